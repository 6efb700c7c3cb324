//! The single-track model on known cars and on a recording: `cargo xtask evaluate single_track`.
//!
//! Cars drawn from the priors are driven up to the limit of grip, over a road whose bank disturbs them, and
//! recorded with noise; printed is how often the stated 95 % bands hold the truth. The recording, of a race
//! car, cannot be part of the repository: its first half estimates and its second half validates by free
//! simulation, then the other way round.

use super::options;
use clap::Parser;
use std::path::{Path, PathBuf};
use std::time::Instant;
use steerwright_evaluation::limit_drive::{LimitDrive, random_car};
use steerwright_evaluation::{Random, on_all_cores};
use steerwright_sysid::single_track::{
    Drive, DriveSegment, Parameter, SimulationFit, SingleTrack, SingleTrackModel,
    SingleTrackOptions, identify_single_track,
};

#[derive(Parser)]
struct Arguments {
    /// A recording with the columns of revs_250lm_first_300s_100hz.csv
    file: Option<PathBuf>,
    /// Simulated drives
    #[arg(long, default_value_t = 20)]
    drives: usize,
    /// Largest lateral acceleration that the driver asks for, over that of the front axle's peak
    #[arg(long, default_value_t = 0.9)]
    grip: f64,
    /// Deviation of the lateral acceleration by the road's bank, m/s²
    #[arg(long, default_value_t = 0.1)]
    bank: f64,
    /// Seed of the cars and drives
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print every parameter of every drive
    #[arg(long)]
    verbose: bool,
}

type Failure = Box<dyn std::error::Error>;

pub(crate) fn run() -> Result<(), Failure> {
    let arguments: Arguments = options();
    if arguments.drives > 0 {
        coverage(&arguments)?;
    }
    match &arguments.file {
        Some(file) => recording(file),
        None => {
            println!("left out: the recording (state its file)");
            Ok(())
        }
    }
}

/// A car whose free simulation follows its own drive worse is not stable without a driver, %.
const STABLE_FIT: f64 = 90.0;

/// A known car with its estimate.
struct Case {
    car: SingleTrackModel,
    truth: SimulationFit,
    found: Result<SingleTrack, steerwright_sysid::Error>,
    seconds: f64,
}

fn coverage(arguments: &Arguments) -> Result<(), Failure> {
    let mut random = Random(arguments.seed);
    let (mut drives, mut left_out) = (Vec::new(), 0);
    while drives.len() < arguments.drives {
        let car = random_car(&mut random);
        let seed = (1e9 * random.uniform()) as u64;
        let estimation = LimitDrive {
            grip_used: arguments.grip,
            bank_mps2: arguments.bank,
            ..LimitDrive::new(car, seed)
        };
        let validation = LimitDrive { seed: seed + 1, ..estimation.clone() };
        let drive = estimation.record().zip(validation.record());
        match drive.map(|d| (car.validate(&d.0), d)) {
            Some((Ok(truth), d)) if truth.yaw_rate > STABLE_FIT => drives.push((car, truth, d)),
            _ => left_out += 1,
        }
    }
    let cases = on_all_cores("drives", drives.len(), |k| {
        let (car, truth, (estimation, validation)) = &drives[k];
        let begun = Instant::now();
        let options = SingleTrackOptions::default();
        let found = identify_single_track(estimation, Some(validation), &options);
        Case { car: *car, truth: *truth, found, seconds: begun.elapsed().as_secs_f64() }
    });
    println!(
        "{} cars from the priors, 120 s each; {left_out} others spin or are unstable without a driver",
        cases.len()
    );
    for (k, case) in cases.iter().enumerate() {
        match &case.found {
            Ok(found) => {
                println!(
                    "{k:>3}: estimation {:.2} % (the true car {:.2} %), validation {:.2} %, spin margin {:.2}, {:.1} s",
                    found.estimation.yaw_rate,
                    case.truth.yaw_rate,
                    found.validation.map_or(f64::NAN, |v| v.yaw_rate),
                    found.spin_margin,
                    case.seconds
                );
                if arguments.verbose {
                    parameters(found, Some(&case.car));
                }
            }
            Err(error) => println!("{k:>3}: {error} (the true car {:.2} %)", case.truth.yaw_rate),
        }
    }
    bands(&cases);
    Ok(())
}

/// How often the bands hold the truth.
fn bands(cases: &[Case]) {
    println!(
        "{:<42}{:>12}{:>10}{:>10}{:>28}",
        "95 % band of", "holds", "mean z", "RMS z", "posterior/prior (median)"
    );
    let found: Vec<_> =
        cases.iter().filter_map(|c| Some((c.car, c.found.as_ref().ok()?))).collect();
    let (mut held, mut all) = (0, 0);
    for parameter in Parameter::ALL {
        let estimates: Vec<_> = found
            .iter()
            .map(|(car, f)| (car.get(parameter), f.parameter(parameter)))
            .filter(|(_, p)| p.standard_error > 0.0)
            .collect();
        if estimates.is_empty() {
            continue;
        }
        let count = estimates.len() as f64;
        let holds = |(t, p): &&(f64, &_)| {
            let p: &steerwright_sysid::single_track::ParameterEstimate = p;
            p.band_95[0] <= *t && *t <= p.band_95[1]
        };
        let inside = estimates.iter().filter(holds).count();
        let scores: Vec<f64> =
            estimates.iter().map(|(t, p)| (p.value - t) / p.standard_error).collect();
        let mut ratios: Vec<f64> = estimates.iter().map(|(_, p)| p.posterior_per_prior).collect();
        ratios.sort_by(f64::total_cmp);
        println!(
            "{:<42}{:>10.1} %{:>10.2}{:>10.2}{:>28.3}",
            parameter.name(),
            100.0 * inside as f64 / count,
            scores.iter().sum::<f64>() / count,
            (scores.iter().map(|z| z * z).sum::<f64>() / count).sqrt(),
            ratios[ratios.len() / 2]
        );
        held += inside;
        all += estimates.len();
    }
    println!("{:<42}{:>10.1} %\n", "all", 100.0 * held as f64 / all.max(1) as f64);
}

/// What of a recording is used; the lateral velocity is only compared.
const SIGNALS: [&str; 2] = ["yaw rate and lateral acceleration", "yaw rate"];

fn recording(file: &Path) -> Result<(), Failure> {
    let mut halves = read(file)?;
    for half in ["first half", "second half"] {
        for signals in SIGNALS {
            let [mut estimation, mut validation] = halves.clone();
            for segment in estimation.segments.iter_mut().chain(&mut validation.segments) {
                if signals != SIGNALS[0] {
                    segment.lateral_acceleration_mps2 = None;
                }
            }
            let begun = Instant::now();
            let options = SingleTrackOptions::default();
            let found = identify_single_track(&estimation, Some(&validation), &options)?;
            let seconds = begun.elapsed().as_secs_f64();
            println!("estimated on {signals} of the {half}, in {seconds:.1} s");
            print("  estimation", &found.estimation);
            if let Some(fit) = &found.validation {
                print("  validation", fit);
            }
            let [refined, followed, same] = found.initial_estimates;
            println!(
                "  spin margin {:.2}; of {refined} initial estimates {followed} followed the drive and {same} reached this minimum",
                found.spin_margin
            );
            parameters(&found, None);
        }
        halves.reverse();
    }
    Ok(())
}

/// All parameters that are not fixed, with the truth where it is known.
fn parameters(found: &SingleTrack, truth: Option<&SingleTrackModel>) {
    for p in found.parameters.iter().filter(|p| p.standard_error > 0.0) {
        let name = p.parameter.name();
        let known = truth.map(|t| t.get(p.parameter));
        println!(
            "  {name:<40}{:>11.5} ± {:<9.5}{:<6} ratio {:.2}{}{}{}",
            p.value,
            p.standard_error,
            p.parameter.unit(),
            p.posterior_per_prior,
            if p.is_determined { "  determined" } else { "" },
            if p.is_at_bound { "  at a bound" } else { "" },
            known.map_or(String::new(), |t| {
                format!("  truth {t:.5}, z {:.2}", (p.value - t) / p.standard_error)
            }),
        );
    }
}

fn print(name: &str, fit: &SimulationFit) {
    let percent = |fit: Option<f64>| fit.map_or("none".into(), |f| format!("{f:.2} %"));
    let degrees = |angle: Option<f64>| angle.unwrap_or(f64::NAN).to_degrees();
    println!(
        "{name}: yaw rate {:.2} %, lateral acceleration {}, sideslip RMS error {:.3}° of {:.3}°, worst 5 s {:.3} rad/s",
        fit.yaw_rate,
        percent(fit.lateral_acceleration),
        degrees(fit.sideslip_rms_error_rad),
        degrees(fit.sideslip_rms_rad),
        fit.worst_window_radps
    );
}

/// The halves of a recording.
fn read(file: &Path) -> Result<[Drive; 2], Failure> {
    let text = std::fs::read_to_string(file)?;
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(str::parse).collect::<Result<_, _>>())
        .collect::<Result<_, _>>()?;
    let drive = |rows: &[Vec<f64>]| -> Result<Drive, String> {
        let column = |name: &str| -> Result<Vec<f64>, String> {
            let at = names.iter().position(|n| *n == name);
            let at = at.ok_or(format!("{}: there is no column {name}", file.display()))?;
            rows.iter()
                .map(|row| row.get(at).copied().ok_or(format!("a row has no {name}")))
                .collect()
        };
        let time = column("t_s")?;
        let [first, .., last] = time.as_slice() else { return Err("there are no rows".into()) };
        Ok(Drive {
            sample_time_s: (last - first) / (time.len() - 1) as f64,
            steering_ratio: 1.0,
            steering_delay_s: 0.0,
            segments: vec![DriveSegment {
                steering_rad: column("roadwheel_angle_rad")?,
                speed_mps: column("vx_mps")?,
                yaw_rate_radps: column("yaw_rate_radps")?,
                lateral_acceleration_mps2: Some(column("ay_mps2")?),
                lateral_velocity_mps: Some(column("vy_mps")?),
                ..DriveSegment::default()
            }],
        })
    };
    let half = rows.len() / 2;
    Ok([drive(&rows[..half])?, drive(&rows[half..])?])
}
