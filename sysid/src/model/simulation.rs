//! Simulation and prediction of state-space models, and the initial states that fit them to data.
//!
//! Signals have time along columns: `u` is nu by N, `y` is ny by N.

use crate::Error;
use crate::data::Signals;
use crate::linalg::columns::Columns;
use crate::linalg::dense::{column, least_squares};
use crate::model::state_space::StateSpace;
use faer::{Mat, MatRef};
use pulp::{Arch, Simd, WithSimd};

/// Output of the model from the state `x0` (eq 1–2), ny by N.
#[must_use]
pub fn simulate(model: &StateSpace, u: MatRef<'_, f64>, x0: &[f64]) -> Signals {
    output(model, u.ncols(), x0, |t, v| v.iter_mut().enumerate().for_each(|(j, v)| *v = u[(j, t)]))
}

/// Output of the model from the state `x0` over `count` samples, of which `input` fills in each.
fn output(
    model: &StateSpace,
    count: usize,
    x0: &[f64],
    input: impl FnMut(usize, &mut [f64]),
) -> Signals {
    let mut y = Signals::zeros(model.outputs(), count);
    driven(model, count, x0, input, |t, now| {
        now.iter().enumerate().for_each(|(i, value)| y[(i, t)] = *value);
    });
    y
}

/// Runs the model from `x0`; `input` fills in each sample, `visit` gets the output.
pub(crate) fn driven(
    model: &StateSpace,
    count: usize,
    x0: &[f64],
    input: impl FnMut(usize, &mut [f64]),
    visit: impl FnMut(usize, &[f64]),
) {
    Arch::new().dispatch(Driven { model, count, x0, input, visit });
}

struct Driven<'a, I, V> {
    model: &'a StateSpace,
    count: usize,
    x0: &'a [f64],
    input: I,
    visit: V,
}

impl<I: FnMut(usize, &mut [f64]), V: FnMut(usize, &[f64])> WithSimd for Driven<'_, I, V> {
    type Output = ();

    /// The same sums whatever the vectors are.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { model, count, x0, mut input, mut visit } = self;
        let [a, b, c, d] =
            [&model.a, &model.b, &model.c, &model.d].map(|m| Columns::new(m.as_ref()));
        let (mut x, mut next) = (x0.to_vec(), vec![0.0; model.order()]);
        let (mut now, mut y) = (vec![0.0; model.inputs()], vec![0.0; model.outputs()]);
        for t in 0..count {
            input(t, &mut now);
            c.product(&x, &mut y);
            d.add_product(&now, &mut y);
            visit(t, &y);
            a.product(&x, &mut next);
            b.add_product(&now, &mut next);
            std::mem::swap(&mut x, &mut next);
        }
    }
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
    output(predictor, y.ncols(), x0, |t, v| {
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

/// Samples until the free response of a stable model has died out.
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
