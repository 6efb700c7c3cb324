//! Which times are accepted.

use super::host::{ERROR, Host, OK, call};
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
fn times_that_cannot_be() {
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
    for tolerance in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let host = Host::new(false);
        assert_eq!(call!(host, setup_experiment(1, tolerance, 0.0, 0, 0.0)), ERROR, "{tolerance}");
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
fn the_first_communication_point_is_the_start_time() {
    let host = experiment(5.0, None);
    assert_eq!(host.do_step(5.0, 0.1), OK);
    assert_eq!(host.do_step(5.1, 0.1), OK);
    assert_eq!(experiment(5.0, None).do_step(0.0, 0.1), ERROR);
}

#[test]
fn both_ways_of_counting_time_are_accepted() {
    for start in [0.0, 1e5] {
        let (sum, product) = (experiment(start, None), experiment(start, None));
        let mut time = start;
        for k in 0..100_000 {
            assert_eq!(sum.do_step(time, 0.01), OK);
            time += 0.01;
            let (from, to) = (start + f64::from(k) * 0.01, start + f64::from(k + 1) * 0.01);
            assert_eq!(product.do_step(from, to - from), OK);
        }
    }
    // Steps so short that the clock cannot tell a thousandth of one.
    let host = experiment(1e5, None);
    for k in 0..1000 {
        assert_eq!(host.do_step(1e5 + f64::from(k) * 1e-9, 1e-9), OK, "{k}");
    }
}

#[test]
fn the_stop_time_is_not_passed() {
    let host = experiment(0.0, Some(0.3));
    // 0.1 + 0.2 is above 0.3.
    assert_eq!(host.do_step(0.0, 0.1), OK);
    assert_eq!(host.do_step(0.1, 0.1), OK);
    assert_eq!(host.do_step(0.2, 0.1), OK);
    assert_eq!(host.do_step(0.3, 0.1), ERROR);
    assert!(host.take_lines()[0].3.contains("stop time 0.3"));
    assert_eq!(experiment(0.0, Some(1.0)).do_step(0.0, 1.0009), OK);
    assert_eq!(experiment(0.0, Some(1.0)).do_step(0.0, 1.0012), ERROR);
    assert_eq!(experiment(0.0, None).do_step(0.0, 1e9), OK);
}
