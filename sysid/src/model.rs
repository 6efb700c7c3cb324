//! The discrete state-space model (eq 1–5) and its simulation.
//!
//! Signals have time along columns: `u` is nu by N, `y` is ny by N.

use crate::columns::Columns;
use crate::dense::{column, eigenvalues, least_squares, spectral_radius};
use crate::{Error, Signals};
use faer::{Mat, MatRef};

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

    /// Brings B and C to one size by a factor on the state, a power of two, which changes no digit of the
    /// response. Without noise the state is in units of next to nothing.
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
        // (e^{jω}I − A)(xr + j xi) = b as a real system of twice the size.
        let n = self.order();
        let (s, c) = omega.sin_cos();
        let m = Mat::from_fn(2 * n, 2 * n, |i, j| {
            let same = if i % n == j % n { 1.0 } else { 0.0 };
            match (i < n, j < n) {
                (true, true) | (false, false) => c * same - self.a[(i % n, j % n)],
                (true, false) => -s * same,
                (false, true) => s * same,
            }
        });
        let rhs = Mat::from_fn(2 * n, 1, |i, _| if i < n { self.b[(i, input)] } else { 0.0 });
        let x = crate::dense::solve(m.as_ref(), rhs.as_ref());
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
        re.is_finite().then_some(re)
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

/// Output of the model from the state `x0` (eq 1–2), ny by N.
#[must_use]
pub fn simulate(model: &StateSpace, u: MatRef<'_, f64>, x0: &[f64]) -> Signals {
    driven(model, u.ncols(), x0, |t, v| v.iter_mut().enumerate().for_each(|(j, v)| *v = u[(j, t)]))
}

/// Output of the model from the state `x0` over `count` samples, of which `input` fills in each.
fn driven(
    model: &StateSpace,
    count: usize,
    x0: &[f64],
    mut input: impl FnMut(usize, &mut [f64]),
) -> Signals {
    let (n, p, m) = (model.order(), model.outputs(), model.inputs());
    let mut x = x0.to_vec();
    let mut next = vec![0.0; n];
    let mut y = Signals::zeros(p, count);
    let [a, b, c, d] = [&model.a, &model.b, &model.c, &model.d].map(|m| Columns::new(m.as_ref()));
    let (mut now, mut of_now) = (vec![0.0; m], vec![0.0; p]);
    for t in 0..count {
        input(t, &mut now);
        c.product(&x, &mut of_now);
        d.add_product(&now, &mut of_now);
        for (i, value) in of_now.iter().enumerate() {
            y[(i, t)] = *value;
        }
        a.product(&x, &mut next);
        b.add_product(&now, &mut next);
        std::mem::swap(&mut x, &mut next);
    }
    y
}

/// One-step predictions of the innovation form (eq 3–4): ŷ(t) from u and y before t, ny by N.
#[must_use]
pub fn predict(
    model: &StateSpace,
    k: MatRef<'_, f64>,
    u: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
    x0: &[f64],
) -> Signals {
    predictions(&predictor(model, k), u, y, x0)
}

/// Output of a predictor, driven by inputs and outputs together.
pub(crate) fn predictions(
    predictor: &StateSpace,
    u: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
    x0: &[f64],
) -> Signals {
    let m = u.nrows();
    driven(predictor, y.ncols(), x0, |t, v| {
        for (l, v) in v.iter_mut().enumerate() {
            *v = if l < m { u[(l, t)] } else { y[(l - m, t)] };
        }
    })
}

/// `x⁺ = (A − K C) x + (B − K D) u + K y`, `ŷ = C x + D u` as a system with the inputs (u, y).
pub(crate) fn predictor(model: &StateSpace, k: MatRef<'_, f64>) -> StateSpace {
    let (n, m, p) = (model.order(), model.inputs(), model.outputs());
    let bd = &model.b - k * &model.d;
    StateSpace {
        a: &model.a - k * &model.c,
        b: Mat::from_fn(n, m + p, |i, j| if j < m { bd[(i, j)] } else { k[(i, j - m)] }),
        c: model.c.clone(),
        d: Mat::from_fn(p, m + p, |i, j| if j < m { model.d[(i, j)] } else { 0.0 }),
    }
}

/// The initial state that makes the simulation fit `y` best in the least-squares sense.
///
/// # Errors
/// [`Error::Numerical`] where the model is not finite.
pub fn initial_state(
    model: &StateSpace,
    u: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
) -> Result<Vec<f64>, Error> {
    let count = y.ncols().min(memory(model));
    let at_rest = vec![0.0; model.order()];
    free_state(model, &simulate(model, u.get(.., ..count), &at_rest), y)
}

/// As [`initial_state`], of a predictor.
pub(crate) fn predictor_state(
    predictor: &StateSpace,
    u: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
) -> Result<Vec<f64>, Error> {
    let count = y.ncols().min(memory(predictor));
    let at_rest = vec![0.0; predictor.order()];
    let forced = predictions(predictor, u.get(.., ..count), y.get(.., ..count), &at_rest);
    free_state(predictor, &forced, y)
}

/// Samples until the free response of a stable model has died out: more say nothing of its start.
pub(crate) fn memory(model: &StateSpace) -> usize {
    let radius = model.spectral_radius().clamp(1e-3, 1.0 - 1e-6);
    (36.0 / -radius.ln()).ceil() as usize + 2 * model.order() + 10
}

/// The state whose free response is what the forced one lacks of `y`.
fn free_state(model: &StateSpace, forced: &Signals, y: MatRef<'_, f64>) -> Result<Vec<f64>, Error> {
    let (n, p, count) = (model.order(), model.outputs(), forced.ncols());
    let free = free_response(model, count);
    let error: Vec<f64> =
        (0..p * count).map(|r| y[(r % p, r / p)] - forced[(r % p, r / p)]).collect();
    let x0 = least_squares(free.as_ref(), column(&error).as_ref(), 1e-12)?;
    Ok((0..n).map(|i| x0[(i, 0)]).collect())
}

/// Rows C, CA, CA², … stacked: ny·count by n.
pub(crate) fn free_response(model: &StateSpace, count: usize) -> Mat<f64> {
    let (n, p) = (model.order(), model.outputs());
    let at = Columns::new(model.a.transpose());
    let mut out = Mat::zeros(p * count, n);
    let mut next = vec![0.0; n];
    for i in 0..p {
        let mut row: Vec<f64> = (0..n).map(|k| model.c[(i, k)]).collect();
        for t in 0..count {
            for (k, v) in row.iter().enumerate() {
                out[(t * p + i, k)] = *v;
            }
            at.product(&row, &mut next);
            std::mem::swap(&mut row, &mut next);
        }
    }
    out
}

/// Row-major copy.
pub(crate) fn rows(m: MatRef<'_, f64>) -> Vec<f64> {
    (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| m[(i, j)])).collect()
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
