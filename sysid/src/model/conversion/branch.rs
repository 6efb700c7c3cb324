//! The nearest model off the branch cut of the logarithm: a mode that dies out within a sample
//! shows in one sample of the impulse response alone, and noise takes its eigenvalue of A to either
//! side of zero. On the negative side A has no real logarithm (eq 9), though the data hardly
//! require it.

use crate::Error;
use crate::linalg::dense::{eigenvalues, solve};
use crate::model::conversion::to_continuous;
use crate::model::state_space::StateSpace;
use faer::{Mat, MatRef};

/// Growth of the squared errors that a continuous form may cost: 5 % of their root.
const MOST_LOSS: f64 = 0.1;
/// Share of the output's root mean square that it may add: noise must not hide more.
const NEGLIGIBLE: f64 = 0.01;

/// Eigenvalues of modes that die out within a sample.
const SHORTER: [f64; 2] = [0.1, 0.01];

/// Steps of inverse iteration, and how far from an eigenvector its result may be.
const STEPS: usize = 4;
const INEXACT: f64 = 1e-8;

pub(crate) fn has_logarithm(model: &StateSpace) -> bool {
    to_continuous(model.a.as_ref(), model.b.as_ref(), 1.0).is_ok()
}

/// Whether squared errors have grown by nearly nothing, for outputs of unit spread.
pub(crate) fn costs_nothing(least: f64, with_logarithm: f64) -> bool {
    let growth = with_logarithm - least;
    growth <= MOST_LOSS * least && growth <= NEGLIGIBLE * NEGLIGIBLE
}

/// The models with each negative eigenvalue λ of A taken to −λ, and to shorter decays. Empty where
/// none is negative, or one is not simple.
pub(crate) fn off_branch_cut(model: &StateSpace) -> Result<Vec<StateSpace>, Error> {
    let mut models: Vec<StateSpace> = Vec::new();
    for most in [1.0, SHORTER[0], SHORTER[1]] {
        let next = moved(model, |value| most.min(-value))?;
        // A mode that is as short already stays where the one before took it.
        models.extend(next.filter(|next| models.last().is_none_or(|last| last.a != next.a)));
    }
    Ok(models)
}

/// The model with each negative λ taken to `place(λ)`: `A + (place(λ) − λ)·v·wᵀ` with the
/// eigenvectors v and w, `wᵀv = 1`, and B scaled along v such that the steady-state gain stays.
fn moved(model: &StateSpace, place: impl Fn(f64) -> f64) -> Result<Option<StateSpace>, Error> {
    let mut to = model.clone();
    let mut any = false;
    let a = model.a.as_ref();
    for (value, imaginary) in eigenvalues(a)? {
        if imaginary != 0.0 || value >= 0.0 {
            continue;
        }
        let (Some(right), Some(left)) = (eigenvector(a, value), eigenvector(a.transpose(), value))
        else {
            return Ok(None);
        };
        let shared = (left.transpose() * &right)[(0, 0)];
        if shared.abs() < INEXACT {
            return Ok(None);
        }
        let onto = &right * left.transpose() * (1.0 / shared);
        // Gain of the mode: wᵀB/(1 − λ).
        let new = place(value);
        let share = (1.0 - new) / (1.0 - value) - 1.0;
        to.a += &onto * (new - value);
        to.b += &onto * &model.b * share;
        any = true;
    }
    Ok(if any { Some(to) } else { None })
}

/// The eigenvector of a simple real eigenvalue, of length 1, by inverse iteration.
fn eigenvector(a: MatRef<'_, f64>, value: f64) -> Option<Mat<f64>> {
    let n = a.nrows();
    let size = a.norm_l2();
    // Next to the eigenvalue, so that there is a solution.
    let shift = value + 1e-10 * size;
    let shifted = Mat::from_fn(n, n, |i, j| a[(i, j)] - if i == j { shift } else { 0.0 });
    let mut vector = Mat::from_fn(n, 1, |i, _| 1.0 + 0.1 * i as f64);
    for _ in 0..STEPS {
        vector = solve(shifted.as_ref(), vector.as_ref());
        vector = &vector * (1.0 / vector.norm_l2());
    }
    let rest = a * &vector - &vector * value;
    if rest.norm_l2() <= INEXACT * size { Some(vector) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(poles: [f64; 3]) -> StateSpace {
        // The modes in a basis in which each depends on the others.
        let basis =
            Mat::from_fn(3, 3, |i, j| [[1.0, 0.4, -0.3], [0.2, 1.0, 0.5], [-0.6, 0.1, 1.0]][i][j]);
        let modes = Mat::from_fn(3, 3, |i, j| if i == j { poles[i] } else { 0.0 });
        let inverse = solve(basis.as_ref(), crate::linalg::dense::identity(3).as_ref());
        let gain = [0.3, -0.8, 0.5];
        let b = Mat::from_fn(3, 1, |i, _| gain[i] * (1.0 - poles[i]));
        StateSpace {
            a: &basis * modes * &inverse,
            b: &basis * b,
            c: Mat::from_fn(1, 3, |_, j| [1.0, 0.7, -0.4][j]),
            d: Mat::zeros(1, 1),
        }
    }

    /// The other modes, the eigenvectors and the steady-state gain stay: it is the model whose pole was
    /// written with the other sign.
    #[test]
    fn only_the_sign_of_the_negative_poles_changes() {
        let all = [1.0, SHORTER[0], SHORTER[1]];
        // A mode as short as a tenth stays where its sign takes it.
        let cases =
            [([0.9, -0.05, 0.6], vec![1.0, SHORTER[1]]), ([0.9, -0.05, -0.3], all.to_vec())];
        for (poles, places) in cases {
            let one = model(poles);
            assert!(!has_logarithm(&one));
            let found = off_branch_cut(&one).unwrap();
            for (found, most) in found.iter().zip(&places) {
                let expected = model(poles.map(|p| if p < 0.0 { most.min(-p) } else { p }));
                assert!((&found.a - &expected.a).norm_max() < 1e-9, "{poles:?}");
                assert!((&found.b - &expected.b).norm_max() < 1e-9, "{poles:?}");
                assert!(has_logarithm(found));
            }
            assert_eq!(found.len(), places.len());
        }
    }

    #[test]
    fn what_has_a_logarithm_or_no_simple_eigenvalue_is_left() {
        assert!(off_branch_cut(&model([0.9, 0.05, 0.6])).unwrap().is_empty());
        let mut defective = model([0.9, 0.5, 0.6]);
        defective.a = Mat::from_fn(3, 3, |i, j| match (i, j) {
            (0, 0) => 0.9,
            (1, 1) | (2, 2) => -0.2,
            (1, 2) => 1.0,
            _ => 0.0,
        });
        assert!(off_branch_cut(&defective).unwrap().is_empty());
    }
}
