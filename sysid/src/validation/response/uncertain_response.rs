//! Whether a model's response is known well enough for a pass, by the stated standard errors of its gain and phase at
//! the frequencies at which a yaw controller works. The rule is the same for every structure.

use crate::validation::response::bands::inside;
use std::f64::consts::{PI, TAU};
use steerwright_formats::{ExcitationBand, Grade, Reason, ReasonCode, Uncertainty};

/// From a lane change to the crossover of a fast yaw loop, Hz.
const FREQUENCIES_HZ: [f64; 3] = [0.3, 1.0, HIGHEST_HZ];
pub(crate) const HIGHEST_HZ: f64 = 2.0;
/// Largest relative standard error of the gain.
pub(crate) const LARGEST_GAIN_ERROR: f64 = 0.1;
/// Largest standard error of the phase, 15°: two of them are half of a phase margin of 60°.
const LARGEST_PHASE_ERROR_RAD: f64 = PI / 12.0;

/// The standard errors of a response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ResponseError {
    pub(crate) frequency_hz: f64,
    /// Of the gain, relative.
    pub(crate) gain: f64,
    /// Of the phase.
    pub(crate) phase_rad: f64,
    /// By which the phase is wrong where the steering, held or not, was read the other way; 0 where that is known.
    pub(crate) open_phase_rad: f64,
}

impl ResponseError {
    /// At the frequencies that count, where `errors` returns those of gain and phase, if they are stated.
    pub(crate) fn all(mut errors: impl FnMut(f64) -> Option<[f64; 2]>) -> Vec<Self> {
        let at = |frequency_hz: f64| {
            let [gain, phase_rad] = errors(frequency_hz).unwrap_or([f64::INFINITY; 2]);
            Self { frequency_hz, gain, phase_rad, open_phase_rad: 0.0 }
        };
        FREQUENCIES_HZ.map(at).to_vec()
    }

    /// Of a state-space model; of the measured response where the model's uncertainty is not stated.
    pub(crate) fn of_plant(
        uncertainty: Option<&Uncertainty>,
        bands: &[ExcitationBand],
    ) -> Vec<Self> {
        Self::all(|hz| match uncertainty {
            Some(uncertainty) => uncertainty.errors_at(hz),
            None => {
                let band = bands.iter().find(|b| inside(&[b.from_hz, b.to_hz], hz))?;
                Some([band.relative_error; 2])
            }
        })
    }
}

/// The standard errors of a response with a steering that may be held over `period_s` instead, or move on instead.
pub(crate) fn with_half_a_period(errors: &[ResponseError], period_s: f64) -> Vec<ResponseError> {
    let open = |e: &ResponseError| ResponseError {
        open_phase_rad: 0.5 * TAU * e.frequency_hz * period_s,
        ..*e
    };
    errors.iter().map(open).collect()
}

/// The reasons for which the response is too uncertain for a pass.
pub(crate) fn uncertain_response(errors: &[ResponseError]) -> Vec<Reason> {
    let worst = |of: fn(&ResponseError) -> f64| {
        errors.iter().max_by(|a, b| of(a).total_cmp(&of(b))).map(|e| (of(e), e.frequency_hz))
    };
    let mut reasons = Vec::new();
    if let Some((error, hz)) = worst(|e| e.gain)
        && (error.is_nan() || error > LARGEST_GAIN_ERROR)
    {
        let (percent, limit) = (100.0 * error, 100.0 * LARGEST_GAIN_ERROR);
        let message = if error < 1.0 {
            format!(
                "the standard error of the gain at {hz} Hz is {percent:.0} %, above {limit:.0} %"
            )
        } else {
            format!("the data do not determine the gain at {hz} Hz")
        };
        let reason = Reason::new(ReasonCode::UncertainGain, Grade::Warn, message);
        reasons.push(reason.compared(percent, limit, "%"));
    }
    // The phase is that of one reading: the other is no standard error, but wrong by all of it.
    let open = errors.iter().map(|e| e.open_phase_rad).fold(0.0, f64::max);
    if let Some((error, hz)) = worst(|e| e.phase_rad + e.open_phase_rad)
        && (error.is_nan() || error > LARGEST_PHASE_ERROR_RAD)
    {
        let (degrees, limit) = (error.to_degrees(), LARGEST_PHASE_ERROR_RAD.to_degrees());
        let message = if error < 1.0 && open > 0.0 {
            format!(
                "the phase at {hz} Hz may be wrong by {degrees:.0}°, above {limit:.0}°: it is open whether the steering is held between its samples"
            )
        } else if error < 1.0 {
            format!(
                "the standard error of the phase at {hz} Hz is {degrees:.0}°, above {limit:.0}°"
            )
        } else {
            format!("the data do not determine the phase at {hz} Hz")
        };
        let reason = Reason::new(ReasonCode::UncertainPhase, Grade::Warn, message);
        reasons.push(reason.compared(degrees, limit, "deg"));
    }
    reasons
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(errors: [[f64; 2]; 3]) -> Vec<ReasonCode> {
        let mut next = errors.into_iter();
        let errors = ResponseError::all(|_| next.next());
        uncertain_response(&errors).into_iter().map(|reason| reason.code).collect()
    }

    #[test]
    fn the_worst_frequency_counts() {
        let known = [0.02, 0.05];
        assert_eq!(codes([known, known, known]), []);
        assert_eq!(codes([known, known, [0.11, 0.05]]), [ReasonCode::UncertainGain]);
        assert_eq!(codes([known, [0.02, 0.27], known]), [ReasonCode::UncertainPhase]);
        let both = [ReasonCode::UncertainGain, ReasonCode::UncertainPhase];
        assert_eq!(codes([known, known, [f64::NAN, f64::NAN]]), both);
        assert_eq!(uncertain_response(&ResponseError::all(|_| None)).len(), 2);
    }

    #[test]
    fn a_hold_that_is_open_counts_whole() {
        let known = ResponseError::all(|_| Some([0.02, 0.02]));
        let of = |period_s| uncertain_response(&with_half_a_period(&known, period_s));
        assert_eq!(of(0.02), []);
        // Half a period of 0.05 s is 18° at 2 Hz.
        let [reason] = &of(0.05)[..] else { panic!() };
        assert_eq!(reason.code, ReasonCode::UncertainPhase);
        assert!(reason.message.starts_with("the phase at 2 Hz may be wrong by 19°, above 15°: "));
    }

    #[test]
    fn the_reason_states_number_limit_and_frequency() {
        let errors = ResponseError::all(|hz| Some([0.07 * hz, 0.0]));
        let reason = uncertain_response(&errors).remove(0);
        assert_eq!(reason.message, "the standard error of the gain at 2 Hz is 14 %, above 10 %");
        assert!((reason.value.unwrap() - 14.0).abs() < 1e-9 && reason.limit == Some(10.0));
    }
}
