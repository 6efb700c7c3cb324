//! Models and references the tests share. The references use no code of the crate.
#![allow(dead_code, unreachable_pub)]

use nalgebra::DMatrix;
use steerwright_formats::InputKind;
use steerwright_formats::{Guidance, PathPoint};
use steerwright_models::{Continuous, GuidanceParameters, IdentifiedData, Sideslip};

/// `e^A` by 60 Taylor terms after scaling to a norm below 2, then squaring. Each
/// squaring doubles the rounding: this reference, not the crate, sets the tolerance at large norms.
pub fn taylor_exponential(a: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    let norm = a.abs().row_sum().max();
    let squarings = (norm / 2.0).log2().ceil().max(0.0) as i32;
    let scaled = a / 2_f64.powi(squarings);
    let mut term = DMatrix::identity(n, n);
    let mut sum = DMatrix::identity(n, n);
    for k in 1..60 {
        term = &term * &scaled / f64::from(k);
        sum += &term;
    }
    for _ in 0..squarings {
        sum = &sum * &sum;
    }
    sum
}

/// `(A, B)` of eq 9–10 by the same means.
pub fn sample(f: &DMatrix<f64>, g: &DMatrix<f64>, step: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = f.nrows();
    let mut m = DMatrix::zeros(n + 1, n + 1);
    m.view_mut((0, 0), (n, n)).copy_from(f);
    m.view_mut((0, n), (n, 1)).copy_from(g);
    let e = taylor_exponential(&(m * step));
    (e.view((0, 0), (n, n)).into_owned(), e.view((0, n), (n, 1)).into_owned())
}

/// A car's yaw rate at 15 m/s: third order, complex poles, in a skewed basis.
pub fn car() -> IdentifiedData {
    from_continuous(
        vec![-6.0, 11.0, 0.5, -9.0, -5.0, 14.0, 0.0, 0.3, -8.0],
        vec![0.4, 6.0, 8.0],
        vec![0.8, 1.1, -0.2],
        0.0,
        0.02,
    )
}

/// The model whose continuous form is given.
pub fn from_continuous(f: Vec<f64>, g: Vec<f64>, h: Vec<f64>, d: f64, ts: f64) -> IdentifiedData {
    let n = g.len();
    let (a, b) = sample(&DMatrix::from_row_slice(n, n, &f), &DMatrix::from_row_slice(n, 1, &g), ts);
    IdentifiedData {
        sample_time: ts,
        a: a.transpose().as_slice().to_vec(),
        b: b.as_slice().to_vec(),
        c: h.clone(),
        d,
        k: (0..n).map(|i| 0.3 / (i + 1) as f64).collect(),
        continuous: Some(Continuous { f, g, h }),
        input: InputKind::Steering,
        delay: 0.0,
        steering_offset: 0.01,
        yaw_rate_offset: 0.02,
        speed: 15.0,
        innovation_std: 0.01,
        sideslip: Sideslip { per_yaw_rate: -0.06, ..Sideslip::default() },
    }
}

/// Fourth-order Runge–Kutta over `time` in `count` steps, with compensated summation.
pub fn runge_kutta<const N: usize>(
    mut x: [f64; N],
    time: f64,
    count: usize,
    f: impl Fn(&[f64; N]) -> [f64; N],
) -> [f64; N] {
    let h = time / count as f64;
    let mut lost = [0.0; N];
    let shift = |x: &[f64; N], k: &[f64; N], s: f64| {
        let mut y = *x;
        y.iter_mut().zip(k).for_each(|(y, k)| *y += s * k);
        y
    };
    for _ in 0..count {
        let k1 = f(&x);
        let k2 = f(&shift(&x, &k1, h / 2.0));
        let k3 = f(&shift(&x, &k2, h / 2.0));
        let k4 = f(&shift(&x, &k3, h));
        for i in 0..N {
            let add = h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) - lost[i];
            let sum = x[i] + add;
            lost[i] = (sum - x[i]) - add;
            x[i] = sum;
        }
    }
    x
}

/// Points of a road whose curvature is a function of distance, by fine quadrature.
pub fn road(length: f64, spacing: f64, curvature: impl Fn(f64) -> f64) -> Vec<PathPoint> {
    let fine = 400;
    let h = spacing / f64::from(fine);
    let (mut x, mut y, mut psi) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut points = Vec::new();
    for i in 0..=(length / spacing).round() as i32 {
        let s = f64::from(i) * spacing;
        points.push(PathPoint {
            distance_m: s,
            x_m: x,
            y_m: y,
            heading_rad: psi,
            curvature_per_m: curvature(s),
        });
        for k in 0..fine {
            let s = s + f64::from(k) * h;
            let (first, second) = (curvature(s), curvature(s + h));
            let middle = psi + h / 2.0 * curvature(s + h / 4.0);
            x += h * middle.cos();
            y += h * middle.sin();
            psi += h / 6.0 * (first + 4.0 * curvature(s + h / 2.0) + second);
        }
    }
    points
}

/// The law of a guidance whose sideslip is that of every speed.
pub fn guided(guidance: Guidance) -> GuidanceParameters {
    GuidanceParameters { guidance, ..GuidanceParameters::default() }
}
