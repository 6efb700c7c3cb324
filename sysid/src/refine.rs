//! Refinement of a stable model by its simulation error: Gauss–Newton with Levenberg–Marquardt
//! damping over A, B, C, D and the initial state.
//!
//! The parametrisation is that of data-driven local coordinates (T. McKelvey, A. Helmersson,
//! T. Ribarits, *Data driven local coordinates for multivariable linear systems and their
//! application to system identification*, Automatica 40, 2004): a change of the state's basis moves
//! (A, B, C) without moving the model, so steps are taken orthogonally to those n² directions. What
//! remains is n(nu + ny) parameters without a canonical form and its conditioning.
//!
//! Steps that would make the model unstable are refused, so the result is as stable as the start.

use crate::Error;
use crate::dense::{hcat, least_squares, spectral_radius, triangle, vcat};
use crate::model::{StateSpace, predict, rows, simulate};
use faer::{Mat, MatRef};

/// When to stop refining.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Most steps.
    pub steps: usize,
    /// A step that lowers the sum of squares by a smaller share than this is the last.
    pub least_gain: f64,
}

/// Refines `model` and `x0` for the simulation of `u` → `y` until `stop`; spectral
/// radii above `radius` are refused. Returns what was reached.
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn refine_output_error(
    model: &StateSpace,
    x0: &[f64],
    u: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
    feedthrough: bool,
    stop: Stop,
    radius: f64,
) -> Result<(StateSpace, Vec<f64>), Error> {
    let mut best = (model.clone(), x0.to_vec());
    let mut error = y - simulate(&best.0, u, &best.1);
    let mut cost = error.squared_norm_l2();
    let mut damping = 1e-4;
    for _ in 0..stop.steps {
        let directions = directions(&best.0, feedthrough)?;
        let jacobian = sensitivities(&best.0, &best.1, u, &directions);
        let p = y.nrows();
        let flat = Mat::from_fn(p * y.ncols(), 1, |r, _| error[(r % p, r / p)]);
        let r = triangle(hcat(&[jacobian.as_ref(), flat.as_ref()]).as_ref());
        let n = jacobian.ncols();
        let rhs = r.get(..n, n..);
        let r = r.get(..n, ..n);
        let mut moved = false;
        for _ in 0..8 {
            let step = damped_step(r, rhs, damping)?;
            let candidate = apply(&best, &directions, &step);
            if candidate.0.spectral_radius() < radius {
                let trial = y - simulate(&candidate.0, u, &candidate.1);
                let trial_cost = trial.squared_norm_l2();
                if trial_cost < cost {
                    let gain = 1.0 - trial_cost / cost;
                    (best, error, cost) = (candidate, trial, trial_cost);
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

/// Refines the Kalman gain `k` of a fixed model by its one-step prediction errors, from the state
/// `x0`; A − K C stays stable. Returns the gain that was reached.
///
/// With the innovation e, `∂ŷ/∂K_kj` is state k of `w⁺ = (A − K C)ᵀ w + c_iᵀ e_j` for output i.
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn refine_gain(
    model: &StateSpace,
    k: MatRef<'_, f64>,
    u: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
    x0: &[f64],
    stop: Stop,
) -> Result<Mat<f64>, Error> {
    const LARGEST_RADIUS: f64 = 0.9999;
    let (n, p, count) = (model.order(), model.outputs(), y.ncols());
    let mut gain = k.to_owned();
    let mut error = y - predict(model, gain.as_ref(), u, y, x0);
    let mut cost = error.squared_norm_l2();
    let mut damping = 1e-4;
    for _ in 0..stop.steps {
        let closed = rows((&model.a - &gain * &model.c).transpose());
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
        let r = triangle(jacobian.as_ref());
        let mut moved = false;
        for _ in 0..8 {
            let step = damped_step(r.get(..n * p, ..n * p), r.get(..n * p, n * p..), damping)?;
            let trial = Mat::from_fn(n, p, |s, j| gain[(s, j)] + step[s * p + j]);
            if spectral_radius((&model.a - &trial * &model.c).as_ref()) < LARGEST_RADIUS {
                let trial_error = y - predict(model, trial.as_ref(), u, y, x0);
                let trial_cost = trial_error.squared_norm_l2();
                if trial_cost < cost {
                    moved = 1.0 - trial_cost / cost > stop.least_gain;
                    (gain, error, cost) = (trial, trial_error, trial_cost);
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

/// Solution of (RᵀR + λ·diag(RᵀR)) δ = Rᵀ q as a least-squares problem.
fn damped_step(r: MatRef<'_, f64>, rhs: MatRef<'_, f64>, damping: f64) -> Result<Vec<f64>, Error> {
    let n = r.ncols();
    let diagonal =
        Mat::from_fn(n, n, |i, j| if i == j { damping.sqrt() * r.col(i).norm_l2() } else { 0.0 });
    let a = vcat(&[r, diagonal.as_ref()]);
    let b = vcat(&[rhs, Mat::zeros(n, 1).as_ref()]);
    let x = least_squares(a.as_ref(), b.as_ref(), 1e-13)?;
    Ok((0..n).map(|i| x[(i, 0)]).collect())
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

/// Derivatives of the simulated output along `directions` and then by each state of x0; rows run
/// over outputs, then time.
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
    let along = all * directions;
    let free = crate::model::free_response(model, count);
    hcat(&[along.as_ref(), free.as_ref()])
}

fn apply(
    from: &(StateSpace, Vec<f64>),
    directions: &Mat<f64>,
    step: &[f64],
) -> (StateSpace, Vec<f64>) {
    let mut to = from.clone();
    let (n, m, p) = (to.0.order(), to.0.inputs(), to.0.outputs());
    let count = directions.ncols();
    let moves: Vec<f64> = (0..directions.nrows())
        .map(|k| (0..count).map(|j| directions[(k, j)] * step[j]).sum())
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
    for (x, h) in to.1.iter_mut().zip(&step[count..]) {
        *x += h;
    }
    to
}
