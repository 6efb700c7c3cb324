//! The matrix: every function in every state with every class of arguments.
//!
//! A case is tried in each state of the table. Where the table forbids the function, `fmi2Error` is
//! expected whatever the arguments; where it allows it, the case's own status. After an error: one
//! log line that names the function, the instance refuses to step, and no variable differs, to the
//! bit, from an instance in the same state that made an error without any arguments.

mod calls;
mod derivatives;
mod instantiation;
mod nothing;
mod states;
mod table;
mod values;

use crate::api::{ERROR, State, Status};
use crate::samples::{Sample, sample, samples};
use crate::unit::Unit;
use table::{Place, is_legal};

/// One function with one class of arguments.
struct Case<'s> {
    function: &'static str,
    class: String,
    /// The status where the function is legal; it may depend on the state.
    expected: Box<dyn Fn(Place) -> Status + 's>,
    call: Box<dyn Fn(&Unit<'s>) -> Status + 's>,
}

impl<'s> Case<'s> {
    fn new(
        function: &'static str,
        class: impl Into<String>,
        expected: Status,
        call: impl Fn(&Unit<'s>) -> Status + 's,
    ) -> Self {
        Self::by_place(function, class, move |_| expected, call)
    }

    fn by_place(
        function: &'static str,
        class: impl Into<String>,
        expected: impl Fn(Place) -> Status + 's,
        call: impl Fn(&Unit<'s>) -> Status + 's,
    ) -> Self {
        let class = class.into();
        Self { function, class, expected: Box::new(expected), call: Box::new(call) }
    }
}

/// An instance in that state.
fn bring(sample: &Sample, place: Place) -> Unit<'_> {
    let mut unit = Unit::new(sample);
    if place == Place::I {
        return unit;
    }
    unit.begin();
    if place == Place::M {
        return unit;
    }
    assert_eq!(unit.exit_initialization(), 0);
    if place == Place::C {
        return unit;
    }
    for k in 0..3 {
        unit.steer(k);
        unit.step();
    }
    match place {
        Place::T => assert_eq!(unit.terminate(), 0),
        Place::E => assert_eq!(unit.cancel(), ERROR),
        _ => {}
    }
    unit
}

/// All variables once the instance is in the error state, where all of them may be read.
fn after_an_error_without_arguments(unit: &Unit<'_>, saved: State) -> Vec<u64> {
    assert_eq!(unit.restore(saved), 0);
    assert_eq!(unit.cancel(), ERROR);
    let values = unit.everything();
    assert_eq!(unit.restore(saved), 0);
    values
}

/// Tries the cases in every state; gives how many calls were made.
fn try_all<'s>(sample: &'s Sample, cases: &[Case<'s>]) -> usize {
    for place in Place::ALL {
        let unit = bring(sample, place);
        let saved = unit.save();
        let before = after_an_error_without_arguments(&unit, saved);
        for case in cases {
            let here = format!("{} {} {}: {place:?}", sample.name(), case.function, case.class);
            assert_eq!(unit.restore(saved), 0, "{here}");
            unit.lines.take();
            let status = (case.call)(&unit);
            let lines = unit.lines.take();
            let legal = is_legal(case.function, place);
            let expected = if legal { (case.expected)(place) } else { ERROR };
            assert_eq!(status, expected, "{here}: {lines:?}");
            if status != ERROR {
                continue;
            }
            let logged: Vec<_> = lines.iter().filter(|line| line.status == ERROR).collect();
            assert_eq!(logged.len(), 1, "{here}: {lines:?}");
            assert_eq!(logged[0].category, "logStatusError", "{here}");
            assert!(logged[0].text.starts_with(case.function), "{here}: {}", logged[0].text);
            assert_eq!(unit.step_at(unit.time, sample.step()), ERROR, "{here}: it steps on");
            assert_eq!(unit.everything(), before, "{here}: a value changed");
        }
        unit.free(saved);
    }
    cases.len() * Place::ALL.len()
}

/// The cases test the optional capabilities; the plants have all of them.
#[test]
fn the_plants_have_every_capability() {
    for name in ["IdentifiedPlant", "BicyclePlant", "NonlinearVehicle"] {
        let flags = sample(name).flags();
        assert!(
            flags.can_interpolate_inputs
                && flags.max_output_derivative_order == 1
                && flags.can_get_and_set_fmu_state
                && flags.can_serialize_fmu_state
                && flags.provides_directional_derivative,
            "{name}: {flags:?}"
        );
        let states = sample(name).variables().iter().filter(|v| v.derivative.is_some()).count();
        // The example of an identified model is discrete: the pose alone is continuous.
        let expected = if name == "IdentifiedPlant" { 3 } else { 6 };
        assert!(states >= expected, "{name}: {states} states");
    }
}

#[test]
fn every_function_in_every_state_with_every_class_of_arguments() {
    for sample in samples() {
        let mut cases = calls::cases(sample);
        cases.extend(values::cases(sample));
        cases.extend(states::cases(sample));
        cases.extend(derivatives::cases(sample));
        for name in crate::api::NAMES {
            let elsewhere = ["fmi2Instantiate", "fmi2FreeInstance"].contains(&name);
            assert!(elsewhere || cases.iter().any(|case| case.function == name), "{name}");
        }
        let calls = try_all(sample, &cases);
        println!("{}: {} classes, {calls} calls", sample.name(), cases.len());
    }
}

/// The two that end or begin an instance: legal in every state.
#[test]
fn an_instance_is_freed_in_every_state() {
    for sample in samples() {
        for place in Place::ALL {
            drop(bring(sample, place));
        }
    }
}
