//! Simulated drives of known cars up to the limit of grip.
//!
//! The equations are those of the single-track model, written a second time, and integrated by the
//! classical Runge–Kutta method in steps of a millisecond; where stated with tyres that relax. A driver asks
//! for random lateral accelerations, corrects yaw rate, and brakes the less the faster the bend.

use super::Random;
use steerwright_sysid::single_track::{Drive, DriveSegment, Parameter, Scale, SingleTrackModel};

/// How a known car is driven and recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitDrive {
    /// The car.
    pub car: SingleTrackModel,
    /// Relaxation length of the tyres, m, which the model does not have; 0 for tyres that follow at once.
    pub relaxation_m: f64,
    /// Length, s.
    pub duration_s: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Largest lateral acceleration that the driver asks for, over that of the front axle's peak.
    pub grip_used: f64,
    /// Least and largest speed, m/s.
    pub speed_mps: [f64; 2],
    /// Deviation of the sensors' white noise: yaw rate, rad/s; lateral acceleration, m/s²; speed, m/s.
    pub noise: [f64; 3],
    /// Deviation of the lateral acceleration by the road's bank, m/s², which lasts for 3 s.
    pub bank_mps2: f64,
    /// Of all random values.
    pub seed: u64,
}

/// Steps of the integration, s.
const FINE_S: f64 = 1e-3;
const GRAVITY: f64 = 9.81;
/// Time in which the load follows braking and driving, s.
const LOAD_S: f64 = 0.12;

/// A car drawn from the default priors, with the steering ratio as stated and a rear axle that is as a
/// rule the stiffer one, as road cars have it.
#[must_use]
pub fn random_car(random: &mut Random) -> SingleTrackModel {
    let mut car = SingleTrackModel::default();
    for parameter in Parameter::ALL {
        let prior = parameter.default_prior();
        if parameter == Parameter::SteeringFactor {
            continue;
        }
        loop {
            let z = prior.standard_deviation * random.normal();
            let value = match parameter.scale() {
                Scale::Linear => prior.mean + z,
                Scale::Logarithmic => prior.mean * z.exp(),
            };
            if (prior.min..=prior.max).contains(&value) {
                car = car.with(parameter, value);
                break;
            }
        }
    }
    let stiffness = car.get(Parameter::StiffnessFront) * (0.15 + 0.15 * random.normal()).exp();
    car.with(Parameter::StiffnessRear, stiffness)
}

/// A signal in steps of [`FINE_S`] at a time, linear in between.
fn between(signal: &[f64], time: f64) -> f64 {
    let place = (time / FINE_S).max(0.0);
    let i = (place as usize).min(signal.len() - 1);
    let next = signal.get(i + 1).copied().unwrap_or(signal[i]);
    signal[i] + (place - i as f64).min(1.0) * (next - signal[i])
}

impl LimitDrive {
    /// Two minutes at 100 Hz and 12 to 40 m/s.
    #[must_use]
    pub fn new(car: SingleTrackModel, seed: u64) -> Self {
        Self {
            car,
            relaxation_m: 0.0,
            duration_s: 120.0,
            sample_time_s: 0.01,
            grip_used: 0.97,
            speed_mps: [12.0, 40.0],
            noise: [0.003, 0.15, 0.03],
            bank_mps2: 0.0,
            seed,
        }
    }

    /// The recording; `None` where the driver loses the car.
    #[must_use]
    pub fn record(&self) -> Option<Drive> {
        let mut random = Random(self.seed);
        let p = |parameter| self.car.get(parameter);
        let wheelbase = p(Parameter::Wheelbase);
        let samples = (self.duration_s / self.sample_time_s) as usize;
        let per_sample = (self.sample_time_s / FINE_S).round() as usize;
        let peak = self.grip_used * p(Parameter::FrictionFront) * GRAVITY;
        // Axles of different stiffness and the lag of the driver's wish.
        let understeer =
            (1.0 / p(Parameter::StiffnessFront) - 1.0 / p(Parameter::StiffnessRear)) / GRAVITY;
        let (mut wish, mut wished) = (0.0, 0.0);
        let (mut wobble, mut hands, mut fast) = (0.0, 0.0, 0.0);
        let [slow, quick] = self.speed_mps;
        let mut speed = 0.5 * (slow + quick);
        let (mut speed_wish, mut acceleration, mut followed) = (speed, 0.0, 0.0);
        let mut bank = 0.0;
        let mut commands: Vec<f64> = Vec::new();
        let mut command = 0.0;
        let delay = p(Parameter::Delay);
        let mut x = [0.0; 5];
        let mut segment = DriveSegment {
            lateral_acceleration_mps2: Some(Vec::new()),
            lateral_velocity_mps: Some(Vec::new()),
            ..DriveSegment::default()
        };
        // The record begins after the delay.
        let ahead = (delay / FINE_S).ceil() as usize + 2;
        let (mut speeds, mut banks) = (Vec::new(), Vec::new());
        let mut states: Vec<[f64; 5]> = Vec::new();
        let mut outputs: Vec<[f64; 2]> = Vec::new();
        for k in 0..samples * per_sample + 2 * ahead {
            let time = k as f64 * FINE_S;
            if k % 1500 == 0 {
                wish = peak * (2.0 * random.uniform() - 1.0).clamp(-0.9, 0.9) / 0.9;
            }
            if k % 150 == 0 {
                wobble = 0.006 * random.normal();
            }
            if k % 4000 == 0 {
                speed_wish = slow + (quick - slow) * random.uniform();
            }
            // Nobody brakes hard in the middle of a fast bend.
            let left = 1.0 - (wished / peak).powi(2);
            let wanted = left * (0.6 * (speed_wish - speed)).clamp(-4.0, 3.0);
            acceleration += FINE_S / 0.3 * (wanted - acceleration);
            speed += FINE_S * acceleration;
            followed += FINE_S / LOAD_S * (acceleration - followed);
            bank += -FINE_S / 3.0 * bank
                + self.bank_mps2 * (2.0 * FINE_S / 3.0).sqrt() * random.normal();
            let road = [speed, followed, bank];
            wished += FINE_S / 0.25 * (wish - wished);
            hands += FINE_S / 0.05 * (wobble - hands);
            fast += FINE_S / 0.05 * (hands - fast);
            let r_wish = wished / speed;
            let steer = wheelbase * r_wish / speed + understeer * wished + 0.15 * (r_wish - x[1]);
            command += FINE_S / 0.05 * (steer.clamp(-0.35, 0.35) - command);
            commands.push(command + fast);
            speeds.push(speed);
            banks.push(bank);
            let at = |t: f64| between(&commands, t - FINE_S - delay);
            states.push(x);
            let (_, output) = self.rates(&x, at(time), road);
            outputs.push(output);
            let f = |x: &[f64; 5], t: f64| self.rates(x, at(t), road).0;
            let add = |a: &[f64; 5], b: &[f64; 5], h: f64| -> [f64; 5] {
                std::array::from_fn(|i| a[i] + h * b[i])
            };
            let a = f(&x, time);
            let b = f(&add(&x, &a, 0.5 * FINE_S), time + 0.5 * FINE_S);
            let c = f(&add(&x, &b, 0.5 * FINE_S), time + 0.5 * FINE_S);
            let d = f(&add(&x, &c, FINE_S), time + FINE_S);
            for i in 0..5 {
                x[i] += FINE_S / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
            }
            if x[0].abs() > 0.3 * speed {
                return None;
            }
        }
        for k in 0..samples {
            let i = ahead + k * per_sample;
            let [gyro, lateral] = outputs[i];
            let mut noisy = |value: f64, deviation: f64| value + deviation * random.normal();
            segment.steering_rad.push(between(&commands, i as f64 * FINE_S - FINE_S));
            segment.speed_mps.push(noisy(speeds[i], self.noise[2]));
            segment.yaw_rate_radps.push(noisy(gyro, self.noise[0]));
            let push = |signal: &mut Option<Vec<f64>>, value: f64| {
                if let Some(signal) = signal {
                    signal.push(value);
                }
            };
            push(&mut segment.lateral_acceleration_mps2, noisy(lateral, self.noise[1]));
            push(&mut segment.lateral_velocity_mps, states[i][0]);
        }
        Some(Drive {
            sample_time_s: self.sample_time_s,
            steering_ratio: 1.0,
            steering_delay_s: 0.0,
            segments: vec![segment],
        })
    }

    /// Slopes of (v_y, r, α_f, α_r, δ), and yaw rate and lateral acceleration as sensors measure them.
    /// `road`: speed, longitudinal acceleration that the load has followed, and acceleration by the bank.
    fn rates(&self, x: &[f64; 5], command: f64, road: [f64; 3]) -> ([f64; 5], [f64; 2]) {
        let [v, along, bank] = road;
        let p = |parameter| self.car.get(parameter);
        let [vy, r, slip_front, slip_rear, delta] = *x;
        let (share, wheelbase) = (p(Parameter::FrontShare), p(Parameter::Wheelbase));
        let (a, b) = (wheelbase * (1.0 - share), wheelbase * share);
        let axle = |stiffness: f64, friction: f64, load: f64, slip: f64| {
            let peak = friction * load;
            let c_alpha = stiffness * load;
            let (c, e) = (p(Parameter::ShapeFactor), p(Parameter::CurvatureFactor));
            let s = c_alpha / (c * peak) * slip;
            peak * (c * (s - e * (s - s.atan())).atan()).sin()
        };
        let targets = [delta - ((vy + a * r) / v).atan(), -((vy - b * r) / v).atan()];
        let slips = if self.relaxation_m > 0.0 { [slip_front, slip_rear] } else { targets };
        let moved = p(Parameter::HeightRatio) * along;
        // The ellipse of friction with the force that drives or brakes.
        let of_front = p(if along < 0.0 { Parameter::BrakeShare } else { Parameter::DriveShare });
        let left = |force: f64, friction: f64, load: f64| {
            (1.0 - (force / (friction * load)).powi(2)).max(0.1).sqrt()
        };
        let front =
            axle(
                p(Parameter::StiffnessFront),
                p(Parameter::FrictionFront),
                GRAVITY * share - moved,
                slips[0],
            ) * left(of_front * along, p(Parameter::FrictionFront), GRAVITY * share - moved)
                * delta.cos();
        let rear = axle(
            p(Parameter::StiffnessRear),
            p(Parameter::FrictionFront) * p(Parameter::FrictionBalance),
            GRAVITY * (1.0 - share) + moved,
            slips[1],
        ) * left(
            (1.0 - of_front) * along,
            p(Parameter::FrictionFront) * p(Parameter::FrictionBalance),
            GRAVITY * (1.0 - share) + moved,
        );
        let force = front + rear;
        let yaw = (a * front - b * rear) / (p(Parameter::DynamicIndex) * a * b);
        let approach = |axle: usize| {
            if self.relaxation_m > 0.0 {
                v / self.relaxation_m * (targets[axle] - slips[axle])
            } else {
                0.0
            }
        };
        let wheel = p(Parameter::SteeringFactor) * command + p(Parameter::SteeringOffset);
        let slopes = [
            force + bank - v * r,
            yaw,
            approach(0),
            approach(1),
            ((wheel - delta) / p(Parameter::Lag))
                .clamp(-p(Parameter::RateMax), p(Parameter::RateMax)),
        ];
        let gyro = r + p(Parameter::YawRateOffset);
        let lateral = force
            + p(Parameter::AccelerometerPosition) * yaw
            + p(Parameter::LateralAccelerationOffset);
        (slopes, [gyro, lateral])
    }
}
