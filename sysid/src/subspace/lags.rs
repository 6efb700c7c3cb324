//! Sums of lagged products Σ_t a(t)·b(t+k) of a block of samples: the one loop that is as long as
//! the log, in the widest vectors the processor has (chosen at run time by `pulp`), which run over
//! lags. A group of accumulators stays in the registers.

use pulp::{Arch, Simd, WithSimd};

/// Lags are padded to a multiple of this, the widest vector there is.
const WIDEST: usize = 8;
/// Vectors of lags at once for two channels: 8 accumulators hide the multiply-add's latency.
const GROUP: usize = 4;

/// Places for the sums of one pair of channels: the lags rounded up.
pub(crate) fn padded(lags: usize) -> usize {
    lags.next_multiple_of(WIDEST)
}

/// Samples of some channels, one channel after the other.
pub(crate) struct Block<'a> {
    /// Channel c has its samples at `c * stride`, of which the first `count + padded(lags)` exist;
    /// those past `count + lags - 1` only reach sums beyond the last lag.
    pub(crate) samples: &'a [f64],
    pub(crate) stride: usize,
    pub(crate) channels: usize,
    pub(crate) count: usize,
    /// Lags 0 to `lags − 1`.
    pub(crate) lags: usize,
}

/// Sums of all pairs of channels: that of a, b and lag k goes to `(a·channels + b)·padded + k`.
pub(crate) fn lag_sums(block: &Block<'_>, sums: &mut [f64]) {
    // Asking the processor takes longer than a short block, so `Arch` remembers the answer.
    Arch::new().dispatch(Kernel { block, sums });
}

struct Kernel<'a, 'b> {
    block: &'a Block<'b>,
    sums: &'a mut [f64],
}

impl WithSimd for Kernel<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Block { samples, stride, channels, count, lags } = *self.block;
        let vectors = padded(lags) / S::F64_LANES;
        let jobs = channels * vectors;
        let channel = |c: usize| &samples[c * stride..];
        for first in (0..channels).step_by(2) {
            // The last of an odd number of channels is its own partner.
            let pair = [first, (first + 1).min(channels - 1)];
            let a = pair.map(|c| &channel(c)[..count]);
            let mut job = 0;
            while job < jobs {
                let from = |g: usize| {
                    let (b, v) = ((job + g) / vectors, (job + g) % vectors);
                    &channel(b)[v * S::F64_LANES..][..count + S::F64_LANES - 1]
                };
                let mut put = |g: usize, sum: [S::f64s; 2]| {
                    let (b, v) = ((job + g) / vectors, (job + g) % vectors);
                    for (c, s) in pair.iter().zip(sum) {
                        let at = (c * channels + b) * padded(lags) + v * S::F64_LANES;
                        S::as_mut_simd_f64s(&mut self.sums[at..at + S::F64_LANES]).0[0] = s;
                    }
                };
                let left = jobs - job;
                if left >= GROUP {
                    accumulate::<S, GROUP>(simd, a, std::array::from_fn(from), &mut put);
                    job += GROUP;
                } else {
                    accumulate::<S, 1>(simd, a, [from(0)], &mut put);
                    job += 1;
                }
            }
        }
    }
}

/// Sums of both channels `a` with each of the `b`, whose lags lie side by side.
#[inline(always)]
fn accumulate<S: Simd, const G: usize>(
    simd: S,
    a: [&[f64]; 2],
    b: [&[f64]; G],
    put: &mut impl FnMut(usize, [S::f64s; 2]),
) {
    let zero = simd.splat_f64s(0.0);
    let mut sums = [[zero; 2]; G];
    for (t, (&a0, &a1)) in a[0].iter().zip(a[1]).enumerate() {
        let (a0, a1) = (simd.splat_f64s(a0), simd.splat_f64s(a1));
        for g in 0..G {
            let x = S::as_simd_f64s(&b[g][t..t + S::F64_LANES]).0[0];
            sums[g] =
                [simd.mul_add_e_f64s(a0, x, sums[g][0]), simd.mul_add_e_f64s(a1, x, sums[g][1])];
        }
    }
    for (g, sum) in sums.into_iter().enumerate() {
        put(g, sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_definition() {
        for (channels, lags, count) in [(1, 1, 1), (2, 30, 257), (3, 7, 64), (5, 17, 100)] {
            let stride = count + padded(lags) + 3;
            let sample = |k: usize| ((k * 7919) % 1013) as f64 / 500.0 - 1.0;
            let samples: Vec<f64> = (0..channels * stride).map(sample).collect();
            let block = Block { samples: &samples, stride, channels, count, lags };
            let mut sums = vec![f64::NAN; channels * channels * padded(lags)];
            lag_sums(&block, &mut sums);
            for a in 0..channels {
                for b in 0..channels {
                    for k in 0..lags {
                        let x = &samples[a * stride..];
                        let y = &samples[b * stride..];
                        let expected: f64 = (0..count).map(|t| x[t] * y[t + k]).sum();
                        let got = sums[(a * channels + b) * padded(lags) + k];
                        assert!((got - expected).abs() < 1e-12 * count as f64, "{a} {b} {k}");
                    }
                }
            }
        }
    }
}
