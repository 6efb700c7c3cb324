//! A steering controller with its proof.

use super::{met, optional, over_speed, robustness, significant, value};
use crate::figures::{self, DEG};
use crate::report::Controller;
use crate::section::{Block, Section, Tone};
use crate::table::Table;
use steerwright_formats::{
    DesignEvidence, DesignedFor, Grade, LoopCoupling, OnACurve, Pid, Requirement, Specification,
    StepMetrics,
};

/// The verdict, gains, required and reached figures, and how robust they are.
pub fn controller_section(controller: &Controller<'_>) -> Section {
    let pid = controller.pid;
    let (s, e, on) = (&pid.specification, &pid.evidence, &pid.designed_for);
    let mut blocks = vec![verdict(controller)];
    if on.quality.grade > Grade::Pass {
        let (grade, codes) = (on.quality.grade, on.quality.codes());
        let text = format!("quality of the design: {grade} ({codes}): {}", on.quality.summary);
        blocks.push(Block::Text(text));
    }
    blocks.push(Block::List(e.advice.clone()));
    blocks.push(Block::Facts(facts(pid)));
    blocks.push(Block::Table(requirements(controller)));
    let delay = on.loop_delay_s;
    if !e.fmu_loops.is_empty() && e.fmu_loops.iter().all(|l| (l.loop_delay_s - delay).abs() > 1e-9)
    {
        blocks.push(Block::Text(format!(
            "the loops of FMUs have no latency but their coupling's, the design is for {:.0} ms",
            1e3 * delay
        )));
    }
    if let Some(l) = controller.in_loop {
        let step = value(s.step_rad * DEG, 1, "deg");
        let title = format!("Yaw step of {step}, in closed loop with {}", l.plant);
        let caption = "Steering is in steering coordinates, as are its limits.";
        let largest = pid.largest_angle_rad();
        let figure = figures::yaw_step(&title, l.response, s, l.metrics, largest);
        blocks.push(Block::figure(figure, 680, caption));
    }
    blocks.extend(e.robustness.iter().flat_map(|r| robustness::robustness(pid, r)));
    blocks.extend(robustness::trade_off(e).map(Block::Text));
    blocks.extend(e.over_speed.iter().flat_map(over_speed::over_speed));
    blocks.extend(e.engagement.iter().flat_map(robustness::engagement));
    let read = format!("the steady-state error is read {} s after the step", s.steady_state_time_s);
    let mut details = vec![
        Block::Heading("The step in detail".into()),
        Block::Table(step(controller)),
        Block::Text(read),
    ];
    if !e.steps.is_empty() {
        details.push(Block::Heading("Steps of other heights".into()));
        details.push(Block::Table(heights(e)));
        details.push(Block::Text("on the model designed on, with the limits".into()));
    }
    details.push(Block::Heading("All parameters".into()));
    details.push(Block::Table(parameters(pid)));
    blocks.push(Block::Details(details));
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
    let e = &controller.pid.evidence;
    let quality = &controller.pid.designed_for.quality;
    let (tone, title, text) = match (controller.in_loop, &e.over_speed, &e.robustness) {
        _ if !e.met => {
            (Tone::Bad, "not every requirement is met".into(), shortfalls(e).join("; "))
        }
        (Some(l), ..) if !controller.is_proved() => (
            Tone::Bad,
            format!("met on the model it was designed on, not in closed loop with {}", l.plant),
            missed_in(&controller.pid.specification, l.metrics).join("; "),
        ),
        (_, Some(over), _) if !over.met => (
            Tone::Bad,
            "not every requirement is met at every speed".into(),
            over_speed::where_missed(over),
        ),
        _ if !quality.allows_design() => (
            Tone::Bad,
            "every requirement is met on a model that failed validation, which does not represent the vehicle"
                .into(),
            String::new(),
        ),
        (_, _, Some(robust)) if !robust.met => (
            Tone::Neutral,
            "every requirement is met on the nominal plant, not on all plants of the ensemble"
                .into(),
            robustness::where_missed(robust).join("; "),
        ),
        _ if quality.grade > Grade::Pass => (
            Tone::Neutral,
            "every requirement is met on the model, which has reservations".into(),
            String::new(),
        ),
        _ => (Tone::Good, "every requirement is met".into(), String::new()),
    };
    Block::Note { tone, title, text }
}

/// The requirements that are not met: what was reached, and what is required.
#[must_use]
pub fn shortfalls(e: &DesignEvidence) -> Vec<String> {
    let sentence = |s: &steerwright_formats::Shortfall| match Requirement::from_name(&s.requirement)
    {
        Some(r) => shortfall(r, Some(s.reached), s.required),
        None => format!("{} is {:.4}, {:.4} is required", s.requirement, s.reached, s.required),
    };
    e.shortfalls.iter().map(sentence).collect()
}

/// The requirements on a step that one does not meet.
fn missed_in(s: &Specification, step: &StepMetrics) -> Vec<String> {
    let missed = |r: Requirement| {
        let (required, reached) = (r.required(s)?, r.of_step(step)?);
        let is_met = reached.is_some_and(|reached| r.is_met(required, reached));
        if is_met { None } else { Some(shortfall(r, reached, required)) }
    };
    Requirement::ALL.into_iter().filter_map(missed).collect()
}

fn shortfall(r: Requirement, reached: Option<f64>, required: f64) -> String {
    format!("{} is {}, {} is required", r.label(), reached_text(r, reached), r.text(required))
}

/// A value that a requirement bounds; a time that is not reached, or a margin without an end.
fn reached_text(r: Requirement, reached: Option<f64>) -> String {
    match reached {
        Some(value) => r.text(value),
        None if r.at_least() => "unlimited".into(),
        None => "never".into(),
    }
}

fn facts(pid: &Pid) -> Vec<(String, String)> {
    let (g, on) = (&pid.gains, &pid.designed_for);
    let mut model = format!("{} {} at {:.1} m/s", on.model, on.name, on.speed_mps);
    model += &behind(on);
    if on.loop_delay_s > 0.0 {
        let delay = 1e3 * on.loop_delay_s;
        model += &format!(", with {delay:.0} ms of loop delay beyond the model's own");
    }
    let gains = format!(
        "kp {:.4}, ki {:.4} 1/s, kd {:.4} s, filter {:.4} s, weights {:.3} and {:.3}",
        g.kp,
        g.ki,
        g.kd,
        g.derivative_filter_time_s,
        g.setpoint_weight_proportional,
        g.setpoint_weight_derivative
    );
    vec![
        Block::fact("designed on", model),
        Block::fact("gains", gains),
        Block::fact("limits", limits(pid)),
    ]
}

/// The actuator before the model, if one was stated.
fn behind(on: &DesignedFor) -> String {
    let Some(actuator) = on.actuator else { return String::new() };
    let [lag, delay] = [actuator.time_constant_s, actuator.delay_s].map(|s| 1e3 * s);
    format!(" behind an actuator with a lag of {lag:.0} ms and a delay of {delay:.0} ms")
}

/// The bounds of the steering at the design speed.
fn limits(pid: &Pid) -> String {
    let (l, speed) = (&pid.limits, pid.designed_for.speed_mps);
    let angle = pid.largest_angle_rad() * DEG;
    let mut text = format!("{angle:.1}° at {speed:.1} m/s, {:.0}°/s", DEG * l.max_rate_radps);
    if let Some(lateral) = l.lateral_acceleration {
        text += &format!("; the angle by speed is that of {} m/s²", lateral.max_mps2);
    }
    if let Some(large) = l.large_errors {
        text += &format!(
            "; of yaw errors beyond {:.1}° the rest is released as a ramp; with a slower actuator the rate is reduced \
             to no less than {:.0}°/s",
            DEG * large.max_yaw_error_rad,
            DEG * large.sustained_rate_radps
        );
    }
    text
}

/// A row for each figure that is required or reached: on the model designed on, in the loop where there is one, in the
/// loops of the FMUs, and over the ensemble.
fn requirements(controller: &Controller<'_>) -> Table {
    let (s, e) = (&controller.pid.specification, &controller.pid.evidence);
    let robust = e.robustness.as_ref();
    let mut headers = vec!["requirement", "required", "reached"];
    headers.extend(controller.in_loop.map(|_| "in the loop"));
    headers.extend(e.fmu_loops.iter().map(|l| match l.coupling {
        LoopCoupling::GaussSeidel => "FMUs, Gauss–Seidel",
        LoopCoupling::Jacobi => "FMUs, Jacobi",
    }));
    if robust.is_some() {
        headers.extend(["worst plant", "kept by"]);
    }
    let mut table = Table::new(headers);
    for r in Requirement::ALL {
        let required = r.required(s);
        let reached = figure(r, e);
        if required.is_none() && reached.is_none() {
            continue;
        }
        let sign = if r.at_least() { "≥" } else { "≤" };
        let marked = |reached: Option<f64>| {
            let text = reached_text(r, reached);
            let unreached = if r.at_least() { f64::INFINITY } else { f64::NAN };
            match required {
                Some(bound) if r.is_met(bound, reached.unwrap_or(unreached)) => text + " ✓",
                Some(_) => text + " ✗",
                None => text,
            }
        };
        let mut row = vec![
            r.label().to_owned(),
            required.map_or_else(String::new, |v| format!("{sign} {}", r.text(v))),
            marked(reached),
        ];
        row.extend(controller.in_loop.map(|l| r.of_step(l.metrics).map_or(String::new(), marked)));
        row.extend(e.fmu_loops.iter().map(|l| {
            match of_steps(r, &l.step, l.step_with_offset.as_ref(), None) {
                Some(v) => r.text(v),
                None => String::new(),
            }
        }));
        if let Some(robust) = robust {
            let over = robust.requirements.iter().find(|o| o.requirement == r.name());
            row.extend(match over {
                Some(o) => [r.text(o.worst), format!("{:.0} %", 100.0 * o.share_kept)],
                None => [String::new(), String::new()],
            });
        }
        table.push(row);
    }
    table
}

fn figure(r: Requirement, e: &DesignEvidence) -> Option<f64> {
    let m = &e.margins;
    match r {
        Requirement::GainMargin => m.gain_margin_db,
        Requirement::PhaseMargin => m.phase_margin_deg,
        Requirement::ModulusMargin => Some(m.modulus_margin),
        Requirement::DelayMargin => m.delay_margin_s,
        Requirement::DiskMargin => m.disk_margin,
        _ => of_steps(r, &e.step, Some(&e.step_with_offset), e.curve.as_ref()),
    }
}

fn of_steps(
    r: Requirement,
    step: &StepMetrics,
    with_offset: Option<&StepMetrics>,
    curve: Option<&OnACurve>,
) -> Option<f64> {
    match r {
        Requirement::SteadyStateWithOffset => with_offset.map(|m| m.steady_state_error_percent),
        Requirement::SteadyStateOnCurve => curve.map(|c| c.steady_state_error_percent),
        _ => r.of_step(step).flatten(),
    }
}

/// The figures of the specification's step, and what it uses of the limits of the steering.
fn step(controller: &Controller<'_>) -> Table {
    let (pid, e) = (controller.pid, &controller.pid.evidence);
    let mut headers = vec!["step", "limit", "on its model"];
    headers.extend(controller.in_loop.map(|_| "in the loop"));
    headers.push("with steering offset");
    let mut table = Table::new(headers);
    let steps = || {
        let in_loop = controller.in_loop.map(|l| l.metrics);
        std::iter::once(&e.step).chain(in_loop).chain([&e.step_with_offset])
    };
    for r in Requirement::ALL {
        if r.of_step(&e.step).is_some() {
            let cells = steps().map(|m| reached_text(r, r.of_step(m).flatten()));
            table.push([r.label().to_owned(), String::new()].into_iter().chain(cells));
        }
    }
    let degrees = |radians: f64| value(DEG * radians, 2, "deg");
    let angles = steps().map(|m| degrees(m.largest_angle_rad));
    let name = "largest steering angle".to_owned();
    table.push([name, degrees(pid.largest_angle_rad())].into_iter().chain(angles));
    let changes = steps().map(|m| degrees(m.largest_increment_rad));
    let name = "largest change in a sample".to_owned();
    table.push([name, degrees(pid.limits.max_increment_rad)].into_iter().chain(changes));
    table
}

fn heights(e: &DesignEvidence) -> Table {
    let mut table = Table::new(["step", "overshoot", "settling time", "largest steering angle"]);
    for s in &e.steps {
        table.push([
            value(s.height_rad * DEG, 0, "deg"),
            value(s.step.overshoot_percent, 1, "%"),
            optional(s.step.settling_time_s, 2, "s", "never"),
            value(s.step.largest_angle_rad * DEG, 1, "deg"),
        ]);
    }
    table
}

fn parameters(pid: &Pid) -> Table {
    let (g, l, a) = (&pid.gains, &pid.limits, &pid.guidance);
    let mut rows = vec![
        ("kp", g.kp, ""),
        ("ki", g.ki, "1/s"),
        ("kd", g.kd, "s"),
        ("time constant of the derivative filter", g.derivative_filter_time_s, "s"),
        ("setpoint weight, proportional", g.setpoint_weight_proportional, ""),
        ("setpoint weight, derivative", g.setpoint_weight_derivative, ""),
        ("anti-windup time", g.anti_windup_time_s, "s"),
        ("sample time", pid.sample_time_s, "s"),
        ("gain crossover", pid.evidence.margins.crossover_radps.unwrap_or(f64::NAN), "rad/s"),
        ("largest steering angle", l.max_angle_rad * DEG, "deg"),
        ("largest change in a sample", l.max_increment_rad * DEG, "deg"),
        ("largest rate", l.max_rate_radps * DEG, "deg/s"),
    ];
    if let Some(bound) = l.lateral_acceleration {
        let angle = pid.largest_angle_rad() * DEG;
        rows.push(("largest steering angle at the speed designed for", angle, "deg"));
        rows.push(("lateral acceleration that bounds it", bound.max_mps2, "m/s²"));
    }
    if let Some(e) = l.large_errors {
        let (error, rate) = (e.max_yaw_error_rad * DEG, e.sustained_rate_radps * DEG);
        rows.push(("largest yaw error that is acted on at once", error, "deg"));
        let lag = "lag of the yaw rate, by which a slower actuator is noticed";
        rows.push((lag, e.yaw_rate_lag_s, "s"));
        rows.push(("largest rate with the slowest actuator", rate, "deg/s"));
    }
    rows.extend([
        ("advice: steering per path curvature", a.feedforward_gain_radm, "rad·m"),
        ("advice: preview time", a.preview_time_s, "s"),
        ("advice: yaw acceleration in the reference", a.yaw_acceleration_gain_s2, "s²"),
        ("advice: yaw jerk in the reference", a.yaw_jerk_gain_s3, "s³"),
    ]);
    let mut table = Table::new(["parameter", "value"]);
    for (name, number, unit) in rows {
        table.push([name.to_owned(), format!("{} {unit}", significant(number)).trim_end().into()]);
    }
    table
}
