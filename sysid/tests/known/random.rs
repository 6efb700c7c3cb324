//! Random numbers and random systems, the same on every machine.

use faer::Mat;
use steerwright_sysid::StateSpace;

/// A small generator (SplitMix64), so that tests are the same everywhere.
#[derive(Debug, Clone)]
pub struct Random(pub u64);

impl Random {
    /// Uniform in 0..1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        let (a, b) = (self.uniform().max(1e-300), self.uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    /// A matrix of standard normal numbers.
    pub fn matrix(&mut self, rows: usize, columns: usize) -> Mat<f64> {
        let values: Vec<f64> = (0..rows * columns).map(|_| self.normal()).collect();
        Mat::from_fn(rows, columns, |i, j| values[i * columns + j])
    }

    /// A stable random system with poles spread over the disc of radius 0.95.
    pub fn system(&mut self, n: usize, m: usize, p: usize) -> StateSpace {
        let a = self.matrix(n, n);
        let probe =
            StateSpace { a, b: self.matrix(n, m), c: self.matrix(p, n), d: self.matrix(p, m) };
        let shrink = 0.95 / probe.spectral_radius();
        StateSpace { a: Mat::from_fn(n, n, |i, j| probe.a[(i, j)] * shrink), ..probe }
    }
}
