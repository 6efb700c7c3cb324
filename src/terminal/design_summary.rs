//! A design for people: gains, required and reached figures, margins, robustness.

use crate::terminal::console;
use std::fmt::Write;
use steerwright_control::Requirement;
use steerwright_formats::{
    Breaking, DesignEvidence, DesignedFor, Grade, LoopCoupling, OnACurve, Pid, Robustness,
    Shortfall, StepMetrics,
};
use steerwright_report::Table;

/// The actuator before the model, if one was stated.
fn behind(on: &DesignedFor) -> String {
    let Some(actuator) = on.actuator else { return String::new() };
    let [lag, delay] = [actuator.time_constant_s, actuator.delay_s].map(|s| 1e3 * s);
    format!(" behind an actuator with a lag of {lag:.0} ms and a delay of {delay:.0} ms")
}

/// Gains, requirements, margins and robustness.
pub(crate) fn summary(pid: &Pid) -> String {
    let (g, e, on) = (&pid.gains, &pid.evidence, &pid.designed_for);
    let [kp, ki, kd, filter] = [g.kp, g.ki, g.kd, g.derivative_filter_time_s];
    let mut text = format!(
        "designed on {} {} at {:.1} m/s{}\n\
         gains    kp {kp:.4}, ki {ki:.4} 1/s, kd {kd:.4} s, filter {filter:.4} s, weights {:.3} and {:.3}\n\n",
        on.model,
        on.name,
        on.speed_mps,
        behind(on),
        g.setpoint_weight_proportional,
        g.setpoint_weight_derivative
    );
    let _ = writeln!(text, "{}", console::table(&required_and_reached(pid)));
    let delay = on.loop_delay_s;
    let unlike = e.fmu_loops.iter().all(|l| (l.loop_delay_s - delay).abs() > 1e-9);
    if !e.fmu_loops.is_empty() && unlike {
        let _ = writeln!(
            text,
            "the loops of FMUs have no latency but their coupling's, the design is for {:.0} ms\n",
            1e3 * delay
        );
    }
    if let Some(robustness) = &e.robustness {
        let _ = writeln!(text, "{}", ranges(pid, robustness));
    }
    text.push_str(&limits(pid));
    text.push_str(&steps(e));
    text.push_str(&engagement(e));
    text.push_str(&trade_off(e));
    let quality = &pid.designed_for.quality;
    if quality.grade > Grade::Pass {
        let (grade, codes) = (quality.grade, quality.codes());
        let _ = writeln!(text, "quality of the design: {grade} ({codes}): {}", quality.summary);
    }
    text.push_str(match (e.met, e.robustness.as_ref().is_none_or(|r| r.met)) {
        (true, _) if !quality.allows_design() => {
            "every requirement is met on a model that failed validation, which does not represent the vehicle\n"
        }
        (true, true) if quality.grade > Grade::Pass => {
            "every requirement is met on the model, which has the reservations above\n"
        }
        (true, true) => "every requirement is met\n",
        (true, false) => {
            "every requirement is met on the nominal plant, not on all plants of the ensemble\n"
        }
        (false, _) => "not every requirement is met\n",
    });
    for missed in shortfalls(e) {
        let _ = writeln!(text, "not met: {missed}");
    }
    for advice in &e.advice {
        let _ = writeln!(text, "  {advice}");
    }
    text.trim_end().to_owned()
}

/// The requirements that are not met: what was reached, and what is required.
pub(crate) fn shortfalls(e: &DesignEvidence) -> Vec<String> {
    let one = |shortfall: &Shortfall| {
        let (label, value): (&str, Box<dyn Fn(f64) -> String>) =
            match Requirement::from_name(&shortfall.requirement) {
                Some(r) => (r.label(), Box::new(move |v| r.text(v))),
                None => (&shortfall.requirement, Box::new(|v| format!("{v:.4}"))),
            };
        let (reached, required) = (value(shortfall.reached), value(shortfall.required));
        format!("{label} is {reached}, {required} is required")
    };
    e.shortfalls.iter().map(one).collect()
}

/// The bounds of the steering at the design speed.
fn limits(pid: &Pid) -> String {
    let (l, speed) = (&pid.limits, pid.designed_for.speed_mps);
    let angle = pid.largest_angle_rad().to_degrees();
    let mut text =
        format!("limits   {angle:.1}° at {speed:.1} m/s, {:.0}°/s", l.max_rate_radps.to_degrees());
    if let Some(lateral) = l.lateral_acceleration {
        let _ = write!(text, "; the angle by speed is that of {} m/s²", lateral.max_mps2);
    }
    if let Some(large) = l.large_errors {
        let _ = write!(
            text,
            "; of yaw errors beyond {:.1}° the rest is released as a ramp; with a slower actuator the rate is \
             reduced to no less than {:.0}°/s",
            large.max_yaw_error_rad.to_degrees(),
            large.sustained_rate_radps.to_degrees()
        );
    }
    text + "\n"
}

fn steps(e: &DesignEvidence) -> String {
    if e.steps.is_empty() {
        return String::new();
    }
    let mut table = Table::new(["step", "overshoot", "settling time"]);
    for s in &e.steps {
        table = table.row([
            format!("{:.0}°", s.height_rad.to_degrees()),
            format!("{:.1} %", s.step.overshoot_percent),
            s.step.settling_time_s.map_or("never".into(), |t| format!("{t:.2} s")),
        ]);
    }
    format!("\nsteps of other heights on the model designed on\n{}", console::table(&table))
}

/// Lateral offsets from which the loop returns to a path.
fn engagement(e: &DesignEvidence) -> String {
    let Some(engagement) = &e.engagement else { return String::new() };
    let mut headers = vec!["heading error".to_owned()];
    let mut speeds: Vec<f64> = engagement.rows.iter().map(|r| r.speed_mps).collect();
    speeds.dedup();
    headers.extend(speeds.iter().map(|v| format!("{v:.1} m/s")));
    let mut table = Table::new(headers);
    let first = speeds.first().copied();
    for row in engagement.rows.iter().filter(|r| Some(r.speed_mps) == first) {
        let at = |v: &f64| {
            let same = |r: &&steerwright_formats::EngagementRow| {
                r.speed_mps == *v && r.heading_error_rad == row.heading_error_rad
            };
            engagement.rows.iter().find(same).and_then(|r| r.largest_offset_m)
        };
        let mut cells = vec![format!("{:.0}°", row.heading_error_rad.to_degrees())];
        cells.extend(speeds.iter().map(|v| at(v).map_or("none".into(), |m| format!("{m:.0} m"))));
        table = table.row(cells);
    }
    let tried = engagement.offsets_m.last().copied().unwrap_or_default();
    format!(
        "\nlargest lateral offset, of up to {tried:.0} m, from which the loop returns to a straight path \
         ({})\n{}\n",
        engagement.plant,
        console::table(&table)
    )
}

/// A row for each figure, with its requirement.
fn required_and_reached(pid: &Pid) -> Table {
    let (s, e) = (&pid.specification, &pid.evidence);
    let robust = e.robustness.as_ref();
    let mut headers = vec!["requirement", "required", "reached"];
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
        let mut row = vec![
            r.label().to_owned(),
            required.map_or_else(String::new, |v| format!("{sign} {}", r.text(v))),
            match reached {
                Some(v) => r.text(v),
                None => if r.at_least() { "unlimited" } else { "never" }.into(),
            },
        ];
        row.extend(e.fmu_loops.iter().map(|l| {
            let offset = l.step_with_offset.as_ref();
            match of_steps(r, &l.step, offset, None) {
                Some(v) => r.text(v),
                None => String::new(),
            }
        }));
        if let Some(robust) = robust {
            let over = robust.requirements.iter().find(|o| o.requirement == r.name());
            row.push(match over {
                Some(o) => r.text(o.worst),
                None => String::new(),
            });
            row.push(match over {
                Some(o) => format!("{:.0} %", 100.0 * o.share_kept),
                None => String::new(),
            });
        }
        table = table.row(row);
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

/// The plants of the ensemble, and the limits of each requirement.
fn ranges(pid: &Pid, r: &Robustness) -> String {
    let ms = |s: f64| format!("{:.0}", 1e3 * s);
    let mut text = format!("worst of {} plants: ", r.plants);
    if r.members > 0 {
        let of_wanted = match r.members_wanted {
            Some(wanted) => {
                format!(" of {wanted} (the others are unstable or have no continuous form)")
            }
            None => String::new(),
        };
        let members = r.members;
        let _ = write!(text, "{members}{of_wanted} drawn from the identified uncertainty, ");
    }
    let _ = write!(text, "gain {} to {}", r.gain_range[0], r.gain_range[1]);
    let [low, high] = r.loop_delay_range_s;
    if high > low {
        let _ = write!(text, ", delay of the loop {} to {} ms", ms(low.max(0.0)), ms(high));
    }
    if let Some([low, high]) = r.speed_range_mps {
        let _ = write!(text, ", {low:.1} to {high:.1} m/s");
    } else if pid.schedule.is_empty() {
        let _ = write!(text, ", at {:.1} m/s alone", pid.designed_for.speed_mps);
    }
    text.push('\n');
    let over_speed = !r.speed.is_empty() || !pid.schedule.is_empty();
    let mut headers = vec!["requirement", "breaks at a loop delay of"];
    headers.extend(if over_speed { Some("at a speed of") } else { None });
    let mut table = Table::new(headers);
    for b in &r.latency {
        let label =
            Requirement::from_name(&b.requirement).map_or(b.requirement.as_str(), |r| r.label());
        let speed = r.speed.iter().find(|s| s.requirement == b.requirement);
        let mut row = vec![label.to_owned(), where_it_breaks(b, &|v| format!("{} ms", ms(v)))];
        let over_speeds = || "see over speed".into();
        row.extend(if over_speed {
            Some(match speed {
                Some(b) => where_it_breaks(b, &|v| format!("{v:.1} m/s")),
                None => over_speeds(),
            })
        } else {
            None
        });
        table = table.row(row);
    }
    format!("{text}{}", console::table(&table))
}

fn where_it_breaks(b: &Breaking, value: &dyn Fn(f64) -> String) -> String {
    match (b.below, b.above) {
        (None, None) => format!("none up to {}", value(b.looked[1])),
        (Some(below), None) => format!("below {}", value(below)),
        (None, Some(above)) => format!("above {}", value(above)),
        (Some(below), Some(above)) => format!("below {}, above {}", value(below), value(above)),
    }
}

fn trade_off(e: &DesignEvidence) -> String {
    let rows: Vec<String> = e
        .trade_off
        .iter()
        .map(|t| {
            let settling = t.settling_time_s.map_or("none".into(), |s| format!("{s:.2} s"));
            format!("{} at {}", settling, t.modulus_margin)
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    format!(
        "shortest settling on the nominal plant by modulus margin: {} (here {} at {:.2})\n",
        rows.join(", "),
        e.step.settling_time_s.map_or("never".into(), |s| format!("{s:.2} s")),
        e.margins.modulus_margin
    )
}
