//! A controller, its step, a road and a run along it.

use super::provenance;
use steerwright_formats::*;
use steerwright_report::{StepResponse, Track};

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
        limits: Limits {
            max_angle_rad: 0.384,
            max_increment_rad: 0.262,
            max_rate_radps: 10.0,
            large_errors: None,
            lateral_acceleration: None,
        },
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
                vec![Shortfall {
                    requirement: "settling_time_s".into(),
                    required: 1.0,
                    reached: 1.4,
                }]
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
        guidance: GuidanceAdvice {
            feedforward_gain_radm: 3.1,
            preview_time_s: 0.2,
            yaw_acceleration_gain_s2: 0.0,
            yaw_jerk_gain_s3: 0.0,
        },
        schedule: vec![],
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
        schedule: vec![],
        speed_mps: 10.0,
        points,
        profile: None,
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
