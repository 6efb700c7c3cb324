//! `steerwright accumulate`: the R factor of logs of any length, in bounded memory.

use crate::commands::identify::accumulated::{are_factors, check_factor_options, factor, merged};
use crate::documents::files;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::log::{LogArguments, log_file};
use crate::output::{OutputKind, Outputs};
use crate::terminal::console;
use crate::terminal::progress::Progress;
use std::path::{Path, PathBuf};
use steerwright_drivelog::Response;
use steerwright_formats::AccumulatedDrives;
use steerwright_report::channel_table;
use steerwright_sysid::{AccumulateOptions, Accumulated, InputKind};

/// Accumulate logs of any length into an R factor, a small file that `identify` accepts in place of logs
///
/// R factors, of several machines, are merged to one, or by `identify`; the model is that of all logs together. An R
/// factor whose logs are all in another counts once; two that share only some of their logs are an error.
#[derive(clap::Args)]
// What a factor does not hold is refused with its reason.
#[command(
    mut_arg("windows", |arg| arg.hide(true)),
    mut_arg("drives", |arg| arg.hide(true)),
    mut_arg("channels", |arg| arg.hide(true)),
    mut_arg("gnss_latency", |arg| arg.hide(true)),
    mut_arg("antenna_x", |arg| arg.hide(true))
)]
pub(crate) struct Arguments {
    /// Logs of any format, read in pieces; each is one drive, with steering and yaw rate. Or R factors
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// File of the R factor
    #[arg(long = "output", short = 'o', value_name = "FILE", default_value = "drives.rfactor")]
    out: PathBuf,
    /// Block rows of the Hankel matrices, the largest horizon for a later identification
    #[arg(long, value_name = "N", default_value_t = AccumulateOptions::default().horizon)]
    horizon: usize,
    /// Input of the model: the steering angle, or its product with the speed
    #[arg(long, value_name = InputKind::WORDS, default_value = "steering")]
    model_input: InputKind,
    #[command(flatten)]
    log: LogArguments,
}

impl Arguments {
    pub(crate) fn options(&self) -> Result<AccumulateOptions, Failure> {
        if !self.log.drives.is_empty() {
            return Err(Failure::new(
                "--drive: accumulate reads each file as one drive",
                "merge the channels of a drive into one CSV file, or identify from the files together: steerwright identify --drive A.csv,B.csv",
            ));
        }
        if self.log.gnss_latency.is_some() || self.log.antenna_x != 0.0 {
            return Err(Failure::new(
                "--gnss-latency and --antenna-x: an R factor holds no fixes",
                "for a model with sideslip, identify from the logs: steerwright identify LOG",
            ));
        }
        Ok(AccumulateOptions {
            log: self.log.options(Response::YawRate)?,
            input_kind: self.model_input,
            horizon: self.horizon,
        })
    }
}

/// The R factor of one log.
pub(crate) fn accumulate_drive(
    path: &Path,
    options: &AccumulateOptions,
    progress: &Progress,
) -> Result<Accumulated, Failure> {
    progress.now(format!("reading {}", path.display()));
    let file = files::of_one_log(path)?;
    Ok(Accumulated::of_log(log_file(&file, progress)?, options)?)
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let are_factors = are_factors(&arguments.logs)?;
    if are_factors {
        check_factor_options(&arguments.log, None)?;
    }
    let options = arguments.options()?;
    let out = Outputs::new(global.force, &arguments.logs)
        .file(&arguments.out, OutputKind::for_document::<AccumulatedDrives>())?;
    let progress = Progress::start("reading the logs");
    let all = merged(arguments.logs.iter().map(|path| {
        if are_factors { factor(path) } else { accumulate_drive(path, &options, &progress) }
    }))?;
    drop(progress);
    let file = all.to_file();
    out.document(&file)?;
    let (estimation, validation) = all.samples();
    let text = format!(
        "{}\n{estimation} estimation samples and {validation} validation samples of {} s, windows of {} samples\n",
        console::table(&channel_table(all.channels())),
        file.sample_time_s,
        2 * file.horizon
    );
    for warning in all.warnings() {
        console::warning(warning);
    }
    console::result(&text, &file)?;
    console::note(format!("written to {out}"));
    Ok(Outcome::Done)
}
