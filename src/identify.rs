//! `steerwright identify`: the plant in a drive log.

use crate::failure::{Failure, Outcome};
use crate::files;
use crate::identify_bicycle::{self, BicycleArguments};
use crate::log_options::{IdentifyArguments, LogArguments};
use crate::tell::Tell;
use formats::{Evidence, Information, Mode, Plant, ResidualTest};
use std::fmt::Write;
use std::path::PathBuf;
use sysid::Traces;

/// Identify the lateral dynamics in a drive log: steering angle in, yaw rate out
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// CSV files with a header, each with a clock of its own: drives where each brings steering and yaw
    /// rate, else the channels of one drive
    #[arg(required_unless_present = "drives", value_name = "LOG")]
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
    text.push_str(&judgement(e));
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

/// Fits, tests and where in frequency the log says something.
fn judgement(e: &Evidence) -> String {
    let mut text = String::new();
    let error = e.held_out.as_ref().and_then(|h| h.fit_standard_error);
    let _ = writeln!(
        text,
        "fit      {:.2}{} % simulated on held-out data, {:.2} % one step ahead, {:.2} % on estimation data",
        e.fit.validation,
        error.map_or_else(String::new, |error| format!(" ± {:.2}", 2.0 * error)),
        e.fit.validation_one_step,
        e.fit.estimation
    );
    if let Some(held_out) = &e.held_out {
        let ahead = held_out.predictions.iter().filter_map(|p| {
            let seconds = p.ahead_s.filter(|_| p.steps > Some(1))?;
            Some(format!("{seconds} s {:.2} %", p.fit))
        });
        let ahead: Vec<String> = ahead.collect();
        let vaf = held_out.variance_accounted_for;
        let _ = writeln!(
            text,
            "         predicted ahead by {}; the simulation accounts for {vaf:.2} % of the variance",
            ahead.join(", ")
        );
    }
    let test = |name: &str, t: &ResidualTest| {
        let passed = if t.pass { "passed" } else { "failed" };
        format!("{name} {passed} ({:.1}, bound {:.1})", t.statistic, t.bound)
    };
    let mut tests =
        vec![test("whiteness", &e.whiteness), test("independence of input", &e.independence)];
    if let Some(residuals) = &e.residuals {
        let t = &residuals.feedback;
        let found = if t.pass { "none" } else { "found" };
        tests.push(format!("feedback {found} ({:.1}, bound {:.1})", t.statistic, t.bound));
    }
    let _ = writeln!(text, "tests    on held-out residuals: {}", tests.join(", "));
    if let Some(response) = e.frequency_response.as_ref().filter(|r| r.compared > 0) {
        let _ = writeln!(
            text,
            "response model within the {:.0} % confidence of the measured one at {:.0} % of {} frequencies",
            100.0 * response.confidence,
            100.0 * response.within,
            response.compared
        );
    }
    if let Some(map) = &e.poles_and_zeros {
        let modes: Vec<String> = map.poles.iter().filter_map(mode).collect();
        let _ = writeln!(text, "modes    {}", modes.join(", "));
    }
    if !e.excitation.bands.is_empty() {
        let headers = ["excitation", "road wheel", "yaw rate", "explained", "gain known to", ""];
        let mut bands = report::Table::new(headers);
        for b in &e.excitation.bands {
            bands.push([
                format!("{} to {} Hz", b.from_hz, b.to_hz),
                format!("{:.3}°", b.road_wheel_std_rad.to_degrees()),
                format!("{:.3} °/s", b.yaw_rate_std_radps.to_degrees()),
                format!("{:.0} %", 100.0 * b.coherence),
                if b.information != Information::None {
                    format!("±{:.1} %", 100.0 * b.relative_error)
                } else {
                    "–".to_owned()
                },
                match b.information {
                    Information::Good => "good",
                    Information::Weak => "weak",
                    Information::None => "no information",
                }
                .to_owned(),
            ]);
        }
        let _ = write!(text, "\n{bands}\n");
    }
    text
}

/// A pole for people: its time constant, or frequency and damping.
fn mode(pole: &Mode) -> Option<String> {
    let (hz, damping) = (pole.natural_frequency_hz?, pole.damping?);
    if pole.discrete[1] != 0.0 {
        return Some(format!("{hz:.2} Hz (damping {damping:.2})"));
    }
    Some(pole.time_constant_s.map_or_else(|| "integrator".into(), |t| format!("{t:.3} s")))
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
