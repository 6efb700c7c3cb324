//! Many instances, many threads, many lives, many loads: all the same, and memory stays flat.

use crate::api::{Api, OK};
use crate::memory::{resident, runs_alone};
use crate::samples::{Sample, sample, samples};
use crate::unit::{Birth, Unit};
use std::time::Instant;

/// Memory that may be gained between a warm-up and the end, bytes.
const SLACK: usize = 1 << 20;

#[test]
fn ten_thousand_instances_at_once() {
    for sample in samples() {
        let mut reference = Unit::started(sample);
        let expected = reference.drive(0, 3);
        let mut units: Vec<Unit<'_>> = (0..10_000).map(|_| Unit::started(sample)).collect();
        for k in 0..3 {
            for (i, unit) in units.iter_mut().enumerate() {
                unit.steer(k);
                unit.step();
                if i % 500 == 0 {
                    assert!(unit.everything() == expected[k as usize], "{} {i}", sample.name());
                }
            }
        }
    }
}

/// Each thread makes, runs and frees instances of every FMU.
#[test]
fn eight_threads() {
    let run = |sample: &Sample| Unit::started(sample).drive(0, 200);
    let expected: Vec<_> = samples().iter().map(run).collect();
    std::thread::scope(|scope| {
        for thread in 0..8 {
            let expected = &expected;
            scope.spawn(move || {
                for _ in 0..10 {
                    for i in 0..samples().len() {
                        let which = (i + thread) % samples().len();
                        assert!(run(&samples()[which]) == expected[which], "thread {thread}");
                    }
                }
            });
        }
    });
}

/// An instance is made by one thread, stepped by others in turn, and freed by another.
#[test]
fn instances_move_between_threads() {
    for sample in samples() {
        let expected = Unit::started(sample).drive(0, 40);
        let made =
            std::thread::scope(|scope| scope.spawn(|| Unit::started(sample)).join().unwrap());
        let mut unit = made;
        let mut all = Vec::new();
        for turn in 0..8 {
            let part =
                std::thread::scope(|scope| scope.spawn(|| unit.drive(turn * 5, 5)).join().unwrap());
            all.extend(part);
        }
        assert!(all == expected, "{}", sample.name());
        std::thread::scope(|scope| drop(scope.spawn(move || drop(unit))));
    }
}

/// A life: made, started, stepped, saved, restored, freed.
fn life(sample: &Sample) {
    let mut unit = Unit::started(sample);
    unit.steer(0);
    unit.step();
    let state = unit.save();
    assert_eq!(unit.restore(state), OK);
    unit.free(state);
}

/// `count` lives of an FMU; the memory after the first tenth is the memory at the end.
fn lives(sample: &Sample, count: usize) {
    let begin = Instant::now();
    let mut warm = 0;
    for k in 0..count {
        if k == count / 10 {
            warm = resident();
        }
        life(sample);
    }
    let gained = resident().saturating_sub(warm);
    let each = begin.elapsed().as_secs_f64() * 1e6 / count as f64;
    println!("{}: {count} lives, {each:.1} us each, {gained} bytes gained", sample.name());
    assert!(gained <= SLACK, "{}: {gained} bytes gained in {count} lives", sample.name());
}

#[test]
fn thousands_of_lives_leave_nothing_behind() {
    if runs_alone("many::thousands_of_lives_leave_nothing_behind") {
        return;
    }
    for sample in samples() {
        lives(sample, 10_000);
    }
}

#[test]
#[ignore = "minutes: cargo xtask stress"]
fn stress_a_million_lives_leave_nothing_behind() {
    if runs_alone("many::stress_a_million_lives_leave_nothing_behind") {
        return;
    }
    lives(sample("LateralPid"), 1_000_000);
    lives(sample("BicyclePlant"), 1_000_000);
}

/// Instantiations that fail leave nothing behind either.
#[test]
fn refusals_leave_nothing_behind() {
    if runs_alone("many::refusals_leave_nothing_behind") {
        return;
    }
    for sample in samples() {
        let refused = || {
            let mut birth = Birth::of(sample);
            birth.guid = Some(c"another".into());
            assert!(birth.give(sample).component.is_null());
        };
        (0..500).for_each(|_| refused());
        let warm = resident();
        (0..5000).for_each(|_| refused());
        let gained = resident().saturating_sub(warm);
        assert!(gained <= SLACK, "{}: {gained} bytes gained", sample.name());
    }
}

/// States that are saved and freed, and states that are reused, leave nothing behind.
#[test]
fn states_leave_nothing_behind() {
    if runs_alone("many::states_leave_nothing_behind") {
        return;
    }
    for sample in samples() {
        let mut unit = Unit::started(sample);
        let mut cycle = |k: u32| {
            unit.steer(k);
            unit.step();
            let mut state = unit.save();
            // SAFETY: a live instance and state.
            assert_eq!(unsafe { (unit.api.get_fmu_state)(unit.component, &mut state) }, OK);
            assert_eq!(unit.restore(state), OK);
            unit.free(state);
            if sample.flags().can_serialize_fmu_state {
                let bytes = unit.serialized();
                assert_eq!(unit.deserialize(&bytes), OK);
            }
        };
        (0..1000).for_each(&mut cycle);
        let warm = resident();
        (1000..21_000).for_each(&mut cycle);
        let gained = resident().saturating_sub(warm);
        assert!(gained <= SLACK, "{}: {gained} bytes gained", sample.name());
    }
}

/// Loaded, used and unloaded again and again: gone each time, and memory stays flat.
#[test]
#[cfg(target_os = "linux")]
fn two_thousand_loads() {
    if runs_alone("many::two_thousand_loads") {
        return;
    }
    for sample in samples() {
        // A copy, for the sample's own is loaded all the time.
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("copy_of_the_library.so");
        std::fs::copy(&sample.library, &file).unwrap();
        let maps = || std::fs::read_to_string("/proc/self/maps").unwrap();
        let is_loaded = || maps().contains("copy_of_the_library.so");
        let birth = Birth::of(sample);
        let [guid, location] = [&birth.guid, &birth.location].map(|text| text.clone().unwrap());
        let mut warm = 0;
        for k in 0..2000 {
            if k == 200 {
                warm = resident();
            }
            let api = Api::load(&file);
            // SAFETY: good strings, no callbacks; the instance is freed before the library goes.
            unsafe {
                let (guid, location) = (guid.as_ptr(), location.as_ptr());
                let none = std::ptr::null();
                let c = (api.instantiate)(c"one".as_ptr(), 1, guid, location, none, 0, 0);
                assert!(!c.is_null());
                assert_eq!((api.setup_experiment)(c, 0, 0.0, 0.0, 0, 0.0), OK);
                assert_eq!((api.enter_initialization_mode)(c), OK);
                assert_eq!((api.exit_initialization_mode)(c), OK);
                assert_eq!((api.do_step)(c, 0.0, sample.step(), 1), OK);
                let mut state = std::ptr::null_mut();
                assert_eq!((api.get_fmu_state)(c, &mut state), OK);
                assert_eq!((api.free_fmu_state)(c, &mut state), OK);
                (api.free_instance)(c);
            }
            if k % 100 == 0 {
                assert!(is_loaded());
                drop(api);
                assert!(!is_loaded(), "{}: still there after load {k}", sample.name());
            }
        }
        let gained = resident().saturating_sub(warm);
        assert!(gained <= SLACK, "{}: {gained} bytes gained", sample.name());
    }
}
