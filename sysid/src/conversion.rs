//! Discrete ↔ continuous time under a zero-order hold (eq 6–11).
//!
//! Eq 9 and 10 together are one exponential, `exp([F G; 0 0]·T) = [A B; 0 I]`, so its logarithm
//! inverts both exactly.
//!
//! The exponential is by Padé approximation with scaling and squaring (Higham 2005). The logarithm
//! is by inverse scaling and squaring: square roots by the product form of the Denman–Beavers
//! iteration with determinantal scaling (Cheng, Higham, Kenney and Laub 2001) until the matrix is
//! near I, then the diagonal Padé approximant of degree 7 as partial fractions on Gauss–Legendre
//! nodes (Higham, *Functions of Matrices*, 2008, ch. 11).

use crate::dense::{eigenvalues, identity, is_finite, relative_difference, solve};
use faer::{Mat, MatRef};
use std::f64::consts::PI;

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

/// Round trips worse than this count as no logarithm: the discrete model is the one identified, and
/// a continuous one that does not lead back to it is another model.
const WORST_ROUND_TRIP: f64 = 1e-10;

/// `(A, B)` with eq 9–10 from `(F, G)` and the sample time.
#[must_use]
pub fn discretize(
    f: MatRef<'_, f64>,
    g: MatRef<'_, f64>,
    sample_time: f64,
) -> (Mat<f64>, Mat<f64>) {
    let (n, m) = (f.nrows(), g.ncols());
    let joined = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => f[(i, j)] * sample_time,
        (true, false) => g[(i, j - n)] * sample_time,
        _ => 0.0,
    });
    let e = exponential(joined.as_ref());
    (e.get(..n, ..n).to_owned(), e.get(..n, n..).to_owned())
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
    // B is scaled to the size of A, so that it does not worsen the logarithm's conditioning.
    let size = b.norm_l2();
    let scale = if size > 0.0 { a.norm_l2() / size } else { 1.0 };
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

/// Matrix exponential.
#[must_use]
pub fn exponential(a: MatRef<'_, f64>) -> Mat<f64> {
    const B: [f64; 14] = [
        64_764_752_532_480_000.0,
        32_382_376_266_240_000.0,
        7_771_770_303_897_600.0,
        1_187_353_796_428_800.0,
        129_060_195_264_000.0,
        10_559_470_521_600.0,
        670_442_572_800.0,
        33_522_128_640.0,
        1_323_241_920.0,
        40_840_800.0,
        960_960.0,
        16_380.0,
        182.0,
        1.0,
    ];
    let n = a.nrows();
    let norm = one_norm(a);
    let squarings = if norm > 5.37 { (norm / 5.37).log2().ceil().min(1000.0) as i32 } else { 0 };
    let factor = 0.5_f64.powi(squarings);
    let a = Mat::from_fn(n, n, |i, j| a[(i, j)] * factor);
    let (i, a2) = (identity(n), &a * &a);
    let a4 = &a2 * &a2;
    let a6 = &a4 * &a2;
    let sum = |k: [f64; 4]| {
        Mat::from_fn(n, n, |r, c| {
            k[0] * a6[(r, c)] + k[1] * a4[(r, c)] + k[2] * a2[(r, c)] + k[3] * i[(r, c)]
        })
    };
    let u = &a * (&a6 * sum([B[13], B[11], B[9], 0.0]) + sum([B[7], B[5], B[3], B[1]]));
    let v = &a6 * sum([B[12], B[10], B[8], 0.0]) + sum([B[6], B[4], B[2], B[0]]);
    let mut e = solve((&v - &u).as_ref(), (&v + &u).as_ref());
    for _ in 0..squarings {
        e = &e * &e;
    }
    e
}

/// Principal matrix logarithm; `None` where the iteration does not converge.
#[must_use]
pub fn logarithm(a: MatRef<'_, f64>) -> Option<Mat<f64>> {
    const NEAR: f64 = 0.264;
    let n = a.nrows();
    let mut root = a.to_owned();
    let mut halvings = 0;
    while one_norm((&root - identity(n)).as_ref()) > NEAR {
        root = square_root(root.as_ref())?;
        halvings += 1;
        if halvings > 60 {
            return None;
        }
    }
    let x = root - identity(n);
    let mut sum = Mat::<f64>::zeros(n, n);
    for (node, weight) in gauss_legendre_7() {
        let denominator =
            Mat::from_fn(n, n, |i, j| node * x[(i, j)] + if i == j { 1.0 } else { 0.0 });
        let term = solve(denominator.as_ref(), x.as_ref());
        sum = Mat::from_fn(n, n, |i, j| sum[(i, j)] + weight * term[(i, j)]);
    }
    let factor = 2.0_f64.powi(halvings);
    let log = Mat::from_fn(n, n, |i, j| factor * sum[(i, j)]);
    is_finite(log.as_ref()).then_some(log)
}

/// Principal square root: M_{k+1} = ½(I + (μ²M + μ⁻²M⁻¹)/2), X_{k+1} = ½ μ X (I + μ⁻²M⁻¹).
fn square_root(a: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let n = a.nrows();
    let one = identity(n);
    let (mut m, mut x) = (a.to_owned(), a.to_owned());
    let mut last = f64::INFINITY;
    for _ in 0..100 {
        let distance = (&m - &one).norm_l2();
        if !distance.is_finite() {
            return None;
        }
        // Rounding stops the quadratic convergence near n·ε.
        if distance < 1e-15 * n as f64 || (distance < 1e-9 && distance >= last) {
            return Some(x);
        }
        last = distance;
        let mu2 = if distance > 1e-2 {
            let determinant = m.determinant().abs();
            determinant.powf(-1.0 / n as f64).clamp(1e-12, 1e12)
        } else {
            1.0
        };
        let mu = mu2.sqrt();
        let inverse = solve(m.as_ref(), one.as_ref());
        x = Mat::from_fn(n, n, |i, j| 0.5 * mu * x[(i, j)])
            * Mat::from_fn(n, n, |i, j| one[(i, j)] + inverse[(i, j)] / mu2);
        m = Mat::from_fn(n, n, |i, j| {
            0.5 * (one[(i, j)] + 0.5 * (mu2 * m[(i, j)] + inverse[(i, j)] / mu2))
        });
    }
    (last < 1e-9).then_some(x)
}

/// Nodes and weights on 0..1.
fn gauss_legendre_7() -> [(f64, f64); 7] {
    const NODES: [(f64, f64); 4] = [
        (0.0, 0.417_959_183_673_469_4),
        (0.405_845_151_377_397_2, 0.381_830_050_505_118_9),
        (0.741_531_185_599_394_4, 0.279_705_391_489_276_7),
        (0.949_107_912_342_758_5, 0.129_484_966_168_869_7),
    ];
    let mut out = [(0.5, 0.5 * NODES[0].1); 7];
    for (k, (x, w)) in NODES.iter().skip(1).enumerate() {
        out[2 * k + 1] = (0.5 * (1.0 + x), 0.5 * w);
        out[2 * k + 2] = (0.5 * (1.0 - x), 0.5 * w);
    }
    out
}

fn one_norm(m: MatRef<'_, f64>) -> f64 {
    (0..m.ncols()).map(|j| m.col(j).norm_l1()).fold(0.0, f64::max)
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
        for a in [matrix(&[&[-0.3, 0.0], &[0.0, 0.5]]), matrix(&[&[0.0, 0.0], &[0.0, 0.5]])] {
            assert!(to_continuous(a.as_ref(), b.as_ref(), 0.1).is_err());
        }
    }
}
