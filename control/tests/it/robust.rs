//! One set of gains for many plants, more requirements, and the diagnosis of those that are infeasible.

use crate::common::{car, designed, identified_car, options as usual, source, transfer};
use steerwright_control::{
    DesignOptions, DesignPlant, Error, RobustOptions, design, evaluate, step_metrics,
};
use steerwright_formats::{
    Bicycle, BicycleEvidence, Document, EstimationFocus, Matrix, Pid, Plant, Requirement,
    Specification, Uncertainty, VehicleDirection,
};

/// A car whose every entry of A, B and C is uncertain by some percent.
fn uncertain() -> Plant {
    let mut plant = identified_car();
    let n = plant.order();
    let entries = n * n + 3 * n + 1;
    let nominal: Vec<f64> = [&plant.discrete.a, &plant.discrete.b]
        .into_iter()
        .flat_map(|m| m.0.iter().flatten().copied())
        .collect();
    let row = |moved: usize| {
        let share = if moved < n * n { 0.002 } else { 0.02 };
        (0..entries).map(|k| if k == moved { share * nominal[k] } else { 0.0 }).collect()
    };
    let moved = (0..nominal.len()).filter(|k| nominal[*k].abs() > 1e-6);
    plant.uncertainty = Some(Uncertainty {
        open_hold_s: None,
        focus: EstimationFocus::Simulation,
        poles: Vec::new(),
        steady_state_gain: None,
        frequency_response: Vec::new(),
        step_response: Vec::new(),
        directions: Matrix(moved.map(row).collect()),
    });
    plant
}

/// The loop hardly depends on the starting points, whether it is designed on several plants or on the nominal
/// one alone, and whether the requirements are kept or out of reach. No plants are drawn, since they
/// would depend on the seed, too.
#[test]
fn the_loop_hardly_depends_on_the_seed() {
    let plant = DesignPlant::from_plant(&identified_car()).expect("a plant");
    let limited = DesignOptions { max_rate_radps: Some(0.4), ..usual() };
    let alone = DesignOptions { robust: None, ..usual() };
    let mut too_soon = alone;
    too_soon.requirements.settling_time_s = Some(0.1);
    for options in [limited, alone, too_soon] {
        let reached = |seed| {
            let evidence = designed(&plant, &DesignOptions { seed, ..options }).evidence;
            (evidence.step.settling_time_s.expect("it settles"), evidence.margins.modulus_margin)
        };
        let all: Vec<_> = (5..=8).map(reached).collect();
        let spread = |of: fn(&(f64, f64)) -> f64| {
            let values = all.iter().map(of);
            values.clone().fold(0.0, f64::max) / values.fold(f64::INFINITY, f64::min)
        };
        assert!(spread(|r| r.0) < 1.02 && spread(|r| r.1) < 1.02, "{all:?}");
    }
}

/// Plants drawn with other random numbers than those of the design keep what the evidence states.
#[test]
fn all_drawn_plants_keep_the_requirements() {
    let file = uncertain();
    let plant = DesignPlant::from_plant(&file).expect("a plant");
    let pid = designed(&plant, &usual());
    let robust = pid.evidence.robustness.as_ref().expect("robustness");
    assert!(pid.evidence.met && robust.met && robust.members == 100, "{robust:?}");
    let n = plant.ensemble_dimension();
    let (mut kept, mut different) = (0, 0.0_f64);
    for k in 0..40_u64 {
        let xi: Vec<f64> = (0..n as u64)
            .map(|i| steerwright_models::noise::gaussian(4242, k * n as u64 + i))
            .collect();
        let Some(member) = plant.member(&xi) else { continue };
        different = different.max((member.gain() / plant.gain() - 1.0).abs());
        kept += usize::from(evaluate(&member, &pid).expect("evidence").met);
    }
    assert!(different > 0.02, "the ensemble is no ensemble: {different}");
    assert!(kept >= 39, "{kept} of 40");
    // The gains of the nominal design alone are not evaluated on them.
    let alone = designed(&plant, &DesignOptions { robust: None, ..usual() });
    assert!(alone.evidence.robustness.is_none());
    assert_ne!(alone.gains, pid.gains);
}

/// Requirements are kept within a latency of ±30 ms, and break where the evidence states.
#[test]
fn the_latency_at_which_requirements_break_is_reported() {
    let plant = DesignPlant::from_plant(&identified_car()).expect("a plant");
    let robust = Some(RobustOptions { latency_s: 0.03, ..RobustOptions::default() });
    let options = DesignOptions { loop_delay_s: 0.04, robust, ..usual() };
    let pid = designed(&plant, &options);
    let robust = pid.evidence.robustness.as_ref().expect("robustness");
    assert!(robust.met, "{robust:?}");
    assert!((robust.loop_delay_range_s[1] - 0.07).abs() < 1e-12);
    let mut reported = 0;
    for b in &robust.latency {
        let requirement = Requirement::from_name(&b.requirement).expect("a known name");
        let Some(above) = b.above else { continue };
        assert!(above > 0.07 - 1e-3, "{b:?}");
        let required = requirement.required(&pid.specification).expect("required");
        // By the exact evidence at another delay, not by the grid of the search.
        let met = |delay: f64| {
            let mut late = pid.clone();
            late.designed_for.loop_delay_s = delay;
            late.designed_for.path_delay_s = delay;
            let e = evaluate(&plant, &late).expect("evidence");
            !e.shortfalls.iter().any(|s| s.requirement == b.requirement)
        };
        assert!(met(above - 0.003) && !met(above + 0.003), "{b:?}, {required}");
        reported += 1;
    }
    assert!(reported >= 3, "{:?}", robust.latency);
}

/// Eq 13 holds at any speed: an identified one is evaluated at ±20 %.
#[test]
fn an_identified_bicycle_is_evaluated_at_other_speeds() {
    let mut bicycle = car(1.0);
    let data_only = DesignPlant::from_bicycle(&bicycle).expect("a plant");
    assert!(!data_only.is_speed_scheduled());
    let file = data_only.at_speed(12.0).expect("another speed").document().expect("a document");
    let moved = Bicycle::from_json(&file, "bicycle.json").expect("eq 13 at its speed");
    assert_eq!(moved.vehicle.speed_mps, 12.0);
    bicycle.evidence = Some(BicycleEvidence::default());
    let plant = DesignPlant::from_bicycle(&bicycle).expect("a plant");
    let pid = designed(&plant, &usual());
    let robust = pid.evidence.robustness.as_ref().expect("robustness");
    let [low, high] = robust.speed_range_mps.expect("a range");
    assert!((low - 12.0).abs() < 1e-9 && (high - 18.0).abs() < 1e-9);
    assert!(robust.met, "{:?}", robust.requirements);
    for speed in [low, high] {
        let other = plant.at_speed(speed).expect("another speed");
        assert!(evaluate(&other, &pid).expect("evidence").met, "{speed}");
    }
    assert!(!robust.speed.is_empty());
    let error = DesignPlant::from_plant(&identified_car()).expect("a plant").at_speed(12.0);
    assert!(matches!(error, Err(Error::NotScheduled { .. })));
}

/// And over its uncertainty: here a lag and a yaw inertia known to some percent.
#[test]
fn an_identified_bicycle_is_evaluated_over_its_uncertainty() {
    let mut bicycle = car(1.0);
    let none = VehicleDirection::default();
    let directions = vec![
        VehicleDirection { actuator_time_constant: 0.2, ..none },
        VehicleDirection { yaw_inertia: 0.05, cornering_stiffness_front: -0.05, ..none },
    ];
    bicycle.evidence = Some(BicycleEvidence { directions, ..BicycleEvidence::default() });
    let plant = DesignPlant::from_bicycle(&bicycle).expect("a plant");
    assert_eq!(plant.ensemble_dimension(), 2);
    // Slower by its lag, and no more than that: eq 13 itself.
    let slower = plant.member(&[1.0, 0.0]).expect("a plant");
    let mut changed = bicycle.clone();
    changed.vehicle.actuator_time_constant_s *= 0.2_f64.exp();
    let expected = DesignPlant::from_bicycle(&changed).expect("a plant");
    let pid = designed(&plant, &usual());
    let of = |pid: &Pid, plant: &DesignPlant| evaluate(plant, pid).expect("evidence");
    let robust = pid.evidence.robustness.as_ref().expect("robustness");
    assert!(robust.met && robust.members == 100, "{robust:?}");
    let (same, late) = (of(&pid, &expected), of(&pid, &slower));
    let off = same.margins.modulus_margin - late.margins.modulus_margin;
    assert!(off.abs() < 1e-9, "{off}");
    let kept = (0..40_u64).filter(|k| {
        let xi = [0, 1].map(|i| steerwright_models::noise::gaussian(4242, 2 * k + i));
        plant.member(&xi).is_some_and(|member| of(&pid, &member).met)
    });
    let kept = kept.count();
    assert!(kept >= 39, "{kept} of 40");
}

#[test]
fn each_requirement_is_kept_or_named() {
    let plant = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
    let requirements = Specification {
        rise_time_s: Some(0.5),
        integral_absolute_error_s: Some(0.4),
        gain_margin_db: Some(10.0),
        phase_margin_deg: Some(55.0),
        delay_margin_s: Some(0.1),
        disk_margin: Some(0.9),
        ..Specification::none()
    };
    let options = DesignOptions { requirements, robust: None, ..usual() };
    let e = designed(&plant, &options).evidence;
    assert!(e.met, "{:?}", e.shortfalls);
    assert!(e.step.rise_time_s.expect("it rises") <= 0.5);
    assert!(e.step.integral_absolute_error_s <= 0.4);
    assert!(e.margins.gain_margin_db.is_none_or(|m| m >= 10.0));
    assert!(e.margins.phase_margin_deg.is_none_or(|m| m >= 55.0));
    assert!(e.margins.delay_margin_s.is_none_or(|m| m >= 0.1));
    assert!(e.margins.disk_margin.expect("a disk margin") >= 0.9);
    // A specification may be empty.
    let free = DesignOptions { requirements: Specification::none(), ..options };
    assert!(designed(&plant, &free).evidence.met);
}

#[test]
fn an_infeasible_requirement_is_diagnosed() {
    let plant = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
    let with = |change: &dyn Fn(&mut DesignOptions)| {
        let mut options = DesignOptions { robust: None, ..usual() };
        change(&mut options);
        let e = designed(&plant, &options).evidence;
        assert!(!e.met && !e.advice.is_empty(), "{e:?}");
        e.advice.join("; ")
    };
    let rate = with(&|o| o.max_rate_radps = Some(0.05));
    assert!(rate.contains("settling time of 1 s is out of reach"), "{rate}");
    assert!(rate.contains("the limit of the steering rate, 3°/s, prevents it"), "{rate}");
    let angle = with(&|o| o.max_angle_rad = Some(0.009));
    assert!(angle.contains("the limit of the steering angle, 0.5°, prevents it"), "{angle}");
    // A zero at +2 rad/s.
    let wrong = transfer(&[-6.0, 12.0], &[5.0, 6.0], 0.1);
    let words = designed(&wrong, &usual()).evidence.advice.join("; ");
    assert!(words.contains("right half-plane at 2.00 rad/s"), "{words}");
    assert!(words.contains("below about 1.00 rad/s"), "{words}");
}

/// With gains that no limit touches, linear theory and the loop with the real PID are one.
#[test]
fn linear_theory_and_the_sampled_loop_agree() {
    for (plant, delay) in [
        (DesignPlant::from_bicycle(&car(1.0)).expect("a plant"), 0.0),
        (transfer(&[40.0], &[8.0], 0.05), 0.013),
    ] {
        let options = DesignOptions { loop_delay_s: delay, robust: None, ..usual() };
        let pid = designed(&plant, &options);
        let (e, linear) = (&pid.evidence, pid.evidence.without_limits.expect("linear theory"));
        assert!((e.step.overshoot_percent - linear.overshoot_percent).abs() < 1e-6);
        let settling = |m: steerwright_formats::StepMetrics| m.settling_time_s.expect("it settles");
        assert!((settling(e.step) - settling(linear)).abs() < 1e-6);
        assert_eq!(step_metrics(&plant, &pid, delay).expect("metrics"), e.step);
        let later = step_metrics(&plant, &pid, delay + 0.01).expect("metrics");
        assert!(later.overshoot_percent > e.step.overshoot_percent);
    }
}

/// Where only the nominal plant keeps a settling time, the advice states one that all could keep, and all keep
/// that one when it is required.
#[test]
fn the_settling_time_that_all_plants_could_keep_is_reported() {
    let plant = DesignPlant::from_plant(&identified_car()).expect("a plant");
    let robust = Some(RobustOptions { latency_s: 0.03, ..RobustOptions::default() });
    let mut options = DesignOptions { loop_delay_s: 0.06, robust, ..usual() };
    options.requirements.settling_time_s = Some(0.7);
    let e = designed(&plant, &options).evidence;
    assert!(e.met && !e.robustness.expect("robustness").met, "{:?}", e.step);
    let words = e.advice.join("; ");
    let (_, rest) = words.split_once("could keep a settling time of ").expect("a sentence");
    let settling: f64 = rest.split(' ').next().expect("a time").parse().expect("a number");
    assert!(settling > 0.7 && settling < 1.2, "{words}");
    options.requirements.settling_time_s = Some(settling);
    let e = designed(&plant, &options).evidence;
    assert!(e.met && e.robustness.expect("robustness").met, "{:?}", e.step);
}

/// Without a drive the rate of the actuator is unknown.
#[test]
fn a_data_sheet_needs_the_rate_of_its_steering() {
    let plant = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
    let error = design(&plant, &source(), &DesignOptions::default()).expect_err("refused");
    assert_eq!(error, Error::NoSteeringRate { model: "car".into() });
    assert!(error.hint().contains("rate of the steering"), "{}", error.hint());
}

/// A step that steers faster than the drive is reported.
#[test]
fn a_step_beyond_the_drive_is_reported() {
    let words = |angle: f64, rate: f64, max_rate_radps: Option<f64>| {
        let mut plant = identified_car();
        plant.evidence.excitation.largest_steering_rad = Some(angle);
        plant.evidence.excitation.largest_steering_rate_radps = Some(rate);
        let plant = DesignPlant::from_plant(&plant).expect("a plant");
        let options = DesignOptions { max_rate_radps, robust: None, ..usual() };
        designed(&plant, &options).evidence.advice.join("; ")
    };
    let gentle = words(0.04, 0.3, Some(1e3));
    assert!(gentle.contains("no more than 17°/s") && gentle.contains("state the rate"), "{gentle}");
    assert!(gentle.contains("no more than 2.3°"), "{gentle}");
    assert_eq!(words(0.5, 5.0, Some(1e3)), "");
    assert_eq!(words(0.5, 0.3, Some(0.4)), "");
    // What no one states is twice what was driven.
    let assumed = words(0.5, 0.3, None);
    assert!(assumed.contains("designed for 34°/s, twice the fastest"), "{assumed}");
    assert!(!assumed.contains("state the rate"), "{assumed}");
}
