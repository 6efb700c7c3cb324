//! The derivatives against finite differences.

use super::coordinates::Coordinates;
use super::rows::{Drive, Sensitivities};
use super::search::each_error;
use crate::dataset::Segment;
use crate::dense::vcat;
use crate::model::StateSpace;
use faer::Mat;

/// Numbers that look random.
fn numbers(rows: usize, columns: usize, seed: usize) -> Mat<f64> {
    Mat::from_fn(rows, columns, |i, j| {
        let x = (i * 7919 + j * 104_729 + seed * 1_299_709 + 17) as f64;
        2.0 * ((x * 0.618_033_988_749_895).sin() * 43_758.545_3).rem_euclid(1.0) - 1.0
    })
}

fn model(n: usize, m: usize, p: usize) -> StateSpace {
    let a = numbers(n, n, 1);
    let shrink = 0.9 / crate::dense::spectral_radius(a.as_ref());
    StateSpace {
        a: Mat::from_fn(n, n, |i, j| shrink * a[(i, j)]),
        b: numbers(n, m, 2),
        c: numbers(p, n, 3),
        d: numbers(p, m, 4),
    }
}

fn errors(model: &StateSpace, drive: Drive, segment: &Segment, x0: &[f64]) -> Vec<f64> {
    let mut all = Vec::new();
    each_error(model, drive, segment, x0, |_, e| all.extend_from_slice(e));
    all
}

#[test]
fn derivatives_are_those_of_finite_differences() {
    const COUNT: usize = 30;
    const STEP: f64 = 1e-6;
    for (n, m, p) in [(1, 1, 1), (3, 1, 1), (4, 2, 1), (3, 1, 2), (5, 2, 3)] {
        for drive in [Drive::Inputs, Drive::InputsAndOutputs] {
            let segment = Segment::new(numbers(m, COUNT, 5), numbers(p, COUNT, 6));
            let width = drive.width(m, p);
            let moving: Vec<bool> = (0..width).map(|l| l < m).collect();
            let weight = Mat::from_fn(p, p, |i, j| if i >= j { 1.0 + (i + j) as f64 } else { 0.0 });
            let coordinates = Coordinates::new(&model(n, width, p), &weight, &moving).unwrap();
            let x0: Vec<f64> = (0..n).map(|i| 0.5 + 0.3 * i as f64).collect();
            let count = coordinates.count();
            assert_eq!(count, n * (p + width) + p * m);
            let line = n + count + 1;
            let mut rows = vec![0.0; p * line];
            let mut filters = Sensitivities::new(&coordinates, drive, &segment, &x0);
            let mut all = Vec::new();
            for t in 0..COUNT {
                filters.sample(t, &mut rows);
                all.extend_from_slice(&rows);
            }
            let here = errors(&coordinates.model, drive, &segment, &x0);
            for (k, e) in here.iter().enumerate() {
                assert!((all[k * line + line - 1] - e).abs() < 1e-12);
            }
            for column in 0..n + count {
                let moved = |by: f64| {
                    let mut x0 = x0.clone();
                    let mut step = vec![0.0; count];
                    if column < n {
                        x0[column] += by;
                    } else {
                        step[column - n] = by;
                    }
                    errors(&coordinates.moved(&step), drive, &segment, &x0)
                };
                let (ahead, behind) = (moved(STEP), moved(-STEP));
                for k in 0..ahead.len() {
                    let expected = (behind[k] - ahead[k]) / (2.0 * STEP);
                    let got = all[k * line + column];
                    let close = (got - expected).abs() < 1e-6 * (1.0 + expected.abs());
                    assert!(
                        close,
                        "{n} {m} {p} {drive:?} row {k} column {column}: {got} {expected}"
                    );
                }
            }
        }
    }
}

/// No move in these coordinates is a change of basis: together they span all of (A, B, C).
#[test]
fn coordinates_complement_the_changes_of_basis() {
    for (n, m, p) in [(2, 1, 1), (3, 1, 2), (4, 1, 3), (4, 3, 2)] {
        let coordinates =
            Coordinates::new(&model(n, m, p), &Mat::identity(p, p), &vec![false; m]).unwrap();
        let of = &coordinates.model;
        let isometry = vcat(&[of.a.as_ref(), of.c.as_ref()]);
        let unit = isometry.transpose() * &isometry - Mat::<f64>::identity(n, n);
        assert!(unit.norm_max() < 1e-8, "{:e}", unit.norm_max());
        let size = n * n + n * m + p * n;
        let mut all = Vec::new();
        for k in 0..coordinates.count() {
            let step: Vec<f64> =
                (0..coordinates.count()).map(|j| f64::from(u8::from(j == k))).collect();
            let delta = coordinates.direction(&step);
            all.push(
                [&delta.a, &delta.b, &delta.c].map(|m| crate::model::rows(m.as_ref())).concat(),
            );
        }
        for e in 0..n * n {
            let e = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i * n + j == e)));
            let (a, b, c) = (&e * &of.a - &of.a * &e, &e * &of.b, &of.c * &e);
            let minus = Mat::from_fn(p, n, |i, j| -c[(i, j)]);
            all.push([&a, &b, &minus].map(|m| crate::model::rows(m.as_ref())).concat());
        }
        let span = Mat::from_fn(size, all.len(), |i, j| all[j][i]);
        assert_eq!(span.nrows(), span.ncols());
        let singular = crate::dense::svd(span.as_ref()).unwrap().s;
        let least = singular[singular.len() - 1];
        assert!(least > 1e-3 * singular[0], "{n} {m} {p}: {least:e}");
    }
}
