//! Where in frequency the log is informative: excitation by bands, and persistency of excitation. A
//! band's gain has the standard error `σ² = Σ S_u S_v / (Σ S_u)² · κ/(2 n_d)` with noise of density
//! S_v, κ, up to 1.94, for the neighbouring frequencies that von Hann's window [couples](coupling).

use crate::linalg::dense::svd;
use crate::validation::response::modelled::{INFORMATIVE, Modelled, rounded};
use crate::validation::response::spectra::Spectra;
use faer::Mat;
use steerwright_formats::{ExcitationBand, Information, Persistence};

/// Ends of the bands, Hz.
pub(crate) const ENDS: [f64; 7] = [0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];
/// The largest relative error of a gain that counts as determined.
const KNOWN: f64 = 0.2;

/// By how much the mean of neighbouring cross densities scatters more than of independent ones: von
/// Hann's window correlates them by (2/3)² and (1/6)².
pub(crate) fn coupling(frequencies: usize) -> f64 {
    let n = frequencies.max(1) as f64;
    let apart = |k: f64, correlation: f64| (1.0 - k / n).max(0.0) * correlation * correlation;
    1.0 + 2.0 * (apart(1.0, 2.0 / 3.0) + apart(2.0, 1.0 / 6.0))
}

/// Whether a frequency belongs to the band between two ends, of which the lower is its.
pub(crate) fn inside(ends: &[f64], frequency_hz: f64) -> bool {
    let f = frequency_hz * (1.0 + 1e-9);
    f > ends[0] && f <= ends[1]
}

pub(crate) fn bands(spectra: &Spectra, modelled: &Modelled<'_>) -> Vec<ExcitationBand> {
    let resolution = spectra.resolution_hz();
    let sample_time_s = 1.0 / (2.0 * resolution * spectra.len().max(1) as f64);
    ENDS.windows(2)
        .filter_map(|ends| {
            let bins: Vec<usize> =
                (0..spectra.len()).filter(|k| inside(ends, spectra.frequency_hz[*k])).collect();
            let sum = |f: &dyn Fn(usize) -> f64| bins.iter().map(|k| f(*k)).sum::<f64>();
            let input = sum(&|k| spectra.input[k]);
            let output = sum(&|k| spectra.output[k]);
            if bins.is_empty() {
                return None;
            }
            let noise = sum(&|k| spectra.noise(k));
            let explained = if output > 0.0 { 1.0 - noise / output } else { 0.0 };
            let variance = sum(&|k| spectra.input[k] * spectra.noise(k)) / (input * input)
                * coupling(bins.len())
                / (2.0 * spectra.averages.max(1.0));
            let model_power = sum(&|k| {
                let (re, im) = modelled.response(spectra.frequency_hz[k], sample_time_s);
                spectra.input[k] * (re * re + im * im)
            });
            // What noise alone would show as coherent is no gain.
            let chance = noise / spectra.averages.max(1.0);
            let gain = ((output - noise - chance) / input).max(model_power / input).max(0.0);
            let relative_error = (variance / gain).sqrt();
            let relative_error =
                if relative_error.is_finite() { relative_error.min(1e3) } else { 1e3 };
            let significant = explained > spectra.significance(0.01);
            let information = if explained >= INFORMATIVE && relative_error <= KNOWN {
                Information::Good
            } else if significant && relative_error <= 1.0 {
                Information::Weak
            } else {
                Information::None
            };
            Some(ExcitationBand {
                from_hz: ends[0],
                to_hz: ends[1],
                road_wheel_std_rad: rounded(
                    modelled.to_road_wheel * (input * resolution).max(0.0).sqrt(),
                ),
                yaw_rate_std_radps: rounded((output * resolution).max(0.0).sqrt()),
                coherence: rounded(explained.clamp(0.0, 1.0)),
                relative_error: rounded(relative_error),
                information,
            })
        })
        .collect()
}

/// Largest order tried.
const ORDERS: usize = 50;
/// Singular values of the input's Hankel matrix below this share of the largest are rounding.
const ROUNDING: f64 = 1e-6;

/// Order of persistent excitation: the rank of the input's Hankel matrix (Ljung 1999, definition
/// 13.2). Its Gram matrix is updated along the diagonals.
pub(crate) fn persistence(input: &[&[f64]]) -> Persistence {
    let count: usize = input.iter().map(|s| s.len()).sum();
    let mean = input.iter().flat_map(|s| s.iter()).sum::<f64>() / count.max(1) as f64;
    let tried = ORDERS.min(input.iter().map(|s| s.len()).max().unwrap_or(0) / 4);
    let mut gram = Mat::<f64>::zeros(tried, tried);
    for segment in input {
        if segment.len() <= tried {
            continue;
        }
        let u: Vec<f64> = segment.iter().map(|v| v - mean).collect();
        let columns = u.len() - tried + 1;
        for lag in 0..tried {
            let mut g: f64 = u[..columns].iter().zip(&u[lag..]).map(|(a, b)| a * b).sum();
            for i in 0..tried - lag {
                gram[(i, i + lag)] += g;
                if lag > 0 {
                    gram[(i + lag, i)] += g;
                }
                if i + lag + 1 < tried {
                    g += u[i + columns] * u[i + lag + columns] - u[i] * u[i + lag];
                }
            }
        }
    }
    let order = svd(gram.as_ref()).map_or(0, |f| {
        let least = ROUNDING * ROUNDING * f.s.first().copied().unwrap_or(0.0);
        f.s.iter().filter(|s| **s > least && **s > 0.0).count()
    });
    Persistence { order, tried }
}
