//! Exponential and logarithm of a matrix. The exponential is nalgebra's (Higham 2009). The
//! logarithm is by inverse scaling and squaring: square roots by the product form of the
//! Denman–Beavers iteration with determinantal scaling (Cheng, Higham, Kenney and Laub 2001), then
//! the Padé approximant of degree 7 (Higham, *Functions of Matrices*, 2008, ch. 11).

use crate::linalg::dense::{identity, is_finite, solve};
use faer::{Mat, MatRef};
use nalgebra::DMatrix;

/// Matrix exponential; not a number where an entry is not finite or too large to be squared.
pub(crate) fn exponential(a: MatRef<'_, f64>) -> Mat<f64> {
    // nalgebra takes entries for finite, and their powers up to the tenth.
    const LARGEST: f64 = 1e30;
    let n = a.nrows();
    if n == 0 || !(is_finite(a) && one_norm(a) < LARGEST) {
        return Mat::from_fn(n, n, |_, _| f64::NAN);
    }
    let e = DMatrix::from_fn(n, n, |i, j| a[(i, j)]).exp();
    Mat::from_fn(n, n, |i, j| e[(i, j)])
}

/// Principal matrix logarithm; `None` where the iteration does not converge.
pub(crate) fn logarithm(a: MatRef<'_, f64>) -> Option<Mat<f64>> {
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
    if is_finite(log.as_ref()) { Some(log) } else { None }
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
    if last < 1e-9 { Some(x) } else { None }
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
