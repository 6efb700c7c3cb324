//! Accepted and rejected times.

use super::host::{ERROR, Host, OK, WARNING, call};
use crate::calls::State;

fn experiment(start: f64, stop: Option<f64>) -> Host {
    let host = Host::new(false);
    let status = call!(
        host,
        setup_experiment(0, f64::NAN, start, i32::from(stop.is_some()), stop.unwrap_or(f64::NAN))
    );
    assert_eq!(status, OK);
    assert_eq!(call!(host, enter_initialization_mode()), OK);
    assert_eq!(call!(host, exit_initialization_mode()), OK);
    host
}

#[test]
fn invalid_times() {
    for (start, stop_defined, stop) in [
        (f64::NAN, 0, 0.0),
        (f64::INFINITY, 0, 0.0),
        (0.0, 1, f64::NAN),
        (0.0, 1, f64::INFINITY),
        (1.0, 1, 0.5),
        (0.0, 2, 1.0),
    ] {
        let host = Host::new(false);
        let status = call!(host, setup_experiment(0, 0.0, start, stop_defined, stop));
        assert_eq!(status, ERROR, "{start} {stop}");
    }
    for (tolerance, expected) in
        [(f64::NAN, ERROR), (f64::INFINITY, ERROR), (0.0, WARNING), (-1.0, WARNING), (1e-320, OK)]
    {
        let host = Host::new(false);
        let status = call!(host, setup_experiment(1, tolerance, 0.0, 0, 0.0));
        assert_eq!(status, expected, "{tolerance}");
    }
    for (time, step) in [
        (0.0, 0.0),
        (0.0, -0.1),
        (0.0, f64::NAN),
        (0.0, f64::INFINITY),
        (f64::NAN, 0.1),
        (f64::INFINITY, 0.1),
        (f64::NEG_INFINITY, 0.1),
        (0.1, 0.1),
        (-0.1, 0.1),
        (0.00011, 0.1),
    ] {
        let host = experiment(0.0, None);
        assert_eq!(host.do_step(time, step), ERROR, "{time} {step}");
        assert_eq!(host.state(), State::Error);
        assert_eq!(host.real(super::probe::Y), 0.0);
    }
}

#[test]
fn a_step_without_a_finite_end_is_reported() {
    let host = experiment(f64::MAX, None);
    assert_eq!(host.do_step(f64::MAX, f64::MAX), ERROR);
    let lines = host.take_lines();
    assert!(lines.iter().any(|line| line.3.contains("has no finite end")), "{lines:?}");
}

#[test]
fn the_first_communication_point_is_the_start_time() {
    let host = experiment(5.0, None);
    assert_eq!(host.do_step(5.0, 0.1), OK);
    assert_eq!(host.do_step(5.1, 0.1), OK);
    assert_eq!(experiment(5.0, None).do_step(0.0, 0.1), ERROR);
}

/// Ten million steps in optimized code, else a million: times `t += h` and `k h`, at rates with and
/// without a binary fraction, up to a stop time; all are accepted.
#[test]
fn both_ways_of_counting_time_are_accepted() {
    let count = if cfg!(debug_assertions) { 1_000_000 } else { 10_000_000 };
    for (start, rate) in [(0.0, 100.0), (1e5, 100.0), (0.0, 60.0)] {
        let step = 1.0 / rate;
        let stop = Some(start + f64::from(count) / rate);
        let (sum, product) = (experiment(start, stop), experiment(start, stop));
        let mut time = start;
        for k in 0..count {
            assert_eq!(sum.do_step(time, step), OK, "step {k} of {step}: {:?}", sum.take_lines());
            time += step;
            let from = start + f64::from(k) * step;
            // Every second step is the difference of the times, the others are the nominal step.
            let by = if k % 2 == 0 { start + f64::from(k + 1) * step - from } else { step };
            assert_eq!(product.do_step(from, by), OK, "step {k}: {:?}", product.take_lines());
        }
    }
    // Steps so short that a double does not resolve a thousandth of one.
    let host = experiment(1e5, None);
    for k in 0..1000 {
        assert_eq!(host.do_step(1e5 + f64::from(k) * 1e-9, 1e-9), OK, "{k}");
    }
    // Whole nanoseconds, of which a sixtieth of a second is not a multiple.
    let host = experiment(0.0, Some(1000.0 / 60.0));
    for k in 0..1000_u64 {
        let time = |k: u64| (k * 1_000_000_000 / 60) as f64 * 1e-9;
        assert_eq!(host.do_step(time(k), time(k + 1) - time(k)), OK, "{k}");
    }
}

/// Summed times drift: ten million steps of 1 ms end 1.6e-6 s late, more than a thousandth of a step.
/// The test computes the drift instead of making the steps.
#[test]
fn a_summed_time_may_drift_past_the_stop_time() {
    let last = (1..10_000_000_u32).fold(0.0_f64, |time, _| time + 0.001);
    assert!(last + 0.001 - 1e4 > 1.5e-6, "{last}");
    let host = experiment(0.0, Some(1e4));
    assert_eq!(host.do_step(0.0, last), OK);
    assert_eq!(host.do_step(last, 0.001), OK, "{:?}", host.take_lines());
    // One step more, or half a step more, is rejected.
    assert_eq!(host.do_step(last + 0.001, 0.001), ERROR);
    let host = experiment(0.0, Some(1e4));
    assert_eq!(host.do_step(0.0, 1e4 - 0.0005), OK);
    assert_eq!(host.do_step(1e4 - 0.0005, 0.001), ERROR);
}

#[test]
fn the_stop_time_is_not_passed() {
    let host = experiment(0.0, Some(0.3));
    // 0.1 + 0.2 exceeds 0.3.
    assert_eq!(host.do_step(0.0, 0.1), OK);
    assert_eq!(host.do_step(0.1, 0.1), OK);
    assert_eq!(host.do_step(0.2, 0.1), OK);
    assert_eq!(host.do_step(0.3, 0.1), ERROR);
    assert!(host.take_lines()[0].3.contains("stop time 0.3"));
    assert_eq!(experiment(0.0, Some(1.0)).do_step(0.0, 1.0009), OK);
    assert_eq!(experiment(0.0, Some(1.0)).do_step(0.0, 1.0012), ERROR);
    assert_eq!(experiment(0.0, None).do_step(0.0, 1e9), OK);
}
