//! A controller over a range of speeds for people: a row for each evaluated speed, and the speed ramps.

use crate::terminal::console;
use std::fmt::Write;
use steerwright_control::Requirement;
use steerwright_formats::{FrozenSpeed, OverSpeed, Shortfall, SpeedRamp, SpeedRampKind};
use steerwright_report::Table;

/// The rows, the reasons of unmet requirements, and the ramps.
pub(crate) fn table(over: &OverSpeed) -> String {
    let mut table = Table::new([
        "speed (m/s)",
        "kp",
        "ki (1/s)",
        "kd (s)",
        "overshoot",
        "settling",
        "error",
        "gain margin",
        "phase margin",
        "delay margin",
        "plants",
        "specification",
    ]);
    for row in &over.frozen {
        table = table.row(cells(row));
    }
    let mut text = format!(
        "over speed (* entries of the table, interpolated between them)\n{}",
        console::table(&table)
    );
    text.push_str(&reasons(over));
    text.push_str(&ramps(&over.ramps));
    text.trim_end().to_owned()
}

fn cells(row: &FrozenSpeed) -> [String; 12] {
    let m = &row.margins;
    let margin = |r: Requirement, value: Option<f64>| r.text(value.unwrap_or(f64::INFINITY));
    let error = row.step.steady_state_error_percent.max(row.curve.steady_state_error_percent);
    let error = error.max(row.step_with_offset.steady_state_error_percent);
    [
        format!("{:.2}{}", row.speed_mps, if row.breakpoint { " *" } else { "" }),
        format!("{:.4}", row.kp),
        format!("{:.4}", row.ki),
        format!("{:.4}", row.kd),
        format!("{:.2} %", row.step.overshoot_percent),
        row.step.settling_time_s.map_or("never".into(), |t| format!("{t:.2} s")),
        format!("{error:.2} %"),
        margin(Requirement::GainMargin, m.gain_margin_db),
        margin(Requirement::PhaseMargin, m.phase_margin_deg),
        margin(Requirement::DelayMargin, m.delay_margin_s),
        match row.share_kept {
            Some(share) => format!("{:.0} %", 100.0 * share),
            None => String::new(),
        },
        if row.met { "met" } else { "not met" }.into(),
    ]
}

/// The unmet requirements and why, a line for neighbouring speeds with the same.
fn reasons(over: &OverSpeed) -> String {
    let alike = |a: &FrozenSpeed, b: &FrozenSpeed| {
        let names = |row: &FrozenSpeed| -> Vec<String> {
            row.shortfalls.iter().map(|s| s.requirement.clone()).collect()
        };
        a.met == b.met && a.reason == b.reason && names(a) == names(b)
    };
    let mut text = String::new();
    for rows in over.frozen.chunk_by(alike) {
        let [first, ..] = rows else { continue };
        let Some(why) = &first.reason else { continue };
        let missed: Vec<String> = (0..first.shortfalls.len())
            .filter_map(|k| worst(rows.iter().filter_map(|row| row.shortfalls.get(k))))
            .collect();
        let last = rows.last().filter(|_| rows.len() > 1);
        let to = match last {
            Some(row) => format!(" to {:.2}", row.speed_mps),
            None => String::new(),
        };
        let missed = missed.join(", ");
        let _ = writeln!(text, "not met at {:.2}{to} m/s: {missed}: {why}", first.speed_mps);
    }
    text
}

/// The largest shortfall of one requirement.
fn worst<'a>(shortfalls: impl Iterator<Item = &'a Shortfall>) -> Option<String> {
    let beyond = |s: &Shortfall| (s.reached - s.required).abs();
    let worst = shortfalls.max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
    let r = Requirement::from_name(&worst.requirement)?;
    let (reached, required) = (r.text(worst.reached), r.text(worst.required));
    Some(format!("{} {reached} instead of {required}", r.label()))
}

fn ramps(ramps: &[SpeedRamp]) -> String {
    let mut text = String::new();
    for r in ramps {
        let range =
            format!("{:.1} to {:.1} m/s at {:+.0} m/s²", r.from_mps, r.to_mps, r.acceleration_mps2);
        let cm = |length: Option<f64>| 100.0 * length.unwrap_or_default();
        let _ = match r.manoeuvre {
            SpeedRampKind::YawSteps => writeln!(
                text,
                "{range}: yaw steps overshoot by up to {:.2} % and settle within {}",
                r.overshoot_percent.unwrap_or_default(),
                r.settling_time_s.map_or("no bound".into(), |t| format!("{t:.2} s"))
            ),
            SpeedRampKind::ConstantRadius => writeln!(
                text,
                "{range}: {:.1} cm RMS and at most {:.1} cm from an arc of {:.0} m",
                cm(r.rms_cross_track_error_m),
                cm(r.largest_cross_track_error_m),
                r.radius_m.unwrap_or_default()
            ),
        };
    }
    text
}
