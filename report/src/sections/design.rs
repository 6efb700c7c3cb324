//! The bicycle model and the controllers with their proof.

use super::{met, optional, significant, value};
use crate::figures::{self, DEG};
use crate::html::{Block, Section, Tone};
use crate::report::Controller;
use crate::table::Table;
use steerwright_formats::{Bicycle, Engagement, Grade, Pid, Shortfall, StepMetrics};

/// Vehicle data and coefficients of eq 13.
pub(crate) fn bicycle(bicycle: &Bicycle, fit: Option<f64>) -> Section {
    let (v, c) = (&bicycle.vehicle, &bicycle.coefficients);
    let mut table = Table::new(["quantity", "value"]);
    for (name, number, unit) in v.in_words() {
        table.push([name.to_owned(), format!("{} {unit}", significant(number)).trim_end().into()]);
    }
    let coefficients = Table::new(["A1", "A2", "A3", "A4", "B1", "B2", "n", "Tn"])
        .row([c.a1, c.a2, c.a3, c.a4, c.b1, c.b2, c.n, c.tn].map(significant));
    let mut blocks = vec![
        Block::Text(format!("Two-wheel model of {} (eq 13).", v.name)),
        Block::Table(table),
        Block::Heading("Coefficients of eq 13".into()),
        Block::Table(coefficients),
    ];
    if let Some(fit) = fit {
        blocks.push(Block::Text(format!(
            "Driven by the recorded steering it fits the measured yaw rate by {}.",
            value(fit, 1, "%")
        )));
    }
    Section::new("The bicycle model", blocks)
}

/// Gains, requirements and reached figures.
pub(crate) fn controller(controller: &Controller<'_>) -> Section {
    let pid = controller.pid;
    let (s, e) = (&pid.specification, &pid.evidence);
    let mut blocks = vec![verdict(controller)];
    blocks.push(Block::List(e.shortfalls.iter().map(shortfall).collect()));
    blocks.push(Block::List(e.advice.clone()));
    blocks.push(Block::Text(format!(
        "Designed on the {} model {} at {}, {}.",
        if pid.designed_for.model == "plant" { "identified" } else { &pid.designed_for.model },
        pid.designed_for.name,
        value(pid.designed_for.speed_mps, 2, "m/s"),
        if pid.designed_for.loop_delay_s > 0.0 {
            let delay = value(pid.designed_for.loop_delay_s, 3, "s");
            format!("with {delay} of loop delay beyond the model's own")
        } else {
            "with no loop delay beyond the model's own".into()
        },
    )));
    blocks.push(Block::Heading("Required and reached".into()));
    blocks.push(Block::Table(requirements(pid, controller.in_loop.map(|l| l.metrics))));
    let at = format!("The steady-state error is read {} s after the step.", s.steady_state_time_s);
    blocks.push(Block::Text(at));
    if let Some(l) = controller.in_loop {
        let step = value(s.step_rad * DEG, 1, "deg");
        let title = format!("Yaw step of {step}, in closed loop with {}", l.plant);
        let caption = "Steering is in steering coordinates, as are its limits.";
        let largest = pid.largest_angle_rad();
        let figure = figures::yaw_step(&title, l.response, s, l.metrics, largest);
        blocks.push(Block::figure(figure, 680, caption));
    }
    if !e.steps.is_empty() {
        blocks.push(Block::Heading("Steps of other heights".into()));
        blocks.push(Block::Table(steps(pid)));
        let of = "On the model designed on, with the limits; shares are of each height.";
        blocks.push(Block::Text(of.into()));
    }
    if let Some(engagement) = &e.engagement {
        blocks.push(Block::Heading("Engagement".into()));
        blocks.push(Block::Table(envelope(engagement)));
        blocks.push(Block::Text(format!(
            "Largest lateral offset, of up to {} m tried, from which the loop returns to a straight \
             path, by speed and heading error (positive away from the path); driven: {}.",
            engagement.offsets_m.last().copied().unwrap_or_default(),
            engagement.plant
        )));
    }
    blocks.push(Block::Heading("Margins".into()));
    blocks.push(Block::Table(margins(pid)));
    blocks.push(Block::Heading("Gains and limits".into()));
    blocks.push(Block::Table(gains(pid)));
    Section::new(format!("Controller: {}", controller.name), blocks)
}

/// The verdict in the words of a table.
pub(crate) fn in_short(controller: &Controller<'_>) -> String {
    let evidence = &controller.pid.evidence;
    match controller.is_proved() {
        true if !controller.pid.designed_for.quality.allows_design() => {
            "met on a model that failed validation".into()
        }
        true if evidence.robustness.as_ref().is_some_and(|r| !r.met) => {
            "met on the nominal plant, not on all".into()
        }
        true if controller.pid.designed_for.quality.grade > Grade::Pass => {
            "met on a model with reservations".into()
        }
        is_met => met(is_met),
    }
}

fn verdict(controller: &Controller<'_>) -> Block {
    let evidence = &controller.pid.evidence;
    let quality = &controller.pid.designed_for.quality;
    let (tone, title) = match controller.in_loop {
        _ if !evidence.met => (Tone::Bad, "Not every requirement is met.".into()),
        Some(l) if !controller.is_proved() => (
            Tone::Bad,
            format!("Met on the model it was designed on, not in closed loop with {}.", l.plant),
        ),
        _ if !quality.allows_design() => (
            Tone::Bad,
            "Every requirement is met on a model that failed validation, which does not represent the vehicle."
                .into(),
        ),
        _ if evidence.robustness.as_ref().is_some_and(|r| !r.met) => (
            Tone::Neutral,
            "Every requirement is met on the nominal plant, not on all plants of the ensemble."
                .into(),
        ),
        _ if quality.grade > Grade::Pass => (
            Tone::Neutral,
            "Every requirement is met on the model, which has reservations.".into(),
        ),
        _ => (Tone::Good, "Every requirement is met.".into()),
    };
    let text = if quality.grade > Grade::Pass {
        let (grade, codes) = (quality.grade, quality.codes());
        format!("Quality of the design: {grade} ({codes}). {}", quality.summary)
    } else {
        String::new()
    };
    Block::Note { tone, title, text }
}

/// A requirement's name in the file ends in its unit, as `settling_time_s` does.
fn shortfall(s: &Shortfall) -> String {
    let units = [("_percent", "%"), ("_s", "s"), ("_db", "dB"), ("_deg", "deg")];
    let parted =
        units.iter().find_map(|(end, unit)| Some((s.requirement.strip_suffix(end)?, *unit)));
    let (name, unit) = parted.unwrap_or((&s.requirement, ""));
    let figure = |v: f64| format!("{}\u{a0}{unit}", significant(v)).trim_end().to_owned();
    let (required, reached) = (figure(s.required), figure(s.reached));
    format!("{}: required {required}, reached {reached}", name.replace('_', " "))
}

/// Requirements and reached figures on the model designed on, in the loop where there is one,
/// and on that model with the steering offset.
fn requirements(pid: &Pid, in_loop: Option<&StepMetrics>) -> Table {
    let (s, e) = (&pid.specification, &pid.evidence);
    let mut headers = vec!["requirement", "required", "on its model", ""];
    if in_loop.is_some() {
        headers.extend(["in the loop", ""]);
    }
    headers.push("with steering offset");
    let mut table = Table::new(headers);
    type Reached = fn(&StepMetrics) -> Option<f64>;
    /// Factor, digits and unit of a figure.
    type Shown<'s> = (f64, usize, &'s str);
    let mut row =
        |name: &str, asked: String, bound: Option<f64>, reached: Reached, shown: Shown<'_>| {
            let (factor, digits, unit) = shown;
            let figure =
                |m: &StepMetrics| optional(reached(m).map(|v| factor * v), digits, unit, "never");
            let mut cells = vec![name.to_owned(), asked];
            for step in std::iter::once(&e.step).chain(in_loop) {
                cells.push(figure(step));
                let kept = |bound: f64| reached(step).is_some_and(|r| r <= bound * (1.0 + 1e-9));
                cells.push(match bound {
                    Some(bound) => met(kept(bound)),
                    None => String::new(),
                });
            }
            cells.push(figure(&e.step_with_offset));
            table.push(cells);
        };
    let steady: Reached = |m| Some(m.steady_state_error_percent);
    let absolute: Reached = |m| Some(m.integral_absolute_error_s);
    let height = "integral of absolute error, over the step's height";
    let figures: [(&str, Option<f64>, Reached, usize, &str); 5] = [
        ("overshoot", s.overshoot_percent, |m| Some(m.overshoot_percent), 2, "%"),
        ("settling time", s.settling_time_s, |m| m.settling_time_s, 3, "s"),
        ("steady-state error", s.steady_state_error_percent, steady, 2, "%"),
        ("rise time, 10 to 90 %", s.rise_time_s, |m| m.rise_time_s, 3, "s"),
        (height, s.integral_absolute_error_s, absolute, 3, "s"),
    ];
    for (name, bound, reached, digits, unit) in figures {
        let asked = match bound {
            Some(v) => format!("≤\u{a0}{v}\u{a0}{unit}"),
            None => String::new(),
        };
        row(name, asked, bound, reached, (1.0, digits, unit));
    }
    let columns = if in_loop.is_some() { 7 } else { 5 };
    let on_curve = e.curve.as_ref().map(|c| c.steady_state_error_percent);
    let with_offset = Some(e.step_with_offset.steady_state_error_percent);
    let mut others = Vec::new();
    for (name, reached) in [
        ("steady-state error with the steering 1° off", with_offset),
        ("steady-state error on a curve", on_curve),
    ] {
        if let (Some(bound), Some(reached)) = (s.steady_state_error_percent, reached) {
            let asked = format!("≤\u{a0}{bound}\u{a0}%");
            let mut cells =
                vec![name.to_owned(), asked, value(reached, 2, "%"), met(reached <= bound)];
            cells.resize(columns, String::new());
            others.push(cells);
        }
    }
    let angles: [(&str, f64, Reached); 2] = [
        ("largest steering angle", pid.largest_angle_rad(), |m| Some(m.largest_angle_rad)),
        ("largest change in a sample", pid.limits.max_increment_rad, |m| {
            Some(m.largest_increment_rad)
        }),
    ];
    for (name, bound, reached) in angles {
        let asked = format!("≤\u{a0}{}", value(bound * DEG, 2, "deg"));
        row(name, asked, Some(bound), reached, (DEG, 2, "deg"));
    }
    others.into_iter().for_each(|cells| table.push(cells));
    table
}

fn steps(pid: &Pid) -> Table {
    let mut table = Table::new(["step", "overshoot", "settling time", "largest steering angle"]);
    for s in &pid.evidence.steps {
        table.push([
            value(s.height_rad * DEG, 0, "deg"),
            value(s.step.overshoot_percent, 1, "%"),
            optional(s.step.settling_time_s, 2, "s", "never"),
            value(s.step.largest_angle_rad * DEG, 1, "deg"),
        ]);
    }
    table
}

fn envelope(engagement: &Engagement) -> Table {
    let mut table = Table::new(["speed", "heading error", "returns from"]);
    for r in &engagement.rows {
        table.push([
            value(r.speed_mps, 1, "m/s"),
            value(r.heading_error_rad * DEG, 0, "deg"),
            optional(r.largest_offset_m, 0, "m", "none"),
        ]);
    }
    table
}

fn margins(pid: &Pid) -> Table {
    let (m, s) = (&pid.evidence.margins, &pid.specification);
    let mut table = Table::new(["margin", "required", "value"]);
    for (name, asked, reached, digits, unit, absent) in [
        ("gain margin", s.gain_margin_db, m.gain_margin_db, 1, "dB", "∞"),
        ("phase margin", s.phase_margin_deg, m.phase_margin_deg, 1, "deg", "∞"),
        ("delay margin", s.delay_margin_s, m.delay_margin_s, 3, "s", "∞"),
        ("modulus margin", s.modulus_margin, Some(m.modulus_margin), 3, "", "–"),
        ("disk margin", s.disk_margin, m.disk_margin, 3, "", "–"),
        ("gain crossover", None, m.crossover_radps, 2, "rad/s", "–"),
    ] {
        let at_least = |v: f64| format!("≥\u{a0}{v}\u{a0}{unit}").trim_end().to_owned();
        table.push([
            name.to_owned(),
            match asked {
                Some(value) => at_least(value),
                None => String::new(),
            },
            optional(reached, digits, unit, absent),
        ]);
    }
    table
}

fn gains(pid: &Pid) -> Table {
    let (g, l, a) = (&pid.gains, &pid.limits, &pid.guidance);
    let mut table = Table::new(["parameter", "value"]);
    let angle = pid.largest_angle_rad() * DEG;
    let bound = l.lateral_acceleration.map(|b| {
        vec![
            ("largest steering angle at the speed designed for", angle, "deg"),
            ("lateral acceleration that bounds it", b.max_mps2, "m/s²"),
        ]
    });
    let large = l.large_errors.map(|e| {
        vec![
            ("largest yaw error that is acted on at once", e.max_yaw_error_rad * DEG, "deg"),
            ("lag of the yaw rate, by which a slower actuator is noticed", e.yaw_rate_lag_s, "s"),
            ("largest rate with the slowest actuator", e.sustained_rate_radps * DEG, "deg/s"),
        ]
    });
    let usual = [
        ("Kp", g.kp, ""),
        ("Ki", g.ki, "1/s"),
        ("Kd", g.kd, "s"),
        ("time constant of the derivative filter", g.derivative_filter_time_s, "s"),
        ("setpoint weight, proportional", g.setpoint_weight_proportional, ""),
        ("setpoint weight, derivative", g.setpoint_weight_derivative, ""),
        ("anti-windup time", g.anti_windup_time_s, "s"),
        ("sample time", pid.sample_time_s, "s"),
        ("largest steering angle", l.max_angle_rad * DEG, "deg"),
        ("largest change in a sample", l.max_increment_rad * DEG, "deg"),
        ("largest rate", l.max_rate_radps * DEG, "deg/s"),
    ];
    let advice = [
        ("advice: steering per path curvature", a.feedforward_gain_radm, "rad·m"),
        ("advice: preview time", a.preview_time_s, "s"),
        ("advice: yaw acceleration in the reference", a.yaw_acceleration_gain_s2, "s²"),
        ("advice: yaw jerk in the reference", a.yaw_jerk_gain_s3, "s³"),
    ];
    let limits = bound.into_iter().chain(large).flatten();
    for (name, number, unit) in usual.into_iter().chain(limits).chain(advice) {
        table.push([name.to_owned(), format!("{} {unit}", significant(number)).trim_end().into()]);
    }
    table
}
