//! States as bytes: what is loaded goes on to the last bit, and no bytes do harm.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::common;

use common::{
    Kind, PLAIN, bicycle, example, get, identified, kinds, longitudinal, nonlinear, path, pid,
    pose, set, start, variable,
};
use fmi2_export::model_description::{Causality, Value};
use fmi2_export::{CoSimulationUnit, Log};
use proptest::prelude::*;
use steerwright_units::{Definition, Fmu, Visitor};

/// The layout version, the length and a fingerprint (FNV-1a) of a unit's state before the start.
struct Layout;

impl Visitor for Layout {
    type Output = (u8, String);

    fn visit<S: Definition>(self) -> (u8, String) {
        let bytes = example::<S>().save();
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for byte in &bytes[1..] {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
        (bytes[0], format!("{} {} {hash:016x}", S::TABLE.model_name, bytes.len()))
    }
}

/// `saved_layouts.txt` is written again with `STEERWRIGHT_UPDATE=1`: with the next version, where a layout has changed.
#[test]
fn a_changed_layout_has_another_version() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/src/saved_layouts.txt");
    let known = std::fs::read_to_string(file).unwrap();
    let mut lines = known.lines();
    let mut version: u8 = lines.next().unwrap().parse().unwrap();
    let mut seen = Vec::new();
    for fmu in Fmu::ALL {
        let (found, layout) = fmu.visit(Layout);
        assert_eq!(found, version, "the version in the states of {}", fmu.name());
        seen.push(layout);
    }
    if std::env::var_os("STEERWRIGHT_UPDATE").is_some() {
        let is_changed = |layout: &str| seen.iter().all(|now| now != layout);
        if lines.any(is_changed) {
            version += 1;
        }
        std::fs::write(file, format!("{version}\n{}\n", seen.join("\n"))).unwrap();
        return;
    }
    assert_eq!(
        seen,
        lines.collect::<Vec<_>>(),
        "STEERWRIGHT_UPDATE=1 writes the layouts with the next version"
    );
}

/// A parameter that a state leaves out would have its value of before.
struct Parameters;

impl Visitor for Parameters {
    type Output = ();

    fn visit<S: Definition>(self) {
        let unit = example::<S>();
        let (mut set_apart, mut loaded) = (unit.clone(), unit.clone());
        for row in S::TABLE.variables.iter().filter(|row| row.causality == Causality::Parameter) {
            let (min, max) = (row.min.unwrap_or(f64::MIN), row.max.unwrap_or(f64::MAX));
            let value = get(&mut set_apart, row.name);
            let other = [0.75 * value, 1.25 * value, 0.5];
            let other = other.into_iter().find(|v| *v != value && (min..=max).contains(v));
            if let Value::Real(_) = set_apart.get(variable::<S>(row.name)) {
                set(&mut set_apart, row.name, other.unwrap());
            }
        }
        loaded.load(&set_apart.save()).unwrap();
        for row in S::TABLE.variables.iter().filter(|row| row.causality == Causality::Parameter) {
            let (seen, kept) = (get(&mut loaded, row.name), get(&mut set_apart, row.name));
            assert_eq!(seen, kept, "{} of {}", row.name, S::TABLE.model_name);
        }
    }
}

#[test]
fn every_parameter_is_in_the_state() {
    Fmu::ALL.into_iter().for_each(|fmu| fmu.visit(Parameters));
}

/// Sets the inputs and steps, then reads all variables: as bits, so that NaN compares.
fn drive<S: CoSimulationUnit>(unit: &mut S, steps: std::ops::Range<u32>) -> Vec<u64> {
    let mut seen = Vec::new();
    for k in steps {
        let t = f64::from(k) * 0.013;
        for row in S::TABLE.variables.iter().filter(|row| row.causality == Causality::Input) {
            match row.name {
                "enabled" => {}
                "gnss_std" => set(unit, "gnss_std", 0.05),
                // A fix every tenth step.
                "gnss_fix_count" => unit.set(
                    variable::<S>("gnss_fix_count"),
                    &Value::Integer(i32::try_from(k / 10).unwrap()),
                ),
                "speed" => set(unit, "speed", 10.0 + (0.3 * t).sin()),
                "x" | "y" => set(unit, row.name, 9.0 * t),
                name => set(unit, name, 0.1 * (3.0 * t).sin() + 0.01 * name.len() as f64),
            }
        }
        if S::CAPABILITIES.interpolates_inputs {
            unit.set_input_derivative(variable::<S>("steering_angle"), 0.3 * (7.0 * t).cos());
        }
        // An error must be an error on both sides.
        let ok = unit.step(t, 0.013, &mut Log::default()).is_ok();
        seen.push(u64::from(ok));
        seen.extend(S::TABLE.variables.iter().map(|row| get(unit, row.name).to_bits()));
    }
    seen
}

fn goes_on<S: CoSimulationUnit>(fresh: &S, prepared: &S) {
    for before in [0, 1, 17, 60] {
        let mut saved = prepared.clone();
        start(&mut saved);
        drive(&mut saved, 0..before);
        let mut loaded = fresh.clone();
        loaded.load(&saved.save()).unwrap();
        assert_eq!(loaded.save(), saved.save());
        assert_eq!(drive(&mut saved, before..before + 60), drive(&mut loaded, before..before + 60));
    }
    // In initialization mode too.
    let mut saved = prepared.clone();
    let mut loaded = fresh.clone();
    loaded.load(&saved.save()).unwrap();
    start(&mut saved);
    start(&mut loaded);
    assert_eq!(drive(&mut saved, 0..40), drive(&mut loaded, 0..40));
}

#[test]
fn identified_plants_go_on() {
    for kind in kinds() {
        for noise in [0.0, 1.0] {
            let fresh = identified(kind);
            let mut prepared = fresh.clone();
            set(&mut prepared, "noise_scale", noise);
            set(&mut prepared, "initial_yaw", 0.4);
            (0..fresh.states().len()).for_each(|i| prepared.set_state(i, 0.1));
            goes_on(&fresh, &prepared);
        }
    }
}

#[test]
fn bicycles_go_on() {
    let mut prepared = bicycle();
    set(&mut prepared, "mass", 1700.0);
    set(&mut prepared, "initial_x", -3.0);
    prepared.set_state(1, 0.2);
    goes_on(&bicycle(), &prepared);
}

#[test]
fn nonlinear_vehicles_go_on() {
    let mut prepared = nonlinear();
    set(&mut prepared, "actuator_delay", 0.05);
    set(&mut prepared, "friction_coefficient", 0.3);
    set(&mut prepared, "initial_x", -3.0);
    prepared.set_state(2, 0.2);
    goes_on(&nonlinear(), &prepared);
}

#[test]
fn longitudinal_plants_go_on() {
    let mut prepared = longitudinal();
    for (name, value) in [("delay", 0.2), ("brake_delay", 0.0), ("initial_speed", 3.0)] {
        set(&mut prepared, name, value);
    }
    goes_on(&longitudinal(), &prepared);
}

#[test]
fn controllers_go_on() {
    let mut prepared = pid();
    for (name, value) in [("ki", 0.7), ("kd", 0.1), ("derivative_filter_time", 0.02)] {
        set(&mut prepared, name, value);
    }
    goes_on(&pid(), &prepared);
}

#[test]
fn paths_go_on() {
    for closed in [false, true] {
        let mut prepared = path(closed);
        set(&mut prepared, "lookahead_min", 3.0);
        goes_on(&path(closed), &prepared);
    }
}

#[test]
fn estimators_go_on() {
    for (name, value) in [("initial_yaw_std", 0.1), ("initial_yaw_std", 2.0), ("gnss_latency", 0.0)]
    {
        let mut prepared = pose();
        set(&mut prepared, "initial_x", 2.0);
        set(&mut prepared, name, value);
        goes_on(&pose(), &prepared);
    }
}

/// The state of one model is none of another of a different order or delay.
#[test]
fn foreign_states_are_refused() {
    let delayed = identified(Kind { delay: 0.05, ..PLAIN });
    assert!(identified(PLAIN).load(&delayed.save()).unwrap_err().contains("history"));
    assert!(bicycle().load(&delayed.save()).is_err());
    assert!(bicycle().load(&[]).unwrap_err().contains("cannot be read"));
    let mut longer = bicycle().save();
    longer.push(0);
    assert!(bicycle().load(&longer).unwrap_err().contains("too many"));
}

/// Values that no importer could have set are refused by name.
#[test]
fn impossible_values_are_refused() {
    let refused = |name: &str, value: f64| {
        let mut plant = bicycle();
        set(&mut plant, name, value);
        bicycle().load(&plant.save()).unwrap_err()
    };
    assert!(refused("speed", -1.0).contains("speed"));
    assert!(refused("mass", 0.0).contains("mass"));
    assert!(refused("initial_yaw", f64::NAN).contains("yaw"));
    assert!(refused("steering_angle", f64::INFINITY).contains("input"));
    let mut controller = pid();
    set(&mut controller, "sample_time", 1e-300);
    assert!(pid().load(&controller.save()).unwrap_err().contains("sample_time"));
}

/// A number inside a model, found in the bytes by its value, is refused where it cannot be.
fn refused<S: CoSimulationUnit>(fresh: &S, used: &S, number: f64, instead: &[f64]) {
    assert!(number != 0.0, "zeros are everywhere");
    let bytes = used.save();
    let places: Vec<usize> =
        (0..bytes.len() - 7).filter(|&i| bytes[i..i + 8] == number.to_le_bytes()).collect();
    assert!(!places.is_empty(), "{number} is not in the state");
    for value in instead {
        let mut changed = bytes.clone();
        places.iter().for_each(|&i| changed[i..i + 8].copy_from_slice(&value.to_le_bytes()));
        assert!(fresh.clone().load(&changed).is_err(), "{value} instead of {number}");
    }
}

fn driven<S: CoSimulationUnit>(fresh: &S, steps: u32, change: impl Fn(&mut S)) -> S {
    let mut used = fresh.clone();
    change(&mut used);
    start(&mut used);
    drive(&mut used, 0..steps);
    used
}

const NOT_FINITE: [f64; 2] = [f64::NAN, f64::INFINITY];

#[test]
fn impossible_states_are_refused() {
    let not_a_phase = [1.0, -0.5, f64::NAN];

    let fresh = identified(Kind { delay: 0.05, ..PLAIN });
    let mut used = driven(&fresh, 1, |s| {
        set(s, "noise_scale", 1.0);
        set(s, "initial_y", 2.0);
        (0..3).for_each(|i| s.set_state(i, 0.1));
    });
    refused(&fresh, &used, 0.013 / 0.02, &not_a_phase);
    refused(&fresh, &used, 0.05 - 0.013, &[0.2, -0.037, f64::NAN]);
    for i in 0..6 {
        let state = used.state(i);
        refused(&fresh, &used, state, &NOT_FINITE);
    }
    let fresh = pid();
    let mut used = driven(&fresh, 1, |_| {});
    refused(&fresh, &used, 0.013 / 0.01 - 1.0, &not_a_phase);
    let angle = get(&mut used, "steering_angle");
    refused(&fresh, &used, angle, &NOT_FINITE);
    for closed in [false, true] {
        let fresh = path(closed);
        let mut used = driven(&fresh, 20, |_| {});
        let distance = get(&mut used, "distance");
        refused(&fresh, &used, distance, &NOT_FINITE);
        if closed {
            refused(&fresh, &used, distance, &[1e300, -1e15]);
        }
        let reference = get(&mut used, "yaw_reference");
        refused(&fresh, &used, reference, &NOT_FINITE);
    }
    let fresh = bicycle();
    let mut used = driven(&fresh, 20, |s| s.set_state(0, 0.1));
    for i in 0..6 {
        let state = used.state(i);
        refused(&fresh, &used, state, &NOT_FINITE);
    }
}

#[test]
fn impossible_nonlinear_vehicles_are_refused() {
    let fresh = nonlinear();
    let mut used = driven(&fresh, 20, |s| s.set_state(0, 0.1));
    for i in 0..7 {
        let state = used.state(i);
        refused(&fresh, &used, state, &NOT_FINITE);
    }
    // Beyond the end stops, which stand in the state as a parameter too.
    let angle = used.state(2);
    refused(&fresh, &used, angle, &[1.1, -1.1]);
    let used = driven(&fresh, 1, |_| {});
    refused(&fresh, &used, 0.025 - 0.013, &[0.2, -0.013, f64::NAN]);
}

#[test]
fn impossible_longitudinal_plants_are_refused() {
    let fresh = longitudinal();
    let mut used = driven(&fresh, 1, |s| {
        set(s, "accelerator", 0.3);
        set(s, "brake", 0.1);
    });
    for i in 0..4 {
        let state = used.state(i);
        refused(&fresh, &used, state, &NOT_FINITE);
    }
    refused(&fresh, &used, 0.013 / 0.02, &[1.0, -0.5, f64::NAN]);
    refused(&fresh, &used, 0.06 - 0.013, &[0.2, -0.013, f64::NAN]);
    refused(&fresh, &used, 0.35, &[0.0, -1.0, 1e9, f64::NAN]);
}

#[test]
fn impossible_estimators_are_refused() {
    let fresh = pose();
    let mut used = driven(&fresh, 25, |s| set(s, "initial_yaw", 0.3));
    for name in ["x", "y", "yaw"] {
        let value = get(&mut used, name);
        refused(&fresh, &used, value, &NOT_FINITE);
    }
    // A latency, and an interval of the history, of another length.
    refused(&fresh, &used, 0.05, &[-1.0, 0.2, f64::NAN]);
    refused(&fresh, &used, 0.013, &[-0.013, 0.1, f64::NAN]);
    // The variance of the yaw at the start.
    let used = driven(&fresh, 0, |s| set(s, "initial_yaw_std", 0.125));
    refused(&fresh, &used, 0.125 * 0.125, &[-1.0, f64::NAN]);
}

fn any_bytes<S: CoSimulationUnit>(fresh: &S, bytes: &[u8]) {
    let mut unit = fresh.clone();
    if unit.load(bytes).is_ok() {
        // Whatever was loaded runs, or says what is wrong.
        drive(&mut unit, 0..5);
        let _ = unit.step(0.0, 5.0, &mut Log::default());
    } else {
        assert_eq!(unit.save(), fresh.save(), "a refused state changes nothing");
    }
}

/// Bytes of a valid state with some replaced, or cut.
fn mutated<S: CoSimulationUnit>(unit: &S, changes: &[(usize, u8)], cut: Option<usize>) -> Vec<u8> {
    let mut bytes = unit.save();
    let length = bytes.len();
    changes.iter().for_each(|&(place, byte)| bytes[place % length] = byte);
    bytes.truncate(cut.map_or(length, |cut| cut % length));
    bytes
}

/// Bytes that make counts and exponents large, more often than chance has them.
fn byte() -> impl Strategy<Value = u8> {
    prop_oneof![any::<u8>(), Just(0), Just(0xff), Just(0x7f), Just(0x80), Just(0xf0), Just(0xef)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn random_bytes_do_no_harm(bytes in prop::collection::vec(byte(), 0..400)) {
        any_bytes(&identified(PLAIN), &bytes);
        any_bytes(&bicycle(), &bytes);
        any_bytes(&longitudinal(), &bytes);
        any_bytes(&nonlinear(), &bytes);
        any_bytes(&pid(), &bytes);
        any_bytes(&pose(), &bytes);
    }

    #[test]
    fn mutated_states_do_no_harm(
        changes in prop::collection::vec((any::<usize>(), byte()), 1..9),
        cut in prop::option::weighted(0.2, any::<usize>()),
        steps in 0..30_u32,
    ) {
        fn both<S: CoSimulationUnit>(fresh: &S, mut used: S, steps: u32, bytes: impl Fn(&S) -> Vec<u8>) {
            any_bytes(fresh, &bytes(&used));
            start(&mut used);
            drive(&mut used, 0..steps);
            any_bytes(fresh, &bytes(&used));
        }
        for kind in [PLAIN, Kind { delay: 0.05, d: 0.2, product: true, continuous: false, over_speed: true }] {
            let fresh = identified(kind);
            let mut used = fresh.clone();
            set(&mut used, "noise_scale", 1.0);
            both(&fresh, used, steps, |s| mutated(s, &changes, cut));
        }
        both(&bicycle(), bicycle(), steps, |s| mutated(s, &changes, cut));
        both(&nonlinear(), nonlinear(), steps, |s| mutated(s, &changes, cut));
        both(&longitudinal(), longitudinal(), steps, |s| mutated(s, &changes, cut));
        both(&pid(), pid(), steps, |s| mutated(s, &changes, cut));
        both(&pose(), pose(), steps, |s| mutated(s, &changes, cut));
        for closed in [false, true] {
            let fresh = path(closed);
            both(&fresh, fresh.clone(), steps, |s| mutated(s, &changes, cut));
        }
    }
}
