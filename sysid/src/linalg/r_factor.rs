//! R of a tall matrix whose rows come block by block: `R ← R of (R; block)` by Householder's
//! reflections, each of one entry of R and a column of the block (G. H. Golub, C. F. Van Loan,
//! *Matrix Computations*, 4th ed. 2013, 5.1 and 5.2). The block's columns stay in the cache; along
//! them the sums run in the widest vectors the processor has (chosen at run time by `pulp`).

use faer::{Mat, MatRef};
use pulp::{Arch, Simd, WithSimd};
use steerwright_formats::interruption::check;

/// Rows gathered before they are reduced; few enough to stay in the cache.
const BLOCK: usize = 256;
/// Rows are padded with zeros to a multiple of this, the widest vector there is.
const WIDEST: usize = 8;
/// From one column to the next: no power of 2, which would put all into the same cache lines.
const STRIDE: usize = BLOCK + WIDEST;
/// Columns that a reflection is applied to at once.
const GROUP: usize = 4;

/// An R factor that accumulates rows.
#[derive(Debug, Clone)]
pub(crate) struct RFactor {
    columns: usize,
    r: Vec<f64>,
    /// Rows gathered since, column by column.
    block: Vec<f64>,
    gathered: usize,
}

impl RFactor {
    pub(crate) fn new(columns: usize) -> Self {
        let (r, block) = (vec![0.0; columns * columns], vec![0.0; columns * STRIDE]);
        Self { columns, r, block, gathered: 0 }
    }

    pub(crate) fn push(&mut self, row: &[f64]) {
        debug_assert_eq!(row.len(), self.columns);
        if self.gathered == BLOCK {
            self.reduce();
        }
        for (column, value) in self.block.chunks_exact_mut(STRIDE).zip(row) {
            column[self.gathered] = *value;
        }
        self.gathered += 1;
    }

    pub(crate) fn accumulate(&mut self, rows: MatRef<'_, f64>) {
        let mut from = 0;
        while from < rows.nrows() {
            if self.gathered == BLOCK {
                self.reduce();
            }
            let count = (BLOCK - self.gathered).min(rows.nrows() - from);
            for (column, j) in self.block.chunks_exact_mut(STRIDE).zip(0..rows.ncols()) {
                let to = &mut column[self.gathered..self.gathered + count];
                to.iter_mut()
                    .zip(rows.col(j).get(from..from + count).iter())
                    .for_each(|(to, x)| *to = *x);
            }
            (self.gathered, from) = (self.gathered + count, from + count);
        }
    }

    fn reduce(&mut self) {
        check();
        let height = self.gathered.next_multiple_of(WIDEST);
        for column in self.block.chunks_exact_mut(STRIDE) {
            column[self.gathered..height].fill(0.0);
        }
        let Self { columns, r, block, .. } = self;
        Arch::new().dispatch(Reflections { columns: *columns, height, r, block });
        self.gathered = 0;
    }

    pub(crate) fn finish(mut self) -> Mat<f64> {
        self.reduce();
        let columns = self.columns;
        Mat::from_fn(columns, columns, |i, j| self.r[i * columns + j])
    }
}

struct Reflections<'a> {
    columns: usize,
    height: usize,
    r: &'a mut [f64],
    block: &'a mut [f64],
}

impl WithSimd for Reflections<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { columns, height, r, block } = self;
        for k in 0..columns {
            let (before, after) = block.split_at_mut((k + 1) * STRIDE);
            let v = &mut before[k * STRIDE..][..height];
            let row = &mut r[k * columns..(k + 1) * columns];
            let [below] = dots::<S, 1>(simd, v, [v]);
            if below == 0.0 {
                continue;
            }
            // H = I − τ (1; v)(1; v)ᵀ takes (α; v) to (β; 0).
            let alpha = row[k];
            let beta = -alpha.hypot(below.sqrt()).copysign(alpha);
            let (tau, scale) = ((beta - alpha) / beta, (alpha - beta).recip());
            v.iter_mut().for_each(|v| *v *= scale);
            row[k] = beta;
            let v = &*v;
            let reflect = |places: &mut [f64], others: &mut [f64]| {
                if let [a, b, c, d] = places {
                    let [of_a, of_b, of_c, of_d] = apart::<GROUP>(others, height);
                    let sums = dots(simd, v, [&*of_a, &*of_b, &*of_c, &*of_d]);
                    let mut times = [0.0; GROUP];
                    for ((place, sum), t) in [a, b, c, d].into_iter().zip(sums).zip(&mut times) {
                        *t = tau * (*place + sum);
                        *place -= *t;
                    }
                    subtract(simd, times, v, [of_a, of_b, of_c, of_d]);
                } else {
                    for (place, other) in places.iter_mut().zip(others.chunks_exact_mut(STRIDE)) {
                        let other = &mut other[..height];
                        let [sum] = dots(simd, v, [&*other]);
                        let times = tau * (*place + sum);
                        *place -= times;
                        subtract(simd, [times], v, [other]);
                    }
                }
            };
            let places = row[k + 1..].chunks_mut(GROUP);
            for (places, others) in places.zip(after.chunks_mut(GROUP * STRIDE)) {
                reflect(places, others);
            }
        }
    }
}

/// The first `height` rows of so many columns.
#[inline(always)]
fn apart<const G: usize>(mut columns: &mut [f64], height: usize) -> [&mut [f64]; G] {
    std::array::from_fn(|_| {
        let (first, rest) = std::mem::take(&mut columns).split_at_mut(STRIDE);
        columns = rest;
        &mut first[..height]
    })
}

/// vᵀx of several x.
#[inline(always)]
fn dots<S: Simd, const G: usize>(simd: S, v: &[f64], x: [&[f64]; G]) -> [f64; G] {
    let v = S::as_simd_f64s(v).0;
    let x = x.map(|x| &S::as_simd_f64s(x).0[..v.len()]);
    let mut sums = [[simd.splat_f64s(0.0); 2]; G];
    for t in (0..v.len()).step_by(2) {
        for (sum, x) in sums.iter_mut().zip(&x) {
            sum[0] = simd.mul_add_e_f64s(v[t], x[t], sum[0]);
            if t + 1 < v.len() {
                sum[1] = simd.mul_add_e_f64s(v[t + 1], x[t + 1], sum[1]);
            }
        }
    }
    sums.map(|[even, odd]| simd.reduce_sum_f64s(simd.add_f64s(even, odd)))
}

/// x ← x − times·v of several x.
#[inline(always)]
fn subtract<S: Simd, const G: usize>(simd: S, times: [f64; G], v: &[f64], x: [&mut [f64]; G]) {
    let v = S::as_simd_f64s(v).0;
    let times = times.map(|t| simd.splat_f64s(-t));
    let mut x = x.map(|x| &mut S::as_mut_simd_f64s(x).0[..v.len()]);
    for (t, v) in v.iter().enumerate() {
        for (x, times) in x.iter_mut().zip(times) {
            x[t] = simd.mul_add_e_f64s(times, *v, x[t]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dense::is_finite;

    /// RᵀR is that of all rows for any number of columns and rows, and R triangular.
    #[test]
    fn the_r_factor_is_that_of_all_rows() {
        let value = |i: usize, j: usize| {
            ((i * 7919 + j * 104_729 + i * j * 31) % 10_007) as f64 / 5000.0 - 1.0
        };
        for columns in [1, 2, 5, 6, 13, 30] {
            for rows in [0, 1, 3, 255, 256, 257, 700] {
                // A column of zeros, one nearly the sum of two others, and one of another unit.
                let m = Mat::from_fn(rows, columns, |i, j| match j {
                    2 => 0.0,
                    3 => value(i, 0) + value(i, 1) + 1e-9 * value(i, 3),
                    4 => 1e12 * value(i, 4),
                    _ => value(i, j),
                });
                let mut all = RFactor::new(columns);
                let half = rows / 2;
                (0..half).for_each(|i| all.push(&row(&m, i)));
                let mut rest = RFactor::new(columns);
                (half..rows).for_each(|i| rest.push(&row(&m, i)));
                all.accumulate(rest.finish().as_ref());
                let r = all.finish();
                let mut pushed = RFactor::new(columns);
                (0..rows).for_each(|i| pushed.push(&row(&m, i)));
                let mut in_blocks = RFactor::new(columns);
                in_blocks.accumulate(m.get(..half, ..));
                in_blocks.accumulate(m.get(half.., ..));
                assert_eq!(in_blocks.finish(), pushed.finish(), "{rows} by {columns}");
                assert!((0..columns).all(|j| (j + 1..columns).all(|i| r[(i, j)] == 0.0)));
                let (got, expected) = (r.transpose() * &r, m.transpose() * &m);
                for (i, j) in (0..columns).flat_map(|j| (0..columns).map(move |i| (i, j))) {
                    let size = (expected[(i, i)] * expected[(j, j)]).sqrt();
                    let apart = (got[(i, j)] - expected[(i, j)]).abs();
                    assert!(apart <= 1e-13 * size, "{rows} by {columns}, {i} {j}: {apart} {size}");
                }
                // What distinguishes the nearly dependent column from the others is not lost, as it
                // would be in the products.
                if rows >= 255 && columns > 3 {
                    let reference = m.qr().thin_R().to_owned();
                    let of = |r: &Mat<f64>| r.get(2..4, 3..4).norm_l2();
                    let (got, expected) = (of(&r), of(&reference));
                    assert!((got - expected).abs() < 1e-5 * expected, "{got} {expected}");
                }
            }
        }
    }

    fn row(m: &Mat<f64>, i: usize) -> Vec<f64> {
        m.row(i).iter().copied().collect()
    }

    #[test]
    fn what_is_not_finite_is_not_hidden() {
        for wrong in [f64::NAN, f64::INFINITY, 1e300] {
            let mut all = RFactor::new(2);
            all.push(&[wrong, 1.0]);
            all.push(&[1.0, 2.0]);
            assert!(!is_finite(all.finish().as_ref()), "{wrong}");
        }
    }
}
