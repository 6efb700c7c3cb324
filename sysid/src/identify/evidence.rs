//! Residual tests, excitation, and the judgement in plain words.

use super::IdentifyOptions;
use crate::DriveLog;
use crate::signal::{coherence, standard_deviation};
use formats::{CoherencePoint, Evidence, Excitation, InputKind, Verdict};

/// Lags of the residual tests.
pub(crate) const LAGS: usize = 25;
/// Coherence above which at least half of the yaw rate's power follows the steering.
const INFORMATIVE: f64 = 0.5;
/// Frequencies beyond this say nothing about lateral dynamics, Hz.
const HIGHEST_SHOWN: f64 = 10.0;
/// The lowest frequencies, where drift rules, do not end the informative band, Hz.
const DRIFT: f64 = 0.5;

/// What the whole log can say.
pub(crate) fn excitation(log: &DriveLog, input: &[f64], noise_to_signal: f64) -> Excitation {
    let c = coherence(input, &log.output, log.sample_time_s);
    // Three neighbouring frequencies together, since a single estimate scatters.
    let smooth = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(c.coherence.len() - 1));
        c.coherence[a..=b].iter().sum::<f64>() / (b - a + 1) as f64
    };
    let threshold = INFORMATIVE.max(c.significance);
    let mut informative_up_to_hz = 0.0;
    for i in 0..c.coherence.len() {
        if smooth(i) >= threshold {
            informative_up_to_hz = c.frequency_hz[i];
        } else if informative_up_to_hz > 0.0 || c.frequency_hz[i] > DRIFT {
            break;
        }
    }
    Excitation {
        road_wheel_std_rad: standard_deviation(&log.input) / log.steering_ratio,
        yaw_rate_std_radps: standard_deviation(&log.output),
        noise_to_signal,
        informative_up_to_hz,
        coherence: c
            .frequency_hz
            .iter()
            .zip(&c.coherence)
            .filter(|(f, _)| **f <= HIGHEST_SHOWN)
            .map(|(f, c)| CoherencePoint { frequency_hz: *f, coherence: *c })
            .collect(),
    }
}

/// Judges by what matters for steering: does the log say enough, does the model simulate data it
/// has not seen, and can it be converted.
pub(crate) fn verdict(
    evidence: &Evidence,
    has_continuous: bool,
    speed_spread: f64,
    options: &IdentifyOptions,
) -> Verdict {
    /// Below, the steering hardly moves the vehicle: a fifth of a degree at the road wheel.
    const LEAST_STEERING: f64 = 0.0035;
    /// The band that a yaw controller with a settling time of a second needs, Hz.
    const LEAST_BAND: f64 = 0.8;
    const GOOD_FIT: f64 = 60.0;
    const LARGEST_NOISE: f64 = 0.5;
    let e = &evidence.excitation;
    let fit = evidence.fit.validation;
    let mut reasons = Vec::new();
    let mut advice = Vec::new();
    let degrees = e.road_wheel_std_rad.to_degrees();
    if e.road_wheel_std_rad < LEAST_STEERING {
        reasons.push(format!("the road wheel moves by {degrees:.2}° (standard deviation) only"));
    }
    if e.informative_up_to_hz < LEAST_BAND {
        reasons.push(format!(
            "yaw rate follows the steering (coherence above {INFORMATIVE}) up to {:.1} Hz only",
            e.informative_up_to_hz
        ));
    }
    let weak = !reasons.is_empty();
    if weak {
        advice.push(
            "drive a slalom with sweeping rhythm, 0.2 to 2 Hz, about ±20° at the steering wheel, for 60 s at steady speed"
                .to_owned(),
        );
    }
    if e.noise_to_signal > LARGEST_NOISE {
        reasons.push(format!("noise is {:.0} % of the yaw rate", 100.0 * e.noise_to_signal));
        advice.push("steer more strongly, or use a less noisy gyro".to_owned());
    }
    if fit < GOOD_FIT {
        reasons.push(format!("the model reproduces held-out data to {fit:.0} % only"));
        advice.push(
            "check the mapping, signs and clocks of the channels; a delay between clocks or a changing speed spoils the fit"
                .to_owned(),
        );
    }
    if !has_continuous {
        reasons.push("the model has no continuous counterpart".to_owned());
        advice.push("try another --order or --sample-time".to_owned());
    }
    if speed_spread > 0.2 {
        let other = match options.input_kind {
            InputKind::Steering => ", or identify with the input steering*speed",
            InputKind::SteeringTimesSpeed => "",
        };
        let percent = 100.0 * speed_spread;
        advice.push(format!("speed varies by {percent:.0} % (standard deviation): hold it{other}"));
    }
    if !evidence.independence.pass {
        advice.push(
            "held-out residuals still depend on past steering: expect effects that a linear model of this order leaves out"
                .to_owned(),
        );
    }
    let trustworthy = reasons.is_empty();
    let summary = if trustworthy {
        // Said where it flatters: a model that is refused has nothing to gain from it.
        let also = options
            .chosen_by_validation()
            .map(|what| format!(" (the part that also chose {what})"))
            .unwrap_or_default();
        format!(
            "The model reproduces held-out yaw rate{also} to {fit:.1} %, and the log informs up to {:.1} Hz: fit to design on.",
            e.informative_up_to_hz
        )
    } else if weak {
        format!("Weakly excited: {}. Do not design on this model.", reasons.join("; "))
    } else {
        format!("Not to be trusted: {}.", reasons.join("; "))
    };
    Verdict { trustworthy, summary, advice }
}
