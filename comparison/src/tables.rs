//! A comparison as tables and as CSV.

use crate::compare::Comparison;
use crate::runs::ComparedRun;
use std::fmt::Write;
use steerwright_formats::Guidance;
use steerwright_report::Table;
use steerwright_sweep::Class;

/// The comparison for people, in tables of at most this many columns of text: conclusions first, then
/// the figures.
#[must_use]
pub fn text(c: &Comparison, columns: usize) -> String {
    let table = |table: &Table| table.text(columns);
    let mut text = String::new();
    for sentence in &c.verdict.sentences {
        let _ = writeln!(text, "{sentence}");
    }
    text.push('\n');
    if c.drive.is_some() {
        let _ = writeln!(text, "{}", table(&drive_table(c)));
    }
    let _ = writeln!(text, "{}", table(&controller_table(c)));
    let _ = writeln!(
        text,
        "cross-track error RMS / largest on the {}, {:.0} m at {:.1} m/s and up to {:.1} m/s²",
        c.road.name,
        c.length(),
        c.road.speed_mps,
        c.lateral_acceleration()
    );
    let _ = writeln!(text, "{}", table(&matrix(c)));
    let _ = writeln!(text, "{}\n{}", table(&road_table(c)), table(&step_table(c)));
    let _ = writeln!(text, "* on the model that the controller was designed on");
    if !c.remarks.is_empty() {
        text.push('\n');
    }
    for remark in &c.remarks {
        let _ = writeln!(text, "remark: {remark}");
    }
    text
}

/// The models compared with the drive.
pub(crate) fn drive_table(c: &Comparison) -> Table {
    let headers = ["model", "what", "validation fit", "VAF", "yaw rate RMS error", "yaw RMS error"];
    let mut table = Table::new(headers);
    for (model, on) in c.models.iter().zip(c.drive.iter().flat_map(|d| &d.models)) {
        table.push([
            model.label.clone(),
            model.kind(),
            format!("{:.2} %", on.fit_percent),
            format!("{:.2} %", on.variance_accounted_for_percent),
            format!("{:.3} deg/s", on.yaw_rate_rms_radps.to_degrees()),
            format!("{:.2} deg", on.yaw_rms_rad.to_degrees()),
        ]);
    }
    table
}

/// Gains, and the predictions on their own model.
pub(crate) fn controller_table(c: &Comparison) -> Table {
    let headers = [
        "controller of",
        "kp",
        "ki (1/s)",
        "kd (s)",
        "modulus margin",
        "predicted overshoot",
        "settling",
        "look-ahead",
        "feedforward",
    ];
    let mut table = Table::new(headers);
    for k in &c.controllers {
        let (g, guidance) = (&k.pid.gains, k.guidance(&c.road));
        let what = match &k.source {
            Some(source) => format!("{} from {}", k.label, source.name),
            None => k.label.clone(),
        };
        table.push([
            what,
            format!("{:.3}", g.kp),
            format!("{:.3}", g.ki),
            format!("{:.4}", g.kd),
            format!("{:.3}", k.pid.evidence.margins.modulus_margin),
            format!("{:.2} %", k.predicted.overshoot_percent),
            seconds(k.predicted.settling_time_s),
            format!("{:.1} m", look_ahead(&guidance, c.road.speed_mps)),
            format!("{:.3} rad.m", guidance.feedforward_gain_radm),
        ]);
    }
    table
}

fn look_ahead(guidance: &Guidance, speed: f64) -> f64 {
    guidance.lookahead_min_m.max(guidance.lookahead_time_s * speed)
}

/// Controllers by plants; a star marks a controller's own model.
pub(crate) fn matrix(c: &Comparison) -> Table {
    let plants = c.plants.iter().map(|p| format!("on {}", p.label));
    let mut table = Table::new(std::iter::once("controller of".to_owned()).chain(plants));
    for (index, controller) in c.controllers.iter().enumerate() {
        let cells = (0..c.plants.len()).map(|plant| {
            let run = c.run(index, plant);
            let own = if c.is_own(run) { " *" } else { "" };
            match (run.off_path_at_m, c.outcome(run).outcome) {
                (Some(at), Class::Unstable) => format!("unstable after {at:.0} m{own}"),
                (Some(at), _) => format!(
                    "off the path after {at:.0} m, by {:.1} m{own}",
                    run.errors.cross_track_max_m
                ),
                (None, _) => format!(
                    "{:.4} / {:.4} m{own}",
                    run.errors.cross_track_rms_m, run.errors.cross_track_max_m
                ),
            }
        });
        table.push(std::iter::once(controller.label.clone()).chain(cells));
    }
    table
}

/// A row for each run along the road.
pub(crate) fn road_table(c: &Comparison) -> Table {
    let headers =
        ["controller of", "on", "yaw error RMS", "largest", "steering rate RMS", "largest"];
    let mut table = Table::new(headers);
    for r in &c.runs {
        let degrees = f64::to_degrees;
        let [controller, plant] = who(c, r);
        table.push([
            controller,
            plant,
            format!("{:.3} deg", degrees(r.errors.heading_rms_rad)),
            format!("{:.3} deg", degrees(r.errors.heading_max_rad)),
            format!("{:.2} deg/s", degrees(r.effort.rate_rms_radps)),
            format!("{:.1} deg/s", degrees(r.effort.rate_max_radps)),
        ]);
    }
    table
}

/// A row for each run: the yaw step of the specification.
pub(crate) fn step_table(c: &Comparison) -> Table {
    let headers = [
        "controller of",
        "on",
        "step overshoot",
        "settling",
        "error",
        "specification",
        "modulus margin",
    ];
    let mut table = Table::new(headers);
    for r in &c.runs {
        let [controller, plant] = who(c, r);
        table.push([
            controller,
            plant,
            format!("{:.2} %", r.step.overshoot_percent),
            seconds(r.step.settling_time_s),
            format!("{:.2} %", r.step.steady_state_error_percent),
            if c.outcome(r).shortfalls.is_empty() { "met" } else { "missed" }.into(),
            match r.modulus_margin {
                Some(m) => format!("{m:.3}"),
                None => "–".into(),
            },
        ]);
    }
    table
}

fn who(c: &Comparison, r: &ComparedRun) -> [String; 2] {
    let star = if c.is_own(r) { " *" } else { "" };
    [c.controllers[r.controller].label.clone(), format!("{}{star}", c.plants[r.plant].label)]
}

fn seconds(value: Option<f64>) -> String {
    match value {
        Some(s) => format!("{s:.3} s"),
        None => "never".into(),
    }
}

/// `results.csv`: a row for each run, in SI units; empty where there is no value.
pub(crate) fn csv(c: &Comparison) -> String {
    let mut text = String::from(
        "controller,plant,own_plant,outcome,off_path_at_m,cross_track_rms_m,cross_track_largest_m,\
         yaw_error_rms_rad,yaw_error_largest_rad,steering_largest_rad,steering_rate_rms_radps,\
         steering_rate_largest_radps,modulus_margin,step_overshoot_percent,step_settling_time_s,\
         step_steady_state_error_percent,step_meets_specification\n",
    );
    let optional = |v: Option<f64>| match v {
        Some(v) => v.to_string(),
        None => String::new(),
    };
    for r in &c.runs {
        let (e, f, s) = (&r.errors, &r.effort, &r.step);
        let cells = [
            quoted(&c.controllers[r.controller].label),
            quoted(&c.plants[r.plant].label),
            c.is_own(r).to_string(),
            c.outcome(r).outcome.name().to_owned(),
            optional(r.off_path_at_m),
            e.cross_track_rms_m.to_string(),
            e.cross_track_max_m.to_string(),
            e.heading_rms_rad.to_string(),
            e.heading_max_rad.to_string(),
            f.angle_max_rad.to_string(),
            f.rate_rms_radps.to_string(),
            f.rate_max_radps.to_string(),
            optional(r.modulus_margin),
            s.overshoot_percent.to_string(),
            optional(s.settling_time_s),
            s.steady_state_error_percent.to_string(),
            c.outcome(r).shortfalls.is_empty().to_string(),
        ];
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
