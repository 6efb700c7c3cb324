//! Small helpers over faer's dense matrices.

use crate::Error;
use crate::linalg::r_factor::RFactor;
use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, Side};

/// Singular values below this share of the largest are rounding, not data.
pub(crate) const RANK_TOLERANCE: f64 = 1e-12;

/// Thin singular value decomposition as owned parts: `m = u · diag(s) · vᵀ`, s descending.
pub(crate) struct Svd {
    pub(crate) u: Mat<f64>,
    pub(crate) s: Vec<f64>,
    pub(crate) v: Mat<f64>,
}

pub(crate) fn svd(m: MatRef<'_, f64>) -> Result<Svd, Error> {
    let f = m.thin_svd().map_err(|_| Error::Numerical { what: "singular values" })?;
    let s = f.S().column_vector();
    Ok(Svd { u: f.U().to_owned(), s: (0..s.nrows()).map(|i| s[i]).collect(), v: f.V().to_owned() })
}

/// Moore–Penrose inverse; singular values below `tolerance` times the largest count as zero.
pub(crate) fn pseudo_inverse(m: MatRef<'_, f64>, tolerance: f64) -> Result<Mat<f64>, Error> {
    let f = svd(m)?;
    let cut = tolerance * f.s.first().copied().unwrap_or(0.0);
    let rank = f.s.iter().take_while(|s| **s > cut).count();
    let scaled = Mat::from_fn(f.v.nrows(), rank, |i, j| f.v[(i, j)] / f.s[j]);
    Ok(scaled * f.u.get(.., ..rank).transpose())
}

pub(crate) fn least_squares(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    tolerance: f64,
) -> Result<Mat<f64>, Error> {
    // Columns are scaled to unit length, so that the tolerance does not depend on units.
    let norms: Vec<f64> = (0..a.ncols()).map(|j| a.col(j).norm_l2()).collect();
    let scale = |j: usize| if norms[j] > 0.0 { norms[j] } else { 1.0 };
    let scaled = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / scale(j));
    // A tall system is reduced to its R factor first: Qᵀb without Q.
    let (top, rhs) = if scaled.nrows() > 2 * scaled.ncols() {
        let n = scaled.ncols();
        let joined = hcat(&[scaled.as_ref(), b]);
        let r = r_factor(joined.as_ref());
        let rows = n.min(r.nrows());
        (r.get(..rows, ..n).to_owned(), r.get(..rows, n..).to_owned())
    } else {
        (scaled, b.to_owned())
    };
    let x = pseudo_inverse(top.as_ref(), tolerance)? * rhs;
    Ok(Mat::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)] / scale(i)))
}

/// R of a QR factorisation, min(m, n) by n, zeros below the diagonal.
pub(crate) fn r_factor(m: MatRef<'_, f64>) -> Mat<f64> {
    // Reflections over the whole height of a few columns leave the cache.
    const TALL: usize = 64;
    const NARROW: usize = 48;
    if m.nrows() >= TALL.max(2 * m.ncols()) && m.ncols() <= NARROW {
        let mut accumulated = RFactor::new(m.ncols());
        accumulated.accumulate(m);
        return accumulated.finish();
    }
    let qr = m.qr();
    let r = qr.thin_R();
    Mat::from_fn(r.nrows(), r.ncols(), |i, j| if i <= j { r[(i, j)] } else { 0.0 })
}

pub(crate) fn solve(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    a.partial_piv_lu().solve(b)
}

pub(crate) fn identity(n: usize) -> Mat<f64> {
    Mat::identity(n, n)
}

pub(crate) fn hcat(parts: &[MatRef<'_, f64>]) -> Mat<f64> {
    let rows = parts.first().map_or(0, |p| p.nrows());
    let mut out = Mat::zeros(rows, parts.iter().map(|p| p.ncols()).sum());
    let mut at = 0;
    for part in parts {
        out.get_mut(.., at..at + part.ncols()).copy_from(part);
        at += part.ncols();
    }
    out
}

pub(crate) fn vcat(parts: &[MatRef<'_, f64>]) -> Mat<f64> {
    let columns = parts.first().map_or(0, |p| p.ncols());
    let mut out = Mat::zeros(parts.iter().map(|p| p.nrows()).sum(), columns);
    let mut at = 0;
    for part in parts {
        out.get_mut(at..at + part.nrows(), ..).copy_from(part);
        at += part.nrows();
    }
    out
}

pub(crate) fn eigenvalues(m: MatRef<'_, f64>) -> Result<Vec<(f64, f64)>, Error> {
    if !is_finite(m) {
        return Err(Error::Numerical { what: "eigenvalues of a matrix that is not finite" });
    }
    let values = m.eigenvalues().map_err(|_| Error::Numerical { what: "eigenvalues" })?;
    Ok(values.iter().map(|z| (z.re, z.im)).collect())
}

/// Largest eigenvalue modulus; infinite where it cannot be had.
pub(crate) fn spectral_radius(m: MatRef<'_, f64>) -> f64 {
    match eigenvalues(m) {
        Ok(values) => values.iter().map(|(re, im)| re.hypot(*im)).fold(0.0, f64::max),
        Err(_) => f64::INFINITY,
    }
}

/// The nearest positive semidefinite matrix to a symmetric one (negative eigenvalues to zero).
pub(crate) fn positive_part(m: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let symmetric = Mat::from_fn(m.nrows(), m.ncols(), |i, j| 0.5 * (m[(i, j)] + m[(j, i)]));
    let f = symmetric
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| Error::Numerical { what: "eigenvalues of a symmetric matrix" })?;
    let s = f.S().column_vector();
    let scaled = Mat::from_fn(m.nrows(), m.ncols(), |i, j| f.U()[(i, j)] * s[j].max(0.0));
    Ok(scaled * f.U().transpose())
}

pub(crate) fn is_finite(m: MatRef<'_, f64>) -> bool {
    (0..m.ncols()).all(|j| (0..m.nrows()).all(|i| m[(i, j)].is_finite()))
}

pub(crate) fn column(values: &[f64]) -> Mat<f64> {
    Mat::from_fn(values.len(), 1, |i, _| values[i])
}

pub(crate) fn relative_difference(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    let norm = b.norm_l2();
    (a - b).norm_l2() / if norm > 0.0 { norm } else { 1.0 }
}

/// Σ a(t)·b(t) of long signals: eight sums side by side, which a compiler makes vectors of.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a8.zip(b8) {
        for (s, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *s += x * y;
        }
    }
    sums.iter().sum::<f64>() + rest
}

pub(crate) fn rows(m: MatRef<'_, f64>) -> Vec<f64> {
    (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| m[(i, j)])).collect()
}

/// Σ a·b of short vectors, in order.
#[inline(always)]
pub(crate) fn short_dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
