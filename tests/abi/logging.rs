//! Log lines: declared categories only, nothing without a reason.

use crate::api::{DISCARD, ERROR, OK, WARNING};
use crate::samples::{Sample, samples};
use crate::unit::{Birth, Line, Unit};
use model_description::{Causality, Kind, Value};
use std::ffi::{CStr, c_char};

/// Something of each kind: the messages, in order.
fn provoke(unit: &Unit<'_>) -> Vec<Line> {
    let sample = unit.sample;
    unit.lines.take();
    let clipped = sample.of(Kind::Real, Causality::Input).find(|v| v.min.is_some());
    // An event: a leniency.
    let input = sample.continuous(Causality::Input)[0];
    assert_eq!(unit.set(input, &Value::Real(0.0)), OK);
    unit.begin();
    assert!(unit.exit_initialization() <= 1);
    // A discard.
    let mut integer = 0;
    // SAFETY: a live instance, a place for the value.
    let status = unsafe { (unit.api.get_status)(unit.component, 0, &mut integer) };
    assert_eq!(status, DISCARD);
    // A warning: once, where an input has limits.
    if let Some(input) = clipped {
        let below = input.min.unwrap_or_default() - 1.0;
        assert_eq!(unit.set_real(input.reference, below), WARNING);
        assert_eq!(unit.set_real(input.reference, below), OK);
    }
    // An error.
    assert_eq!(unit.cancel(), ERROR);
    unit.lines.take()
}

fn set_logging(unit: &Unit<'_>, on: bool, categories: &[&CStr]) {
    let pointers: Vec<*const c_char> = categories.iter().map(|c| c.as_ptr()).collect();
    let (n, on) = (pointers.len(), i32::from(on));
    // SAFETY: a live instance, as many strings as declared.
    let status = unsafe { (unit.api.set_debug_logging)(unit.component, on, n, pointers.as_ptr()) };
    assert_eq!(status, OK);
}

fn born(sample: &Sample, logging_on: bool) -> Unit<'_> {
    let unit = Birth { logging_on, ..Birth::of(sample) }.give(sample);
    assert!(!unit.component.is_null());
    unit
}

fn categories(lines: &[Line]) -> Vec<&str> {
    let mut all: Vec<&str> = lines.iter().map(|line| line.category.as_str()).collect();
    all.dedup();
    all
}

/// The category goes with the status, both with the call, and the format is never the text.
#[test]
fn with_logging_everything_is_logged_in_declared_categories() {
    for sample in samples() {
        let declared: Vec<&str> =
            sample.description.log_categories.iter().map(|c| c.name.as_str()).collect();
        let lines = provoke(&born(sample, true));
        for line in &lines {
            assert!(declared.contains(&line.category.as_str()), "{line:?}");
            assert_eq!(line.format, "%s");
            assert_eq!(line.instance, "one");
            let expected = ["logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError"];
            assert_eq!(line.category, expected[line.status as usize], "{line:?}");
            assert!(!line.text.is_empty() && !line.text.contains('\n'), "{line:?}");
        }
        let logged = categories(&lines);
        for expected in ["logEvents", "logStatusDiscard", "logStatusError"] {
            assert!(logged.contains(&expected), "{}: {lines:?}", sample.name());
        }
    }
}

/// The standard has a message come with each warning and error; the rest is debug logging.
#[test]
fn without_logging_warnings_and_errors_alone_are_logged() {
    for sample in samples() {
        let lines = provoke(&born(sample, false));
        assert!(lines.iter().all(|l| [WARNING, ERROR].contains(&l.status)), "{lines:?}");
        assert_eq!(lines.iter().filter(|l| l.status == ERROR).count(), 1, "{lines:?}");
    }
}

/// A run in which nothing is wrong.
#[test]
fn a_good_run_is_silent() {
    for sample in samples() {
        for logging_on in [false, true] {
            let mut unit = born(sample, logging_on);
            unit.begin();
            assert_eq!(unit.exit_initialization(), OK);
            unit.drive(0, 50);
            assert_eq!(unit.terminate(), OK);
            let mut lines = unit.lines.take();
            // The run sets all inputs, of which a model of accelerator and brake does not have each.
            lines.retain(|line| !line.text.contains("has no effect: "));
            assert_eq!(lines, [], "{} {logging_on}", sample.name());
        }
    }
}

#[test]
fn categories_are_chosen_one_by_one() {
    let all = ["logEvents", "logStatusDiscard", "logStatusWarning", "logStatusError"];
    for sample in samples() {
        let everything = provoke(&born(sample, true));
        let present = categories(&everything);
        for (name, chosen) in all.into_iter().zip([
            c"logEvents",
            c"logStatusDiscard",
            c"logStatusWarning",
            c"logStatusError",
        ]) {
            let unit = born(sample, false);
            set_logging(&unit, true, &[chosen]);
            let expected: Vec<&str> = present.iter().copied().filter(|p| *p == name).collect();
            assert_eq!(categories(&provoke(&unit)), expected, "{} only {name}", sample.name());

            let unit = born(sample, true);
            set_logging(&unit, false, &[chosen]);
            let expected: Vec<&str> = present.iter().copied().filter(|p| *p != name).collect();
            assert_eq!(categories(&provoke(&unit)), expected, "{} without {name}", sample.name());
        }
        let unit = born(sample, false);
        set_logging(&unit, true, &[c"logAll"]);
        assert_eq!(provoke(&unit), everything, "{}", sample.name());
        let unit = born(sample, true);
        set_logging(&unit, false, &[]);
        assert_eq!(provoke(&unit), provoke(&born(sample, false)), "{}", sample.name());
    }
}

/// A name and a GUID that are formats of `printf` are passed as they are, and never as a format.
#[test]
fn formats_in_names_are_text() {
    let name = c"%s%n%d 100% %";
    for sample in samples() {
        let unit = Birth { name: Some(name), ..Birth::of(sample) }.give(sample);
        assert_eq!(unit.cancel(), ERROR);
        let lines = unit.lines.take();
        assert_eq!((&*lines[0].instance, &*lines[0].format), ("%s%n%d 100% %", "%s"));

        let mut birth = Birth::of(sample);
        birth.guid = Some(c"%n%s".into());
        let lines = birth.give(sample).lines.take();
        assert_eq!(lines[0].format, "%s");
        assert!(lines[0].text.contains("the GUID given is \"%n%s\""), "{lines:?}");

        birth = Birth::of(sample);
        birth.location = Some(c"ftp://%n%s%20".into());
        let lines = birth.give(sample).lines.take();
        assert_eq!(lines[0].format, "%s");
        assert!(lines[0].text.contains("ftp://%n%s%20"), "{lines:?}");
    }
}
