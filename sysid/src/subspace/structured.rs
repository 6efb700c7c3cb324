//! B and D for given A and C, without the bias of coloured inputs.

use crate::Error;
use crate::linalg::dense::{RANK_TOLERANCE, least_squares, pseudo_inverse, r_factor, vcat};
use crate::model::StateSpace;
use crate::subspace::factor::Factor;
use crate::subspace::weights::Subspace;
use faer::{Mat, MatRef};

/// B and D for given A, C by the unbiased problem of N4SID (Van Overschee and De Moor 1996, figure
/// 4.8): `[Γ_{i−1}⁺ Z_{i+1}; Y_i] − [A; C] Γ_i⁺ Z_i = 𝒦(B, D) U_f`, 𝒦 linear in B and D, Z the
/// projections of the future outputs, Γ the subspace's own. With
/// [`crate::subspace::Weighting::Moesp`] this is SLICOT's combined method.
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
    let now = pseudo_inverse(gamma, RANK_TOLERANCE)?;
    let next = pseudo_inverse(gamma.get(..short, ..), RANK_TOLERANCE)?;
    // 𝒦 U_f has columns in Q1 only, so only these can be fitted.
    let (past, future) = (factor.past(), factor.future());
    let l = factor.l.get(.., ..past);
    let x = &now * l.get(future.., ..);
    let w = &next * l.get(future + p.., ..) - a * &x;
    let v = l.get(future..future + p, ..) - c * &x;
    // Errors of the state count by what they do to the outputs, whatever the basis: ‖Γ w‖ = ‖T w‖.
    let t = r_factor(gamma);
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
    let solution = least_squares(slopes.as_ref(), target.as_ref(), RANK_TOLERANCE)?;
    let at = |row: usize, input: usize| solution[(row * m + input, 0)];
    Ok(StateSpace {
        a: a.to_owned(),
        b: Mat::from_fn(n, m, at),
        c: c.to_owned(),
        d: Mat::from_fn(p, m, |i, j| if feedthrough { at(n + i, j) } else { 0.0 }),
    })
}
