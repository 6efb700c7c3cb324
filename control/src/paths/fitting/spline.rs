//! Penalised cubic B-splines on a uniform grid (P-splines; Eilers and Marx 1996).
//!
//! Minimises `Σ (vᵢ − f(tᵢ))² + μ ∫ f‴(t)² dt` over cubic splines f, by a banded Cholesky factorisation. With
//! ρ points a unit length, a wave of length λ passes by the share `1/(1 + (μ/ρ)(2π/λ)⁶)`.

use std::f64::consts::TAU;

/// Subdiagonals of the normal matrix.
const BAND: usize = 3;

/// The μ that halves waves of length `cutoff` in `density` points a unit length.
pub(crate) fn penalty(cutoff: f64, density: f64) -> f64 {
    density * (cutoff / TAU).powi(6)
}

/// A cubic spline on `[start, start + intervals·step]`.
#[derive(Debug, Clone)]
pub(crate) struct Spline {
    start: f64,
    step: f64,
    /// Intervals + 3 coefficients.
    coefficients: Vec<f64>,
}

/// The four basis functions that live on an interval, at its fraction `u`.
fn basis(u: f64) -> [f64; 4] {
    let v = 1.0 - u;
    [
        v * v * v / 6.0,
        (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
        (-3.0 * u * u * u + 3.0 * u * u + 3.0 * u + 1.0) / 6.0,
        u * u * u / 6.0,
    ]
}

fn basis_first(u: f64) -> [f64; 4] {
    let v = 1.0 - u;
    [-0.5 * v * v, 1.5 * u * u - 2.0 * u, -1.5 * u * u + u + 0.5, 0.5 * u * u]
}

fn basis_second(u: f64) -> [f64; 4] {
    [1.0 - u, 3.0 * u - 2.0, 1.0 - 3.0 * u, u]
}

/// The factor of the normal matrix, for any number of right-hand sides.
pub(crate) struct Fitter {
    start: f64,
    step: f64,
    parameters: Vec<f64>,
    /// Lower triangle, row by row: entry `[i][k]` is column `i − k`.
    factor: Vec<[f64; BAND + 1]>,
}

impl Fitter {
    /// Prepares fits at the parameters `t`, all within the grid; `None` where they are too few.
    pub(crate) fn new(t: &[f64], start: f64, step: f64, intervals: usize, mu: f64) -> Option<Self> {
        let n = intervals + 3;
        let mut matrix = vec![[0.0; BAND + 1]; n];
        for &t in t {
            let (first, u) = locate(t, start, step, n);
            let b = basis(u);
            for i in 0..4 {
                for j in 0..=i {
                    matrix[first + i][i - j] += b[i] * b[j];
                }
            }
        }
        // f‴ is constant on each interval: the third difference of its coefficients over step³.
        let difference = [-1.0, 3.0, -3.0, 1.0];
        let weight = mu / step.powi(5);
        for first in 0..n - 3 {
            for i in 0..4 {
                for j in 0..=i {
                    matrix[first + i][i - j] += weight * difference[i] * difference[j];
                }
            }
        }
        cholesky(&mut matrix)?;
        Some(Self { start, step, parameters: t.to_vec(), factor: matrix })
    }

    /// The spline nearest the values at the parameters.
    pub(crate) fn fit(&self, values: &[f64]) -> Spline {
        let n = self.factor.len();
        let mut c = vec![0.0; n];
        for (&t, &value) in self.parameters.iter().zip(values) {
            let (first, u) = locate(t, self.start, self.step, n);
            for (i, b) in basis(u).into_iter().enumerate() {
                c[first + i] += b * value;
            }
        }
        for i in 0..n {
            for k in 1..=BAND.min(i) {
                c[i] -= self.factor[i][k] * c[i - k];
            }
            c[i] /= self.factor[i][0];
        }
        for i in (0..n).rev() {
            for k in 1..=BAND.min(n - 1 - i) {
                c[i] -= self.factor[i + k][k] * c[i + k];
            }
            c[i] /= self.factor[i][0];
        }
        Spline { start: self.start, step: self.step, coefficients: c }
    }
}

/// First coefficient of the interval that holds `t`, and the fraction within it.
fn locate(t: f64, start: f64, step: f64, n: usize) -> (usize, f64) {
    let position = ((t - start) / step).max(0.0);
    let first = (position.floor() as usize).min(n - 4);
    (first, position - first as f64)
}

fn cholesky(matrix: &mut [[f64; BAND + 1]]) -> Option<()> {
    for i in 0..matrix.len() {
        for k in (0..=BAND.min(i)).rev() {
            let j = i - k;
            let mut sum = matrix[i][k];
            for m in k + 1..=BAND.min(i) {
                if m - k <= BAND {
                    sum -= matrix[i][m] * matrix[j][m - k];
                }
            }
            if k == 0 {
                if !(sum.is_finite() && sum > 0.0) {
                    return None;
                }
                matrix[i][0] = sum.sqrt();
            } else {
                matrix[i][k] = sum / matrix[j][0];
            }
        }
    }
    Some(())
}

impl Spline {
    /// Value, first and second derivative.
    pub(crate) fn point_at(&self, t: f64) -> [f64; 3] {
        let (first, u) = locate(t, self.start, self.step, self.coefficients.len());
        let c = &self.coefficients[first..first + 4];
        let dot = |b: [f64; 4]| b.iter().zip(c).map(|(b, c)| b * c).sum::<f64>();
        [
            dot(basis(u)),
            dot(basis_first(u)) / self.step,
            dot(basis_second(u)) / (self.step * self.step),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_pass_whatever_the_penalty() {
        let t: Vec<f64> = (0..200).map(|i| 0.37 * f64::from(i)).collect();
        let f = |t: f64| 3.0 - 0.2 * t + 0.05 * t * t;
        let values: Vec<f64> = t.iter().map(|t| f(*t)).collect();
        let spline = Fitter::new(&t, 0.0, 1.5, 50, 1e3).unwrap().fit(&values);
        for &t in &t {
            let [value, first, second] = spline.point_at(t);
            assert!((value - f(t)).abs() < 1e-6, "{value} {}", f(t));
            assert!((first - (-0.2 + 0.1 * t)).abs() < 1e-6);
            assert!((second - 0.1).abs() < 1e-6);
        }
    }

    /// A wave passes by 1/(1 + (cutoff/length)⁶): 64/65 at twice the cut-off length, a half at it.
    #[test]
    fn waves_pass_by_their_share() {
        let t: Vec<f64> = (0..4000).map(|i| 0.25 * f64::from(i)).collect();
        for (length, share) in [(40.0, 64.0 / 65.0), (20.0, 0.5), (10.0, 1.0 / 65.0)] {
            let values: Vec<f64> = t.iter().map(|t| (TAU * t / length).sin()).collect();
            let spline = Fitter::new(&t, 0.0, 1.0, 1000, penalty(20.0, 4.0)).unwrap().fit(&values);
            let gain = (400..3600).map(|i| 2.0 * spline.point_at(t[i])[0] * values[i]).sum::<f64>()
                / 3200.0;
            assert!((gain - share).abs() < 0.01, "length {length}: {gain}, expected {share}");
        }
    }
}
