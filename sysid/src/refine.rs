//! Refinement of a stable model by its simulation error: Gauss–Newton with Levenberg–Marquardt
//! damping over A, B, C, D and the initial state of each segment.
//!
//! The parametrisation is that of data-driven local coordinates (T. McKelvey, A. Helmersson,
//! T. Ribarits, *Data driven local coordinates for multivariable linear systems and their
//! application to system identification*, Automatica 40, 2004): a change of the state's basis moves
//! (A, B, C) without moving the model, so steps are taken orthogonally to those n² directions. What
//! remains is n(nu + ny) parameters without a canonical form and its conditioning.
//!
//! Steps that would make the model unstable are refused, so the result is as stable as the start.

use crate::dense::{hcat, spectral_radius};
use crate::elimination::{Elimination, Solution};
use crate::model::{StateSpace, free_response, predict, rows, simulate};
use crate::{DataSet, Error, Segment};
use faer::{Mat, MatRef};

/// When to stop refining.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Most steps.
    pub steps: usize,
    /// A step that lowers the sum of squares by a smaller share than this is the last.
    pub least_gain: f64,
}

/// A model with the initial state of each segment.
pub type WithStates = (StateSpace, Vec<Vec<f64>>);

/// Refines `model` and the initial states `x0` of the segments for the simulation of the data until
/// `stop`; spectral radii above `radius` are refused. Returns what was reached.
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn refine_output_error(
    model: &StateSpace,
    x0: &[Vec<f64>],
    data: &DataSet,
    feedthrough: bool,
    stop: Stop,
    radius: f64,
) -> Result<WithStates, Error> {
    let mut best = (model.clone(), x0.to_vec());
    let (mut errors, mut cost) = errors(data, &best.1, |s, x0| simulate(&best.0, s.u.as_ref(), x0));
    let mut damping = 1e-4;
    for _ in 0..stop.steps {
        let directions = directions(&best.0, feedthrough)?;
        let mut elimination = Elimination::new(directions.ncols(), model.order());
        for ((segment, x0), error) in data.segments().iter().zip(&best.1).zip(&errors) {
            let along = sensitivities(&best.0, x0, segment.u.as_ref(), &directions);
            let free = free_response(&best.0, segment.len());
            let rows = hcat(&[free.as_ref(), along.as_ref(), flat(error).as_ref()]);
            elimination.segment(rows.as_ref());
        }
        let mut moved = false;
        for _ in 0..8 {
            let candidate = apply(&best, &directions, &elimination.solve(damping)?);
            if candidate.0.spectral_radius() < radius {
                let (trial, trial_cost) = self::errors(data, &candidate.1, |s, x0| {
                    simulate(&candidate.0, s.u.as_ref(), x0)
                });
                if trial_cost < cost {
                    let gain = 1.0 - trial_cost / cost;
                    (best, errors, cost) = (candidate, trial, trial_cost);
                    damping = (damping * 0.2).max(1e-12);
                    moved = gain > stop.least_gain;
                    break;
                }
            }
            damping *= 8.0;
        }
        if !moved {
            break;
        }
    }
    Ok(best)
}

/// Refines the Kalman gain `k` of a fixed model by its one-step prediction errors, from the
/// segments' states `x0`; A − K C stays stable. Returns the gain that was reached.
///
/// With the innovation e, `∂ŷ/∂K_kj` is state k of `w⁺ = (A − K C)ᵀ w + c_iᵀ e_j` for output i.
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn refine_gain(
    model: &StateSpace,
    k: MatRef<'_, f64>,
    data: &DataSet,
    x0: &[Vec<f64>],
    stop: Stop,
) -> Result<Mat<f64>, Error> {
    const LARGEST_RADIUS: f64 = 0.9999;
    let (n, p) = (model.order(), model.outputs());
    let prediction_errors = |gain: &Mat<f64>| {
        errors(data, x0, |s, x0| predict(model, gain.as_ref(), s.u.as_ref(), s.y.as_ref(), x0))
    };
    let mut gain = k.to_owned();
    let (mut errors, mut cost) = prediction_errors(&gain);
    let mut damping = 1e-4;
    for _ in 0..stop.steps {
        let closed = rows((&model.a - &gain * &model.c).transpose());
        let mut elimination = Elimination::new(n * p, 0);
        for error in &errors {
            elimination.segment(gain_regressors(model, &closed, error).as_ref());
        }
        let mut moved = false;
        for _ in 0..8 {
            let step = elimination.solve(damping)?.shared;
            let trial = Mat::from_fn(n, p, |s, j| gain[(s, j)] + step[s * p + j]);
            if spectral_radius((&model.a - &trial * &model.c).as_ref()) < LARGEST_RADIUS {
                let (trial_errors, trial_cost) = prediction_errors(&trial);
                if trial_cost < cost {
                    moved = 1.0 - trial_cost / cost > stop.least_gain;
                    (gain, errors, cost) = (trial, trial_errors, trial_cost);
                    damping = (damping * 0.2).max(1e-12);
                    break;
                }
            }
            damping *= 8.0;
        }
        if !moved {
            break;
        }
    }
    Ok(gain)
}

/// What `output` misses of each segment's output, and the sum of squares.
fn errors(
    data: &DataSet,
    x0: &[Vec<f64>],
    output: impl Fn(&Segment, &[f64]) -> Mat<f64>,
) -> (Vec<Mat<f64>>, f64) {
    let errors: Vec<Mat<f64>> =
        data.segments().iter().zip(x0).map(|(s, x0)| &s.y - output(s, x0)).collect();
    let cost = errors.iter().map(|e| e.squared_norm_l2()).sum();
    (errors, cost)
}

/// A signal as one column, outputs of a sample together.
fn flat(signal: &Mat<f64>) -> Mat<f64> {
    let p = signal.nrows();
    Mat::from_fn(p * signal.ncols(), 1, |r, _| signal[(r % p, r / p)])
}

/// Derivatives of a segment's predictions by the entries of K, and its prediction errors.
fn gain_regressors(model: &StateSpace, closed: &[f64], error: &Mat<f64>) -> Mat<f64> {
    let (n, p, count) = (model.order(), model.outputs(), error.ncols());
    let mut jacobian = Mat::zeros(p * count, n * p + 1);
    for (i, j) in (0..p).flat_map(|i| (0..p).map(move |j| (i, j))) {
        let mut w = vec![0.0; n];
        for t in 0..count {
            for (state, v) in w.iter().enumerate() {
                jacobian[(t * p + i, state * p + j)] = *v;
            }
            w = (0..n)
                .map(|s| {
                    crate::model::dot(&closed[s * n..(s + 1) * n], &w)
                        + model.c[(i, s)] * error[(j, t)]
                })
                .collect();
        }
    }
    for (t, i) in (0..count).flat_map(|t| (0..p).map(move |i| (t, i))) {
        jacobian[(t * p + i, n * p)] = error[(i, t)];
    }
    jacobian
}

/// Orthonormal directions in (vec A, vec B, vec C, vec D), row by row, that are no change of basis.
fn directions(model: &StateSpace, feedthrough: bool) -> Result<Mat<f64>, Error> {
    let (n, m, p) = (model.order(), model.inputs(), model.outputs());
    let size = n * n + n * m + p * n;
    // Columns: the move of vec(A, B, C) under x → (I + ε E) x, that is (EA − AE, EB, −CE).
    let tangent = Mat::from_fn(size, n * n, |k, e| {
        let (row, col) = (e / n, e % n);
        if k < n * n {
            let (i, j) = (k / n, k % n);
            let ea = if i == row { model.a[(col, j)] } else { 0.0 };
            let ae = if j == col { model.a[(i, row)] } else { 0.0 };
            ea - ae
        } else if k < n * n + n * m {
            let (i, j) = ((k - n * n) / m, (k - n * n) % m);
            if i == row { model.b[(col, j)] } else { 0.0 }
        } else {
            let (i, j) = ((k - n * n - n * m) / n, (k - n * n - n * m) % n);
            if j == col { -model.c[(i, row)] } else { 0.0 }
        }
    });
    let full = tangent.svd().map_err(|_| Error::Numerical { what: "tangent of the basis" })?;
    let q = full.U();
    let free = size - n * n;
    let more = if feedthrough { p * m } else { 0 };
    Ok(Mat::from_fn(size + p * m, free + more, |i, j| match (i < size, j < free) {
        (true, true) => q[(i, n * n + j)],
        (false, false) if i - size == j - free => 1.0,
        _ => 0.0,
    }))
}

/// Derivatives of a segment's simulated output along `directions`; rows run over outputs, then time.
///
/// The response of output i to the entry (k, j) of A is that of state k of the transposed system
/// `w⁺ = Aᵀ w + c_iᵀ x_j`, and likewise of B with u_j in place of x_j, since C(zI−A)⁻¹e_k is the k-th
/// entry of (zI−Aᵀ)⁻¹Cᵀ. So n(n + nu) states per output give all derivatives.
fn sensitivities(
    model: &StateSpace,
    x0: &[f64],
    u: MatRef<'_, f64>,
    directions: &Mat<f64>,
) -> Mat<f64> {
    let (n, m, p, count) = (model.order(), model.inputs(), model.outputs(), u.ncols());
    let size = directions.nrows();
    let a = rows(model.a.as_ref());
    let b = rows(model.b.as_ref());
    let wide = n + m;
    // Row-major, a row for each output of each sample.
    let mut all = vec![0.0; p * count * size];
    let (c_at, d_at) = (n * n + n * m, n * n + n * m + p * n);
    for i in 0..p {
        let (mut w, mut next) = (vec![0.0; n * wide], vec![0.0; n * wide]);
        let mut xu = [x0, &vec![0.0; m]].concat();
        let mut x_next = vec![0.0; n];
        for t in 0..count {
            for j in 0..m {
                xu[n + j] = u[(j, t)];
            }
            let at = (t * p + i) * size;
            let row = &mut all[at..at + size];
            for k in 0..n {
                row[k * n..(k + 1) * n].copy_from_slice(&w[k * wide..k * wide + n]);
                let b_at = n * n + k * m;
                row[b_at..b_at + m].copy_from_slice(&w[k * wide + n..(k + 1) * wide]);
            }
            row[c_at + i * n..c_at + (i + 1) * n].copy_from_slice(&xu[..n]);
            row[d_at + i * m..d_at + (i + 1) * m].copy_from_slice(&xu[n..]);
            for k in 0..n {
                let out = &mut next[k * wide..(k + 1) * wide];
                let c = model.c[(i, k)];
                for (o, v) in out.iter_mut().zip(&xu) {
                    *o = c * v;
                }
                for r in 0..n {
                    let g = a[r * n + k];
                    for (o, v) in out.iter_mut().zip(&w[r * wide..(r + 1) * wide]) {
                        *o += g * v;
                    }
                }
                x_next[k] = crate::model::dot(&a[k * n..(k + 1) * n], &xu[..n])
                    + crate::model::dot(&b[k * m..(k + 1) * m], &xu[n..]);
            }
            std::mem::swap(&mut w, &mut next);
            xu[..n].copy_from_slice(&x_next);
        }
    }
    let all = MatRef::from_row_major_slice(&all, p * count, size);
    all * directions
}

fn apply(from: &WithStates, directions: &Mat<f64>, step: &Solution) -> WithStates {
    let mut to = from.clone();
    let (n, m, p) = (to.0.order(), to.0.inputs(), to.0.outputs());
    let count = directions.ncols();
    let moves: Vec<f64> = (0..directions.nrows())
        .map(|k| (0..count).map(|j| directions[(k, j)] * step.shared[j]).sum())
        .collect();
    let mut moves = moves.into_iter();
    for (matrix, height, width) in
        [(&mut to.0.a, n, n), (&mut to.0.b, n, m), (&mut to.0.c, p, n), (&mut to.0.d, p, m)]
    {
        for i in 0..height {
            for j in 0..width {
                matrix[(i, j)] += moves.next().unwrap_or(0.0);
            }
        }
    }
    for (x0, moves) in to.1.iter_mut().zip(&step.own) {
        for (x, h) in x0.iter_mut().zip(moves) {
            *x += h;
        }
    }
    to
}
