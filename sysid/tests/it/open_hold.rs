//! Whether the steering of linear cars is held between its samples, over speeds, rates and lags.

use crate::linear_car::{CAR, LinearCar, Pattern};
use steerwright_drivelog::Intersample;
use steerwright_formats::{BicycleEvidence, Grade, ReasonCode};
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};
use steerwright_sysid::single_track::{IdentifyVehicleOptions, identify_vehicle};

fn identified(drive: LinearCar) -> BicycleEvidence {
    let found = identify_bicycle(&drive.log(), &BicycleOptions::default()).unwrap();
    found.bicycle.evidence.unwrap()
}

fn value(e: &BicycleEvidence, name: &str) -> f64 {
    e.identified.iter().find(|q| q.name == name).unwrap().value
}

fn is_read_as_held(e: &BicycleEvidence) -> bool {
    e.warnings.iter().any(|w| w.contains("read as held"))
}

/// A vehicle reads the steering as the other structures do, and is no pass where that is open and matters.
#[test]
fn a_vehicle_is_no_pass_by_a_steering_that_may_be_held() {
    let drive = LinearCar {
        pattern: Pattern::Multisine,
        rate_hz: 20.0,
        is_held: true,
        seed: 3,
        mean_mps: 22.0,
        varies_mps: 5.0,
        ..CAR
    };
    let found = identify_vehicle(&drive.log(), &IdentifyVehicleOptions::default()).unwrap();
    let e = found.vehicle.evidence.as_ref().unwrap();
    let delay = e.parameters.iter().find(|p| p.name == "actuator_delay").unwrap();
    println!("{delay:?}");
    assert!(e.warnings.iter().any(|w| w.contains("read as held")), "{:?}", e.warnings);
    assert_eq!(e.open_hold_s, Some(0.05));
    // Half a period of 0.05 s is no delay of the vehicle.
    assert!(delay.value < 0.01);
    assert_eq!(found.vehicle.quality.grade, Grade::Warn);
    let codes: Vec<_> = found.vehicle.quality.reasons.iter().map(|r| r.code).collect();
    assert!(codes.contains(&ReasonCode::UncertainPhase), "{codes:?}");
    // Stated, it is one.
    let stated = LinearCar { intersample: Some(Intersample::Zoh), ..drive };
    let found = identify_vehicle(&stated.log(), &IdentifyVehicleOptions::default()).unwrap();
    assert_eq!(found.vehicle.quality.grade, Grade::Pass, "{:?}", found.vehicle.quality.reasons);
}

/// Drives over patterns and speeds, for sample rates and lags of the actuator.
fn drives(of: &[(f64, f64)], is_held: bool) -> Vec<LinearCar> {
    let mut all = Vec::new();
    for pattern in [Pattern::Chirp, Pattern::Multisine] {
        for (seed, mean_mps, varies_mps) in [(2, 18.0, 10.0), (3, 22.0, 5.0), (4, 16.0, 0.0)] {
            all.extend(of.iter().map(|&(rate_hz, lag_s)| LinearCar {
                seed,
                pattern,
                mean_mps,
                varies_mps,
                rate_hz,
                lag_s,
                is_held,
                ..CAR
            }));
        }
    }
    all
}

/// A chirp at a speed that varies, by which models of one speed prefer a hold by hundreds.
#[test]
fn a_chirp_at_varying_speed_is_not_read_as_held() {
    let e = identified(CAR);
    let (wheelbase, lag) = (value(&e, "effective_wheelbase"), value(&e, "actuator_time_constant"));
    println!("wheelbase {wheelbase:.3} m, lag {lag:.4} s, open {:?}", e.open_hold_s);
    assert!(!is_read_as_held(&e));
    assert!((wheelbase - 2.75).abs() < 0.01 && (lag - 0.04).abs() < 0.003);
    let held = identified(LinearCar { is_held: true, ..CAR });
    assert!(is_read_as_held(&held), "{:?}", held.warnings);
}

/// No steering that moves on is read as held where the speed varies.
#[test]
#[ignore = "slow: cargo xtask test"]
fn no_steering_that_moves_on_is_read_as_held() {
    let mut read_as_held = 0;
    let rates_and_lags =
        [(20.0, 0.04), (20.0, 0.1), (50.0, 0.02), (50.0, 0.04), (50.0, 0.1), (100.0, 0.06)];
    for drive in drives(&rates_and_lags, false) {
        let e = identified(drive);
        println!("{drive:?}: open {:?}", e.open_hold_s);
        let is_read_as_held = is_read_as_held(&e);
        read_as_held += usize::from(is_read_as_held);
        // At one speed a lag may be a delay, and with that a hold.
        assert!(!is_read_as_held || drive.varies_mps == 0.0, "{drive:?}");
        let wheelbase = value(&e, "effective_wheelbase");
        let is_determined = drive.varies_mps > 0.0 && drive.rate_hz > 20.0;
        assert!(!is_determined || (wheelbase / 2.75 - 1.0).abs() < 0.02, "{drive:?}: {wheelbase}");
    }
    println!("{read_as_held} are read as held, at one speed");
    assert!(read_as_held <= 3, "{read_as_held}");
}

/// No steering that is held is certain to move on, however the speed varies.
#[test]
#[ignore = "slow: cargo xtask test"]
fn no_steering_that_is_held_is_certain_to_move_on() {
    let rates_and_lags =
        [(10.0, 0.06), (20.0, 0.04), (20.0, 0.1), (50.0, 0.02), (50.0, 0.04), (50.0, 0.1)];
    let all = drives(&rates_and_lags, true);
    let mut read_as_held = 0;
    for drive in &all {
        let e = identified(*drive);
        println!("{drive:?}: read as held {}, open {:?}", is_read_as_held(&e), e.open_hold_s);
        assert!(e.open_hold_s.is_some(), "{drive:?}");
        read_as_held += usize::from(is_read_as_held(&e));
    }
    println!("{read_as_held} of {} are read as held", all.len());
    assert!(4 * read_as_held > all.len(), "{read_as_held} of {}", all.len());
}
