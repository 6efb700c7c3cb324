//! Levenberg–Marquardt on det Λ with `Λ = Σ e eᵀ/N`, the maximum-likelihood criterion for white
//! Gaussian errors of unknown covariance (Ljung, *System Identification*, 2nd ed. 1999, eq
//! 7.90–7.91). Its gradient is that of `Σ eᵀΛ⁻¹e` with Λ held, so each step is one of least squares
//! with the rows weighted by the Cholesky factor of Λ at the present model. The columns of a
//! segment's initial state are eliminated by the same QR factorisation; an offset of the outputs is
//! a parameter in addition to the model's.

use crate::Error;
use crate::data::{DataSet, Segment};
use crate::linalg::dense::{identity, is_finite, least_squares, spectral_radius, vcat};
use crate::linalg::levenberg_marquardt::{USUAL, by_more_than, lower};
use crate::linalg::r_factor::RFactor;
use crate::model::{StateSpace, driven};
use crate::pem::coordinates::Coordinates;
use crate::pem::rows::{Drive, Sensitivities};
use faer::{Mat, MatRef, Side};
use pulp::{Arch, Simd, WithSimd};

/// When to stop refining.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Most steps.
    pub steps: usize,
    /// A step that lowers the criterion (for one output the sum of squares) by a smaller share than
    /// this is the last.
    pub least_gain: f64,
}

/// A model with the initial state of each segment and, where free, constants on the outputs.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    pub(crate) model: StateSpace,
    pub(crate) x0s: Vec<Vec<f64>>,
    pub(crate) offsets: Option<Vec<f64>>,
}

pub(super) struct Linearised {
    /// R of the weighted derivatives by the free offsets and along the local coordinates with the
    /// initial states eliminated, square, and last the errors' column.
    pub(super) r_factor: Mat<f64>,
    /// For each segment the first n rows of its own R factor: (R₀₀, R₀θ, r₀).
    pub(super) heads: Vec<Mat<f64>>,
    /// Number of free offsets, whose columns are the first of θ.
    pub(super) offsets: usize,
}

/// The error covariance Σ e eᵀ/N; not finite where the model's output is not.
pub(super) fn error_covariance(point: &Point, drive: Drive, data: &DataSet) -> Mat<f64> {
    let p = data.outputs();
    let offset = |i: usize| point.offsets.as_ref().map_or(0.0, |offsets| offsets[i]);
    let mut sum = Mat::<f64>::zeros(p, p);
    for (segment, x0) in data.segments().iter().zip(&point.x0s) {
        each_error(&point.model, drive, segment, x0, |_, e| {
            for j in 0..p {
                for i in 0..p {
                    sum[(i, j)] += (e[i] - offset(i)) * (e[j] - offset(j));
                }
            }
        });
    }
    let count = data.samples() as f64;
    Mat::from_fn(p, p, |i, j| sum[(i, j)] / count)
}

/// Calls `visit` with the time and the error y − ŷ of each sample of a segment.
pub(super) fn each_error(
    model: &StateSpace,
    drive: Drive,
    segment: &Segment,
    x0: &[f64],
    mut visit: impl FnMut(usize, &[f64]),
) {
    let mut e = vec![0.0; model.outputs()];
    let fill = |t: usize, v: &mut [f64]| drive.fill(segment, t, v);
    driven(model, segment.len(), x0, fill, |t, y| {
        for (i, (e, y)) in e.iter_mut().zip(y).enumerate() {
            *e = segment.y[(i, t)] - y;
        }
        visit(t, &e);
    });
}

/// `det(Λ)^(1/ny)`; infinite where Λ is not finite.
pub(super) fn criterion(covariance: &Mat<f64>) -> f64 {
    if !is_finite(covariance.as_ref()) {
        return f64::INFINITY;
    }
    let p = covariance.nrows();
    if p == 1 {
        return covariance[(0, 0)];
    }
    regular(covariance).determinant().max(0.0).powf(1.0 / p as f64)
}

/// The covariance with 1e-10 of each variance added, for outputs that are met exactly.
fn regular(covariance: &Mat<f64>) -> Mat<f64> {
    const SHARE: f64 = 1e-10;
    let p = covariance.nrows();
    let trace = (0..p).map(|i| covariance[(i, i)]).sum::<f64>();
    Mat::from_fn(p, p, |i, j| {
        let variance = covariance[(i, i)].max(1e-30 * trace);
        covariance[(i, j)] + if i == j { SHARE * variance } else { 0.0 }
    })
}

/// The lower triangular L⁻¹ with `L Lᵀ = Λ`.
pub(super) fn weight(covariance: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let p = covariance.nrows();
    if covariance.norm_max() == 0.0 {
        return Ok(identity(p));
    }
    let cholesky = regular(covariance)
        .llt(Side::Lower)
        .map_err(|_| Error::Numerical { what: "covariance of the prediction errors" })?;
    Ok(crate::linalg::dense::solve(cholesky.L(), identity(p).as_ref()))
}

/// The derivatives at the coordinates' model, weighted by `weight`, reduced to triangles.
pub(super) fn linearise(
    coordinates: &Coordinates,
    (x0s, offsets): (&[Vec<f64>], Option<&[f64]>),
    drive: Drive,
    data: &DataSet,
    weight: &Mat<f64>,
) -> Linearised {
    Arch::new().dispatch(Derivatives { coordinates, x0s, offsets, drive, data, weight })
}

struct Derivatives<'a> {
    coordinates: &'a Coordinates,
    x0s: &'a [Vec<f64>],
    offsets: Option<&'a [f64]>,
    drive: Drive,
    data: &'a DataSet,
    weight: &'a Mat<f64>,
}

impl WithSimd for Derivatives<'_> {
    type Output = Linearised;

    /// The same sums whatever the vectors are.
    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) -> Linearised {
        let Self { coordinates, x0s, offsets, drive, data, weight } = self;
        let (n, p) = (coordinates.model.order(), coordinates.model.outputs());
        let free = offsets.map_or(0, <[f64]>::len);
        let count = free + coordinates.count();
        let width = n + count + 1;
        let mut all = RFactor::new(count + 1);
        let mut heads = Vec::new();
        let mut rows = vec![0.0; p * width];
        for (segment, x0) in data.segments().iter().zip(x0s) {
            let mut filters = Sensitivities::new(coordinates, drive, segment, x0, offsets);
            let mut head = Some(RFactor::new(width));
            let mut close = |head: &mut Option<RFactor>, all: &mut RFactor| {
                if let Some(head) = head.take() {
                    let r = head.finish();
                    all.accumulate(r.get(n.., n..));
                    heads.push(r.get(..n, ..).to_owned());
                }
            };
            for t in 0..segment.len() {
                if !filters.free {
                    close(&mut head, &mut all);
                }
                filters.sample(t, &mut rows);
                weigh(weight, &mut rows);
                for row in rows.chunks_exact(width) {
                    match &mut head {
                        Some(head) => head.push(row),
                        None => all.push(&row[n..]),
                    }
                }
            }
            close(&mut head, &mut all);
        }
        Linearised { r_factor: all.finish(), heads, offsets: free }
    }
}

/// rows ← weight · rows, weight lower triangular.
#[inline(always)]
pub(super) fn weigh(weight: &Mat<f64>, rows: &mut [f64]) {
    let p = weight.nrows();
    let width = rows.len() / p;
    for i in (0..p).rev() {
        let (before, row) = rows.split_at_mut(i * width);
        let own = weight[(i, i)];
        row[..width].iter_mut().for_each(|x| *x *= own);
        for (j, other) in before.chunks_exact(width).enumerate() {
            let factor = weight[(i, j)];
            row[..width].iter_mut().zip(other).for_each(|(x, y)| *x += factor * y);
        }
    }
}

impl Linearised {
    /// The step of offsets and coordinates, and that of each initial state.
    fn step(&self, damping: f64) -> Result<(Vec<f64>, Vec<Vec<f64>>), Error> {
        let q = self.r_factor.ncols() - 1;
        let step = damped_step(
            self.r_factor.get(..q, ..q),
            self.r_factor.get(..q, q..),
            damping,
            self.offsets,
        )?;
        let mut initial = Vec::new();
        for head in &self.heads {
            let n = head.nrows();
            let rhs = Mat::from_fn(n, 1, |i, _| {
                head[(i, n + q)] - (0..q).map(|j| head[(i, n + j)] * step[j]).sum::<f64>()
            });
            let x = least_squares(head.get(.., ..n), rhs.as_ref(), 1e-12)?;
            initial.push((0..n).map(|i| x[(i, 0)]).collect());
        }
        Ok((step, initial))
    }
}

/// Solution of (RᵀR + λ·diag(RᵀR)) δ = Rᵀ q; the first `linear` unknowns are not damped.
pub(crate) fn damped_step(
    r: MatRef<'_, f64>,
    rhs: MatRef<'_, f64>,
    damping: f64,
    linear: usize,
) -> Result<Vec<f64>, Error> {
    let n = r.ncols();
    let damped = |i: usize| if i < linear { 0.0 } else { damping.sqrt() * r.col(i).norm_l2() };
    let diagonal = Mat::from_fn(n, n, |i, j| if i == j { damped(i) } else { 0.0 });
    let a = vcat(&[r, diagonal.as_ref()]);
    let b = vcat(&[rhs, Mat::zeros(n, 1).as_ref()]);
    let x = least_squares(a.as_ref(), b.as_ref(), 1e-13)?;
    Ok((0..n).map(|i| x[(i, 0)]).collect())
}

pub(crate) struct Found {
    pub(crate) point: Point,
    pub(super) covariance: Mat<f64>,
    pub(super) steps: usize,
    /// The state there is `basis · x` of the start's state.
    pub(super) basis: Mat<f64>,
}

/// A step to a model stable by less is refused: rounding would decide.
const MARGIN: f64 = 1e-9;

/// Lowers the criterion until `stop`; spectral radii of `radius` or more are refused.
pub(super) fn search(
    start: Point,
    drive: Drive,
    data: &DataSet,
    feedthrough: &[bool],
    stop: Stop,
    radius: f64,
) -> Result<Found, Error> {
    let radius = radius.min(1.0 - MARGIN);
    let covariance = error_covariance(&start, drive, data);
    let cost = criterion(&covariance);
    if !cost.is_finite() {
        return Err(Error::Numerical { what: "errors of the model to be refined" });
    }
    // Going back to the start's basis could spoil the stability that was checked.
    let basis = identity(start.model.order());
    let linearise = |(best, covariance, _): &(Point, Mat<f64>, Mat<f64>),
                     _: &mut f64|
     -> Result<_, Error> {
        let weight = weight(covariance)?;
        let coordinates = Coordinates::new(&best.model, &weight, feedthrough)?;
        // `best` itself stays as it was checked until a step is taken.
        let x0s: Vec<Vec<f64>> = best.x0s.iter().map(|x| times(&coordinates.basis, x)).collect();
        let linear = linearise(&coordinates, (&x0s, best.offsets.as_deref()), drive, data, &weight);
        Ok(Some((coordinates, x0s, linear)))
    };
    let reached = lower::<_, _, Error>(
        ((start, covariance, basis), cost),
        stop.steps,
        USUAL,
        by_more_than(stop.least_gain),
        linearise,
        |(best, _, basis), (coordinates, x0s, linear), damping| {
            let (step, initial) = linear.step(damping)?;
            let (of_offsets, step) = step.split_at(linear.offsets);
            let model = coordinates.moved(step);
            // One that is not a number is refused too.
            if !matches!(spectral_radius(model.a.as_ref()), r if r < radius) {
                return Ok(None);
            }
            let add = |(x, d): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
                x.iter().zip(d).map(|(x, d)| x + d).collect()
            };
            let x0s = x0s.iter().zip(&initial).map(add).collect();
            let offsets = best.offsets.as_ref().map(|offsets| {
                offsets.iter().zip(of_offsets).map(|(offset, d)| offset + d).collect()
            });
            let trial = Point { model, x0s, offsets };
            let covariance = error_covariance(&trial, drive, data);
            let cost = criterion(&covariance);
            Ok(Some(((trial, covariance, &coordinates.basis * basis), cost)))
        },
    )?;
    let (point, covariance, basis) = reached.point;
    Ok(Found { point, covariance, steps: reached.steps, basis })
}

pub(super) fn times(m: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    (0..m.nrows()).map(|i| (0..m.ncols()).map(|j| m[(i, j)] * x[j]).sum()).collect()
}
