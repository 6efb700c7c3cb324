//! A model with what drives it, and the limits of what is looked at.

use crate::model::StateSpace;

/// Lags of the residual tests.
pub(crate) const LAGS: usize = 25;
/// Frequencies beyond this have no information about lateral dynamics, Hz.
pub(crate) const HIGHEST_SHOWN: f64 = 10.0;
/// The lowest frequencies, where drift rules, do not end the informative band, Hz.
pub(crate) const DRIFT: f64 = 0.5;
/// Coherence above which at least half of the yaw rate's power follows the steering.
pub(crate) const INFORMATIVE: f64 = 0.5;

/// A model with what drives it.
pub(crate) struct Modelled<'a> {
    /// The model in SI units.
    pub(crate) model: &'a StateSpace,
    /// Its delay from the recorded input to the input of the model, s.
    pub(crate) delay_s: f64,
    /// The recorded input: steering, or steering times speed.
    pub(crate) input: &'a [f64],
    /// What the model makes of it, rad/s.
    pub(crate) simulated: &'a [f64],
    /// Factor from the input to the angle at the road wheel, rad.
    pub(crate) to_road_wheel: f64,
}

/// Six significant digits: what is plotted needs no more, and the file stays readable.
pub(crate) fn rounded(x: f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return 0.0;
    }
    format!("{x:.5e}").parse().unwrap_or(x)
}
