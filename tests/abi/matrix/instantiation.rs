//! `fmi2Instantiate`: refused arguments, with a line in the log and NULL.

use crate::api::OK;
use crate::samples::samples;
use crate::unit::Birth;
use std::ffi::CString;
use std::ptr::{null, null_mut};

/// A change to a good birth that makes it a bad one.
type Change = Box<dyn Fn(&mut Birth<'_>)>;

#[test]
fn bad_arguments_give_null_and_a_line() {
    for sample in samples() {
        let guid = sample.description.guid.clone();
        let of = |text: String| Some(CString::new(text).unwrap());
        let mut changes: Vec<(&str, Change)> = vec![
            ("no name", Box::new(|b| b.name = None)),
            ("an empty name", Box::new(|b| b.name = Some(c""))),
            ("a blank name", Box::new(|b| b.name = Some(c" \t"))),
            ("no GUID", Box::new(|b| b.guid = None)),
            ("model exchange", Box::new(|b| b.fmu_type = 0)),
            ("type 2", Box::new(|b| b.fmu_type = 2)),
            ("type -1", Box::new(|b| b.fmu_type = -1)),
        ];
        for other in [
            String::new(),
            "00000000-0000-0000-0000-000000000000".into(),
            format!("{{{guid}}}"),
            guid[1..].to_owned(),
            format!("{guid} "),
            guid.replace(&guid[..1], "x"),
        ] {
            let other = of(other);
            changes.push(("another GUID", Box::new(move |b| b.guid = other.clone())));
        }
        for (class, change) in &changes {
            let mut birth = Birth::of(sample);
            change(&mut birth);
            let unit = birth.give(sample);
            assert!(unit.component.is_null(), "{} {class}", sample.name());
            let lines = unit.lines.take();
            assert_eq!(lines.len(), 1, "{class}: {lines:?}");
            assert_eq!((lines[0].status, &*lines[0].category), (3, "logStatusError"), "{class}");
            assert!(lines[0].text.starts_with("fmi2Instantiate: "), "{class}: {lines:?}");
        }
    }
}

/// No callbacks, no logger, flags that are no Boolean: an importer's business.
#[test]
fn careless_arguments_are_taken() {
    for sample in samples() {
        let birth = Birth::of(sample);
        let (name, guid) = (birth.name.unwrap(), birth.guid.unwrap());
        let location = birth.location.unwrap();
        let (name, guid, location) = (name.as_ptr(), guid.as_ptr(), location.as_ptr());
        let none = crate::api::Callbacks {
            logger: null(),
            allocate_memory: null(),
            free_memory: null(),
            step_finished: null(),
            environment: null_mut(),
        };
        for callbacks in [null(), &raw const none] {
            for flag in [0, 1, 7] {
                // SAFETY: strings that live for the call, null or a struct that does.
                unsafe {
                    let api = &sample.api;
                    let c = (api.instantiate)(name, 1, guid, location, callbacks, flag, flag);
                    assert!(!c.is_null());
                    // Errors have no receiver.
                    assert_eq!((api.cancel_step)(c), 3);
                    assert_eq!((api.reset)(c), OK);
                    (api.free_instance)(c);
                    let refused = (api.instantiate)(null(), 1, guid, location, callbacks, flag, 1);
                    assert!(refused.is_null());
                }
            }
        }
    }
}
