//! `steerwright identify`: the plant in a drive log.

use crate::failure::{Failure, Outcome};
use crate::files;
use crate::identify_bicycle::{self, BicycleArguments};
use crate::log_options::{IdentifyArguments, LogArguments};
use crate::tell::Tell;
use formats::Plant;
use std::fmt::Write;
use std::path::PathBuf;
use sysid::Traces;

/// Identify the lateral dynamics in a drive log: steering angle in, yaw rate out
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// CSV files with a header, each with a clock of its own
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Write the model here: by default plant.json, of the structure bicycle bicycle.json
    #[arg(long = "out", short = 'o', value_name = "FILE")]
    out: Option<PathBuf>,
    /// Also write measured and simulated signals as CSV
    #[arg(long, value_name = "CSV")]
    traces: Option<PathBuf>,
    /// Print the plant as JSON on stdout
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    log: LogArguments,
    #[command(flatten)]
    identify: IdentifyArguments,
    #[command(flatten)]
    bicycle: BicycleArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let log = arguments.log.read(&arguments.logs)?;
    let traces = arguments.traces.as_deref();
    let out = |default: &str| arguments.out.clone().unwrap_or_else(|| default.into());
    if let Some(options) = arguments.bicycle.options(&arguments.identify)? {
        let out = out("bicycle.json");
        return identify_bicycle::run(&log, &options, &out, traces, arguments.json);
    }
    let out = out("plant.json");
    let identified = sysid::identify(&log, &arguments.identify.options())?;
    files::write_document(&out, &identified.plant)?;
    if let Some(traces) = traces {
        files::write(traces, traces_csv(&identified.traces, None).as_bytes())?;
    }
    let text = format!("{}\nwritten to {}", evidence(&identified.plant), out.display());
    Tell::new(arguments.json).result(&text, &identified.plant)?;
    Ok(Outcome::Done)
}

/// The evidence behind a plant, for people.
pub(crate) fn evidence(plant: &Plant) -> String {
    let e = &plant.evidence;
    let channels = channel_table(&e.channels);
    let mut orders =
        report::Table::new(["order", "singular value", "estimation", "held out", "as estimated"]);
    for row in &e.order_table {
        let chosen = if row.order == plant.order() { " <" } else { "" };
        orders = orders.row([
            format!("{}{chosen}", row.order),
            format!("{:.4e}", row.singular_value),
            format!("{:.2} %", row.estimation_fit),
            format!("{:.2} %", row.validation_fit),
            if row.stable { "stable".into() } else { "unstable".to_owned() },
        ]);
    }
    let mut text = format!("{channels}values in rad, rad/s and m/s\n\n{orders}\n");
    let _ = writeln!(
        text,
        "model    order {}, {} ({}) with {} block rows, sample time {} s",
        plant.order(),
        e.method,
        plant.provenance.options.get("realization").map_or("", String::as_str),
        e.horizon,
        plant.discrete.sample_time_s
    );
    let _ = writeln!(
        text,
        "fit      {:.2} % simulated on held-out data, {:.2} % one step ahead, {:.2} % on estimation data",
        e.fit.validation, e.fit.validation_one_step, e.fit.estimation
    );
    let passed = |pass: bool| if pass { "passed" } else { "failed" };
    let _ = writeln!(
        text,
        "tests    on held-out residuals: whiteness {} ({:.1}, bound {:.1}), independence of input {} ({:.1}, bound {:.1})",
        passed(e.whiteness.pass),
        e.whiteness.statistic,
        e.whiteness.bound,
        passed(e.independence.pass),
        e.independence.statistic,
        e.independence.bound
    );
    for warning in &e.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    let _ = writeln!(text, "verdict  {}", e.verdict.summary);
    for advice in &e.verdict.advice {
        let _ = writeln!(text, "         {advice}");
    }
    text
}

/// What was read of the log.
pub(crate) fn channel_table(all: &[formats::ChannelSummary]) -> report::Table {
    let mut channels =
        report::Table::new(["channel", "column", "read as", "rows", "rate", "min", "mean", "max"]);
    for c in all {
        channels = channels.row([
            c.role.clone(),
            c.column.clone(),
            c.unit.clone(),
            c.rows.to_string(),
            format!("{:.1} Hz", c.rate_hz),
            format!("{:.4}", c.min),
            format!("{:.4}", c.mean),
            format!("{:.4}", c.max),
        ]);
    }
    channels
}

/// The signals as CSV; with the yaw rate of a bicycle model where there is one.
pub(crate) fn traces_csv(traces: &Traces, bicycle: Option<&[f64]>) -> String {
    let mut text = String::from(
        "time_s,steering_rad,yaw_rate_radps,simulated_yaw_rate_radps,held_out,yaw_rad,simulated_yaw_rad",
    );
    if bicycle.is_some() {
        text.push_str(",bicycle_yaw_rate_radps");
    }
    text.push('\n');
    for k in 0..traces.time_s.len() {
        let _ = write!(
            text,
            "{},{},{},{},{},{},{}",
            traces.time_s[k],
            traces.steering_rad[k],
            traces.yaw_rate_radps[k],
            traces.simulated_yaw_rate_radps[k],
            u8::from(traces.is_validation[k]),
            traces.yaw_rad[k],
            traces.simulated_yaw_rad[k]
        );
        if let Some(bicycle) = bicycle {
            let _ = write!(text, ",{}", bicycle[k]);
        }
        text.push('\n');
    }
    text
}
