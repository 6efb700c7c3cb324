//! GetXXX and SetXXX: every variable, and every wrong argument.

use super::Case;
use super::table::Place;
use crate::api::{Api, Component, ERROR, OK, Status, WARNING};
use crate::samples::Sample;
use model_description::{Causality, Initial, Kind, Value, Variability, Variable};
use std::ffi::c_char;
use std::ptr::null;

/// A value reference that no variable has.
const NOWHERE: u32 = 0x0fff_ffff;

pub(super) fn cases(sample: &Sample) -> Vec<Case<'_>> {
    assert!(sample.variables().iter().all(|v| v.reference != NOWHERE));
    let mut cases = of_variables(sample);
    cases.extend(of_type(sample, Kind::Real, REAL, 1.0));
    cases.extend(of_type(sample, Kind::Integer, INTEGER, 1));
    cases.extend(of_type(sample, Kind::Boolean, BOOLEAN, 1));
    cases.extend(of_type(sample, Kind::String, STRING, c"text".as_ptr()));
    cases.extend(wrong_values(sample));
    cases
}

/// Whether the standard lets the variable be set there: the footnotes of the row SetXXX. One
/// leniency beyond it: an input may be set in the state instantiated, as FMPy does.
fn may_set(variable: &Variable, place: Place) -> bool {
    if variable.variability == Variability::Constant {
        return false;
    }
    let is_input = variable.causality == Causality::Input;
    let initial = variable.effective_initial();
    match place.letter() {
        'I' => is_input || matches!(initial, Some(Initial::Exact | Initial::Approx)),
        'M' => is_input || initial == Some(Initial::Exact),
        'C' => {
            is_input
                || variable.causality == Causality::Parameter
                    && variable.variability == Variability::Tunable
        }
        _ => false,
    }
}

/// A value of its type within its limits.
fn plausible(variable: &Variable) -> Value {
    let low = variable.min.unwrap_or(f64::NEG_INFINITY);
    variable.start.clone().unwrap_or(match variable.kind {
        Kind::Real => Value::Real(low.max(0.0)),
        Kind::Integer => Value::Integer(0),
        Kind::Boolean => Value::Boolean(false),
        Kind::String => Value::String("text".into()),
    })
}

/// Each variable read, which is lenient in initialization mode, and set.
fn of_variables(sample: &Sample) -> Vec<Case<'_>> {
    let mut cases = Vec::new();
    for variable in sample.variables() {
        let (get, set) = match variable.kind {
            Kind::Real => ("fmi2GetReal", "fmi2SetReal"),
            Kind::Integer => ("fmi2GetInteger", "fmi2SetInteger"),
            Kind::Boolean => ("fmi2GetBoolean", "fmi2SetBoolean"),
            Kind::String => ("fmi2GetString", "fmi2SetString"),
        };
        let expected = |place| if may_set(variable, place) { OK } else { ERROR };
        let value = plausible(variable);
        cases.push(Case::new(get, &variable.name, OK, |unit| unit.bits(variable).0));
        cases.push(Case::by_place(set, &variable.name, expected, move |unit| {
            unit.set(variable, &value)
        }));
    }
    cases
}

type Get<T> = unsafe extern "C" fn(Component, *const u32, usize, *mut T) -> Status;
type Set<T> = unsafe extern "C" fn(Component, *const u32, usize, *const T) -> Status;

/// The pair of functions of one type: their names, and where they are.
type Pair<T> = (&'static str, &'static str, fn(&Api) -> (Get<T>, Set<T>));

const REAL: Pair<f64> = ("fmi2GetReal", "fmi2SetReal", |api| (api.get_real, api.set_real));
const INTEGER: Pair<i32> =
    ("fmi2GetInteger", "fmi2SetInteger", |api| (api.get_integer, api.set_integer));
const BOOLEAN: Pair<i32> =
    ("fmi2GetBoolean", "fmi2SetBoolean", |api| (api.get_boolean, api.set_boolean));
const STRING: Pair<*const c_char> =
    ("fmi2GetString", "fmi2SetString", |api| (api.get_string, api.set_string));

/// Wrong references, pointers and lengths for one type. `value` is one of that type.
fn of_type<'s, T: Copy + PartialEq + std::fmt::Debug + 's>(
    sample: &'s Sample,
    kind: Kind,
    (get, set, functions): Pair<T>,
    value: T,
) -> Vec<Case<'s>> {
    let of_another = sample.variables().iter().find(|v| v.kind != kind).map(|v| v.reference);
    // Where all variables are of this type there is none of another.
    let of_another = of_another.unwrap_or(NOWHERE);
    let good = sample.variables().iter().find(|v| v.kind == kind).map(|v| v.reference);
    let input = sample.of(kind, Causality::Input).map(|v| v.reference).next();
    let mut lists = vec![
        ("an unknown reference", vec![NOWHERE]),
        ("the largest reference", vec![u32::MAX]),
        ("a reference of another type", vec![of_another]),
        ("unknown references", vec![NOWHERE; 3]),
    ];
    if let Some(good) = good {
        lists.push(("good, then unknown", vec![good, good, NOWHERE]));
        lists.push(("good, then of another type", vec![good, of_another]));
    }
    if let Some(input) = input {
        lists.push(("an input, then unknown", vec![input, NOWHERE]));
        lists.push(("an input, then of another type", vec![input, of_another]));
    }
    let mut cases = Vec::new();
    for (class, references) in lists {
        let again = references.clone();
        cases.push(Case::new(get, class, ERROR, move |unit| {
            let mut values = vec![value; again.len()];
            let (n, get) = (again.len(), functions(unit.api).0);
            // SAFETY: a live instance, as many elements as declared.
            let status = unsafe { get(unit.component, again.as_ptr(), n, values.as_mut_ptr()) };
            assert_eq!(values, vec![value; n], "{class}: written to in spite of the error");
            status
        }));
        cases.push(Case::new(set, class, ERROR, move |unit| {
            let values = vec![value; references.len()];
            let (n, set) = (references.len(), functions(unit.api).1);
            // SAFETY: a live instance, as many elements as declared.
            unsafe { set(unit.component, references.as_ptr(), n, values.as_ptr()) }
        }));
    }
    let reference = good.unwrap_or(NOWHERE);
    for (class, n, with_references, with_values, expected) in [
        ("zero length, NULL", 0, false, false, OK),
        ("zero length", 0, true, true, OK),
        ("references NULL", 1, false, true, ERROR),
        ("values NULL", 1, true, false, ERROR),
        ("both NULL", 1, false, false, ERROR),
        ("longer than memory", usize::MAX, true, true, ERROR),
        ("longer than memory in bytes", usize::MAX / 2 + 1, true, true, ERROR),
        ("longer than memory, NULL", usize::MAX, false, false, ERROR),
    ] {
        let references = move || if with_references { &raw const reference } else { null() };
        cases.push(Case::new(get, class, expected, move |unit| {
            let mut room = value;
            let values = if with_values { &raw mut room } else { std::ptr::null_mut() };
            // SAFETY: a live instance; elements that cannot be are refused before they are read.
            let status = unsafe { functions(unit.api).0(unit.component, references(), n, values) };
            assert_eq!(room, value);
            status
        }));
        cases.push(Case::new(set, class, expected, move |unit| {
            let values = if with_values { &raw const value } else { null() };
            // SAFETY: as above.
            unsafe { functions(unit.api).1(unit.component, references(), n, values) }
        }));
    }
    cases
}

/// Numbers that a variable cannot have: alone, and after one that it can.
fn wrong_values(sample: &Sample) -> Vec<Case<'_>> {
    let mut cases = Vec::new();
    // One that may be set in I, M and C, whose value must not change with the bad one after it.
    let companion = sample.continuous(Causality::Input)[0].reference;
    let reals = sample.variables().iter().filter(|v| v.kind == Kind::Real);
    for variable in reals.filter(|v| may_set(v, Place::M)) {
        let is_input = variable.causality == Causality::Input;
        let mut values = vec![(f64::NAN, ERROR), (f64::INFINITY, ERROR), (-f64::INFINITY, ERROR)];
        // Outside its limits an input is clipped with a warning, anything else is refused.
        let outside = if is_input { WARNING } else { ERROR };
        values.extend(variable.min.map(|min| (min.next_down(), outside)));
        values.extend(variable.min.map(|_| (-f64::MAX, outside)));
        values.extend(variable.max.map(|max| (max.next_up(), outside)));
        for (value, status) in values {
            let expected = move |place| if may_set(variable, place) { status } else { ERROR };
            let class = format!("{} = {value:e}", variable.name);
            cases.push(Case::by_place("fmi2SetReal", &class, expected, move |unit| {
                // The warning of a clipped input comes once for an instance.
                if status == WARNING && may_set(variable, Place::I) {
                    return once_clipped(unit.set_real(variable.reference, value));
                }
                unit.set_real(variable.reference, value)
            }));
            if status == ERROR && variable.reference != companion {
                let class = format!("a good one, then {class}");
                cases.push(Case::new("fmi2SetReal", class, ERROR, move |unit| {
                    let (references, values) = ([companion, variable.reference], [0.123, value]);
                    let (references, values) = (references.as_ptr(), values.as_ptr());
                    // SAFETY: a live instance, two elements each.
                    unsafe { (unit.api.set_real)(unit.component, references, 2, values) }
                }));
            }
        }
    }
    for variable in sample.of(Kind::Boolean, Causality::Input) {
        for value in [2, -1, i32::MAX, i32::MIN] {
            let class = format!("{} = {value}", variable.name);
            cases.push(Case::new("fmi2SetBoolean", class, ERROR, move |unit| {
                let reference = variable.reference;
                // SAFETY: a live instance, one element each.
                unsafe { (unit.api.set_boolean)(unit.component, &reference, 1, &value) }
            }));
        }
    }
    // No FMU has a String; one that is NULL is refused with the reference.
    cases.push(Case::new("fmi2SetString", "a text that is NULL", ERROR, |unit| {
        // SAFETY: a live instance, one element each.
        unsafe { (unit.api.set_string)(unit.component, &0, 1, &null()) }
    }));
    cases
}

/// Clipping is reported once: later calls are as good as any.
fn once_clipped(status: Status) -> Status {
    if status == OK { WARNING } else { status }
}
