//! Drives of [linear cars](LinearCar).
//!
//! The car is integrated in steps of 2 ms (Runge–Kutta of order 4, the steering angle a straight line
//! within a step), so that its response is right to 1e-6. The logger is described by
//! [`LinearDrive`]: rate, quantisation, play, gusts, noise.

use crate::Random;
use crate::linear_car::LinearCar;
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Step of the integration, s.
const STEP_S: f64 = 0.002;
/// Steering-wheel angle over road-wheel angle.
const STEERING_RATIO: f64 = 16.0;
/// Delay of a driver's reaction, s.
const REACTION_S: f64 = 0.2;

/// What the driver wants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    /// A winding road: noise through a low-pass of second order at 0.4 Hz, and a lane change every few
    /// seconds.
    Road,
    /// Logarithmic sweeps from 0.1 to 3 Hz and back.
    Sweep,
    /// Steps of random size, each held for an interval, behind a lag of first order.
    HeldSteps {
        /// From one step to the next, s.
        interval_s: f64,
        /// Time constant of the lag, s.
        lag_s: f64,
    },
}

/// What the log has of the steering.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Steering {
    /// Samples of an angle that moves on between them.
    Measured,
    /// A command that is held from row to row.
    Command,
    /// The same in a column with the name of an angle.
    HeldAngle,
}

impl Steering {
    fn is_held(self) -> bool {
        self != Self::Measured
    }
}

/// One drive and how it is logged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearDrive {
    /// The car.
    pub car: LinearCar,
    /// Duration, s.
    pub seconds: f64,
    /// Rows of the log in a second; divides 500.
    pub rate_hz: f64,
    /// Mean speed, m/s.
    pub speed_mps: f64,
    /// Standard deviation of the speed, share of the mean.
    pub speed_spread: f64,
    /// What the driver wants.
    pub course: Course,
    /// Root mean square of the lateral acceleration that is wanted, m/s².
    pub acceleration_mps2: f64,
    /// Whether the driver also steers against the yaw rate, 0.2 s late.
    pub driver: bool,
    /// Root mean square of the yaw rate that gusts make, rad/s.
    pub gust_radps: f64,
    /// Standard deviation of the gyro's noise, rad/s.
    pub gyro_noise_radps: f64,
    /// Quantum of the recorded angle at the steering wheel, degrees.
    pub quantum_deg: f64,
    /// Play between steering wheel and road wheel, degrees at the steering wheel.
    pub lash_deg: f64,
    /// What is logged of the steering.
    pub steering: Steering,
    /// Seed of course, gusts and noise.
    pub seed: u64,
}

impl LinearDrive {
    /// As on the road: a speed of 12 to 30 m/s that varies by 3 %, gusts, quantisation and play of 0.1°,
    /// 100 Hz, 120 s.
    pub fn realistic(car: LinearCar, random: &mut Random) -> Self {
        Self {
            car,
            seconds: 120.0,
            rate_hz: 100.0,
            speed_mps: 12.0 + 18.0 * random.uniform(),
            speed_spread: 0.03,
            course: Course::Road,
            acceleration_mps2: 1.0 + random.uniform(),
            driver: random.uniform() < 0.5,
            gust_radps: 0.004 + 0.004 * random.uniform(),
            gyro_noise_radps: 0.003,
            quantum_deg: 0.1,
            lash_deg: 0.1,
            steering: Steering::Measured,
            seed: (random.uniform() * 2f64.powi(53)) as u64,
        }
    }

    /// White gyro noise and nothing else that disturbs.
    pub fn ideal(car: LinearCar, random: &mut Random) -> Self {
        let all = Self::realistic(car, random);
        Self { speed_spread: 0.0, gust_radps: 0.0, quantum_deg: 0.0, lash_deg: 0.0, ..all }
    }

    /// As a steering robot drives: sweeps in open loop, white gyro noise.
    pub fn clean_sweep(car: LinearCar, random: &mut Random) -> Self {
        let all = Self::ideal(car, random);
        Self { course: Course::Sweep, driver: false, ..all }
    }

    /// As a controller that decides a few times a second steers a robot: steps behind a lag, of which the angle is measured
    /// at any rate. Each second drive has steps at rows of a log at 10 Hz.
    pub fn held_steps(car: LinearCar, random: &mut Random) -> Self {
        let all = Self::ideal(car, random);
        let interval_s = 0.2 + 0.5 * random.uniform();
        let is_at_rows = random.uniform() < 0.5;
        let interval_s = if is_at_rows { (10.0 * interval_s).round() / 10.0 } else { interval_s };
        let lag_s = 0.1 + 0.15 * random.uniform();
        let course = Course::HeldSteps { interval_s, lag_s };
        Self { course, driver: false, gyro_noise_radps: 0.002, ..all }
    }

    /// As a simulator logs: a command held over each row, no noise, no driver.
    pub fn noise_free(car: LinearCar, random: &mut Random) -> Self {
        let all = Self::ideal(car, random);
        Self { gyro_noise_radps: 0.0, driver: false, steering: Steering::Command, ..all }
    }

    /// Drives.
    #[must_use]
    pub fn record(&self) -> LinearLog {
        let mut random = Random(self.seed);
        let wish = Wish::new(self, &mut random);
        self.along(&wish, &mut random)
    }

    fn along(&self, wish: &Wish, random: &mut Random) -> LinearLog {
        let steps_a_row = (1.0 / (self.rate_hz * STEP_S)).round() as usize;
        let mut gusts = Gusts::new(self);
        let mut speed = self.speed_mps;
        let degree = (1.0 / STEERING_RATIO).to_radians();
        let mut x = [0.0; 3];
        let mut heard = VecDeque::from(vec![0.0; (REACTION_S / STEP_S).round() as usize]);
        let against =
            if self.driver { 0.35 / self.car.steady_state_gain(self.speed_mps) } else { 0.0 };
        let mut felt = 0.0;
        let mut wheel = wish.at(0.0);
        let mut road_wheel = wheel;
        let mut log = LinearLog {
            drive: *self,
            time: Vec::new(),
            steering: Vec::new(),
            yaw_rate: Vec::new(),
            speed: Vec::new(),
        };
        for k in 0..(self.seconds / STEP_S).round() as usize {
            let t = k as f64 * STEP_S;
            if k % steps_a_row == 0 {
                if self.steering.is_held() {
                    wheel = wish.at(t) - against * felt;
                }
                let quantum = self.quantum_deg * degree;
                let seen = if quantum > 0.0 { (wheel / quantum).round() * quantum } else { wheel };
                log.time.push(t);
                log.steering.push(seen);
                log.yaw_rate.push(x[1] + self.gyro_noise_radps * random.normal());
                log.speed.push(speed);
            }
            // Half a second's correlation of the speed's deviation.
            let keep = (-STEP_S / 2.0_f64).exp();
            speed = self.speed_mps
                + keep * (speed - self.speed_mps)
                + self.speed_mps * self.speed_spread * (1.0 - keep * keep).sqrt() * random.normal();
            let gust = gusts.next(random);
            heard.push_back(x[1]);
            let late = heard.pop_front().unwrap_or_default();
            felt += STEP_S / 0.1 * (late - felt);
            let next = match self.steering {
                Steering::Measured => wish.at(t + STEP_S) - against * felt,
                Steering::Command | Steering::HeldAngle => wheel,
            };
            let play = 0.5 * self.lash_deg * degree;
            let before = road_wheel;
            let after = f64::clamp(before, next - play, next + play);
            let before = if self.lash_deg > 0.0 { before } else { wheel };
            let at = |share: f64| before + share * (after - before);
            let slope = |x: [f64; 3], share: f64| self.car.slope(speed, x, at(share), gust);
            let moved = |k: [f64; 3], h: f64| [x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2]];
            let k1 = slope(x, 0.0);
            let k2 = slope(moved(k1, 0.5 * STEP_S), 0.5);
            let k3 = slope(moved(k2, 0.5 * STEP_S), 0.5);
            let k4 = slope(moved(k3, STEP_S), 1.0);
            for i in 0..3 {
                x[i] += STEP_S / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
            (road_wheel, wheel) = (after, next);
        }
        log
    }
}

/// The angle that is wanted, at the road wheel.
struct Wish {
    /// Sines as angle, circular frequency and phase: a stationary random course that can be read at any
    /// instant.
    sines: Vec<[f64; 3]>,
    /// Instant, duration and angle of each lane change.
    changes: Vec<[f64; 3]>,
    sweep: Option<(f64, f64)>,
    steps: Option<LaggedSteps>,
}

/// Steps behind a lag of first order.
struct LaggedSteps {
    interval_s: f64,
    lag_s: f64,
    /// Angle at the start of each interval, and the angle that it goes to.
    intervals: Vec<[f64; 2]>,
}

impl LaggedSteps {
    fn new(seconds: f64, [interval_s, lag_s]: [f64; 2], rms: f64, random: &mut Random) -> Self {
        let keep = (-interval_s / lag_s).exp();
        let mut intervals = vec![[0.0, rms * random.normal()]];
        for _ in 0..(seconds / interval_s).ceil() as usize {
            let [from, to] = intervals[intervals.len() - 1];
            intervals.push([to + keep * (from - to), rms * random.normal()]);
        }
        Self { interval_s, lag_s, intervals }
    }

    fn at(&self, t: f64) -> f64 {
        // A step at t is seen at t, whatever the rounding.
        let last = self.intervals.len() - 1;
        let k = ((t / self.interval_s + 1e-9).floor() as usize).min(last);
        let [from, to] = self.intervals[k];
        to + (-(t - k as f64 * self.interval_s) / self.lag_s).exp() * (from - to)
    }
}

impl Wish {
    fn new(drive: &LinearDrive, random: &mut Random) -> Self {
        const SINES: usize = 120;
        let rms = drive.acceleration_mps2
            / (drive.speed_mps * drive.car.steady_state_gain(drive.speed_mps));
        if drive.course == Course::Sweep {
            return Self {
                sines: vec![],
                changes: vec![],
                sweep: Some((drive.seconds, 1.4 * rms)),
                steps: None,
            };
        }
        if let Course::HeldSteps { interval_s, lag_s } = drive.course {
            let steps = LaggedSteps::new(drive.seconds, [interval_s, lag_s], rms, random);
            return Self { sines: vec![], changes: vec![], sweep: None, steps: Some(steps) };
        }
        let mut sines: Vec<[f64; 3]> = (0..SINES)
            .map(|_| {
                let hz = 0.02 * (3.0_f64 / 0.02).powf(random.uniform());
                // Density of noise behind a low-pass of second order, drawn over log frequency.
                let size = (hz / (1.0 + (hz / 0.4).powi(4))).sqrt();
                [size, TAU * hz, TAU * random.uniform()]
            })
            .collect();
        let power: f64 = sines.iter().map(|s| 0.5 * s[0] * s[0]).sum();
        sines.iter_mut().for_each(|s| s[0] *= rms / power.sqrt());
        let mut changes = Vec::new();
        let mut t = 4.0 * random.uniform();
        while t < drive.seconds {
            let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
            changes.push([t, 1.5 + 1.5 * random.uniform(), sign * rms]);
            t += 4.0 + 8.0 * random.uniform();
        }
        Self { sines, changes, sweep: None, steps: None }
    }

    fn at(&self, t: f64) -> f64 {
        if let Some((seconds, size)) = self.sweep {
            // 0.1 to 3 Hz in the first half, back in the second.
            let (half, ratio) = (0.5 * seconds, 30.0_f64);
            let part = |t: f64| TAU * 0.1 * half / ratio.ln() * (ratio.powf(t / half) - 1.0);
            return if t < half {
                size * part(t).sin()
            } else {
                size * (2.0 * part(half) - part(seconds - t)).sin()
            };
        }
        if let Some(steps) = &self.steps {
            return steps.at(t);
        }
        let course: f64 = self.sines.iter().map(|[a, w, p]| a * (w * t + p).sin()).sum();
        let change = |[from, lasting, size]: &[f64; 3]| {
            let share = (t - from) / lasting;
            if (0.0..1.0).contains(&share) { size * (TAU * share).sin() } else { 0.0 }
        };
        course + self.changes.iter().map(change).sum::<f64>()
    }
}

/// Lateral force and yaw moment of side wind, as accelerations: noise with a correlation of 0.4 s.
struct Gusts {
    state: f64,
    size: f64,
    /// m/s² of lateral velocity for each rad/s² of yaw rate.
    lateral: f64,
}

impl Gusts {
    const LASTING_S: f64 = 0.4;

    fn new(drive: &LinearDrive) -> Self {
        // A moment that lasts changes the yaw rate by its response in a steady turn.
        let (f, _) = drive.car.lateral(drive.speed_mps);
        let lateral = 5.0;
        let determinant = f[0][0] * f[1][1] - f[0][1] * f[1][0];
        let steady = ((f[1][0] * lateral - f[0][0]) / determinant).abs();
        Self { state: 0.0, size: drive.gust_radps / steady, lateral }
    }

    fn next(&mut self, random: &mut Random) -> [f64; 2] {
        let keep = (-STEP_S / Self::LASTING_S).exp();
        self.state = keep * self.state + (1.0 - keep * keep).sqrt() * random.normal();
        let moment = self.size * self.state;
        [self.lateral * moment, moment]
    }
}

/// What was logged.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearLog {
    /// The drive.
    pub drive: LinearDrive,
    /// Instants, s.
    pub time: Vec<f64>,
    /// Road-wheel angle or command, rad.
    pub steering: Vec<f64>,
    /// Yaw rate, rad/s.
    pub yaw_rate: Vec<f64>,
    /// Speed, m/s.
    pub speed: Vec<f64>,
}

impl LinearLog {
    /// As a logger writes it.
    #[must_use]
    pub fn csv(&self) -> String {
        let steering = match self.drive.steering {
            Steering::Measured | Steering::HeldAngle => "roadwheel_angle_rad",
            Steering::Command => "roadwheel_command_rad",
        };
        let mut text = format!("time_s,{steering},yaw_rate_radps,speed_mps\n");
        for k in 0..self.time.len() {
            let (t, u, y, v) = (self.time[k], self.steering[k], self.yaw_rate[k], self.speed[k]);
            let _ = writeln!(text, "{t:.3},{u:.12},{y:.12},{v:.4}");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(steering: Steering) -> LinearDrive {
        let mut random = Random(3);
        let car = LinearCar::random(&mut random);
        let noise_free = LinearDrive::noise_free(car, &mut random);
        LinearDrive { steering, seconds: 40.0, ..noise_free }
    }

    /// A sine of 1 Hz comes out with the gain and phase of [`LinearCar::response`].
    #[test]
    fn the_simulated_response_is_the_stated_one() {
        for servo_s in [0.0, 0.08] {
            let mut drive = drive(Steering::Measured);
            drive.car.servo_s = servo_s;
            let (hz, size) = (1.0, 0.02);
            let sine = vec![[size, TAU * hz, 0.0]];
            let wish = Wish { sines: sine, changes: Vec::new(), sweep: None, steps: None };
            let log = drive.along(&wish, &mut Random(1));
            // The last ten seconds, which are whole periods.
            let last = log.time.iter().zip(&log.yaw_rate).skip(3000);
            let along = |f: fn(f64) -> f64| -> f64 {
                last.clone().map(|(t, y)| y * f(TAU * hz * t)).sum::<f64>() / 500.0
            };
            let (re, im) = drive.car.response(drive.speed_mps, hz);
            // The wheel moves along straight lines from step to step, whose sine is smaller.
            let lines = 1.0 - (TAU * hz * STEP_S).powi(2) / 12.0;
            assert!((along(f64::sin) / size - lines * re).abs() < 1e-6 * re.abs(), "{servo_s}");
            assert!((along(f64::cos) / size - lines * im).abs() < 1e-6 * re.abs(), "{servo_s}");
        }
    }

    /// Samples of a command are those of the car with the input held.
    #[test]
    fn a_command_is_held() {
        let drive = drive(Steering::Command);
        let log = drive.record();
        let (f, g) = drive.car.lateral(drive.speed_mps);
        let f = faer::Mat::from_fn(2, 2, |i, j| f[i][j]);
        let g = faer::Mat::from_fn(2, 1, |i, _| g[i]);
        let (a, b) = steerwright_sysid::model::conversion::discretize(f.as_ref(), g.as_ref(), 0.01);
        let mut x = [0.0; 2];
        for (u, y) in log.steering.iter().zip(&log.yaw_rate) {
            assert!((x[1] - y).abs() < 1e-9, "{} {y}", x[1]);
            x = [0, 1].map(|i| a[(i, 0)] * x[0] + a[(i, 1)] * x[1] + b[(i, 0)] * u);
        }
    }
}
