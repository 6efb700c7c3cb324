//! `steerwright identify`: the plant in a drive log.

use crate::evidence::{evidence, plots};
use crate::failure::{Failure, Outcome};
use crate::files;
use crate::identify_bicycle::{self, BicycleArguments};
use crate::identify_factor;
use crate::log_options::{IdentifyArguments, LogArguments};
use crate::tell::Tell;
use formats::Plant;
use std::fmt::Write;
use std::path::PathBuf;
use sysid::Traces;

/// Identify the lateral dynamics in a drive log: steering angle in, yaw rate out
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// CSV files with a header, each with a clock of its own: drives where each brings steering and yaw
    /// rate, else the channels of one drive. Or factors written by `absorb`, which are merged
    #[arg(required_unless_present = "drives", value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Write the model here: by default plant.json, of the structure bicycle bicycle.json
    #[arg(long = "out", short = 'o', value_name = "FILE")]
    out: Option<PathBuf>,
    /// Also write measured and simulated signals as CSV
    #[arg(long, value_name = "CSV")]
    traces: Option<PathBuf>,
    /// Also draw the evidence, as SVG files in this folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Also write the evidence with its figures as one HTML page
    #[arg(long, value_name = "HTML")]
    report: Option<PathBuf>,
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
    let traces = arguments.traces.as_deref();
    let out = |default: &str| arguments.out.clone().unwrap_or_else(|| default.into());
    if identify_factor::are_factors(&arguments.logs)? {
        let asked = [
            ("--structure bicycle", arguments.bicycle.options(&arguments.identify)?.is_some()),
            ("--traces", traces.is_some()),
            ("--plots", arguments.plots.is_some()),
            ("--report", arguments.report.is_some()),
        ];
        if let Some((option, _)) = asked.iter().find(|(_, asked)| *asked) {
            return Err(Failure::new(
                format!("{option}: a factor holds no signals"),
                "identify from the log itself, or leave it out",
            ));
        }
        let (log, identify) = (&arguments.log, &arguments.identify);
        let out = out("plant.json");
        return identify_factor::run(&arguments.logs, log, identify, &out, arguments.json);
    }
    let log = arguments.log.read(&arguments.logs)?;
    if let Some(options) = arguments.bicycle.options(&arguments.identify)? {
        let drawn = [("--plots", &arguments.plots), ("--report", &arguments.report)];
        if let Some((name, _)) = drawn.iter().find(|(_, path)| path.is_some()) {
            let message = format!("{name} is an option of the structure state-space");
            return Err(Failure::new(message, "leave it out; --traces writes the signals as CSV"));
        }
        let out = out("bicycle.json");
        return identify_bicycle::run(&log, &options, &out, traces, arguments.json);
    }
    let out = out("plant.json");
    let identified = sysid::identify(&log, &arguments.identify.options())?;
    files::write_document(&out, &identified.plant)?;
    let csv = traces_csv(&identified.traces, None);
    if let Some(traces) = traces {
        files::write(traces, csv.as_bytes())?;
    }
    let mut text = format!("{}\nwritten to {}", evidence(&identified.plant), out.display());
    text += &show(arguments, &identified.plant, &csv)?;
    Tell::new(arguments.json).result(&text, &identified.plant)?;
    Ok(Outcome::of(&identified.plant.quality))
}

/// Draws what was asked for; the places it was written to, for people.
fn show(arguments: &Arguments, plant: &Plant, csv: &str) -> Result<String, Failure> {
    let mut text = String::new();
    if arguments.plots.is_none() && arguments.report.is_none() {
        return Ok(text);
    }
    let traces = report::Traces::from_csv(csv.as_bytes(), "traces")?;
    if let Some(folder) = &arguments.plots {
        plots(plant, &traces, folder)?;
        let _ = write!(text, "\nfigures in {}", folder.display());
    }
    if let Some(path) = &arguments.report {
        let page = report::Report {
            title: format!("{}: the identified model", plant.name),
            plant: Some(plant),
            traces: Some(&traces),
            ..report::Report::default()
        };
        files::write(path, page.to_html().as_bytes())?;
        let _ = write!(text, "\nreport in {}", path.display());
    }
    Ok(text)
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
