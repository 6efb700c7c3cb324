//! The figures of a report, each a function from plain data to a [`Figure`].
//!
//! Angles are shown in degrees; everything handed over is SI and radians.

pub(crate) mod channels;
mod compared;
mod design;
mod evidence;
mod identification;
mod open_loop;
mod speed;
mod tracking;

pub use channels::{ChannelSignals, OF_CHANNELS, of_channels};
pub use compared::{
    Driven, Simulated, YawStep, models_against_drive, road_and_curvature, tracking, yaw_steps,
};
pub use design::yaw_step;
pub use evidence::{frequency_response, poles_and_zeros, prediction, residuals};
pub use identification::{coherence, comparison, drive, order_table};
pub use open_loop::{OpenLoop, bode, nyquist};
pub use speed::{SpeedResponse, speed_profile, speed_steps};
pub use tracking::{reference_road, road_height, tracking_errors};

use crate::figure::Figure;
use crate::read::Traces;
use steerwright_formats::{Model, Plant};

/// The names of [`of_identification`].
pub const OF_IDENTIFICATION: [&str; 8] = [
    "drive",
    "comparison",
    "coherence",
    "orders",
    "prediction",
    "residuals",
    "frequency-response",
    "poles-and-zeros",
];

/// Every figure of an identified model and its drive: a name for a file, a height in pixels that suits
/// a width of 900, and the figure. Figures without data are omitted.
#[must_use]
pub fn of_identification(
    model: &Model,
    traces: &Traces,
    bicycle_fit: Option<f64>,
) -> Vec<(&'static str, u32, Figure)> {
    let [driven, compared, ..] = OF_IDENTIFICATION;
    let mut all = vec![
        (driven, 600, drive(traces)),
        (compared, 720, comparison(traces, model.fits(), bicycle_fit)),
    ];
    if let Some(plant) = model.plant() {
        all.extend(of_plant(plant));
    }
    all
}

/// The figures of the evidence that only a plant in state space has.
fn of_plant(plant: &Plant) -> Vec<(&'static str, u32, Figure)> {
    let e = &plant.evidence;
    let step = plant.discrete.sample_time_s;
    let [.., coherent, orders, ahead, residual, frequency, poles] = OF_IDENTIFICATION;
    let mut all = Vec::new();
    if !e.excitation.coherence.is_empty() {
        all.push((coherent, 330, coherence(&e.excitation)));
    }
    if !e.order_table.is_empty() {
        all.push((orders, 320, order_table(&e.order_table, plant.order())));
    }
    all.extend(e.held_out.iter().map(|h| (ahead, 280, prediction(h))));
    all.extend(e.residuals.iter().map(|r| (residual, 320, residuals(r, step))));
    let response = |r| (frequency, 760, frequency_response(r, plant.input));
    all.extend(e.frequency_response.iter().map(response));
    all.extend(e.poles_and_zeros.iter().map(|m| (poles, 440, poles_and_zeros(m))));
    all
}

pub(crate) const DEG: f64 = 180.0 / std::f64::consts::PI;

/// A length in m: to 0.1 mm where it is small, since good controllers differ by less than a millimetre.
pub(crate) fn metres(value: f64) -> String {
    text(value, if value.abs() < 0.1 { 4 } else { 3 })
}

/// A number with a proper minus sign.
pub(crate) fn text(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let text = format!("{value:.digits$}");
    let zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
    if zero { text.trim_start_matches('-').into() } else { text.replace('-', "−") }
}
