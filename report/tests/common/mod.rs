//! Made-up but plausible content of the files of the other stages.
#![allow(dead_code, missing_docs, unreachable_pub)]

use formats::*;
use report::{StepResponse, Traces, Track};

/// A small repeatable noise in −1…1 (a linear congruential generator).
pub fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 33) as f64 / f64::from(1u32 << 30) - 1.0
}

pub fn traces(samples: usize) -> Traces {
    let mut t = Traces::default();
    let (mut seed, mut r, mut yaw, mut simulated_yaw) = (7, 0.0, 0.0, 0.0);
    let dt = 300.0 / samples as f64;
    for k in 0..samples {
        let time = k as f64 * dt;
        let steering = 0.06 * (0.21 * time).sin() + 0.04 * (0.83 * time + 1.0).sin().powi(3);
        r += dt / 0.25 * (3.2 * steering - r);
        let measured = r + 0.012 * noise(&mut seed) + 0.02 * (0.3 * time).cos();
        yaw += dt * measured;
        simulated_yaw += dt * r;
        t.time_s.push(time);
        t.steering_rad.push(steering);
        t.yaw_rate_radps.push(measured);
        t.simulated_yaw_rate_radps.push(r);
        t.held_out.push(k >= samples / 2);
        t.yaw_rad.push(yaw);
        t.simulated_yaw_rad.push(simulated_yaw);
    }
    t.bicycle_yaw_rate_radps = Some(t.simulated_yaw_rate_radps.iter().map(|r| 1.25 * r).collect());
    t
}

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
        verdict: Verdict {
            trustworthy: true,
            summary: "The model explains the held-out half well up to 1.7 Hz.".into(),
            advice: vec!["Drive at one speed to sharpen the model.".into()],
        },
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
        predictions: vec![
            row(Some(1), 95.4),
            row(Some(2), 92.0),
            row(Some(10), 83.0),
            row(Some(20), 78.2),
            row(None, 77.9),
        ],
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

pub fn provenance() -> Provenance {
    Provenance {
        version: "0.1.0".into(),
        sources: vec![SourceFile {
            name: "drive \"<b>& 'one'.csv".into(),
            sha256: sha256_hex(b"drive"),
        }],
        options: [("order".to_owned(), "auto".to_owned()), ("horizon".into(), "20".into())].into(),
    }
}

pub fn plant() -> Plant {
    let m = |rows: &[&[f64]]| Matrix(rows.iter().map(|r| r.to_vec()).collect());
    Plant {
        schema: Plant::SCHEMA.into(),
        name: "250 LM".into(),
        input: InputKind::Steering,
        steering_ratio: 1.0,
        input_delay_s: 0.05,
        operating_point: OperatingPoint {
            speed_mps: 38.2,
            steering_offset_rad: 0.0012,
            yaw_rate_offset_radps: 0.0,
        },
        discrete: Discrete {
            sample_time_s: 0.05,
            a: m(&[&[0.8, 0.1], &[-0.1, 0.7]]),
            b: m(&[&[0.2], &[0.1]]),
            c: m(&[&[1.0, 0.0]]),
            d: m(&[&[0.0]]),
            k: m(&[&[0.1], &[0.0]]),
            x0: vec![0.0, 0.0],
        },
        continuous: None,
        noise: Noise { innovation_variance: 1e-5 },
        uncertainty: None,
        evidence: evidence(),
        provenance: provenance(),
    }
}

pub fn step(factor: f64) -> StepResponse {
    let mut s = StepResponse::default();
    for k in 0..300 {
        let t = f64::from(k) * 0.01;
        let yaw = 1.0 - (-5.5 * t).exp() * ((3.2 * t).cos() + 1.4 * (3.2 * t).sin());
        s.time_s.push(t);
        s.yaw_rad.push(0.0873 * yaw * factor);
        s.steering_rad.push((0.21 * (-6.0 * t).exp() - 0.03 * (-1.5 * t).exp()) * factor);
    }
    s
}

pub fn pid(met: bool) -> Pid {
    let metrics = StepMetrics {
        overshoot_percent: 0.41,
        settling_time_s: Some(0.83),
        steady_state_error_percent: 0.02,
        rise_time_s: Some(0.37),
        largest_angle_rad: 0.18,
        largest_increment_rad: 0.11,
        integral_absolute_error_s: 0.2,
    };
    Pid {
        schema: Pid::SCHEMA.into(),
        name: "PID".into(),
        sample_time_s: 0.01,
        gains: PidGains {
            kp: 1.93,
            ki: 2.2,
            kd: 0.21,
            derivative_filter_time_s: 0.02,
            setpoint_weight_proportional: 0.8,
            setpoint_weight_derivative: 0.0,
            anti_windup_time_s: 0.5,
        },
        limits: Limits { max_angle_rad: 0.384, max_increment_rad: 0.262, max_rate_radps: 10.0 },
        designed_for: DesignedFor {
            model: "plant".into(),
            name: "250 LM".into(),
            sha256: sha256_hex(b"plant"),
            speed_mps: 38.2,
            steering_ratio: 1.0,
            loop_delay_s: 0.0,
            ..DesignedFor::default()
        },
        specification: Specification {
            step_rad: 0.0873,
            steering_offset_rad: 0.0175,
            ..Specification::default()
        },
        evidence: DesignEvidence {
            met,
            shortfalls: if met {
                vec![]
            } else {
                vec![Shortfall { requirement: "settling time".into(), required: 1.0, reached: 1.4 }]
            },
            step: StepMetrics {
                settling_time_s: if met { Some(0.83) } else { Some(1.4) },
                ..metrics
            },
            step_with_offset: StepMetrics { overshoot_percent: 2.4, ..metrics },
            small_step: None,
            margins: Margins {
                gain_margin_db: Some(13.4),
                phase_margin_deg: Some(64.0),
                delay_margin_s: Some(0.21),
                modulus_margin: 0.71,
                crossover_radps: Some(5.3),
                disk_margin: Some(0.9),
            },
            ..DesignEvidence::default()
        },
        guidance: GuidanceAdvice { feedforward_gain_radm: 3.1, preview_time_s: 0.2 },
        provenance: provenance(),
    }
}

pub fn path() -> Path {
    let points = (0..=400)
        .map(|k| {
            let s = f64::from(k) * 0.5;
            PathPoint {
                distance_m: s,
                x_m: s * 0.96,
                y_m: 9.0 * (s / 25.0).sin(),
                heading_rad: (0.36 * (s / 25.0).cos()).atan(),
                curvature_per_m: -0.0144 * (s / 25.0).sin(),
            }
        })
        .collect();
    Path {
        schema: Path::SCHEMA.into(),
        name: "slalom".into(),
        closed: false,
        guidance: Guidance::default(),
        speed_mps: 10.0,
        points,
        provenance: provenance(),
    }
}

pub fn track(error: f64) -> Track {
    let mut t = Track::default();
    for k in 0..2000 {
        let time = f64::from(k) * 0.01;
        let s = 10.0 * time;
        let e = error * (s / 25.0 + 0.4).sin() * (1.0 - (-s / 20.0).exp());
        t.time_s.push(time);
        t.distance_m.push(s);
        t.x_m.push(s * 0.96);
        t.y_m.push(9.0 * (s / 25.0).sin() + e);
        t.cross_track_error_m.push(e);
        t.heading_error_rad.push(0.05 * error * (s / 25.0 + 0.4).cos());
        t.steering_rad.push(-0.05 * (s / 25.0).sin() + 0.02 * e);
    }
    t
}

pub fn bicycle() -> Bicycle {
    Bicycle {
        schema: Bicycle::SCHEMA.into(),
        vehicle: VehicleData {
            name: "sedan".into(),
            mass_kg: 1573.0,
            yaw_inertia_kgm2: 2873.0,
            distance_front_m: 1.1,
            distance_rear_m: 1.58,
            cornering_stiffness_front_npr: 160_000.0,
            cornering_stiffness_rear_npr: 160_000.0,
            actuator_time_constant_s: 0.1,
            steering_ratio: 15.0,
            speed_mps: 20.0,
        },
        coefficients: BicycleCoefficients {
            a1: -203.4,
            a2: 48.8,
            a3: 26.7,
            a4: -206.4,
            b1: 101.7,
            b2: 61.3,
            n: 0.0667,
            tn: 0.1,
        },
        state_matrix: Matrix::from_fn(5, 5, |_, _| 0.0),
        input_matrix: Matrix::from_fn(5, 1, |_, _| 0.0),
        evidence: None,
        provenance: provenance(),
    }
}
