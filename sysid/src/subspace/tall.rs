//! The R factor of the windows by a blocked tall-skinny QR: each block's rows are factored together
//! with the R factor of those before (J. Demmel, L. Grigori, M. Hoemmen and J. Langou, SIAM J. Sci.
//! Comput. 34, 2012). A first column of ones is carried along, so that the rest of R is that of the
//! windows about their mean: offsets cost no digits.

use crate::linalg::dense::{r_factor, vcat};
use faer::{Mat, MatRef};

/// R of \[1 h(t)ᵀ\], rows t.
#[derive(Debug, Clone)]
pub(crate) struct Tall {
    channels: usize,
    /// At most 1 + w·c rows.
    r: Mat<f64>,
}

impl Tall {
    pub(crate) fn new(channels: usize, window: usize) -> Self {
        Self { channels, r: Mat::zeros(0, 1 + window * channels) }
    }

    /// Adds windows that start at the first `count` samples, channel c at `c * stride`.
    pub(crate) fn add_windows(&mut self, samples: &[f64], stride: usize, count: usize) {
        let kept = self.r.nrows();
        let mut stacked = Mat::zeros(kept + count, self.r.ncols());
        stacked.get_mut(..kept, ..).copy_from(&self.r);
        for j in 0..stacked.ncols() {
            let Some(column) = stacked.col_mut(j).try_as_col_major_mut() else { continue };
            let column = &mut column.as_slice_mut()[kept..];
            if j == 0 {
                column.fill(1.0);
            } else {
                let (lag, channel) = ((j - 1) / self.channels, (j - 1) % self.channels);
                column.copy_from_slice(&samples[channel * stride + lag..][..count]);
            }
        }
        self.r = r_factor(stacked.as_ref());
    }

    /// Adds the windows of another R factor, whose samples had `shift` more taken off than these.
    pub(crate) fn merge(&mut self, other: &Self, shift: &[f64]) {
        let r = Mat::from_fn(other.r.nrows(), other.r.ncols(), |i, j| {
            let moved = if j == 0 { 0.0 } else { other.r[(i, 0)] * shift[(j - 1) % self.channels] };
            other.r[(i, j)] + moved
        });
        self.r = r_factor(vcat(&[self.r.as_ref(), r.as_ref()]).as_ref());
    }

    pub(crate) fn write(&self, to: &mut Vec<f64>) {
        for i in 0..self.r.nrows() {
            to.extend((i..self.r.ncols()).map(|j| self.r[(i, j)]));
        }
    }

    /// Takes what [`write`](Self::write) appended; the rest, or `None` of too little.
    pub(crate) fn read<'a>(&mut self, mut from: &'a [f64], columns: usize) -> Option<&'a [f64]> {
        let size = self.r.ncols();
        let rows = columns.min(size);
        let mut r = Mat::zeros(rows, size);
        for i in 0..rows {
            let (values, rest) = from.split_at_checked(size - i)?;
            values.iter().enumerate().for_each(|(k, x)| r[(i, i + k)] = *x);
            from = rest;
        }
        self.r = r;
        Some(from)
    }

    /// R of the windows about their mean over √j, and the mean, in order of time.
    pub(crate) fn centred(&self, columns: usize) -> (Mat<f64>, Vec<f64>) {
        let size = self.r.ncols() - 1;
        let scale = 1.0 / (columns as f64).sqrt();
        let at = |i: usize, j: usize| if i < self.r.nrows() { self.r[(i, j)] } else { 0.0 };
        let rest = Mat::from_fn(size, size, |i, j| at(i + 1, j + 1) * scale);
        let mean = (0..size).map(|j| at(0, j + 1) / at(0, 0)).collect();
        (rest, mean)
    }
}

/// Columns of an R factor, factored again: lower triangular, with a diagonal that is not negative.
pub(crate) fn lower(chosen: MatRef<'_, f64>) -> Mat<f64> {
    let r = r_factor(chosen);
    let size = chosen.ncols();
    Mat::from_fn(size, size, |i, j| {
        if j >= r.nrows() {
            0.0
        } else if r[(j, j)] < 0.0 {
            -r[(j, i)]
        } else {
            r[(j, i)]
        }
    })
}
