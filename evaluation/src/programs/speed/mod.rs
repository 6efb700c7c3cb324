//! From samples to (A, B, C, D, K) with fixed order and horizon: time, memory and accuracy compared
//! with SLICOT, which runs in turns on the same data, and with others where they can.
//!
//! Times are processor times of one thread, medians of several turns. The system is a seeded one of
//! order 4 with one input and one output; its output carries white noise of a fifth of its size.

mod conditioning;
mod memory;
mod others;

use super::options;
use clap::Parser;
use faer::MatRef;
use std::path::Path;
use steerwright_evaluation::Random;
use steerwright_evaluation::measure::{median, processor_time_s};
use steerwright_evaluation::peers::{PeerModel, Peers, write_signals};
use steerwright_sysid::subspace::{
    Factor, noise_model, shift_realization, structured_bd, subspace,
};
use steerwright_sysid::{DataSet, Innovation, StateSpace, Weighting, fit_percent, simulate};

const HORIZON: usize = 15;
const ORDER: usize = 4;
/// Samples, turns, and runs of each in a turn.
const SIZES: [(usize, usize, usize); 4] =
    [(1_000, 15, 20), (10_000, 15, 10), (100_000, 11, 2), (1_000_000, 9, 1)];
const NOISE: f64 = 0.2;
/// The weighting that is timed.
const METHOD: Weighting = Weighting::Moesp;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

#[derive(Parser)]
struct Arguments {
    /// Only load the signals of this file and report the peak memory, or compute the model too
    #[arg(long, hide = true, num_args = 3, value_names = ["loaded|model", "FILE", "COUNT"])]
    memory: Option<Vec<String>>,
    /// Longest signals, samples
    #[arg(long, default_value_t = 1_000_000)]
    longest: usize,
    /// Draws whose fits are compared at each length, at most
    #[arg(long, default_value_t = 40)]
    draws: usize,
}

pub(crate) fn run() -> Outcome<()> {
    let arguments: Arguments = options();
    match arguments.memory {
        Some(values) => memory::memory_of(&values),
        None => report(arguments.longest, arguments.draws),
    }
}

/// Signals with the output that has no noise.
struct Signals {
    u: Vec<f64>,
    y: Vec<f64>,
    clean: Vec<f64>,
}

fn truth() -> StateSpace {
    Random(4).system(ORDER, 1, 1)
}

/// Drives the true system with `u`, and adds noise of a share of its output.
fn drive(u: Vec<f64>, noise: f64, random: &mut Random) -> Signals {
    let clean = simulate(&truth(), row(&u), &[0.0; ORDER]);
    let clean: Vec<f64> = (0..u.len()).map(|t| clean[(0, t)]).collect();
    let size = (clean.iter().map(|x| x * x).sum::<f64>() / clean.len() as f64).sqrt();
    let y = clean.iter().map(|x| x + noise * size * random.normal()).collect();
    Signals { u, y, clean }
}

fn white(count: usize, random: &mut Random) -> Vec<f64> {
    (0..count).map(|_| random.normal()).collect()
}

fn row(x: &[f64]) -> MatRef<'_, f64> {
    MatRef::from_row_major_slice(x, 1, x.len())
}

/// R factor to (A, B, C, D, K): A, C by MOESP and B, D by N4SID, as SLICOT's combined method.
fn ours(u: &[f64], y: &[f64]) -> Result<(Factor, Innovation), steerwright_sysid::Error> {
    let factor = Factor::of_signals(&[(row(u), row(y))], HORIZON, 1.0)?;
    let model = model(&factor, METHOD)?;
    Ok((factor, model))
}

fn model(factor: &Factor, method: Weighting) -> Result<Innovation, steerwright_sysid::Error> {
    let space = subspace(factor, method)?;
    let (a, c) = shift_realization(&space, ORDER, 1)?;
    let model = structured_bd(factor, &space, a.as_ref(), c.as_ref(), true)?;
    let gain = noise_model(factor, &model)?.gain;
    Ok(Innovation { model, gain })
}

/// Fit of a simulation to the output without noise, percent.
fn fit(model: &StateSpace, signals: &Signals) -> f64 {
    let y = simulate(model, row(&signals.u), &[0.0; ORDER]);
    let y: Vec<f64> = (0..y.ncols()).map(|t| y[(0, t)]).collect();
    fit_percent(&signals.clean, &y)
}

/// −∞ of an unstable model.
fn stable_fit(model: &StateSpace, signals: &Signals) -> f64 {
    if model.spectral_radius() < 1.0 { fit(model, signals) } else { f64::NEG_INFINITY }
}

fn report(longest: usize, draws: usize) -> Outcome<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("signals.bin");
    let mut peers = match Peers::start() {
        Ok(peers) => Some(peers),
        Err(problem) => {
            println!("left out: SLICOT, sippy, nfoursid: {problem}");
            None
        }
    };
    println!(
        "R factor to (A, B, C, D, K), order {ORDER}, s = {HORIZON}, one input and output, one thread; ms"
    );
    println!(
        "| samples | here | SLICOT | ratio | target | of which factor | from a DataSet | fit here, % | fit SLICOT, % | fit K here, % | fit K SLICOT, % | factor by |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (count, turns, runs) in SIZES.into_iter().filter(|size| size.0 <= longest) {
        let mut random = Random(count as u64);
        let u = white(count, &mut random);
        let signals = drive(u, NOISE, &mut random);
        write_signals(&path, &signals.u, &signals.y)?;
        if let Some(peers) = &mut peers {
            peers.load(&path, count)?;
        }
        line(&signals, turns, runs, peers.as_mut())?;
    }
    if longest >= SIZES[3].0 {
        memory::memory(&path, SIZES[3].0);
    }
    fits(&path, peers.as_mut(), longest, draws)?;
    conditioning::ill_conditioned(&path, peers.as_mut())?;
    others::others(&path, peers.as_mut(), longest)?;
    others::octave(&path)
}

/// Mean processor seconds of a few runs.
fn timed<T>(runs: usize, mut work: impl FnMut() -> T) -> (f64, T) {
    let start = processor_time_s();
    for _ in 1..runs {
        std::hint::black_box(work());
    }
    let last = std::hint::black_box(work());
    ((processor_time_s() - start) / runs as f64, last)
}

fn line(
    signals: &Signals,
    turns: usize,
    runs: usize,
    mut peers: Option<&mut Peers>,
) -> Outcome<()> {
    let (u, y) = (&signals.u, &signals.y);
    let count = u.len();
    let data = DataSet::single(1.0, row(u).to_owned(), row(y).to_owned())?;
    let [mut here, mut factor_only, mut from_data, mut there] = [const { Vec::new() }; 4];
    let mut peer: Option<PeerModel> = None;
    for _ in 0..turns {
        here.push(timed(runs, || ours(u, y)).0);
        if let Some(peers) = peers.as_deref_mut() {
            let found = peers.slicot(HORIZON, ORDER, 'C', runs)?;
            there.push(found.seconds);
            peer = Some(found);
        }
        factor_only.push(timed(runs, || Factor::of_signals(&[(row(u), row(y))], HORIZON, 1.0)).0);
        from_data
            .push(timed(runs, || Factor::new(&data, HORIZON).and_then(|f| model(&f, METHOD))).0);
    }
    let (factor, found) = ours(u, y)?;
    let ms = |seconds: &[f64]| format!("{:.3}", 1e3 * median(seconds));
    let ratio = median(&here) / median(&there);
    let target = if count == SIZES[3].0 { 0.4 } else { 1.0 };
    let predicted = |m: &Innovation| {
        let y_hat = steerwright_sysid::model::predict(
            &m.model,
            m.gain.as_ref(),
            row(u),
            row(y),
            &[0.0; ORDER],
        );
        fit_percent(y, &(0..count).map(|t| y_hat[(0, t)]).collect::<Vec<_>>())
    };
    let of_peer = |f: &dyn Fn(&Innovation) -> f64| {
        peer.as_ref().map_or("–".into(), |p| format!("{:.4}", f(&p.model)))
    };
    println!(
        "| {count} | {} | {} | {ratio:.2} | {} {target} | {} | {} | {:.4} | {} | {:.4} | {} | {} |",
        ms(&here),
        ms(&there),
        if ratio <= target { "≤" } else { "missed:" },
        ms(&factor_only),
        ms(&from_data),
        fit(&found.model, signals),
        of_peer(&|m| fit(&m.model, signals)),
        predicted(&found),
        of_peer(&predicted),
        factor.conditioning,
    );
    Ok(())
}

/// Fits to the noise-free output over several draws of input and noise: one draw is luck.
fn fits(path: &Path, mut peers: Option<&mut Peers>, longest: usize, most: usize) -> Outcome<()> {
    println!(
        "\nFit to the noise-free output, %, median over draws (models of them that are unstable)"
    );
    println!(
        "| samples | draws | MOESP | CVA | N4SID | SLICOT | draws in which MOESP is no worse by 1e-6 |"
    );
    println!("|---|---|---|---|---|---|---|");
    let sizes = [(1_000, 40), (10_000, 20), (100_000, 10), (1_000_000, 3)];
    for (count, draws) in sizes.into_iter().filter(|(count, _)| *count <= longest) {
        let draws = draws.min(most);
        let mut all = [const { Vec::new() }; 4];
        for draw in 0..draws {
            let mut random = Random(1_000 * count as u64 + draw as u64);
            let u = white(count, &mut random);
            let signals = drive(u, NOISE, &mut random);
            let factor = Factor::of_signals(&[(row(&signals.u), row(&signals.y))], HORIZON, 1.0)?;
            for (method, fits) in
                [Weighting::Moesp, Weighting::Cva, Weighting::N4sid].iter().zip(&mut all)
            {
                fits.push(stable_fit(&model(&factor, *method)?.model, &signals));
            }
            if let Some(peers) = peers.as_deref_mut() {
                write_signals(path, &signals.u, &signals.y)?;
                peers.load(path, count)?;
                let found = peers.slicot(HORIZON, ORDER, 'C', 1)?;
                all[3].push(stable_fit(&found.model.model, &signals));
            }
        }
        let cell = |fits: &Vec<f64>| {
            let unstable = fits.iter().filter(|f| **f == f64::NEG_INFINITY).count();
            format!("{:.4} ({unstable})", median(fits))
        };
        let wins = all[0].iter().zip(&all[3]).filter(|(a, b)| **a >= *b - 1e-6).count();
        println!(
            "| {count} | {draws} | {} | {} | {} | {} | {wins} |",
            cell(&all[0]),
            cell(&all[1]),
            cell(&all[2]),
            cell(&all[3])
        );
    }
    Ok(())
}
