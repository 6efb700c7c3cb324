//! Plants and options that do not allow a design are rejected with their reason.

use crate::common::{car, identified, identified_car, options as usual, requiring, source};
use steerwright_control::{DesignOptions, DesignPlant, Error, design};

/// Eq 9–11: a file with one edited matrix is inconsistent.
#[test]
fn an_inconsistent_plant_is_rejected() {
    let plant = identified_car();
    let refused = |change: &dyn Fn(&mut steerwright_formats::Plant)| {
        let mut plant = plant.clone();
        change(&mut plant);
        let error = DesignPlant::from_plant(&plant).expect_err("refused");
        assert!(matches!(error, Error::Identified { .. }) && !error.hint().is_empty(), "{error}");
        error.to_string()
    };
    assert!(refused(&|p| p.discrete.a.0[0][0] *= 1.01).contains("A differs"));
    assert!(refused(&|p| p.discrete.b.0[0][0] += 0.01).contains("B differs"));
    assert!(refused(&|p| p.discrete.c.0[0][1] = 2.0).contains("C differs"));
    let edit = |p: &mut steerwright_formats::Plant| {
        p.continuous.as_mut().expect("a continuous model").f.0[0][0] *= 1.01;
    };
    assert!(refused(&edit).contains("differs"));
}

/// Feedforward and the gain of steering times speed are undefined without a speed.
#[test]
fn a_plant_of_unknown_speed_is_rejected() {
    for input in [
        steerwright_formats::InputKind::Steering,
        steerwright_formats::InputKind::SteeringTimesSpeed,
    ] {
        let mut plant = identified_car();
        plant.operating_point.speed_mps = 0.0;
        plant.input = input;
        let error = DesignPlant::from_plant(&plant).expect_err("refused");
        assert_eq!(error, Error::NoSpeed { model: "drive".into() });
        assert!(error.to_string().contains("operating_point.speed_mps is 0"), "{error}");
        assert!(error.hint().contains("speed"), "{}", error.hint());
    }
}

#[test]
fn plants_that_cannot_be_controlled_are_rejected() {
    let refused = |f: &[f64], g: &[f64], h: &[f64]| {
        let plant = identified(f, g, h, 0.01, 0.0);
        let errors = [true, false].map(|continuous| {
            let mut plant = plant.clone();
            if !continuous {
                plant.continuous = None;
            }
            DesignPlant::from_plant(&plant).expect_err("refused")
        });
        assert_eq!(
            std::mem::discriminant(&errors[0]),
            std::mem::discriminant(&errors[1]),
            "{errors:?}"
        );
        assert!(!errors[0].hint().is_empty());
        errors[0].to_string()
    };
    assert!(refused(&[0.5], &[1.0], &[1.0]).contains("unstable"));
    assert!(refused(&[0.0], &[1.0], &[1.0]).contains("unstable"));
    assert!(refused(&[-5.0], &[1.0], &[-1.0]).contains("steady-state gain"));
    assert!(refused(&[-5.0], &[0.0], &[1.0]).contains("steady-state gain"));
    for bad in [
        requiring(|s| s.overshoot_percent = Some(-1.0)),
        DesignOptions { loop_delay_s: -0.1, ..usual() },
        DesignOptions { loop_delay_s: 20.0, ..usual() },
        requiring(|s| s.modulus_margin = Some(1.0)),
        requiring(|s| s.settling_time_s = Some(f64::NAN)),
        DesignOptions { max_angle_rad: Some(0.0), ..usual() },
        DesignOptions { sample_time_s: 0.0, ..usual() },
    ] {
        let plant = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
        assert!(design(&plant, &source(), &bad).is_err(), "{bad:?}");
    }
}
