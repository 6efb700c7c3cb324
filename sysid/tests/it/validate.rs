//! A model validated on a drive: the truth fits, a wrong one less, and an identified one gets the
//! figures of its identification. Sensors with offsets and drifts.

use crate::common;
use crate::drives::quick;
use crate::known::Random;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{Continuous, Matrix};
use steerwright_sysid::model::conversion::discretize;
use steerwright_sysid::{
    Detrend, Error, Identified, IdentifyOptions, InputKind, ValidationData, identify, validate,
    validate_plant,
};

/// [`common::vehicle`], whose steering acts by `gain`.
fn vehicle(gain: f64) -> Continuous {
    let (f, g) = common::vehicle(12.0 * gain);
    Continuous {
        f: Matrix::from_fn(3, 3, |i, j| f[(i, j)]),
        g: Matrix::from_fn(3, 1, |i, _| g[(i, 0)]),
        h: Matrix::from_fn(1, 3, |_, j| if j == 1 { 1.0 } else { 0.0 }),
    }
}

const SAMPLE_TIME: f64 = 0.04;
const STEERING_OFFSET: f64 = 0.05;
const GYRO_BIAS: f64 = -0.2;

/// A drive of `vehicle(1.0)`, with a steering offset and a biased gyro, that starts in a turn; the
/// second part is driven harder than the first.
fn drive(noise: f64) -> DriveLog {
    let (f, g) = common::vehicle(12.0);
    let (a, b) = discretize(f.as_ref(), g.as_ref(), SAMPLE_TIME);
    let mut random = Random(31);
    let mut x = [0.3, 0.2, 0.02];
    let (mut input, mut output, mut level) = (Vec::new(), Vec::new(), 0.0);
    for k in 0..2000 {
        if k % 15 == 0 {
            level = (if k < 1000 { 0.02 } else { 0.03 }) * random.normal();
        }
        input.push(level + STEERING_OFFSET);
        output.push(x[1] + GYRO_BIAS + noise * random.normal());
        x = std::array::from_fn(|i| {
            (0..3).map(|j| a[(i, j)] * x[j]).sum::<f64>() + b[(i, 0)] * level
        });
    }
    DriveLog { speed: Some(vec![20.0; 2000]), ..common::recording(SAMPLE_TIME, input, output) }
}

fn options(hold_out: f64) -> IdentifyOptions {
    IdentifyOptions {
        validation: ValidationData { fraction: hold_out, ..ValidationData::default() },
        ..quick(3)
    }
}

/// An output offset of its own on the estimation data makes up for what the means of input and output
/// leave, on the validation data too.
#[test]
fn the_truth_fits_and_a_wrong_model_less() {
    let log = drive(0.0);
    let of = |gain: f64| validate(&log, &options(0.4), &vehicle(gain)).unwrap();
    let right = of(1.0);
    println!("{} {}", right.estimation_fit, right.validation_fit);
    assert!(right.estimation_fit > 100.0 - 1e-6 && right.validation_fit > 100.0 - 1e-6);
    assert_eq!(right.simulated_yaw_rate_radps.len(), log.len());
    for gain in [0.8, 1.2] {
        let wrong = of(gain);
        // A gain off by 20 % leaves 20 % of the yaw rate, less what the initial state makes up for.
        assert!((75.0..85.0).contains(&wrong.validation_fit), "{gain}: {}", wrong.validation_fit);
        assert!((75.0..85.0).contains(&wrong.estimation_fit), "{gain}: {}", wrong.estimation_fit);
    }
    assert!(of(-1.0).validation_fit < 0.0);
}

#[test]
fn an_identified_model_gets_the_figures_of_its_identification() {
    let log = drive(5e-3);
    for hold_out in [0.3, 0.5] {
        let options = options(hold_out);
        let found = identify(&log, &options).unwrap();
        let validated = validate(&log, &options, found.plant.continuous.as_ref().unwrap()).unwrap();
        let fit = &found.plant.evidence.fit;
        let apart =
            [fit.estimation - validated.estimation_fit, fit.validation - validated.validation_fit];
        println!("{fit:?} apart {apart:?}");
        assert!(fit.validation > 95.0 && fit.validation < 99.9, "{fit:?}");
        // The identification refines the initial state of the estimation part over all of it.
        assert!(apart[0].abs() < 1e-4 && apart[1].abs() < 1e-6, "{apart:?}");
        let traces = found.traces.simulated_yaw_rate_radps.iter();
        let worst = traces
            .zip(&validated.simulated_yaw_rate_radps)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-4, "{worst}");
        // A steering angle drives it, whatever the other model was identified with.
        let product = IdentifyOptions { input_kind: InputKind::SteeringTimesSpeed, ..options };
        let model = found.plant.continuous.as_ref().unwrap();
        assert_eq!(validate(&log, &product, model).unwrap(), validated);
    }
}

#[test]
fn matrices_that_do_not_fit_each_other_are_refused() {
    let good = vehicle(1.0);
    for bad in [
        Continuous { g: Matrix::from_fn(2, 1, |_, _| 1.0), ..good.clone() },
        Continuous { h: Matrix::from_fn(1, 2, |_, _| 1.0), ..good.clone() },
        Continuous { f: Matrix::from_fn(3, 2, |_, _| 1.0), ..good.clone() },
    ] {
        let error = validate(&drive(0.0), &options(0.5), &bad);
        assert!(matches!(error, Err(Error::NoModel { .. })), "{error:?}");
    }
}

/// From its file alone: with its delay, its direct gain, what drives it, and on samples that are not
/// its own.
#[test]
fn a_plant_gets_the_figures_of_its_identification_from_its_file() {
    let log = drive(5e-3);
    for (delay_s, feedthrough, input_kind) in [
        (0.0, false, InputKind::Steering),
        (0.05, false, InputKind::Steering),
        (0.0, true, InputKind::Steering),
        (0.04, false, InputKind::SteeringTimesSpeed),
    ] {
        let options = IdentifyOptions {
            delay_s: Some(delay_s),
            feedthrough: Some(feedthrough),
            input_kind,
            ..options(0.4)
        };
        let plant = identify(&log, &options).unwrap().plant;
        assert_eq!(plant.input_delay_s, delay_s);
        // The delay in the plant goes before the options.
        let validated = validate_plant(
            &log,
            &IdentifyOptions {
                validation: ValidationData { fraction: 0.4, ..ValidationData::default() },
                ..IdentifyOptions::default()
            },
            &plant,
        )
        .unwrap();
        let fit = &plant.evidence.fit;
        assert!((fit.validation - validated.validation_fit).abs() < 1e-6, "{fit:?} {validated:?}");
        assert_eq!(validated.first_validation_sample, 1200);
    }
    // On every second sample, the driving angle held over both.
    let options = IdentifyOptions { delay_s: Some(0.0), ..options(0.5) };
    let mut plant = identify(&log, &options).unwrap().plant;
    let mut half = log.clone();
    half.sample_time_s *= 2.0;
    half.segments[0].range = 0..1000;
    for signal in [&mut half.input, &mut half.output, half.speed.as_mut().unwrap()] {
        *signal = signal.iter().copied().step_by(2).collect();
    }
    // The steps last 15 samples, so some begin on a sample that is left out.
    let fit = validate_plant(&half, &options, &plant).unwrap().validation_fit;
    assert!((80.0..99.0).contains(&fit), "{fit}");
    plant.continuous = None;
    let error = validate_plant(&half, &options, &plant).unwrap_err();
    assert!(matches!(error, Error::NoModel { .. }), "{error}");
}

/// A drift of the gyro's zero: with lines taken out the model is the same
/// as without drift, and the traces show the drift again; with means it is not followed.
#[test]
fn a_drift_is_taken_out_by_lines_and_by_nothing_else() {
    let straight = drive(0.003);
    let mut drifting = straight.clone();
    for k in 0..drifting.len() {
        let t = k as f64 * SAMPLE_TIME;
        drifting.output[k] += 0.004 * t - 0.1;
    }
    let of = |log: &DriveLog, detrend: Detrend| {
        let auto = IdentifyOptions { delay_s: Some(0.0), ..options(0.5) };
        identify(log, &IdentifyOptions { detrend, ..auto }).unwrap()
    };
    let (with, without) = (of(&drifting, Detrend::Linear), of(&straight, Detrend::Linear));
    let (a, b) = (&with.plant.evidence.fit, &without.plant.evidence.fit);
    assert!((a.validation - b.validation).abs() < 1e-8, "{a:?} {b:?}");
    assert!((a.estimation - b.estimation).abs() < 1e-8, "{a:?} {b:?}");
    let response = |of: &Identified| {
        let points = &of.plant.uncertainty.as_ref().unwrap().frequency_response;
        points.iter().map(|p| p.magnitude).collect::<Vec<_>>()
    };
    for (a, b) in response(&with).iter().zip(response(&without)) {
        assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
    }
    // Where there is no drift, lines take what is slow in the response for one.
    let means = of(&straight, Detrend::Mean).plant.evidence.fit;
    let cost = means.validation - b.validation;
    assert!((0.0..1.5).contains(&cost), "{means:?} {b:?}");
    assert!(of(&drifting, Detrend::Mean).plant.evidence.fit.validation < b.validation - 5.0);
    let traces = &with.traces;
    let off = traces.simulated_yaw_rate_radps.iter().zip(&drifting.output);
    let worst = off.map(|(s, y)| (s - y).abs()).fold(0.0, f64::max);
    assert!(worst < 0.06, "{worst}");
}
