//! Products of small matrices with vectors, many times over: the inner loop of every simulation.

use crate::linalg::dense::rows;
use faer::MatRef;

/// A matrix stored column by column, so that products with vectors run along the result.
#[derive(Debug, Clone)]
pub(crate) struct Columns {
    height: usize,
    values: Vec<f64>,
}

impl Columns {
    pub(crate) fn new(m: MatRef<'_, f64>) -> Self {
        Self { height: m.nrows(), values: rows(m.transpose()) }
    }

    #[inline(always)]
    pub(crate) fn product(&self, x: &[f64], out: &mut [f64]) {
        self.sum(x, Addend::Nothing, out);
    }

    #[inline(always)]
    pub(crate) fn product_and(&self, x: &[f64], factor: f64, column: &[f64], out: &mut [f64]) {
        self.sum(x, Addend::Column(factor, column), out);
    }

    #[inline(always)]
    pub(crate) fn add_product(&self, x: &[f64], out: &mut [f64]) {
        self.sum(x, Addend::Out, out);
    }

    #[inline(always)]
    fn sum(&self, x: &[f64], addend: Addend<'_>, out: &mut [f64]) {
        // Of a known height the sums stay in registers.
        match self.height {
            1 => self.of_height::<1>(x, addend, out),
            2 => self.of_height::<2>(x, addend, out),
            3 => self.of_height::<3>(x, addend, out),
            4 => self.of_height::<4>(x, addend, out),
            5 => self.of_height::<5>(x, addend, out),
            6 => self.of_height::<6>(x, addend, out),
            7 => self.of_height::<7>(x, addend, out),
            8 => self.of_height::<8>(x, addend, out),
            9 => self.of_height::<9>(x, addend, out),
            10 => self.of_height::<10>(x, addend, out),
            _ => self.of_any_height(x, addend, out),
        }
    }

    #[inline(always)]
    fn of_height<const N: usize>(&self, x: &[f64], addend: Addend<'_>, out: &mut [f64]) {
        let Some(out) = out.first_chunk_mut::<N>() else { return };
        let mut sums = match addend {
            Addend::Nothing => [0.0; N],
            Addend::Out => *out,
            Addend::Column(factor, column) => match column.first_chunk::<N>() {
                Some(column) => column.map(|value| factor * value),
                None => return,
            },
        };
        let columns = self.values.as_chunks::<N>().0;
        // Two sums side by side, since a sum waits for the one before.
        let mut others = [0.0; N];
        let ((pairs, last), (twos, one)) = (columns.as_chunks::<2>(), x.as_chunks::<2>());
        for ([even, odd], [v, w]) in pairs.iter().zip(twos) {
            for i in 0..N {
                sums[i] += even[i] * v;
                others[i] += odd[i] * w;
            }
        }
        for (column, v) in last.iter().zip(one) {
            for i in 0..N {
                sums[i] += column[i] * v;
            }
        }
        *out = std::array::from_fn(|i| sums[i] + others[i]);
    }

    fn of_any_height(&self, x: &[f64], addend: Addend<'_>, out: &mut [f64]) {
        match addend {
            Addend::Nothing => out.fill(0.0),
            Addend::Out => {}
            Addend::Column(factor, column) => {
                out.iter_mut().zip(column).for_each(|(o, value)| *o = factor * value);
            }
        }
        for (column, v) in self.values.chunks_exact(self.height.max(1)).zip(x) {
            for (o, a) in out.iter_mut().zip(column) {
                *o += a * v;
            }
        }
    }
}

/// The addend of a product.
#[derive(Clone, Copy)]
enum Addend<'a> {
    Nothing,
    Out,
    Column(f64, &'a [f64]),
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
            let addend = out.clone();
            columns.product_and(&x, 3.0, &addend, &mut out);
            for (i, o) in out.iter().enumerate() {
                let expected: f64 = (0..width).map(|j| 7.0 * m[(i, j)] * x[j]).sum();
                assert!((o - expected).abs() < 1e-12, "{height} by {width}: {o} {expected}");
            }
        }
    }
}
