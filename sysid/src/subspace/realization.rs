//! From the column space of Γ to A, B, C, D and the noise.

use super::weights::{oblique, oblique_next};
use super::{Factor, Subspace};
use crate::dense::{hcat, least_squares, pseudo_inverse, spectral_radius, triangle, vcat};
use crate::elimination::{Elimination, Solution};
use crate::model::{StateSpace, free_response};
use crate::riccati::kalman_filter;
use crate::stability::stable_fit;
use crate::{DataSet, Error, Segment};
use faer::{Mat, MatRef};

const TOLERANCE: f64 = 1e-12;

/// How A and C come out of the column space of Γ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Realization {
    /// The shift structure of Γ: [`shift_realization`].
    Shift,
    /// Least squares between the estimated state sequences: [`eq12`].
    Eq12,
}

impl Realization {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Shift, Self::Eq12];

    /// The name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Shift => "shift",
            Self::Eq12 => "eq 12",
        }
    }
}

/// A and C from the shift structure of Γ: C is its first block row, Γ↑ A = Γ↓.
///
/// # Errors
/// [`Error::OrderAboveHorizon`] where Γ is too short for the order.
pub fn shift_realization(
    subspace: &Subspace,
    order: usize,
    outputs: usize,
) -> Result<(Mat<f64>, Mat<f64>), Error> {
    let gamma = gamma(subspace, order, outputs)?;
    let rows = gamma.nrows();
    let a = pseudo_inverse(gamma.get(..rows - outputs, ..), TOLERANCE)? * gamma.get(outputs.., ..);
    Ok((a, gamma.get(..outputs, ..).to_owned()))
}

/// The first `order` columns of the subspace's basis.
fn gamma(subspace: &Subspace, order: usize, outputs: usize) -> Result<MatRef<'_, f64>, Error> {
    let rows = subspace.basis.nrows();
    if order == 0 || order > subspace.basis.ncols() || order + outputs > rows {
        return Err(Error::OrderAboveHorizon { order, horizon: rows / outputs });
    }
    Ok(subspace.basis.get(.., ..order))
}

/// The oblique projections O_i and O_{i+1}, of which any weighting and order takes its states.
#[derive(Debug, Clone)]
pub struct Projections {
    now: Mat<f64>,
    next: Mat<f64>,
}

impl Projections {
    /// Projects the future outputs of the data.
    ///
    /// # Errors
    /// [`Error::Numerical`] where a decomposition does not converge.
    pub fn new(factor: &Factor) -> Result<Self, Error> {
        let now = oblique(factor)?;
        let blank = Mat::zeros(now.nrows(), factor.outputs);
        Ok(Self { now: hcat(&[now.as_ref(), blank.as_ref()]), next: oblique_next(factor)? })
    }

    /// State sequences X̂_i = Γ_i⁺ O_i and X̂_{i+1} = Γ_{i−1}⁺ O_{i+1}, order by columns.
    fn states(
        &self,
        subspace: &Subspace,
        order: usize,
        outputs: usize,
    ) -> Result<[Mat<f64>; 2], Error> {
        let gamma = gamma(subspace, order, outputs)?;
        let short = gamma.get(..gamma.nrows() - outputs, ..);
        Ok([
            pseudo_inverse(gamma, TOLERANCE)? * &self.now,
            pseudo_inverse(short, TOLERANCE)? * &self.next,
        ])
    }
}

/// Eq 12: A, B, C, D by least squares between the state sequences X̂_i = Γ_i⁺ O_i and
/// X̂_{i+1} = Γ_{i−1}⁺ O_{i+1}. Without feedthrough D is left out of the second row's regression, so
/// that C is the best one given D = 0.
///
/// With coloured inputs its B and D are biased (the oblique projection's states start from
/// different initial states); [`structured_bd`] and [`refit_output`] are not.
///
/// # Errors
/// As [`shift_realization`].
pub fn eq12(
    factor: &Factor,
    projections: &Projections,
    subspace: &Subspace,
    order: usize,
    feedthrough: bool,
) -> Result<StateSpace, Error> {
    let (m, p) = (factor.inputs, factor.outputs);
    let [now, next] = projections.states(subspace, order, p)?;
    let (u, y) = now_signals(factor);
    let xu = vcat(&[now.as_ref(), u]);
    let ab = transposed_fit(xu.as_ref(), next.as_ref())?;
    let (c, d) = if feedthrough {
        let cd = transposed_fit(xu.as_ref(), y)?;
        (cd.get(.., ..order).to_owned(), cd.get(.., order..).to_owned())
    } else {
        (transposed_fit(now.as_ref(), y)?, Mat::zeros(p, m))
    };
    Ok(StateSpace { a: ab.get(.., ..order).to_owned(), b: ab.get(.., order..).to_owned(), c, d })
}

/// A of [`eq12`] with a penalty on its size that brings the spectral radius down to `radius`, as
/// [`stable_shift`](crate::stability::stable_shift) does; `None` only where the states are not finite.
///
/// # Errors
/// As [`shift_realization`].
pub fn stable_eq12(
    factor: &Factor,
    projections: &Projections,
    subspace: &Subspace,
    order: usize,
    radius: f64,
) -> Result<Option<Mat<f64>>, Error> {
    let states = projections.states(subspace, order, factor.outputs)?;
    let (u, _) = now_signals(factor);
    // What the input of the same sample explains is taken out of both, which leaves A alone.
    let mut rest = Vec::with_capacity(2);
    for x in &states {
        rest.push(x - transposed_fit(u, x.as_ref())? * u);
    }
    Ok(stable_fit(rest[0].transpose(), rest[1].transpose(), radius)
        .map(|a| a.transpose().to_owned()))
}

/// Input and output of the present, the first block rows of U_f and Y_f.
fn now_signals(factor: &Factor) -> (MatRef<'_, f64>, MatRef<'_, f64>) {
    let (m, p, future) = (factor.inputs, factor.outputs, factor.future());
    (factor.l.get(..m, ..future + p), factor.l.get(future..future + p, ..future + p))
}

/// Θ with least ‖target − Θ·data‖.
fn transposed_fit(data: MatRef<'_, f64>, target: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    Ok(least_squares(data.transpose(), target.transpose(), TOLERANCE)?.transpose().to_owned())
}

/// B and D for given A, C by the unbiased least-squares problem of N4SID (Van Overschee and
/// De Moor 1996, figure 4.8): with Z the orthogonal projections of the future outputs,
/// `[Γ_{i−1}⁺ Z_{i+1}; Y_i] − [A; C] Γ_i⁺ Z_i = 𝒦(B, D) U_f`, 𝒦 linear in B and D. Γ is the
/// subspace's own, of which A and C are the shift realization; with [`Method::Moesp`] this is
/// SLICOT's combined method.
///
/// [`Method::Moesp`]: super::Method::Moesp
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn structured_bd(
    factor: &Factor,
    subspace: &Subspace,
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    feedthrough: bool,
) -> Result<StateSpace, Error> {
    let (n, m, p) = (a.nrows(), factor.inputs, factor.outputs);
    let gamma = subspace.basis.get(.., ..n);
    let s = factor.horizon;
    let short = (s - 1) * p;
    let now = pseudo_inverse(gamma, TOLERANCE)?;
    let next = pseudo_inverse(gamma.get(..short, ..), TOLERANCE)?;
    // 𝒦 U_f has columns in Q1 only, so only these can be fitted.
    let (past, future) = (factor.past(), factor.future());
    let l = factor.l.get(.., ..past);
    let x = &now * l.get(future.., ..);
    let w = &next * l.get(future + p.., ..) - a * &x;
    let v = l.get(future..future + p, ..) - c * &x;
    // Errors of the state count by what they do to the outputs, ‖Γ w‖ = ‖T w‖, so that the result does
    // not depend on the basis of the state.
    let t = triangle(gamma);
    let target = vcat(&[(&t * &w).as_ref(), v.as_ref()]);
    let cells = target.nrows() * past;
    let count = m * (n + if feedthrough { p } else { 0 });
    let mut slopes = Mat::zeros(cells, count);
    for index in 0..count {
        let (row, input) = (index / m, index % m);
        // Columns of H_i for this input that B or D of one puts there, one for each sample of it.
        let column = |sample: usize, i: usize| {
            let start = (sample + usize::from(row < n)) * p;
            if row >= n {
                f64::from(i == start + row - n)
            } else if i >= start {
                gamma[(i - start, row)]
            } else {
                0.0
            }
        };
        let h = Mat::from_fn(s * p, s, |i, sample| column(sample, i));
        let x = &now * &h;
        let mut slope = vcat(&[(-(a * &x)).as_ref(), (-(c * &x)).as_ref()]);
        let x_next = &next * h.get(..short, ..s - 1);
        let mut later = slope.get_mut(..n, 1..);
        later += &x_next;
        slope[(row, 0)] += 1.0;
        let weighted = &t * slope.get(..n, ..);
        slope.get_mut(..n, ..).copy_from(&weighted);
        for sample in 0..s {
            for k in 0..n + p {
                for j in 0..past {
                    slopes[(j * (n + p) + k, index)] +=
                        slope[(k, sample)] * l[(sample * m + input, j)];
                }
            }
        }
    }
    let target = Mat::from_fn(cells, 1, |k, _| target[(k % (n + p), k / (n + p))]);
    let solution = least_squares(slopes.as_ref(), target.as_ref(), TOLERANCE)?;
    let at = |row: usize, input: usize| solution[(row * m + input, 0)];
    Ok(StateSpace {
        a: a.to_owned(),
        b: Mat::from_fn(n, m, at),
        c: c.to_owned(),
        d: Mat::from_fn(p, m, |i, j| if feedthrough { at(n + i, j) } else { 0.0 }),
    })
}

/// Residuals [W; V] of the state recursion with the states that Γ sees in the data:
/// X_i = Γ_i⁺(Z_i − H_i U_f), X_{i+1} = Γ_{i−1}⁺(Z_{i+1} − H_{i−1} U_f⁻).
fn recursion_residuals(
    factor: &Factor,
    model: &StateSpace,
    gamma: MatRef<'_, f64>,
) -> Result<Mat<f64>, Error> {
    let (m, p, s) = (factor.inputs, factor.outputs, factor.horizon);
    let (past, future) = (factor.past(), factor.future());
    let width = future + p;
    let h = toeplitz(model, gamma, s);
    let l = &factor.l;
    let mut z = l.get(future.., ..width).to_owned();
    for j in future..width {
        for i in 0..z.nrows() {
            z[(i, j)] = 0.0;
        }
    }
    let u = l.get(..past, ..width);
    let x = pseudo_inverse(gamma, TOLERANCE)? * (z - &h * u);
    let z_next = l.get(future + p.., ..width);
    let short = (s - 1) * p;
    let h_next = h.get(..short, ..(s - 1) * m);
    let x_next = pseudo_inverse(gamma.get(..short, ..), TOLERANCE)?
        * (z_next - h_next * l.get(m..past, ..width));
    let now = l.get(..m, ..width);
    let w = x_next - &model.a * &x - &model.b * now;
    let v = l.get(future..future + p, ..width) - &model.c * &x - &model.d * now;
    Ok(vcat(&[w.as_ref(), v.as_ref()]))
}

/// Block Toeplitz matrix of D and Γ's rows times B, s·ny by s·nu.
fn toeplitz(model: &StateSpace, gamma: MatRef<'_, f64>, s: usize) -> Mat<f64> {
    let (m, p) = (model.inputs(), model.outputs());
    let gb = gamma * &model.b;
    Mat::from_fn(s * p, s * m, |i, j| {
        let (row, column) = (i / p, j / m);
        match row.cmp(&column) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => model.d[(i % p, j % m)],
            std::cmp::Ordering::Greater => gb[((row - column - 1) * p + i % p, j % m)],
        }
    })
}

/// Kalman gain and innovation covariance of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseModel {
    /// K, n by ny.
    pub gain: Mat<f64>,
    /// Covariance of the innovation, ny by ny.
    pub innovation: Mat<f64>,
    /// Whether the Riccati equation gave the gain; otherwise it is zero, and A − K C = A.
    pub solved: bool,
}

/// The noise of `model` from the covariances of the recursion's residuals and the Riccati equation.
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn noise_model(factor: &Factor, model: &StateSpace) -> Result<NoiseModel, Error> {
    let n = model.order();
    let gamma = free_response(model, factor.horizon);
    let residuals = recursion_residuals(factor, model, gamma.as_ref())?;
    let covariance = &residuals * residuals.transpose();
    let q = covariance.get(..n, ..n);
    let s = covariance.get(..n, n..);
    let r = covariance.get(n.., n..);
    let future = factor.future();
    let y = factor.l.get(future..future + factor.outputs, ..);
    // Data without noise leave rounding here, of which no filter can be made.
    let noisy = (0..r.nrows()).all(|i| r[(i, i)] > 1e-18 * y.row(i).squared_norm_l2());
    let filter =
        if noisy { kalman_filter(model.a.as_ref(), model.c.as_ref(), q, r, s) } else { None };
    Ok(match filter {
        Some(f) => NoiseModel { gain: f.gain, innovation: f.innovation, solved: true },
        None => NoiseModel {
            gain: Mat::zeros(n, factor.outputs),
            innovation: r.to_owned(),
            solved: false,
        },
    })
}

/// What [`refit_output`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct Refit {
    /// The model with B and D refitted.
    pub model: StateSpace,
    /// Initial state of each segment.
    pub x0: Vec<Vec<f64>>,
    /// Constant added to each output; zeros unless asked for.
    pub offset: Vec<f64>,
}

/// B, D, the initial states and, where asked, a constant on each output that make the *simulated*
/// output of (A, C) fit the data best, by linear least squares. A must be stable.
///
/// The response of output i to column j of B is the state of the transposed system driven by input
/// j, `z⁺ = Aᵀ z + c_iᵀ u_j`, since C(zI−A)⁻¹B = Bᵀ(zI−Aᵀ)⁻¹Cᵀ.
///
/// # Errors
/// [`Error::Numerical`] where the regressors are not finite.
pub fn refit_output(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    data: &DataSet,
    feedthrough: bool,
    offset: bool,
) -> Result<Refit, Error> {
    let (n, m, p) = (a.nrows(), data.inputs(), data.outputs());
    let unstable = Error::Numerical { what: "simulation of an unstable model" };
    if !spectral_radius(a).is_finite() {
        return Err(unstable);
    }
    let (d_start, o_start) = (n * m, n * m + if feedthrough { p * m } else { 0 });
    let shared = o_start + if offset { p } else { 0 };
    let mut elimination = Elimination::new(shared, n);
    for segment in data.segments() {
        let rows = output_regressors(a, c, segment, (feedthrough, offset));
        if !crate::dense::is_finite(rows.as_ref()) {
            return Err(unstable);
        }
        elimination.segment(rows.as_ref());
    }
    let Solution { shared: solution, own: x0 } = elimination.solve(0.0)?;
    let at = |k: usize| solution[k];
    Ok(Refit {
        model: StateSpace {
            a: a.to_owned(),
            b: Mat::from_fn(n, m, |k, j| at(k * m + j)),
            c: c.to_owned(),
            d: Mat::from_fn(p, m, |i, j| if feedthrough { at(d_start + i * m + j) } else { 0.0 }),
        },
        x0,
        offset: (0..p).map(|i| if offset { at(o_start + i) } else { 0.0 }).collect(),
    })
}

/// Rows of [`refit_output`] for one segment: x0, B, D, offset, output.
fn output_regressors(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    segment: &Segment,
    (feedthrough, offset): (bool, bool),
) -> Mat<f64> {
    let (u, y) = (&segment.u, &segment.y);
    let (n, m, p, count) = (a.nrows(), u.nrows(), y.nrows(), segment.len());
    let at = crate::model::rows(a.transpose());
    let (b_start, d_start) = (n, n + n * m);
    let o_start = d_start + if feedthrough { p * m } else { 0 };
    let target = o_start + if offset { p } else { 0 };
    let mut regressors = Mat::zeros(p * count, target + 1);
    let mut next = vec![0.0; n];
    let mut step = |z: &mut Vec<f64>, drive: f64, ci: &[f64]| {
        for (k, x) in next.iter_mut().enumerate() {
            *x = crate::model::dot(&at[k * n..(k + 1) * n], z) + ci[k] * drive;
        }
        std::mem::swap(z, &mut next);
    };
    for i in 0..p {
        let ci: Vec<f64> = (0..n).map(|k| c[(i, k)]).collect();
        for j in 0..m {
            let mut z = vec![0.0; n];
            for t in 0..count {
                for k in 0..n {
                    regressors[(i * count + t, b_start + k * m + j)] = z[k];
                }
                if feedthrough {
                    regressors[(i * count + t, d_start + i * m + j)] = u[(j, t)];
                }
                step(&mut z, u[(j, t)], &ci);
            }
        }
        let mut free = ci.clone();
        for t in 0..count {
            for k in 0..n {
                regressors[(i * count + t, k)] = free[k];
            }
            if offset {
                regressors[(i * count + t, o_start + i)] = 1.0;
            }
            regressors[(i * count + t, target)] = y[(i, t)];
            step(&mut free, 0.0, &ci);
        }
    }
    regressors
}
