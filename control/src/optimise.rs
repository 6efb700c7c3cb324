//! Nelder–Mead from several starting points, the same each time.
//!
//! The starts are the caller's own guesses and points of the additive recurrence of Roberts (2018),
//! `xₙ = frac(seed + n·α)` with αᵢ = φ⁻ⁱ and φ the positive root of φ^{d+1} = φ + 1: a
//! low-discrepancy sequence without a random number. The best few are restarted with a fresh
//! simplex, since Nelder–Mead may stall where the cost has a kink.

use crate::Error;
use argmin::core::{CostFunction, Executor, State};
use argmin::solver::neldermead::NelderMead;

/// Iterations of each start, and of a restart.
const ITERATIONS: u64 = 120;
const POLISH: u64 = 250;
/// Size of the first simplex, and of a restart's.
const SIMPLEX: f64 = 0.4;
const SMALL_SIMPLEX: f64 = 0.12;

struct Cost<'a, F>(&'a F);

impl<F: Fn(&[f64]) -> f64> CostFunction for Cost<'_, F> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Self::Param) -> Result<f64, argmin::core::Error> {
        Ok((self.0)(x))
    }
}

/// The best point found and its cost, from these starts, the best `keep` of which are restarted.
pub(crate) fn minimise(
    cost: &impl Fn(&[f64]) -> f64,
    starts: &[Vec<f64>],
    keep: usize,
) -> Result<(Vec<f64>, f64), Error> {
    let mut found = starts
        .iter()
        .map(|start| descend(cost, start, SIMPLEX, ITERATIONS))
        .collect::<Result<Vec<_>, _>>()?;
    // A stable sort: equal costs keep the order of the starts.
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found.truncate(keep);
    for candidate in &mut found {
        for size in [SMALL_SIMPLEX, SMALL_SIMPLEX] {
            let polished = descend(cost, &candidate.0, size, POLISH)?;
            if polished.1 < candidate.1 {
                *candidate = polished;
            }
        }
    }
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found.into_iter().next().ok_or_else(|| Error::Optimiser("nothing to start from".into()))
}

/// The first points of the recurrence in a box.
pub(crate) fn sequence(box_: &[(f64, f64)], count: u32, seed: u64) -> Vec<Vec<f64>> {
    let dimensions = box_.len() as i32;
    let mut phi = 2.0_f64;
    for _ in 0..60 {
        phi = (1.0 + phi).powf(1.0 / f64::from(dimensions + 1));
    }
    // Seeds shift the sequence by multiples of the golden ratio's fraction.
    let shift = (seed % 1_000_000) as f64 * 0.618_033_988_749_894_9;
    (1..=count)
        .map(|n| {
            box_.iter()
                .zip(1..)
                .map(|((low, high), i)| {
                    let u = (shift + 0.5 + f64::from(n) * phi.powi(-i)).fract();
                    low + u * (high - low)
                })
                .collect()
        })
        .collect()
}

fn descend(
    cost: &impl Fn(&[f64]) -> f64,
    start: &[f64],
    size: f64,
    iterations: u64,
) -> Result<(Vec<f64>, f64), Error> {
    let mut simplex = vec![start.to_vec()];
    for i in 0..start.len() {
        let mut vertex = start.to_vec();
        vertex[i] += size;
        simplex.push(vertex);
    }
    let stopped = |e: argmin::core::Error| Error::Optimiser(e.to_string());
    let solver = NelderMead::new(simplex).with_sd_tolerance(1e-6).map_err(stopped)?;
    let result = Executor::new(Cost(cost), solver)
        .configure(|state| state.max_iters(iterations))
        .timer(false)
        .run()
        .map_err(stopped)?;
    let state = result.state();
    let best = state.get_best_param().cloned().unwrap_or_else(|| start.to_vec());
    Ok((best, state.get_best_cost()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley, minimum 0 at (1, 1).
    #[test]
    fn finds_the_end_of_a_curved_valley() {
        let valley = |x: &[f64]| (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2);
        let box_ = [(-2.0, 2.0), (-1.0, 3.0)];
        let mut starts = sequence(&box_, 6, 3);
        starts.insert(0, vec![-1.2, 1.0]);
        let (x, cost) = minimise(&valley, &starts, 2).unwrap();
        assert!(cost < 1e-5 && (x[0] - 1.0).abs() < 0.01, "{x:?} {cost}");
        assert_eq!(minimise(&valley, &starts, 2).unwrap().0, x);
    }

    #[test]
    fn starts_lie_in_the_box_and_differ_by_seed() {
        let box_ = [(0.0, 1.0), (-3.0, -2.0), (5.0, 6.0)];
        let a = sequence(&box_, 6, 1);
        assert!(a.iter().all(|x| x.iter().zip(box_).all(|(x, (l, h))| (l..=h).contains(x))));
        assert_ne!(a, sequence(&box_, 6, 2));
    }
}
