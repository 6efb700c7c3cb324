//! The single-track model on the Revs recording: `cargo xtask evaluate single_track FILE`.

use super::options;
use clap::Parser;
use std::path::{Path, PathBuf};
use std::time::Instant;
use steerwright_sysid::single_track::{
    Drive, DriveSegment, Parameter, Prior, SimulationFit, SingleTrackOptions, identify_single_track,
};

#[derive(Parser)]
struct Arguments {
    /// The recording, revs_250lm_first_300s_100hz.csv
    file: Option<PathBuf>,
    /// Leave out lateral acceleration
    #[arg(long)]
    yaw_rate_only: bool,
    #[arg(long)]
    swap: bool,
    /// name=mean,sd
    #[arg(long)]
    prior: Vec<String>,
}

pub(crate) fn run() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Arguments = options();
    let Some(file) = arguments.file else { return Ok(()) };
    let mut halves = read(&file, arguments.yaw_rate_only)?;
    if arguments.swap {
        halves.reverse();
    }
    let [estimation, validation] = halves;
    let mut o = SingleTrackOptions::default();
    for p in &arguments.prior {
        let (name, rest) = p.split_once('=').ok_or("=")?;
        let (mean, sd) = rest.split_once(',').ok_or(",")?;
        let parameter =
            *Parameter::ALL.iter().find(|p| p.name() == name).ok_or(format!("no {name}"))?;
        let prior = parameter.default_prior();
        o.priors.push((
            parameter,
            Prior { mean: mean.parse()?, standard_deviation: sd.parse()?, ..prior },
        ));
    }
    let start = Instant::now();
    let found = identify_single_track(&estimation, Some(&validation), &o)?;
    let seconds = start.elapsed().as_secs_f64();
    for p in &found.parameters {
        println!(
            "{:<40} {:>12.5} ± {:<9.5} {:<6} prior {:>8.4} ± {:<8.4} ratio {:.2}{}{}",
            p.parameter.name(),
            p.value,
            p.standard_error,
            p.parameter.unit(),
            p.prior.mean,
            p.prior.standard_deviation,
            p.posterior_per_prior,
            if p.is_determined { " determined" } else { "" },
            if p.is_at_bound { " at bound" } else { "" },
        );
    }
    print("estimation", &found.estimation);
    if let Some(validation) = &found.validation {
        print("validation", validation);
    }
    println!(
        "spin margin {} %, initial estimates {:?}, {seconds:.1} s",
        100.0 * found.spin_margin,
        found.initial_estimates
    );
    Ok(())
}

fn print(name: &str, fit: &SimulationFit) {
    println!(
        "{name}: yaw rate {:.2} %, lateral acceleration {:.2} %, sideslip RMS error {:.3}° of {:.3}°, worst window {:.3} rad/s",
        fit.yaw_rate,
        fit.lateral_acceleration.unwrap_or(f64::NAN),
        fit.sideslip_rms_error_rad.unwrap_or(f64::NAN).to_degrees(),
        fit.sideslip_rms_rad.unwrap_or(f64::NAN).to_degrees(),
        fit.worst_window_radps
    );
}

fn read(file: &Path, yaw_rate_only: bool) -> Result<[Drive; 2], Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(file)?;
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|l| l.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>())
        .collect::<Result<_, _>>()?;
    let column = |name: &str, rows: &[Vec<f64>]| -> Result<Vec<f64>, String> {
        let at = names.iter().position(|n| *n == name).ok_or(format!("no column {name}"))?;
        Ok(rows.iter().map(|r| r[at]).collect())
    };
    let drive = |rows: &[Vec<f64>]| -> Result<Drive, String> {
        Ok(Drive {
            sample_time_s: 0.01,
            steering_ratio: 1.0,
            segments: vec![DriveSegment {
                steering_rad: column("roadwheel_angle_rad", rows)?,
                speed_mps: column("vx_mps", rows)?,
                yaw_rate_radps: column("yaw_rate_radps", rows)?,
                lateral_acceleration_mps2: if yaw_rate_only {
                    None
                } else {
                    Some(column("ay_mps2", rows)?)
                },
                longitudinal_acceleration_mps2: Some(column("ax_mps2", rows)?),
                lateral_velocity_mps: Some(column("vy_mps", rows)?),
            }],
        })
    };
    let half = rows.len() / 2;
    Ok([drive(&rows[..half])?, drive(&rows[half..])?])
}
