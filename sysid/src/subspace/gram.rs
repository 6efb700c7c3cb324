//! The Gram matrix of the windows, from sums that need one pass and little memory.
//!
//! With windows h(t) = \[z(t); …; z(t+w−1)\] of the samples z = \[u; y\], Σ h hᵀ has displacement
//! structure (T. Kailath and A. H. Sayed, *Displacement structure: theory and applications*, SIAM
//! Review 37, 1995): `G(a+1, b+1) = G(a, b) + z(j+a) z(j+b)ᵀ − z(a) z(b)ᵀ`. So it follows from the
//! w lag sums of the first block row and the first and last w−1 samples of each segment, which add
//! up over segments in any order.
//!
//! The samples come with a constant taken off, the rest of the mean is taken off at the end, and
//! sums of blocks are added with their rounding errors kept (Knuth's two-sum), since the condition
//! is squared.

use crate::subspace::lags::{Block, lag_sums, padded};
use faer::Mat;

/// Sums over windows.
#[derive(Debug, Clone)]
pub(crate) struct Gram {
    channels: usize,
    window: usize,
    /// Lag sums as [`lag_sums`] lays them out.
    lags: Sums,
    /// Σ z(t) over the windows' first samples.
    firsts: Sums,
    /// Σ of tail·tailᵀ − head·headᵀ, the lower triangle, of the last and first w−1 samples.
    edges: Mat<f64>,
    edge_sums: Vec<f64>,
    scratch: Vec<f64>,
}

/// Second moments of the windows about their mean, divided by their number.
pub(crate) struct Moments {
    /// Covariance, variables in order of time, w·c square and symmetric.
    pub(crate) covariance: Mat<f64>,
    /// Means of the variables, without the constant that was taken off the samples.
    pub(crate) mean: Vec<f64>,
    /// Largest share of a variable's square that was its mean: what centring cancelled.
    pub(crate) cancellation: f64,
}

impl Gram {
    pub(crate) fn new(channels: usize, window: usize) -> Self {
        let edge = (window - 1) * channels;
        let sums = channels * channels * padded(window);
        Self {
            channels,
            window,
            lags: Sums::new(sums),
            firsts: Sums::new(channels),
            edges: Mat::zeros(edge, edge),
            edge_sums: vec![0.0; edge],
            scratch: vec![0.0; sums],
        }
    }

    /// Adds windows that start at the first `count` samples, channel c at `c * stride`.
    pub(crate) fn add_windows(&mut self, samples: &[f64], stride: usize, count: usize) {
        let Self { channels, window, .. } = *self;
        let block = Block { samples, stride, channels, count, lags: window };
        lag_sums(&block, &mut self.scratch);
        self.lags.add(&self.scratch);
        for c in 0..channels {
            self.firsts.add_one(c, sum(&samples[c * stride..][..count]));
        }
    }

    /// Adds the edges of a segment: its first and last w−1 samples, sample after sample.
    pub(crate) fn add_edges(&mut self, head: &[f64], tail: &[f64]) {
        for j in 0..head.len() {
            let (h, t) = (head[j], tail[j]);
            self.edge_sums[j] += t - h;
            for i in j..head.len() {
                self.edges[(i, j)] += tail[i] * t - head[i] * h;
            }
        }
    }

    /// Adds the sums of other segments, whose samples had `shift` more taken off than these.
    pub(crate) fn merge(&mut self, other: &Self, shift: &[f64], columns: usize) {
        let c = self.channels;
        let step = |lag: usize| &other.edge_sums[lag * c..(lag + 1) * c];
        // Σ z(t+k), from that of k = 0.
        let mut late: Vec<f64> = (0..c).map(|i| other.firsts.value(i)).collect();
        for lag in 0..self.window {
            for a in 0..c {
                for (b, late) in late.iter().enumerate() {
                    let moved = other.firsts.value(a) * shift[b]
                        + shift[a] * late
                        + columns as f64 * shift[a] * shift[b];
                    let at = (a * c + b) * padded(self.window) + lag;
                    self.lags.add_one(at, other.lags.high[at]);
                    self.lags.add_one(at, other.lags.low[at]);
                    self.lags.add_one(at, moved);
                }
            }
            if lag + 1 < self.window {
                late.iter_mut().zip(step(lag)).for_each(|(s, e)| *s += e);
            }
        }
        for (a, shift) in shift.iter().enumerate() {
            self.firsts.add_one(a, other.firsts.value(a));
            self.firsts.add_one(a, columns as f64 * shift);
        }
        let edge = self.edge_sums.len();
        for j in 0..edge {
            for i in j..edge {
                self.edges[(i, j)] += other.edges[(i, j)]
                    + other.edge_sums[i] * shift[j % c]
                    + shift[i % c] * other.edge_sums[j];
            }
            self.edge_sums[j] += other.edge_sums[j];
        }
    }

    pub(crate) fn write(&self, to: &mut Vec<f64>) {
        for sums in [&self.lags, &self.firsts] {
            to.extend(&sums.high);
            to.extend(&sums.low);
        }
        to.extend(&self.edge_sums);
        for j in 0..self.edge_sums.len() {
            to.extend((j..self.edge_sums.len()).map(|i| self.edges[(i, j)]));
        }
    }

    /// Takes what [`write`](Self::write) has appended; the rest, or `None` where there is too little.
    pub(crate) fn read<'a>(&mut self, mut from: &'a [f64]) -> Option<&'a [f64]> {
        let mut take = |to: &mut [f64]| {
            let (values, rest) = from.split_at_checked(to.len())?;
            to.copy_from_slice(values);
            from = rest;
            Some(())
        };
        for sums in [&mut self.lags, &mut self.firsts] {
            take(&mut sums.high)?;
            take(&mut sums.low)?;
        }
        take(&mut self.edge_sums)?;
        for j in 0..self.edge_sums.len() {
            let mut column = vec![0.0; self.edge_sums.len() - j];
            take(&mut column)?;
            column.iter().enumerate().for_each(|(i, x)| self.edges[(i + j, j)] = *x);
        }
        Some(from)
    }

    pub(crate) fn moments(&self, columns: usize) -> Moments {
        let (c, w) = (self.channels, self.window);
        let (size, count) = (c * w, columns as f64);
        let mut g = Mat::zeros(size, size);
        for i in 0..size {
            for j in 0..=i {
                // The lag sums are of the earlier sample times the later; i is the later.
                g[(i, j)] = if j < c {
                    let at = (j * c + i % c) * padded(w) + i / c;
                    self.lags.value(at)
                } else {
                    g[(i - c, j - c)] + self.edges[(i - c, j - c)]
                };
            }
        }
        let mut sums: Vec<f64> = (0..c).map(|i| self.firsts.value(i)).collect();
        for i in c..size {
            sums.push(sums[i - c] + self.edge_sums[i - c]);
        }
        let mut cancellation: f64 = 1.0;
        for i in 0..size {
            let square = g[(i, i)];
            for j in 0..=i {
                let centred = (g[(i, j)] - sums[i] * (sums[j] / count)) / count;
                g[(i, j)] = centred;
                g[(j, i)] = centred;
            }
            cancellation = cancellation.max(square / count / g[(i, i)]);
        }
        // A variable that does not change has 0/0 here, which `max` passes over.
        let mean = sums.iter().map(|s| s / count).collect();
        Moments { covariance: g, mean, cancellation }
    }
}

/// Sums that keep what rounding takes away.
#[derive(Debug, Clone)]
struct Sums {
    high: Vec<f64>,
    low: Vec<f64>,
}

impl Sums {
    fn new(count: usize) -> Self {
        Self { high: vec![0.0; count], low: vec![0.0; count] }
    }

    fn add_one(&mut self, at: usize, x: f64) {
        let (sum, error) = two_sum(self.high[at], x);
        self.high[at] = sum;
        self.low[at] += error;
    }

    fn add(&mut self, terms: &[f64]) {
        for ((high, low), x) in self.high.iter_mut().zip(&mut self.low).zip(terms) {
            let (sum, error) = two_sum(*high, *x);
            *high = sum;
            *low += error;
        }
    }

    fn value(&self, at: usize) -> f64 {
        self.high[at] + self.low[at]
    }
}

/// The sum and its rounding error (D. E. Knuth, *The Art of Computer Programming* 2, 4.2.2).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// A sum in eight strands, which the compiler keeps in vectors.
pub(crate) fn sum(x: &[f64]) -> f64 {
    let (chunks, rest) = x.as_chunks::<8>();
    let mut strands = [0.0; 8];
    for chunk in chunks {
        strands.iter_mut().zip(chunk).for_each(|(s, x)| *s += x);
    }
    strands.iter().sum::<f64>() + rest.iter().sum::<f64>()
}
