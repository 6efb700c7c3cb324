//! `cargo xtask evaluate large`: `identify` with all its choices and evidence on a recording of a
//! million samples, in processor time and peak memory, compared with what the recording itself takes.

use super::options;
use clap::Parser;
use steerwright_drivelog::{DriveLog, LogOptions};
use steerwright_evaluation::Drive;
use steerwright_evaluation::measure::{peak_memory, processor_time_s};
use steerwright_sysid::IdentifyOptions;

/// `identify` on a long recording.
#[derive(Parser)]
struct Arguments {
    /// Samples, of 0.04 s
    #[arg(long, default_value_t = 1_000_000)]
    samples: usize,
    /// Order of the model, or all that are tried
    #[arg(long)]
    order: Option<usize>,
    /// Leave the delay at zero
    #[arg(long)]
    no_delay: bool,
    /// Leave the refinement by simulation errors out
    #[arg(long)]
    no_refinement: bool,
}

pub(crate) fn run() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Arguments = options();
    let log = recording(arguments.samples)?;
    let held = peak_memory().ok_or("the system does not report the peak memory")?;
    let options = IdentifyOptions {
        order: arguments.order,
        delay_s: if arguments.no_delay { Some(0.0) } else { None },
        refine: !arguments.no_refinement,
        ..IdentifyOptions::default()
    };
    let start = processor_time_s();
    let found = steerwright_sysid::identify(&log, &options)?;
    let seconds = processor_time_s() - start;
    let peak = peak_memory().unwrap_or_default();
    let channel = 8e-6 * arguments.samples as f64;
    println!(
        "{} samples (a channel of them is {channel:.1} MB): {:.1} MB with the recording loaded, {:.1} MB more at the peak of identify, that is {:.1} channels",
        log.len(),
        held * 1e-6,
        (peak - held) * 1e-6,
        (peak - held) * 1e-6 / channel
    );
    println!(
        "{seconds:.2} s of processor time; order {}, validation fit {:.3} %",
        found.plant.order(),
        found.plant.evidence.fit.validation
    );
    Ok(())
}

/// A recording without a file: the reader's own cost is measured by `command_line`.
fn recording(samples: usize) -> Result<DriveLog, steerwright_sysid::Error> {
    let drive = |samples| {
        Drive { sample_time: 0.04, delay: 0.0, servo: 0.05, noise: 0.002, seed: 1 }.record(samples)
    };
    // The head of a short file, with the long signals in it.
    let short = [("drive.csv".to_owned(), drive(500).csv().into_bytes())];
    let mut log = steerwright_drivelog::read_log(&short, &LogOptions::default())?;
    let long = drive(samples);
    log.speed = Some(vec![15.0; samples]);
    log.segments = vec![steerwright_drivelog::Segment { time0_s: 0.0, range: 0..samples }];
    (log.input, log.output) = (long.steering, long.yaw_rate);
    Ok(log)
}
