//! Bias of the identification with a driver in the loop, by Monte Carlo: the open-loop methods compared
//! with SSARX and PBSID-opt with growing past horizon, Chou and Verhaegen's method where it applies,
//! the test for feedback, and PARSIM-K of another package on the same data.
//!
//! The records are long: of p past samples in N, overfitting leaves a bias of the order p/N, which at
//! 100,000 samples 200 records just show (0.05 % of the response at p = 20). It is none of the methods',
//! and falls faster with N than the interval does with the number of records.

use super::options;
use clap::Parser;
use steerwright_evaluation::bias::{Bias, Biases, Errors};
use steerwright_evaluation::driver::{Drive, SAMPLE_TIME_S};
use steerwright_evaluation::measure::cell;
use steerwright_evaluation::{on_all_cores, parsim};
use steerwright_sysid::subspace::closed_loop::{self, ClosedLoopMethod, errors_in_variables};
use steerwright_sysid::subspace::{Factor, shift_realization, structured_bd, subspace};
use steerwright_sysid::{Error, Method, StateSpace};

/// Bias with a driver in the loop
#[derive(Parser)]
struct Arguments {
    /// Samples a record
    #[arg(long, default_value_t = 400_000)]
    samples: usize,
    /// Records
    #[arg(long, default_value_t = 50)]
    seeds: u64,
    /// Past horizons
    #[arg(long, value_delimiter = ',', default_values_t = [5, 10, 20, 40])]
    past: Vec<usize>,
    /// Block rows of the future, at most the past horizon
    #[arg(long, default_value_t = 10)]
    future: usize,
    /// Block rows of the future for Chou and Verhaegen's method, whose input they must excite
    #[arg(long, default_value_t = 6)]
    sensors_future: usize,
    /// Samples a record for the test for feedback
    #[arg(long, default_value_t = 4000)]
    feedback_samples: usize,
    /// Records for that test
    #[arg(long, default_value_t = 200)]
    feedback_seeds: u64,
    /// Samples a record for PARSIM-K
    #[arg(long, default_value_t = 10_000)]
    peer_samples: usize,
    /// Records that PARSIM-K is run on
    #[arg(long, default_value_t = 20)]
    peer_seeds: u64,
}

const ORDER: usize = 3;

pub(crate) fn run() -> Result<(), Error> {
    let arguments: Arguments = options();
    let truth = Drive::vehicle();
    println!(
        "{} records of {} samples of {SAMPLE_TIME_S} s; mean error ± half its 95 % interval, * outside it",
        arguments.seeds, arguments.samples
    );
    let controlled = Drive::controlled();
    heading("a controller on the measured yaw rate, process and measurement noise", &controlled);
    let data = factors(&controlled, &arguments, 0)?;
    for &past in &arguments.past {
        open_loop_rows(&data, past, &truth);
        closed_loop_rows(&data, past, arguments.future.min(past), &truth);
    }
    let sensors = Drive::white_sensors();
    heading(
        "white noise on both sensors, a driver who feels the true yaw rate, steady sines",
        &sensors,
    );
    let data = factors(&sensors, &arguments, 10_000)?;
    for &past in &arguments.past {
        let future = arguments.future.min(past);
        open_loop_rows(&data, past, &truth);
        closed_loop_rows(&data, past, future, &truth);
        row("chou-verhaegen", past, &truth, &data, |d| {
            let future = arguments.sensors_future.min(past);
            Ok(errors_in_variables::identify_in(d, past, future, ORDER, false)?.model)
        });
    }
    feedback_rates(&arguments)?;
    peer(&arguments, &truth)
}

/// One factor for each record, long enough for all horizons; no record is kept.
fn factors(drive: &Drive, arguments: &Arguments, from: u64) -> Result<Vec<Factor>, Error> {
    let longest = arguments.past.iter().copied().max().unwrap_or(1);
    let horizon = longest.max((longest + arguments.future + 1).div_ceil(2));
    let factor =
        |k: usize| Factor::new(&drive.record(arguments.samples, from + k as u64)?, horizon);
    on_all_cores("records", arguments.seeds as usize, factor).into_iter().collect()
}

fn heading(what: &str, drive: &Drive) {
    println!("\n{what}");
    if let Some(radius) = drive.predictor_radius() {
        println!("the predictor forgets by {radius:.3} a sample");
    }
    println!(
        "{:>5} {:<16}{:>22}{:>22}{:>24}",
        "past", "method", "response %", "gain %", "slowest pole"
    );
}

fn open_loop_rows(data: &[Factor], past: usize, truth: &StateSpace) {
    for method in steerwright_sysid::Weighting::ALL {
        row(Method::from(method).name(), past, truth, data, |d| {
            let factor = d.with_horizon(past)?;
            let found = subspace(&factor, method)?;
            let (a, c) = shift_realization(&found, ORDER, 1)?;
            structured_bd(&factor, &found, a.as_ref(), c.as_ref(), false)
        });
    }
}

fn closed_loop_rows(data: &[Factor], past: usize, future: usize, truth: &StateSpace) {
    for method in ClosedLoopMethod::ALL {
        row(Method::from(method).name(), past, truth, data, |d| {
            Ok(closed_loop::decompose(d, method, past, future, false)?.model(ORDER)?.model)
        });
    }
}

fn row(
    name: &str,
    past: usize,
    truth: &StateSpace,
    data: &[Factor],
    estimate: impl Fn(&Factor) -> Result<StateSpace, Error> + Sync,
) {
    let one = |d: &Factor| estimate(d).ok().and_then(|m| Errors::new(&m, truth));
    let (first, second) = data.split_at(data.len() / 2);
    let each = |part: &[Factor]| part.iter().filter_map(one).collect::<Vec<_>>();
    let errors = std::thread::scope(|scope| {
        let other = scope.spawn(|| each(second));
        let mut errors = each(first);
        errors.extend(other.join().unwrap_or_default());
        errors
    });
    if errors.len() < 2 {
        println!("{past:>5} {name:<16}no model");
        return;
    }
    let b = Biases::new(&errors);
    let lost = data.len() - b.records;
    let note = if lost > 0 { format!("  {lost} without a model") } else { String::new() };
    println!(
        "{past:>5} {name:<16}{:>22}{:>22}{:>24}{note}",
        cell(b.response, 100.0, 2),
        cell(b.gain, 100.0, 2),
        cell(b.pole, 1.0, 4)
    );
}

fn feedback_rates(arguments: &Arguments) -> Result<(), Error> {
    println!(
        "\ntest for feedback at a significance level of 1 %, records of {} samples",
        arguments.feedback_samples
    );
    let controlled = Drive::controlled();
    let open = Drive { gain: 0.0, ..controlled.clone() };
    let open_sines = Drive { gain: 0.0, input_noise: 0.0, ..Drive::white_sensors() };
    for (what, drive) in [
        ("no loop, noise", &open),
        ("no loop, sines", &open_sines),
        ("a tenth of the gain", &Drive { gain: 0.1 * controlled.gain, ..controlled.clone() }),
        ("in the loop", &controlled),
    ] {
        let mut found = 0;
        for seed in 20_000..20_000 + arguments.feedback_seeds {
            let data = drive.record(arguments.feedback_samples, seed)?;
            found += usize::from(closed_loop::feedback(&data, 2.0, 1.0)?.detected);
        }
        println!("  {what:<22}{found} of {} records", arguments.feedback_seeds);
    }
    Ok(())
}

/// PARSIM-K and PBSID-opt on the same records.
fn peer(arguments: &Arguments, truth: &StateSpace) -> Result<(), Error> {
    const HORIZON: usize = 20;
    println!(
        "\npoles by PARSIM-K (sippy_unipi) and here, horizons {HORIZON}, mean error ± half its 95 % interval"
    );
    let drive = Drive::controlled();
    let mut found: Vec<(&str, Vec<Errors>)> =
        [("parsim-k", vec![]), ("ssarx", vec![]), ("pbsid", vec![])].into();
    let mut apart = Vec::new();
    for seed in 30_000..30_000 + arguments.peer_seeds {
        let data = drive.record(arguments.peer_samples, seed)?;
        let theirs = match parsim::poles(&data, HORIZON, ORDER) {
            Ok(poles) => poles,
            Err(problem) => {
                println!("left out: {problem}");
                return Ok(());
            }
        };
        let theirs = Errors::new(&with_poles(&theirs), truth);
        let ours: Vec<Option<Errors>> = ClosedLoopMethod::ALL
            .iter()
            .map(|m| {
                let model =
                    closed_loop::identify(&data, *m, HORIZON, HORIZON, ORDER, false).ok()?.model;
                Errors::new(&model, truth)
            })
            .collect();
        if let (Some(theirs), [Some(ssarx), Some(pbsid)]) = (theirs, ours.as_slice()) {
            apart.push(theirs.pole.iter().zip(&pbsid.pole).map(|(a, b)| a - b).collect());
            found[0].1.push(theirs);
            found[1].1.push(ssarx.clone());
            found[2].1.push(pbsid.clone());
        }
    }
    if apart.len() < 2 {
        println!("left out: no models");
        return Ok(());
    }
    for (name, errors) in &found {
        println!("  {name:<24}{}", cell(Biases::new(errors).pole, 1.0, 4));
    }
    println!("  {:<24}{}", "parsim-k minus pbsid", cell(Bias::new(&apart), 1.0, 4));
    Ok(())
}

/// A model with these poles and nothing else of meaning.
fn with_poles(poles: &[(f64, f64)]) -> StateSpace {
    use faer::Mat;
    let n = poles.len();
    // A complex pair, in whatever order, fills a block [re im; −im re] from its first to its second.
    let mut a = Mat::zeros(n, n);
    let mut k = 0;
    while k < n {
        let (re, im) = poles[k];
        a[(k, k)] = re;
        if im != 0.0 && k + 1 < n {
            a[(k + 1, k + 1)] = re;
            a[(k, k + 1)] = im;
            a[(k + 1, k)] = -im;
            k += 1;
        }
        k += 1;
    }
    let ones = |r: usize, c: usize| Mat::from_fn(r, c, |_, _| 1.0);
    StateSpace { a, b: ones(n, 1), c: ones(1, n), d: Mat::zeros(1, 1) }
}
