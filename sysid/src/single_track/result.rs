//! From a drive to a single-track model, and what is reported of it.

use crate::Error;
use crate::data::statistics::fit_percent;
use crate::single_track::drive::Drive;
use crate::single_track::dynamics::Constants;
use crate::single_track::estimate::{free_run, solve};
use crate::single_track::options::SingleTrackOptions;
use crate::single_track::parameters::{Parameter, values};
use crate::single_track::prepared::prepare;
use crate::single_track::problem::{Normal, Problem};
use crate::single_track::simulate::simulate;

/// An estimated parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterEstimate {
    /// Which.
    pub parameter: Parameter,
    /// Value in its unit.
    pub value: f64,
}

/// A free simulation compared with the measured signals.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationFit {
    /// `100·(1 − ‖y − ŷ‖/‖y − mean y‖)` of yaw rate.
    pub yaw_rate_fit: f64,
    /// Of lateral acceleration.
    pub lateral_acceleration_fit: Option<f64>,
    /// RMS error of the sideslip angle, rad.
    pub sideslip_rms_error_rad: Option<f64>,
    /// Largest RMS error of yaw rate in a window of 5 s, rad/s.
    pub worst_window_radps: f64,
}

/// An identified single-track model.
#[derive(Debug, Clone, PartialEq)]
pub struct SingleTrack {
    /// All parameters.
    pub parameters: Vec<ParameterEstimate>,
    /// On estimation data.
    pub estimation: SimulationFit,
    point: [f64; crate::single_track::parameters::COUNT],
}

/// Identifies.
///
/// # Errors
/// [`Error`].
pub fn identify_single_track(
    drive: &Drive,
    options: &SingleTrackOptions,
) -> Result<SingleTrack, Error> {
    drive.check()?;
    let has = drive.segments.iter().all(|s| s.lateral_acceleration_mps2.is_some());
    let priors = options.priors(has)?;
    let free = (0..priors.len()).filter(|&i| priors[i].standard_deviation > 0.0).collect();
    let problem = Problem {
        segments: prepare(drive),
        priors: std::array::from_fn(|i| Normal::new(Parameter::ALL[i], &priors[i])),
        free,
        fitted: [true, has, options.fit_lateral_velocity],
    };
    let found = solve(&problem)?;
    let v = values(&found.point);
    let mut track = SingleTrack {
        parameters: Parameter::ALL
            .iter()
            .map(|&parameter| ParameterEstimate { parameter, value: v[parameter.index()] })
            .collect(),
        estimation: SimulationFit {
            yaw_rate_fit: 0.0,
            lateral_acceleration_fit: None,
            sideslip_rms_error_rad: None,
            worst_window_radps: 0.0,
        },
        point: found.point,
    };
    track.estimation = track.simulate(drive);
    let _ = free_run;
    Ok(track)
}

impl SingleTrack {
    /// Free simulation.
    pub fn simulate(&self, drive: &Drive) -> SimulationFit {
        let segments = prepare(drive);
        let k = Constants::new(&self.point);
        let run = crate::single_track::simulate::Run {
            stride: 1,
            longest_step_s: 0.01,
            gain: 0.0,
            restart: 0,
        };
        let (mut y, mut y_hat, mut a, mut a_hat, mut slip) =
            (vec![], vec![], vec![], vec![], vec![]);
        let mut worst: f64 = 0.0;
        for s in &segments {
            let start = y.len();
            simulate(&k, s, &run, |i, o| {
                y.push(s.yaw_rate[i]);
                y_hat.push(o.yaw_rate);
                if let Some(m) = s.lateral_acceleration {
                    a.push(m[i]);
                    a_hat.push(o.lateral_acceleration);
                }
                if let Some(m) = s.lateral_velocity {
                    slip.push(
                        (m[i] / s.speed[i]).atan() - (o.lateral_velocity / s.speed[i]).atan(),
                    );
                }
            });
            let w = (5.0 / s.sample_time).round() as usize;
            let e: Vec<f64> =
                y[start..].iter().zip(&y_hat[start..]).map(|(a, b)| (a - b) * (a - b)).collect();
            for c in e.windows(w).step_by(w / 10) {
                worst = worst.max((c.iter().sum::<f64>() / w as f64).sqrt());
            }
        }
        SimulationFit {
            yaw_rate_fit: fit_percent(&y, &y_hat),
            lateral_acceleration_fit: (!a.is_empty()).then(|| fit_percent(&a, &a_hat)),
            sideslip_rms_error_rad: (!slip.is_empty())
                .then(|| (slip.iter().map(|e| e * e).sum::<f64>() / slip.len() as f64).sqrt()),
            worst_window_radps: worst,
        }
    }
}
