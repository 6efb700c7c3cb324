//! The matrix exponential by Padé approximation with scaling and squaring (Higham 2005).

use crate::linalg::dense::{identity, solve};
use faer::{Mat, MatRef};

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

pub(super) fn one_norm(m: MatRef<'_, f64>) -> f64 {
    (0..m.ncols()).map(|j| m.col(j).norm_l1()).fold(0.0, f64::max)
}
