//! The documents that are timed, where the FMU's example is not like those of a drive.

use steerwright_formats::{
    DesignEvidence, DesignedFor, Discrete, Document as _, GuidanceAdvice, InputKind, Limits,
    Margins, Matrix, Noise, OperatingPoint, Path, PathPoint, Pid, PidGains, Plant, Specification,
    StepMetrics,
};

/// Four stable states with a delay and noise.
pub(crate) fn plant() -> Plant {
    Plant {
        schema: Plant::SCHEMA.into(),
        name: "example".into(),
        input: InputKind::Steering,
        steering_ratio: 15.0,
        input_delay_s: 0.025,
        operating_point: OperatingPoint {
            speed_mps: 15.0,
            steering_offset_rad: 0.01,
            yaw_rate_offset_radps: 0.0,
        },
        discrete: Discrete {
            sample_time_s: 0.01,
            a: Matrix(vec![
                vec![0.95, 0.05, 0.0, 0.0],
                vec![-0.05, 0.95, 0.02, 0.0],
                vec![0.0, 0.0, 0.8, 0.1],
                vec![0.0, 0.0, -0.1, 0.8],
            ]),
            b: Matrix::column(&[0.01, 0.02, 0.03, 0.01]),
            c: Matrix(vec![vec![1.0, 0.5, 0.25, 0.125]]),
            d: Matrix(vec![vec![0.0]]),
            k: Matrix::column(&[0.1, 0.05, 0.02, 0.01]),
            x0: vec![0.0; 4],
        },
        continuous: None,
        noise: Noise { innovation_variance: 1e-6 },
        sideslip: None,
        uncertainty: None,
        evidence: steerwright_formats::Evidence::default(),
        quality: steerwright_formats::Quality::default(),
        provenance: steerwright_formats::Provenance::default(),
    }
}

/// A controller of a car with a steering ratio of 15.
pub(crate) fn pid() -> Pid {
    let step = StepMetrics {
        overshoot_percent: 0.5,
        settling_time_s: Some(0.9),
        steady_state_error_percent: 0.1,
        rise_time_s: Some(0.5),
        largest_angle_rad: 1.0,
        largest_increment_rad: 0.1,
        integral_absolute_error_s: 0.2,
    };
    Pid {
        schema: Pid::SCHEMA.into(),
        name: "example".into(),
        sample_time_s: 0.01,
        gains: PidGains {
            kp: 30.0,
            ki: 2.0,
            kd: 1.5,
            derivative_filter_time_s: 0.02,
            setpoint_weight_proportional: 0.7,
            setpoint_weight_derivative: 0.0,
            anti_windup_time_s: 0.5,
        },
        limits: Limits {
            max_angle_rad: 5.76,
            max_increment_rad: 3.9,
            max_rate_radps: 6.0,
            large_errors: None,
            lateral_acceleration: None,
        },
        designed_for: DesignedFor {
            model: "plant".into(),
            name: "example".into(),
            sha256: String::new(),
            speed_mps: 15.0,
            steering_ratio: 15.0,
            loop_delay_s: 0.0,
            ..DesignedFor::default()
        },
        specification: Specification {
            step_rad: 0.1,
            steering_offset_rad: 0.0,
            ..Specification::default()
        },
        evidence: DesignEvidence {
            met: true,
            shortfalls: Vec::new(),
            step,
            step_with_offset: step,
            small_step: None,
            margins: Margins {
                gain_margin_db: None,
                phase_margin_deg: Some(60.0),
                delay_margin_s: None,
                modulus_margin: 0.7,
                crossover_radps: None,
                disk_margin: Some(0.9),
            },
            ..DesignEvidence::default()
        },
        guidance: GuidanceAdvice {
            feedforward_gain_radm: 40.0,
            preview_time_s: 0.2,
            yaw_acceleration_gain_s2: 0.0,
            yaw_jerk_gain_s3: 0.0,
        },
        schedule: vec![],
        provenance: steerwright_formats::Provenance::default(),
    }
}

/// A straight of 20 m, then an arc to the left.
pub(crate) fn path() -> Path {
    let radius = 50.0;
    let point = |i: i32| {
        let distance_m = f64::from(i) * 2.0;
        let angle = ((distance_m - 20.0) / radius).max(0.0);
        PathPoint {
            distance_m,
            x_m: distance_m.min(20.0) + radius * angle.sin(),
            y_m: radius * (1.0 - angle.cos()),
            heading_rad: angle,
            curvature_per_m: if angle > 0.0 { 1.0 / radius } else { 0.0 },
        }
    };
    Path {
        schema: Path::SCHEMA.into(),
        name: "example".into(),
        closed: false,
        guidance: steerwright_formats::Guidance::default(),
        schedule: vec![],
        speed_mps: 15.0,
        points: (0..=60).map(point).collect(),
        profile: None,
        provenance: steerwright_formats::Provenance::default(),
    }
}
