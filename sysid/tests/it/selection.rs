//! Order, horizon and feedthrough chosen from the data: right where they can be determined, the same in
//! any unit, and an error with a hint where the data allow nothing.

use crate::known::{Experiment, Random, halves, response_distance};
use faer::Mat;
use steerwright_sysid::{
    Automatic, DataSet, Detrend, Error, IdentifyOptions, Method, Segment, Signals, StateSpace,
    Weighting, automatic, simulate,
};

fn chosen(data: &DataSet, options: &IdentifyOptions) -> Result<Automatic, Error> {
    let [estimation, validation] = halves(data)?;
    automatic(&estimation, &validation, options)
}

fn noisy(e: &Experiment) -> DataSet {
    DataSet::single(1.0, e.u.clone(), e.noisy.clone()).unwrap()
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn the_order_of_random_systems_is_found() {
    let mut random = Random(23);
    let (mut right, mut count) = (0, 0);
    while count < 24 {
        let (order, direct) = (1 + count % 6, count % 4 == 3);
        let e = Experiment::random(&mut random, order, direct, 2000, 20.0);
        if e.share_of_last_state(direct) < 0.025 {
            continue;
        }
        let found = chosen(&noisy(&e), &IdentifyOptions::default()).unwrap();
        let same = found.model.order() == order && (found.model.d[(0, 0)] != 0.0) == direct;
        right += usize::from(same);
        if !same {
            println!("{order} {direct}: {}, D {:?}", found.model.order(), found.model.d);
        }
        count += 1;
    }
    assert!(right >= 23, "{right} of {count}");
}

/// Sensors with offsets, and a record that begins and ends in the middle of a manoeuvre: the output
/// offset is found with the model, so that nothing is left.
#[test]
fn offsets_leave_no_error_where_there_is_no_noise() {
    let mut random = Random(61);
    for (n, m, p) in [(1, 1, 1), (2, 1, 1), (4, 1, 1), (3, 2, 1), (3, 1, 2)] {
        let truth = StateSpace { d: Mat::zeros(p, m), ..random.system(n, m, p) };
        let u = random.matrix(m, 1000);
        let y = simulate(&truth, u.as_ref(), &vec![2.0; n]);
        let (of_u, of_y) = ([3.0, -0.2], [-5.0, 40.0]);
        let data = DataSet::single(
            0.04,
            Mat::from_fn(m, 1000, |i, t| u[(i, t)] + of_u[i]),
            Mat::from_fn(p, 1000, |i, t| y[(i, t)] + of_y[i]),
        );
        let found = chosen(&data.unwrap(), &IdentifyOptions::default()).unwrap();
        let what = format!("{n} {m} {p}: order {}", found.model.order());
        // An error of 1e-8 of the output is a fit of 100 − 1e-6 %.
        let fits = [found.estimation_fit, found.validation_fit];
        assert!(fits.iter().all(|fit| *fit > 100.0 - 1e-6), "{what}, {fits:?}");
        assert_eq!(found.model.order(), n, "{what}");
        for (i, own) in of_y.iter().enumerate().take(p) {
            let moved: f64 = (0..m)
                .map(|l| {
                    let gain = found.model.steady_state_gain(i, l).unwrap();
                    gain * (found.input_offsets[l] - of_u[l])
                })
                .sum();
            let off = found.output_offsets[i] - own - moved;
            assert!(off.abs() < 1e-7, "{what}: {off:e}");
        }
    }
}

/// A mode that dies out within a sample and lies a little on the wrong side of zero keeps no model from a
/// continuous form, a mode that truly alternates does, and without noise nothing is touched.
#[test]
fn a_negative_pole_that_hardly_shows_is_replaced_by_a_continuous_form() {
    let found = |pole: f64, noise: f64| {
        let truth = StateSpace {
            a: Mat::from_fn(2, 2, |i, j| [[0.85, 0.0], [0.0, pole]][i][j]),
            b: Mat::from_fn(2, 1, |i, _| [0.15, 0.02 * (1.0 - pole)][i]),
            c: Mat::from_fn(1, 2, |_, _| 1.0),
            d: Mat::zeros(1, 1),
        };
        let mut random = Random(5);
        let u = random.matrix(1, 3000);
        let e = random.matrix(1, 3000);
        let y = simulate(&truth, u.as_ref(), &[0.0; 2]);
        let y = Mat::from_fn(1, 3000, |_, t| y[(0, t)] + noise * e[(0, t)]);
        let data = DataSet::single(0.01, u, y).unwrap();
        let options = IdentifyOptions { order: Some(2), ..IdentifyOptions::default() };
        let found = chosen(&data, &options).unwrap();
        let mut poles = found.model.poles().unwrap();
        poles.sort_by(|a, b| a.0.total_cmp(&b.0));
        (poles[0].0, found.estimation_fit, found.model.steady_state_gain(0, 0).unwrap())
    };
    let (pole, _, gain) = found(-0.02, 0.01);
    assert!(pole > 0.0 && pole < 0.1 && (gain - 1.02).abs() < 0.01, "{pole} {gain}");
    let (alternating, ..) = found(-0.5, 0.01);
    assert!((alternating + 0.5).abs() < 0.1, "{alternating}");
    let (exact, fit, _) = found(-0.02, 0.0);
    assert!((exact + 0.02).abs() < 1e-8 && fit > 100.0 - 1e-6, "{exact} {fit}");
}

/// Second order, lightly damped, with low-pass input and coloured noise.
fn coloured(samples: usize, seed: u64) -> (StateSpace, DataSet) {
    let truth = StateSpace {
        a: Mat::from_fn(2, 2, |i, j| [[0.8, 0.25], [-0.25, 0.8]][i][j]),
        b: Mat::from_fn(2, 1, |i, _| [0.5, 0.3][i]),
        c: Mat::from_fn(1, 2, |_, j| [1.0, -0.4][j]),
        d: Mat::zeros(1, 1),
    };
    let mut random = Random(seed);
    let (white, noise) = (random.matrix(1, samples), random.matrix(1, samples));
    let low_pass = |m: &Mat<f64>, pole: f64| {
        let mut x = 0.0;
        Mat::from_fn(1, samples, |_, t| {
            x = pole * x + (1.0 - pole * pole).sqrt() * m[(0, t)];
            x
        })
    };
    let (u, e) = (low_pass(&white, 0.9), low_pass(&noise, 0.95));
    let clean = simulate(&truth, u.as_ref(), &[0.0; 2]);
    let size = 0.3 * clean.as_ref().norm_l2() / e.norm_l2();
    let y = Mat::from_fn(1, samples, |_, t| clean[(0, t)] + size * e[(0, t)] + 7.0);
    (truth, DataSet::single(0.05, u, y).unwrap())
}

#[test]
fn coloured_noise_is_no_state_and_no_feedthrough() {
    let (mut most, mut direct) = (0, 0);
    for seed in 1..=4 {
        let found = chosen(&coloured(2500, seed).1, &IdentifyOptions::default()).unwrap();
        most = most.max(found.model.order());
        direct += usize::from(found.model.d[(0, 0)] != 0.0);
    }
    assert!(most <= 2 && direct == 0, "order {most}, {direct} with feedthrough");
}

#[test]
fn more_data_bring_the_model_nearer() {
    let error = |samples: usize| {
        let errors = (1..=3).map(|seed| {
            let (truth, data) = coloured(samples, seed);
            let found = chosen(&data, &IdentifyOptions::default()).unwrap();
            response_distance(&truth, &found.model)
        });
        errors.sum::<f64>() / 3.0
    };
    let (few, many) = (error(1000), error(8000));
    assert!(many < 0.5 * few, "{few} {many}");
}

/// A first-order plant under strong coloured noise, its input answering to the output of the sample
/// before.
fn in_a_loop(samples: usize, seed: u64) -> (StateSpace, DataSet) {
    let one = |x: f64| Mat::from_fn(1, 1, |_, _| x);
    let truth = StateSpace { a: one(0.8), b: one(0.5), c: one(1.0), d: one(0.0) };
    let mut random = Random(seed);
    let (excitation, noise) = (random.matrix(1, samples), random.matrix(1, samples));
    let (mut x, mut v, mut r, mut before) = (0.0, 0.0, 0.0, 0.0);
    let (mut u, mut y) = (Mat::zeros(1, samples), Mat::zeros(1, samples));
    for t in 0..samples {
        v = 0.9 * v + 0.5 * noise[(0, t)];
        r = 0.8 * r + 0.6 * excitation[(0, t)];
        (u[(0, t)], y[(0, t)]) = (r - 0.6 * before, x + v);
        before = y[(0, t)];
        x = 0.8 * x + 0.5 * u[(0, t)];
    }
    (truth, DataSet::single(0.05, u, y).unwrap())
}

#[test]
fn feedback_does_not_bias_what_is_chosen() {
    let distance = |method: Option<Method>| {
        let distances = (1..=3).map(|seed| {
            let (truth, data) = in_a_loop(12_000, seed);
            let options = IdentifyOptions { method, order: Some(1), ..IdentifyOptions::default() };
            response_distance(&truth, &chosen(&data, &options).unwrap().model)
        });
        distances.sum::<f64>() / 3.0
    };
    let (by_itself, open) = (distance(None), distance(Some(Weighting::Moesp.into())));
    println!("{by_itself} {open}");
    assert!(open > 0.2, "this loop is meant to mislead: {open}");
    assert!(by_itself < 0.25 * open, "{by_itself} {open}");
    // Nor is the coloured noise a state.
    let found = chosen(&in_a_loop(12_000, 1).1, &IdentifyOptions::default()).unwrap();
    assert_eq!(found.model.order(), 1, "{found:?}");
}

#[test]
fn units_offsets_and_the_order_of_channels_do_not_matter() {
    let mut random = Random(31);
    let truth = random.system(3, 2, 2);
    let (u, noise) = (random.matrix(2, 1200), random.matrix(2, 1200));
    let clean = simulate(&truth, u.as_ref(), &[0.0; 3]);
    let y = clean.as_ref() + Mat::from_fn(2, 1200, |i, t| 0.1 * noise[(i, t)]);
    let plain = DataSet::single(1.0, u.clone(), y.clone()).unwrap();
    let (ku, ly) = ([1e-4, 3e3], [1e5, 0.02]);
    let other = DataSet::single(
        1.0,
        Mat::from_fn(2, 1200, |i, t| ku[i] * u[(1 - i, t)] + 10.0 * ku[i]),
        Mat::from_fn(2, 1200, |i, t| ly[i] * y[(1 - i, t)] - 5.0 * ly[i]),
    )
    .unwrap();
    let options = IdentifyOptions { horizon: Some(10), ..IdentifyOptions::default() };
    let (a, b) = (chosen(&plain, &options).unwrap(), chosen(&other, &options).unwrap());
    assert_eq!(a.model.order(), b.model.order());
    assert!((a.validation_fit - b.validation_fit).abs() < 1e-3, "{a:?} {b:?}");
    let back = StateSpace {
        b: Mat::from_fn(a.model.order(), 2, |i, j| b.model.b[(i, 1 - j)] * ku[1 - j]),
        c: Mat::from_fn(2, a.model.order(), |i, j| b.model.c[(1 - i, j)] / ly[1 - i]),
        d: Mat::from_fn(2, 2, |i, j| b.model.d[(1 - i, 1 - j)] * ku[1 - j] / ly[1 - i]),
        a: b.model.a.clone(),
    };
    let distance = response_distance(&a.model, &back);
    assert!(distance < 1e-3, "{distance:e}");
}

#[test]
fn hard_data_lead_to_stable_models_in_every_setting() {
    // A ramp, a growing oscillation, an integrator and noise, driven by nothing that explains them.
    let mut random = Random(41);
    let n = 900;
    let u = random.matrix(1, n);
    let noise = random.matrix(1, n);
    let mut sum = 0.0;
    let outputs = [
        Mat::from_fn(1, n, |_, t| 0.01 * t as f64 + 0.1 * noise[(0, t)]),
        Mat::from_fn(1, n, |_, t| (0.006 * t as f64).exp() * (0.3 * t as f64).sin() + u[(0, t)]),
        Mat::from_fn(1, n, |_, t| {
            sum += u[(0, t)];
            sum + noise[(0, t)]
        }),
        noise.clone(),
    ];
    let mut stabilised = 0;
    for (case, y) in outputs.into_iter().enumerate() {
        let data = DataSet::single(0.02, u.clone(), y).unwrap();
        for (horizon, order) in [(15, 2), (15, 6), (40, 4), (40, 6)] {
            for refine in [false, true] {
                let options = IdentifyOptions {
                    order: Some(order),
                    horizon: Some(horizon),
                    refine,
                    ..IdentifyOptions::default()
                };
                let found = chosen(&data, &options).unwrap();
                let radius = found.model.spectral_radius();
                let what = format!("case {case}, {horizon}, {order}, {refine}: {found:?}");
                assert!(radius < 1.0 && found.estimation_fit >= -1e-9, "{what}");
                if let (Some(from), Some((_, after))) =
                    (found.orders[0].stabilised_from, found.orders[0].stabilised_fits)
                {
                    stabilised += 1;
                    assert!(from >= 1.0 && after <= found.estimation_fit + 1e-6, "{what}");
                }
            }
        }
    }
    assert!(stabilised > 0, "the data were meant to mislead");
}

fn single(u: impl Into<Signals>, y: impl Into<Signals>) -> Result<DataSet, Error> {
    DataSet::single(1.0, u, y)
}

/// What is wrong with the data, and that the error has a hint.
fn refusal(data: Result<DataSet, Error>, options: &IdentifyOptions) -> String {
    let error = data.and_then(|d| chosen(&d, options)).expect_err("no model can come of this");
    assert!(error.hint().len() > 15, "{error}");
    error.to_string()
}

#[test]
fn hostile_inputs_are_errors_with_a_hint() {
    let auto = IdentifyOptions::default();
    let mut random = Random(51);
    let n = 600;
    let (u, y) = (random.matrix(1, n), random.matrix(1, n));
    let of = |f: &dyn Fn(usize) -> f64| Mat::from_fn(1, n, |_, t| f(t));
    let constant = of(&|_| 3.25);
    assert!(refusal(single(constant.clone(), y.clone()), &auto).contains("input 0"));
    assert!(refusal(single(u.clone(), constant.clone()), &auto).contains("output 0"));
    let hole = of(&|t| if t == 77 { f64::NAN } else { y[(0, t)] });
    assert!(refusal(single(u.clone(), hole), &auto).contains("77"));
    assert!(refusal(single(u.get(.., ..1).to_owned(), y.get(.., ..1).to_owned()), &auto).len() > 5);
    assert!(refusal(single(Mat::zeros(0, n), y.clone()), &auto).contains("no input"));
    let long = IdentifyOptions { horizon: Some(200), ..auto.clone() };
    assert!(refusal(single(u.clone(), y.clone()), &long).contains("too few"));
    let many = random.matrix(60, n);
    assert!(refusal(single(many, y.clone()), &auto).contains("too few"));
    let shapes = automatic(
        &single(u.clone(), y.clone()).unwrap(),
        &single(random.matrix(2, n), y.clone()).unwrap(),
        &auto,
    );
    assert!(matches!(shapes, Err(Error::Data { .. })));
    let uneven = DataSet::new(1.0, vec![Segment::new(u.clone(), y.get(.., ..9).to_owned())]);
    assert!(matches!(uneven, Err(Error::Data { .. })));
}

#[test]
fn extreme_and_dependent_signals_lead_to_a_model_or_an_error() {
    let mut random = Random(61);
    let n = 600;
    let truth = random.system(2, 1, 1);
    let u = random.matrix(1, n);
    let clean = simulate(&truth, u.as_ref(), &[0.0; 2]);
    // From rest and about zero, so that nothing but the model has to be found.
    let auto = IdentifyOptions { detrend: Detrend::None, ..IdentifyOptions::default() };
    let plain = chosen(&single(u.clone(), clean.clone()).unwrap(), &auto).unwrap();
    assert!(plain.validation_fit > 99.999_999, "{plain:?}");
    // As large and as small as numbers go.
    for size in [1e300, 1e-300] {
        let y = Mat::from_fn(1, n, |_, t| size * clean[(0, t)]);
        let found = chosen(&single(u.clone(), y).unwrap(), &auto).unwrap();
        assert!((found.validation_fit - plain.validation_fit).abs() < 1e-6, "{size:e}: {found:?}");
    }
    // The same input twice, and an input of two sines only.
    let twice = Mat::from_fn(2, n, |i, t| (1.0 + i as f64) * u[(0, t)]);
    let sines = Mat::from_fn(1, n, |_, t| (0.3 * t as f64).sin() + (1.1 * t as f64).cos());
    let response = simulate(&truth, sines.as_ref(), &[0.0; 2]);
    for data in [single(twice, clean.clone()).unwrap(), single(sines, response).unwrap()] {
        match chosen(&data, &auto) {
            Ok(found) => assert!(found.model.spectral_radius() < 1.0, "{found:?}"),
            Err(error) => assert!(error.hint().len() > 15, "{error}"),
        }
    }
}
