//! The share of random systems whose order is found, and the cost of a wrong order.
//!
//! Stable systems of order 1 to 6 in turn with white input and 20 dB of white noise: 5,000 samples, of
//! which the first half estimates and chooses.

use super::options;
use clap::Parser;
use steerwright_evaluation::{Experiment, LARGEST_ORDER, LEAST_SHARE, Random, request};
use steerwright_sysid::{Automatic, DataSet, Error, IdentifyOptions, automatic};

/// Prints how often the order of random systems is found.
#[derive(Parser)]
struct Arguments {
    /// Systems in each experiment
    #[arg(long, default_value_t = 200)]
    systems: usize,
    /// Samples of each system
    #[arg(long, default_value_t = 5000)]
    samples: usize,
    /// Signal-to-noise ratio, dB
    #[arg(long, default_value_t = 20.0)]
    snr: f64,
    /// Seed of the random systems
    #[arg(long, default_value_t = 190)]
    seed: u64,
}

/// Block rows for SLICOT: twice the largest order and more.
const BLOCK_ROWS: usize = 15;

pub(crate) fn run() -> Result<(), String> {
    let arguments: Arguments = options();
    determined(&arguments, false)?;
    determined(&arguments, true)?;
    unfiltered(&arguments)
}

/// The systems whose order can be determined.
fn determined(arguments: &Arguments, feedthrough: bool) -> Result<(), String> {
    let count = if feedthrough { arguments.systems.div_ceil(4) } else { arguments.systems };
    let mut random = Random(arguments.seed);
    let mut right = [0_usize; LARGEST_ORDER];
    let mut requested = [0_usize; LARGEST_ORDER];
    let (mut direct, mut refused) = (0, 0);
    let (mut numbers, mut truth) = (Vec::new(), Vec::new());
    let mut wrong = Vec::new();
    while truth.len() < count {
        let order = 1 + truth.len() % LARGEST_ORDER;
        let e = draw(arguments, &mut random, order, feedthrough);
        let share = e.share_of_last_state(feedthrough);
        if share < LEAST_SHARE {
            refused += 1;
            continue;
        }
        let found = chosen(&e, None).map_err(|e| e.to_string())?;
        let got = found.model.order();
        requested[order - 1] += 1;
        right[order - 1] += usize::from(got == order);
        direct += usize::from((found.model.d[(0, 0)] != 0.0) == feedthrough);
        if got != order {
            wrong.push(format!("{order} → {got} ({:.1} %)", 100.0 * share));
        }
        numbers.extend((0..e.u.ncols()).map(|t| e.u[(0, t)]));
        numbers.extend((0..e.u.ncols()).map(|t| e.noisy[(0, t)]));
        truth.push(order);
    }
    println!(
        "\n{count} systems {} feedthrough whose best model of one order less errs by {} % of the output or more ({refused} others were drawn)",
        if feedthrough { "with" } else { "without" },
        100.0 * LEAST_SHARE,
    );
    print!("  {:<34}", "order");
    (1..=LARGEST_ORDER).for_each(|order| print!("{order:>8}"));
    println!("{:>10}", "all");
    row("right orders", &right, &requested);
    let arguments = [arguments.samples, BLOCK_ROWS].map(|x| x.to_string());
    match request(include_str!("../../python/orders.py"), &numbers, &arguments) {
        Ok(lines) => {
            for (column, name) in
                ["SLICOT (ctrlsys), N4SID", "SLICOT (ctrlsys), MOESP"].into_iter().enumerate()
            {
                let mut right = [0; LARGEST_ORDER];
                for (line, order) in lines.iter().zip(&truth) {
                    let got = line.split_whitespace().nth(column);
                    right[order - 1] += usize::from(got == Some(order.to_string().as_str()));
                }
                row(name, &right, &requested);
            }
        }
        Err(problem) => println!("  left out: SLICOT: {problem}"),
    }
    println!("  feedthrough rightly determined in {direct} of {count}");
    if !wrong.is_empty() {
        println!("  wrong, with the share of the last state: {}", wrong.join(", "));
    }
    Ok(())
}

/// The systems as they come: what a wrong order costs.
fn unfiltered(arguments: &Arguments) -> Result<(), String> {
    let mut random = Random(arguments.seed.wrapping_add(1));
    let (mut worst, mut sum, mut right) = (f64::NEG_INFINITY, 0.0, 0);
    for k in 0..arguments.systems {
        let order = 1 + k % LARGEST_ORDER;
        let e = draw(arguments, &mut random, order, false);
        let free = chosen(&e, None).map_err(|e| e.to_string())?;
        if free.model.order() == order {
            right += 1;
            worst = worst.max(0.0);
            continue;
        }
        let given = chosen(&e, Some(order)).map_err(|e| e.to_string())?;
        let loss = e.clean_fit(&given.model) - e.clean_fit(&free.model);
        worst = worst.max(loss);
        sum += loss;
    }
    println!(
        "\n{} systems as they come: the fit to the output without noise, of the true order less of the chosen one, is {:.2} points on average and at most {worst:.2}; {right} have the true order",
        arguments.systems,
        sum / arguments.systems as f64,
    );
    Ok(())
}

fn draw(a: &Arguments, random: &mut Random, order: usize, feedthrough: bool) -> Experiment {
    Experiment::random(random, order, feedthrough, a.samples, a.snr)
}

fn chosen(e: &Experiment, order: Option<usize>) -> Result<Automatic, Error> {
    let data = DataSet::single(1.0, e.u.clone(), e.noisy.clone())?;
    let [estimation, validation] = steerwright_evaluation::halves(&data)?;
    automatic(&estimation, &validation, &IdentifyOptions { order, ..IdentifyOptions::default() })
}

fn row(name: &str, right: &[usize], requested: &[usize]) {
    print!("  {name:<34}");
    for (right, requested) in right.iter().zip(requested) {
        print!("{:>8}", format!("{right}/{requested}"));
    }
    let all = format!("{}/{}", right.iter().sum::<usize>(), requested.iter().sum::<usize>());
    println!("{all:>10}");
}
