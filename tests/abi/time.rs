//! Ten million steps, as importers count time: none refused, no tick lost or gained.
//!
//! An integrating controller shows its ticks: with kp = kd = 0 and a constant error e, each tick
//! adds ki·Ts·e, so the steering angle over that product is the number of ticks, tick 0 included.

use crate::api::OK;
use crate::samples::sample;
use crate::unit::Unit;

const STEPS: u32 = 10_000_000;
/// Yaw error, rad.
const ERROR_RAD: f64 = 0.5;
/// Increment of one tick, rad.
const INCREMENT: f64 = 1.0 / (1 << 24) as f64;

/// A controller that counts its ticks, at its first communication point.
fn counter(sample_time: f64, start: f64) -> Unit<'static> {
    let pid = sample("LateralPid");
    let mut unit = Unit::new(pid);
    assert_eq!(unit.setup(start), OK);
    // SAFETY: a live instance.
    assert_eq!(unsafe { (unit.api.enter_initialization_mode)(unit.component) }, OK);
    for (name, value) in [
        ("kp", 0.0),
        ("ki", INCREMENT / (sample_time * ERROR_RAD)),
        ("kd", 0.0),
        ("max_angle", 1e3),
        ("max_increment", 1e3),
        ("max_rate", 1e6),
        ("sample_time", sample_time),
        ("yaw", 0.0),
        ("yaw_reference", ERROR_RAD),
    ] {
        assert_eq!(unit.set_real(pid.reference(name), value), OK, "{name}");
    }
    assert_eq!(unit.exit_initialization(), OK);
    unit.time = start;
    // As an importer does before it steps; what is read last is what tick 0 takes.
    assert_eq!(ticks(&unit), 1);
    unit
}

/// The number of ticks so far.
fn ticks(unit: &Unit<'_>) -> u64 {
    let angle = unit.real(unit.sample.reference("steering_angle"));
    let count = angle / INCREMENT;
    assert!((count - count.round()).abs() < 1e-3, "{count} ticks");
    count.round() as u64
}

/// Steps from time to time as `steps_of_importer` has them; `per_tick` steps are a sample.
fn run(
    sample_time: f64,
    steps: u32,
    per_tick: u32,
    steps_of_importer: impl Fn(u32, f64) -> (f64, f64),
) {
    let unit = counter(sample_time, steps_of_importer(0, 0.0).0);
    let (component, do_step) = (unit.component, unit.api.do_step);
    let mut end = steps_of_importer(0, 0.0).0;
    for k in 0..steps {
        let (time, step) = steps_of_importer(k, end);
        // SAFETY: a live instance.
        let status = unsafe { do_step(component, time, step, 1) };
        assert_eq!(status, OK, "step {k} at {time}: {:?}", unit.lines.take());
        end = time + step;
        // Often at first, where a mistake in the phase would show, and at the end.
        if k < 1000 || k % 1_000_003 == 0 || k + 1 == steps {
            let expected = 1 + u64::from((k + 1) / per_tick);
            assert_eq!(ticks(&unit), expected, "after step {k}, {step} s a step");
        }
    }
}

#[test]
fn ten_million_steps_with_added_times() {
    for sample_time in [0.01, 1.0 / 60.0] {
        run(sample_time, STEPS, 1, |_, end| (end, sample_time));
    }
}

#[test]
fn ten_million_steps_with_multiplied_times() {
    for sample_time in [0.01, 1.0 / 60.0] {
        run(sample_time, STEPS, 1, |k, _| (f64::from(k) * sample_time, sample_time));
    }
}

/// The size of a step is the difference of two such times, an ulp more or less each time.
#[test]
fn ten_million_steps_with_multiplied_times_and_their_differences() {
    for sample_time in [0.01, 1.0 / 60.0] {
        run(sample_time, STEPS, 1, |k, _| {
            let (time, next) = (f64::from(k) * sample_time, f64::from(k + 1) * sample_time);
            (time, next - time)
        });
    }
}

/// Integer nanoseconds, in which a sixtieth of a second cannot be said.
#[test]
fn a_million_steps_in_nanoseconds() {
    for (sample_time, nanoseconds) in [(0.01, 10_000_000), (0.02, 20_000_000)] {
        run(sample_time, STEPS / 10, 1, |k, _| {
            (u64::from(k) as f64 * nanoseconds as f64 * 1e-9, nanoseconds as f64 * 1e-9)
        });
    }
}

/// Seven steps a sample, whose size is no binary fraction of it.
#[test]
fn ten_million_parts_of_a_sample() {
    let step = 0.01 / 7.0;
    run(0.01, STEPS, 7, |_, end| (end, step));
    run(0.01, STEPS, 7, |k, _| (f64::from(k) * step, step));
}

/// Two weeks after zero.
#[test]
fn a_million_steps_from_a_late_start() {
    let start = 1e6;
    for sample_time in [0.01, 1.0 / 60.0] {
        let added = |k, end| if k == 0 { (start, sample_time) } else { (end, sample_time) };
        run(sample_time, STEPS / 10, 1, added);
        run(sample_time, STEPS / 10, 1, |k, _| (start + f64::from(k) * sample_time, sample_time));
    }
}
