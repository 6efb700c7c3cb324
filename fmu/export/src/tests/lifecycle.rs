//! Instantiation, the logger and its categories, drop balance, descriptions.

use super::host::{ERROR, Host, Lines, OK, WARNING, call, callbacks, guid};
use super::probe::{ERROR_IN_STEP, FAULT, LIVE, Probe, TABLE, U, WARNING_IN_STEP};
use crate::calls::State;
use crate::logger::LOG_CATEGORIES;
use crate::resources::Resources;
use crate::{boundary as c, describe};
use std::ffi::{CStr, CString, c_void};
use std::ptr::null;

fn instantiate(
    name: Option<&CStr>,
    fmu_type: i32,
    guid: Option<&CStr>,
    location: Option<&CStr>,
    lines: &Lines,
) -> *mut c_void {
    let pointer = |text: Option<&CStr>| text.map_or(null(), CStr::as_ptr);
    let callbacks = callbacks(lines);
    // SAFETY: valid strings or null.
    unsafe {
        c::instantiate::<Probe>(
            pointer(name),
            fmu_type,
            pointer(guid),
            pointer(location),
            &callbacks,
            0,
            0,
        )
    }
}

#[test]
fn rejected_instantiations() {
    let good = guid();
    let braces = CString::new(format!("{{{}}}", good.to_str().unwrap())).unwrap();
    let cases = [
        (None, 1, Some(good.as_c_str()), None),
        (Some(c""), 1, Some(good.as_c_str()), None),
        (Some(c" \t"), 1, Some(good.as_c_str()), None),
        (Some(c"a"), 0, Some(good.as_c_str()), None),
        (Some(c"a"), 7, Some(good.as_c_str()), None),
        (Some(c"a"), 1, None, None),
        (Some(c"a"), 1, Some(c""), None),
        (Some(c"a"), 1, Some(c"00000000-0000-0000-0000-000000000000"), None),
        (Some(c"a"), 1, Some(braces.as_c_str()), None),
        (Some(c"a"), 1, Some(good.as_c_str()), Some(c"http://example.org/resources")),
        (Some(c"a"), 1, Some(good.as_c_str()), Some(c"")),
    ];
    for case in cases {
        let lines = Lines::default();
        let component = instantiate(case.0, case.1, case.2, case.3, &lines);
        assert!(component.is_null(), "{case:?}");
        let lines = lines.take();
        assert_eq!(lines.len(), 1, "{case:?}: {lines:?}");
        assert_eq!((lines[0].1, lines[0].2.as_str()), (ERROR, "logStatusError"));
    }
    assert_eq!(LIVE.get(), 0);
}

#[test]
fn no_logger_and_no_callbacks() {
    let mut silent = callbacks(&Lines::default());
    silent.logger = None;
    for callbacks in [null(), &raw const silent] {
        for id in [guid(), c"wrong".to_owned()] {
            // SAFETY: valid strings; no callbacks, or no logger in them.
            unsafe {
                let component =
                    c::instantiate::<Probe>(c"a".as_ptr(), 1, id.as_ptr(), null(), callbacks, 0, 1);
                assert_eq!(component.is_null(), id != guid());
                if !component.is_null() {
                    assert_eq!(c::do_step::<Probe>(component, 0.0, 1.0, 1), ERROR);
                    c::free_instance::<Probe>(component);
                }
            }
        }
    }
}

#[test]
fn resources_are_found_however_their_folder_is_spelled() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("a b ü%20").join("resources");
    std::fs::create_dir_all(folder.join("more")).unwrap();
    std::fs::write(folder.join("data.json"), b"{}").unwrap();
    std::fs::write(folder.join("more/x.bin"), [0, 1, 2]).unwrap();
    let files = vec![("more/x.bin".into(), vec![0, 1, 2]), ("data.json".into(), b"{}".to_vec())];
    let resources = Resources::read(&folder).unwrap();
    assert_eq!(resources, Resources::from(files));
    assert_eq!(resources.get("more/x.bin"), Some([0, 1, 2].as_slice()));
    assert_eq!(resources.get("x.bin"), None);

    let id = CString::new(crate::guid::<Probe>(&resources)).unwrap();
    let path = folder.to_str().unwrap();
    let escaped = path.replace('%', "%25").replace(' ', "%20").replace('ü', "%C3%BC");
    for location in [
        format!("file://{escaped}"),
        format!("file:{escaped}"),
        format!("file:///{escaped}"),
        format!("file://localhost{escaped}/"),
        format!("file://{path}"),
        path.to_owned(),
    ] {
        let lines = Lines::default();
        let location = CString::new(location).unwrap();
        let component = instantiate(Some(c"a"), 1, Some(&id), Some(&location), &lines);
        assert!(!component.is_null(), "{location:?}: {lines:?}");
        // SAFETY: made above.
        unsafe { c::free_instance::<Probe>(component) };
    }
    // Other resources have another GUID.
    let lines = Lines::default();
    assert!(instantiate(Some(c"a"), 1, Some(&id), None, &lines).is_null());
    assert!(lines.borrow()[0].3.contains("GUID"), "{lines:?}");
}

#[test]
fn a_unit_may_reject_its_resources() {
    for (content, status) in [("bad", ERROR), ("panic", super::host::FATAL)] {
        let root = tempfile::tempdir().unwrap();
        std::fs::write(root.path().join("fault.txt"), content).unwrap();
        let resources = Resources::read(root.path()).unwrap();
        let id = CString::new(crate::guid::<Probe>(&resources)).unwrap();
        let location = CString::new(root.path().to_str().unwrap()).unwrap();
        let lines = Lines::default();
        assert!(instantiate(Some(c"a"), 1, Some(&id), Some(&location), &lines).is_null());
        assert_eq!((lines.borrow().len(), lines.borrow()[0].1), (1, status), "{lines:?}");
    }
}

#[test]
fn the_callbacks_and_the_name_are_copied() {
    let lines = Lines::default();
    let component = {
        let name = CString::new("short-lived").unwrap();
        instantiate(Some(&name), 1, Some(&guid()), None, &lines)
    };
    // SAFETY: made above.
    unsafe {
        assert_eq!(c::do_step::<Probe>(component, 0.0, 1.0, 1), ERROR);
        c::free_instance::<Probe>(component);
    }
    assert_eq!(lines.borrow()[0].0, "short-lived");
}

#[test]
fn messages_are_not_formats_and_their_categories_are_declared() {
    let host = Host::in_state(State::StepComplete);
    assert_eq!(host.set_integer(FAULT, ERROR_IN_STEP), OK);
    assert_eq!(host.do_step(0.0, 1.0), ERROR);
    let lines = host.take_lines();
    assert_eq!(lines.len(), 1);
    assert_eq!(lines[0].3, "fmi2DoStep: diverged 100% %s");
    assert!(LOG_CATEGORIES.iter().any(|(name, _)| *name == lines[0].2));
}

#[test]
fn a_warning_of_the_unit_is_logged_and_returned() {
    let host = Host::in_state(State::StepComplete);
    assert_eq!(host.set_integer(FAULT, WARNING_IN_STEP), OK);
    assert_eq!(host.do_step(0.0, 1.0), WARNING);
    assert_eq!(host.state(), State::StepComplete);
    assert_eq!(host.take_lines()[0].3, "too fast");
}

/// The categories that are logged, of an event, a warning and an error.
fn logged(on: i32, categories: &[&CStr]) -> (i32, Vec<String>) {
    let host = Host::new(false);
    let pointers: Vec<_> = categories.iter().map(|name| name.as_ptr()).collect();
    let status = call!(host, set_debug_logging(on, pointers.len(), pointers.as_ptr()));
    host.take_lines();
    assert_eq!(host.set_real(U, 1.0), OK);
    assert_eq!(host.set_real(U, 100.0), WARNING);
    assert_eq!(host.do_step(0.0, 1.0), ERROR);
    (status, host.take_lines().into_iter().map(|line| line.2).collect())
}

#[test]
fn categories_are_respected() {
    let all = ["logEvents", "logStatusWarning", "logStatusError"];
    let owned = |names: &[&str]| (OK, names.iter().map(|name| (*name).to_owned()).collect());
    assert_eq!(logged(1, &[]), owned(&all));
    assert_eq!(logged(1, &[c"logAll"]), owned(&all));
    assert_eq!(logged(0, &[]), owned(&all[1..]));
    assert_eq!(logged(1, &[c"logEvents"]), owned(&all[..1]));
    assert_eq!(logged(1, &[c"logStatusError", c"logStatusFatal"]), owned(&all[2..]));
    assert_eq!(logged(0, &[c"logStatusWarning"]), owned(&all[2..]));
    assert_eq!(logged(1, &[c"nonsense", c"logEvents"]), (WARNING, vec!["logEvents".into()]));
}

#[test]
fn everything_is_freed() {
    for _ in 0..100 {
        let host = Host::in_state(State::StepComplete);
        let mut state = std::ptr::null_mut();
        assert_eq!(call!(host, get_fmu_state(&mut state)), OK);
        assert_eq!(call!(host, get_fmu_state(&mut state)), OK);
        assert_eq!(call!(host, set_fmu_state(state)), OK);
        assert_eq!(call!(host, reset()), OK);
        assert_eq!(call!(host, free_fmu_state(&mut state)), OK);
        assert_eq!(LIVE.get(), 2);
        drop(host);
        assert_eq!(LIVE.get(), 0);
        drop(Host::in_state(State::Fatal));
        assert_eq!(LIVE.get(), 0);
    }
}

#[test]
fn any_number_of_instances_on_any_threads() {
    std::thread::scope(|scope| {
        for thread in 0..8 {
            scope.spawn(move || {
                for _ in 0..100 {
                    let hosts: Vec<Host> =
                        (0..4).map(|_| Host::in_state(State::StepComplete)).collect();
                    for (k, host) in hosts.iter().enumerate() {
                        let speed = (thread * 4 + k) as f64 / 10.0;
                        let mut state = std::ptr::null_mut();
                        assert_eq!(host.set_real(U, speed), OK);
                        assert_eq!(call!(host, get_fmu_state(&mut state)), OK);
                        assert_eq!(host.do_step(0.0, 0.5), OK);
                        assert_eq!(host.real(super::probe::Y), speed);
                        assert_eq!(call!(host, set_fmu_state(state)), OK);
                        assert_eq!(call!(host, free_fmu_state(&mut state)), OK);
                        assert_eq!(host.real(super::probe::Y), 0.0);
                    }
                }
                assert_eq!(LIVE.get(), 0);
            });
        }
    });
}

#[test]
fn the_description_is_that_of_the_library() {
    let description = describe::<Probe>(&Resources::default(), None).unwrap();
    assert_eq!(description.findings(), []);
    assert_eq!(description.guid, guid().to_str().unwrap());
    let co_simulation = description.co_simulation.as_ref().unwrap();
    assert_eq!(co_simulation.model_identifier, TABLE.model_name);
    assert!(co_simulation.can_get_and_set_fmu_state);
    assert_eq!(description.variable("gain").unwrap().start, Some(2.0.into()));
    let names: Vec<&str> = description.log_categories.iter().map(|c| c.name.as_str()).collect();
    assert!(names.contains(&"logAll") && names.contains(&"logStatusError"));
}
