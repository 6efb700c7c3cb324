//! The quality of a plant of several channels, by rules of any system.

use steerwright_formats::{
    Grade, MultivariableEvidence, OutputEvidence, PairEvidence, Quality, Reason, ReasonCode,
};

/// Simulation fit below which the inputs explain little of an output, percent.
const LEAST_FIT: f64 = 30.0;
/// Standard error of a gain at rest over the gain from which it is uncertain; of gains that matter.
const UNCERTAIN_GAIN: f64 = 0.5;
/// A gain that matters moves the output by this share of its standard deviation for one of the input's.
const GAIN_THAT_MATTERS: f64 = 0.2;
/// Statistic over bound from which residuals depend on the past input clearly.
const CLEARLY: f64 = 2.0;

/// The quality by the fits on validation data, the residuals and the uncertainty.
pub(super) fn quality(
    e: &MultivariableEvidence,
    has_continuous: bool,
    deviations: [&[f64]; 2],
) -> Quality {
    let mut reasons = Vec::new();
    for output in &e.outputs {
        reasons.extend(low_fit(output));
    }
    if e.outputs.iter().all(|o| o.fit_standard_error.is_none()) {
        let message = "the validation data are too short for standard errors of the fits";
        reasons.push(Reason::new(ReasonCode::ShortValidation, Grade::Warn, message));
    }
    let [inputs, outputs] = deviations;
    let gains = e.pairs.iter().enumerate().filter_map(|(place, pair)| {
        let per_unit = outputs[place / inputs.len()] / inputs[place % inputs.len()];
        Some((pair, uncertain_gain(pair, per_unit)?))
    });
    reasons.extend(worst(gains.collect()).map(|(pair, share, others)| {
        let message = format!(
            "the gain at rest from {} to {} has a standard error of {:.0} %{others}",
            pair.input,
            pair.output,
            100.0 * share
        );
        let reason = Reason::new(ReasonCode::UncertainGain, Grade::Warn, message);
        reason.compared(100.0 * share, 100.0 * UNCERTAIN_GAIN, "%")
    }));
    let tests = e.pairs.iter().filter_map(|pair| {
        let share = pair.independence.statistic / pair.independence.bound;
        if share > CLEARLY { Some((pair, share)) } else { None }
    });
    reasons.extend(worst(tests.collect()).map(|(pair, _, others)| {
        let message = format!(
            "past values of {} explain a part of the prediction errors of {}{others}: the model lacks dynamics of \
             this pair",
            pair.input, pair.output
        );
        let reason = Reason::new(ReasonCode::ModelError, Grade::Warn, message);
        reason.compared(pair.independence.statistic, pair.independence.bound, "")
    }));
    for output in e.outputs.iter().filter(|o| !o.coherence.is_empty()) {
        if output.coherence.iter().all(|point| point.coherence < output.coherence_of_chance) {
            let message = format!(
                "at no frequency do the inputs explain more of {} than chance does",
                output.output
            );
            reasons.push(Reason::new(ReasonCode::NarrowBand, Grade::Warn, message));
        }
    }
    let fits: Vec<String> = e
        .outputs
        .iter()
        .map(|o| {
            let error = o.fit_standard_error.map(|error| format!(" ± {:.1}", 2.0 * error));
            format!("{} {:.1}{} %", o.output, o.fit.validation, error.unwrap_or_default())
        })
        .collect();
    let summary = format!("The fits on validation data are {}.", fits.join(", "));
    let advice = match reasons.is_empty() {
        true => Vec::new(),
        false => vec![
            "record longer, with inputs that move independently of each other at the frequencies of interest; leave \
             out inputs that cause nothing, and name those that are missing"
                .into(),
        ],
    };
    let mut remarks = Vec::new();
    if !has_continuous {
        remarks
            .push("The model has no continuous form: it is valid at its sample time only.".into());
    }
    if e.feedback.is_some_and(|test| !test.pass) {
        remarks.push("The data show feedback from outputs to inputs.".into());
    }
    Quality::new(summary, reasons, advice).with_remarks(remarks)
}

fn low_fit(output: &OutputEvidence) -> Option<Reason> {
    let (name, fit) = (&output.output, output.fit.validation);
    let (grade, limit, message) = if fit < 0.0 {
        let message = format!(
            "the simulation of {name} on validation data is worse than its mean: fit {fit:.1} %"
        );
        (Grade::Fail, 0.0, message)
    } else if fit < LEAST_FIT {
        let message =
            format!("the fit of {name} on validation data is {fit:.1} %, below {LEAST_FIT} %");
        (Grade::Warn, LEAST_FIT, message)
    } else {
        return None;
    };
    let reason = Reason::new(ReasonCode::LowValidationFit, grade, message);
    Some(reason.compared(fit, limit, "%"))
}

/// The pair with the largest number, and in words how many others there are.
fn worst(pairs: Vec<(&PairEvidence, f64)>) -> Option<(&PairEvidence, f64, String)> {
    let others = match pairs.len() {
        0 | 1 => String::new(),
        2 => " (and another pair)".into(),
        count => format!(" (and {} other pairs)", count - 1),
    };
    let largest = pairs.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((largest.0, largest.1, others))
}

/// Standard error over the gain at rest, of a gain that matters and is not determined; `per_unit` is the output's standard
/// deviation over the input's.
fn uncertain_gain(pair: &PairEvidence, per_unit: f64) -> Option<f64> {
    let gain = pair.steady_state_gain?;
    let share = gain.standard_error / gain.value.abs();
    let matters = gain.value.abs().max(gain.standard_error) > GAIN_THAT_MATTERS * per_unit;
    // A gain of 0 has no finite share.
    if matters && share > UNCERTAIN_GAIN { Some(share.min(1e6)) } else { None }
}
