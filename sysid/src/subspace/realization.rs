//! From the column space of Γ to A, B, C, D: the shift structure, and eq 12.

use crate::Error;
use crate::linalg::dense::{RANK_TOLERANCE, hcat, least_squares, pseudo_inverse, vcat};
use crate::model::StateSpace;
use crate::model::stability::stable_fit;
use crate::subspace::factor::Factor;
use crate::subspace::weights::{Subspace, oblique, oblique_next};
use faer::{Mat, MatRef};

/// How A and C come out of the column space of Γ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Realization {
    /// The shift structure of Γ: [`shift_realization`].
    Shift,
    /// Least squares between the estimated state sequences: [`eq12`].
    Eq12,
}

steerwright_formats::words!(Realization { Shift = "shift", Eq12 = "eq 12" });

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
    let a =
        pseudo_inverse(gamma.get(..rows - outputs, ..), RANK_TOLERANCE)? * gamma.get(outputs.., ..);
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
            pseudo_inverse(gamma, RANK_TOLERANCE)? * &self.now,
            pseudo_inverse(short, RANK_TOLERANCE)? * &self.next,
        ])
    }
}

/// Eq 12: A, B, C, D by least squares between the state sequences X̂_i = Γ_i⁺ O_i and X̂_{i+1} =
/// Γ_{i−1}⁺ O_{i+1}; C is the best one given D = 0 without feedthrough.
///
/// With coloured inputs its B and D are biased; [`structured_bd`](crate::subspace::structured_bd)
/// and [`refit_output`](crate::subspace::refit_output) are not.
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
/// [`stable_shift`](crate::model::stability::stable_shift) does; `None` only where the states are not finite.
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
    Ok(least_squares(data.transpose(), target.transpose(), RANK_TOLERANCE)?.transpose().to_owned())
}
