//! Small documents of every kind.
#![allow(dead_code)] // each test binary uses its own part

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use steerwright_formats::{
    Bicycle, Continuous, Discrete, Document, Evidence, Guidance, InputKind, Matrix, Noise,
    OperatingPoint, Path, PathPoint, Pid, Plant, ProfileLimits, ProfilePoint, Provenance,
    SourceFile, SpeedProfile, VehicleData,
};
use steerwright_packaging::{Binary, Fmu, Packed};

/// A text that breaks what does not escape it.
pub(crate) const AWKWARD: &str = "a \"drive\" <b>&amp; | `x` é\n\u{1}";

pub(crate) fn provenance() -> Provenance {
    Provenance {
        version: "0.1.0".into(),
        sources: vec![SourceFile {
            name: "drive <1>.csv".into(),
            sha256: "ab".repeat(32),
            of_samples: false,
        }],
        options: BTreeMap::from([("order".into(), "auto".into())]),
    }
}

/// ẋ = −5 x + 5 u, r = x: a yaw rate that follows the steering within 0.2 s.
pub(crate) fn plant() -> String {
    let a = (-0.05_f64).exp();
    let mut evidence = Evidence::default();
    evidence.fit.validation = 87.654_321;
    evidence.excitation.road_wheel_std_rad = 0.03;
    Plant {
        schema: Plant::SCHEMA.into(),
        name: AWKWARD.into(),
        input: InputKind::Steering,
        steering_ratio: 2.0,
        input_delay_s: 0.0,
        operating_point: OperatingPoint {
            speed_mps: 10.0,
            steering_offset_rad: 0.01,
            yaw_rate_offset_radps: 0.0,
        },
        discrete: Discrete {
            sample_time_s: 0.01,
            a: Matrix(vec![vec![a]]),
            b: Matrix::column(&[1.0 - a]),
            c: Matrix(vec![vec![1.0]]),
            d: Matrix(vec![vec![0.0]]),
            k: Matrix::column(&[0.0]),
            x0: vec![0.0],
        },
        continuous: Some(Continuous {
            f: Matrix(vec![vec![-5.0]]),
            g: Matrix::column(&[5.0]),
            h: Matrix(vec![vec![1.0]]),
        }),
        noise: Noise { innovation_variance: 1e-6 },
        sideslip: None,
        uncertainty: None,
        evidence,
        quality: steerwright_formats::Quality::new("fit to design on", Vec::new(), Vec::new()),
        provenance: provenance(),
    }
    .to_json()
}

pub(crate) fn bicycle() -> String {
    let vehicle = VehicleData {
        name: "car".into(),
        mass_kg: 1093.2952,
        yaw_inertia_kgm2: 1791.5995,
        distance_front_m: 1.1561957,
        distance_rear_m: 1.4227171,
        cornering_stiffness_front_npr: 129_696.69,
        cornering_stiffness_rear_npr: 105_400.27,
        actuator_time_constant_s: 0.05,
        steering_ratio: 1.0,
        speed_mps: 15.0,
        ..VehicleData::default()
    };
    Bicycle::new(vehicle).to_json()
}

pub(crate) fn pid() -> String {
    const STEP: steerwright_formats::StepMetrics = steerwright_formats::StepMetrics {
        overshoot_percent: 0.5,
        settling_time_s: Some(0.9),
        steady_state_error_percent: 0.1,
        rise_time_s: Some(0.4),
        largest_angle_rad: 0.05,
        largest_increment_rad: 0.004,
        integral_absolute_error_s: 0.2,
    };
    Pid {
        schema: Pid::SCHEMA.into(),
        name: "controller".into(),
        sample_time_s: 0.02,
        gains: steerwright_formats::PidGains {
            kp: 1.2,
            ki: 2.0,
            kd: 0.08,
            derivative_filter_time_s: 0.012,
            setpoint_weight_proportional: 0.6,
            setpoint_weight_derivative: 0.0,
            anti_windup_time_s: 0.2,
        },
        limits: steerwright_formats::Limits {
            max_angle_rad: 0.38,
            max_increment_rad: 0.26,
            max_rate_radps: 0.4,
            large_errors: None,
            lateral_acceleration: None,
        },
        designed_for: steerwright_formats::DesignedFor {
            model: "plant".into(),
            name: "drive".into(),
            sha256: "cd".repeat(32),
            speed_mps: 10.0,
            steering_ratio: 2.0,
            loop_delay_s: 0.0,
            ..steerwright_formats::DesignedFor::default()
        },
        specification: steerwright_formats::Specification {
            step_rad: 0.0873,
            steering_offset_rad: 0.0175,
            ..steerwright_formats::Specification::default()
        },
        evidence: steerwright_formats::DesignEvidence {
            met: true,
            shortfalls: Vec::new(),
            step: STEP,
            step_with_offset: STEP,
            small_step: None,
            margins: steerwright_formats::Margins {
                gain_margin_db: Some(18.0),
                phase_margin_deg: Some(52.0),
                delay_margin_s: Some(0.14),
                modulus_margin: 0.7,
                crossover_radps: Some(6.5),
                disk_margin: Some(0.9),
            },
            ..steerwright_formats::DesignEvidence::default()
        },
        guidance: steerwright_formats::GuidanceAdvice {
            feedforward_gain_radm: 0.0,
            preview_time_s: 0.25,
            yaw_acceleration_gain_s2: 0.0,
            yaw_jerk_gain_s3: 0.0,
        },
        schedule: vec![],
        provenance: provenance(),
    }
    .to_json()
}

/// From 7 m/s with an acceleration that changes from 0.3 to -0.1 m/s² in 120 m.
fn profile() -> SpeedProfile {
    let end = (49.0 + 120.0 * (0.3 - 0.1_f64)).sqrt();
    let point = |distance_m, speed_mps, acceleration_mps2| ProfilePoint {
        distance_m,
        speed_mps,
        acceleration_mps2,
    };
    SpeedProfile {
        limits: ProfileLimits {
            max_speed_mps: 10.0,
            max_lateral_acceleration_mps2: 1.0,
            max_acceleration_mps2: 1.0,
            max_deceleration_mps2: 1.0,
            max_jerk_mps3: None,
            friction: None,
            steering: None,
            end_speeds_mps: Some([7.0, end]),
        },
        time_s: 15.0,
        binding: vec![],
        points: vec![point(0.0, 7.0, 0.3), point(120.0, end, -0.1)],
    }
}

/// A road that bends to the left with a radius of 100 m.
pub(crate) fn path() -> String {
    let point = |k: u32| {
        let s = f64::from(k);
        let heading = s / 100.0;
        PathPoint {
            distance_m: s,
            x_m: 100.0 * heading.sin(),
            y_m: 100.0 * (1.0 - heading.cos()),
            heading_rad: heading,
            curvature_per_m: 0.01,
        }
    };
    Path {
        schema: Path::SCHEMA.into(),
        name: "bend".into(),
        closed: false,
        guidance: Guidance { sideslip_correction_time_s: 4.0, ..Guidance::default() },
        schedule: vec![],
        speed_mps: 10.0,
        points: (0..=120).map(point).collect(),
        profile: Some(profile()),
        provenance: provenance(),
    }
    .to_json()
}

pub(crate) fn document(fmu: Fmu) -> String {
    match fmu {
        Fmu::IdentifiedPlant => plant(),
        Fmu::BicyclePlant => bicycle(),
        Fmu::LateralPid => pid(),
        Fmu::ReferencePath => path(),
        other => other.example().to_owned(),
    }
}

pub(crate) const LINUX: &[Binary<'_>] = &[Binary { platform: "linux64", bytes: b"a library" }];

pub(crate) fn packed(fmu: Fmu) -> Packed {
    steerwright_packaging::package(&document(fmu), "document.json", LINUX, None, None).unwrap()
}

/// The files of an archive.
pub(crate) fn files(packed: &Packed) -> BTreeMap<String, Vec<u8>> {
    let mut zip = zip::ZipArchive::new(Cursor::new(&packed.bytes)).unwrap();
    (0..zip.len())
        .map(|index| {
            let mut file = zip.by_index(index).unwrap();
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes).unwrap();
            (file.name().unwrap().into_owned(), bytes)
        })
        .collect()
}

pub(crate) fn text(files: &BTreeMap<String, Vec<u8>>, name: &str) -> String {
    String::from_utf8(files.get(name).unwrap_or_else(|| panic!("no {name}")).clone()).unwrap()
}
