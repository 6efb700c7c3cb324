//! The criterion: the largest variance `cᵀ·M⁻¹·c` of what is to be known, by the delta method, over its gradients c, with the
//! information matrix M (n by n, row by row). Here c are the gradients of the logarithm of the gain and of the phase of the
//! response over a band of frequencies, so that the criterion is the squared largest relative standard error of the response.
//!
//! The response leaves combinations of the parameters open, such as lag and yaw inertia. The shape of a signal therefore
//! minimises a cost that has the generalised variance of the parameters, too (D-optimality):
//!
//! ```text
//! ln max_i c_iᵀ·M⁻¹·c_i + (1/n)·ln det M⁻¹
//! ```

/// Exponent of the smooth maximum over the variances.
const SHARPNESS: f64 = 24.0;

/// A symmetric matrix, n by n, row by row.
pub(super) type Square = Vec<f64>;

/// What is to be known.
#[derive(Debug, Clone)]
pub(super) struct Criterion {
    /// Number of parameters n.
    pub(super) size: usize,
    /// Gradients c, n long each.
    pub(super) gradients: Vec<Vec<f64>>,
}

/// The Cholesky factor of an information matrix.
pub(super) struct Factor {
    size: usize,
    lower: Square,
}

impl Factor {
    /// `None` where the matrix is not positive definite.
    pub(super) fn new(matrix: &[f64], size: usize) -> Option<Self> {
        let mut lower = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| lower[i * size + k] * lower[j * size + k]).sum();
                let rest = matrix[i * size + j] - known;
                if i == j {
                    if !(rest > 0.0 && rest.is_finite()) {
                        return None;
                    }
                    lower[i * size + i] = rest.sqrt();
                } else {
                    lower[i * size + j] = rest / lower[j * size + j];
                }
            }
        }
        Some(Self { size, lower })
    }

    /// L⁻¹·b.
    pub(super) fn half_solve(&self, b: &[f64]) -> Vec<f64> {
        let n = self.size;
        let mut x = b.to_vec();
        for i in 0..n {
            let known: f64 = (0..i).map(|k| self.lower[i * n + k] * x[k]).sum();
            x[i] = (x[i] - known) / self.lower[i * n + i];
        }
        x
    }

    /// M⁻¹·b.
    pub(super) fn solve(&self, b: &[f64]) -> Vec<f64> {
        let n = self.size;
        let mut x = self.half_solve(b);
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| self.lower[k * n + i] * x[k]).sum();
            x[i] = (x[i] - known) / self.lower[i * n + i];
        }
        x
    }

    /// `ln det M⁻¹` over the number of parameters.
    fn generalised_variance(&self) -> f64 {
        let n = self.size;
        -2.0 * (0..n).map(|i| self.lower[i * n + i].ln()).sum::<f64>() / n as f64
    }

    /// `cᵀ·M⁻¹·c`.
    pub(super) fn variance(&self, c: &[f64]) -> f64 {
        self.half_solve(c).iter().map(|x| x * x).sum()
    }
}

impl Criterion {
    /// The largest variance; `None` where the information is singular.
    pub(super) fn largest(&self, information: &[f64]) -> Option<f64> {
        let factor = Factor::new(information, self.size)?;
        Some(self.gradients.iter().map(|c| factor.variance(c)).fold(0.0, f64::max))
    }

    /// The cost; infinite where the information is singular.
    pub(super) fn cost(&self, information: &[f64]) -> f64 {
        let Some(factor) = Factor::new(information, self.size) else { return f64::INFINITY };
        let variances = self.gradients.iter().map(|c| factor.variance(c));
        variances.fold(0.0, f64::max).ln() + factor.generalised_variance()
    }

    /// The cost with a smooth maximum of the variances, `ln(Σ f^ρ)/ρ`, and the matrix W of its change with the information,
    /// `d = −tr(W·dM)`. `None` where the information is singular.
    pub(super) fn smooth(&self, information: &[f64]) -> Option<(f64, Square)> {
        let n = self.size;
        let factor = Factor::new(information, n)?;
        let variances: Vec<f64> = self.gradients.iter().map(|c| factor.variance(c)).collect();
        let largest = variances.iter().copied().fold(0.0, f64::max);
        let powers: Vec<f64> = variances.iter().map(|f| (f / largest).powf(SHARPNESS)).collect();
        let sum: f64 = powers.iter().sum();
        let mut w = vec![0.0; n * n];
        for ((c, power), variance) in self.gradients.iter().zip(&powers).zip(&variances) {
            let x = factor.solve(c);
            let weight = power / (sum * variance);
            for i in 0..n {
                for j in 0..n {
                    w[i * n + j] += weight * x[i] * x[j];
                }
            }
        }
        for i in 0..n {
            let mut unit = vec![0.0; n];
            unit[i] = 1.0;
            for (j, inverse) in factor.solve(&unit).into_iter().enumerate() {
                w[i * n + j] += inverse / n as f64;
            }
        }
        Some((largest.ln() + sum.ln() / SHARPNESS + factor.generalised_variance(), w))
    }
}
