//! Functions without variables: life cycle, times, statuses, logging.

use super::Case;
use crate::api::{DISCARD, ERROR, OK, WARNING, text_of};
use crate::samples::Sample;
use crate::unit::Unit;
use std::ffi::{CStr, c_char};
use std::ptr::{null, null_mut};

const INFINITY: f64 = f64::INFINITY;
const NAN: f64 = f64::NAN;

pub(super) fn cases(sample: &Sample) -> Vec<Case<'_>> {
    let mut cases = whole(sample);
    cases.extend(setup());
    cases.extend(logging());
    cases.extend(steps(sample));
    cases.extend(statuses());
    cases
}

/// Those that take an instance and nothing else.
fn whole(sample: &Sample) -> Vec<Case<'_>> {
    vec![
        Case::new("fmi2GetTypesPlatform", "", OK, |unit| {
            i32::from(text_of(unit.api.get_types_platform) != "default")
        }),
        Case::new("fmi2GetVersion", "", OK, |unit| {
            i32::from(text_of(unit.api.get_version) != "2.0")
        }),
        Case::new("fmi2EnterInitializationMode", "without an experiment", ERROR, |unit| {
            // SAFETY: a live instance.
            unsafe { (unit.api.enter_initialization_mode)(unit.component) }
        }),
        Case::new("fmi2ExitInitializationMode", "", OK, Unit::exit_initialization),
        Case::new("fmi2Terminate", "", OK, Unit::terminate),
        Case::new("fmi2Reset", "", OK, Unit::reset),
        Case::new("fmi2Reset", "and a start", OK, move |unit| {
            let status = unit.reset();
            unit.begin();
            assert_eq!(unit.exit_initialization(), OK);
            assert_eq!(unit.step_at(0.0, sample.step()), OK);
            status
        }),
        Case::new("fmi2CancelStep", "", ERROR, Unit::cancel),
    ]
}

fn setup<'s>() -> Vec<Case<'s>> {
    let case =
        |class: &str, expected, (tolerance_defined, tolerance, start, stop_defined, stop)| {
            Case::new("fmi2SetupExperiment", class, expected, move |unit| {
                // SAFETY: a live instance.
                unsafe {
                    (unit.api.setup_experiment)(
                        unit.component,
                        tolerance_defined,
                        tolerance,
                        start,
                        stop_defined,
                        stop,
                    )
                }
            })
        };
    vec![
        case("valid", OK, (0, 0.0, 0.0, 0, 0.0)),
        case("a late start", OK, (1, 1e-6, 100.0, 1, 200.0)),
        case("an early start", OK, (0, 0.0, -5.0, 1, -5.0)),
        case("undefined ones are not looked at", OK, (0, NAN, 0.0, 0, NAN)),
        case("start NaN", ERROR, (0, 0.0, NAN, 0, 0.0)),
        case("start infinite", ERROR, (0, 0.0, INFINITY, 0, 0.0)),
        case("start -infinite", ERROR, (0, 0.0, -INFINITY, 0, 0.0)),
        case("stop NaN", ERROR, (0, 0.0, 0.0, 1, NAN)),
        case("stop infinite", ERROR, (0, 0.0, 0.0, 1, INFINITY)),
        case("stop before start", ERROR, (0, 0.0, 1.0, 1, 0.5)),
        case("tolerance NaN", ERROR, (1, NAN, 0.0, 0, 0.0)),
        case("tolerance zero", WARNING, (1, 0.0, 0.0, 0, 0.0)),
        case("tolerance negative", WARNING, (1, -1e-3, 0.0, 0, 0.0)),
        case("tolerance infinite", ERROR, (1, INFINITY, 0.0, 0, 0.0)),
        case("toleranceDefined 2", ERROR, (2, 1e-6, 0.0, 0, 0.0)),
        case("stopTimeDefined -1", ERROR, (0, 0.0, 0.0, -1, 1.0)),
    ]
}

fn logging<'s>() -> Vec<Case<'s>> {
    let case = |class: &str, expected, on: i32, categories: Vec<Option<&'static CStr>>| {
        Case::new("fmi2SetDebugLogging", class, expected, move |unit| {
            let pointer = |category: &Option<&CStr>| category.map_or(null(), CStr::as_ptr);
            let pointers: Vec<*const c_char> = categories.iter().map(pointer).collect();
            // SAFETY: a live instance, as many strings as declared.
            let status = unsafe {
                let n = pointers.len();
                (unit.api.set_debug_logging)(unit.component, on, n, pointers.as_ptr())
            };
            if status != ERROR {
                // As it was, for the cases after.
                // SAFETY: a live instance, no strings.
                unsafe { (unit.api.set_debug_logging)(unit.component, 0, 0, null()) };
            }
            status
        })
    };
    let raw = |class: &str, expected, n: usize| {
        Case::new("fmi2SetDebugLogging", class, expected, move |unit| {
            // SAFETY: a live instance; a null pointer is not read.
            unsafe { (unit.api.set_debug_logging)(unit.component, 0, n, null()) }
        })
    };
    vec![
        case("on", OK, 1, vec![]),
        case("off", OK, 0, vec![]),
        case("one category", OK, 1, vec![Some(c"logStatusError")]),
        case("every warning", OK, 1, vec![Some(c"logStatusError"), Some(c"logStatusWarning")]),
        case("an unknown category", WARNING, 1, vec![Some(c"logAll"), Some(c"logNothing")]),
        case("an empty category", WARNING, 1, vec![Some(c"logAll"), Some(c"")]),
        case("loggingOn 2", ERROR, 2, vec![]),
        case("loggingOn -1", ERROR, -1, vec![Some(c"logAll")]),
        case("a NULL category", ERROR, 1, vec![Some(c"logAll"), None]),
        raw("no categories, NULL", OK, 0),
        raw("one category, NULL", ERROR, 1),
        raw("more categories than memory", ERROR, usize::MAX),
    ]
}

fn steps(sample: &Sample) -> Vec<Case<'_>> {
    let h = sample.step();
    let case = |class: &str, expected, times: Box<dyn Fn(f64) -> (f64, f64)>| {
        Case::new("fmi2DoStep", class, expected, move |unit| {
            let (time, step) = times(unit.time);
            unit.step_at(time, step)
        })
    };
    let mut cases = vec![
        case("valid", OK, Box::new(move |t| (t, h))),
        case("a third of a step", OK, Box::new(move |t| (t, h / 3.0))),
        case("an ulp more", OK, Box::new(move |t| (t.next_up(), h.next_up()))),
        case("half a thousandth late", OK, Box::new(move |t| (t + 0.5e-3 * h, h))),
        case("half a thousandth early", OK, Box::new(move |t| (t - 0.5e-3 * h, h))),
        case("two thousandths late", ERROR, Box::new(move |t| (t + 2e-3 * h, h))),
        case("two thousandths early", ERROR, Box::new(move |t| (t - 2e-3 * h, h))),
        case("a step skipped", ERROR, Box::new(move |t| (t + h, h))),
        case("the step before again", ERROR, Box::new(move |t| (t - h, h))),
        case("size 0", ERROR, Box::new(|t| (t, 0.0))),
        case("size -0", ERROR, Box::new(|t| (t, -0.0))),
        case("size negative", ERROR, Box::new(move |t| (t, -h))),
    ];
    for value in [NAN, INFINITY, -INFINITY] {
        cases.push(case(&format!("size {value}"), ERROR, Box::new(move |t| (t, value))));
        cases.push(case(&format!("time {value}"), ERROR, Box::new(move |_| (value, h))));
        cases.push(case(&format!("both {value}"), ERROR, Box::new(move |_| (value, value))));
    }
    cases
}

fn statuses<'s>() -> Vec<Case<'s>> {
    let mut cases = Vec::new();
    // fmi2StatusKind: fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated,
    // and numbers that are none.
    for kind in [0, 1, 2, 3, 4, -1, i32::MAX] {
        let known = |answered: i32| if kind == answered { OK } else { DISCARD };
        let class = format!("kind {kind}");
        cases.push(Case::new("fmi2GetStatus", &class, DISCARD, move |unit| {
            let mut value = 99;
            // SAFETY: a live instance, a place for the value.
            let status = unsafe { (unit.api.get_status)(unit.component, kind, &mut value) };
            assert_eq!(value, 99);
            status
        }));
        cases.push(Case::new("fmi2GetRealStatus", &class, known(2), move |unit| {
            let mut value = NAN;
            // SAFETY: as above.
            let status = unsafe { (unit.api.get_real_status)(unit.component, kind, &mut value) };
            let expected = if status == OK { unit.time } else { NAN };
            assert_eq!(value.to_bits(), expected.to_bits());
            status
        }));
        cases.push(Case::new("fmi2GetIntegerStatus", &class, DISCARD, move |unit| {
            let mut value = 99;
            // SAFETY: as above.
            let status = unsafe { (unit.api.get_integer_status)(unit.component, kind, &mut value) };
            assert_eq!(value, 99);
            status
        }));
        cases.push(Case::new("fmi2GetBooleanStatus", &class, known(3), move |unit| {
            let mut value = 99;
            // SAFETY: as above.
            let status = unsafe { (unit.api.get_boolean_status)(unit.component, kind, &mut value) };
            assert_eq!(value, if status == OK { 0 } else { 99 });
            status
        }));
        cases.push(Case::new("fmi2GetStringStatus", &class, DISCARD, move |unit| {
            let mut value = null();
            // SAFETY: as above.
            unsafe { (unit.api.get_string_status)(unit.component, kind, &mut value) }
        }));
    }
    // SAFETY, for all five: a live instance; a null pointer is not written to.
    cases.push(Case::new("fmi2GetStatus", "NULL", ERROR, |unit| {
        // SAFETY: see above.
        unsafe { (unit.api.get_status)(unit.component, 0, null_mut()) }
    }));
    cases.push(Case::new("fmi2GetRealStatus", "NULL", ERROR, |unit| {
        // SAFETY: see above.
        unsafe { (unit.api.get_real_status)(unit.component, 2, null_mut()) }
    }));
    cases.push(Case::new("fmi2GetIntegerStatus", "NULL", ERROR, |unit| {
        // SAFETY: see above.
        unsafe { (unit.api.get_integer_status)(unit.component, 0, null_mut()) }
    }));
    cases.push(Case::new("fmi2GetBooleanStatus", "NULL", ERROR, |unit| {
        // SAFETY: see above.
        unsafe { (unit.api.get_boolean_status)(unit.component, 3, null_mut()) }
    }));
    cases.push(Case::new("fmi2GetStringStatus", "NULL", ERROR, |unit| {
        // SAFETY: see above.
        unsafe { (unit.api.get_string_status)(unit.component, 1, null_mut()) }
    }));
    cases
}

/// No step ends past a stop time that was defined, up to a thousandth of a step.
#[test]
fn the_stop_time_is_kept() {
    for sample in crate::samples::samples() {
        let h = sample.step();
        for (stop, fits) in [(2.0 * h, true), (2.0 * h + 0.5e-3 * h, true), (1.9 * h, false)] {
            let unit = Unit::new(sample);
            // SAFETY: a live instance.
            unsafe {
                let c = unit.component;
                assert_eq!((unit.api.setup_experiment)(c, 0, 0.0, 0.0, 1, stop), OK);
                assert_eq!((unit.api.enter_initialization_mode)(c), OK);
            }
            assert_eq!(unit.exit_initialization(), OK);
            assert_eq!(unit.step_at(0.0, h), OK);
            let status = unit.step_at(h, h);
            assert_eq!(status, if fits { OK } else { ERROR }, "{} {stop}", sample.name());
        }
    }
}
