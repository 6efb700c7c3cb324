//! A drive with its true pose, and the readings of its sensors.

use steerwright_formats::{Gnss, InitialUncertainty, SensorNoise};
use steerwright_models::noise::gaussian;
use steerwright_models::quadrature::Pose;
use steerwright_models::{PoseEstimator, PoseInput, PoseParameters, Sideslip};

pub(crate) const H: f64 = 0.01;

/// A car at 15 m/s on a winding road, its sensors and their noise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drive {
    pub(crate) seed: i32,
    pub(crate) parameters: PoseParameters,
    pub(crate) gnss_std: f64,
    /// Whether readings are as noisy as the filter assumes.
    pub(crate) noise: bool,
}

#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Truth {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) yaw: f64,
    pub(crate) bias: f64,
    /// What is added to the sideslip per yaw rate.
    pub(crate) sideslip: f64,
}

/// Sensor readings at a communication point, and the true pose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    pub(crate) input: PoseInput,
    pub(crate) truth: Truth,
}

pub(crate) const DRIVE: Drive = Drive {
    seed: 1,
    parameters: PoseParameters {
        gnss: Gnss {
            latency_s: 0.1,
            period_s: 0.0,
            antenna_x_m: 0.7,
            antenna_y_m: 0.3,
            std_m: 0.0,
        },
        sideslip: Sideslip {
            per_yaw_rate: -0.06,
            growth: -0.001,
            per_yaw_acceleration: 0.005,
            reference_speed: 0.0,
            distance_rear: 0.0,
        },
        noise: SensorNoise {
            yaw_rate_density: 1e-3,
            yaw_rate_bias_density: 5e-5,
            speed_density: 0.05,
            lateral_velocity_density: 0.05,
            sideslip_per_yaw_rate_density: 1e-3,
        },
        initial_pose: Pose { x: 0.0, y: 0.0, yaw: 0.0 },
        initial: InitialUncertainty {
            position_std_m: 1.0,
            yaw_std_rad: 0.1,
            yaw_rate_bias_std_radps: 0.01,
            sideslip_per_yaw_rate_std_s: 0.02,
        },
    },
    gnss_std: 0.02,
    noise: true,
};

impl Drive {
    /// The moments after each of `steps` steps; a fix every ten steps, of the antenna as it was
    /// `lag` steps before.
    pub(crate) fn moments(&self, steps: usize, lag: usize) -> Vec<Moment> {
        let p = &self.parameters;
        let mut drawn = 0_u64;
        let mut draw = |std: f64| {
            drawn += 1;
            if self.noise { std * gaussian(self.seed, drawn) } else { 0.0 }
        };
        let mut truth = Truth {
            x: p.initial_pose.x + draw(p.initial.position_std_m),
            y: p.initial_pose.y + draw(p.initial.position_std_m),
            yaw: p.initial_pose.yaw + draw(p.initial.yaw_std_rad),
            bias: draw(p.initial.yaw_rate_bias_std_radps),
            sideslip: draw(p.initial.sideslip_per_yaw_rate_std_s),
        };
        let white = 1.0 / H.sqrt();
        let rate_at = |t: f64| 0.25 * (0.6 * t).sin() + 0.1 * (1.7 * t).cos();
        let speed_at = |t: f64| 15.0 + (0.3 * t).sin();
        let mut truths = vec![truth];
        let mut moments = Vec::new();
        let mut input = PoseInput { gnss_std: self.gnss_std, ..PoseInput::default() };
        for k in 1..=steps {
            let end = k as f64 * H;
            // Trapezia, as the filter joins the readings.
            let rate = 0.5 * (rate_at(end - H) + rate_at(end));
            let speed = 0.5 * (speed_at(end - H) + speed_at(end));
            let Sideslip { per_yaw_rate: s, growth: q, per_yaw_acceleration: c, .. } = p.sideslip;
            let turning = (rate_at(end) - rate_at(end - H)) / H;
            let slip = (s + truth.sideslip + q * (speed * rate).powi(2)) * rate + c * turning;
            let across = slip * speed + draw(p.noise.lateral_velocity_density * white);
            let middle = truth.yaw + 0.5 * rate * H;
            truth.x += H * (speed * middle.cos() - across * middle.sin());
            truth.y += H * (speed * middle.sin() + across * middle.cos());
            truth.yaw += rate * H;
            truth.bias += draw(p.noise.yaw_rate_bias_density * H.sqrt());
            truth.sideslip += draw(p.noise.sideslip_per_yaw_rate_density * H.sqrt());
            truths.push(truth);
            input.yaw_rate = rate_at(end) + truth.bias + draw(p.noise.yaw_rate_density * white);
            input.speed = speed_at(end) + draw(p.noise.speed_density * white);
            if k % 10 == 0 && k >= lag {
                let Truth { x, y, yaw, .. } = truths[k - lag];
                let (sin, cos) = yaw.sin_cos();
                input.gnss_x =
                    x + p.gnss.antenna_x_m * cos - p.gnss.antenna_y_m * sin + draw(self.gnss_std);
                input.gnss_y =
                    y + p.gnss.antenna_x_m * sin + p.gnss.antenna_y_m * cos + draw(self.gnss_std);
                input.gnss_fix_count += 1;
            }
            moments.push(Moment { input, truth });
        }
        moments
    }

    pub(crate) fn estimator(&self) -> PoseEstimator {
        let mut estimator = PoseEstimator::new(self.parameters).unwrap();
        estimator.start().unwrap();
        estimator
    }
}
