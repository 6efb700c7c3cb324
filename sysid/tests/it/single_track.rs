//! The single-track model on simulated drives of known cars.

use crate::known::limit_drive::LimitDrive;
use steerwright_sysid::Error;
use steerwright_sysid::single_track::{
    Drive, DriveSegment, Parameter, Prior, Scale, SingleTrack, SingleTrackModel,
    SingleTrackOptions, VehicleOptions, identify_single_track,
};

/// A car that is not the priors' mean.
fn car() -> SingleTrackModel {
    SingleTrackModel::default()
        .with(Parameter::StiffnessFront, 11.0)
        .with(Parameter::StiffnessRear, 16.0)
        .with(Parameter::FrictionFront, 0.85)
        .with(Parameter::FrictionBalance, 1.2)
        .with(Parameter::Wheelbase, 2.9)
        .with(Parameter::FrontShare, 0.54)
        .with(Parameter::DynamicIndex, 0.9)
        .with(Parameter::Lag, 0.05)
        .with(Parameter::Delay, 0.03)
        .with(Parameter::SteeringOffset, 0.006)
        .with(Parameter::YawRateOffset, -0.004)
}

fn identified(drive: &LimitDrive) -> SingleTrack {
    let validation = LimitDrive { seed: drive.seed + 100, ..drive.clone() };
    let [drive, validation] = [drive, &validation].map(|d| d.record().unwrap());
    identify_single_track(&drive, Some(&validation), &SingleTrackOptions::default()).unwrap()
}

#[test]
fn simulations_agree_with_an_independent_one() {
    let quick = car().with(Parameter::Lag, 0.002).with(Parameter::CurvatureFactor, -0.5);
    for car in [SingleTrackModel::default(), car(), quick] {
        let quiet = LimitDrive { noise: [0.0; 3], grip_used: 0.9, ..LimitDrive::new(car, 2) };
        let fit = car.validate(&quiet.record().unwrap()).unwrap();
        assert!(fit.yaw_rate > 99.8, "{fit:?}");
        assert!(fit.sideslip_rms_error_rad.unwrap() < 2e-4, "{fit:?}");
    }
}

#[test]
fn parameters_of_a_known_car_are_recovered() {
    let car = car();
    let found = identified(&LimitDrive::new(car, 1));
    for (parameter, within) in [
        (Parameter::StiffnessFront, 0.03),
        (Parameter::StiffnessRear, 0.03),
        (Parameter::FrictionFront, 0.03),
        (Parameter::FrictionBalance, 0.03),
        (Parameter::Wheelbase, 0.02),
        (Parameter::DynamicIndex, 0.05),
    ] {
        let p = found.parameter(parameter);
        let error = p.value / car.get(parameter) - 1.0;
        assert!(error.abs() < within, "{parameter:?}: {} {error}", p.value);
        assert!(p.is_determined, "{p:?}");
    }
    for p in &found.parameters {
        let score = (p.value - car.get(p.parameter)).abs() / p.standard_error.max(1e-12);
        assert!(p.standard_error == 0.0 || score < 4.5, "{p:?}: {score}");
    }
    let validation = found.validation.unwrap();
    assert!(validation.yaw_rate > 97.0, "{validation:?}");
    // Neither sideslip nor lateral velocity was fitted.
    assert!(validation.sideslip_rms_error_rad.unwrap() < 0.003, "{validation:?}");
    // Yaw rate alone finds what lateral acceleration does not add to.
    let mut drive = LimitDrive::new(car, 1).record().unwrap();
    drive.segments[0].lateral_acceleration_mps2 = None;
    let alone = identify_single_track(&drive, None, &SingleTrackOptions::default()).unwrap();
    let stiffness = alone.parameter(Parameter::StiffnessRear).value;
    assert!((stiffness / 16.0 - 1.0).abs() < 0.1, "{stiffness}");
}

/// A servo that the driver's corrections outrun, and one that they do not.
#[test]
fn a_largest_rate_of_the_road_wheels_is_found_where_the_drive_shows_it() {
    for (rate, seed) in [(0.06, 21), (0.12, 22)] {
        let slow = car().with(Parameter::RateMax, rate);
        let found = identified(&LimitDrive::new(slow, seed));
        for (parameter, value, within) in [
            (Parameter::RateMax, rate, 0.05),
            (Parameter::StiffnessFront, 11.0, 0.04),
            (Parameter::Wheelbase, 2.9, 0.02),
        ] {
            let p = found.parameter(parameter);
            assert!((p.value / value - 1.0).abs() < within && p.is_determined, "{rate}: {p:?}");
            let score = (p.value - value).abs() / p.standard_error;
            assert!(score < 4.5, "{rate}: {p:?}");
        }
        // It is not taken for a lag: 80 ms of lag and delay.
        let lag_s = found.model.get(Parameter::Lag) + found.model.get(Parameter::Delay);
        assert!((0.06..0.1).contains(&lag_s), "{rate}: {lag_s}");
        assert!(found.validation.unwrap().yaw_rate > 97.0, "{rate}: {:?}", found.validation);
        let vehicle = found.model.vehicle(&VehicleOptions::default());
        let written = vehicle.actuator.road_wheel_rate_max_radps;
        assert_eq!(written, found.model.get(Parameter::RateMax));
    }
    for seed in [23, 24] {
        let found = identified(&LimitDrive::new(car(), seed));
        let p = found.parameter(Parameter::RateMax);
        assert!(p.standard_error == 0.0 && !p.is_determined, "{p:?}");
        let written = found.model.vehicle(&VehicleOptions::default());
        assert_eq!(written.actuator.road_wheel_rate_max_radps, 10.0);
    }
}

/// Tyres that relax over 0.4 m, 15 ms at 26 m/s, which the model does not have.
#[test]
fn a_car_whose_tyres_relax_is_followed() {
    for seed in [5, 11] {
        let found = identified(&LimitDrive { relaxation_m: 0.4, ..LimitDrive::new(car(), seed) });
        let validation = found.validation.unwrap();
        let margin = found.spin_margin;
        assert!(validation.yaw_rate > 95.0 && margin >= 0.02, "{validation:?} {margin}");
        // Beyond the 80 ms of the actuator.
        let lag_s = found.model.get(Parameter::Lag) + found.model.get(Parameter::Delay);
        assert!((0.08..0.12).contains(&lag_s), "{lag_s}");
    }
}

/// A twelfth of the grip at almost one speed: no tyre saturates.
#[test]
fn a_gentle_drive_does_not_determine_friction() {
    let gentle =
        LimitDrive { grip_used: 0.08, speed_mps: [19.5, 20.5], ..LimitDrive::new(car(), 3) };
    let found = identified(&gentle);
    for parameter in [
        Parameter::FrictionFront,
        Parameter::FrictionBalance,
        Parameter::ShapeFactor,
        Parameter::CurvatureFactor,
    ] {
        let p = found.parameter(parameter);
        assert!(!p.is_determined && p.posterior_per_prior > 0.6, "{p:?}");
    }
    for parameter in [Parameter::StiffnessFront, Parameter::StiffnessRear, Parameter::Wheelbase] {
        assert!(found.parameter(parameter).is_determined, "{parameter:?}");
    }
    assert!(found.validation.unwrap().yaw_rate > 85.0, "{:?}", found.validation);
}

/// The priors' mean, from which the search starts, has a rear axle of less grip than the front's and half
/// the grip of the car: it spins on this drive.
#[test]
fn an_initial_estimate_that_spins_does_not_ruin_the_estimate() {
    let car = car();
    let drive = LimitDrive::new(car, 4).record().unwrap();
    let prior = |parameter: Parameter, mean: f64, deviation: f64| {
        (parameter, Prior { mean, standard_deviation: deviation, ..parameter.default_prior() })
    };
    let priors = vec![
        prior(Parameter::FrictionBalance, 0.92, 0.3),
        prior(Parameter::FrictionFront, 0.45, 0.5),
        prior(Parameter::StiffnessFront, 25.0, 0.7),
        prior(Parameter::StiffnessRear, 12.0, 0.7),
    ];
    let spinning = priors.iter().fold(SingleTrackModel::default(), |model, (parameter, prior)| {
        model.with(*parameter, prior.mean)
    });
    let before = spinning.validate(&drive).unwrap();
    assert!(before.yaw_rate < 0.0 && before.worst_window_radps > 0.5, "{before:?}");
    let options = SingleTrackOptions { priors, ..SingleTrackOptions::default() };
    let found = identify_single_track(&drive, None, &options).unwrap();
    assert!(found.estimation.yaw_rate > 97.0, "{:?}", found.estimation);
    let friction = found.parameter(Parameter::FrictionFront).value;
    assert!((friction / 0.85 - 1.0).abs() < 0.05, "{friction}");
}

/// The priors have a rear axle with less grip than the car's, and the estimation data do not reach its limit.
#[test]
fn of_equal_estimates_the_one_far_from_a_spin_is_delivered() {
    let car = car();
    let [estimation, validation] = [(4, 0.4), (104, 0.95)]
        .map(|(seed, grip_used)| LimitDrive { grip_used, ..LimitDrive::new(car, seed) })
        .map(|drive| drive.record().unwrap());
    let balance = Parameter::FrictionBalance;
    let prior = |parameter: Parameter, mean, standard_deviation| {
        (parameter, Prior { mean, standard_deviation, ..parameter.default_prior() })
    };
    let priors = vec![prior(balance, 1.05, 0.05), prior(Parameter::FrictionFront, 0.78, 0.05)];
    let options = SingleTrackOptions { priors, ..SingleTrackOptions::default() };
    let found = identify_single_track(&estimation, Some(&validation), &options).unwrap();
    // The estimate of least cost is in the middle of its band.
    let least = found.parameters.iter().fold(found.model, |model, p| {
        let [low, high] = p.band_95;
        let middle = match p.parameter.scale() {
            Scale::Linear => 0.5 * (low + high),
            Scale::Logarithmic => (low * high).sqrt(),
        };
        model.with(p.parameter, middle)
    });
    let reduced = |model: SingleTrackModel| {
        let rear = model.get(balance) * (1.0 - found.spin_margin);
        let model = model.with(balance, rear);
        [&estimation, &validation].map(|d| model.validate(d).unwrap().yaw_rate)
    };
    let (least, delivered) = (reduced(least), reduced(found.model));
    assert!(delivered.iter().all(|fit| *fit > 80.0), "{delivered:?}");
    assert!(
        least.iter().any(|fit| *fit < 0.0),
        "{least:?} {} {:?}",
        found.spin_margin,
        found.parameter(balance)
    );
    assert!(found.validation.unwrap().yaw_rate > 97.0, "{:?}", found.validation);
}

#[test]
fn a_stated_wheelbase_identifies_the_steering_ratio() {
    let car = car().with(Parameter::SteeringFactor, 1.0 / 1.1);
    let drive = LimitDrive::new(car, 6).record().unwrap();
    let options = SingleTrackOptions { wheelbase_m: Some(2.9), ..SingleTrackOptions::default() };
    let found = identify_single_track(&drive, None, &options).unwrap();
    assert_eq!(found.model.get(Parameter::Wheelbase), 2.9);
    let factor = found.parameter(Parameter::SteeringFactor);
    assert!((1.1 * factor.value - 1.0).abs() < 0.03, "{factor:?}");
    assert_eq!(found.correlation(Parameter::Wheelbase, Parameter::Lag), 0.0);
}

#[test]
fn signals_that_are_no_drive_are_refused() {
    let segment = DriveSegment {
        steering_rad: vec![0.0; 100],
        speed_mps: vec![20.0; 100],
        yaw_rate_radps: vec![0.0; 100],
        ..DriveSegment::default()
    };
    let drive = |segment: DriveSegment| Drive {
        sample_time_s: 0.01,
        steering_ratio: 1.0,
        steering_delay_s: 0.0,
        segments: vec![segment],
    };
    let refused =
        |d: Drive| identify_single_track(&d, None, &SingleTrackOptions::default()).unwrap_err();
    let short = DriveSegment { speed_mps: vec![20.0; 99], ..segment.clone() };
    assert!(matches!(refused(drive(short)), Error::Data { .. }));
    let backwards = DriveSegment { speed_mps: vec![-1.0; 100], ..segment.clone() };
    assert!(matches!(refused(drive(backwards)), Error::Data { .. }));
    let broken = DriveSegment { steering_rad: vec![f64::NAN; 100], ..segment.clone() };
    assert!(matches!(refused(drive(broken)), Error::Data { .. }));
    let empty = Drive { segments: Vec::new(), ..drive(segment.clone()) };
    assert!(matches!(refused(empty), Error::TooFewSamples { .. }));
    let still = Drive { sample_time_s: 0.0, ..drive(segment) };
    assert!(matches!(refused(still), Error::Option { .. }));
}
