//! A controller over a range of speeds: a row for each evaluated speed, and the speed ramps.

use crate::section::Block;
use crate::table::Table;
use steerwright_formats::{
    FrozenSpeed, OverSpeed, Requirement, Shortfall, SpeedRamp, SpeedRampKind,
};

/// The rows, the reasons of unmet requirements, and the ramps.
pub(super) fn over_speed(over: &OverSpeed) -> Vec<Block> {
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
    over.frozen.iter().for_each(|row| table.push(cells(row)));
    let heading = "Over speed (* entries of the table, interpolated between them)";
    vec![
        Block::Heading(heading.into()),
        Block::Table(table),
        Block::List(reasons(over)),
        Block::List(over.ramps.iter().map(ramp).collect()),
    ]
}

/// At how many speeds a requirement is missed, and from which on.
pub(super) fn where_missed(over: &OverSpeed) -> String {
    let mut missed = over.frozen.iter().filter(|row| !row.met);
    let Some(first) = missed.next() else { return "in a speed ramp".into() };
    let (count, all) = (1 + missed.count(), over.frozen.len());
    format!("{count} of {all} speeds miss one, the first at {:.2} m/s", first.speed_mps)
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
fn reasons(over: &OverSpeed) -> Vec<String> {
    let alike = |a: &FrozenSpeed, b: &FrozenSpeed| {
        let names = |row: &FrozenSpeed| -> Vec<String> {
            row.shortfalls.iter().map(|s| s.requirement.clone()).collect()
        };
        a.met == b.met && a.reason == b.reason && names(a) == names(b)
    };
    let mut all = Vec::new();
    for rows in over.frozen.chunk_by(alike) {
        let [first, ..] = rows else { continue };
        let Some(why) = &first.reason else { continue };
        let missed: Vec<String> = (0..first.shortfalls.len())
            .filter_map(|k| worst(rows.iter().filter_map(|row| row.shortfalls.get(k))))
            .collect();
        let to = match rows {
            [_, .., last] => format!(" to {:.2}", last.speed_mps),
            _ => String::new(),
        };
        let missed = missed.join(", ");
        all.push(format!("not met at {:.2}{to} m/s: {missed}: {why}", first.speed_mps));
    }
    all
}

/// The largest shortfall of one requirement.
fn worst<'a>(shortfalls: impl Iterator<Item = &'a Shortfall>) -> Option<String> {
    let beyond = |s: &Shortfall| (s.reached - s.required).abs();
    let worst = shortfalls.max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
    let r = Requirement::from_name(&worst.requirement)?;
    let (reached, required) = (r.text(worst.reached), r.text(worst.required));
    Some(format!("{} {reached} instead of {required}", r.label()))
}

fn ramp(r: &SpeedRamp) -> String {
    let range =
        format!("{:.1} to {:.1} m/s at {:+.0} m/s²", r.from_mps, r.to_mps, r.acceleration_mps2);
    let cm = |length: Option<f64>| 100.0 * length.unwrap_or_default();
    match r.manoeuvre {
        SpeedRampKind::YawSteps => format!(
            "{range}: yaw steps overshoot by up to {:.2} % and settle within {}",
            r.overshoot_percent.unwrap_or_default(),
            r.settling_time_s.map_or("no bound".into(), |t| format!("{t:.2} s"))
        ),
        SpeedRampKind::ConstantRadius => format!(
            "{range}: {:.1} cm RMS and at most {:.1} cm from an arc of {:.0} m",
            cm(r.rms_cross_track_error_m),
            cm(r.largest_cross_track_error_m),
            r.radius_m.unwrap_or_default()
        ),
    }
}
