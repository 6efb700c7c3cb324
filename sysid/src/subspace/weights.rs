//! The weighted singular value decomposition whose column space is that of Γ.

use crate::Error;
use crate::linalg::dense::{RANK_TOLERANCE, pseudo_inverse, r_factor, svd, vcat};
use crate::subspace::factor::Factor;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, MatRef, Par};

/// The weighting W1·O_i·W2 of the oblique projection O_i of Y_f along U_f on W_p (Van Overschee
/// and De Moor 1995, table 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weighting {
    /// W1 = I, W2 = I.
    N4sid,
    /// W1 = I, W2 = Π, the projection on the complement of U_f.
    Moesp,
    /// W1 = (Y_f Π Y_fᵀ)^{−1/2}, W2 = Π: singular values are canonical correlations.
    Cva,
}

impl Weighting {
    /// All of them, in the order in which they are compared.
    pub const ALL: [Self; 3] = [Self::Moesp, Self::Cva, Self::N4sid];
}

/// Singular values and the basis W1⁻¹·U·S^{1/2} of the extended observability matrix Γ.
#[derive(Debug, Clone)]
pub struct Subspace {
    /// All singular values, descending.
    pub singular_values: Vec<f64>,
    /// s·ny rows; the first n columns span Γ at order n.
    pub basis: Mat<f64>,
}

/// Oblique projection O_i = L32 L22⁺ \[L21 L22\] in the coordinates of (Q1, Q2), s·ny rows.
pub(crate) fn oblique(factor: &Factor) -> Result<Mat<f64>, Error> {
    let (past, future) = (factor.past(), factor.future());
    let l = &factor.l;
    let on = unit_rows(l.get(past..future, ..future), past);
    let inverse = pseudo_inverse(on.get(.., past..), RANK_TOLERANCE)?;
    Ok(l.get(future.., past..future) * inverse * on)
}

/// Rows over the length of their part from column `from` on, so that units do not matter.
fn unit_rows(m: MatRef<'_, f64>, from: usize) -> Mat<f64> {
    let lengths: Vec<f64> = (0..m.nrows()).map(|i| m.get(.., from..).row(i).norm_l2()).collect();
    let scale = |i: usize| if lengths[i] > 0.0 { lengths[i] } else { 1.0 };
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] / scale(i))
}

/// Decomposes the weighted projection.
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn subspace(factor: &Factor, method: Weighting) -> Result<Subspace, Error> {
    let (past, future) = (factor.past(), factor.future());
    let l = &factor.l;
    let l32 = l.get(future.., past..future);
    match method {
        Weighting::N4sid => from_svd(oblique(factor)?.as_ref(), None),
        // O_i Π = L32 Q2.
        Weighting::Moesp => from_svd(l32, None),
        Weighting::Cva => {
            // Y_f Π Y_fᵀ = [L32 L33][L32 L33]ᵀ = T Tᵀ; the canonical correlations are the same for any
            // root, so W1 = T⁻¹ with the triangular T where it is regular.
            let t = r_factor(l.get(future.., past..).transpose());
            if t.nrows() == t.ncols() && is_regular(t.as_ref()) {
                let mut whitened = l32.to_owned();
                solve_lower_triangular_in_place(t.transpose(), whitened.as_mut(), Par::Seq);
                return from_svd(whitened.as_ref(), Some(t.transpose()));
            }
            // Otherwise = U S² Uᵀ, so W1 = S⁻¹ Uᵀ, W1⁻¹ = U S.
            let f = svd(l.get(future.., past..))?;
            let cut = RANK_TOLERANCE * f.s.first().copied().unwrap_or(0.0);
            let rank = f.s.iter().take_while(|s| **s > cut).count();
            let ut = Mat::from_fn(rank, f.u.nrows(), |i, j| f.u[(j, i)] / f.s[i]);
            let back = Mat::from_fn(f.u.nrows(), rank, |i, j| f.u[(i, j)] * f.s[j]);
            from_svd((ut * l32).as_ref(), Some(back.as_ref()))
        }
    }
}

/// Whether an R factor is far from singular, each column (a signal's) seen in its own unit.
fn is_regular(t: MatRef<'_, f64>) -> bool {
    const LEAST: f64 = 1e-6;
    (0..t.ncols()).all(|j| t[(j, j)].abs() > LEAST * t.col(j).norm_l2())
}

/// Zeros replace the singular values that data without noise lack.
fn from_svd(m: MatRef<'_, f64>, back: Option<MatRef<'_, f64>>) -> Result<Subspace, Error> {
    let f = svd(m)?;
    let scaled = Mat::from_fn(f.u.nrows(), f.s.len(), |i, j| f.u[(i, j)] * f.s[j].sqrt());
    let spanned = match back {
        Some(w) => w * &scaled,
        None => scaled.clone(),
    };
    let rows = spanned.nrows();
    let mut singular_values = f.s;
    singular_values.resize(rows, 0.0);
    let basis =
        Mat::from_fn(rows, rows, |i, j| if j < spanned.ncols() { spanned[(i, j)] } else { 0.0 });
    Ok(Subspace { singular_values, basis })
}

/// O_{i+1} of Y_f⁻ along U_f⁻ on W_p⁺ in the coordinates of (Q1, Q2, first block of Q3).
pub(crate) fn oblique_next(factor: &Factor) -> Result<Mat<f64>, Error> {
    let (m, p) = (factor.inputs, factor.outputs);
    let (past, future) = (factor.past(), factor.future());
    let width = future + p;
    let l = &factor.l;
    // [U_f⁻; W_p⁺] spans what [U_f; W_p; y_i] spans: the same rows in another order.
    let along = l.get(m..past, ..width);
    let on = vcat(&[
        l.get(..m, ..width),
        l.get(past..future, ..width),
        l.get(future..future + p, ..width),
    ]);
    let both = unit_rows(vcat(&[along, on.as_ref()]).as_ref(), 0);
    let target = l.get(future + p.., ..width);
    let coefficients = target * pseudo_inverse(both.as_ref(), RANK_TOLERANCE)?;
    Ok(coefficients.get(.., along.nrows()..) * both.get(along.nrows().., ..))
}
