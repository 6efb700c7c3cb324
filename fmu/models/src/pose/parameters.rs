//! The parameters of the filter.

use crate::Error;
use crate::numbers::as_numbers;
use crate::quadrature::Pose;
use crate::sideslip::Sideslip;
use steerwright_formats::{Estimator, Gnss, InitialUncertainty, Ranged, SensorNoise};

/// Shortest period of fixes, s.
const SHORTEST_PERIOD: f64 = 1e-6;

/// Where the sensors are, how noisy they are, and where the vehicle may be at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseParameters {
    /// The receiver and its antenna.
    pub gnss: Gnss,
    /// The sideslip of the vehicle.
    pub sideslip: Sideslip,
    /// Noise of gyro and speed.
    pub noise: SensorNoise,
    /// The pose at the start.
    pub initial_pose: Pose,
    /// Its uncertainty, and that of the gyro's bias.
    pub initial: InitialUncertainty,
}

as_numbers!(PoseParameters: gnss.latency_s gnss.antenna_x_m gnss.antenna_y_m gnss.std_m gnss.period_s
    sideslip.per_yaw_rate sideslip.growth sideslip.per_yaw_acceleration sideslip.reference_speed
    sideslip.distance_rear
    noise.yaw_rate_density noise.yaw_rate_bias_density noise.speed_density noise.lateral_velocity_density
    noise.sideslip_per_yaw_rate_density
    initial_pose.x initial_pose.y initial_pose.yaw
    initial.position_std_m initial.yaw_std_rad initial.yaw_rate_bias_std_radps
    initial.sideslip_per_yaw_rate_std_s);

impl Default for PoseParameters {
    /// An automotive gyro and wheel speeds; a start known to a metre and six degrees.
    fn default() -> Self {
        Self {
            gnss: Gnss {
                latency_s: 0.0,
                antenna_x_m: 0.0,
                antenna_y_m: 0.0,
                std_m: 0.0,
                period_s: 0.0,
            },
            sideslip: Sideslip::default(),
            noise: SensorNoise {
                yaw_rate_density: 1e-3,
                yaw_rate_bias_density: 5e-5,
                speed_density: 0.05,
                lateral_velocity_density: 0.05,
                sideslip_per_yaw_rate_density: 1e-3,
            },
            initial_pose: Pose::default(),
            initial: InitialUncertainty {
                position_std_m: 1.0,
                yaw_std_rad: 0.1,
                yaw_rate_bias_std_radps: 0.01,
                sideslip_per_yaw_rate_std_s: 0.02,
            },
        }
    }
}

impl PoseParameters {
    /// Checks the ranges of the parameters.
    ///
    /// # Errors
    /// Names the value that is wrong.
    pub fn check(&self) -> Result<(), Error> {
        // None at all, or one whose ends a step can count.
        let (period, longest) = (self.gnss.period_s, Gnss::LONGEST_PERIOD_S);
        if period != 0.0 {
            within(&[("period_s", "the period of the fixes", period, SHORTEST_PERIOD, longest)])?;
        }
        within(&self.gnss.ranges())?;
        let Sideslip { per_yaw_rate, growth, per_yaw_acceleration, reference_speed, distance_rear } =
            self.sideslip;
        let stated = [per_yaw_rate, growth, per_yaw_acceleration, distance_rear];
        within(&Estimator::sideslip_ranges(stated))?;
        within(&self.noise.ranges())?;
        let Pose { x, y, yaw } = self.initial_pose;
        within(&[
            ("speed_mps", "the sideslip's reference speed", reference_speed, 0.0, 1e3),
            ("x", "the initial x", x, f64::MIN, f64::MAX),
            ("y", "the initial y", y, f64::MIN, f64::MAX),
            ("yaw", "the initial yaw", yaw, f64::MIN, f64::MAX),
        ])?;
        within(&self.initial.ranges())
    }
}

/// The values must be in their ranges, which NaN is not.
fn within(ranges: &[Ranged]) -> Result<(), Error> {
    for &(_, name, value, min, max) in ranges {
        if !(min..=max).contains(&value) {
            return Err(Error::Range { name, value, min, max });
        }
    }
    Ok(())
}
