//! `steerwright identify --structure torque`: the response to a steering torque in a drive log.

use crate::console;
use crate::evidence::{band, channel_table, conclusion};
use crate::failure::{Failure, Outcome};
use crate::output::Output;
use crate::progress::Progress;
use std::fmt::Write;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{NORMAL_95, Torque};
use steerwright_sysid::torque::{TorqueOptions, identify_torque};

pub(crate) fn run(
    log: &DriveLog,
    options: &TorqueOptions,
    out: &Output,
) -> Result<Outcome, Failure> {
    let progress = Progress::start("identifying");
    let torque = identify_torque(log, options)?;
    drop(progress);
    out.document(&torque)?;
    console::result(&text(&torque), &torque)?;
    console::note(format!("written to {out}"));
    Ok(Outcome::of(&torque.quality))
}

fn text(torque: &Torque) -> String {
    let command = &torque.command_unit;
    let estimates = [
        (
            "lateral acceleration per command",
            Some(torque.acceleration_per_command),
            format!("m/s² per {command}"),
        ),
        ("friction", Some(torque.friction), command.clone()),
        ("roll coefficient", torque.roll_coefficient, "1".into()),
        ("offset", Some(torque.offset_mps2), "m/s²".into()),
        ("delay", Some(torque.delay_s), "s".into()),
    ];
    let mut table = steerwright_report::Table::new(["identified", "value", "95 % band", "unit"]);
    for (name, estimate, unit) in estimates {
        let Some(estimate) = estimate else { continue };
        table = table.row([
            name.into(),
            format!("{:.5}", estimate.value),
            band(
                estimate.value,
                NORMAL_95 * estimate.standard_error,
                matches!(name, "friction" | "delay"),
            ),
            unit,
        ]);
    }
    let e = &torque.evidence;
    let channels = console::table(&channel_table(&e.channels));
    let mut text = format!("{channels}\n{}\n", console::table(&table));
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
