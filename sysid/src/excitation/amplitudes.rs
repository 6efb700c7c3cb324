//! The amplitudes of a multisine, as a convex problem in the power p of each tone (Goodwin and Payne, *Dynamic System
//! Identification: Experiment Design and Data Analysis*, 1977; Bombois and others, *Least costly identification experiment for
//! control*, 2006):
//!
//! ```text
//! minimise    max_i c_iᵀ·M(p)⁻¹·c_i,   M(p) = M₀ + Σ p_k·M_k
//! such that   Σ p_k·h_jk ≤ 1,  p ≥ 0
//! ```
//!
//! M₀ is the information of the priors, M_k that of a tone of power 1, and h_jk the mean square of a limited quantity over the
//! square of its limit. A signal within a limit has a mean square within its square, so that the optimum bounds what any signal
//! of these tones within the limits reaches. It is solved by the barrier method with Newton's steps (Boyd and Vandenberghe,
//! *Convex Optimization*, 2004, 11.3), whose gap follows from the number of inequalities.

use super::criterion::{Criterion, Factor, Square};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Largest gap of the optimum, as a share of it.
pub(super) const GAP: f64 = 1e-4;
/// Factor between the barrier's weights.
const GROWTH: f64 = 8.0;
/// Newton steps for each weight, and halvings of a step.
const STEPS: usize = 60;
const HALVINGS: usize = 50;

/// Tones whose powers are optimised.
pub(super) struct Tones<'a> {
    pub(super) criterion: &'a Criterion,
    /// M₀.
    pub(super) prior: &'a [f64],
    /// M_k.
    pub(super) information: Vec<Square>,
    /// h_jk, a row for each limit.
    pub(super) shares: Vec<Vec<f64>>,
}

/// The optimum.
#[derive(Debug, Clone)]
pub(super) struct Amplitudes {
    /// Power of each tone.
    pub(super) power: Vec<f64>,
    /// Largest variance.
    pub(super) largest: f64,
    /// Largest variance below which no powers within the limits get.
    pub(super) bound: f64,
}

/// A point of the barrier method: powers, and t above all variances.
struct Point {
    power: Vec<f64>,
    t: f64,
}

/// Value, gradient and Hessian of the barrier function, with t last.
struct Local {
    gradient: Vec<f64>,
    hessian: Mat<f64>,
}

impl Tones<'_> {
    fn information(&self, power: &[f64]) -> Square {
        let mut sum = self.prior.to_vec();
        for (p, m) in power.iter().zip(&self.information) {
            for (s, m) in sum.iter_mut().zip(m) {
                *s += p * m;
            }
        }
        sum
    }

    fn rests(&self, power: &[f64]) -> Vec<f64> {
        let used = |row: &Vec<f64>| row.iter().zip(power).map(|(h, p)| h * p).sum::<f64>();
        self.shares.iter().map(|row| 1.0 - used(row)).collect()
    }

    fn inequalities(&self) -> f64 {
        (self.criterion.gradients.len() + self.shares.len() + self.information.len()) as f64
    }

    /// `weight·t − Σ ln`; infinite outside of the limits.
    fn value(&self, at: &Point, weight: f64) -> f64 {
        let Some(factor) = Factor::new(&self.information(&at.power), self.criterion.size) else {
            return f64::INFINITY;
        };
        let above = self.criterion.gradients.iter().map(|c| at.t - factor.variance(c));
        let mut sum = weight * at.t;
        for rest in above.chain(self.rests(&at.power)).chain(at.power.iter().copied()) {
            if rest.is_nan() || rest <= 0.0 {
                return f64::INFINITY;
            }
            sum -= rest.ln();
        }
        sum
    }

    fn local(&self, at: &Point, weight: f64) -> Option<Local> {
        let (n, count) = (self.criterion.size, at.power.len());
        let factor = Factor::new(&self.information(&at.power), n)?;
        let mut gradient = vec![0.0; count + 1];
        let mut hessian = Mat::<f64>::zeros(count + 1, count + 1);
        gradient[count] = weight;
        for c in &self.criterion.gradients {
            let x = factor.solve(c);
            let above = at.t - factor.variance(c);
            // y_k = M_k·x; the variance changes by −xᵀ·y_k and curves by 2·y_kᵀ·M⁻¹·y_l.
            let mut slopes = Vec::with_capacity(count);
            let mut halves = Vec::with_capacity(count);
            for m in &self.information {
                let y: Vec<f64> = m
                    .chunks_exact(n)
                    .map(|row| row.iter().zip(&x).map(|(m, x)| m * x).sum())
                    .collect();
                slopes.push(-x.iter().zip(&y).map(|(x, y)| x * y).sum::<f64>());
                halves.push(factor.half_solve(&y));
            }
            let inverse = 1.0 / above;
            for k in 0..count {
                gradient[k] += slopes[k] * inverse;
                for l in 0..=k {
                    let curve: f64 = halves[k].iter().zip(&halves[l]).map(|(a, b)| a * b).sum();
                    hessian[(k, l)] +=
                        2.0 * curve * inverse + slopes[k] * slopes[l] * inverse * inverse;
                }
                hessian[(count, k)] -= slopes[k] * inverse * inverse;
            }
            gradient[count] -= inverse;
            hessian[(count, count)] += inverse * inverse;
        }
        for (row, rest) in self.shares.iter().zip(self.rests(&at.power)) {
            for k in 0..count {
                gradient[k] += row[k] / rest;
                for l in 0..=k {
                    hessian[(k, l)] += row[k] * row[l] / (rest * rest);
                }
            }
        }
        for (k, p) in at.power.iter().enumerate() {
            gradient[k] -= 1.0 / p;
            hessian[(k, k)] += 1.0 / (p * p);
        }
        Some(Local { gradient, hessian })
    }

    /// A Newton step; the squared decrement, or `None` where the step is not found.
    fn newton(&self, at: &mut Point, weight: f64) -> Option<f64> {
        let local = self.local(at, weight)?;
        let count = local.gradient.len();
        // Powers differ by orders: the Hessian is scaled to a unit diagonal.
        let scale: Vec<f64> = (0..count).map(|k| local.hessian[(k, k)].sqrt()).collect();
        let scaled = Mat::from_fn(count, count, |i, j| {
            let (i, j) = (i.max(j), i.min(j));
            local.hessian[(i, j)] / (scale[i] * scale[j])
        });
        let right = Mat::from_fn(count, 1, |i, _| -local.gradient[i] / scale[i]);
        let solved = scaled.llt(Side::Lower).ok()?.solve(&right);
        let step: Vec<f64> = (0..count).map(|i| solved[(i, 0)] / scale[i]).collect();
        let slope: f64 = step.iter().zip(&local.gradient).map(|(s, g)| s * g).sum();
        let before = self.value(at, weight);
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            let power = at.power.iter().zip(&step).map(|(p, s)| p + length * s).collect();
            let next = Point { power, t: at.t + length * step[count - 1] };
            if self.value(&next, weight) <= before + 0.1 * length * slope {
                *at = next;
                return Some(-slope);
            }
            length *= 0.5;
        }
        None
    }

    /// The optimum; `None` where the information is singular for all powers.
    pub(super) fn optimise(&self) -> Option<Amplitudes> {
        let count = self.information.len();
        let largest_share: Vec<f64> = (0..count)
            .map(|k| self.shares.iter().map(|row| row[k]).fold(f64::MIN_POSITIVE, f64::max))
            .collect();
        let power: Vec<f64> = largest_share.iter().map(|h| 0.5 / (count as f64 * h)).collect();
        let t = 2.0 * self.criterion.largest(&self.information(&power))?;
        let mut at = Point { power, t };
        let mut weight = self.inequalities() / at.t;
        loop {
            for _ in 0..STEPS {
                match self.newton(&mut at, weight) {
                    Some(decrement) if decrement > 1e-8 => {}
                    Some(_) | None => break,
                }
            }
            let gap = self.inequalities() / weight;
            let largest = self.criterion.largest(&self.information(&at.power))?;
            // The steps end at rounding: a weight beyond does not tighten the bound.
            if gap < GAP * largest || weight > 1e15 / at.t {
                return Some(Amplitudes { bound: at.t - gap, power: at.power, largest });
            }
            weight *= GROWTH;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tones(criterion: &Criterion, prior: &[f64], information: Vec<Square>) -> Amplitudes {
        let shares = vec![vec![1.0; information.len()], vec![1.0, 0.5, 2.0]];
        Tones { criterion, prior, information, shares }.optimise().unwrap()
    }

    /// Two parameters, of which the first two tones inform one each: with equal variances wanted, the powers that minimise
    /// max(1/(4·p₁), 1/p₂) with p₁ + p₂ = 1 are 1/5 and 4/5, by hand.
    #[test]
    fn powers_of_two_independent_parameters() {
        let criterion = Criterion { size: 2, gradients: vec![vec![1.0, 0.0], vec![0.0, 1.0]] };
        let information =
            vec![vec![4.0, 0.0, 0.0, 0.0], vec![0.0, 0.0, 0.0, 1.0], vec![0.1, 0.0, 0.0, 0.1]];
        let found = tones(&criterion, &[1e-9, 0.0, 0.0, 1e-9], information);
        assert!((found.power[0] - 0.2).abs() < 1e-3, "{found:?}");
        assert!((found.power[1] - 0.8).abs() < 1e-3, "{found:?}");
        assert!(found.power[2] < 1e-3, "{found:?}");
        assert!((found.largest - 1.25).abs() < 1e-3, "{found:?}");
        let gap = (found.largest - found.bound) / found.largest;
        assert!((0.0..=2.0 * GAP).contains(&gap), "{gap:e}");
    }

    /// No random powers within the limits are below the bound.
    #[test]
    fn the_bound_is_one() {
        let criterion =
            Criterion { size: 2, gradients: vec![vec![1.0, 0.5], vec![-0.3, 1.0], vec![1.0, 1.0]] };
        let information: Vec<Square> =
            vec![vec![4.0, 1.0, 1.0, 2.0], vec![0.5, -0.2, -0.2, 1.0], vec![3.0, -1.0, -1.0, 6.0]];
        let prior = [0.3, 0.0, 0.0, 0.1];
        let found = tones(&criterion, &prior, information.clone());
        let mut least = f64::INFINITY;
        for k in 1..5000_u32 {
            let spread = |step: f64| (f64::from(k) * step).fract();
            let raw = [spread(0.618_034), spread(0.414_214), spread(0.732_051)];
            let used = raw.iter().sum::<f64>().max(raw[0] + 0.5 * raw[1] + 2.0 * raw[2]);
            let mut sum = prior.to_vec();
            for (p, m) in raw.iter().zip(&information) {
                for (s, m) in sum.iter_mut().zip(m) {
                    *s += p / used * m;
                }
            }
            least = least.min(criterion.largest(&sum).unwrap());
        }
        assert!(found.bound <= least, "{} {least}", found.bound);
        assert!(found.largest < 1.01 * least, "{} {least}", found.largest);
    }
}
