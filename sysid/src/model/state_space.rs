//! The discrete state-space model (eq 1–5).

use crate::Error;
use crate::linalg::dense::{eigenvalues, solve, spectral_radius};
use faer::Mat;

/// `x⁺ = A x + B u`, `y = C x + D u` (eq 1–2 without noise).
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace {
    /// State matrix, n by n.
    pub a: Mat<f64>,
    /// Input matrix, n by nu.
    pub b: Mat<f64>,
    /// Output matrix, ny by n.
    pub c: Mat<f64>,
    /// Feedthrough, ny by nu.
    pub d: Mat<f64>,
}

impl StateSpace {
    /// Order n.
    #[must_use]
    pub fn order(&self) -> usize {
        self.a.nrows()
    }

    /// Brings B and C to one size by a power of two, which changes no digit of the response.
    pub(crate) fn scale_state(&mut self) {
        let ratio = (self.b.norm_l2() / self.c.norm_l2()).sqrt();
        if ratio.is_finite() && ratio > 0.0 {
            let by = 2.0_f64.powi(ratio.log2().round() as i32);
            self.b = &self.b * (1.0 / by);
            self.c = &self.c * by;
        }
    }

    /// Number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.b.ncols()
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.c.nrows()
    }

    /// Eigenvalues of A as (real, imaginary).
    ///
    /// # Errors
    /// [`Error::Numerical`] where A is not finite.
    pub fn poles(&self) -> Result<Vec<(f64, f64)>, Error> {
        eigenvalues(self.a.as_ref())
    }

    /// Largest eigenvalue modulus of A.
    #[must_use]
    pub fn spectral_radius(&self) -> f64 {
        spectral_radius(self.a.as_ref())
    }

    /// Markov parameters D, CB, CAB, … as ny by nu matrices.
    #[must_use]
    pub fn markov_parameters(&self, count: usize) -> Vec<Mat<f64>> {
        let mut out = vec![self.d.clone()];
        let mut ab = self.b.clone();
        for _ in 1..count {
            out.push(&self.c * &ab);
            ab = &self.a * ab;
        }
        out.truncate(count);
        out
    }

    /// Frequency response of one input–output pair at `omega` rad per sample, (real, imaginary).
    #[must_use]
    pub fn frequency_response(&self, output: usize, input: usize, omega: f64) -> (f64, f64) {
        let (sin, cos) = omega.sin_cos();
        self.response_at(output, input, (cos, sin))
    }

    /// `c·(z I − A)⁻¹·b + d` of one input–output pair at a complex z; of the matrices of a continuous model at s.
    pub(crate) fn response_at(&self, output: usize, input: usize, z: (f64, f64)) -> (f64, f64) {
        // (z I − A)(xr + j xi) = b as a real system of twice the size.
        let n = self.order();
        let (c, s) = z;
        let m = Mat::from_fn(2 * n, 2 * n, |i, j| {
            let same = if i % n == j % n { 1.0 } else { 0.0 };
            match (i < n, j < n) {
                (true, true) | (false, false) => c * same - self.a[(i % n, j % n)],
                (true, false) => -s * same,
                (false, true) => s * same,
            }
        });
        let rhs = Mat::from_fn(2 * n, 1, |i, _| if i < n { self.b[(i, input)] } else { 0.0 });
        let x = solve(m.as_ref(), rhs.as_ref());
        let (mut re, mut im) = (self.d[(output, input)], 0.0);
        for i in 0..n {
            re += self.c[(output, i)] * x[(i, 0)];
            im += self.c[(output, i)] * x[(n + i, 0)];
        }
        (re, im)
    }

    /// Steady-state gain of one input–output pair; `None` for an integrator.
    #[must_use]
    pub fn steady_state_gain(&self, output: usize, input: usize) -> Option<f64> {
        let (re, _) = self.frequency_response(output, input, 0.0);
        if re.is_finite() { Some(re) } else { None }
    }

    /// The system from `input[j]·u_j` to `output[i]·y_i`, its state as it is.
    pub(crate) fn scaled(&self, input: &[f64], output: &[f64]) -> Self {
        Self {
            a: self.a.clone(),
            b: Mat::from_fn(self.b.nrows(), self.b.ncols(), |i, j| self.b[(i, j)] / input[j]),
            c: Mat::from_fn(self.c.nrows(), self.c.ncols(), |i, j| self.c[(i, j)] * output[i]),
            d: Mat::from_fn(self.d.nrows(), self.d.ncols(), |i, j| {
                self.d[(i, j)] * output[i] / input[j]
            }),
        }
    }
}

/// `x⁺ = A x + B u + K e`, `y = C x + D u + e` (eq 3–4).
#[derive(Debug, Clone, PartialEq)]
pub struct Innovation {
    /// A, B, C, D.
    pub model: StateSpace,
    /// Kalman gain K, n by ny.
    pub gain: Mat<f64>,
}
