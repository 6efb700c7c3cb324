//! What a manoeuvre is designed for, within which limits.

use crate::Error;
use crate::structures::single_track::vehicle::ROAD_WHEEL_LIMITS;
use steerwright_formats::{Bicycle, ManoeuvreGoal, ManoeuvreLimits, Vehicle};

/// Straight driving after the signal of a block, s.
pub(super) const REST_S: f64 = 2.0;
/// Shortest block, s.
const SHORTEST_BLOCK_S: f64 = 8.0;
/// Frequencies of a band at which the response is to be known.
const FREQUENCIES: usize = 9;

/// An understeer gradient of 1 deg/g, rad·s²/m.
const RADIANS_PER_DEGREE_PER_G: f64 = std::f64::consts::PI / 180.0 / 9.80665;

/// What is to be designed.
#[derive(Debug, Clone, PartialEq)]
pub struct ExcitationOptions {
    /// The quantity whose standard error is minimised.
    pub goal: ManoeuvreGoal,
    /// Speeds, m/s.
    pub speeds_mps: Vec<f64>,
    /// Time of the recording, s.
    pub time_s: f64,
    /// Length of a block, s.
    pub block_s: f64,
    /// Band in which the response is to be known, Hz; of other goals that of the steering.
    pub band_hz: [f64; 2],
    /// Two standard errors of the goal that are to be reached, in its unit.
    pub max_error: Option<f64>,
    /// Limits.
    pub limits: ManoeuvreLimits,
    /// Spectral density of the errors of the yaw rate, (rad/s)²/Hz, two-sided: a variance times its sample time and, where the
    /// errors last, over the long run.
    pub noise_density: f64,
    /// Time from one sample of the signals to the next, s.
    pub sample_time_s: f64,
    /// Whether a driver steers, to a metronome, instead of a robot.
    pub by_driver: bool,
    /// Standard deviation of each axle's cornering stiffness, and of the friction where the tyre limit is the goal, relative, of
    /// a model that states no uncertainty; the limits leave room for it.
    pub assumed_uncertainty: f64,
}

impl Default for ExcitationOptions {
    /// 0.2 to 2 Hz, two minutes at 15 m/s and 3 m/s², and a gyro of 0.1 °/s at 100 Hz.
    fn default() -> Self {
        Self {
            goal: ManoeuvreGoal::Response,
            speeds_mps: vec![15.0],
            time_s: 120.0,
            block_s: 20.0,
            band_hz: [0.2, 2.0],
            max_error: None,
            limits: ManoeuvreLimits {
                max_lateral_acceleration_mps2: 3.0,
                max_angle_rad: None,
                max_rate_radps: None,
                max_offset_m: None,
            },
            noise_density: 0.1_f64.to_radians().powi(2) * 0.01,
            sample_time_s: 0.01,
            by_driver: false,
            assumed_uncertainty: 0.1,
        }
    }
}

impl ExcitationOptions {
    pub(super) fn check(&self) -> Result<(), Error> {
        let within = |option, value: f64, [low, high]: [f64; 2], unit: &str| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                let expected = format!("{low} to {high}{unit}");
                Err(Error::option(option, format!("{value}{unit}"), expected))
            }
        };
        if self.speeds_mps.is_empty() || self.speeds_mps.len() > 5 {
            let got = self.speeds_mps.len();
            return Err(Error::option("number of speeds", got, "1 to 5"));
        }
        for speed in &self.speeds_mps {
            within("speed", *speed, [1.0, 100.0], " m/s")?;
        }
        within("block", self.block_s, [SHORTEST_BLOCK_S, 60.0], " s")?;
        let least = 2.0 * self.block_s * self.speeds_mps.len() as f64;
        within("time", self.time_s, [least, 3600.0], " s")?;
        let [low, high] = self.band_hz;
        let least_hz = 2.0 / (self.block_s - REST_S);
        within("band", low, [least_hz, 5.0], " Hz")?;
        within("band", high, [(1.2 * low).min(5.0), 5.0], " Hz")?;
        within("sample time", self.sample_time_s, [0.001, 0.1 / high], " s")?;
        if let Some(error) = self.max_error {
            match self.goal {
                ManoeuvreGoal::Response => {
                    within("response error", 100.0 * error, [0.1, 100.0], " %")?;
                }
                ManoeuvreGoal::Understeer => {
                    let degrees_per_g = error / RADIANS_PER_DEGREE_PER_G;
                    within("understeer error", degrees_per_g, [1e-3, 100.0], " deg/g")?;
                }
                ManoeuvreGoal::TyreLimit => {
                    within("friction error", 100.0 * error, [0.1, 100.0], " %")?;
                }
            }
        }
        let limits = &self.limits;
        within(
            "max lateral acceleration",
            limits.max_lateral_acceleration_mps2,
            [0.1, 50.0],
            " m/s²",
        )?;
        let positive = [
            ("max angle", limits.max_angle_rad, " rad"),
            ("max rate", limits.max_rate_radps, " rad/s"),
            ("road width", limits.max_offset_m, " m"),
        ];
        for (option, limit, unit) in positive {
            within(option, limit.unwrap_or(1.0), [1e-3, 1e3], unit)?;
        }
        within("uncertainty", 100.0 * self.assumed_uncertainty, [0.0, 50.0], " %")?;
        within("noise", self.noise_density.sqrt(), [1e-9, 1.0], " (rad/s)/√Hz")
    }

    /// Signal without the straight driving after it, s.
    pub(super) fn signal_s(&self) -> f64 {
        self.block_s - REST_S
    }

    /// Blocks of each half at each speed.
    pub(super) fn repeats(&self) -> usize {
        let blocks = (self.time_s / self.block_s + 1e-9).floor() as usize;
        (blocks / (2 * self.speeds_mps.len())).max(1)
    }

    pub(super) fn frequencies_hz(&self) -> Vec<f64> {
        let [low, high] = self.band_hz;
        let at = |i: usize| low * (high / low).powf(i as f64 / (FREQUENCIES - 1) as f64);
        (0..FREQUENCIES).map(at).collect()
    }
}

/// The options with the largest rate that a bicycle knows of its actuator.
pub(super) fn within_rate(bicycle: &Bicycle, options: &ExcitationOptions) -> ExcitationOptions {
    let mut options = options.clone();
    if let Some((rate, _)) = bicycle.largest_rate() {
        let own = rate * bicycle.vehicle.steering_ratio;
        let stated = options.limits.max_rate_radps.unwrap_or(f64::INFINITY);
        options.limits.max_rate_radps = Some(stated.min(own));
    }
    options
}

/// The options with the limits of a vehicle's actuator, beyond which the road wheels do not follow; the model has none.
pub(super) fn within_actuator(vehicle: &Vehicle, options: &ExcitationOptions) -> ExcitationOptions {
    let actuator = &vehicle.actuator;
    let mut options = options.clone();
    let [rate, angle] = [
        (actuator.road_wheel_rate_max_radps, ROAD_WHEEL_LIMITS[0]),
        (actuator.road_wheel_angle_max_rad, ROAD_WHEEL_LIMITS[1]),
    ]
    // Those of an identified vehicle are beyond any drive.
    .map(
        |(own, unknown)| {
            if own < unknown { own * actuator.steering_ratio } else { f64::INFINITY }
        },
    );
    for (limit, own) in
        [(&mut options.limits.max_rate_radps, rate), (&mut options.limits.max_angle_rad, angle)]
    {
        let least = limit.unwrap_or(f64::INFINITY).min(own);
        *limit = if least.is_finite() { Some(least) } else { None };
    }
    options
}
