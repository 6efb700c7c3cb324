//! How certain a fit is: the block jackknife over segments of time, `se² = (B − 1)/B · Σ_b (θ_b −
//! θ̄)²` (Efron and Tibshirani 1993, chapter 11; Künsch 1989 for blocks of dependent data).

use steerwright_formats::{BLOCK_S, LEAST_BLOCKS};

/// A fit and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FitWithError {
    pub(crate) fit: f64,
    /// Standard error, percentage points; `None` where there are too few blocks.
    pub(crate) standard_error: Option<f64>,
    pub(crate) blocks: usize,
}

/// Least samples in a block.
const LEAST_SAMPLES: usize = 20;
const MOST_BLOCKS: usize = 30;

/// Fit of segments of (y, ŷ) with the standard error from blocks of [`BLOCK_S`] or longer.
pub(crate) fn fit_with_error(segments: &[(&[f64], &[f64])], sample_time_s: f64) -> FitWithError {
    let count: usize = segments.iter().map(|(y, _)| y.len()).sum();
    let mean = segments.iter().flat_map(|(y, _)| y.iter()).sum::<f64>() / count.max(1) as f64;
    let least = ((BLOCK_S / sample_time_s).ceil() as usize).max(LEAST_SAMPLES);
    let length = least.max(count.div_ceil(MOST_BLOCKS));
    let mut sums: Vec<[f64; 2]> = Vec::new();
    for (y, y_hat) in segments {
        // Blocks of nearly equal length: a few samples less make no other number of them.
        let blocks = ((y.len() as f64 / length as f64).round() as usize).max(1);
        for b in 0..blocks {
            let range = b * y.len() / blocks..(b + 1) * y.len() / blocks;
            let mut sum = [0.0; 2];
            for (y, y_hat) in y[range.clone()].iter().zip(&y_hat[range]) {
                sum[0] += (y - y_hat) * (y - y_hat);
                sum[1] += (y - mean) * (y - mean);
            }
            sums.push(sum);
        }
    }
    let total = sums.iter().fold([0.0; 2], |t, s| [t[0] + s[0], t[1] + s[1]]);
    let fit = |[error, spread]: [f64; 2]| 100.0 * (1.0 - (error.max(0.0) / spread).sqrt());
    let blocks = sums.len();
    let all = if total[0].is_finite() && total[1] > 0.0 { fit(total) } else { f64::NEG_INFINITY };
    let mut out = FitWithError { fit: all, standard_error: None, blocks };
    if blocks < LEAST_BLOCKS || !all.is_finite() {
        return out;
    }
    let without: Vec<f64> = sums.iter().map(|s| fit([total[0] - s[0], total[1] - s[1]])).collect();
    let middle = without.iter().sum::<f64>() / blocks as f64;
    let scatter: f64 = without.iter().map(|f| (f - middle) * (f - middle)).sum();
    let standard_error = (scatter * (blocks - 1) as f64 / blocks as f64).sqrt();
    out.standard_error = if standard_error.is_finite() { Some(standard_error) } else { None };
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::statistics::fit_percent;
    use crate::validation::residuals::correlation::tests::noise;

    /// Over seeds, the scatter of the fit is its standard error, with errors that correlate over half a
    /// second and a signal that does over two, in one segment as in several.
    #[test]
    fn the_standard_error_is_the_scatter() {
        for segment in [4000, 900] {
            let (mut fits, mut errors) = (Vec::new(), 0.0);
            for seed in 0..150_u64 {
                let state = &mut (seed + 1);
                let (mut y, mut y_hat, mut slow, mut error) = (vec![], vec![], 0.0, 0.0);
                for _ in 0..4000 {
                    slow = 0.98 * slow + noise(state);
                    error = 0.92 * error + 0.8 * noise(state);
                    y.push(slow + error);
                    y_hat.push(slow);
                }
                let pairs: Vec<_> = y.chunks(segment).zip(y_hat.chunks(segment)).collect();
                let got = fit_with_error(&pairs, 0.04);
                assert!((got.fit - fit_percent(&y, &y_hat)).abs() < 1e-9);
                fits.push(got.fit);
                errors += got.standard_error.unwrap().powi(2) / 150.0;
            }
            let (scatter, stated) =
                (steerwright_drivelog::signal::standard_deviation(&fits), errors.sqrt());
            println!("segments of {segment}: scatter {scatter:.3}, stated {stated:.3} points");
            assert!((0.75..1.33).contains(&(stated / scatter)), "{stated} {scatter}");
        }
    }

    #[test]
    fn too_little_data_has_no_standard_error() {
        let y: Vec<f64> = (0..200).map(f64::from).collect();
        let got = fit_with_error(&[(&y, &y)], 0.04);
        assert_eq!((got.fit, got.standard_error), (100.0, None));
        assert_eq!(fit_with_error(&[], 0.04).fit, f64::NEG_INFINITY);
        assert_eq!(fit_with_error(&[(&[1.0; 500], &[1.0; 500])], 0.04).standard_error, None);
    }
}
