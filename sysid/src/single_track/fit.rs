//! The free simulation compared with the measured signals.

use crate::Error;
use crate::data::statistics::fit_percent;
use crate::single_track::drive::{Drive, DriveSegment};
use crate::single_track::model::{SimulatedSegment, SingleTrackModel};

/// The window of [`SimulationFit::worst_window_radps`], s.
const WINDOW_S: f64 = 5.0;
/// Below this speed sideslip angles are not compared, m/s.
const LEAST_SPEED: f64 = 3.0;

/// A free simulation compared with the measured signals. Fits are `100·(1 − ‖y − ŷ‖/‖y − mean y‖)` in
/// percent over all segments, −∞ where the simulation leaves all bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationFit {
    /// Fit of yaw rate, %.
    pub yaw_rate: f64,
    /// Fit of lateral acceleration, %, where it is measured.
    pub lateral_acceleration: Option<f64>,
    /// RMS error of the sideslip angle, rad, above 3 m/s, where lateral velocity is measured.
    pub sideslip_rms_error_rad: Option<f64>,
    /// RMS of the measured sideslip angle likewise, rad.
    pub sideslip_rms_rad: Option<f64>,
    /// Largest RMS error of yaw rate in a window of 5 s, rad/s.
    pub worst_window_radps: f64,
}

impl SingleTrackModel {
    /// Validates the free simulation on a drive.
    ///
    /// # Errors
    /// Those of [`Drive::check`].
    pub fn validate(&self, drive: &Drive) -> Result<SimulationFit, Error> {
        let simulated = self.simulate(drive)?;
        let pairs: Vec<_> = drive.segments.iter().zip(&simulated).collect();
        let fit = |signals: fn(&DriveSegment, &SimulatedSegment) -> Option<[Vec<f64>; 2]>| {
            let (mut y, mut y_hat) = (Vec::new(), Vec::new());
            for (measured, simulated) in &pairs {
                let [a, b] = signals(measured, simulated)?;
                y.extend(a);
                y_hat.extend(b);
            }
            Some(fit_percent(&y, &y_hat))
        };
        let slips: Option<Vec<[f64; 2]>> = pairs
            .iter()
            .map(|(m, s)| sideslip(m, s))
            .collect::<Option<Vec<_>>>()
            .map(|s| s.concat());
        let rms = |of: fn(&[f64; 2]) -> f64| {
            let slips = slips.as_ref().filter(|s| !s.is_empty())?;
            Some((slips.iter().map(|s| of(s).powi(2)).sum::<f64>() / slips.len() as f64).sqrt())
        };
        Ok(SimulationFit {
            yaw_rate: fit(|m, s| Some([m.yaw_rate_radps.clone(), s.yaw_rate_radps.clone()]))
                .unwrap_or(f64::NEG_INFINITY),
            lateral_acceleration: fit(|m, s| {
                let measured = m.lateral_acceleration_mps2.clone()?;
                Some([measured, s.lateral_acceleration_mps2.clone()])
            }),
            sideslip_rms_error_rad: rms(|[a, b]| a - b),
            sideslip_rms_rad: rms(|[a, _]| *a),
            worst_window_radps: pairs
                .iter()
                .map(|(m, s)| worst_window(m, s, drive.sample_time_s))
                .fold(0.0, f64::max),
        })
    }
}

/// Measured and simulated sideslip angles, rad, where the vehicle moves.
fn sideslip(measured: &DriveSegment, simulated: &SimulatedSegment) -> Option<Vec<[f64; 2]>> {
    let vy = measured.lateral_velocity_mps.as_ref()?;
    let both = vy.iter().zip(&simulated.lateral_velocity_mps).zip(&measured.speed_mps);
    let moving = both.filter(|(_, v)| **v > LEAST_SPEED);
    Some(moving.map(|((a, b), v)| [a.atan2(*v), b.atan2(*v)]).collect())
}

/// Largest RMS error of yaw rate in a window, or over a segment that is shorter.
fn worst_window(measured: &DriveSegment, simulated: &SimulatedSegment, sample_time: f64) -> f64 {
    let square = |(a, b): (&f64, &f64)| (a - b) * (a - b);
    let squares: Vec<f64> =
        measured.yaw_rate_radps.iter().zip(&simulated.yaw_rate_radps).map(square).collect();
    let n = ((WINDOW_S / sample_time).round() as usize).clamp(1, squares.len().max(1));
    let mean = |w: &[f64]| w.iter().sum::<f64>() / n as f64;
    // A tenth of a window apart.
    squares.windows(n).step_by(n.div_ceil(10)).map(mean).fold(0.0, f64::max).sqrt()
}
