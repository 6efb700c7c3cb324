//! Products of small matrices with vectors whose entries are padded with zeros to whole vectors of the processor: the
//! inner loop of filters that run side by side. The same sums whatever the vectors are.

use faer::MatRef;

/// Numbers in a block.
pub(crate) const LANES: usize = 4;
type Block = [f64; LANES];

/// Blocks that so many numbers take.
pub(crate) fn blocks_of(count: usize) -> usize {
    count.div_ceil(LANES).max(1)
}

/// The rows of a matrix one after the other, each padded.
pub(crate) fn padded_rows(m: MatRef<'_, f64>) -> Vec<f64> {
    let width = LANES * blocks_of(m.ncols());
    let value = |i: usize, j: usize| if j < m.ncols() { m[(i, j)] } else { 0.0 };
    (0..m.nrows()).flat_map(|i| (0..width).map(move |j| value(i, j))).collect()
}

/// xᵀy of padded vectors of `B` blocks; of any number where `B` is 0.
#[inline(always)]
pub(crate) fn block_dot<const B: usize>(x: &[f64], y: &[f64]) -> f64 {
    let (x, y) = (x.as_chunks::<LANES>().0, y.as_chunks::<LANES>().0);
    let count = if B == 0 { x.len() } else { B };
    let mut sums = [0.0; LANES];
    for (x, y) in x[..count].iter().zip(&y[..count]) {
        for i in 0..LANES {
            sums[i] += x[i] * y[i];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// A matrix stored column by column, each padded.
#[derive(Debug, Clone)]
pub(crate) struct BlockColumns {
    blocks: usize,
    values: Vec<f64>,
}

impl BlockColumns {
    pub(crate) fn new(m: MatRef<'_, f64>) -> Self {
        Self { blocks: blocks_of(m.nrows()), values: padded_rows(m.transpose()) }
    }

    pub(crate) fn blocks(&self) -> usize {
        self.blocks
    }

    /// `out ← out + M·x` with an `out` of `B` blocks; of any number where `B` is 0. A column for each entry of x.
    #[inline(always)]
    pub(crate) fn add_product<const B: usize>(&self, x: &[f64], out: &mut [f64]) {
        if B == 0 {
            for first in 0..self.blocks {
                self.add_rows::<1>(first, self.blocks, x, &mut out[LANES * first..]);
            }
        } else {
            self.add_rows::<B>(0, B, x, out);
        }
    }

    /// Of the rows from the block `first` on, of columns of `height` blocks.
    #[inline(always)]
    fn add_rows<const B: usize>(&self, first: usize, height: usize, x: &[f64], out: &mut [f64]) {
        let Some(out) = out.as_chunks_mut::<LANES>().0.first_chunk_mut::<B>() else { return };
        let columns = self.values.as_chunks::<LANES>().0;
        let (pairs, last) = (columns.chunks_exact(2 * height), x.as_chunks::<2>());
        let rest = pairs.remainder();
        // Two sums side by side, since a sum waits for the one before.
        let (mut sums, mut others) = (*out, [[0.0; LANES]; B]);
        for (pair, [even, odd]) in pairs.zip(last.0) {
            add::<B>(&mut sums, &pair[first..], *even);
            add::<B>(&mut others, &pair[height + first..], *odd);
        }
        for (column, x) in rest.chunks_exact(height).zip(last.1) {
            add::<B>(&mut sums, &column[first..], *x);
        }
        for (out, (sum, other)) in out.iter_mut().zip(sums.iter().zip(&others)) {
            *out = std::array::from_fn(|i| sum[i] + other[i]);
        }
    }
}

/// `to ← to + x·column`.
#[inline(always)]
fn add<const B: usize>(to: &mut [Block; B], column: &[Block], x: f64) {
    for (to, column) in to.iter_mut().zip(column) {
        for i in 0..LANES {
            to[i] += column[i] * x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn products_are_those_of_matrices_of_any_height() {
        let value = |k: usize| ((k * 7919 + 13) % 101) as f64 / 50.0 - 1.0;
        let numbers = |count: usize, from: usize| (0..count).map(|k| value(from + k)).collect();
        for (height, width) in (1..=12).flat_map(|h| [0, 1, 2, 5, 6].map(|w| (h, w))) {
            let m = Mat::from_fn(height, width, |i, j| value(i + 14 * j));
            let x: Vec<f64> = numbers(width, 200);
            let columns = BlockColumns::new(m.as_ref());
            let blocks = columns.blocks();
            assert_eq!(blocks, height.div_ceil(LANES));
            let addend: Vec<f64> = numbers(LANES * blocks, 300);
            let (mut of_any, mut out) = (addend.clone(), addend.clone());
            columns.add_product::<0>(&x, &mut of_any);
            match blocks {
                1 => columns.add_product::<1>(&x, &mut out),
                2 => columns.add_product::<2>(&x, &mut out),
                _ => columns.add_product::<3>(&x, &mut out),
            }
            assert_eq!(of_any, out);
            for i in 0..height {
                let expected: f64 = (0..width).map(|j| m[(i, j)] * x[j]).sum();
                assert!((out[i] - addend[i] - expected).abs() < 1e-12, "{height} by {width}");
            }
            assert_eq!(out[height..], addend[height..]);
        }
        let rows = padded_rows(Mat::from_fn(2, 5, |i, j| value(i + 3 * j)).as_ref());
        assert_eq!(rows.len(), 16);
        let expected: f64 = (0..5).map(|j| value(3 * j) * value(1 + 3 * j)).sum();
        for dot in [block_dot::<0>, block_dot::<2>] {
            assert!((dot(&rows[..8], &rows[8..]) - expected).abs() < 1e-15);
        }
    }
}
