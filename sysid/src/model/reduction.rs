//! Balanced truncation: models of lower order that keep the states which matter most from input to
//! output.
//!
//! B. C. Moore, *Principal component analysis in linear systems*, IEEE Trans. Automatic Control 26
//! (1981), by the square-root method of Tombs and Postlethwaite (1987). The Gramians
//! `P = A P Aᵀ + B Bᵀ` and `Q = Aᵀ Q A + Cᵀ C` come from doubling (Smith 1968).

use crate::Error;
use crate::linalg::dense::{is_finite, svd};
use crate::model::StateSpace;
use faer::{Mat, MatRef, Side};

/// A stable model in balanced coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Balanced {
    /// The model, states in descending order of their Hankel singular values.
    pub model: StateSpace,
    /// Hankel singular values, descending; fewer than the order where states are not reached or not
    /// seen.
    pub hankel_singular_values: Vec<f64>,
}

impl Balanced {
    /// The model with the states of the given indices only.
    #[must_use]
    pub fn keep(&self, states: &[usize]) -> StateSpace {
        let (m, n) = (&self.model, states.len());
        StateSpace {
            a: Mat::from_fn(n, n, |i, j| m.a[(states[i], states[j])]),
            b: Mat::from_fn(n, m.inputs(), |i, j| m.b[(states[i], j)]),
            c: Mat::from_fn(m.outputs(), n, |i, j| m.c[(i, states[j])]),
            d: m.d.clone(),
        }
    }
}

/// Brings a stable model into balanced coordinates.
///
/// # Errors
/// [`Error::Numerical`] where the model is unstable or not finite.
pub fn balanced(model: &StateSpace) -> Result<Balanced, Error> {
    let bb = &model.b * model.b.transpose();
    let cc = model.c.transpose() * &model.c;
    let l = root(gramian(model.a.as_ref(), bb)?.as_ref())?;
    let m = root(gramian(model.a.transpose(), cc)?.as_ref())?;
    let f = svd((m.transpose() * &l).as_ref())?;
    let cut = 1e-12 * f.s.first().copied().unwrap_or(0.0);
    let n = f.s.iter().take_while(|s| **s > cut).count();
    let right = Mat::from_fn(f.v.nrows(), n, |i, j| f.v[(i, j)] / f.s[j].sqrt());
    let left = Mat::from_fn(f.u.nrows(), n, |i, j| f.u[(i, j)] / f.s[j].sqrt());
    let (t, inverse) = (l * right, left.transpose() * m.transpose());
    let balanced = StateSpace {
        a: &inverse * &model.a * &t,
        b: &inverse * &model.b,
        c: &model.c * &t,
        d: model.d.clone(),
    };
    Ok(Balanced { model: balanced, hankel_singular_values: f.s[..n].to_vec() })
}

/// `X = A X Aᵀ + W` for a stable A: X ← X + A X Aᵀ, A ← A², until nothing is added.
pub(crate) fn gramian(a: MatRef<'_, f64>, w: Mat<f64>) -> Result<Mat<f64>, Error> {
    const MOST_DOUBLINGS: usize = 50;
    let (mut a, mut x) = (a.to_owned(), w);
    for _ in 0..MOST_DOUBLINGS {
        let added = &a * &x * a.transpose();
        x = &x + &added;
        if !is_finite(x.as_ref()) {
            break;
        }
        if added.norm_l2() <= 1e-17 * x.norm_l2() {
            return Ok(x);
        }
        a = &a * &a;
    }
    Err(Error::Numerical { what: "the Gramian of a model that is not stable" })
}

/// R with X = R Rᵀ of a symmetric, positive semidefinite X.
fn root(x: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let n = x.nrows();
    let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (x[(i, j)] + x[(j, i)]));
    let f = symmetric
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| Error::Numerical { what: "eigenvalues of a Gramian" })?;
    let s = f.S().column_vector();
    Ok(Mat::from_fn(n, n, |i, j| f.U()[(i, j)] * s[j].max(0.0).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_that_nothing_reaches_is_dropped_and_the_rest_kept() {
        let model = StateSpace {
            a: Mat::from_fn(3, 3, |i, j| {
                [[0.9, 0.1, 0.0], [-0.1, 0.9, 0.0], [0.0, 0.0, 0.5]][i][j]
            }),
            b: Mat::from_fn(3, 1, |i, _| [1.0, 0.5, 0.0][i]),
            c: Mat::from_fn(1, 3, |_, j| [1.0, 0.2, 3.0][j]),
            d: Mat::from_fn(1, 1, |_, _| 0.3),
        };
        let reduced = balanced(&model).unwrap();
        assert_eq!(reduced.hankel_singular_values.len(), 2);
        let (want, got) = (model.markov_parameters(40), reduced.model.markov_parameters(40));
        let worst = want.iter().zip(&got).map(|(a, b)| (a - b).norm_max()).fold(0.0, f64::max);
        assert!(worst < 1e-12, "{worst:e}");
    }

    #[test]
    fn the_error_is_within_twice_what_was_cut() {
        // Enns (1984): ‖G − G_r‖∞ ≤ 2 Σ of the singular values that are left out.
        let model = StateSpace {
            a: Mat::from_fn(3, 3, |i, j| if i == j { [0.9, -0.4, 0.6][i] } else { 0.0 }),
            b: Mat::from_fn(3, 1, |i, _| [1.0, -0.5, 0.7][i]),
            c: Mat::from_fn(1, 3, |_, j| [1.0, 0.2, -0.6][j]),
            d: Mat::zeros(1, 1),
        };
        let all = balanced(&model).unwrap();
        let reduced = all.keep(&[0, 1]);
        for k in 0..100 {
            let w = std::f64::consts::PI * f64::from(k) / 99.0;
            let (a, b) = (model.frequency_response(0, 0, w), reduced.frequency_response(0, 0, w));
            let error = (a.0 - b.0).hypot(a.1 - b.1);
            assert!(error <= 2.0 * all.hankel_singular_values[2] + 1e-12);
        }
        assert!(reduced.spectral_radius() < 1.0);
    }

    #[test]
    fn an_unstable_model_is_refused() {
        let one = |x: f64| Mat::from_fn(1, 1, |_, _| x);
        let model = StateSpace { a: one(1.1), b: one(1.0), c: one(1.0), d: one(0.0) };
        assert!(balanced(&model).is_err());
    }
}
