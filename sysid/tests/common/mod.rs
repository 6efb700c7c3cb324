//! Signals and systems for the tests.
#![allow(clippy::unwrap_used, clippy::panic)]
#![allow(dead_code)] // each test binary uses a part of it

use faer::Mat;
use sysid::StateSpace;

/// A small generator (SplitMix64), so that tests are the same everywhere.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        let (a, b) = (self.uniform().max(1e-300), self.uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    pub(crate) fn matrix(&mut self, rows: usize, columns: usize) -> Mat<f64> {
        let values: Vec<f64> = (0..rows * columns).map(|_| self.normal()).collect();
        Mat::from_fn(rows, columns, |i, j| values[i * columns + j])
    }

    /// A stable random system with poles spread over the disc of radius 0.95.
    pub(crate) fn system(&mut self, n: usize, m: usize, p: usize) -> StateSpace {
        let a = self.matrix(n, n);
        let probe =
            StateSpace { a, b: self.matrix(n, m), c: self.matrix(p, n), d: self.matrix(p, m) };
        let shrink = 0.95 / probe.spectral_radius();
        StateSpace { a: Mat::from_fn(n, n, |i, j| probe.a[(i, j)] * shrink), ..probe }
    }
}

/// Largest distance between two sets of poles, each matched to its nearest.
pub(crate) fn pole_distance(a: &StateSpace, b: &StateSpace) -> f64 {
    let mut left = b.poles().unwrap();
    let mut worst: f64 = 0.0;
    for (re, im) in a.poles().unwrap() {
        let (k, d) = left
            .iter()
            .map(|(r, i)| (r - re).hypot(i - im))
            .enumerate()
            .min_by(|x, y| x.1.total_cmp(&y.1))
            .unwrap();
        left.swap_remove(k);
        worst = worst.max(d);
    }
    worst
}

/// Largest difference of Markov parameters over the largest of `a`'s.
pub(crate) fn markov_distance(a: &StateSpace, b: &StateSpace, count: usize) -> f64 {
    let (a, b) = (a.markov_parameters(count), b.markov_parameters(count));
    let size = a.iter().map(|m| m.norm_max()).fold(0.0, f64::max);
    a.iter().zip(&b).map(|(x, y)| (x - y).norm_max()).fold(0.0, f64::max) / size
}

/// Largest relative difference of the frequency responses (first input and output).
pub(crate) fn response_distance(a: &StateSpace, b: &StateSpace) -> f64 {
    let (mut worst, mut size): (f64, f64) = (0.0, 0.0);
    for k in 0..200 {
        let omega = std::f64::consts::PI * f64::from(k) / 200.0;
        let (x, y) = (a.frequency_response(0, 0, omega), b.frequency_response(0, 0, omega));
        worst = worst.max((x.0 - y.0).hypot(x.1 - y.1));
        size = size.max(x.0.hypot(x.1));
    }
    worst / size
}

/// A file of the repository's test data.
pub(crate) fn data(path: &str) -> Vec<u8> {
    let path = format!("{}/../tests/data/{path}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}
