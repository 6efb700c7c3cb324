//! Minimisation of a function with kinks, reproducible and without derivatives.
//!
//! Nelder–Mead (`simplex`) from several starting points, or differential evolution (`evolution`) on
//! separate islands. The best few points are polished by Nelder–Mead with a new simplex, since it may stall
//! where the cost has a kink.

mod evolution;
mod simplex;

use crate::Error;
use crate::design::parallel::each;
use evolution::evolve;
use simplex::descend;

/// Iterations of each start.
const ITERATIONS: u64 = 120;
/// Size of the first simplex, and of a polish.
const SIMPLEX: f64 = 0.4;
const SMALL_SIMPLEX: f64 = 0.12;

/// The effort of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Effort {
    /// Number of populations and generations; without populations, number of starting points to descend
    /// from, those of least cost.
    pub(crate) islands: usize,
    pub(crate) generations: usize,
    pub(crate) begin: usize,
    /// Number of points that are polished, times that each is, and iterations of each time.
    pub(crate) keep: usize,
    pub(crate) restarts: usize,
    pub(crate) polish: u64,
}

/// The effort where no good point is known.
pub(crate) const EVOLVED: Effort =
    Effort { islands: 2, generations: 90, begin: 0, keep: 2, restarts: 2, polish: 200 };
/// The effort of repeating such a search with better starting points.
pub(crate) const SHORT: Effort = Effort { generations: 60, ..EVOLVED };
/// The effort from two good starting points.
pub(crate) const TWICE: Effort = Effort { begin: 2, keep: 2, ..QUICK };
/// The effort from the gains of nearly the same plants.
pub(crate) const NEAR: Effort = Effort { restarts: 2, ..QUICK };
/// The effort from a good starting point.
pub(crate) const QUICK: Effort =
    Effort { islands: 0, generations: 0, begin: 1, keep: 1, restarts: 1, polish: 120 };

/// The points found, from the best on, each with its cost.
pub(crate) type Points = Vec<(Vec<f64>, f64)>;

/// The points found; `cost` takes a point and a cost beyond which it need not be exact.
pub(crate) fn minimise(
    cost: &(impl Fn(&[f64], f64) -> f64 + Sync),
    starts: &[Vec<f64>],
    effort: Effort,
) -> Result<Points, Error> {
    let mut found = if effort.islands == 0 {
        let down = |start: &Vec<f64>| descend(cost, start, SIMPLEX, ITERATIONS);
        if effort.begin < starts.len() {
            let mut starts = each(starts, |x| (x.clone(), cost(x, f64::INFINITY)))?;
            // A stable sort: equal costs keep the order of the starts.
            starts.sort_by(|a, b| a.1.total_cmp(&b.1));
            starts.truncate(effort.begin);
            each(&starts, |(start, _)| down(start))?
        } else {
            each(starts, down)?
        }
    } else {
        let island = |i: usize| -> Vec<Vec<f64>> {
            starts.iter().skip(i).step_by(effort.islands).cloned().collect()
        };
        let islands: Vec<usize> = (0..effort.islands.min(starts.len())).collect();
        let evolved = each(&islands, |i| evolve(cost, island(*i), effort.generations, *i as u64))?;
        evolved.into_iter().flatten().collect()
    };
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let kept = effort.keep.min(found.len());
    let polished = each(&found[..kept], |candidate| {
        let mut best = candidate.clone();
        for _ in 0..effort.restarts {
            let polished = descend(cost, &best.0, SMALL_SIMPLEX, effort.polish);
            if polished.1 < best.1 {
                best = polished;
            }
        }
        best
    })?;
    found.splice(..kept, polished);
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    if found.is_empty() {
        return Err(Error::Optimiser("nothing to start from".into()));
    }
    Ok(found)
}

/// The first points in a box of the additive recurrence of Roberts (2018), `xₙ = frac(seed + n·α)` with
/// αᵢ = φ⁻ⁱ and φ the positive root of φ^{d+1} = φ + 1.
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

#[cfg(test)]
mod tests {
    use super::*;

    const THOROUGH: Effort =
        Effort { islands: 0, generations: 0, begin: 99, keep: 3, restarts: 2, polish: 250 };

    /// Rosenbrock's valley, minimum 0 at (1, 1).
    #[test]
    fn finds_the_end_of_a_curved_valley() {
        let valley =
            |x: &[f64], _: f64| (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2);
        let box_ = [(-2.0, 2.0), (-1.0, 3.0)];
        let mut starts = sequence(&box_, 6, 3);
        starts.insert(0, vec![-1.2, 1.0]);
        let (x, cost) = minimise(&valley, &starts, THOROUGH).unwrap().remove(0);
        assert!(cost < 1e-5 && (x[0] - 1.0).abs() < 0.01, "{x:?} {cost}");
        assert_eq!(minimise(&valley, &starts, THOROUGH).unwrap()[0].0, x);
    }

    #[test]
    fn starts_lie_in_the_box_and_differ_by_seed() {
        let box_ = [(0.0, 1.0), (-3.0, -2.0), (5.0, 6.0)];
        let a = sequence(&box_, 6, 1);
        assert!(a.iter().all(|x| x.iter().zip(box_).all(|(x, (l, h))| (l..=h).contains(x))));
        assert_ne!(a, sequence(&box_, 6, 2));
    }
}
