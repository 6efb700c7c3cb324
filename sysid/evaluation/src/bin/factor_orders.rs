//! `cargo xtask evaluate factor_orders`: what is identified from a factor beside what is identified from
//! the same samples in memory, on the random systems whose order can be told.
//!
//! Stable systems of order 1 to 6 in turn with white input and white noise on the output, as in
//! `orders`; both are given the first half of each record.

use clap::Parser;
use faer::Mat;
use std::fmt::Write;
use sysid::{
    AbsorbOptions, Absorbed, DataSet, IdentifyOptions, LogFile, LogOptions, StateSpace, automatic,
};
use sysid_evaluation::{Experiment, Random, halves};

/// Prints how often a factor and the samples in memory give the same order.
#[derive(Parser)]
struct Arguments {
    /// Systems
    #[arg(long, default_value_t = 200)]
    systems: usize,
    /// Samples of each system, of which the first half is identified from
    #[arg(long, default_value_t = 5000)]
    samples: usize,
    /// Signal-to-noise ratio, dB
    #[arg(long, default_value_t = 20.0)]
    snr: f64,
    /// Seed of the random systems
    #[arg(long, default_value_t = 190)]
    seed: u64,
    /// Block rows of the factor
    #[arg(long, default_value_t = AbsorbOptions::default().horizon)]
    horizon: usize,
}

/// The best model of one order less must err by this share of the output's root mean square.
const LEAST_SHARE: f64 = 0.02;
const LARGEST_ORDER: usize = 6;
const SAMPLE_TIME_S: f64 = 0.05;
/// Signals of such a spread are of a size that a road wheel and a car have, rad and rad/s.
const SPREADS: [f64; 2] = [0.01, 0.1];

fn main() -> Result<(), String> {
    let arguments = Arguments::parse();
    let mut random = Random(arguments.seed);
    let (mut both, mut right) = (0, [0; 2]);
    let mut losses = Vec::new();
    let mut apart = Vec::new();
    while losses.len() < arguments.systems {
        let order = 1 + losses.len() % LARGEST_ORDER;
        let e = Experiment::random(&mut random, order, false, arguments.samples, arguments.snr);
        if e.share_of_last_state(false) < LEAST_SHARE {
            continue;
        }
        let data = DataSet::single(SAMPLE_TIME_S, e.u.clone(), e.noisy.clone());
        let [estimation, held_out] =
            data.and_then(|d| halves(&d)).map_err(|problem| problem.to_string())?;
        let memory = automatic(&estimation, &held_out, &IdentifyOptions::default())
            .map_err(|problem| problem.to_string())?
            .model;
        let factor = from_factor(&estimation, arguments.horizon)
            .map_err(|problem| format!("a system of order {order}: {problem}"))?;
        let orders = [memory.order(), factor.order()];
        both += usize::from(orders[0] == orders[1]);
        for (right, got) in right.iter_mut().zip(orders) {
            *right += usize::from(got == order);
        }
        let loss = e.clean_fit(&memory) - e.clean_fit(&factor);
        losses.push(loss);
        if orders[0] != orders[1] {
            apart.push(format!("{order} → {}, {} ({loss:.2})", orders[0], orders[1]));
        }
    }
    let count = losses.len();
    losses.sort_by(f64::total_cmp);
    let mean = losses.iter().sum::<f64>() / count as f64;
    println!(
        "{count} systems whose best model of one order less errs by {} % of the output or more",
        100.0 * LEAST_SHARE
    );
    println!("  the same order from the factor as in memory: {both}/{count}");
    println!(
        "  the right order: {}/{count} in memory, {}/{count} from the factor",
        right[0], right[1]
    );
    println!(
        "  fit to the output without noise, in memory less from the factor: {mean:.2} points on average, median {:.2}, from {:.2} to {:.2}",
        losses[count / 2],
        losses[0],
        losses[count - 1]
    );
    if !apart.is_empty() {
        println!(
            "  apart (right → in memory, from the factor, points of fit lost): {}",
            apart.join(", ")
        );
    }
    Ok(())
}

/// The model from the inputs to the outputs of `data` that its factor gives.
fn from_factor(data: &DataSet, horizon: usize) -> Result<StateSpace, String> {
    let segment = &data.segments()[0];
    let spread = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
    let [u, y] = [segment.u.row(0), segment.y.row(0)];
    let [to_u, to_y] = [SPREADS[0] / spread(u), SPREADS[1] / spread(y)];
    let mut csv = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps\n");
    for (t, (u, y)) in u.iter().zip(y).enumerate() {
        let _ = writeln!(csv, "{:.2},{:e},{:e}", SAMPLE_TIME_S * t as f64, to_u * u, to_y * y);
    }
    let log = LogOptions { sample_time_s: Some(SAMPLE_TIME_S), ..LogOptions::default() };
    let options = AbsorbOptions { log, horizon, ..AbsorbOptions::default() };
    let plant = Absorbed::of_log(LogFile::of_bytes("drive.csv", csv.as_bytes()), &options)
        .and_then(|state| state.identify(&IdentifyOptions::default()))
        .map_err(|problem| problem.to_string())?;
    let d = &plant.discrete;
    let [a, b, c, d] =
        [(&d.a, 1.0), (&d.b, to_u), (&d.c, 1.0 / to_y), (&d.d, to_u / to_y)].map(|(m, factor)| {
            Mat::from_fn(m.rows(), m.columns().unwrap_or(0), |i, j| factor * m.at(i, j))
        });
    Ok(StateSpace { a, b, c, d })
}
