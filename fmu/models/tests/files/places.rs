//! Every number of a file arrives where it belongs.

#![allow(clippy::unwrap_used)]

use steerwright_formats::{
    Guidance, InputKind, LargeErrors, LateralAcceleration, Matrix, Path, PidGains, Plant,
};
use steerwright_models::files::{
    guidance_parameters, identified_model, path_geometry, pid_parameters,
};
use steerwright_models::{Error, GuidanceParameters, PidParameters, Sideslip};

fn plant() -> Plant {
    Plant {
        schema: "steerwright/plant/1".into(),
        name: "drive".into(),
        input: InputKind::SteeringTimesSpeed,
        steering_ratio: 15.0,
        input_delay_s: 0.03,
        operating_point: steerwright_formats::OperatingPoint {
            speed_mps: 12.0,
            steering_offset_rad: 0.02,
            yaw_rate_offset_radps: 0.003,
        },
        discrete: steerwright_formats::Discrete {
            sample_time_s: 0.01,
            a: Matrix(vec![vec![0.9, 0.1], vec![-0.2, 0.8]]),
            b: Matrix(vec![vec![1.0], vec![2.0]]),
            c: Matrix(vec![vec![3.0, 4.0]]),
            d: Matrix(vec![vec![0.5]]),
            k: Matrix(vec![vec![0.6], vec![0.7]]),
            x0: vec![0.0; 2],
        },
        continuous: None,
        noise: steerwright_formats::Noise { innovation_variance: 1e-4 },
        sideslip: None,
        uncertainty: None,
        evidence: steerwright_formats::Evidence::default(),
        quality: steerwright_formats::Quality::default(),
        provenance: steerwright_formats::Provenance::default(),
    }
}

#[test]
fn the_identified_model() {
    let model = identified_model(&plant()).unwrap();
    let data = model.data();
    assert_eq!(data.a, [0.9, 0.1, -0.2, 0.8]);
    assert_eq!(
        (&data.b[..], &data.c[..], &data.k[..]),
        (&[1.0, 2.0][..], &[3.0, 4.0][..], &[0.6, 0.7][..])
    );
    assert_eq!((data.d, data.sample_time, data.delay, data.speed), (0.5, 0.01, 0.03, 12.0));
    assert_eq!((data.steering_offset, data.yaw_rate_offset), (0.02, 0.003));
    assert_eq!(data.input, InputKind::SteeringTimesSpeed);
    assert!((data.innovation_std - 0.01).abs() < 1e-15);
    let continuous = steerwright_formats::Continuous {
        f: Matrix(vec![vec![-1.0, 0.0], vec![0.0, -1.0]]),
        g: Matrix(vec![vec![1.0], vec![2.0]]),
        h: Matrix(vec![vec![3.0, 4.0]]),
    };
    let error = identified_model(&Plant { continuous: Some(continuous), ..plant() }).unwrap_err();
    assert!(matches!(error, Error::Inconsistent { name: "A", .. }), "{error}");
}

#[test]
fn the_controller() {
    let pid = steerwright_formats::Pid {
        schema: "steerwright/pid/1".into(),
        name: "pid".into(),
        sample_time_s: 0.01,
        gains: PidGains {
            kp: 1.0,
            ki: 2.0,
            kd: 3.0,
            derivative_filter_time_s: 4.0,
            setpoint_weight_proportional: 5.0,
            setpoint_weight_derivative: 6.0,
            anti_windup_time_s: 7.0,
        },
        limits: steerwright_formats::Limits {
            max_angle_rad: 8.0,
            max_increment_rad: 9.0,
            max_rate_radps: 10.0,
            large_errors: None,
            lateral_acceleration: None,
        },
        designed_for: steerwright_formats::DesignedFor {
            model: "plant".into(),
            name: "drive".into(),
            sha256: String::new(),
            speed_mps: 15.0,
            steering_ratio: 1.0,
            loop_delay_s: 0.0,
            ..steerwright_formats::DesignedFor::default()
        },
        specification: steerwright_formats::Specification {
            step_rad: 0.1,
            steering_offset_rad: 0.01,
            ..steerwright_formats::Specification::default()
        },
        evidence: steerwright_formats::DesignEvidence {
            met: true,
            shortfalls: Vec::new(),
            step: STEP,
            step_with_offset: STEP,
            small_step: None,
            margins: steerwright_formats::Margins {
                gain_margin_db: None,
                phase_margin_deg: None,
                delay_margin_s: None,
                modulus_margin: 0.7,
                crossover_radps: None,
                disk_margin: Some(0.9),
            },
            ..steerwright_formats::DesignEvidence::default()
        },
        guidance: steerwright_formats::GuidanceAdvice {
            feedforward_gain_radm: 0.0,
            preview_time_s: 0.0,
            yaw_acceleration_gain_s2: 0.0,
            yaw_jerk_gain_s3: 0.0,
        },
        schedule: vec![],
        provenance: steerwright_formats::Provenance::default(),
    };
    let expected = PidParameters {
        gains: pid.gains,
        max_angle: 8.0,
        max_increment: 9.0,
        max_rate: 10.0,
        large_errors: LargeErrors {
            sustained_rate_radps: 10.0,
            ..PidParameters::default().large_errors
        },
        sample_time: 0.01,
        ..PidParameters::default()
    };
    assert_eq!(pid_parameters(&pid), expected);

    let limits = steerwright_formats::Limits {
        large_errors: Some(LargeErrors {
            max_yaw_error_rad: 11.0,
            yaw_rate_lag_s: 17.0,
            sustained_rate_radps: 12.0,
            rate_reserve_time_s: 13.0,
        }),
        lateral_acceleration: Some(LateralAcceleration {
            max_mps2: 14.0,
            steering_per_curvature_radm: 15.0,
            understeer_gradient_rads2pm: 16.0,
        }),
        ..pid.limits
    };
    let expected = PidParameters {
        large_errors: LargeErrors {
            max_yaw_error_rad: 11.0,
            yaw_rate_lag_s: 17.0,
            sustained_rate_radps: 12.0,
            rate_reserve_time_s: 13.0,
        },
        lateral_acceleration: LateralAcceleration {
            max_mps2: 14.0,
            steering_per_curvature_radm: 15.0,
            understeer_gradient_rads2pm: 16.0,
        },
        ..expected
    };
    assert_eq!(pid_parameters(&steerwright_formats::Pid { limits, ..pid }), expected);
}

/// A file from before the limits by speed and error has the one angle, and acts on every error.
#[test]
fn the_controller_of_an_older_file() {
    use steerwright_formats::Document;
    let text = include_str!("../../../lateral-pid/example.json");
    let pid = steerwright_formats::Pid::from_json(text, "pid.json").unwrap();
    assert!(!pid.to_json().contains("large_errors"));
    let p = pid_parameters(&pid);
    assert_eq!(p.large_errors.max_yaw_error_rad, std::f64::consts::PI);
    for speed in [0.0, 15.0, 60.0] {
        assert_eq!(p.largest_angle(speed), pid.limits.max_angle_rad);
    }
}

const STEP: steerwright_formats::StepMetrics = steerwright_formats::StepMetrics {
    overshoot_percent: 0.0,
    settling_time_s: None,
    steady_state_error_percent: 0.0,
    rise_time_s: None,
    largest_angle_rad: 0.0,
    largest_increment_rad: 0.0,
    integral_absolute_error_s: 0.2,
};

#[test]
fn the_path_and_its_guidance() {
    let guidance = Guidance {
        lookahead_time_s: 1.0,
        lookahead_min_m: 2.0,
        preview_time_s: 3.0,
        feedforward_gain_radm: 4.0,
        sideslip_per_yaw_rate_s: 5.0,
        cross_track_integral_gain_per_s: 6.0,
        sideslip_per_yaw_acceleration_s2: 7.0,
        sideslip_growth_s5pm2: 8.0,
        distance_rear_m: 11.0,
        yaw_acceleration_gain_s2: 9.0,
        yaw_jerk_gain_s3: 10.0,
        sideslip_correction_time_s: 13.0,
        speed_preview_time_s: 14.0,
        brake_preview_time_s: 15.0,
    };
    let law = guidance_parameters(&guidance, 12.0);
    assert_eq!(law, GuidanceParameters { guidance, reference_speed: 12.0, ..Default::default() });
    let sideslip = Sideslip {
        per_yaw_rate: 5.0,
        growth: 8.0,
        per_yaw_acceleration: 7.0,
        reference_speed: 12.0,
        distance_rear: 11.0,
    };
    assert_eq!(law.sideslip(), sideslip);

    // A straight along y.
    let point = |distance_m: f64| steerwright_formats::PathPoint {
        distance_m,
        x_m: 7.0,
        y_m: 2.0 + distance_m,
        heading_rad: std::f64::consts::FRAC_PI_2,
        curvature_per_m: 0.0,
    };
    let path = Path {
        schema: "steerwright/path/1".into(),
        name: "straight".into(),
        closed: false,
        guidance,
        schedule: vec![],
        speed_mps: 10.0,
        points: vec![point(1.0), point(5.0)],
        profile: None,
        provenance: steerwright_formats::Provenance::default(),
    };
    let geometry = path_geometry(&path).unwrap();
    let middle = geometry.point_at(3.0);
    assert_eq!((geometry.start(), geometry.end(), geometry.is_closed()), (1.0, 5.0, false));
    assert!((middle.x_m - 7.0).abs() < 1e-12 && (middle.y_m - 5.0).abs() < 1e-12, "{middle:?}");
    assert_eq!((middle.heading_rad, middle.curvature_per_m), (std::f64::consts::FRAC_PI_2, 0.0));
    let error = path_geometry(&Path { points: vec![point(1.0)], ..path }).unwrap_err();
    assert_eq!(error, Error::TooFewPoints { got: 1 });
}
