//! The derivatives against finite differences.

use crate::data::{DataSet, Segment};
use crate::linalg::dense::{identity, solve, vcat};
use crate::model::{Innovation, StateSpace};
use crate::pem::coordinates::Coordinates;
use crate::pem::covariance::uncertain_simulation;
use crate::pem::rows::{Drive, Sensitivities};
use crate::pem::search::each_error;
use crate::pem::stable_gain;
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
    let shrink = 0.9 / crate::linalg::dense::spectral_radius(a.as_ref());
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
    // Long enough for the free response to fall by four orders of magnitude.
    const COUNT: usize = 100;
    const STEP: f64 = 1e-6;
    for (n, m, p) in [(1, 1, 1), (3, 1, 1), (4, 2, 1), (3, 1, 2), (5, 2, 3), (9, 1, 1), (13, 1, 1)]
    {
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
            let mut filters = Sensitivities::new(&coordinates, drive, &segment, &x0, None);
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
                [&delta.a, &delta.b, &delta.c]
                    .map(|m| crate::linalg::dense::rows(m.as_ref()))
                    .concat(),
            );
        }
        for e in 0..n * n {
            let e = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i * n + j == e)));
            let (a, b, c) = (&e * &of.a - &of.a * &e, &e * &of.b, &of.c * &e);
            let minus = Mat::from_fn(p, n, |i, j| -c[(i, j)]);
            all.push([&a, &b, &minus].map(|m| crate::linalg::dense::rows(m.as_ref())).concat());
        }
        let span = Mat::from_fn(size, all.len(), |i, j| all[j][i]);
        assert_eq!(span.nrows(), span.ncols());
        let singular = crate::linalg::dense::svd(span.as_ref()).unwrap().s;
        let least = singular[singular.len() - 1];
        assert!(least > 1e-3 * singular[0], "{n} {m} {p}: {least:e}");
    }
}

/// The offsets' columns are those of a constant on each output, and the errors are about the offsets.
#[test]
fn offsets_are_columns_of_ones() {
    let (n, m, p) = (2, 1, 2);
    let segment = Segment::new(numbers(m, 5, 5), numbers(p, 5, 6));
    let coordinates =
        Coordinates::new(&model(n, m, p), &Mat::identity(p, p), &vec![false; m]).unwrap();
    let (x0, offsets) = ([0.3, -0.2], [0.7, -2.0]);
    let row_of = |offsets: Option<&[f64]>| {
        let width = n + offsets.map_or(0, <[f64]>::len) + coordinates.count() + 1;
        let mut rows = vec![0.0; p * width];
        let mut filters = Sensitivities::new(&coordinates, Drive::Inputs, &segment, &x0, offsets);
        for t in 0..3 {
            filters.sample(t, &mut rows);
        }
        rows.chunks(width).map(<[f64]>::to_vec).collect::<Vec<_>>()
    };
    for (i, (with, without)) in row_of(Some(&offsets)).iter().zip(row_of(None)).enumerate() {
        assert_eq!(with[..n], without[..n]);
        assert_eq!(with[n..n + p], [[1.0, 0.0], [0.0, 1.0]][i]);
        let last = without.len() - 1;
        assert_eq!(with[n + p..n + p + last - n], without[n..last]);
        assert!((with[last + p] - (without[last] - offsets[i])).abs() < 1e-14);
    }
}

/// Of a first-order model on nine samples, too few for correlated errors, the covariance is σ²·(JᵀJ)⁻¹
/// with all that was estimated in J: the initial state, and the offset where there is one.
#[test]
fn the_covariance_is_that_of_least_squares_written_out() {
    const COUNT: usize = 9;
    let (a, b, c, x0) = (0.7, 0.5, 2.0, 0.8);
    let one = |x: f64| Mat::from_fn(1, 1, |_, _| x);
    let segment = Segment::new(numbers(1, COUNT, 5), numbers(1, COUNT, 6));
    let state_space = |a: f64, b: f64| StateSpace { a: one(a), b: one(b), c: one(c), d: one(0.0) };
    let data = DataSet::new(1.0, vec![segment.clone()]).unwrap();
    for offset in [false, true] {
        let of = |q: &[f64]| -> Vec<f64> {
            let all = errors(&state_space(q[0], q[1]), Drive::Inputs, &segment, &[q[2]]);
            all.iter().map(|e| e - if offset { q[3] } else { 0.0 }).collect()
        };
        let at: Vec<f64> = [a, b, x0, 0.0].into_iter().take(3 + usize::from(offset)).collect();
        let slopes = Mat::from_fn(COUNT, at.len(), |t, j| {
            let moved = |by: f64| {
                let mut q = at.clone();
                q[j] += by;
                of(&q)[t]
            };
            (moved(-1e-6) - moved(1e-6)) / 2e-6
        });
        let information = slopes.transpose() * &slopes;
        let inverse = solve(information.as_ref(), identity(at.len()).as_ref());
        let squares: f64 = of(&at).iter().map(|e| e * e).sum();
        let variance = squares / (COUNT - at.len()) as f64;
        let innovation = Innovation { model: state_space(a, b), gain: one(0.0) };
        let x0s = vec![vec![x0]];
        let (simulated, predicted) = ((x0s.as_slice(), &data), (x0s.as_slice(), &data));
        let none = crate::pem::neighbours::Neighbours::default();
        let found =
            uncertain_simulation(&innovation, simulated, predicted, false, offset, none).unwrap();
        // Moves of A, and of C·B, by the entries A, B, C.
        let moves: Vec<[f64; 2]> = (0..found.factor.ncols())
            .map(|k| [found.factor[(0, k)], c * found.factor[(1, k)] + b * found.factor[(2, k)]])
            .collect();
        for (i, j) in [(0, 0), (0, 1), (1, 1)] {
            let got: f64 = moves.iter().map(|m| m[i] * m[j]).sum();
            let scale = |i: usize| if i == 1 { c } else { 1.0 };
            let expected = variance * scale(i) * scale(j) * inverse[(i, j)];
            assert!((got / expected - 1.0).abs() < 1e-4, "{offset} {i} {j}: {got} {expected}");
        }
    }
}

#[test]
fn a_gain_is_halved_until_its_predictor_is_stable() {
    let one = |x: f64| Mat::from_fn(1, 1, |_, _| x);
    let model = StateSpace { a: one(0.5), b: one(1.0), c: one(1.0), d: one(0.0) };
    // 0.5 − 4, 0.5 − 2, 0.5 − 1.
    assert_eq!(stable_gain(&model, &one(4.0), 1.0).unwrap()[(0, 0)], 1.0);
    assert_eq!(stable_gain(&model, &one(0.4), 1.0).unwrap()[(0, 0)], 0.4);
}

#[test]
fn an_integrator_has_coordinates() {
    let model = StateSpace { a: identity(1), b: identity(1), c: identity(1), d: Mat::zeros(1, 1) };
    let found = Coordinates::new(&model, &identity(1), &[false]).unwrap();
    let of = &found.model;
    assert!((of.a[(0, 0)] - 1.0).abs() < 1e-9);
    assert!((of.c[(0, 0)] * of.b[(0, 0)] - 1.0).abs() < 1e-6, "{of:?}");
}
