//! The response to a steering torque and its evidence, for people.

use crate::console;
use crate::evidence::{channel_table, conclusion};
use std::fmt::Write;
use steerwright_formats::Torque;

pub(super) fn text(torque: &Torque, tables: &str) -> String {
    let e = &torque.evidence;
    let channels = console::table(&channel_table(&e.channels));
    let mut text = format!("{channels}\n{tables}");
    let _ = writeln!(
        text,
        "fit      {:.2} % on validation data, {:.2} % on estimation data; errors of {:.3} m/s²",
        e.validation_fit, e.estimation_fit, e.error_mps2
    );
    let samples = |n: usize| n as f64 * e.sample_time_s;
    let _ = writeln!(
        text,
        "data     {:.0} s estimation data at {:.1} m/s on average, {:.0} s validation data, above {} m/s",
        samples(e.estimation_samples),
        e.mean_speed_mps,
        samples(e.validation_samples),
        e.least_speed_mps
    );
    text + &conclusion(&e.warnings, &torque.quality)
}
