//! The structure `bicycle` compared with the black-box models on recorded drives: `cargo xtask evaluate
//! bicycle --data DIR`.
//!
//! Each drive is cut in half; one half estimates, the other validates, then the other way round. Fits
//! are 100·(1 − ‖y − ŷ‖/‖y − mean y‖) of simulations on yaw rate. The recording in DIR/revs cannot be
//! part of the repository.

use super::options;
use clap::Parser;
use std::path::{Path, PathBuf};
use steerwright_drivelog::{DriveLog, LogOptions, read_log};
use steerwright_evaluation::swapped_halves;
use steerwright_sysid::bicycle::{BicycleOptions, IdentifiedBicycle, identify_bicycle};
use steerwright_sysid::{IdentifyOptions, InputKind, identify};

#[derive(Parser)]
struct Arguments {
    /// Folder of recordings that are no part of the repository
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Sample times to bring the recording to, s
    #[arg(long, value_delimiter = ',', default_value = "0.02,0.04,0.05")]
    sample_times: Vec<f64>,
}

type Failure = Box<dyn std::error::Error>;

pub(crate) fn run() -> Result<(), Failure> {
    let arguments: Arguments = options();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    println!("Multi-body vehicle, 15 m/s (examples/drives/multibody)");
    let file = root.join("examples/drives/multibody/drive.csv");
    drive(&file, ["steering_command_rad", "yaw_rate_radps", "speed_mps"], 0.04)?;
    let Some(data) = arguments.data else {
        println!("left out: the Revs drive (state its folder with --data DIR)");
        return Ok(());
    };
    let file = data.join("revs/revs_250lm_first_300s_100hz.csv");
    for sample_time in arguments.sample_times {
        println!("\nRevs drive, {sample_time} s");
        drive(&file, ["roadwheel_angle_rad", "yaw_rate_radps", "vx_mps"], sample_time)?;
    }
    Ok(())
}

/// All models on both halves of a drive.
fn drive(file: &Path, columns: [&str; 3], sample_time: f64) -> Result<(), Failure> {
    let [input, output, speed] = columns.map(|c| Some(c.to_owned()));
    let options = LogOptions {
        input,
        output,
        speed,
        steering_ratio: Some(1.0),
        sample_time_s: Some(sample_time),
        ..LogOptions::default()
    };
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let log = read_log(&[(name, std::fs::read(file)?)], &options)?;
    let swapped = swapped_halves(&log);
    println!("{:<24}{:>12}{:>12}{:>12}{:>12}", "", "1st half", "on 2nd", "2nd half", "on 1st");
    let row = |name: &str, fits: [f64; 4]| {
        print!("{name:<24}");
        fits.iter().for_each(|f| print!("{f:>10.2} %"));
        println!();
    };
    let found = [bicycle(&log)?, bicycle(&swapped)?];
    let fits = found.each_ref().map(|f| f.bicycle.evidence.clone().unwrap_or_default());
    let [a, b] = &fits;
    let qualities = found.each_ref().map(|f| &f.bicycle.quality);
    row("bicycle", [a.estimation_fit, a.validation_fit, b.estimation_fit, b.validation_fit]);
    let [c, d] = [&a.with_delay, &b.with_delay];
    row(
        "bicycle with delay",
        [c.estimation_fit, c.validation_fit, d.estimation_fit, d.validation_fit],
    );
    for (name, kind) in
        [("black box δ", InputKind::Steering), ("black box δ·v", InputKind::SteeringTimesSpeed)]
    {
        let [a, b] = [black_box(&log, kind)?, black_box(&swapped, kind)?];
        row(name, [a.0, a.1, b.0, b.1]);
    }
    println!("\n{:<32}{:>26}{:>26}", "identified by the", "1st half", "2nd half");
    for (i, q) in a.identified.iter().enumerate() {
        let shown = |value: f64, error: f64| format!("{value:.5} ± {error:.5}");
        // Where one understeers and the other oversteers, there is nothing to compare.
        let other = b.identified.get(i).filter(|o| o.name == q.name);
        println!(
            "{:<32}{:>26}{:>26}",
            format!("{} [{}]", q.name, q.unit),
            shown(q.value, q.standard_error),
            other.map(|o| shown(o.value, o.standard_error)).unwrap_or_default()
        );
    }
    for ((half, e), quality) in [("1st", a), ("2nd", b)].into_iter().zip(qualities) {
        println!(
            "{half} half: delay {:.4} ± {:.4} s, errors last {:.1} s, {}",
            e.with_delay.input_delay_s,
            e.with_delay.standard_error_s,
            e.error_correlation_time_s,
            quality.summary
        );
    }
    Ok(())
}

fn bicycle(log: &DriveLog) -> Result<IdentifiedBicycle, Failure> {
    Ok(identify_bicycle(log, &BicycleOptions::default())?)
}

/// Fits of the identified state-space model with everything chosen by itself.
fn black_box(log: &DriveLog, input_kind: InputKind) -> Result<(f64, f64), Failure> {
    let options = IdentifyOptions { input_kind, ..IdentifyOptions::default() };
    let fit = identify(log, &options)?.plant.evidence.fit;
    Ok((fit.estimation, fit.validation))
}
