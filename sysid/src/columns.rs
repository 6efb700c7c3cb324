//! Products of small matrices with vectors, many times over: the inner loop of every simulation.

use crate::model::rows;
use faer::MatRef;

/// A matrix stored column by column: its products with vectors then run along the result, which the
/// compiler can do several entries at a time.
#[derive(Debug, Clone)]
pub(crate) struct Columns {
    height: usize,
    values: Vec<f64>,
}

impl Columns {
    pub(crate) fn new(m: MatRef<'_, f64>) -> Self {
        Self { height: m.nrows(), values: rows(m.transpose()) }
    }

    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// out = self · x.
    pub(crate) fn product(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.add_product(x, out);
    }

    /// out += self · x, one column after the other.
    #[inline]
    pub(crate) fn add_product(&self, x: &[f64], out: &mut [f64]) {
        // Of a known height the sums stay in registers; beyond, they are as good in memory.
        match self.height {
            1 => self.of_height::<1>(x, out),
            2 => self.of_height::<2>(x, out),
            3 => self.of_height::<3>(x, out),
            4 => self.of_height::<4>(x, out),
            5 => self.of_height::<5>(x, out),
            6 => self.of_height::<6>(x, out),
            7 => self.of_height::<7>(x, out),
            8 => self.of_height::<8>(x, out),
            9 => self.of_height::<9>(x, out),
            10 => self.of_height::<10>(x, out),
            _ => self.of_any_height(x, out),
        }
    }

    #[inline]
    fn of_height<const N: usize>(&self, x: &[f64], out: &mut [f64]) {
        let Ok(out) = <&mut [f64; N]>::try_from(out) else { return };
        let mut sums = *out;
        for (column, v) in self.values.as_chunks::<N>().0.iter().zip(x) {
            for (sum, a) in sums.iter_mut().zip(column) {
                *sum += a * v;
            }
        }
        *out = sums;
    }

    fn of_any_height(&self, x: &[f64], out: &mut [f64]) {
        for (column, v) in self.values.chunks_exact(self.height.max(1)).zip(x) {
            for (o, a) in out.iter_mut().zip(column) {
                *o += a * v;
            }
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
        for (height, width) in (0..14).flat_map(|h| [0, 1, 2, 5].map(|w| (h, w))) {
            let m = Mat::from_fn(height, width, |i, j| value(i + 14 * j));
            let x: Vec<f64> = (0..width).map(|j| value(200 + j)).collect();
            let mut out = vec![f64::NAN; height];
            let columns = Columns::new(m.as_ref());
            columns.product(&x, &mut out);
            columns.add_product(&x, &mut out);
            for (i, o) in out.iter().enumerate() {
                let expected: f64 = (0..width).map(|j| 2.0 * m[(i, j)] * x[j]).sum();
                assert!((o - expected).abs() < 1e-12, "{height} by {width}: {o} {expected}");
            }
        }
    }
}
