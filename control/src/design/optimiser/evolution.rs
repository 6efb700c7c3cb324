//! Differential evolution (Storn and Price 1997), reproducible.
//!
//! A candidate is `b + F·(p − q)` with random points p and q, and b the best or a random one. It crosses the
//! kinks of a settling time, where a simplex stalls, and replaces a point only where it is no worse.

/// Share of the candidates with b the best point.
const FROM_BEST: f64 = 0.1;
/// Smallest factor F of a difference, and the range above it.
const FACTOR: (f64, f64) = (0.4, 0.5);
/// Probability that a coordinate is the candidate's.
const CROSSOVER: f64 = 0.9;
/// Difference of costs below which the population has converged.
const CONVERGED: f64 = 1e-4;

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Numbers(u64);

impl Numbers {
    /// Uniform in [0, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / 9_007_199_254_740_992.0
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }
}

/// The best point after some generations, with its cost, exact up to its argument; `None` of none.
pub(crate) fn evolve(
    cost: &impl Fn(&[f64], f64) -> f64,
    population: Vec<Vec<f64>>,
    generations: usize,
    stream: u64,
) -> Option<(Vec<f64>, f64)> {
    let mut numbers = Numbers(stream);
    let mut all: Vec<(Vec<f64>, f64)> = population
        .into_iter()
        .map(|x| {
            let c = cost(&x, f64::INFINITY);
            (x, c)
        })
        .collect();
    let n = all.len();
    let mut best = (0..n).min_by(|a, b| all[*a].1.total_cmp(&all[*b].1))?;
    let mut candidate = Vec::new();
    for _ in 0..generations {
        for i in 0..n {
            let (p, q) = (numbers.below(n), numbers.below(n));
            let from = if numbers.next() < FROM_BEST { best } else { numbers.below(n) };
            let factor = FACTOR.0 + FACTOR.1 * numbers.next();
            let own = numbers.below(all[i].0.len());
            candidate.clone_from(&all[i].0);
            for (j, x) in candidate.iter_mut().enumerate() {
                if j == own || numbers.next() < CROSSOVER {
                    *x = all[from].0[j] + factor * (all[p].0[j] - all[q].0[j]);
                }
            }
            let now = cost(&candidate, all[i].1);
            if now <= all[i].1 {
                std::mem::swap(&mut all[i].0, &mut candidate);
                all[i].1 = now;
                if now < all[best].1 {
                    best = i;
                }
            }
        }
        let worst = all.iter().map(|(_, c)| *c).fold(f64::NEG_INFINITY, f64::max);
        if worst - all[best].1 < CONVERGED {
            break;
        }
    }
    Some(all.swap_remove(best))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::optimiser::sequence;

    /// Plateaus around the minimum of 0 at (1, −2), on which a descent stops.
    #[test]
    fn finds_the_minimum_behind_plateaus() {
        let cost = |x: &[f64], _: f64| {
            let plateau = if x[0] > 0.8 && x[0] < 1.2 { 0.0 } else { 3.0 + x[0].abs().floor() };
            plateau + (x[0] - 1.0).abs() + (x[1] + 2.0).powi(2)
        };
        let begin = || sequence(&[(-4.0, 4.0), (-4.0, 4.0)], 20, 1);
        let (x, least) = evolve(&cost, begin(), 80, 1).unwrap();
        assert!(least < 1e-3 && (x[0] - 1.0).abs() < 1e-3 && (x[1] + 2.0).abs() < 0.03, "{x:?}");
        assert_eq!(evolve(&cost, begin(), 80, 1).unwrap().0, x);
        // Evaluations that end early change nothing.
        let bounded = |x: &[f64], most: f64| {
            let all = cost(x, most);
            if all > most { 0.5 * (all + most) } else { all }
        };
        assert_eq!(evolve(&bounded, begin(), 80, 1).unwrap().0, x);
        assert!(evolve(&cost, Vec::new(), 80, 1).is_none());
    }
}
