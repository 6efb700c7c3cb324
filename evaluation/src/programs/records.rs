//! Recorded data with automatic settings, first half to second half, compared with the results of
//! others.

use super::options;
use clap::Parser;
use faer::Mat;
use std::path::{Path, PathBuf};
use steerwright_drivelog::{DriveLog, LogFile, LogOptions, read_drives, read_log};
use steerwright_evaluation::{halves, pole_distance, recording, request, response_distance};
use steerwright_sysid::subspace::{Factor, shift_realization, structured_bd, subspace};
use steerwright_sysid::{
    DataSet, IdentifyOptions, InputKind, StateSpace, ValidationData, Weighting, automatic, identify,
};

/// Prints how well recorded data are reproduced with automatic settings.
#[derive(Parser)]
struct Arguments {
    /// Folder of the recordings that are not in the repository: revs, daisy
    #[arg(long)]
    data: Option<PathBuf>,
}

const INPUTS: [(&str, InputKind); 2] =
    [("δ", InputKind::Steering), ("δ·v", InputKind::SteeringTimesSpeed)];
const PEERS: &str = include_str!("../../python/records.py");

pub(crate) fn run() -> Result<(), String> {
    let arguments: Arguments = options();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/drives");
    slicots_model(&own)?;
    println!("\nautomatic settings, estimated on the first half, simulated on the second");
    println!(
        "  {:<16}{:>6}{:>9}{:>4}{:>12}{:>11}{:>12}",
        "set", "order", "horizon", "D", "estimation", "validation", "target"
    );
    let dryer = own.join("dryer2/dryer2_slicot_ib01ad.csv");
    row("dryer2", &recording(&dryer, &["u"], &["y"], 0.08)?, 85.7)?;
    match &arguments.data {
        Some(folder) => {
            let daisy = |name: &str, u: &[&str], y: &[&str]| {
                recording(&folder.join("daisy").join(name), u, y, 1.0)
            };
            // The targets are what Octave's n4sid reaches with the settings of its user's choice.
            let robot = daisy("robot_arm.csv", &["reaction_torque"], &["acceleration"])?;
            row("robot_arm", &robot, 94.4)?;
            let exchanger = daisy("exchanger.csv", &["flow_rate"], &["outlet_temperature"])?;
            row("exchanger", &exchanger, 48.2)?;
            let outputs = ["tracking_error_1", "tracking_error_2"];
            let player = daisy("CD_player_arm.csv", &["force_1", "force_2"], &outputs)?;
            row("CD_player_arm", &player, 64.1)?;
            revs(&folder.join("revs/revs_250lm_first_300s_100hz.csv"))?;
        }
        None => println!("  left out: the sets of DaISy and the Revs drive (--data DIR)"),
    }
    scale_car(&own.join("dart"))?;
    weak_drive(&own.join("comma2k19"))
}

/// SLICOT's combined method on all of dryer2, from its package in the same run.
fn slicots_model(own: &Path) -> Result<(), String> {
    let file = own.join("dryer2/dryer2_slicot_ib01ad.csv");
    let data = recording(&file, &["u"], &["y"], 0.08)?;
    let ours = || -> Result<StateSpace, steerwright_sysid::Error> {
        let factor = Factor::new(&data, 15)?;
        let sub = subspace(&factor, Weighting::Moesp)?;
        let (a, c) = shift_realization(&sub, 4, 1)?;
        structured_bd(&factor, &sub, a.as_ref(), c.as_ref(), true)
    };
    let ours = ours().map_err(|e| e.to_string())?;
    println!("dryer2, SLICOT's combined method, n = 4, 15 block rows, feedthrough");
    let text = std::fs::read_to_string(own.join("dryer2/slicot_ib01bd_result.txt"))
        .map_err(|e| e.to_string())?;
    let printed = |title: &str| -> Vec<f64> {
        let after = text.lines().skip_while(|l| !l.contains(title)).skip(1);
        after
            .take_while(|l| !l.trim().is_empty())
            .flat_map(str::split_whitespace)
            .filter_map(|x| x.parse().ok())
            .collect()
    };
    let printed = [
        printed("state matrix A"),
        printed("input matrix B"),
        printed("output matrix C"),
        printed("input-output matrix D"),
    ];
    let compare = |name: &str, one: &StateSpace, theirs: &StateSpace| {
        println!(
            "  {name:<44} poles differ by {:.1e}, the frequency response by {:.1e}",
            pole_distance(one, theirs),
            response_distance(theirs, one)
        );
    };
    let printed = model(&printed)?;
    compare("ours and SLICOT's as printed", &ours, &printed);
    let arguments = ["1000", "combined", "15", "4"].map(str::to_owned);
    match request(PEERS, &numbers(&data), &arguments) {
        Ok(lines) => {
            let blocks: Vec<Vec<f64>> = lines.iter().map(|l| parsed(l)).collect();
            let theirs = model(&blocks)?;
            compare("ours and ctrlsys in this run", &ours, &theirs);
            // The effect of rounding to four decimals.
            compare("ctrlsys in this run and SLICOT's as printed", &theirs, &printed);
        }
        Err(problem) => println!("  left out: ctrlsys: {problem}"),
    }
    Ok(())
}

/// One output, one input, A, B, C, D row by row.
fn model(blocks: &[Vec<f64>]) -> Result<StateSpace, String> {
    let [a, b, c, d] = blocks else { return Err("expected A, B, C and D".into()) };
    let n = b.len();
    if (a.len(), c.len(), d.len()) != (n * n, n, 1) {
        return Err("the shapes of A, B, C and D do not fit".into());
    }
    Ok(StateSpace {
        a: Mat::from_fn(n, n, |i, j| a[i * n + j]),
        b: Mat::from_fn(n, 1, |i, _| b[i]),
        c: Mat::from_fn(1, n, |_, j| c[j]),
        d: Mat::from_fn(1, 1, |_, _| d[0]),
    })
}

fn row(name: &str, data: &DataSet, target: f64) -> Result<(), String> {
    let [estimation, validation] = halves(data).map_err(|e| e.to_string())?;
    let found = automatic(&estimation, &validation, &IdentifyOptions::default())
        .map_err(|e| e.to_string())?;
    let direct = if found.model.d.norm_max() > 0.0 { "yes" } else { "no" };
    print!(
        "  {name:<16}{:>6}{:>9}{direct:>4}{:>12.2}{:>11.2}{target:>12.1}",
        found.model.order(),
        found.horizon,
        found.estimation_fit,
        found.validation_fit,
    );
    if found.validation_fits.len() > 1 {
        let each: Vec<String> = found.validation_fits.iter().map(|f| format!("{f:.1}")).collect();
        print!("   each output: {}", each.join(", "));
    }
    println!();
    Ok(())
}

/// The drive on a race track: automatic settings compared with output-error models, and all of 48
/// settings.
fn revs(file: &Path) -> Result<(), String> {
    let log = drive(file, None)?;
    for (name, kind) in INPUTS {
        let options = IdentifyOptions { input_kind: kind, ..IdentifyOptions::default() };
        let plant = identify(&log, &options).map_err(|e| e.to_string())?.plant;
        let mut theirs: Vec<f64> = Vec::new();
        for order in 2..=4 {
            let what = ["oe".to_owned(), order.to_string()];
            match request_parts(&log, kind, 0.5, &what) {
                Ok(fits) => theirs.extend(fits.get(1)),
                Err(problem) => println!("  left out: output error: {problem}"),
            }
        }
        let e = &plant.evidence;
        println!(
            "  {:<16}{:>6}{:>9}{:>4}{:>12.2}{:>11.2}{:>12.2}   output-error models of order 2, 3, 4 in this run: {}",
            format!("Revs, {name}"),
            plant.order(),
            e.horizon,
            if plant.discrete.d.entry(0, 0) == 0.0 { "no" } else { "yes" },
            e.fit.estimation,
            e.fit.validation,
            theirs.first().map_or(f64::NAN, |fit| fit - 0.3),
            theirs.iter().map(|f| format!("{f:.2}")).collect::<Vec<_>>().join(", ")
        );
    }
    println!(
        "\nRevs, every setting: horizon 15, 30, 60, 100; order 2, 4, 6; 0.02 and 0.05 s; δ and δ·v"
    );
    let (mut refined, mut plain) = (Tally::default(), Tally::default());
    let (mut slicot, mut left_out) = (Tally::default(), None);
    for step in [0.02, 0.05] {
        let log = drive(file, Some(step))?;
        for (_, kind) in INPUTS {
            for horizon in [15, 30, 60, 100] {
                for order in [2, 4, 6] {
                    for (refine, tally) in [(true, &mut refined), (false, &mut plain)] {
                        let options = IdentifyOptions {
                            input_kind: kind,
                            order: Some(order),
                            horizon: Some(horizon),
                            refine,
                            ..IdentifyOptions::default()
                        };
                        let plant = identify(&log, &options).map_err(|e| e.to_string())?.plant;
                        let a = &plant.discrete.a;
                        let n = plant.order();
                        let a = Mat::from_fn(n, n, |i, j| a.entry(i, j));
                        let blank = |r, c| Mat::zeros(r, c);
                        let radius =
                            StateSpace { a, b: blank(n, 1), c: blank(1, n), d: blank(1, 1) }
                                .spectral_radius();
                        let fit = plant.evidence.fit;
                        tally.add(radius, fit.estimation, fit.validation);
                        let lost = plant.evidence.warnings.iter();
                        for warning in lost.filter(|w| !refine && w.contains("stabilised")) {
                            println!("    {step} s, horizon {horizon}, order {order}: {warning}");
                        }
                    }
                    let what = ["n4sid".to_owned(), horizon.to_string(), order.to_string()];
                    match request_parts(&log, kind, 0.5, &what).as_deref() {
                        Ok([radius, fits @ ..]) if fits.len() == 2 => {
                            slicot.add(*radius, fits[0], fits[1]);
                        }
                        Ok(_) => slicot.failed += 1,
                        Err(problem) => {
                            slicot.failed += 1;
                            left_out = Some(problem.to_owned());
                        }
                    }
                }
            }
        }
    }
    refined.print("refined (the default)");
    plain.print("subspace alone");
    slicot.print("SLICOT (ctrlsys), N4SID");
    if let Some(problem) = left_out {
        println!("  (of SLICOT's, some failed: {problem})");
    }
    Ok(())
}

/// What came of many settings.
#[derive(Default)]
struct Tally {
    settings: usize,
    unstable: usize,
    negative: usize,
    failed: usize,
    validation: Vec<f64>,
}

impl Tally {
    fn add(&mut self, radius: f64, estimation: f64, validation: f64) {
        self.settings += 1;
        self.unstable += usize::from(radius >= 1.0);
        self.negative += usize::from(!(estimation >= 0.0 && validation >= 0.0));
        self.validation.push(validation);
    }

    fn print(&self, name: &str) {
        let least = self.validation.iter().copied().fold(f64::INFINITY, f64::min);
        let most = self.validation.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // An unstable simulation may fit by minus any number.
        let least = if least < -1e3 { format!("{least:.0e}") } else { format!("{least:.1}") };
        println!(
            "  {name:<26} {} settings: {} unstable, {} with a negative fit, {} failed; validation fits from {least} to {most:.1} %",
            self.settings, self.unstable, self.negative, self.failed
        );
    }
}

fn drive(file: &Path, sample_time_s: Option<f64>) -> Result<DriveLog, String> {
    let bytes = std::fs::read(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let options = LogOptions {
        input: Some("roadwheel_angle_rad".into()),
        output: Some("yaw_rate_radps".into()),
        speed: Some("vx_mps".into()),
        steering_ratio: Some(1.0),
        sample_time_s,
        ..LogOptions::default()
    };
    read_log(&[("revs.csv".to_owned(), bytes)], &options).map_err(|e| e.to_string())
}

/// What a peer answers for the same parts as ours.
fn request_parts(
    log: &DriveLog,
    kind: InputKind,
    validation: f64,
    what: &[String],
) -> Result<Vec<f64>, String> {
    let ones = vec![1.0; log.len()];
    let factor = match (kind, &log.speed) {
        (InputKind::SteeringTimesSpeed, Some(speed)) => speed,
        _ => &ones,
    };
    let mut numbers: Vec<f64> = log.input.iter().zip(factor).map(|(u, v)| u * v).collect();
    numbers.extend(&log.output);
    let split = log.len() - (validation * log.len() as f64).round() as usize;
    let arguments: Vec<String> =
        std::iter::once(split.to_string()).chain(what.iter().cloned()).collect();
    let lines = request(PEERS, &numbers, &arguments)?;
    Ok(lines.first().map(|l| parsed(l)).unwrap_or_default())
}

/// A scale car, estimated on its first drive and validated on its second, as the demo reads them.
fn scale_car(folder: &Path) -> Result<(), String> {
    const VALIDATION: f64 = 0.4085;
    println!(
        "\ndart: estimated on the first drive, fit on the second, and SciPy's output error of order 2"
    );
    for step in [0.02, 0.05] {
        let options = LogOptions {
            time: Some("vicon time".into()),
            input: Some("steering".into()),
            output: Some("vicon yaw".into()),
            speed: Some("vel encoder".into()),
            units: [
                ("vicon time", "s"),
                ("steering", "1"),
                ("vicon yaw", "rad"),
                ("vel encoder", "m/s"),
            ]
            .map(|(column, unit)| (column.to_owned(), unit.to_owned()))
            .into(),
            steering_ratio: Some(1.0),
            steering_full_scale_rad: Some(0.375),
            sample_time_s: Some(step),
            ..LogOptions::default()
        };
        let read = |name: &str| {
            let bytes = std::fs::read(folder.join(name)).map_err(|e| e.to_string())?;
            Ok::<_, String>(vec![LogFile::of_bytes(name, &bytes)])
        };
        let drives = vec![read("estimation.csv")?, read("validation.csv")?];
        let log = read_drives(Vec::new(), drives, &options).map_err(|e| e.to_string())?;
        for (name, kind) in INPUTS {
            let options = IdentifyOptions {
                input_kind: kind,
                validation: ValidationData { fraction: VALIDATION, ..ValidationData::default() },
                ..IdentifyOptions::default()
            };
            let plant = identify(&log, &options).map_err(|e| e.to_string())?.plant;
            let theirs = request_parts(&log, kind, VALIDATION, &["oe".to_owned(), "2".to_owned()]);
            let theirs = match &theirs {
                Ok(fits) => format!("{:.2}", fits.get(1).copied().unwrap_or(f64::NAN)),
                Err(problem) => format!("left out: {problem}"),
            };
            let bound = plant.evidence.held_out.as_ref().and_then(|h| h.fit_bound);
            println!(
                "  {name:<4} {step} s: order {}, {:.2} % (noise allows {:.1} %), SciPy {theirs} %",
                plant.order(),
                plant.evidence.fit.validation,
                bound.unwrap_or(f64::NAN)
            );
        }
    }
    Ok(())
}

/// The drive that has hardly any information.
fn weak_drive(folder: &Path) -> Result<(), String> {
    let names = ["steering_wheel_angle.csv", "gyro.csv", "speed.csv"];
    let files = names
        .iter()
        .map(|n| Ok(((*n).to_owned(), std::fs::read(folder.join(n)).map_err(|e| e.to_string())?)))
        .collect::<Result<Vec<_>, String>>()?;
    let options = LogOptions {
        input: Some("steering_wheel_angle_deg".into()),
        output: Some("-gyro_down_radps".into()),
        speed: Some("speed_mps".into()),
        steering_ratio: Some(16.9),
        ..LogOptions::default()
    };
    let log = read_log(&files, &options).map_err(|e| e.to_string())?;
    let plant = identify(&log, &IdentifyOptions::default()).map_err(|e| e.to_string())?.plant;
    let (fit, verdict) = (plant.evidence.fit, &plant.quality);
    println!(
        "\ncomma2k19: order {}, fit {:.1} %, validation {:.1} %\n  {}",
        plant.order(),
        fit.estimation,
        fit.validation,
        verdict.summary
    );
    for advice in &verdict.advice {
        println!("  advice: {advice}");
    }
    Ok(())
}

fn numbers(data: &DataSet) -> Vec<f64> {
    let segments = || data.segments().iter();
    let u = segments().flat_map(|s| s.u.row(0).iter().copied());
    u.chain(segments().flat_map(|s| s.y.row(0).iter().copied())).collect()
}

fn parsed(line: &str) -> Vec<f64> {
    line.split_whitespace().filter_map(|x| x.parse().ok()).collect()
}
