//! A library exported by the macro, loaded as by an importer.
#![allow(clippy::unwrap_used)] // helpers of tests are not seen as tests

mod common;

use common::{DoStep, Free, GetReal, SetReal, load, start, symbol};
use fmi2_export::calls::Call;
use fmi2_export::{Resources, describe};
use integrator::Integrator;
use libloading::Library;
use std::ffi::c_void;
use std::path::PathBuf;

#[path = "../examples/integrator.rs"]
mod integrator;

#[test]
fn all_34_functions_are_exported() {
    let library = load("integrator");
    for call in Call::ALL {
        symbol::<*const c_void>(&library, call.name());
    }
    assert_eq!(Call::ALL.len(), 34);
}

#[test]
fn it_runs_and_survives_a_panic() {
    let library = load("integrator");
    let (one, two) = (start::<Integrator>(&library), start::<Integrator>(&library));
    let set = symbol::<SetReal>(&library, "fmi2SetReal");
    let get = symbol::<GetReal>(&library, "fmi2GetReal");
    let step = symbol::<DoStep>(&library, "fmi2DoStep");
    let mut y = 0.0;
    // SAFETY: live instances, good arguments.
    unsafe {
        assert_eq!(set(one, [0, 1].as_ptr(), 2, [3.0, 2.0].as_ptr()), 0);
        assert_eq!(step(one, 0.0, 0.5, 1), 0);
        assert_eq!(get(one, &2, 1, &mut y), 0);
        assert_eq!(y, 3.0);
        assert_eq!(set(two, &0, 1, &2e6), 0);
        assert_eq!(step(two, 0.0, 0.5, 1), 4);
        assert_eq!(step(two, 0.5, 0.5, 1), 4);
        assert_eq!(step(one, 0.5, 0.5, 1), 0);
        for component in [one, two] {
            symbol::<Free>(&library, "fmi2FreeInstance")(component);
        }
    }
}

/// The library is unloaded completely, with and without a panic; each load starts from new.
#[test]
#[cfg(target_os = "linux")]
fn it_is_unloaded_2000_times() {
    // A separate copy, since other tests have the library loaded.
    let copy = tempfile::tempdir().unwrap();
    let file = copy.path().join("alone.so");
    std::fs::copy(common::path("integrator"), &file).unwrap();
    let mapped = || std::fs::read_to_string("/proc/self/maps").unwrap().contains("alone.so");
    for cycle in 0..2000 {
        // SAFETY: our own library.
        let library = unsafe { Library::new(&file) }.unwrap();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let component = start::<Integrator>(&library);
                // SAFETY: a live instance, good arguments; every tenth panics.
                unsafe {
                    let speed = if cycle % 10 == 0 { 2e6 } else { 1.0 };
                    assert_eq!(
                        symbol::<SetReal>(&library, "fmi2SetReal")(component, &0, 1, &speed),
                        0
                    );
                    let status = symbol::<DoStep>(&library, "fmi2DoStep")(component, 0.0, 0.1, 1);
                    assert_eq!(status, if cycle % 10 == 0 { 4 } else { 0 });
                    symbol::<Free>(&library, "fmi2FreeInstance")(component);
                }
            });
        });
        if cycle % 100 == 0 {
            assert!(mapped());
            drop(library);
            assert!(!mapped(), "still loaded after cycle {cycle}");
        }
    }
    assert!(!mapped());
}

/// The description is written next to the tests, to try importers by hand.
#[test]
fn its_description_has_no_faults() {
    let description = describe::<Integrator>(&Resources::default(), None).unwrap();
    assert_eq!(description.findings(), []);
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("Integrator.xml");
    std::fs::write(path, description.to_xml()).unwrap();
}
