//! The refinement compared with scipy's `least_squares` on the same criterion, from the same initial
//! estimate.
//!
//! Both foci on a simulated car (order 2, 20 dB) and on Ljung's dryer (order 4): the least mean square
//! that each reaches, and the standard errors of each. scipy works on polynomials with a Jacobian by
//! finite differences (`python/refinement.py`), so nothing but the criterion is shared. For the
//! simulation focus scipy's errors are from the sample autocovariance up to 40 lags, the project's from
//! an autoregression.
//!
//! Then the time that one step takes and what the search needs of memory, at growing length.

use super::options;
use clap::Parser;
use faer::{Mat, MatRef};
use std::io::Write;
use std::path::Path;
use std::process::Stdio;
use std::time::Instant;
use steerwright_evaluation::measure::peak_memory;
use steerwright_evaluation::{Random, initial_estimate, recording};
use steerwright_sysid::pem::{Focus, Stop, Uncertain, refine_prediction, uncertain};
use steerwright_sysid::{DataSet, Error, Innovation, Signals, StateSpace, simulate};

const STOP: Stop = Stop { steps: 200, least_gain: 1e-12 };
const SCRIPT: &str = include_str!("../../python/refinement.py");

/// The refinement compared with scipy's, and what its steps cost.
#[derive(Parser)]
struct Arguments {
    /// Longest data that the steps are timed on, samples
    #[arg(long, default_value_t = 1_000_000)]
    longest: usize,
}

/// Name, value, standard error.
type Row = (String, f64, f64);

pub(crate) fn run() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Arguments = options();
    let has_peer = match steerwright_evaluation::python() {
        Ok(_) => true,
        Err(problem) => {
            println!("left out: scipy: {problem}");
            false
        }
    };
    for (name, data, order) in [("simulated car", car()?, 2), ("dryer2", dryer()?, 4)] {
        for focus in [Focus::Simulation, Focus::Prediction] {
            let start = initial_estimate(&data, order)?;
            let clock = Clock::start();
            let (cost, ours) = ours(&start, &data, focus)?;
            let elapsed = clock.ms();
            println!("\n{name}, order {order}, {} samples, {focus:?}", data.samples());
            let theirs = if has_peer { Some(theirs(&start.0, &data, focus)?) } else { None };
            println!("  {:16}{:>14}{:>14}{:>14}{:>14}", "", "here", "scipy", "± here", "± scipy");
            let (their_cost, their_rows) = theirs.unwrap_or((f64::NAN, Vec::new()));
            println!("  {:16}{cost:14.8}{their_cost:14.8}", "mean square");
            for (name, value, error) in &ours {
                let other = their_rows.iter().find(|(n, ..)| n == name);
                let (v, e) = other.map_or((f64::NAN, f64::NAN), |(_, v, e)| (*v, *e));
                println!("  {name:16}{value:14.6}{v:14.6}{error:14.6}{e:14.6}");
            }
            println!("  {elapsed:.1} ms here");
        }
    }
    cost_of_steps(arguments.longest)
}

/// Time and memory of the simulation focus on the car's drive.
fn cost_of_steps(longest: usize) -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "\nsimulation focus   order   steps   ms/step   covariance ms   peak memory beyond the data"
    );
    let sizes = [(13_750, 2), (13_750, 4), (13_750, 8), (100_000, 4), (1_000_000, 4)];
    for (count, order) in sizes.into_iter().filter(|(count, _)| *count <= longest) {
        let data = car_of(count)?;
        let (start, x0s) = initial_estimate(&data, order)?;
        let before = restart_peak();
        let clock = Clock::start();
        let stop = Stop { steps: 10, least_gain: 0.0 };
        let found = refine_prediction(&start, &x0s, &data, false, Focus::Simulation, stop, 0.9999)?;
        let refining = clock.ms();
        let clock = Clock::start();
        let uncertainty = uncertain(&found.innovation, &found.x0s, &data, false, Focus::Simulation);
        let uncertainty_ms = clock.ms();
        let memory = peak_memory().zip(before).map_or("not reported".into(), |(peak, before)| {
            format!("{:.1} MB", (peak - before) / 1_048_576.0)
        });
        println!(
            "N = {count:8} {order:12} {:7} {:9.2} {uncertainty_ms:15.1}{} {memory:>18}",
            found.steps,
            refining / found.steps.max(1) as f64,
            if uncertainty.is_ok() { " " } else { "?" },
        );
    }
    Ok(())
}

/// Time that this thread has run for, where the system reports it (Linux), else what has passed.
struct Clock {
    wall: Instant,
    run: Option<f64>,
}

impl Clock {
    fn start() -> Self {
        Self { wall: Instant::now(), run: Self::run_ms() }
    }

    fn run_ms() -> Option<f64> {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        Some(text.split_whitespace().next()?.parse::<f64>().ok()? * 1e-6)
    }

    fn ms(&self) -> f64 {
        match (self.run, Self::run_ms()) {
            (Some(then), Some(now)) => now - then,
            _ => self.wall.elapsed().as_secs_f64() * 1e3,
        }
    }
}

/// The peak memory, bytes, reset to the present one.
fn restart_peak() -> Option<f64> {
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    peak_memory()
}

/// A car's yaw rate by a driven steering, noise in innovation form.
fn car() -> Result<DataSet, Error> {
    car_of(5000)
}

fn car_of(count: usize) -> Result<DataSet, Error> {
    let mut random = Random(1);
    let (white, e) = (random.matrix(1, count), random.matrix(1, count));
    let mut state = 0.0;
    let u = Mat::from_fn(1, count, |_, t| {
        state = 0.8 * state + white[(0, t)];
        state
    });
    let a = Mat::from_fn(2, 2, |i, j| [[0.75, 0.2], [-0.2, 0.7]][i][j]);
    let both = StateSpace {
        a,
        b: Mat::from_fn(2, 2, |i, j| [[0.9, 0.2], [0.4, -0.1]][i][j]),
        c: Mat::from_fn(1, 2, |_, j| [1.0, 0.3][j]),
        d: Mat::from_fn(1, 2, |_, j| [0.0, 0.5][j]),
    };
    let signals = Mat::from_fn(2, count, |i, t| if i == 0 { u[(0, t)] } else { e[(0, t)] });
    let y = simulate(&both, signals.as_ref(), &[0.0; 2]);
    DataSet::single(0.04, u, y)
}

/// Ljung's dryer, its means removed.
fn dryer() -> Result<DataSet, Box<dyn std::error::Error>> {
    let path =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/drives/dryer2/dryer2_slicot_ib01ad.csv");
    let data = recording(Path::new(path), &["u"], &["y"], 0.08)?;
    let centred = |signal: &Signals| {
        let samples = signal.row(0);
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        Mat::from_fn(1, samples.len(), |_, t| samples[t] - mean)
    };
    let segment = &data.segments()[0];
    Ok(DataSet::single(0.08, centred(&segment.u), centred(&segment.y))?)
}

fn ours(
    (start, x0s): &(Innovation, Vec<Vec<f64>>),
    data: &DataSet,
    focus: Focus,
) -> Result<(f64, Vec<Row>), Error> {
    let found = refine_prediction(start, x0s, data, false, focus, STOP, 0.9999)?;
    let of = uncertain(&found.innovation, &found.x0s, data, false, focus)?;
    let mut rows = Vec::new();
    if let Some((value, error)) = of.steady_state_gain(0, 0) {
        rows.push(("gain".into(), value, error));
    }
    for omega in [0.1, 0.5, 1.5] {
        let r = of.frequency_response(0, 0, omega);
        rows.push((format!("magnitude({omega})"), r.re.hypot(r.im), r.magnitude_error));
    }
    rows.extend(slowest_pole(&of)?);
    Ok((found.error_covariance[(0, 0)], rows))
}

/// The largest modulus of a pole.
fn slowest_pole(of: &Uncertain) -> Result<Option<Row>, Error> {
    let size = |p: &steerwright_sysid::pem::PoleEstimate| p.re.hypot(p.im);
    Ok(of.poles()?.into_iter().max_by(|a, b| size(a).total_cmp(&size(b))).map(|p| {
        let (x, y) = (p.re / size(&p), p.im / size(&p));
        let variance = x * x * p.variance_re + y * y * p.variance_im + 2.0 * x * y * p.covariance;
        ("slowest_pole".into(), size(&p), variance.sqrt())
    }))
}

fn theirs(
    start: &Innovation,
    data: &DataSet,
    focus: Focus,
) -> Result<(f64, Vec<Row>), Box<dyn std::error::Error>> {
    let segment = &data.segments()[0];
    let line = |m: MatRef<'_, f64>| {
        let numbers = (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| (i, j)));
        numbers.map(|at| format!("{:e}", m[at])).collect::<Vec<_>>().join(" ")
    };
    let m = &start.model;
    let focus = if focus == Focus::Simulation { "simulation" } else { "prediction" };
    let mut text = format!("{focus} {} {}\n", m.order(), data.samples());
    let (u, y) = (segment.u.as_ref(), segment.y.as_ref());
    for matrix in [m.a.as_ref(), m.b.as_ref(), m.c.as_ref(), start.gain.as_ref(), u, y] {
        text += &line(matrix);
        text.push('\n');
    }
    let mut child = steerwright_evaluation::python()?
        .args(["-c", SCRIPT])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    child.stdin.take().ok_or("no input to the peer")?.write_all(text.as_bytes())?;
    let output = child.wait_with_output()?;
    if !output.status.success() {
        return Err("the peer failed".into());
    }
    let mut cost = f64::NAN;
    let mut rows = Vec::new();
    for line in String::from_utf8(output.stdout)?.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["cost", value] => cost = value.parse()?,
            [name, value, error] => rows.push((name.into(), value.parse()?, error.parse()?)),
            _ => return Err(format!("unexpected line of the peer: {line}").into()),
        }
    }
    Ok((cost, rows))
}
