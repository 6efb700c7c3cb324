//! States, derivatives, partial derivatives and dependencies of the plants, each against the
//! others and against differences of the functions themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::common;

use common::{PLAIN, bicycle, get, identified, kinds, nonlinear, set, start, step, variable};
use fmi2_export::model_description::{Causality, DependencyKind, DependsOn, Kind as Type};
use fmi2_export::{CoSimulationUnit, Known, Unknown, VariableId};
use std::fmt::Debug;

/// Numbers between two limits, always the same ones.
fn random() -> impl FnMut(f64, f64) -> f64 {
    let mut state = 1_u64;
    move |low, high| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn rows<S: CoSimulationUnit>(causality: Causality) -> Vec<&'static str> {
    let rows = S::TABLE.variables.iter();
    rows.filter(|r| r.causality == causality && r.kind == Type::Real).map(|r| r.name).collect()
}

fn unknowns<S: CoSimulationUnit>(unit: &S) -> Vec<Unknown<S::Variable>> {
    let n = unit.states().len();
    let outputs =
        rows::<S>(Causality::Output).into_iter().map(|r| Unknown::Variable(variable::<S>(r)));
    outputs.chain((0..n).map(Unknown::Derivative)).chain((0..n).map(Unknown::State)).collect()
}

fn value<S: CoSimulationUnit>(unit: &mut S, unknown: Unknown<S::Variable>) -> f64 {
    match unknown {
        Unknown::Variable(v) => get(unit, v.spec().name),
        Unknown::Derivative(i) => unit.state_derivative(i),
        Unknown::State(i) => unit.state(i),
    }
}

/// What can be varied before the start: Real inputs and parameters, and states, of which those
/// that cannot be set are varied by the parameter they follow.
fn knowns<S: CoSimulationUnit>(unit: &S) -> Vec<(Known<S::Variable>, Change)> {
    let n = unit.states().len();
    let names = rows::<S>(Causality::Input).into_iter().chain(rows::<S>(Causality::Parameter));
    let variables =
        names.map(|name| (Known::Variable(variable::<S>(name)), Change::Variable(name)));
    let pose = ["initial_yaw", "initial_x", "initial_y"];
    let states = (0..n).map(|i| {
        let change = match i.checked_sub(n - 3) {
            Some(k) => Change::Variable(pose[k]),
            None => Change::State(i),
        };
        (Known::State(i), change)
    });
    variables.chain(states).collect()
}

#[derive(Debug, Clone, Copy)]
enum Change {
    Variable(&'static str),
    State(usize),
}

fn vary<S: CoSimulationUnit>(unit: &S, change: Change, by: f64) -> S {
    let mut unit = unit.clone();
    match change {
        Change::Variable(name) => {
            let before = get(&mut unit, name);
            set(&mut unit, name, before + by);
        }
        Change::State(i) => {
            let before = unit.state(i);
            unit.set_state(i, before + by);
        }
    }
    unit
}

/// Random instances in initialization mode.
fn samples<S: CoSimulationUnit>(unit: &S, speeds: &[f64]) -> Vec<S> {
    let mut random = random();
    let n = unit.states().len() - 3;
    speeds
        .iter()
        .map(|&speed| {
            let mut s = unit.clone();
            set(&mut s, "speed", speed);
            set(&mut s, "steering_angle", random(-0.5, 0.5));
            set(&mut s, "initial_yaw", random(-3.0, 3.0));
            set(&mut s, "initial_x", random(-9.0, 9.0));
            (0..n).for_each(|i| s.set_state(i, random(-1.0, 1.0)));
            s
        })
        .collect()
}

/// Partial derivatives against central differences; zero for every value where there is no
/// dependency, and not always zero where there is one; of a constant factor, always the same.
fn check<S: CoSimulationUnit>(unit: &S, label: impl Debug, speeds: &[f64])
where
    S::Variable: Debug,
{
    let samples = samples(unit, speeds);
    for unknown in unknowns(unit) {
        for (known, change) in knowns(unit) {
            let dependency = unit.dependency(unknown, known);
            let place = format!("{label:?}: {unknown:?} by {known:?}, {dependency:?}");
            let mut seen: Vec<f64> = Vec::new();
            for sample in &samples {
                let size = match change {
                    Change::Variable(name) => 1e-6 * get(&mut sample.clone(), name).abs().max(1.0),
                    Change::State(_) => 1e-6,
                };
                let high = value(&mut vary(sample, change, size), unknown);
                let low = value(&mut vary(sample, change, -size), unknown);
                let difference = (high - low) / (2.0 * size);
                if dependency.is_none() {
                    assert_eq!(high, low, "{place}");
                }
                match sample.clone().partial_derivative(unknown, known) {
                    Some(partial) => {
                        let tolerance = 1e-6 * (1.0 + partial.abs());
                        assert!(
                            (partial - difference).abs() < tolerance,
                            "{place}: {partial} {difference}"
                        );
                        seen.push(partial);
                    }
                    None => {
                        assert_eq!(dependency, Some(DependencyKind::Dependent), "{place}");
                        seen.push(difference);
                    }
                }
            }
            assert_eq!(seen.iter().any(|&d| d != 0.0), dependency.is_some(), "{place}: {seen:?}");
            if matches!(dependency, Some(DependencyKind::Constant | DependencyKind::Fixed)) {
                assert!(seen.iter().all(|d| *d == seen[0]), "{place}: {seen:?}");
            }
        }
    }
}

#[test]
fn partial_derivatives_of_the_identified_plant() {
    for kind in kinds() {
        check(&identified(kind), kind, &[0.0, 7.0, 15.0]);
        let mut noisy = identified(kind);
        set(&mut noisy, "noise_scale", 0.7);
        check(&noisy, kind, &[11.0]);
    }
}

#[test]
fn partial_derivatives_of_the_bicycle() {
    // Some of the wheels are at their largest rate.
    let mut limited = bicycle();
    set(&mut limited, "actuator_rate_max", 12.0);
    check(&limited, "bicycle", &[0.0, 0.3, 0.9, 1.1, 8.0, 40.0, 12.0, 25.0]);
}

/// Where the table lists dependencies it lists the same: for a model without feedthrough.
#[test]
fn the_tables_agree() {
    fn agree<S: CoSimulationUnit>(unit: &S)
    where
        S::Variable: Debug,
    {
        let listed = |list: DependsOn, name: &str| match list {
            DependsOn::Nothing => false,
            DependsOn::All => true,
            DependsOn::On(names) => names.contains(&name),
        };
        for row in S::TABLE.variables.iter().filter(|r| r.causality == Causality::Output) {
            let unknown = Unknown::Variable(variable::<S>(row.name));
            for known in S::TABLE.variables {
                let dependency =
                    unit.dependency(unknown, Known::Variable(variable::<S>(known.name)));
                let place = format!("{} by {}", row.name, known.name);
                match known.causality {
                    Causality::Input => {
                        assert_eq!(
                            dependency.is_some(),
                            listed(row.depends_on, known.name),
                            "{place}"
                        );
                        assert_eq!(
                            dependency.is_some(),
                            listed(row.initial_depends_on, known.name),
                            "{place}"
                        );
                    }
                    Causality::Parameter => {
                        assert_eq!(
                            dependency.is_some(),
                            listed(row.initial_depends_on, known.name),
                            "{place}"
                        );
                    }
                    _ => assert_eq!(dependency, None, "{place}"),
                }
            }
        }
    }
    agree(&identified(PLAIN));
    agree(&bicycle());
    agree(&nonlinear());
}

/// The derivative of each state is how fast it moves in the next moment, and that of each output
/// too; with a ramp, in the middle of a drive.
fn check_rates<S: CoSimulationUnit>(mut unit: S, label: impl Debug) {
    let speed = get(&mut unit, "speed");
    start(&mut unit);
    for k in 0..40 {
        set(&mut unit, "steering_angle", 0.1 * (f64::from(k) * 0.4).sin());
        unit.set_input_derivative(variable::<S>("steering_angle"), 0.3);
        step(&mut unit, 0.0073);
    }
    let (angle, slope) = (0.07, -0.6);
    set(&mut unit, "steering_angle", angle);
    unit.set_input_derivative(variable::<S>("steering_angle"), slope);
    let outputs = rows::<S>(Causality::Output);
    let n = unit.states().len();
    let at = |h: f64| -> Vec<f64> {
        let mut s = unit.clone();
        if h > 0.0 {
            step(&mut s, h);
            set(&mut s, "steering_angle", angle + slope * h);
        }
        let states: Vec<f64> = (0..n).map(|i| s.state(i)).collect();
        outputs.iter().map(|name| get(&mut s, name)).chain(states).collect()
    };
    // Second-order one-sided difference.
    let h = 1e-5;
    let (now, one, two) = (at(0.0), at(h), at(2.0 * h));
    let expected: Vec<f64> = outputs
        .iter()
        .map(|name| unit.output_derivative(variable::<S>(name)))
        .collect::<Vec<_>>()
        .into_iter()
        .chain((0..n).map(|i| unit.state_derivative(i)))
        .collect();
    for (i, expected) in expected.iter().enumerate() {
        let seen = (4.0 * one[i] - two[i] - 3.0 * now[i]) / (2.0 * h);
        assert!(
            (seen - expected).abs() < 1e-5 * (1.0 + speed + expected.abs()),
            "{label:?}: number {i} of {outputs:?} and states: {seen} {expected}"
        );
    }
}

#[test]
fn derivatives_by_time() {
    for kind in kinds() {
        check_rates(identified(kind), kind);
        let mut noisy = identified(kind);
        set(&mut noisy, "noise_scale", 1.0);
        check_rates(noisy, kind);
    }
    for speed in [0.5, 3.0, 30.0] {
        let mut plant = bicycle();
        set(&mut plant, "speed", speed);
        check_rates(plant, speed);
        let mut vehicle = nonlinear();
        set(&mut vehicle, "speed", speed);
        check_rates(vehicle.clone(), speed);
        set(&mut vehicle, "actuator_delay", 0.0);
        check_rates(vehicle, speed);
    }
}

/// States: how many, which can be set, what they start at, and that they survive the start.
#[test]
fn states_start_where_they_are_set() {
    fn check<S: CoSimulationUnit>(mut unit: S, settable: usize) {
        let specs = unit.states();
        assert_eq!(specs.len(), settable + 3);
        for (i, spec) in specs.iter().enumerate() {
            assert_eq!(spec.settable, i < settable);
            assert_eq!(unit.state(i), 0.0);
            unit.set_state(i, 0.1 * (i + 1) as f64);
        }
        for started in [false, true] {
            if started {
                start(&mut unit);
            }
            for i in 0..settable {
                assert_eq!(unit.state(i), 0.1 * (i + 1) as f64);
            }
            assert_eq!(unit.state(settable), 0.0, "yaw follows initial_yaw");
        }
    }
    check(identified(PLAIN), 3);
    check(identified(common::Kind { continuous: false, ..PLAIN }), 0);
    check(bicycle(), 3);
    check(nonlinear(), 4);
    // Outputs read before the start follow.
    let mut plant = bicycle();
    plant.set_state(1, 0.4);
    assert_eq!(get(&mut plant, "yaw_rate"), 0.4);
    set(&mut plant, "initial_yaw", 1.5);
    assert_eq!((plant.state(3), get(&mut plant, "yaw")), (1.5, 1.5));
    let mut plant = identified(PLAIN);
    plant.set_state(1, 0.4);
    assert!((get(&mut plant, "yaw_rate") - (0.02 + 1.1 * 0.4)).abs() < 1e-15);
}

/// A speed's derivative does nothing, and that is logged once.
#[test]
fn speed_is_held() {
    fn held<S: CoSimulationUnit>(mut plant: S) {
        start(&mut plant);
        let mut other = plant.clone();
        plant.set_input_derivative(variable::<S>("speed"), 3.0);
        let mut log = fmi2_export::Log::default();
        plant.step(0.0, 0.1, &mut log).unwrap();
        plant.step(0.1, 0.1, &mut log).unwrap();
        assert_eq!(log.lines().len(), 1);
        step(&mut other, 0.1);
        step(&mut other, 0.1);
        assert_eq!(get(&mut plant, "x"), get(&mut other, "x"));
    }
    held(bicycle());
    held(nonlinear());
}
