//! The two foci of the refinement: errors of the simulation, or of the one-step prediction.
//!
//! First a Monte Carlo experiment on a known car (order 2, 2,000 samples, 60 drives): with the noise in
//! innovation form, and with output noise whose slow kind no filter of order 2 can have; driven
//! openly, and by a driver who steers against the yaw rate. For each focus the bias and the scatter of
//! the steady-state gain, and the error of the frequency response, relative to the truth. Then the fit of
//! the simulation of the second half of recordings, estimated on the first; those of DaISy with
//! `--data DIR`, where DIR holds the folder `daisy`.

use super::options;
use clap::Parser;
use faer::Mat;
use std::path::{Path, PathBuf};
use steerwright_evaluation::{Random, initial_estimate, response_distance};
use steerwright_sysid::model::initial_state;
use steerwright_sysid::pem::{Focus, Stop, refine_prediction};
use steerwright_sysid::{DataSet, Error, Innovation, StateSpace, fit_percent, simulate};

const STOP: Stop = Stop { steps: 40, least_gain: 1e-9 };
const SAMPLES: usize = 2000;
const FOCI: [Focus; 2] = [Focus::Simulation, Focus::Prediction];

/// Which errors to make small.
#[derive(Parser)]
struct Arguments {
    /// Folder with the recordings that may not be copied.
    #[arg(long)]
    data: Option<PathBuf>,
    /// Drives of the known car
    #[arg(long, default_value_t = 60)]
    drives: usize,
}

pub(crate) fn run() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Arguments = options();
    println!("known car, {} drives of {SAMPLES} samples; percent of the truth", arguments.drives);
    println!(
        "{:34}{:12}{:>12}{:>14}{:>20}",
        "", "focus", "gain bias", "gain scatter", "response error, rms"
    );
    for feedback in [0.0, 0.15] {
        for kind in [NoiseKind::Innovation, NoiseKind::Slow] {
            experiment(feedback, kind, arguments.drives)?;
        }
    }
    println!("\nfit of the simulated second half, percent (estimated on the first)");
    println!("{:20}{:>6}{:>12}{:>12}", "", "order", "simulation", "prediction");
    let dryer = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../examples/drives/dryer2/dryer2_slicot_ib01ad.csv");
    halves("dryer2", &dryer, &[3, 4])?;
    match arguments.data {
        Some(folder) => {
            halves("robot_arm", &folder.join("daisy/robot_arm.csv"), &[4, 6])?;
            halves("exchanger", &folder.join("daisy/exchanger.csv"), &[2, 4])?;
        }
        None => println!("left out: robot_arm, exchanger (--data DIR)"),
    }
    Ok(())
}

#[derive(Clone, Copy)]
enum NoiseKind {
    Innovation,
    Slow,
}

fn car() -> Innovation {
    let model = StateSpace {
        a: Mat::from_fn(2, 2, |i, j| [[0.75, 0.3], [-0.3, 0.7]][i][j]),
        b: Mat::from_fn(2, 1, |i, _| [0.9, 0.4][i]),
        c: Mat::from_fn(1, 2, |_, j| [1.0, 0.3][j]),
        d: Mat::zeros(1, 1),
    };
    Innovation { model, gain: Mat::from_fn(2, 1, |i, _| [0.4, -0.2][i]) }
}

fn drive(random: &mut Random, feedback: f64, kind: NoiseKind) -> Result<DataSet, Error> {
    let truth = car();
    let m = &truth.model;
    let (mut x, mut last, mut slow, mut wish) = ([0.0; 2], 0.0, 0.0, 0.0);
    let (mut u, mut y) = (Mat::zeros(1, SAMPLES), Mat::zeros(1, SAMPLES));
    for t in 0..SAMPLES {
        wish = 0.8 * wish + random.normal();
        u[(0, t)] = wish - feedback * last;
        let e = random.normal();
        let (noise, into) = match kind {
            NoiseKind::Innovation => (e, e),
            NoiseKind::Slow => {
                slow = 0.97 * slow + 0.3 * e;
                (slow, 0.0)
            }
        };
        y[(0, t)] = m.c[(0, 0)] * x[0] + m.c[(0, 1)] * x[1] + noise;
        last = y[(0, t)];
        x = std::array::from_fn(|i| {
            m.a[(i, 0)] * x[0]
                + m.a[(i, 1)] * x[1]
                + m.b[(i, 0)] * u[(0, t)]
                + truth.gain[(i, 0)] * into
        });
    }
    DataSet::single(0.04, u, y)
}

fn experiment(feedback: f64, kind: NoiseKind, drives: usize) -> Result<(), Error> {
    let truth = car().model;
    let gain = truth.steady_state_gain(0, 0).unwrap_or(f64::NAN);
    let mut results = [Vec::new(), Vec::new()];
    for seed in 0..drives {
        let data = drive(&mut Random(seed as u64), feedback, kind)?;
        for (focus, results) in FOCI.into_iter().zip(&mut results) {
            let model = estimate(&data, 2, focus)?;
            let error = model.steady_state_gain(0, 0).unwrap_or(f64::NAN) / gain - 1.0;
            results.push((100.0 * error, 100.0 * response_distance(&truth, &model)));
        }
    }
    let noise = match kind {
        NoiseKind::Innovation => "innovation form",
        NoiseKind::Slow => "slow output noise",
    };
    let loop_ = if feedback > 0.0 { "driver's feedback" } else { "no feedback" };
    for (focus, results) in FOCI.into_iter().zip(&results) {
        let n = results.len() as f64;
        let bias = results.iter().map(|r| r.0).sum::<f64>() / n;
        let scatter = (results.iter().map(|r| (r.0 - bias).powi(2)).sum::<f64>() / n).sqrt();
        let response = (results.iter().map(|r| r.1 * r.1).sum::<f64>() / n).sqrt();
        let what = format!("{loop_}, {noise}");
        println!("{what:34}{:12}{bias:12.2}{scatter:14.2}{response:20.2}", format!("{focus:?}"));
    }
    Ok(())
}

/// The initial estimate, refined.
fn estimate(data: &DataSet, order: usize, focus: Focus) -> Result<StateSpace, Error> {
    let (start, x0s) = initial_estimate(data, order)?;
    let found = refine_prediction(&start, &x0s, data, false, focus, STOP, 0.9999)?;
    Ok(found.innovation.model)
}

fn halves(name: &str, path: &Path, orders: &[usize]) -> Result<(), Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut rows = Vec::new();
    for line in text.lines().skip(1) {
        // The last two columns; some recordings have the time before them.
        let mut cells = line.rsplit(',').map(|cell| cell.trim().parse::<f64>());
        let (Some(y), Some(u)) = (cells.next(), cells.next()) else {
            return Err(format!("{name}: two columns are expected").into());
        };
        rows.push([u?, y?]);
    }
    let half = rows.len() / 2;
    let signal = |k: usize, from: usize, to: usize| {
        let mean = rows[..half].iter().map(|r| r[k]).sum::<f64>() / half as f64;
        Mat::from_fn(1, to - from, |_, t| rows[from + t][k] - mean)
    };
    let first = DataSet::single(1.0, signal(0, 0, half), signal(1, 0, half))?;
    let (u, y) = (signal(0, half, rows.len()), signal(1, half, rows.len()));
    for &order in orders {
        let mut fits = Vec::new();
        for focus in FOCI {
            let model = estimate(&first, order, focus)?;
            let fit = if model.spectral_radius() < 1.0 {
                let x0 = initial_state(&model, u.as_ref(), y.as_ref())?;
                let simulated = simulate(&model, u.as_ref(), &x0);
                let list = |m: &Mat<f64>| (0..m.ncols()).map(|t| m[(0, t)]).collect::<Vec<_>>();
                fit_percent(&list(&y), simulated.row(0))
            } else {
                f64::NEG_INFINITY
            };
            fits.push(fit);
        }
        println!("{name:20}{order:6}{:12.2}{:12.2}", fits[0], fits[1]);
    }
    Ok(())
}
