//! Discrete ↔ continuous time under a zero-order hold (eq 6–11).
//!
//! Eq 9 and 10 together are one exponential, `exp([F G; 0 0]·T) = [A B; 0 I]`, so its logarithm
//! inverts both exactly.

mod branch;
mod functions;

use crate::linalg::dense::{eigenvalues, relative_difference};
use faer::{Mat, MatRef};
use std::f64::consts::PI;

pub(crate) use crate::model::conversion::branch::{costs_nothing, has_logarithm, off_branch_cut};
pub(crate) use crate::model::conversion::functions::exponential;
use crate::model::conversion::functions::logarithm;

/// The continuous model F, G of eq 6 with the round-trip error of eq 9–10.
#[derive(Debug, Clone, PartialEq)]
pub struct ContinuousModel {
    /// F, 1/s.
    pub f: Mat<f64>,
    /// G, per second.
    pub g: Mat<f64>,
    /// The larger of ‖exp(F·T) − A‖/‖A‖ and the same for B.
    pub round_trip: f64,
}

/// Round trips worse than this count as no logarithm: the result is another model.
const WORST_ROUND_TRIP: f64 = 1e-10;

/// `(A, B)` with eq 9–10 from `(F, G)` and the sample time.
#[must_use]
pub fn discretize(
    f: MatRef<'_, f64>,
    g: MatRef<'_, f64>,
    sample_time: f64,
) -> (Mat<f64>, Mat<f64>) {
    let (n, m) = (f.nrows(), g.ncols());
    let scale = input_scale(f, g);
    let joined = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => f[(i, j)] * sample_time,
        (true, false) => g[(i, j - n)] * scale * sample_time,
        _ => 0.0,
    });
    let e = exponential(joined.as_ref());
    let b = e.get(..n, n..);
    (e.get(..n, ..n).to_owned(), Mat::from_fn(n, m, |i, j| b[(i, j)] / scale))
}

/// A power of two that brings B to the size of A, so that units do not matter.
fn input_scale(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    let ratio = a.norm_l2() / b.norm_l2();
    if ratio.is_finite() && ratio > 0.0 { 2.0_f64.powi(ratio.log2().round() as i32) } else { 1.0 }
}

/// `(F, G)` from `(A, B)`: the inverse of [`discretize`].
///
/// # Errors
/// The reason in words where A has no real principal logarithm, or none within 1e-10 of it.
pub fn to_continuous(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    sample_time: f64,
) -> Result<ContinuousModel, String> {
    let (n, m) = (a.nrows(), b.ncols());
    check_branch(a)?;
    let scale = input_scale(a, b);
    let joined = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => a[(i, j)],
        (true, false) => b[(i, j - n)] * scale,
        (false, false) if i == j => 1.0,
        _ => 0.0,
    });
    let log = logarithm(joined.as_ref())
        .ok_or_else(|| "the logarithm of A did not converge".to_owned())?;
    let f = Mat::from_fn(n, n, |i, j| log[(i, j)] / sample_time);
    let g = Mat::from_fn(n, m, |i, j| log[(i, n + j)] / (scale * sample_time));
    let (a2, b2) = discretize(f.as_ref(), g.as_ref(), sample_time);
    let round_trip = relative_difference(a2.as_ref(), a).max(relative_difference(b2.as_ref(), b));
    if round_trip <= WORST_ROUND_TRIP {
        Ok(ContinuousModel { f, g, round_trip })
    } else {
        Err(format!("the logarithm of A is inexact (round trip {round_trip:.1e})"))
    }
}

/// A real principal logarithm exists where no eigenvalue lies on the closed negative real axis.
fn check_branch(a: MatRef<'_, f64>) -> Result<(), String> {
    let values = eigenvalues(a).map_err(|e| e.to_string())?;
    let largest = values.iter().map(|(re, im)| re.hypot(*im)).fold(0.0, f64::max);
    for (re, im) in values {
        if re.hypot(im) <= 1e-15 * largest {
            return Err("an eigenvalue of A is zero, so A has no logarithm".into());
        }
        if PI - im.atan2(re).abs() < 1e-7 {
            return Err(format!(
                "the eigenvalue {re:.4} of A is negative, so A has no real logarithm"
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]]) -> Mat<f64> {
        Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    }

    fn round_trip(f: &Mat<f64>, t: f64) -> (f64, f64) {
        let g = Mat::from_fn(f.nrows(), 1, |i, _| 1.0 + i as f64);
        let (a, b) = discretize(f.as_ref(), g.as_ref(), t);
        let back = to_continuous(a.as_ref(), b.as_ref(), t).unwrap();
        (back.round_trip, relative_difference(back.f.as_ref(), f.as_ref()))
    }

    #[test]
    fn round_trips_of_hard_matrices() {
        let cases = [
            ("vehicle", matrix(&[&[-5.0, -14.0, 60.0], &[1.3, -6.0, 40.0], &[0.0, 0.0, -20.0]])),
            ("defective", matrix(&[&[-2.0, 1.0, 0.0], &[0.0, -2.0, 1.0], &[0.0, 0.0, -2.0]])),
            ("near integrator", matrix(&[&[-1e-9, 1.0], &[0.0, -3.0]])),
            ("integrator", matrix(&[&[0.0, 1.0], &[0.0, 0.0]])),
            ("near the branch cut", matrix(&[&[-0.1, 75.0], &[-75.0, -0.1]])),
        ];
        for (name, f) in &cases {
            let (there, back) = round_trip(f, 0.04);
            assert!(there < 1e-10, "{name}: {there:e}");
            assert!(back < 1e-9, "{name}: {back:e}");
        }
        // Stiff: the fast mode is e^{-20} after a sample, so F is known to 1e-16·e^{20} at best.
        let stiff = matrix(&[&[-500.0, 3.0, 1.0], &[0.0, -0.01, 1.0], &[0.0, -1.0, -0.02]]);
        let (there, back) = round_trip(&stiff, 0.04);
        assert!(there < 1e-10 && back < 1e-5, "{there:e} {back:e}");
    }

    #[test]
    fn exponential_of_a_rotation_and_of_a_nilpotent_matrix() {
        let e = exponential(matrix(&[&[0.0, -100.0], &[100.0, 0.0]]).as_ref());
        let (s, c) = 100.0_f64.sin_cos();
        assert!((e[(0, 0)] - c).abs() < 1e-12 && (e[(1, 0)] - s).abs() < 1e-12);
        let e = exponential(matrix(&[&[0.0, 7.0], &[0.0, 0.0]]).as_ref());
        assert!((e[(0, 0)] - 1.0).abs() < 1e-14 && (e[(0, 1)] - 7.0).abs() < 1e-13);
        assert_eq!(e[(1, 0)], 0.0);
    }

    #[test]
    fn a_logarithm_that_does_not_lead_back_is_none() {
        let b = matrix(&[&[1.0], &[1.0]]);
        let convert = |coupling: f64| {
            let a = matrix(&[&[0.9, coupling], &[0.0, 0.5]]);
            to_continuous(a.as_ref(), b.as_ref(), 0.1)
        };
        assert!(convert(10.0).unwrap().round_trip < 1e-12);
        // Far from normal, rounding is amplified: 3e-8 of A is lost at 1e3, more beyond.
        for coupling in [1e3, 1e4, 1e6] {
            let reason = convert(coupling).unwrap_err();
            assert!(reason.contains("inexact"), "{coupling}: {reason}");
        }
    }

    #[test]
    fn negative_and_zero_eigenvalues_have_no_real_logarithm() {
        let b = matrix(&[&[1.0], &[1.0]]);
        for (pole, word) in [(-0.3, "negative"), (0.0, "zero")] {
            let a = matrix(&[&[pole, 0.0], &[0.0, 0.5]]);
            let reason = to_continuous(a.as_ref(), b.as_ref(), 0.1).unwrap_err();
            assert!(reason.contains(word), "{reason}");
        }
    }
}
