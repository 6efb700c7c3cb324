//! Whole drives: the multi-body vehicle, a weakly excited city drive, and data built to make subspace
//! estimates unstable.

use crate::common::{data, multibody, recording};
use crate::known::Random;
use faer::Mat;
use faer::linalg::solvers::Solve;
use steerwright_drivelog::{DriveLog, LogOptions, read_log};
use steerwright_formats::{Document, Plant};
use steerwright_sysid::subspace::Realization;
use steerwright_sysid::{
    Error, IdentifyOptions, InputKind, Method, ValidationData, Weighting, identify,
};

/// One order, weighting and horizon, where a test is not about their choice.
pub(crate) fn quick(order: usize) -> IdentifyOptions {
    IdentifyOptions {
        order: Some(order),
        method: Some(Weighting::Moesp.into()),
        horizon: Some(15),
        ..IdentifyOptions::default()
    }
}

#[test]
fn the_multi_body_vehicle_is_reproduced_on_the_validation_half() {
    let log = multibody();
    let found = identify(&log, &IdentifyOptions::default()).unwrap();
    let e = &found.plant.evidence;
    // What the sensor's noise leaves is 98.4 % at 100 Hz.
    assert!(e.fit.validation > 98.0, "{:?}", e.fit);
    assert!(e.fit.validation_one_step >= e.fit.validation - 0.5);
    assert!(found.plant.quality.allows_design(), "{:?}", found.plant.quality);
    assert!(e.excitation.informative_up_to_hz > 1.5);
    assert!(e.conversion_round_trip.unwrap() < 1e-10);
    assert!((found.plant.operating_point.speed_mps - 15.0).abs() < 0.05);
    // Driven straight at zero: the offset is the sensors' bias, which is none.
    assert!(found.plant.operating_point.steering_offset_rad.abs() < 2e-4);
    // Steady-state gain of the data sheet's car: V/(L + K_us V²) is near 4 to 6 at 15 m/s.
    let c = found.plant.continuous.as_ref().unwrap();
    let n = found.plant.order();
    let f = Mat::from_fn(n, n, |i, j| -c.f.entry(i, j));
    let g = Mat::from_fn(n, 1, |i, _| c.g.entry(i, 0));
    let x = f.partial_piv_lu().solve(&g);
    let gain: f64 = (0..n).map(|i| c.h.entry(0, i) * x[(i, 0)]).sum();
    assert!((4.0..6.5).contains(&gain), "{gain}");
    // The file reads back as it was written.
    let text = found.plant.to_json();
    assert_eq!(Plant::from_json(&text, "plant.json").unwrap(), found.plant);
    let traces = &found.traces;
    assert!(traces.time_s.len() == log.len() && traces.simulated_yaw_rad.len() == log.len());
    assert_eq!(traces.is_validation.iter().filter(|v| **v).count(), e.validation_samples);
}

#[test]
fn equal_input_leads_to_equal_bytes() {
    let log = multibody();
    let options = quick(3);
    let text = || identify(&log, &options).unwrap().plant.to_json();
    assert_eq!(text(), text());
}

#[test]
fn every_method_order_and_feedthrough_leads_to_a_valid_stable_plant() {
    let log = multibody();
    for method in Weighting::ALL {
        for (order, feedthrough, refine) in [(1, false, false), (3, true, true), (8, true, false)] {
            let options = IdentifyOptions {
                method: Some(method.into()),
                order: Some(order),
                horizon: Some(12),
                feedthrough: Some(feedthrough),
                refine,
                input_kind: InputKind::SteeringTimesSpeed,
                ..IdentifyOptions::default()
            };
            let plant = identify(&log, &options).unwrap().plant;
            assert_eq!(
                (plant.order(), plant.evidence.method.as_str()),
                (order, Method::from(method).name())
            );
            assert!(plant.evidence.fit.validation > 85.0, "{method:?} {order}");
            assert_eq!(plant.discrete.d.entry(0, 0) == 0.0, !feedthrough);
        }
    }
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn eq_12_and_the_shift_structure_compete_by_fit() {
    let log = multibody();
    let mut won = std::collections::BTreeMap::new();
    for method in Weighting::ALL {
        for order in 1..=4 {
            let fit = |realization: Option<Realization>| {
                let options = IdentifyOptions {
                    method: Some(method.into()),
                    realization,
                    refine: false,
                    ..quick(order)
                };
                let plant = identify(&log, &options).unwrap().plant;
                // Without a requested feedthrough there is none, and B is refitted in both.
                assert_eq!(plant.discrete.d.entry(0, 0), 0.0);
                (plant.evidence.fit.estimation, plant.provenance.options["realization"].clone())
            };
            let (shift, eq12) = (fit(Some(Realization::Shift)), fit(Some(Realization::Eq12)));
            assert_eq!((shift.1.as_str(), eq12.1.as_str()), ("shift", "eq 12"));
            let chosen = fit(None);
            println!("{method:?} {order}: shift {:.3} eq 12 {:.3}", shift.0, eq12.0);
            assert!((shift.0 - eq12.0).abs() > 1e-6, "they are two models");
            // They compete with an output offset, which is left out of the fits where it explains nothing.
            if (shift.0 - eq12.0).abs() > 1e-3 {
                assert_eq!(&chosen, if eq12.0 > shift.0 { &eq12 } else { &shift });
            } else {
                assert!(chosen == eq12 || chosen == shift);
            }
            *won.entry(chosen.1).or_insert(0) += 1;
        }
    }
    assert!(won.len() == 2, "each wins somewhere: {won:?}");
}

#[test]
fn a_weakly_excited_drive_gets_a_model_and_is_called_weak() {
    let names = ["steering_wheel_angle.csv", "gyro.csv", "speed.csv"];
    let files: Vec<(String, Vec<u8>)> =
        names.iter().map(|n| ((*n).to_owned(), data(&format!("comma2k19/{n}")))).collect();
    let mut options = LogOptions {
        input: Some("steering_wheel_angle_deg".into()),
        output: Some("-gyro_down_radps".into()),
        speed: Some("speed_mps".into()),
        ..LogOptions::default()
    };
    assert!(matches!(
        read_log(&files, &options),
        Err(steerwright_drivelog::Error::SteeringRatioUnknown { .. })
    ));
    options.steering_ratio = Some(16.9);
    let log = read_log(&files, &options).unwrap();
    let plant = identify(&log, &IdentifyOptions::default()).unwrap().plant;
    let quality = &plant.quality;
    assert!(
        !quality.allows_design() && quality.summary.starts_with("Weakly excited"),
        "{quality:?}"
    );
    // The fit with its uncertainty, and what to drive in numbers.
    assert!(plant.evidence.held_out.as_ref().unwrap().fit_standard_error.is_some());
    let fit = format!("{:.0} ± ", plant.evidence.fit.validation);
    assert!(plant.evidence.fit.validation > 60.0 || quality.summary.contains(&fit), "{quality:?}");
    let advice = quality.advice.join("; ");
    let remarks = quality.remarks.join("; ");
    assert!(remarks.contains("above 2 Hz there is no information in this log"), "{remarks}");
    assert!(advice.contains("slalom whose rhythm sweeps from 0.2 to 2 Hz, about ±"), "{advice}");
    assert!(plant.evidence.excitation.road_wheel_std_rad < 0.002);
    // Left steering turns left: the axis was mapped with its sign.
    let other = LogOptions { output: Some("gyro_down_radps".into()), ..options };
    let mirrored = read_log(&files, &other).unwrap();
    assert!(log.output.iter().zip(&mirrored.output).all(|(a, b)| (a + b).abs() < 1e-12));
}

/// A first-order yaw response to white steering with white sensor noise; from sample `from` on, the
/// steering acts stronger by `stronger` and the noise is coloured with the pole `noise_pole`.
fn changing_recording(from: usize, stronger: f64, noise_pole: f64) -> DriveLog {
    let mut random = Random(23);
    let n = 3000;
    let (mut x, mut noise) = (0.0, 0.0);
    let (mut input, mut output) = (Vec::new(), Vec::new());
    for k in 0..n {
        let (gain, pole) = if k < from { (1.0, 0.0) } else { (1.0 + stronger, noise_pole) };
        let u = 0.02 * random.normal();
        noise = pole * noise + 2e-3 * random.normal();
        input.push(u);
        output.push(x + noise);
        x = 0.8 * x + gain * u;
    }
    recording(0.04, input, output)
}

#[test]
fn residuals_are_tested_on_data_that_the_model_has_not_seen() {
    let tests = |log: &DriveLog| {
        let e = identify(log, &quick(1)).unwrap().plant.evidence;
        println!("{:?} {:?}", e.whiteness, e.independence);
        (e.whiteness.pass, e.independence.pass)
    };
    let half = 1500;
    assert_eq!(tests(&changing_recording(half, 0.0, 0.0)), (true, true));
    assert_eq!(tests(&changing_recording(half, 0.0, 0.5)), (false, true));
    assert!(!tests(&changing_recording(half, 0.2, 0.0)).1);
}

#[test]
fn the_validation_data_choose_nothing() {
    let log = multibody();
    let plant = |log: &DriveLog| identify(log, &IdentifyOptions::default()).unwrap().plant;
    let mut other = log.clone();
    let half = log.len() - (0.5 * log.len() as f64).round() as usize;
    for (k, y) in other.output.iter_mut().enumerate().skip(half) {
        *y *= if k % 100 < 50 { 0.2 } else { 3.0 };
    }
    let (one, two) = (plant(&log), plant(&other));
    assert_eq!((&one.discrete.a, &one.discrete.b), (&two.discrete.a, &two.discrete.b));
    assert_eq!(one.evidence.fit.estimation, two.evidence.fit.estimation);
    assert!(two.evidence.fit.validation < one.evidence.fit.validation - 20.0);
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn the_result_is_stable_where_the_estimate_is_not() {
    // Growing oscillations, an integrator, a ramp, and pure noise: each alone misleads the shift
    // structure. Whatever is requested, the plant is stable and finite.
    let mut random = Random(5);
    let n = 400;
    let u: Vec<f64> = (0..n).map(|_| 0.02 * random.normal()).collect();
    let mut integral = 0.0;
    let outputs: [Vec<f64>; 4] = [
        (0..n).map(|k| f64::exp(0.004 * k as f64) * (0.5 * k as f64).sin() + u[k]).collect(),
        u.iter()
            .map(|x| {
                integral += x;
                integral
            })
            .collect(),
        (0..n).map(|k| 1e-3 * k as f64 + u[k.saturating_sub(1)]).collect(),
        (0..n).map(|_| random.normal()).collect(),
    ];
    let mut stabilised = std::collections::BTreeMap::new();
    for (case, y) in outputs.into_iter().enumerate() {
        let log = recording(0.04, u.clone(), y);
        for method in Weighting::ALL {
            for order in [1, 3, 8] {
                for (refine, realization) in [
                    (true, None),
                    (false, Some(Realization::Shift)),
                    (false, Some(Realization::Eq12)),
                ] {
                    let options = IdentifyOptions {
                        method: Some(method.into()),
                        realization,
                        order: Some(order),
                        horizon: Some(12),
                        refine,
                        ..IdentifyOptions::default()
                    };
                    let plant = identify(&log, &options).unwrap().plant;
                    let n = plant.order();
                    let a = Mat::from_fn(n, n, |i, j| plant.discrete.a.entry(i, j));
                    let radius =
                        a.eigenvalues().unwrap().iter().map(|z| z.norm()).fold(0.0, f64::max);
                    assert!(radius < 1.0, "case {case} {method:?} {order}: {radius}");
                    let closed = Mat::from_fn(n, n, |i, j| {
                        a[(i, j)] - plant.discrete.k.entry(i, 0) * plant.discrete.c.entry(0, j)
                    });
                    let closed =
                        closed.eigenvalues().unwrap().iter().map(|z| z.norm()).fold(0.0, f64::max);
                    assert!(
                        closed < 1.0,
                        "case {case} {method:?} {order} {refine}: {closed} {radius} {:?}",
                        plant.evidence.warnings
                    );
                    assert!(!plant.quality.allows_design() || case == 1 || case == 2);
                    if plant.evidence.stabilised_from.is_some() {
                        *stabilised.entry(realization).or_insert(0) += 1;
                    }
                }
            }
        }
    }
    println!("{stabilised:?}");
    for realization in Realization::ALL {
        let count = stabilised.get(&Some(realization)).copied().unwrap_or(0);
        assert!(count > 5, "the data were meant to mislead: {stabilised:?}");
    }
}

#[test]
fn options_out_of_range_and_hopeless_recordings_are_errors() {
    let log = multibody();
    let base = IdentifyOptions::default();
    for options in [
        IdentifyOptions { order: Some(0), ..base.clone() },
        IdentifyOptions { order: Some(20), horizon: Some(10), ..base.clone() },
        IdentifyOptions { horizon: Some(1), ..base.clone() },
        IdentifyOptions {
            validation: ValidationData { fraction: 1.0, ..ValidationData::default() },
            ..base.clone()
        },
        IdentifyOptions { max_order: 0, ..base.clone() },
    ] {
        let error = identify(&log, &options).unwrap_err();
        assert!(!error.hint().is_empty(), "{error}");
    }
    let short = recording(0.04, vec![0.0, 1.0], vec![0.0, 1.0]);
    assert!(matches!(identify(&short, &base), Err(Error::TooFewSamples { .. })));
    let still = recording(0.04, vec![0.0; 500], vec![0.1; 500]);
    assert!(matches!(identify(&still, &base), Err(Error::NoModel { .. })));
    let mut broken = log.clone();
    broken.output[100] = f64::NAN;
    assert!(matches!(identify(&broken, &base), Err(Error::NoModel { .. })));
    let product = IdentifyOptions { input_kind: InputKind::SteeringTimesSpeed, ..base };
    assert_eq!(identify(&recording(0.04, log.input, log.output), &product), Err(Error::NoSpeed));
}
