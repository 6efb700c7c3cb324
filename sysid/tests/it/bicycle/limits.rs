//! What no drive determines, and drives that are none: reported, or rejected.

use super::{DRIVE, Drive, T, car, drive, evidence, recording};
use crate::known::Random;
use steerwright_drivelog::DriveLog;
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};
use steerwright_sysid::{Error, ValidationData};

#[test]
fn a_constant_speed_is_reported_to_schedule_nothing() {
    let log = drive(car(), Drive { noise: 0.001, slowest: 15.0, fastest: 15.0, ..DRIVE });
    let found = identify_bicycle(&log, &BicycleOptions::default()).unwrap();
    let e = evidence(&found);
    assert!(e.validation_fit > 97.0);
    assert!(e.warnings.iter().any(|w| w.contains("hardly varies")), "{:?}", e.warnings);
    let quality = &found.bicycle.quality;
    assert!(quality.summary.contains("the only speed driven"), "{quality:?}");
}

#[test]
fn hopeless_drives_are_errors_or_reported() {
    let good = drive(car(), Drive { noise: 0.003, seconds: 40.0, ..DRIVE });
    let n = good.len();
    let options = BicycleOptions::default();
    let identify = |log: &DriveLog| identify_bicycle(log, &options);

    let no_speed = DriveLog { speed: None, ..good.clone() };
    let error = identify(&no_speed).unwrap_err();
    assert_eq!(error, Error::SpeedNeeded);
    assert!(error.hint().contains("channel of the speed"), "{}", error.hint());

    let mut broken = good.clone();
    broken.speed.as_mut().unwrap()[7] = f64::NAN;
    assert!(matches!(identify(&broken), Err(Error::NoModel { .. })));
    for value in [f64::NAN, f64::INFINITY] {
        let mut broken = good.clone();
        broken.input[3] = value;
        assert!(matches!(identify(&broken), Err(Error::NoModel { .. })));
        let mut broken = good.clone();
        broken.output[n - 1] = value;
        assert!(matches!(identify(&broken), Err(Error::NoModel { .. })));
    }
    let mut backwards = good.clone();
    backwards.speed.as_mut().unwrap()[7] = -3.0;
    assert!(identify(&backwards).unwrap_err().to_string().contains("-3 m/s"));

    let still = DriveLog { input: vec![0.01; n], ..good.clone() };
    assert!(identify(&still).unwrap_err().to_string().contains("steering does not move"));
    let short =
        DriveLog { speed: Some(vec![10.0; 50]), ..recording(T, vec![0.1; 50], vec![0.1; 50]) };
    assert!(matches!(identify(&short), Err(Error::TooFewSamples { .. })));
    let mut uneven = good.clone();
    uneven.speed.as_mut().unwrap().pop();
    assert!(matches!(identify(&uneven), Err(Error::NoModel { .. })));

    // Nothing of it is a car, and nothing of it may crash or be trusted.
    let mut random = Random(3);
    let noise: Vec<f64> = (0..n).map(|_| random.normal()).collect();
    for (what, log) in [
        ("at rest", DriveLog { speed: Some(vec![0.0; n]), ..good.clone() }),
        ("noise", DriveLog { output: noise.clone(), ..good.clone() }),
        (
            "opposite sign",
            DriveLog { input: good.input.iter().map(|u| -u).collect(), ..good.clone() },
        ),
        (
            "spikes",
            DriveLog {
                output: noise.iter().map(|e| if *e > 2.0 { 1e6 } else { 0.0 }).collect(),
                ..good.clone()
            },
        ),
        ("flying", DriveLog { speed: Some(vec![1e4; n]), ..good.clone() }),
        ("huge", DriveLog { input: noise.iter().map(|e| 1e300 * e).collect(), ..good.clone() }),
    ] {
        match identify(&log) {
            Ok(found) => {
                let e = evidence(&found);
                let quality = &found.bicycle.quality;
                println!("{what}: {:.1} % {}", e.validation_fit, quality.summary);
                assert!(!quality.allows_design(), "{what}: {quality:?}");
            }
            Err(error) => println!("{what}: {error}; {}", error.hint()),
        }
    }

    for options in [
        BicycleOptions { mass_kg: Some(0.0), ..BicycleOptions::default() },
        BicycleOptions { front_share: Some(1.0), ..BicycleOptions::default() },
        BicycleOptions { wheelbase_m: Some(f64::NAN), ..BicycleOptions::default() },
        BicycleOptions {
            validation: ValidationData { fraction: 0.95, ..ValidationData::default() },
            ..BicycleOptions::default()
        },
    ] {
        assert!(matches!(identify_bicycle(&good, &options), Err(Error::Option { .. })));
    }
}
