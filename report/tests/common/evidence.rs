//! The evidence of an identified plant.

use super::noise;
use steerwright_formats::*;

pub fn evidence() -> Evidence {
    let row = |order, singular_value, estimation_fit, validation_fit, stable| OrderRow {
        order,
        singular_value: Some(singular_value),
        estimation_fit,
        validation_fit,
        stable,
        criterion: 0.0,
    };
    let channel = |role: &str, column: &str, unit: &str, min, mean, max| ChannelSummary {
        role: role.into(),
        column: column.into(),
        unit: unit.into(),
        rows: 30_000,
        rate_hz: 100.0,
        min,
        mean,
        max,
        ..ChannelSummary::default()
    };
    Evidence {
        method: "n4sid".into(),
        horizon: 20,
        factor: Some(DataFactor {
            method: FactorMethod::Gram,
            condition: Some(3.2e3),
            input_condition: Some(1.7e2),
            asked_horizon: 30,
            horizon: 20,
        }),
        delay: Some(DelayEstimate {
            estimate_s: 0.052,
            standard_error_s: Some(0.011),
            lag_without_s: 0.06,
            evidence: 31.0,
            taken: true,
        }),
        estimation_samples: 3000,
        validation_samples: 3000,
        fit: Fits { estimation: 81.2, validation: 77.9, validation_one_step: 95.4 },
        order_table: vec![
            row(1, 31.0, 60.1, 57.2, true),
            row(2, 9.2, 81.2, 77.9, true),
            row(3, 0.81, 81.5, 77.3, true),
            row(4, 0.52, 81.9, -3e5, false),
            row(5, 0.44, 82.0, 76.1, true),
            row(6, 0.40, 82.1, 71.0, true),
            row(7, 0.36, 82.2, 72.4, false),
            row(8, 0.35, 82.2, 70.8, true),
        ],
        feedback: Some(ResidualTest { lags: 25, statistic: 19.3, bound: 44.3, pass: true }),
        whiteness: ResidualTest { lags: 25, statistic: 61.0, bound: 44.3, pass: false },
        independence: ResidualTest { lags: 25, statistic: 30.2, bound: 44.3, pass: true },
        excitation: Excitation {
            road_wheel_std_rad: 0.05,
            yaw_rate_std_radps: 0.17,
            noise_to_signal: 0.04,
            informative_up_to_hz: 1.7,
            coherence: (1..200)
                .map(|k| {
                    let frequency_hz = 0.05 * f64::from(k);
                    let ripple = 0.03 * (f64::from(k) * 1.7).sin();
                    let coherence = (0.96 / (1.0 + (frequency_hz / 1.8).powi(4)) + ripple).abs();
                    CoherencePoint { frequency_hz, coherence: coherence.min(1.0) }
                })
                .collect(),
            bands: bands(),
            persistence: Some(Persistence { order: 50, tried: 50 }),
            ..Excitation::default()
        },
        held_out: Some(held_out()),
        residuals: Some(residuals()),
        frequency_response: Some(frequency_response()),
        poles_and_zeros: Some(poles_and_zeros()),
        stabilised_from: Some(1.0004),
        conversion_round_trip: Some(3.1e-15),
        channels: vec![
            channel("steering", "roadWheelAngle", "deg", -0.2, 0.001, 0.31),
            channel("yaw_rate", "yawRate <script>", "deg/s", -0.9, 0.02, 0.84),
            channel("speed", "vxCG", "m/s", 16.1, 38.2, 61.0),
        ],
        warnings: vec!["the speed varies from 16.1 to 61.0 m/s: a linear model averages it".into()],
        ..Evidence::default()
    }
}

fn bands() -> Vec<ExcitationBand> {
    let band = |from_hz, to_hz, coherence, relative_error, information| ExcitationBand {
        from_hz,
        to_hz,
        road_wheel_std_rad: 0.02,
        yaw_rate_std_radps: 0.06,
        coherence,
        relative_error,
        information,
    };
    vec![
        band(0.0, 0.5, 0.96, 0.013, Information::Good),
        band(0.5, 2.0, 0.6, 0.11, Information::Weak),
        band(2.0, 10.0, 0.02, 1e3, Information::None),
    ]
}

fn held_out() -> HeldOut {
    let row = |steps: Option<usize>, fit: f64| PredictionFit {
        steps,
        ahead_s: steps.map(|k| 0.05 * k as f64),
        fit,
        variance_accounted_for: 100.0 - (100.0 - fit).powi(2) / 100.0,
    };
    HeldOut {
        fit_standard_error: Some(1.3),
        blocks: 25,
        variance_accounted_for: 95.1,
        selection: "end".into(),
        fit_bound: Some(95.4),
        predictions: vec![
            row(Some(1), 95.4),
            row(Some(2), 92.0),
            row(Some(10), 83.0),
            row(Some(20), 78.2),
            row(None, 77.9),
        ],
        ..HeldOut::default()
    }
}

fn residuals() -> ResidualCorrelation {
    let mut seed = 9;
    let mut some = |count| (0..count).map(|_| 0.06 * noise(&mut seed)).collect::<Vec<_>>();
    let (mut autocorrelation, with_input) = (some(25), some(51));
    autocorrelation[0] = 0.31;
    ResidualCorrelation {
        autocorrelation,
        autocorrelation_bound: 0.047,
        with_input,
        with_input_bound: 0.055,
        feedback: ResidualTest { lags: 25, statistic: 70.0, bound: 44.3, pass: false },
    }
}

fn frequency_response() -> FrequencyResponse {
    let mut seed = 3;
    let points = (1..100)
        .map(|k| {
            let frequency_hz = 0.1 * f64::from(k);
            let coherence = 0.96 / (1.0 + (frequency_hz / 1.8).powi(4));
            let model_gain = 5.2 / (1.0 + (frequency_hz / 1.4).powi(2)).sqrt();
            let radius = model_gain * (0.1 * (1.0 - coherence) / coherence).sqrt();
            ResponsePoint {
                frequency_hz,
                gain: (model_gain + 0.5 * radius * noise(&mut seed)).abs(),
                phase_rad: -(frequency_hz / 1.4).atan() - 0.3 * frequency_hz,
                radius,
                coherence,
                coherence_low: (coherence - 0.15 * (1.0 - coherence)).max(0.0),
                coherence_high: (coherence + 0.1 * (1.0 - coherence)).min(1.0),
                model_gain,
                model_phase_rad: -(frequency_hz / 1.3).atan() - 0.3 * frequency_hz,
            }
        })
        .collect();
    FrequencyResponse {
        confidence: 0.95,
        averages: 54.2,
        resolution_hz: 0.1,
        significant_coherence: 0.083,
        compared: 17,
        within: 16.0 / 17.0,
        bands: vec![departure(0.2, 0.5, 0.99, 1.0), departure(0.5, 1.0, 1.31, -14.0)],
        points,
    }
}

fn departure(from_hz: f64, to_hz: f64, gain_ratio: f64, degrees: f64) -> BandDeparture {
    let phase_ahead_rad = f64::to_radians(degrees);
    BandDeparture {
        from_hz,
        to_hz,
        gain_ratio,
        phase_ahead_rad,
        standard_error: 0.01,
        departure: ((gain_ratio - 1.0).hypot(phase_ahead_rad) - 0.02).max(0.0),
    }
}

fn poles_and_zeros() -> PoleZeroMap {
    let mode = |re: f64, im: f64| {
        let (a, b) = (re.hypot(im).ln() / 0.05, im.atan2(re) / 0.05);
        Mode {
            discrete: [re, im],
            spread: Some(Spread {
                variance_re: 1e-3,
                variance_im: if im == 0.0 { 0.0 } else { 4e-4 },
                covariance: if im == 0.0 { 0.0 } else { 4e-4 },
            }),
            continuous: Some([a, b]),
            natural_frequency_hz: Some(a.hypot(b) / std::f64::consts::TAU),
            damping: Some(-a / a.hypot(b)),
            time_constant_s: Some(-1.0 / a),
        }
    };
    PoleZeroMap {
        poles: vec![mode(0.75, 0.09), mode(0.4, 0.0)],
        zeros: vec![mode(0.3, 0.0), mode(-3.2, 0.0)],
        continuous_zeros: vec![[-9.0, 0.0], [-400.0, 0.0]],
        continuous_zero_spreads: vec![
            Spread { variance_re: 2.0, variance_im: 0.0, covariance: 0.0 },
            Spread { variance_re: 1e5, variance_im: 0.0, covariance: 0.0 },
        ],
    }
}
