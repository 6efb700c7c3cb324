//! Errors of the identified response from steering to yaw rate, for logs at 100 Hz down to 10 Hz.
//!
//! Linear cars whose response is known, with logs as [`LinearDrive`] makes them; each is read and
//! identified as the command line does. The error is ‖Ĝ − G‖/‖G‖ over 0.1 to 2 Hz, the bias of the
//! phase the mean over the drives. It is compared with SciPy's output error of the true order on the
//! same halves.

use super::options;
use clap::Parser;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use steerwright_drivelog::{LogOptions, read_log};
use steerwright_evaluation::{LinearCar, LinearDrive, LinearLog, Random, Steering, request};
use steerwright_sysid::model::conversion;
use steerwright_sysid::{IdentifyOptions, Intersample, StateSpace, identify};

/// Prints how well the response from steering to yaw rate is identified.
#[derive(Parser)]
struct Arguments {
    /// Drives of each kind
    #[arg(long, default_value_t = 36)]
    drives: usize,
    /// Kinds of drives; all of them unless named
    #[arg(long, value_delimiter = ',')]
    kinds: Vec<String>,
    /// Rates of the logs, Hz
    #[arg(long, value_delimiter = ',', default_values_t = [100.0, 50.0, 20.0, 10.0])]
    rates: Vec<f64>,
    /// Sample time of the identification, s; chosen unless given
    #[arg(long)]
    sample_time: Option<f64>,
    /// What the steering does between its samples; by the log unless given
    #[arg(long)]
    intersample: Option<String>,
    /// Order of the model; chosen unless given
    #[arg(long)]
    order: Option<usize>,
    /// Seed of the cars and drives
    #[arg(long, default_value_t = 14)]
    seed: u64,
    /// One line for each drive
    #[arg(long)]
    each: bool,
    /// One drive of each kind at 100 and 20 Hz
    #[arg(long)]
    short: bool,
}

/// A kind of drive, by name.
type DriveKind = (&'static str, fn(LinearCar, &mut Random) -> LinearDrive);

const KINDS: [DriveKind; 5] = [
    ("realistic", LinearDrive::realistic),
    ("command", |car, random| LinearDrive {
        steering: Steering::Command,
        ..LinearDrive::realistic(car, random)
    }),
    ("ideal", LinearDrive::ideal),
    ("sweep", LinearDrive::clean_sweep),
    ("noise-free", LinearDrive::noise_free),
];

/// Where the bias of the phase is shown, Hz.
const SHOWN_HZ: [f64; 3] = [0.3, 1.0, 2.0];

pub(crate) fn run() -> Result<(), String> {
    let mut arguments: Arguments = options();
    if arguments.short {
        (arguments.drives, arguments.rates) = (1, vec![100.0, 20.0]);
    }
    println!(
        "{:<11}{:>5}  {:>13}  {:>20}  {:>5}{:>5}{:>8}{:>7}  {:<16}{:>13}",
        "", "", "error, %", "phase bias, degrees", "", "", "", "no", "", "SciPy OE, %"
    );
    println!(
        "{:<11}{:>5}{:>8}{:>7}{:>8}{:>7}{:>7}{:>7}{:>9}{:>6}{:>6}  {:<16}{:>6}{:>7}",
        "drives",
        "Hz",
        "median",
        "90 %",
        "0.3 Hz",
        "1 Hz",
        "2 Hz",
        "delay",
        "feedback",
        "cont.",
        "none",
        "orders",
        "median",
        "90 %"
    );
    let named =
        |name: &str| arguments.kinds.is_empty() || arguments.kinds.iter().any(|k| k == name);
    for (name, drive) in KINDS.iter().filter(|(name, _)| named(name)) {
        for &rate in &arguments.rates {
            row(&arguments, name, *drive, rate)?;
        }
    }
    Ok(())
}

fn row(
    arguments: &Arguments,
    name: &str,
    drive: fn(LinearCar, &mut Random) -> LinearDrive,
    rate_hz: f64,
) -> Result<(), String> {
    let mut random = Random(arguments.seed);
    let logs: Vec<LinearLog> = (0..arguments.drives)
        .map(|_| {
            let car = LinearCar::random(&mut random);
            let drive = drive(car, &mut random);
            LinearDrive { rate_hz, ..drive }.record()
        })
        .collect();
    let (mut errors, mut phases) = (Vec::new(), [0.0; 3]);
    let mut orders: BTreeMap<usize, usize> = BTreeMap::new();
    let (mut delays, mut feedback, mut discrete, mut none) = (0, 0, 0, 0);
    for (k, log) in logs.iter().enumerate() {
        let found = match Found::new(log, arguments) {
            Ok(found) => found,
            Err(problem) => {
                none += 1;
                if arguments.each {
                    println!("  {k}: {problem}");
                }
                continue;
            }
        };
        *orders.entry(found.order).or_default() += 1;
        delays += usize::from(found.delay_s > 0.0);
        feedback += usize::from(found.feedback);
        let Some(model) = &found.continuous else {
            discrete += 1;
            if arguments.each {
                println!("  {k}: order {}: {}", found.order, found.warnings.join("; "));
            }
            continue;
        };
        let of = |hz: f64| turned(model.frequency(hz), -TAU * hz * found.delay_s);
        let error = error(log, &of);
        errors.push(error);
        for (sum, hz) in phases.iter_mut().zip(SHOWN_HZ) {
            *sum += phase(of(hz), truth(log, hz));
        }
        if arguments.each {
            println!(
                "  {k}: order {}, {:.2} %, delay {:.3} s, feedback {}, driver {}, {:.1} m/s, T {} s, fit {:.1}",
                found.order,
                100.0 * error,
                found.delay_s,
                found.feedback,
                log.drive.driver,
                log.drive.speed_mps,
                found.sample_time_s,
                found.fit
            );
        }
    }
    let count = errors.len().max(1) as f64;
    let mut orders_text = String::new();
    for (order, count) in &orders {
        orders_text += &format!("{order}:{count} ");
    }
    let peer = match peer(&logs) {
        Ok(e) => format!("{:>6.2}{:>7.2}", 100.0 * quantile(&e, 0.5), 100.0 * quantile(&e, 0.9)),
        Err(problem) => format!("left out: {problem}"),
    };
    println!(
        "{name:<11}{rate_hz:>5}{:>8.2}{:>7.2}{:>8.2}{:>7.2}{:>7.2}{delays:>7}{feedback:>9}{discrete:>6}{none:>6}  {orders_text:<16}{peer}",
        100.0 * quantile(&errors, 0.5),
        100.0 * quantile(&errors, 0.9),
        phases[0] / count,
        phases[1] / count,
        phases[2] / count,
    );
    Ok(())
}

/// What was identified.
struct Found {
    order: usize,
    delay_s: f64,
    feedback: bool,
    sample_time_s: f64,
    fit: f64,
    warnings: Vec<String>,
    continuous: Option<Continuous>,
}

impl Found {
    fn new(log: &LinearLog, arguments: &Arguments) -> Result<Self, String> {
        let files = [("drive.csv".to_owned(), log.csv().into_bytes())];
        let options = LogOptions {
            sample_time_s: arguments.sample_time,
            steering_ratio: Some(1.0),
            intersample: match arguments.intersample.as_deref() {
                Some("zoh") => Some(Intersample::Zoh),
                Some("bl") => Some(Intersample::Bl),
                _ => None,
            },
            ..LogOptions::default()
        };
        let read = read_log(&files, &options).map_err(|e| e.to_string())?;
        let options = IdentifyOptions { order: arguments.order, ..IdentifyOptions::default() };
        let plant = identify(&read, &options).map_err(|e| e.to_string())?.plant;
        let continuous = plant.continuous.as_ref().map(|c| {
            let n = plant.order();
            let by = |rows: usize, columns: usize, at: &dyn Fn(usize, usize) -> f64| {
                faer::Mat::from_fn(rows, columns, at)
            };
            Continuous(StateSpace {
                a: by(n, n, &|i, j| c.f.entry(i, j)),
                b: by(n, 1, &|i, j| c.g.entry(i, j)),
                c: by(1, n, &|i, j| c.h.entry(i, j)),
                d: by(1, 1, &|i, j| plant.discrete.d.entry(i, j)),
            })
        });
        Ok(Self {
            order: plant.order(),
            delay_s: plant.input_delay_s,
            feedback: plant.evidence.feedback.is_some_and(|f| !f.pass),
            sample_time_s: plant.discrete.sample_time_s,
            fit: plant.evidence.fit.validation,
            warnings: plant.evidence.warnings,
            continuous,
        })
    }
}

/// A model in continuous time.
struct Continuous(StateSpace);

impl Continuous {
    /// H (jω − F)⁻¹ G + D, by its discretisation with a short hold: the step is a thousandth of the
    /// period.
    fn frequency(&self, hz: f64) -> (f64, f64) {
        let step = 1e-3 / hz;
        let m = &self.0;
        let (a, b) = conversion::discretize(m.a.as_ref(), m.b.as_ref(), step);
        let held = StateSpace { a, b, c: m.c.clone(), d: faer::Mat::zeros(1, 1) };
        let w = TAU * hz * step;
        let (re, im) = held.frequency_response(0, 0, w);
        // Without the hold: its delay of half a step, and its gain.
        let (re, im) = turned((re, im), 0.5 * w);
        let gain = (0.5 * w) / (0.5 * w).sin();
        (re * gain + m.d[(0, 0)], im * gain)
    }
}

fn truth(log: &LinearLog, hz: f64) -> (f64, f64) {
    log.drive.car.response(log.drive.speed_mps, hz)
}

/// Multiplied by e^{j·angle}.
fn turned((re, im): (f64, f64), angle: f64) -> (f64, f64) {
    let (s, c) = angle.sin_cos();
    (re * c - im * s, re * s + im * c)
}

/// Phase of one number against another, degrees.
fn phase(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.1 * b.0 - a.0 * b.1).atan2(a.0 * b.0 + a.1 * b.1).to_degrees()
}

/// ‖Ĝ − G‖/‖G‖ over 0.1 to 2 Hz.
fn error(log: &LinearLog, of: &dyn Fn(f64) -> (f64, f64)) -> f64 {
    const POINTS: usize = 40;
    let (mut off, mut size) = (0.0, 0.0);
    for k in 0..POINTS {
        let hz = 0.1 + 1.9 * k as f64 / (POINTS - 1) as f64;
        let (g, h) = (truth(log, hz), of(hz));
        off += (h.0 - g.0).powi(2) + (h.1 - g.1).powi(2);
        size += g.0 * g.0 + g.1 * g.1;
    }
    (off / size).sqrt()
}

/// Errors of SciPy's output error of order 2 on the first halves.
fn peer(logs: &[LinearLog]) -> Result<Vec<f64>, String> {
    let Some(first) = logs.first() else { return Ok(Vec::new()) };
    let half = first.time.len() / 2;
    let mut numbers = Vec::new();
    for log in logs {
        numbers.extend_from_slice(&log.steering[..half]);
        numbers.extend_from_slice(&log.yaw_rate[..half]);
    }
    let hold = match first.drive.steering {
        Steering::Measured => "foh",
        Steering::Command | Steering::HeldAngle => "zoh",
    };
    let step = 1.0 / first.drive.rate_hz;
    let arguments = [half.to_string(), step.to_string(), hold.to_owned()];
    let lines = request(include_str!("../../python/output_error.py"), &numbers, &arguments)?;
    let of = |(log, line): (&LinearLog, &String)| {
        let words = line.split_whitespace().map(str::parse::<f64>);
        let numbers = words.collect::<Result<Vec<f64>, _>>().map_err(|e| e.to_string())?;
        let &[b1, b0, a1, a0] = numbers.as_slice() else { return Err(line.clone()) };
        Ok(error(log, &|hz| {
            let w = TAU * hz;
            let (above, below) = ((b0, b1 * w), (a0 - w * w, a1 * w));
            let size = below.0 * below.0 + below.1 * below.1;
            (
                (above.0 * below.0 + above.1 * below.1) / size,
                (above.1 * below.0 - above.0 * below.1) / size,
            )
        }))
    };
    logs.iter().zip(&lines).map(of).collect()
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1) as f64;
    sorted.get((share * last).round() as usize).copied().unwrap_or(f64::NAN)
}
