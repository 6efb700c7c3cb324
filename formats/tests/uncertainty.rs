//! The uncertainty in `plant.json`: read as written, refused where it is wrong, members drawn from it.
#![allow(clippy::unwrap_used)]

use steerwright_formats::{
    Discrete, Document, Error, Estimate, EstimationFocus, Evidence, FrequencyBand, InputKind,
    Matrix, Noise, OperatingPoint, Plant, Provenance, StepBand, UncertainPole, Uncertainty,
};

/// An order-2 plant with two directions: one moves B alone, one everything.
fn plant() -> Plant {
    let pole =
        |re| UncertainPole { re, im: 0.0, variance_re: 1e-4, variance_im: 0.0, covariance: 0.0 };
    let mut only_b = vec![0.0; 11];
    only_b[4] = 0.25;
    let everything: Vec<f64> = (1..=11).map(|k| 0.01 * f64::from(k)).collect();
    Plant {
        schema: Plant::SCHEMA.into(),
        name: "drive".into(),
        input: InputKind::Steering,
        steering_ratio: 1.0,
        input_delay_s: 0.0,
        operating_point: OperatingPoint {
            speed_mps: 15.0,
            steering_offset_rad: 0.0,
            yaw_rate_offset_radps: 0.0,
        },
        discrete: Discrete {
            sample_time_s: 0.01,
            a: Matrix(vec![vec![0.9, 0.0], vec![0.0, 0.8]]),
            b: Matrix::column(&[0.1, 0.2]),
            c: Matrix(vec![vec![1.0, 0.5]]),
            d: Matrix(vec![vec![0.0]]),
            k: Matrix::column(&[0.3, 0.4]),
            x0: vec![0.0, 0.0],
        },
        continuous: None,
        noise: Noise { innovation_variance: 4e-6 },
        sideslip: None,
        uncertainty: Some(Uncertainty {
            focus: EstimationFocus::Simulation,
            poles: vec![pole(0.9), pole(0.8)],
            steady_state_gain: Some(Estimate { value: 1.5, standard_error: 0.1 }),
            frequency_response: vec![FrequencyBand {
                frequency_hz: 1.0,
                magnitude: 1.2,
                phase_rad: -0.3,
                magnitude_standard_error: 0.1,
                phase_standard_error_rad: 0.05,
            }],
            step_response: vec![StepBand { time_s: 0.1, value: 0.5, standard_error: 0.02 }],
            open_hold_s: Some(0.1),
            directions: Matrix(vec![only_b, everything]),
        }),
        evidence: Evidence::default(),
        quality: steerwright_formats::Quality::default(),
        provenance: Provenance::default(),
    }
}

#[test]
fn it_is_read_as_it_was_written_and_may_be_missing() {
    let with = plant();
    let text = with.to_json();
    assert_eq!(Plant::from_json(&text, "p").unwrap(), with);
    // Each direction on one line, so that a file can be read and diffed.
    assert!(text.contains("[0.01, 0.02, "), "{text}");
    let without = Plant { uncertainty: None, ..plant() };
    assert!(!without.to_json().contains("uncertainty"));
    assert_eq!(Plant::from_json(&without.to_json(), "p").unwrap(), without);
}

#[test]
fn faults_are_named_by_their_place() {
    let fault = |change: &dyn Fn(&mut Uncertainty)| {
        let mut plant = plant();
        change(plant.uncertainty.as_mut().unwrap());
        match plant.checked("p").unwrap_err() {
            Error::Value { path, .. } => path,
            other => other.to_string(),
        }
    };
    assert_eq!(fault(&|u| u.poles.truncate(1)), "uncertainty.poles");
    assert_eq!(fault(&|u| u.poles[1].variance_re = -1.0), "uncertainty.poles[1].variance_re");
    assert_eq!(
        fault(&|u| u.steady_state_gain.as_mut().unwrap().standard_error = f64::NAN),
        "uncertainty.steady_state_gain.standard_error"
    );
    assert_eq!(
        fault(&|u| u.frequency_response[0].phase_rad = f64::INFINITY),
        "uncertainty.frequency_response[0].phase_rad"
    );
    assert_eq!(
        fault(&|u| u.step_response[0].standard_error = -0.1),
        "uncertainty.step_response[0].standard_error"
    );
    assert_eq!(fault(&|u| u.open_hold_s = Some(0.0)), "uncertainty.open_hold_s");
    assert_eq!(fault(&|u| u.directions.0[1].truncate(10)), "uncertainty.directions");
    assert_eq!(fault(&|u| u.directions.0[1][3] = f64::NAN), "uncertainty.directions[1][3]");
    assert_eq!(
        fault(&|u| u.directions = Matrix(vec![vec![0.0; 11]; 12])),
        "uncertainty.directions"
    );
}

#[test]
fn a_member_is_the_model_moved_along_the_directions() {
    let plant = plant();
    assert_eq!(plant.ensemble_dimension(), 2);
    let still = plant.ensemble_member(&[0.0, 0.0]).unwrap();
    assert_eq!(still.discrete, plant.discrete);
    let member = plant.ensemble_member(&[2.0, -1.0]).unwrap();
    let (was, is) = (&plant.discrete, &member.discrete);
    assert!((is.a.entry(0, 1) - (was.a.entry(0, 1) - 0.02)).abs() < 1e-15);
    assert!((is.b.entry(0, 0) - (was.b.entry(0, 0) + 0.5 - 0.05)).abs() < 1e-15);
    assert!((is.c.entry(0, 1) - (was.c.entry(0, 1) - 0.08)).abs() < 1e-15);
    assert!((is.d.entry(0, 0) + 0.09).abs() < 1e-15);
    assert!((is.k.entry(1, 0) - (was.k.entry(1, 0) - 0.11)).abs() < 1e-15);
    assert_eq!((member.continuous.clone(), member.uncertainty.clone()), (None, None));
    assert_eq!(Plant::from_json(&member.to_json(), "p").unwrap(), member);
}

#[test]
fn no_member_where_none_can_be_drawn() {
    let plant = plant();
    assert!(plant.ensemble_member(&[0.0]).is_none());
    // The second direction moves A by [0.01, 0.02; 0.03, 0.04]: far along it A is unstable.
    assert!(plant.ensemble_member(&[0.0, 20.0]).is_none());
    let certain = Plant { uncertainty: None, ..plant };
    assert_eq!(certain.ensemble_dimension(), 0);
    assert!(certain.ensemble_member(&[]).is_none());
}
