//! A manoeuvre for people: what is driven, how much of the limits it uses, the standard errors to expect, and the other kinds.

use crate::terminal::console;
use std::fmt::Write;
use steerwright_formats::{Manoeuvre, ManoeuvreGoal, ManoeuvreKind};
use steerwright_report::{
    Table, goal_error, goal_in_words, manoeuvre_limits, manoeuvre_parameters, signal_in_words,
};

pub(crate) fn summary(manoeuvre: &Manoeuvre) -> String {
    let goal = manoeuvre.purpose.goal;
    let blocks = manoeuvre.schedule.len();
    let mut text = format!(
        "{}: {} of {:.0} s, {blocks} blocks of {:.0} s\n",
        manoeuvre.name,
        manoeuvre.kind,
        manoeuvre.time_s(),
        manoeuvre.block_s
    );
    for signal in &manoeuvre.signals {
        let _ = writeln!(text, "signal   {}", signal_in_words(manoeuvre.kind, signal));
    }
    let _ = writeln!(text, "\n{}", console::table(&manoeuvre_limits(manoeuvre)));
    let e = &manoeuvre.expected;
    let detail = match goal {
        ManoeuvreGoal::Response => "two standard errors of gain and phase, the largest in the band",
        ManoeuvreGoal::Understeer => "two standard errors",
        ManoeuvreGoal::TyreLimit => "two standard errors, the larger of both",
    };
    let error = goal_error(goal, 2.0 * e.largest_error);
    let _ = write!(text, "{} known to {error} ({detail})", goal_in_words(manoeuvre));
    if let Some(bound) = e.bound {
        let _ = write!(
            text,
            "; no tones within the limits know it better than to {}",
            goal_error(goal, 2.0 * bound)
        );
    }
    text.push('\n');
    if let Some(wanted) = manoeuvre.purpose.max_error {
        let met = if e.met { "met" } else { "not met" };
        let _ = write!(text, "required {}: {met}", goal_error(goal, wanted));
        let _ = match e.needed_time_s {
            Some(time) => writeln!(text, "; {time:.0} s would do"),
            None => writeln!(text, "; no time would do"),
        };
    }
    let mut table =
        Table::new(["speed (m/s)", "frequency (Hz)", "gain (1/s)", "± gain", "± phase"]);
    for row in &e.response {
        table.push([
            format!("{:.1}", row.speed_mps),
            format!("{:.2}", row.frequency_hz),
            format!("{:.3}", row.gain),
            format!("{:.2} %", 200.0 * row.gain_error),
            format!("{:.2}°", 2.0 * row.phase_error_rad.to_degrees()),
        ]);
    }
    let table =
        if goal == ManoeuvreGoal::TyreLimit { manoeuvre_parameters(manoeuvre) } else { table };
    let _ = writeln!(text, "\n{}", console::table(&table));
    let mut table = Table::new([
        "manoeuvre",
        if goal == ManoeuvreGoal::Response { "largest error in the band" } else { "error" },
    ]);
    for other in &manoeuvre.alternatives {
        let who = match other.kind {
            _ if goal == ManoeuvreGoal::TyreLimit => "robot or driver",
            ManoeuvreKind::Multisine => "robot",
            _ => "driver",
        };
        table
            .push([format!("{} ({who})", other.kind), goal_error(goal, 2.0 * other.largest_error)]);
    }
    let _ = write!(text, "{}", console::table(&table));
    text
}
