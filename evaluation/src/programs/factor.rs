//! `cargo xtask evaluate factor`: what is identified from an R factor compared with what is identified
//! from the same samples in memory, on the random systems whose order can be determined, and with a
//! driver in the loop.
//!
//! The systems are made as those of `orders`: of order 1 to 6 in turn with white input and white noise
//! on the output; both are given the first half of each record.

use super::options;
use clap::Parser;
use steerwright_evaluation::bias::{Biases, Errors};
use steerwright_evaluation::driver::Drive;
use steerwright_evaluation::measure::cell;
use steerwright_evaluation::{
    AccumulatedSignals, Experiment, LARGEST_ORDER, LEAST_SHARE, Random, halves, on_all_cores,
};
use steerwright_sysid::{
    AccumulateOptions, DataSet, Error, IdentifyOptions, StateSpace, automatic,
};

/// Prints how often an R factor and the samples in memory lead to the same order.
#[derive(Parser)]
struct Arguments {
    /// Systems
    #[arg(long, default_value_t = 36)]
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
    #[arg(long, default_value_t = AccumulateOptions::default().horizon)]
    horizon: usize,
    /// Records with a driver in the loop
    #[arg(long, default_value_t = 6)]
    drives: u64,
    /// Samples of each of these
    #[arg(long, default_value_t = 40_000)]
    drive_samples: usize,
}

const SAMPLE_TIME_S: f64 = 0.05;

pub(crate) fn run() -> Result<(), Error> {
    let arguments: Arguments = options();
    if arguments.systems > 0 {
        open_loop(&arguments)?;
    }
    if arguments.drives > 1 {
        in_a_loop(&arguments)?;
    }
    Ok(())
}

/// A random system, identified both ways.
struct Both {
    order: usize,
    /// Orders found in memory and from the factor.
    found: [usize; 2],
    /// Fit in memory less that from the factor, points.
    loss: f64,
}

/// The system of that number: each has its own random numbers.
fn both(arguments: &Arguments, number: usize) -> Result<Both, Error> {
    let order = 1 + number % LARGEST_ORDER;
    let mut random = Random(arguments.seed.wrapping_add(1_000_003 * number as u64));
    let e = loop {
        let e = Experiment::random(&mut random, order, false, arguments.samples, arguments.snr);
        if e.share_of_last_state(false) >= LEAST_SHARE {
            break e;
        }
    };
    let data = DataSet::single(SAMPLE_TIME_S, e.u.clone(), e.noisy.clone())?;
    let [estimation, validation] = halves(&data)?;
    let options = IdentifyOptions::default();
    let memory = automatic(&estimation, &validation, &options)?.model;
    let factor = AccumulatedSignals::new(&estimation, arguments.horizon)?.identify(&options)?.model;
    let loss = e.clean_fit(&memory) - e.clean_fit(&factor);
    Ok(Both { order, found: [memory.order(), factor.order()], loss })
}

/// Random systems without feedback.
fn open_loop(arguments: &Arguments) -> Result<(), Error> {
    let (mut same, mut right) = (0, [0; 2]);
    let mut losses = Vec::new();
    let mut apart = Vec::new();
    for system in on_all_cores("random systems", arguments.systems, |k| both(arguments, k)) {
        let Both { order, found, loss } = system?;
        same += usize::from(found[0] == found[1]);
        for (right, got) in right.iter_mut().zip(found) {
            *right += usize::from(got == order);
        }
        losses.push(loss);
        if found[0] != found[1] {
            apart.push(format!("{order} → {}, {} ({loss:.2})", found[0], found[1]));
        }
    }
    let count = losses.len();
    losses.sort_by(f64::total_cmp);
    let mean = losses.iter().sum::<f64>() / count as f64;
    println!(
        "{count} systems whose best model of one order less errs by {} % of the output or more",
        100.0 * LEAST_SHARE
    );
    println!("  the same order from the factor as in memory: {same}/{count}");
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

/// The same vehicle with a driver in the loop, by both ways.
fn in_a_loop(arguments: &Arguments) -> Result<(), Error> {
    let truth = Drive::vehicle();
    println!(
        "\n{} records of {} samples with a driver in the loop; mean error ± half its 95 % interval, * outside it",
        arguments.drives, arguments.drive_samples
    );
    println!("{:<32}{:>20}{:>20}{:>22}  orders", "", "response %", "gain %", "slowest pole");
    for order in [Some(truth.order()), None] {
        let options = IdentifyOptions { order, ..IdentifyOptions::default() };
        let what = if order.is_some() { "order given" } else { "order chosen" };
        let identified = on_all_cores(what, arguments.drives as usize, |seed| {
            identified(arguments, &options, seed as u64)
        });
        let mut rows: [(&str, Vec<StateSpace>); 2] =
            [("in memory", Vec::new()), ("from the factor", Vec::new())];
        let mut feedback = 0;
        for drive in identified {
            let ([memory, factor], found) = drive?;
            rows[0].1.push(memory);
            rows[1].1.push(factor);
            feedback += u64::from(found);
        }
        for (name, models) in &rows {
            let errors: Vec<Errors> =
                models.iter().filter_map(|m| Errors::new(m, &truth)).collect();
            let b = Biases::new(&errors);
            let orders: Vec<String> = models.iter().map(|m| m.order().to_string()).collect();
            println!(
                "{:<32}{:>20}{:>20}{:>22}  {}",
                format!("{what}, {name}"),
                cell(b.response, 100.0, 2),
                cell(b.gain, 100.0, 2),
                cell(b.pole, 1.0, 4),
                if order.is_some() { String::new() } else { orders.join(" ") }
            );
        }
        println!("  feedback found by the factor in {feedback} of {}", arguments.drives);
    }
    Ok(())
}

/// A record identified in memory and from the factor, and whether the factor found feedback.
fn identified(
    arguments: &Arguments,
    options: &IdentifyOptions,
    seed: u64,
) -> Result<([StateSpace; 2], bool), Error> {
    let data = Drive::controlled().record(arguments.drive_samples, seed)?;
    // A factor keeps a fourth of the samples for validation.
    let cut = 3 * arguments.drive_samples / 4;
    let [estimation, validation] = [0..cut, cut..arguments.drive_samples].map(|range| {
        let s = &data.segments()[0];
        DataSet::single(data.sample_time_s(), s.u.columns(range.clone()), s.y.columns(range))
    });
    let memory = automatic(&estimation?, &validation?, options)?.model;
    let factor = AccumulatedSignals::new(&data, arguments.horizon)?.identify(options)?;
    Ok(([memory, factor.model], factor.feedback))
}
