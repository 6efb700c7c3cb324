//! A model with what drives it, its bandwidth, and the limits of what is looked at.

use crate::model::StateSpace;
use std::f64::consts::FRAC_1_SQRT_2;

/// Lags of the residual tests.
pub(crate) const LAGS: usize = 25;
/// Frequencies beyond this have no information about lateral dynamics, Hz.
pub(crate) const HIGHEST_SHOWN: f64 = 10.0;
/// The lowest frequencies, where drift rules, do not end the informative band, Hz.
pub(crate) const DRIFT: f64 = 0.5;
/// Coherence above which at least half of the yaw rate's power follows the steering.
pub(crate) const INFORMATIVE: f64 = 0.5;
/// Where the gain of low frequencies is taken, Hz: above drift, and still quasi-steady.
pub(crate) const LOW_HZ: f64 = 0.2;
/// Frequencies looked at for a decade.
const A_DECADE: f64 = 100.0;

pub(crate) struct Modelled<'a> {
    pub(crate) model: &'a StateSpace,
    /// Its delay from the recorded input to the input of the model, s.
    pub(crate) delay_s: f64,
    /// The recorded input: steering, or steering times speed.
    pub(crate) input: &'a [f64],
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

/// The lowest frequency with a gain 3 dB below that of [`LOW_HZ`], Hz, else `highest_hz`.
pub(crate) fn bandwidth_hz(at: &dyn Fn(f64) -> (f64, f64), highest_hz: f64) -> f64 {
    let gain = |hz: f64| {
        let (re, im) = at(hz);
        re.hypot(im)
    };
    let least = FRAC_1_SQRT_2 * gain(LOW_HZ);
    let points = (A_DECADE * (highest_hz / LOW_HZ).log10()).ceil().max(0.0);
    let frequency = |k: usize| LOW_HZ * 10_f64.powf(k as f64 / A_DECADE);
    (0..points as usize).map(frequency).find(|hz| gain(*hz) < least).unwrap_or(highest_hz)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_has_that_of_its_corner() {
        let at = |hz: f64| {
            let x = hz / 2.0;
            (3.0 / (1.0 + x * x), -3.0 * x / (1.0 + x * x))
        };
        let found = bandwidth_hz(&at, 50.0);
        assert!((found - 2.0).abs() < 0.05, "{found}");
        assert!((bandwidth_hz(&at, 1.0) - 1.0).abs() < 1e-12);
        // A gain that rises again, where nothing was driven, is not part of it.
        let rising = |hz: f64| if hz > 20.0 { (9.0, 0.0) } else { at(hz) };
        assert!((bandwidth_hz(&rising, 50.0) - found).abs() < 1e-12);
    }
}
