//! Reading what was written, and refusing everything else at the right place.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use steerwright_formats::{
    Continuous, Discrete, Document, Error, Estimator, Evidence, Guidance, InputKind, Longitudinal,
    Manoeuvre, Matrix, Noise, OperatingPoint, Path, PathPoint, Plant, Provenance, Sideslip,
    SideslipTerm,
};

fn plant() -> Plant {
    Plant {
        schema: Plant::SCHEMA.into(),
        name: "a drive with [odd, 1,2] \"name\"".into(),
        input: InputKind::SteeringTimesSpeed,
        steering_ratio: 16.3,
        input_delay_s: 0.0,
        operating_point: OperatingPoint {
            speed_mps: 15.0,
            steering_offset_rad: 0.01,
            yaw_rate_offset_radps: 0.0,
        },
        discrete: Discrete {
            sample_time_s: 0.01,
            a: Matrix(vec![vec![0.9, 0.1], vec![-0.1, 0.8]]),
            b: Matrix::column(&[0.1, 1.0 / 3.0]),
            c: Matrix(vec![vec![1.0, 0.0]]),
            d: Matrix(vec![vec![0.0]]),
            k: Matrix::column(&[0.0, 0.0]),
            x0: vec![0.0, 1e-300],
        },
        continuous: Some(Continuous {
            f: Matrix(vec![vec![-1.0, 0.1], vec![-0.1, -2.0]]),
            g: Matrix::column(&[0.1, 0.3]),
            h: Matrix(vec![vec![1.0, 0.0]]),
        }),
        noise: Noise { innovation_variance: 4e-6 },
        sideslip: None,
        uncertainty: None,
        evidence: Evidence::default(),
        quality: steerwright_formats::Quality::default(),
        provenance: Provenance::default(),
    }
}

/// Where `Plant::from_json` says the fault is.
fn fault(text: &str) -> String {
    match Plant::from_json(text, "p.json").unwrap_err() {
        Error::Syntax { path, .. } | Error::Value { path, .. } => path,
        Error::Schema { found, .. } => format!("schema {found}"),
        other => panic!("{other}"),
    }
}

#[test]
fn what_is_written_is_read_again_exactly() {
    let text = plant().to_json();
    assert_eq!(Plant::from_json(&text, "p.json").unwrap(), plant());
    assert!(text.contains("\"A\": [\n      [0.9, 0.1],\n      [-0.1, 0.8]\n    ]"), "{text}");
}

#[test]
fn faults_are_named_by_their_place() {
    let good = plant().to_json();
    for (from, to, expected) in [
        ("steerwright/plant/1", "steerwright/plant/2", "schema `steerwright/plant/2`"),
        ("steerwright/plant/1", "steerwright/pid/1", "schema `steerwright/pid/1`"),
        ("\"steering_ratio\": 16.3", "\"steering_ratio\": 0", "steering_ratio"),
        ("\"steering_ratio\": 16.3", "\"steering_ratio\": \"16\"", "steering_ratio"),
        ("\"speed_mps\": 15.0", "\"speed_mps\": null", "operating_point.speed_mps"),
        ("\"speed_mps\": 15.0", "\"speed_mps\": 1e999", "operating_point.speed_mps"),
        ("[0.9, 0.1]", "[0.9]", "discrete.A"),
        ("[0.9, 0.1]", "[0.9, \"x\"]", "discrete.A[0][1]"),
        ("\"x0\": [0.0, 1e-300]", "\"x0\": [0.0]", "discrete.x0"),
        ("steering*speed", "throttle", "input"),
        ("\"sample_time_s\": 0.01", "\"sample_time_s\": -0.01", "discrete.sample_time_s"),
        ("\"steering_ratio\"", "\"steering_ration\"", "steering_ration"),
    ] {
        assert!(good.contains(from), "{from} is not in {good}");
        assert_eq!(fault(&good.replacen(from, to, 1)), expected, "{from} -> {to}");
    }
    for no_object in ["[]", " [1, 2]\n", "17", "\"plant\"", "null"] {
        assert_eq!(fault(no_object), "schema no object", "{no_object}");
    }
    assert_eq!(fault("{}"), "schema nothing");
    assert_eq!(fault(""), ".");
    assert_eq!(fault(&format!("{good} x")), ".");
}

#[test]
fn a_path_needs_two_points_at_increasing_distance() {
    let point = |d: f64| PathPoint {
        distance_m: d,
        x_m: d,
        y_m: 0.0,
        heading_rad: 0.0,
        curvature_per_m: 0.0,
    };
    let mut path = Path {
        schema: Path::SCHEMA.into(),
        name: "straight".into(),
        closed: false,
        guidance: Guidance::default(),
        schedule: vec![],
        speed_mps: 15.0,
        points: vec![point(0.0), point(1.0), point(2.0)],
        profile: None,
        provenance: Provenance::default(),
    };
    assert_eq!(Path::from_json(&path.to_json(), "p").unwrap(), path);
    path.points[2] = point(1.0);
    let error = path.checked("road.json").unwrap_err();
    assert!(error.to_string().starts_with("road.json: at `points[2][0]`"), "{error}");
    path.points.truncate(1);
    assert!(path.checked("p").is_err());
}

#[test]
fn faults_of_a_speed_profile_have_their_place() {
    // From 1 m to 5 m v² falls by 4·(2 + 0.6), and to standstill at constant jerk by 1.5·4·0.6.
    let settled = r#"{"schema": "steerwright/path/1", "name": "straight", "closed": false, "guidance":
        {"lookahead_time_s": 1, "lookahead_min_m": 5, "preview_time_s": 0, "feedforward_gain_radm": 0,
        "sideslip_per_yaw_rate_s": 0}, "speed_mps": 15, "points": [[0, 0, 0, 0, 0], [9, 9, 0, 0, 0]],
        "profile": {"limits": {"max_speed_mps": 15, "max_lateral_acceleration_mps2": 4, "max_acceleration_mps2": 2,
        "max_deceleration_mps2": 3, "end_speeds_mps": [4, 0]}, "time_s": 4.5, "binding":
        [{"limit": "lateral-acceleration", "from_m": 0, "to_m": 1, "time_s": 0.3}],
        "points": [[0, 4, 0], [1, 3.7417, -2], [5, 1.8974, -0.6], [9, 0, 0]]},
        "provenance": {"version": "", "sources": [], "options": {}}}"#;
    let fault = |text: &str| match Path::from_json(text, "p") {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    assert_eq!(fault(settled), "");
    for (from, to, expected) in [
        ("[1, 3.7417, -2]", "[1, 4.7417, -2]", "at `profile.points[1]`: from 4 m/s to 4.7417 m/s"),
        ("[5, 1.8974, -0.6]", "[5, 0, -0.6]", "at `profile.points[2][1]`: the speed is 0"),
        ("[1, 3.7417, -2]", "[0, 3.7417, -2]", "at `profile.points[1][0]`: distance 0 does not"),
        ("[9, 0, 0]]}", "[8, 0, 0]]}", "at `profile.points[3]`"),
        ("\"end_speeds_mps\": [4, 0]", "\"friction\": 1", "at `profile.limits.end_speeds_mps`"),
        ("\"closed\": false", "\"closed\": true", "a closed path has no ends"),
        ("\"max_speed_mps\": 15", "\"max_speed_mps\": 0", "at `profile.limits.max_speed_mps`"),
        ("lateral-acceleration", "lateral", "unknown variant `lateral`"),
        ("\"time_s\": 4.5", "\"time_s\": -4.5", "at `profile.time_s`"),
    ] {
        assert!(settled.contains(from), "{from}");
        let text = fault(&settled.replacen(from, to, 1));
        assert!(text.contains(expected), "{from} -> {to}: {text}");
    }
    // A file without a profile is read as before.
    let (before, rest) = settled.split_once("\"profile\"").unwrap();
    let rest = &rest[rest.find("\"provenance\"").unwrap()..];
    assert_eq!(fault(&format!("{before}{rest}")), "");
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in ".{0,200}") {
        let _ = Plant::from_json(&text, "p");
    }

    #[test]
    fn a_damaged_file_never_makes_the_reader_panic(at in 0usize..3000, with in any::<char>()) {
        let mut text: Vec<char> = plant().to_json().chars().collect();
        let at = at % text.len();
        text[at] = with;
        let _ = Plant::from_json(&text.into_iter().collect::<String>(), "p");
    }

    #[test]
    fn numbers_survive_to_the_last_bit(value in any::<f64>().prop_filter("finite", |v| v.is_finite())) {
        let mut document = plant();
        document.discrete.b.0[0][0] = value;
        let back = Plant::from_json(&document.to_json(), "p").unwrap();
        prop_assert_eq!(back.discrete.b.entry(0, 0).to_bits(), value.to_bits());
    }
}

/// Evidence that came later is absent from older files: they are read, and written without it.
#[test]
fn a_plant_from_before_the_evidence_grew_is_read() {
    let text = plant().to_json();
    for later in
        ["held_out", "residuals", "frequency_response", "poles_and_zeros", "bands", "persistence"]
    {
        assert!(!text.contains(&format!("\"{later}\"")), "{later}");
    }
}

/// A sideslip that follows the speed is written and read; one without the distance to the rear axle is
/// written as it always was.
#[test]
fn the_distance_to_the_rear_axle_is_optional() {
    let term = |value: f64| SideslipTerm { value, standard_error: 0.05 };
    let with = |distance_rear_m: Option<SideslipTerm>| {
        let sideslip = Sideslip {
            speed_mps: distance_rear_m.map(|_| 12.0),
            sideslip_per_yaw_rate_s: 0.04,
            standard_error_s: 0.002,
            sideslip_growth_s5pm2: None,
            sideslip_per_yaw_acceleration_s2: None,
            distance_rear_m,
            gnss_latency_s: 0.1,
            gnss_latency_standard_error_s: None,
            antenna_x_m: 0.0,
        };
        Plant { sideslip: Some(sideslip), ..plant() }
    };
    let stated = with(Some(term(1.4)));
    assert_eq!(Plant::from_json(&stated.to_json(), "p.json").unwrap(), stated);
    let text = with(None).to_json();
    assert!(!text.contains("distance_rear_m"), "{text}");
    assert!(!text.contains("\"speed_mps\": 12"), "{text}");
    assert_eq!(Plant::from_json(&text, "p.json").unwrap().sideslip.unwrap().distance_rear(), 0.0);
    assert_eq!(fault(&with(Some(term(-1.0))).to_json()), "sideslip.distance_rear_m.value");

    let text = include_str!("../../examples/drives/multibody/estimator.json");
    let estimator = Estimator::from_json(text, "estimator.json").unwrap();
    assert_eq!(estimator.distance_rear_m, 0.0);
    assert!(!estimator.to_json().contains("distance_rear_m"));
    let wrong = Estimator { distance_rear_m: -1.0, ..estimator }.to_json();
    let error = Estimator::from_json(&wrong, "estimator.json").unwrap_err().to_string();
    assert!(error.contains("distance_rear_m"), "{error}");
}

#[test]
fn a_manoeuvre_has_blocks_that_follow_each_other_and_signals_that_fit_them() {
    let text = include_str!("excitation.json");
    let read = |text: &str| Manoeuvre::from_json(text, "m.json");
    let manoeuvre = read(text).unwrap();
    assert_eq!(read(&manoeuvre.to_json()).unwrap(), manoeuvre);
    assert_eq!((manoeuvre.time_s(), manoeuvre.block_samples()), (8.0, 8));
    let steered: Vec<f64> =
        (0..6).map(|k| manoeuvre.steering_rad(&manoeuvre.schedule[1], k)).collect();
    assert_eq!(steered, [0.0, -0.3, 0.0, 0.3, 0.0, 0.0]);
    for (from, to, at) in [
        ("\"start_s\": 4.0", "\"start_s\": 5.0", "schedule[1].start_s"),
        ("\"signal\": 0", "\"signal\": 1", "schedule[0].signal"),
        ("\"block_s\": 4.0", "\"block_s\": 2.0", "schedule[1].start_s"),
        ("\"max_angle_rad\": 0.5", "\"max_angle_rad\": 0.0", "limits.max_angle_rad"),
        ("\"noise_density\": 3e-08", "\"noise_density\": 0.0", "noise_density"),
        ("\"speed_mps\": 15.0", "\"speed_mps\": -1.0", "signals[0].speed_mps"),
        ("\"gain_error\": 0.01", "\"gain_error\": -0.01", "expected.response[0].gain_error"),
    ] {
        assert!(text.contains(from), "{from}");
        match read(&text.replacen(from, to, 1)).unwrap_err() {
            Error::Value { path, .. } => assert_eq!(path, at),
            other => panic!("{other}"),
        }
    }
}

/// A covariance that is none is refused at the entry that is wrong: controllers are designed on vehicles drawn from it.
#[test]
fn a_covariance_is_symmetric_with_correlations_within_one() {
    let text = include_str!("../../fmu/longitudinal-plant/example.json");
    let with = |i: usize, j: usize, value: f64| {
        let mut model = Longitudinal::from_json(text, "longitudinal.json").unwrap();
        model.parameters = vec!["gains[0].gain".into(), "delay_s".into()];
        model.covariance = Matrix(vec![vec![4.0, -1.0], vec![-1.0, 1.0]]);
        model.covariance.0[i][j] = value;
        model.checked("longitudinal.json").map_err(|e| e.to_string()).err().unwrap_or_default()
    };
    assert_eq!(with(1, 0, -1.0), "");
    let negative = with(0, 0, -1e-6);
    assert!(negative.contains("covariance[0][0]"), "{negative}");
    let asymmetric = with(0, 1, 0.5);
    assert!(asymmetric.contains("a covariance is symmetric"), "{asymmetric}");
    let correlated = with(0, 0, 0.0);
    assert!(correlated.contains("covariance[1][0]"), "{correlated}");
}
