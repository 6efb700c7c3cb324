//! The model error against the measured response, band by band: `ρ = Σ S_u G* Ĝ / Σ S_u |G|²`
//! (docs/methods/validation.md) brings the model's response G to the measured Ĝ. Its real and
//! imaginary part scatter, with noise of density S_v, by `σ² = Σ S_u |G|² S_v / (Σ S_u |G|²)² ·
//! κ/(2 n_d)` each (as in [`crate::validation::response::bands`]).
//!
//! A controller that stabilises the model stabilises every plant within a relative model error of
//! 1/|T| (Skogestad and Postlethwaite 2005, section 7.5); |T| is at most about 1.3 in a loop with
//! little overshoot, and below half of that share its margins remain ones.

use crate::validation::response::bands::{ENDS, coupling, inside};
use crate::validation::response::modelled::{INFORMATIVE, Modelled, rounded};
use crate::validation::response::spectra::Spectra;
use steerwright_formats::BandDeparture;

/// Model errors in the bands in which steering explains most of the yaw rate.
pub(crate) fn band_errors(
    spectra: &Spectra,
    modelled: &Modelled<'_>,
    measured: &[(f64, f64)],
    sample_time_s: f64,
) -> Vec<BandDeparture> {
    ENDS.windows(2)
        .filter_map(|ends| {
            let (mut factor, mut power, mut scatter) = ((0.0, 0.0), 0.0, 0.0);
            let (mut noise, mut output, mut count) = (0.0, 0.0, 0);
            for k in (0..measured.len()).filter(|k| inside(ends, spectra.frequency_hz[*k])) {
                let model = modelled.response(spectra.frequency_hz[k], sample_time_s);
                let (u, v) = (spectra.input[k], spectra.noise(k));
                let size = model.0 * model.0 + model.1 * model.1;
                factor.0 += u * (model.0 * measured[k].0 + model.1 * measured[k].1);
                factor.1 += u * (model.0 * measured[k].1 - model.1 * measured[k].0);
                power += u * size;
                scatter += u * size * v;
                noise += v;
                output += spectra.output[k];
                count += 1;
            }
            let significant = spectra.significance(0.01).max(INFORMATIVE);
            if !(power > 0.0 && noise < (1.0 - significant) * output) {
                return None;
            }
            let (re, im) = (factor.0 / power, factor.1 / power);
            let size = re.hypot(im);
            let coupled = coupling(count) / (2.0 * spectra.averages.max(1.0));
            let standard_error = (scatter * coupled).sqrt() / (power * size);
            // |G − Ĝ|/|Ĝ| = |1 − ρ|/|ρ|.
            let apart = (1.0 - re).hypot(im) / size;
            if apart.is_finite() && standard_error.is_finite() {
                Some(BandDeparture {
                    from_hz: ends[0],
                    to_hz: ends[1],
                    gain_ratio: rounded(1.0 / size),
                    phase_ahead_rad: rounded(-im.atan2(re)),
                    standard_error: rounded(standard_error),
                    departure: rounded((apart - 2.0 * standard_error).max(0.0)),
                })
            } else {
                None
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::StateSpace;
    use crate::validation::residuals::correlation::tests::noise;
    use crate::validation::response::bands::bands;
    use faer::Mat;

    fn row(values: &[f64]) -> Mat<f64> {
        Mat::from_fn(1, values.len(), |_, j| values[j])
    }

    const TS: f64 = 0.04;

    fn unit() -> StateSpace {
        StateSpace { a: row(&[0.0]), b: row(&[0.0]), c: row(&[0.0]), d: row(&[1.0]) }
    }

    fn modelled<'a>(model: &'a StateSpace, delay_s: f64) -> Modelled<'a> {
        Modelled { model, delay_s, input: &[], simulated: &[], to_road_wheel: 1.0 }
    }

    fn measured(s: &Spectra) -> Vec<(f64, f64)> {
        (0..s.len()).map(|k| s.response(k)).collect()
    }

    /// Half the gain and 0.04 s late: the model y = u has twice the gain and is ahead; with the delay
    /// of 0.08 s it is behind by as much.
    #[test]
    fn gain_and_phase_are_the_models_against_the_measured() {
        let state = &mut 3;
        let u: Vec<f64> = (0..6000).map(|_| noise(state)).collect();
        let y: Vec<f64> = (0..6000).map(|t| if t > 0 { 0.5 * u[t - 1] } else { 0.0 }).collect();
        let s = Spectra::welch(&[(&u, &y)], TS);
        let model = unit();
        for (delay, sign) in [(0.0, 1.0), (2.0 * TS, -1.0)] {
            let all = band_errors(&s, &modelled(&model, delay), &measured(&s), TS);
            let band = all.iter().find(|b| b.from_hz == 1.0).unwrap();
            let lead = std::f64::consts::TAU * 1.5 * TS;
            assert!((band.gain_ratio - 2.0).abs() < 0.06, "{band:?}");
            assert!((band.phase_ahead_rad - sign * lead).abs() < 0.06, "{band:?}");
            // |2 e^{jφ} − 1|, little of it chance.
            let apart = (2.0 * lead.cos() - 1.0).hypot(2.0 * lead.sin());
            assert!((band.departure - apart).abs() < 0.1, "{band:?}");
        }
    }

    /// The stated errors, of the model error and of the band's gain, are the scatter over seeds.
    #[test]
    fn standard_errors_of_a_band_are_the_scatter() {
        const SEEDS: u64 = 150;
        let model = unit();
        let [mut gain, mut phase, mut stated, mut known, mut none] = [0.0; 5];
        for seed in 0..SEEDS {
            let state = &mut (100 + seed);
            let u: Vec<f64> = (0..1500).map(|_| noise(state)).collect();
            let y: Vec<f64> = u.iter().map(|u| u + 0.5 * noise(state)).collect();
            let s = Spectra::welch(&[(&u, &y)], TS);
            let m = modelled(&model, 0.0);
            let all = band_errors(&s, &m, &measured(&s), TS);
            let band = all.iter().find(|b| b.from_hz == 1.0).unwrap();
            gain += (band.gain_ratio - 1.0).powi(2);
            phase += band.phase_ahead_rad.powi(2);
            stated += band.standard_error.powi(2);
            none += f64::from(u8::from(band.departure == 0.0)) / SEEDS as f64;
            let of_gain = bands(&s, &m).into_iter().find(|b| b.from_hz == 1.0).unwrap();
            known += of_gain.relative_error.powi(2);
        }
        let ratio = |of: f64| (of / stated).sqrt();
        let ratios = [gain, phase, known].map(ratio);
        println!("gain, phase, band's gain over stated: {ratios:?}");
        assert!(ratios.iter().all(|r| (0.8..1.25).contains(r)), "{ratios:?}");
        // A complex number within two standard errors of each part: 1 − e⁻².
        assert!((0.77..0.95).contains(&none), "{none}");
    }

    #[test]
    fn a_frequency_at_an_end_belongs_to_the_band_above() {
        assert!(inside(&[0.5, 1.0], 0.5) && !inside(&[0.5, 1.0], 1.0));
        assert!(inside(&[0.0, 0.2], 0.1) && !inside(&[0.0, 0.2], 0.3));
    }
}
