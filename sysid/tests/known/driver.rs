//! A vehicle with a driver in the loop, and what is recorded of it.

use super::Random;
use faer::Mat;
use steerwright_sysid::model::riccati::kalman_filter;
use steerwright_sysid::{DataSet, Error, StateSpace};

/// Sample time of the recordings, s.
pub const SAMPLE_TIME_S: f64 = 0.05;

/// What moves the vehicle and where the noise comes in.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Standard deviation of the white process noise on the lateral velocity, m/s a sample, and on
    /// the yaw rate, rad/s a sample.
    pub process: [f64; 2],
    /// Standard deviation of the noise on the measured yaw rate, rad/s.
    pub output_noise: f64,
    /// Standard deviation of the noise on the measured steering angle, rad.
    pub input_noise: f64,
    /// Driver's gain from yaw rate to steering angle, s; 0 opens the loop.
    pub gain: f64,
    /// Whether the driver (a controller then) acts on the measured yaw rate, noise included, or on the
    /// true one.
    pub acts_on_measurement: bool,
    /// What the driver wants besides.
    pub excitation: Excitation,
}

/// The external part of the steering angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Excitation {
    /// Noise through a low-pass of 1 Hz.
    Noise,
    /// Twelve sines from 0.2 to 6 Hz with random phases, as a steering robot drives them.
    Sines,
}

impl Drive {
    /// Everything the driver or controller acts on is recorded: what the predictor's methods assume.
    #[must_use]
    pub fn controlled() -> Self {
        Self {
            process: [0.02, 0.02],
            output_noise: 0.03,
            input_noise: 0.0,
            gain: 0.09,
            acts_on_measurement: true,
            excitation: Excitation::Noise,
        }
    }

    /// The driver feels the true yaw rate, and both recordings have white sensor noise.
    #[must_use]
    pub fn white_sensors() -> Self {
        Self {
            process: [0.0, 0.0],
            output_noise: 0.03,
            input_noise: 0.01,
            gain: 0.06,
            acts_on_measurement: false,
            excitation: Excitation::Sines,
        }
    }

    /// The vehicle from steering angle to yaw rate: lateral velocity, yaw rate, road wheel behind an
    /// actuator lag of 0.06 s, at 30 m/s, sampled with the input held.
    #[must_use]
    pub fn vehicle() -> StateSpace {
        let (mass, inertia, front, rear, cf, cr, v, lag) =
            (1500.0, 2500.0, 1.2, 1.5, 8e4, 9e4, 30.0, 0.06);
        let f = [
            [-(cf + cr) / (mass * v), (rear * cr - front * cf) / (mass * v) - v, cf / mass],
            [
                (rear * cr - front * cf) / (inertia * v),
                -(front * front * cf + rear * rear * cr) / (inertia * v),
                front * cf / inertia,
            ],
            [0.0, 0.0, -1.0 / lag],
        ];
        // exp of [F G; 0 0]·T by its series, halved eight times.
        let steps = 256.0;
        let step = Mat::from_fn(4, 4, |i, j| match (i, j) {
            (3, _) => 0.0,
            (2, 3) => SAMPLE_TIME_S / (lag * steps),
            (_, 3) => 0.0,
            _ => f[i][j] * SAMPLE_TIME_S / steps,
        });
        let mut power: Mat<f64> = Mat::identity(4, 4);
        let mut exponential = power.clone();
        for k in 1..12 {
            power = Mat::from_fn(4, 4, |i, j| (&power * &step)[(i, j)] / f64::from(k));
            exponential += &power;
        }
        for _ in 0..8 {
            exponential = &exponential * &exponential;
        }
        StateSpace {
            a: exponential.get(..3, ..3).to_owned(),
            b: exponential.get(..3, 3..).to_owned(),
            c: Mat::from_fn(1, 3, |_, j| if j == 1 { 1.0 } else { 0.0 }),
            d: Mat::zeros(1, 1),
        }
    }

    /// Largest pole modulus of the predictor A − K C: how fast the past is forgotten.
    #[must_use]
    pub fn predictor_radius(&self) -> Option<f64> {
        let vehicle = Self::vehicle();
        let q =
            Mat::from_fn(3, 3, |i, j| if i == j && i < 2 { self.process[i].powi(2) } else { 0.0 });
        let r = Mat::from_fn(1, 1, |_, _| self.output_noise.powi(2));
        let s = Mat::zeros(3, 1);
        let (a, c) = (vehicle.a.as_ref(), vehicle.c.as_ref());
        let filter = kalman_filter(a, c, q.as_ref(), r.as_ref(), s.as_ref())?;
        let closed = &vehicle.a - &filter.gain * &vehicle.c;
        Some(StateSpace { a: closed, ..vehicle }.spectral_radius())
    }

    /// Records `count` samples after the loop has settled.
    ///
    /// # Errors
    /// [`Error::Data`] where the loop is unstable and the numbers leave the representable.
    pub fn record(&self, count: usize, seed: u64) -> Result<DataSet, Error> {
        const SETTLE: usize = 300;
        // Delay of 0.2 s; lead 0.3 s over lag 0.1 s, held.
        const DELAY: usize = 4;
        let (lead, pole) = (0.3 / 0.1, (-SAMPLE_TIME_S / 0.1_f64).exp());
        let vehicle = Self::vehicle();
        let mut random = Random(seed);
        let sines: Vec<[f64; 2]> = (0..12)
            .map(|k| {
                let hz = 0.2 + 5.8 * f64::from(k) / 11.0;
                [
                    std::f64::consts::TAU * hz * SAMPLE_TIME_S,
                    std::f64::consts::TAU * random.uniform(),
                ]
            })
            .collect();
        let smooth = (-std::f64::consts::TAU * SAMPLE_TIME_S).exp();
        let mut x = [0.0; 3];
        let (mut want, mut lagged) = (0.0, 0.0);
        let mut heard = [0.0; DELAY];
        let (mut u, mut y) = (Mat::zeros(1, count), Mat::zeros(1, count));
        for t in 0..SETTLE + count {
            let yaw_rate = x[1];
            let measured = yaw_rate + self.output_noise * random.normal();
            let late = heard[t % DELAY];
            heard[t % DELAY] = if self.acts_on_measurement { measured } else { yaw_rate };
            let reaction = lagged + lead * (late - lagged);
            lagged = pole * lagged + (1.0 - pole) * late;
            let excitation = random.normal();
            want = match self.excitation {
                Excitation::Noise => {
                    smooth * want + (1.0 - smooth * smooth).sqrt() * 0.03 * excitation
                }
                Excitation::Sines => {
                    0.02 * sines.iter().map(|[w, p]| (w * t as f64 + p).sin()).sum::<f64>()
                }
            };
            let steering = want - self.gain * reaction;
            let sensed = steering + self.input_noise * random.normal();
            if t >= SETTLE {
                u[(0, t - SETTLE)] = sensed;
                y[(0, t - SETTLE)] = measured;
            }
            let noise = [self.process[0] * random.normal(), self.process[1] * random.normal(), 0.0];
            let before = x;
            for i in 0..3 {
                x[i] = vehicle.b[(i, 0)] * steering + noise[i];
                for (j, z) in before.iter().enumerate() {
                    x[i] += vehicle.a[(i, j)] * z;
                }
            }
        }
        DataSet::single(SAMPLE_TIME_S, u, y)
    }
}
