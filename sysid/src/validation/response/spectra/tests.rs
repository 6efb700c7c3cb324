//! Spectra against their definitions.

use super::*;
use crate::validation::residuals::correlation::tests::noise;

fn near(got: f64, expected: f64) {
    assert!((got - expected).abs() <= 1e-9 * expected.abs() + 1e-13, "{got:e} {expected:e}");
}

/// Printed by SciPy 1.17.1:
/// ```python
/// import numpy as np; from scipy import signal
/// k = np.arange(1200); f = lambda k: np.sin(.001*k*k) + .5*np.cos(.3*k)
/// u = f(k); y = u + .5*f(k-2) + .2*np.cos(.0037*k*k) + 3
/// o = dict(fs=25, window='hann', nperseg=256, noverlap=128, detrend='constant')
/// for a in (signal.welch(u, **o), signal.welch(y, **o), signal.csd(u, y, **o),
///           signal.coherence(u, y, **o)): print(repr(a[0][[1,12,40,128]]), repr(a[1][[1,12,40,128]]))
/// ```
#[test]
fn spectra_are_those_of_scipy() {
    let f = |k: f64| (0.001 * k * k).sin() + 0.5 * (0.3 * k).cos();
    let k: Vec<f64> = (0..1200).map(f64::from).collect();
    let u: Vec<f64> = k.iter().map(|k| f(*k)).collect();
    let y: Vec<f64> =
        k.iter().map(|k| f(*k) + 0.5 * f(k - 2.0) + 0.2 * (0.0037 * k * k).cos() + 3.0).collect();
    let s = Spectra::welch(&[(&u, &y)], 0.04);
    assert_eq!((s.len(), s.windows), (128, 8));
    let frequency = [0.097_656_25, 1.171_875, 3.906_25];
    let input = [6.646_628_456_158_351e-3, 8.136_788_713_824_805e-1, 7.195_445_206_938_066e-2];
    let output = [1.799_382_159_613_037e-2, 1.735_516_459_418_689, 6.443_647_133_913_034e-2];
    let cross = [
        (1.030_784_085_905_662e-2, -5.312_577_148_399_713e-5),
        (1.164_960_508_434_825, -2.328_697_960_386_887e-1),
        (5.805_949_577_322_397e-2, -3.358_174_335_518_337e-2),
    ];
    let coherence = [8.884_277_863_116_303e-1, 9.994_393_342_617_816e-1, 9.702_679_348_198_384e-1];
    for (i, k) in [0, 11, 39].into_iter().enumerate() {
        near(s.frequency_hz[k], frequency[i]);
        near(s.input[k], input[i]);
        near(s.output[k], output[i]);
        near(s.cross[k].0, cross[i].0);
        near(s.cross[k].1, cross[i].1);
        near(s.coherence(k), coherence[i]);
    }
    near(s.frequency_hz[127], 12.5);
    near(s.output[127], 1.140_712_587_795_038e-3);
}

/// Bounds hold as often as stated, over many seeds and frequencies: the response of y(t) = u(t) +
/// u(t−1) + e(t), its coherence, and that of unrelated signals.
#[test]
fn bands_hold_as_often_as_stated() {
    let mut state = 1;
    let [mut all, mut inside, mut covered, mut alarms] = [0.0; 4];
    for _ in 0..60 {
        let u: Vec<f64> = (0..2001).map(|_| noise(&mut state)).collect();
        let v: Vec<f64> = (0..2000).map(|_| noise(&mut state)).collect();
        let y: Vec<f64> = (0..2000).map(|t| u[t + 1] + u[t] + v[t]).collect();
        let s = Spectra::welch(&[(&u[1..], &y)], 0.04);
        let unrelated = Spectra::welch(&[(&u[1..], &v)], 0.04);
        for k in 0..100 {
            let omega = PI * (k + 1) as f64 / s.len() as f64;
            let truth = (1.0 + omega.cos(), -omega.sin());
            let power = truth.0 * truth.0 + truth.1 * truth.1;
            let got = s.response(k);
            let apart = (got.0 - truth.0).hypot(got.1 - truth.1);
            let (low, high) = s.coherence_bounds(k, 1.96);
            all += 1.0;
            inside += f64::from(u8::from(apart <= s.radius(k, 0.05)));
            covered += f64::from(u8::from((low..=high).contains(&(power / (power + 1.0)))));
            alarms += f64::from(u8::from(unrelated.coherence(k) > unrelated.significance(0.01)));
        }
    }
    let [inside, covered, alarms] = [inside / all, covered / all, alarms / all];
    println!("response {inside:.4}, coherence {covered:.4}, false alarms {alarms:.4}");
    assert!((inside - 0.95).abs() < 0.015, "{inside}");
    assert!((covered - 0.95).abs() < 0.015, "{covered}");
    assert!((0.005..0.016).contains(&alarms), "{alarms}");
}

/// The gain's scatter over seeds is its standard error, with several segments as with one.
#[test]
fn standard_errors_are_the_scatter() {
    for parts in [1, 5] {
        let mut state = 5;
        let (mut squares, mut predicted, mut count) = (0.0, 0.0, 0.0);
        for _ in 0..40 {
            let u: Vec<f64> = (0..3000).map(|_| noise(&mut state)).collect();
            let y: Vec<f64> = u.iter().map(|u| u + 0.5 * noise(&mut state)).collect();
            let length = u.len() / parts;
            let segments: Vec<_> = u.chunks(length).zip(y.chunks(length)).collect();
            let s = Spectra::welch(&segments, 0.04);
            for k in 2..100 {
                let (re, im) = s.response(k);
                squares += (re.hypot(im) - 1.0).powi(2);
                predicted += s.noise_to_input(k) / (2.0 * s.averages.max(1.0));
                count += 1.0;
            }
        }
        let ratio = (squares / predicted).sqrt();
        println!("{parts} segments: scatter {:.4}, ratio {ratio:.3}", f64::sqrt(squares / count));
        assert!((0.92..1.08).contains(&ratio), "{ratio}");
    }
}

/// In pieces of any length, merged and through numbers, as in one.
#[test]
fn pieces_return_what_the_whole_returns() {
    let mut state = 9;
    let u: Vec<f64> = (0..3000).map(|_| noise(&mut state)).collect();
    let y: Vec<f64> = (0..3000).map(|_| noise(&mut state)).collect();
    let whole = Spectra::welch(&[(&u[..2000], &y[..2000]), (&u[2000..], &y[2000..])], 0.04);
    let mut parts = [2000, 1000].map(|_| Sums::of_sample_time(0.04));
    for (part, range) in parts.iter_mut().zip([0..2000, 2000..3000]) {
        for (u, y) in u[range.clone()].chunks(37).zip(y[range].chunks(37)) {
            part.push(u, y);
        }
        part.end_segment();
    }
    let [mut first, second] = parts;
    first.merge(&Sums::from_numbers(&second.to_numbers()).unwrap_or_else(|| Sums::new(2)));
    assert_eq!(first.length(), 256);
    let got = first.spectra(0.04);
    assert_eq!((got.windows, got.averages), (whole.windows, whole.averages));
    for k in 0..got.len() {
        near(got.output[k], whole.output[k]);
        near(got.cross[k].1, whole.cross[k].1);
    }
    let mut wrong = second.to_numbers();
    wrong[2] = -1.0;
    assert!(Sums::from_numbers(&wrong).is_none() && Sums::from_numbers(&[1.0]).is_none());
}

#[test]
fn no_window_straddles_two_segments() {
    let mut state = 3;
    let u: Vec<f64> = (0..1200).map(|_| noise(&mut state)).collect();
    let y: Vec<f64> = u.iter().map(|u| 2.0 * u).collect();
    // A jump between the two would be seen at every frequency.
    let high: Vec<f64> = y[600..].iter().map(|y| y + 1e3).collect();
    let s = Spectra::welch(&[(&u[..600], &y[..600]), (&u[600..], &high)], 0.04);
    for k in 0..s.len() {
        assert!((s.response(k).0 - 2.0).abs() < 1e-9 && s.response(k).1.abs() < 1e-9);
        assert!(s.coherence(k) > 1.0 - 1e-9);
    }
}

#[test]
fn little_or_no_data_lead_to_no_nonsense() {
    for n in [0, 1, 2, 3, 10, 40] {
        let u: Vec<f64> = (0..n).map(|k| f64::from(k % 3)).collect();
        let s = Spectra::welch(&[(&u, &vec![1.0; u.len()])], 0.04);
        for k in 0..s.len() {
            assert_eq!(s.coherence(k), 0.0);
            assert!(s.response(k).0.is_finite() && !s.significance(0.01).is_nan());
        }
    }
}
