//! The evidence behind a plant of several channels, for people, and its signals.

use crate::terminal::console;
use crate::terminal::evidence::{channel_table, conclusion, with_error};
use std::fmt::Write;
use steerwright_formats::{BLOCK_S, LEAST_BLOCKS, MultivariablePlant};
use steerwright_report::Table;
use steerwright_sysid::multivariable::ChannelTraces;

/// The evidence of each output and each pair.
pub(crate) fn evidence(plant: &MultivariablePlant, tables: &str) -> String {
    let e = &plant.evidence;
    let channels = console::table(&channel_table(&e.channels));
    let mut orders = Table::new(["order", "estimation", "validation", "as estimated"]);
    for row in &e.order_table {
        let chosen = if row.order == plant.order() { " <" } else { "" };
        orders = orders.row([
            format!("{}{chosen}", row.order),
            format!("{:.2} %", row.estimation_fit),
            format!("{:.2} %", row.validation_fit),
            if row.stable { "stable".into() } else { "unstable".to_owned() },
        ]);
    }
    let mut text = format!("{channels}\n{}\n{tables}", console::table(&orders));
    let has_feedthrough = plant.discrete.d.0.iter().flatten().any(|d| *d != 0.0);
    let _ = writeln!(
        text,
        "model    order {}, {} ({}) with {} block rows, sample time {} s, {} feedthrough",
        plant.order(),
        e.method,
        plant.provenance.options.get("realization").map_or("", String::as_str),
        e.horizon,
        plant.discrete.sample_time_s,
        if has_feedthrough { "with" } else { "without" }
    );
    for input in plant.inputs.iter().filter(|input| input.delay_s > 0.0) {
        let samples = (input.delay_s / plant.discrete.sample_time_s).round();
        let _ = writeln!(
            text,
            "delay    {} s of {}, {samples} samples beyond the one of every model",
            input.delay_s, input.name
        );
    }
    let seconds =
        |samples: usize| (1e6 * samples as f64 * plant.discrete.sample_time_s).round() / 1e6;
    let _ = writeln!(
        text,
        "data     {} samples ({} s) of estimation data, {} samples ({} s) of validation data",
        e.estimation_samples,
        seconds(e.estimation_samples),
        e.validation_samples,
        seconds(e.validation_samples)
    );
    for output in &e.outputs {
        let without =
            format!("too few blocks of {BLOCK_S} s or 20 samples: {LEAST_BLOCKS} are needed");
        let fit = with_error(output.fit.validation, output.fit_standard_error, without);
        let _ = writeln!(
            text,
            "fit      {}: {fit} simulated on validation data, {:.2} % one step ahead, {:.2} % on estimation data",
            output.output, output.fit.validation_one_step, output.fit.estimation
        );
    }
    for output in &e.outputs {
        let pass = |pass: bool| if pass { "passed" } else { "failed" };
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
        let _ = writeln!(
            text,
            "residual {}: white: {}, {inputs} (tests at 99 %)",
            output.output,
            pass(output.whiteness.pass)
        );
    }
    text + &conclusion(&e.warnings, &plant.quality)
}

/// The signals as CSV: time, inputs, outputs, simulated outputs, and whether the sample is validation data.
pub(crate) fn traces_csv(traces: &ChannelTraces) -> String {
    let mut text = String::from("time_s");
    for (name, _) in &traces.inputs {
        let _ = write!(text, ",{name}");
    }
    for (name, ..) in &traces.outputs {
        let _ = write!(text, ",{name},simulated_{name}");
    }
    text.push_str(",held_out\n");
    for (k, time) in traces.time_s.iter().enumerate() {
        let _ = write!(text, "{time}");
        for (_, samples) in &traces.inputs {
            let _ = write!(text, ",{}", samples[k]);
        }
        for (_, measured, simulated) in &traces.outputs {
            let _ = write!(text, ",{},{}", measured[k], simulated[k]);
        }
        let _ = writeln!(text, ",{}", u8::from(traces.is_validation[k]));
    }
    text
}
