//! Reset and FMU states: the run after them equals a run of a new instance bit for bit.

use crate::api::{ERROR, OK};
use crate::samples::{Sample, is_exact, samples};
use crate::unit::Unit;
use model_description::{Causality, Kind, Value};
use std::ptr::null_mut;

/// Gives each start value another one near it; noise is among them.
fn disturb(unit: &Unit<'_>) {
    let exact = unit.sample.variables().iter().filter(|v| is_exact(v));
    for variable in exact.filter(|v| v.causality != Causality::Input) {
        let value = match variable.start.clone().unwrap() {
            Value::Real(start) => {
                let max = variable.max.unwrap_or(f64::INFINITY);
                Value::Real((start * 1.01 + 0.001).min(max))
            }
            Value::Integer(start) => Value::Integer(start + 1),
            other => other,
        };
        assert_eq!(unit.set(variable, &value), OK, "{}: {:?}", variable.name, unit.lines.take());
    }
}

/// A whole life in bits: in initialization mode, at the start, in 40 steps, statuses too.
fn life(unit: &mut Unit<'_>, disturbed: bool) -> Vec<Vec<u64>> {
    unit.time = 0.0;
    unit.begin();
    let mut all = vec![unit.everything()];
    if disturbed {
        disturb(unit);
        all.push(unit.everything());
    }
    all.push(vec![unit.exit_initialization() as u64]);
    all.push(unit.everything());
    all.extend(unit.drive(0, 40));
    all
}

/// The calls to an instance before its reset.
type Past = fn(&mut Unit<'_>);

#[test]
fn after_a_reset_everything_is_as_in_a_fresh_instance() {
    for sample in samples() {
        let fresh = [false, true].map(|disturbed| life(&mut Unit::new(sample), disturbed));
        assert_ne!(fresh[0], fresh[1], "{}: start values change nothing", sample.name());
        // From each state of the machine: what was before must not matter.
        let before: [(&str, Past); 6] = [
            ("nothing", |_| {}),
            ("initialization mode", |unit| {
                unit.begin();
                disturb(unit);
            }),
            ("a run", |unit| {
                life(unit, true);
            }),
            ("a late start", |unit| {
                assert_eq!(unit.setup(1e6), OK);
            }),
            ("an error", |unit| {
                life(unit, true);
                assert_eq!(unit.cancel(), ERROR);
            }),
            ("an end", |unit| {
                life(unit, true);
                assert_eq!(unit.terminate(), OK);
            }),
        ];
        for (name, first) in before {
            for (expected, disturbed) in [(&fresh[0], false), (&fresh[1], true)] {
                let mut unit = Unit::new(sample);
                first(&mut unit);
                for _ in 0..2 {
                    assert_eq!(unit.reset(), OK);
                    let again = life(&mut unit, disturbed);
                    assert!(again == *expected, "{}: reset after {name}", sample.name());
                }
            }
        }
    }
}

/// An instance with noise and other start values, at its first communication point.
fn disturbed(sample: &Sample) -> Unit<'_> {
    let unit = Unit::initializing(sample);
    disturb(&unit);
    assert!(unit.exit_initialization() <= 1);
    unit
}

#[test]
fn saved_run_restored_run_is_the_same_to_the_bit() {
    for sample in samples() {
        let mut unit = disturbed(sample);
        // Before the first step, and in the middle.
        for from in [0, 1, 23] {
            while unit.time < f64::from(from) * sample.step() * 0.999 {
                unit.drive(from, 1);
            }
            let (state, time) = (unit.save(), unit.time);
            let at_save = unit.everything();
            let first = unit.drive(from, 30);
            assert_ne!(first[0], first[29]);
            for way in ["at once", "after an error", "after the end", "after a reset"] {
                match way {
                    "after an error" => assert_eq!(unit.cancel(), ERROR),
                    "after the end" => assert_eq!(unit.terminate(), OK),
                    "after a reset" => assert_eq!(unit.reset(), OK),
                    _ => {}
                }
                assert_eq!(unit.restore(state), OK);
                unit.time = time;
                assert_eq!(unit.everything(), at_save, "{} {way}", sample.name());
                assert!(unit.drive(from, 30) == first, "{} {way}", sample.name());
            }
            // Another instance goes on from there as well.
            let mut other = Unit::new(sample);
            assert_eq!(other.restore(state), OK);
            other.time = time;
            assert!(other.drive(from, 30) == first, "{} in another instance", sample.name());
            assert_eq!(unit.restore(state), OK);
            unit.time = time;
            unit.free(state);
        }
    }
}

#[test]
fn a_state_is_reused_and_holds_what_was_saved_last() {
    for sample in samples() {
        let mut unit = disturbed(sample);
        let mut state = unit.save();
        let first = state;
        for k in 0..20 {
            unit.drive(k, 1);
            // SAFETY: a live instance and state.
            assert_eq!(unsafe { (unit.api.get_fmu_state)(unit.component, &mut state) }, OK);
            assert_eq!(state, first, "another place");
        }
        let (last, time) = (unit.everything(), unit.time);
        let rest = unit.drive(20, 10);
        assert_eq!(unit.restore(state), OK);
        assert_eq!(unit.everything(), last);
        unit.time = time;
        assert!(unit.drive(20, 10) == rest, "{}", sample.name());
        unit.free(state);
    }
}

/// The state of the machine is part of it: a state of initialization mode leads back there.
#[test]
fn a_state_of_initialization_mode_leads_back_there() {
    for sample in samples() {
        let mut unit = Unit::initializing(sample);
        disturb(&unit);
        let state = unit.save();
        let run = |unit: &mut Unit<'_>| {
            unit.time = 0.0;
            assert!(unit.exit_initialization() <= 1);
            unit.drive(0, 10)
        };
        let first = run(&mut unit);
        assert_eq!(unit.restore(state), OK);
        assert_eq!(unit.step_at(0.0, sample.step()), ERROR);
        assert_eq!(unit.restore(state), OK);
        assert!(run(&mut unit) == first, "{}", sample.name());
        unit.free(state);
    }
}

#[test]
fn serialized_states_go_on_in_other_instances() {
    for sample in samples().iter().filter(|s| s.flags().can_serialize_fmu_state) {
        let mut unit = disturbed(sample);
        for from in [0, 20, 40] {
            let (bytes, time) = (unit.serialized(), unit.time);
            assert_eq!(unit.serialized(), bytes, "{}: not the same twice", sample.name());
            let now = unit.everything();
            let rest = unit.drive(from, 20);
            let mut other = Unit::new(sample);
            assert_eq!(other.deserialize(&bytes), OK, "{:?}", other.lines.take());
            other.time = time;
            assert_eq!(other.everything(), now);
            assert_eq!(other.serialized(), bytes);
            assert!(other.drive(from, 20) == rest, "{}", sample.name());
        }
    }
}

/// A state of one FMU is none of another.
#[test]
fn a_serialized_state_of_another_fmu_is_refused() {
    let serializing: Vec<&Sample> =
        samples().iter().filter(|s| s.flags().can_serialize_fmu_state).collect();
    for one in &serializing {
        let bytes = Unit::started(one).serialized();
        for other in serializing.iter().filter(|other| other.name() != one.name()) {
            let mut unit = Unit::started(other);
            assert_eq!(unit.deserialize(&bytes), ERROR, "{} in {}", one.name(), other.name());
            assert_eq!(unit.reset(), OK);
            unit.begin();
            assert!(unit.exit_initialization() <= 1);
            unit.step();
        }
    }
}

/// States that are never freed or are freed by another instance have no effect.
#[test]
fn states_outlive_their_instance() {
    for sample in samples() {
        let mut first = disturbed(sample);
        first.drive(0, 5);
        let state = first.save();
        let rest = first.drive(5, 5);
        drop(first);
        let mut second = Unit::new(sample);
        assert_eq!(second.restore(state), OK);
        second.time = (0..5).fold(0.0, |t, _| t + sample.step());
        assert!(second.drive(5, 5) == rest, "{}", sample.name());
        let mut slot = state;
        // SAFETY: a live instance and state.
        assert_eq!(unsafe { (second.api.free_fmu_state)(second.component, &mut slot) }, OK);
        assert_eq!(slot, null_mut());
        assert_eq!(second.restore(state), ERROR);
    }
}

/// No variable of an FMU here is a String; if one comes, the tests above should set it too.
#[test]
fn there_are_no_strings() {
    assert!(samples().iter().all(|s| s.variables().iter().all(|v| v.kind != Kind::String)));
}
