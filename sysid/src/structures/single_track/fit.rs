//! The free simulation compared with the measured signals.

use crate::Error;
use crate::data::statistics::fit_percent;
use crate::structures::single_track::drive::{Drive, DriveSegment};
use crate::structures::single_track::model::{SimulatedSegment, SingleTrackModel};
use crate::validation::residuals::fit::fit_with_error;
use steerwright_formats::SimulationFit;

/// Fit of a simulation that left all bounds, percent: nothing of the drive is reproduced.
const LOST: f64 = -100.0;
/// Worst window of a simulation that left all bounds, rad/s.
const LOST_WINDOW: f64 = 1e3;
/// The window of [`SimulationFit::worst_window_radps`], s.
const WINDOW_S: f64 = 5.0;
/// Below this speed sideslip angles are not compared, m/s.
const LEAST_SPEED: f64 = 3.0;

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
            // The maximum is also that of no number.
            Some(fit_percent(&y, &y_hat).max(LOST))
        };
        let slips: Option<Vec<[f64; 2]>> = pairs
            .iter()
            .map(|(m, s)| sideslip(m, s))
            .collect::<Option<Vec<_>>>()
            .map(|s| s.concat());
        let rms = |of: fn(&[f64; 2]) -> f64| {
            let slips = slips.as_ref().filter(|s| !s.is_empty())?;
            let mean = slips.iter().map(|s| of(s).powi(2)).sum::<f64>() / slips.len() as f64;
            Some(mean.sqrt()).filter(|rms| rms.is_finite())
        };
        let yaw_rate_pairs: Vec<(&[f64], &[f64])> = pairs
            .iter()
            .map(|(m, s)| (m.yaw_rate_radps.as_slice(), s.yaw_rate_radps.as_slice()))
            .collect();
        let with_error = fit_with_error(&yaw_rate_pairs, drive.sample_time_s);
        Ok(SimulationFit {
            yaw_rate_standard_error: with_error.standard_error,
            blocks: with_error.blocks,
            yaw_rate: fit(|m, s| Some([m.yaw_rate_radps.clone(), s.yaw_rate_radps.clone()]))
                .unwrap_or(LOST),
            lateral_acceleration: fit(|m, s| {
                let measured = m.lateral_acceleration_mps2.clone()?;
                Some([measured, s.lateral_acceleration_mps2.clone()])
            }),
            sideslip_rms_error_rad: rms(|[a, b]| a - b),
            sideslip_rms_rad: rms(|[a, _]| *a),
            worst_window_radps: pairs
                .iter()
                .map(|(m, s)| worst_window(m, s, drive.sample_time_s))
                .map(|w| if w.is_finite() { w } else { LOST_WINDOW })
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
    squares.windows(n).step_by(n.div_ceil(10)).map(mean).fold(0.0, larger).sqrt()
}

/// The larger one; what is no number is larger than all.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}
