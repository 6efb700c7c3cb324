//! What there is to state of an identified model, by its structure.

use super::significant;
use super::words::{Facts, not_negative, percent, validation_data, with_error};
use crate::figures::{DEG, text};
use crate::section::Block;
use steerwright_formats::{
    BLOCK_S, Evidence, IdentifiedActuator, InputKind, LEAST_BLOCKS, Mode, MultivariablePlant,
    Plant, ResidualTest,
};

/// The actuator between the steering command and the measured angle.
pub(super) fn actuator_in_words(a: &IdentifiedActuator) -> String {
    let lag =
        not_negative(1e3 * a.time_constant_s, 2e3 * a.time_constant_standard_error_s, 1, " ms");
    let delay = not_negative(1e3 * a.delay_s, 2e3 * a.delay_standard_error_s, 1, " ms");
    let rate = match a.max_rate_radps {
        Some(rate) => format!(", at most {rate:.3} rad/s ({:.1}°/s)", DEG * rate),
        None => String::new(),
    };
    format!(
        "lag {lag}, delay {delay}{rate}, {:.3} times the command; fit {:.1} % of the measured angle",
        a.gain, a.fit
    )
}

pub(super) fn of_plant(plant: &Plant) -> Facts {
    let (e, p) = (&plant.evidence, &plant.operating_point);
    let model = format!(
        "order {}, {} ({}) with {} block rows, sample time {} s",
        plant.order(),
        e.method,
        plant.provenance.options.get("realization").map_or("", String::as_str),
        e.horizon,
        plant.discrete.sample_time_s
    );
    let input = match plant.input {
        InputKind::Steering => "steering angle",
        InputKind::SteeringTimesSpeed => "steering angle times speed",
    };
    let input = format!(
        "{input}, with a delay of {:.3} s; at {:.2} m/s, steering ratio {}",
        plant.input_delay_s,
        p.speed_mps,
        significant(plant.steering_ratio)
    );
    let offsets = format!(
        "{}° of the steering angle, {}°/s of the yaw rate",
        text(DEG * p.steering_offset_rad, 3),
        text(DEG * p.yaw_rate_offset_radps, 3)
    );
    let mut facts = vec![
        Block::fact("model", model),
        Block::fact("input", input),
        Block::fact("offsets", offsets),
        Block::fact("data", samples(e.estimation_samples, e.validation_samples)),
    ];
    if let Some(d) = &e.delay {
        let taken = if d.taken { "taken" } else { "not taken: lags explain the log as well" };
        facts.push(Block::fact(
            "delay",
            match d.standard_error_s {
                Some(e) => {
                    format!("{}, {taken}", not_negative(1e3 * d.estimate_s, 2e3 * e, 0, " ms"))
                }
                None => "none taken: this log does not determine it".into(),
            },
        ));
    }
    facts.extend(validation(e));
    facts
}

fn samples(estimation: usize, validation: usize) -> String {
    format!("{estimation} samples of estimation data, {validation} of validation data")
}

/// Fits, tests, and what the log shows of the model.
fn validation(e: &Evidence) -> Facts {
    let is_validated = e.validation_samples > 0;
    let fit_text = |fit: f64| if is_validated { percent(fit) } else { "–".into() };
    let fit = match e.held_out.as_ref().filter(|_| is_validated) {
        Some(h) => with_error(e.fit.validation, h.fit_standard_error, h.without_standard_error()),
        None => fit_text(e.fit.validation),
    };
    let mut facts = vec![Block::fact(
        "fit",
        format!(
            "{fit} simulated on validation data, {} one step ahead, {} on estimation data",
            fit_text(e.fit.validation_one_step),
            percent(e.fit.estimation)
        ),
    )];
    if let Some(held_out) = &e.held_out {
        let ahead = held_out.predictions.iter().filter_map(|p| {
            let seconds = p.ahead_s.filter(|_| p.steps > Some(1))?;
            Some(format!("{seconds} s {}", percent(p.fit)))
        });
        let ahead: Vec<String> = ahead.collect();
        let of_variance = format!(
            "the simulation accounts for {} of the variance",
            percent(held_out.variance_accounted_for)
        );
        facts.push(Block::fact(
            "predicted",
            match ahead.is_empty() {
                true => of_variance,
                false => format!("ahead by {}; {of_variance}", ahead.join(", ")),
            },
        ));
        facts.push(Block::fact("validated on", validation_data(held_out)));
    }
    let test = |name: &str, t: &ResidualTest| match (t.lags, t.pass) {
        (0, _) => format!("{name} not tested"),
        (_, true) => format!("{name} passed {}", statistic(t)),
        (_, false) => format!("{name} failed {}", statistic(t)),
    };
    let found = |t: &ResidualTest| if t.pass { "none" } else { "found" };
    let mut tests =
        vec![test("whiteness", &e.whiteness), test("independence of input", &e.independence)];
    if let Some(residuals) = &e.residuals {
        let t = &residuals.feedback;
        let name = "dependence of the input on past residuals";
        tests.push(format!("{name} {} {}", found(t), statistic(t)));
    }
    let tests = format!("of the residuals on validation data: {}", tests.join(", "));
    facts.push(Block::fact("tests", tests));
    if let Some(t) = e.feedback.as_ref().filter(|t| t.lags > 0) {
        let text = format!(
            "{} in the estimation data {}, which selects among the methods",
            found(t),
            statistic(t)
        );
        facts.push(Block::fact("feedback", text));
    }
    if let Some(response) = e.frequency_response.as_ref().filter(|r| r.compared > 0) {
        let text = format!(
            "model within the {:.0} % confidence of the measured one at {:.0} % of {} frequencies",
            100.0 * response.confidence,
            100.0 * response.within,
            response.compared
        );
        facts.push(Block::fact("response", text));
    }
    if let Some(map) = &e.poles_and_zeros {
        let modes: Vec<String> = map.poles.iter().filter_map(mode).collect();
        facts.push(Block::fact("modes", modes.join(", ")));
    }
    facts
}

/// A test's statistic with its bound.
fn statistic(t: &ResidualTest) -> String {
    format!("({:.1} over {} lags, bound {:.1})", t.statistic, t.lags, t.bound)
}

/// A pole: its time constant, or frequency and damping.
fn mode(pole: &Mode) -> Option<String> {
    let (hz, damping) = (pole.natural_frequency_hz?, pole.damping?);
    if pole.discrete[1] != 0.0 {
        return Some(format!("{hz:.2} Hz (damping {damping:.2})"));
    }
    Some(match pole.time_constant_s {
        Some(t) => format!("{t:.3} s"),
        None => "integrator".into(),
    })
}

pub(super) fn of_channels(plant: &MultivariablePlant) -> Facts {
    let (e, step) = (&plant.evidence, plant.discrete.sample_time_s);
    let has_feedthrough = plant.discrete.d.0.iter().flatten().any(|d| *d != 0.0);
    let model = format!(
        "order {}, {} ({}) with {} block rows, sample time {step} s, {} feedthrough",
        plant.order(),
        e.method,
        plant.provenance.options.get("realization").map_or("", String::as_str),
        e.horizon,
        if has_feedthrough { "with" } else { "without" }
    );
    let mut facts = vec![Block::fact("model", model)];
    for input in plant.inputs.iter().filter(|input| input.delay_s > 0.0) {
        let samples = (input.delay_s / step).round();
        let text = format!(
            "{} s of {}, {samples} samples beyond the one of every model",
            input.delay_s, input.name
        );
        facts.push(Block::fact("delay", text));
    }
    let seconds = |samples: usize| (1e6 * samples as f64 * step).round() / 1e6;
    let data = format!(
        "{} samples ({} s) of estimation data, {} samples ({} s) of validation data",
        e.estimation_samples,
        seconds(e.estimation_samples),
        e.validation_samples,
        seconds(e.validation_samples)
    );
    facts.push(Block::fact("data", data));
    for output in &e.outputs {
        let without =
            format!("too few blocks of {BLOCK_S} s or 20 samples: {LEAST_BLOCKS} are needed");
        let text = format!(
            "{}: {} simulated on validation data, {} one step ahead, {} on estimation data",
            output.output,
            with_error(output.fit.validation, output.fit_standard_error, without),
            percent(output.fit.validation_one_step),
            percent(output.fit.estimation)
        );
        facts.push(Block::fact("fit", text));
    }
    for output in &e.outputs {
        let failed: Vec<&str> = e
            .pairs
            .iter()
            .filter(|pair| pair.output == output.output && !pair.independence.pass)
            .map(|pair| pair.input.as_str())
            .collect();
        let inputs = match failed.is_empty() {
            true => "independent of all inputs".into(),
            false => format!("dependent on {}", failed.join(", ")),
        };
        let white = if output.whiteness.pass { "passed" } else { "failed" };
        let text = format!("{}: white: {white}, {inputs} (tests at 99 %)", output.output);
        facts.push(Block::fact("residual", text));
    }
    facts
}
