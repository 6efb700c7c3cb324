//! `steerwright absorb`: logs into a factor, in memory that does not grow with them.

use crate::Global;
use crate::console;
use crate::evidence::channel_table;
use crate::failure::{Failure, Outcome};
use crate::log_options::{LogArguments, input_kind, log_file};
use crate::output::{Kind, Outputs};
use crate::progress::Progress;
use formats::AbsorbedDrives;
use std::path::PathBuf;
use sysid::{AbsorbOptions, Absorbed, InputKind};

/// Absorb logs of any length into a small file, which `identify` takes in place of logs; files of many
/// machines are merged there as if all logs had been absorbed at once
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// CSV files with a header, read in chunks; each is a drive of its own and brings steering and yaw
    /// rate on one clock
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Write the factor here
    #[arg(long = "out", short = 'o', value_name = "FILE", default_value = "drives.factor")]
    out: PathBuf,
    /// Block rows of the Hankel matrices, the most that can be identified with later
    #[arg(long, value_name = "N", default_value_t = AbsorbOptions::default().horizon)]
    horizon: usize,
    /// What will drive the model: the steering angle, or its product with speed
    #[arg(long, value_name = "steering|steering*speed", default_value = "steering", value_parser = input_kind)]
    model_input: InputKind,
    #[command(flatten)]
    log: LogArguments,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    if !arguments.log.drives.is_empty() {
        return Err(Failure::new(
            "--drive: each file is read as a drive of its own here",
            "merge the channels of a drive into one CSV file, or identify from the files together: steerwright identify --drive A.csv,B.csv",
        ));
    }
    let out = Outputs::new(global.force, &arguments.logs)
        .file(&arguments.out, Kind::of::<AbsorbedDrives>())?;
    let options = AbsorbOptions {
        log: arguments.log.options(),
        input_kind: arguments.model_input,
        horizon: arguments.horizon,
    };
    let mut all: Option<Absorbed> = None;
    let progress = Progress::start("reading the logs");
    for path in &arguments.logs {
        progress.now(format!("reading {}", path.display()));
        let one = Absorbed::of_log(log_file(path, &progress)?, &options)?;
        match &mut all {
            Some(all) => all.merge(one)?,
            None => all = Some(one),
        }
    }
    drop(progress);
    let Some(all) = all else { return Err(drivelog::Error::NoFiles.into()) };
    let file = all.to_file();
    out.document(&file)?;
    let (estimation, held_out) = all.samples();
    let text = format!(
        "{}values in rad, rad/s and m/s\n\n{estimation} samples of {} s to estimate from, {held_out} held out, windows of {} samples\n",
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
