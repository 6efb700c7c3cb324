//! Identification from closed-loop data: exact without noise, unbiased with a driver in the loop where
//! the open-loop methods are not, and clear about data without information.

use crate::known::bias::{Biases, Errors};
use crate::known::driver::Drive;
use crate::known::{Random, markov_distance, pole_distance};
use faer::Mat;
use steerwright_sysid::subspace::closed_loop::{self, ClosedLoopMethod, errors_in_variables};
use steerwright_sysid::subspace::{Factor, shift_realization, structured_bd, subspace};
use steerwright_sysid::{DataSet, Error, Segment, Signals, StateSpace, simulate};

#[test]
fn without_noise_both_methods_are_exact() {
    let mut random = Random(1);
    for (n, m, p) in [(1, 1, 1), (2, 1, 1), (4, 1, 1), (3, 2, 1), (4, 1, 2), (5, 2, 3)] {
        for feedthrough in [false, true] {
            let mut truth = random.system(n, m, p);
            if !feedthrough {
                truth.d = Mat::zeros(p, m);
            }
            // Two drives from different states.
            let mut drive = |x0: f64| {
                let u = random.matrix(m, 300);
                let y = simulate(&truth, u.as_ref(), &vec![x0; n]);
                Segment::new(u, y)
            };
            let data = DataSet::new(1.0, vec![drive(1.0), drive(-2.0)]).unwrap();
            for method in ClosedLoopMethod::ALL {
                let found =
                    closed_loop::identify(&data, method, n + 4, n + 2, n, feedthrough).unwrap();
                let model = &found.model;
                let (poles, markov) =
                    (pole_distance(model, &truth), markov_distance(&truth, model, 30));
                let what = format!("{method:?} {n} {m} {p} D {feedthrough}");
                assert!(poles < 1e-8 && markov < 1e-8, "{what}: {poles:.1e} {markov:.1e}");
                if !feedthrough {
                    assert_eq!(model.d, Mat::<f64>::zeros(p, m), "{what}");
                }
            }
        }
    }
}

/// Two inputs and outputs in innovation form under feedback with a delay of a sample,
/// u(t) = r(t) − F y(t−1).
fn two_by_two(count: usize, seed: u64) -> (StateSpace, Mat<f64>, DataSet) {
    let truth = StateSpace {
        a: Mat::from_fn(3, 3, |i, j| [[0.8, 0.2, 0.0], [-0.2, 0.8, 0.1], [0.0, 0.0, 0.5]][i][j]),
        b: Mat::from_fn(3, 2, |i, j| [[1.0, 0.2], [0.3, -0.5], [0.0, 1.0]][i][j]),
        c: Mat::from_fn(2, 3, |i, j| [[1.0, 0.0, 0.3], [0.2, 1.0, 0.0]][i][j]),
        d: Mat::zeros(2, 2),
    };
    let gain = Mat::from_fn(3, 2, |i, j| [[0.4, 0.1], [0.0, 0.3], [0.1, 0.0]][i][j]);
    let mut random = Random(seed);
    let (mut u, mut y) = (Mat::zeros(2, count), Mat::zeros(2, count));
    let mut x = Mat::zeros(3, 1);
    let mut before = Mat::zeros(2, 1);
    for t in 0..count {
        let e = random.matrix(2, 1);
        let input = Mat::from_fn(2, 1, |i, _| random.normal() - [0.25, -0.2][i] * before[(i, 0)]);
        let output = &truth.c * &x + &e;
        u.col_mut(t).copy_from(input.col(0));
        y.col_mut(t).copy_from(output.col(0));
        x = &truth.a * &x + &truth.b * input + &gain * e;
        before = output;
    }
    (truth, gain, DataSet::single(1.0, u, y).unwrap())
}

#[test]
fn several_inputs_and_outputs_and_the_gain_come_out() {
    let (truth, gain, data) = two_by_two(20_000, 5);
    let from_noise = |m: &StateSpace, k: &Mat<f64>| StateSpace { b: k.clone(), ..m.clone() };
    for method in ClosedLoopMethod::ALL {
        let found = closed_loop::identify(&data, method, 20, 8, 3, false).unwrap();
        let markov = markov_distance(&truth, &found.model, 30);
        let noise =
            markov_distance(&from_noise(&truth, &gain), &from_noise(&found.model, &found.gain), 20);
        assert!(markov < 0.05 && noise < 0.1, "{method:?}: {markov} {noise}");
    }
}

#[test]
fn all_orders_come_from_one_decomposition() {
    let (_, _, data) = two_by_two(2000, 6);
    let factor = closed_loop::factor(&data, 12, 6).unwrap();
    for method in ClosedLoopMethod::ALL {
        let all = closed_loop::decompose(&factor, method, 12, 6, false).unwrap();
        assert_eq!(all.largest_order(), 12);
        assert!(all.singular_values.windows(2).all(|s| s[0] >= s[1]), "{method:?}");
        for order in 1..=6 {
            let one = closed_loop::identify(&data, method, 12, 6, order, false).unwrap();
            let model = all.model(order).unwrap();
            assert!(pole_distance(&one.model, &model.model) < 1e-10, "{method:?} {order}");
            // The predictor A − K C is stable whatever the order.
            let closed = &model.model.a - &model.gain * &model.model.c;
            let radius = StateSpace { a: closed, ..model.model.clone() }.spectral_radius();
            assert!(radius < 1.0, "{method:?} {order}: {radius}");
            let tamed = all.stable_model(order, 0.6).unwrap();
            assert!(tamed.model.spectral_radius() <= 0.6 + 1e-12, "{method:?} {order}");
            let free = all.stable_model(order, 0.999).unwrap();
            assert!(free.model.spectral_radius() <= 0.999, "{method:?} {order}");
        }
    }
}

#[test]
fn units_and_order_of_the_channels_do_not_matter() {
    let (_, _, data) = two_by_two(1500, 7);
    let (ku, ky) = ([1e-5, -3e3], [4e4, -2e-3]);
    let first = &data.segments()[0];
    let change = |x: &Signals, k: [f64; 2]| Mat::from_fn(2, x.ncols(), |i, t| k[i] * x[(1 - i, t)]);
    let changed = DataSet::single(1.0, change(&first.u, ku), change(&first.y, ky)).unwrap();
    for method in ClosedLoopMethod::ALL {
        let one = closed_loop::identify(&data, method, 10, 5, 3, true).unwrap();
        let two = closed_loop::identify(&changed, method, 10, 5, 3, true).unwrap();
        let m = &two.model;
        let back = StateSpace {
            a: m.a.clone(),
            b: Mat::from_fn(3, 2, |i, j| m.b[(i, 1 - j)] * ku[1 - j]),
            c: Mat::from_fn(2, 3, |i, j| m.c[(1 - i, j)] / ky[1 - i]),
            d: Mat::from_fn(2, 2, |i, j| m.d[(1 - i, 1 - j)] * ku[1 - j] / ky[1 - i]),
        };
        let noise = |m: &StateSpace, k: Mat<f64>| StateSpace { b: k, ..m.clone() };
        let gain = Mat::from_fn(3, 2, |i, j| two.gain[(i, 1 - j)] * ky[1 - j]);
        let distances = [
            pole_distance(&one.model, m),
            markov_distance(&one.model, &back, 30),
            markov_distance(&noise(&one.model, one.gain.clone()), &noise(&back, gain), 30),
        ];
        assert!(distances.iter().all(|d| *d < 1e-8), "{method:?}: {distances:?}");
    }
    let [a, b] = [&data, &changed].map(|d| closed_loop::feedback(d, 10.0, 5.0).unwrap());
    assert!((a.statistic / b.statistic - 1.0).abs() < 1e-8);
}

fn biases(data: &[DataSet], estimate: impl Fn(&DataSet) -> StateSpace) -> Biases {
    let truth = Drive::vehicle();
    let errors: Vec<Errors> =
        data.iter().map(|d| Errors::new(&estimate(d), &truth).unwrap()).collect();
    Biases::new(&errors)
}

fn open_loop(data: &DataSet, method: steerwright_sysid::Weighting, past: usize) -> StateSpace {
    let factor = Factor::new(data, past).unwrap();
    let found = subspace(&factor, method).unwrap();
    let (a, c) = shift_realization(&found, 3, 1).unwrap();
    structured_bd(&factor, &found, a.as_ref(), c.as_ref(), false).unwrap()
}

#[test]
fn with_a_driver_in_the_loop_only_the_predictors_bias_goes_with_the_past() {
    let data: Vec<DataSet> =
        (0..12).map(|seed| Drive::controlled().record(20_000, seed).unwrap()).collect();
    for method in steerwright_sysid::Weighting::ALL {
        let bias = biases(&data, |d| open_loop(d, method, 20)).response;
        assert!(bias.is_significant(), "{method:?}: {bias:?}");
    }
    for method in ClosedLoopMethod::ALL {
        let at = |past: usize| {
            let one = |d: &DataSet| {
                closed_loop::identify(d, method, past, past.min(10), 3, false).unwrap().model
            };
            biases(&data, one).response
        };
        let (short, long) = (at(5), at(25));
        assert!(short.is_significant(), "{method:?}: {short:?}");
        assert!(!long.is_significant(), "{method:?}: {long:?}");
        assert!(long.mean < 0.2 * short.mean, "{method:?}: {short:?} {long:?}");
    }
}

#[test]
fn errors_in_variables_are_met_where_the_predictors_are_biased() {
    let data: Vec<DataSet> =
        (0..30).map(|seed| Drive::white_sensors().record(6000, seed).unwrap()).collect();
    for method in ClosedLoopMethod::ALL {
        let one = |d: &DataSet| closed_loop::identify(d, method, 20, 10, 3, false).unwrap().model;
        let bias = biases(&data, one).response;
        assert!(bias.is_significant(), "{method:?}: {bias:?}");
    }
    let one = |d: &DataSet| errors_in_variables::identify(d, 20, 6, 3, false).unwrap().model;
    let bias = biases(&data, one).response;
    assert!(!bias.is_significant(), "{bias:?}");
}

/// What chance puts into a projection on the past falls as the record grows, what is there does not.
#[test]
fn the_excitation_for_errors_in_variables_is_in_units_of_chance() {
    let mut random = Random(12);
    let mut of = |count: usize, shared: f64| {
        let (white, e) = (random.matrix(1, count), random.matrix(1, count));
        let sines = |t: usize| (1..=6).map(|k| (0.4 * (k * t) as f64).sin()).sum::<f64>();
        let u = Mat::from_fn(1, count, |i, t| white[(i, t)] + shared * sines(t));
        let y = Mat::from_fn(1, count, |i, t| if t > 0 { u[(i, t - 1)] } else { 0.0 } + e[(i, t)]);
        let data = DataSet::single(1.0, u, y).unwrap();
        errors_in_variables::identify(&data, 20, 6, 1, false).unwrap().excitation
    };
    // White excitation is not predicted by the past: somewhat less than 1, since the least is taken.
    for count in [1000, 30_000] {
        let chance = of(count, 0.0);
        assert!((0.3..1.0).contains(&chance), "{count}: {chance}");
    }
    let (short, long) = (of(1000, 0.6), of(16_000, 0.6));
    println!("{short:.2} {long:.2}");
    assert!(short > 1.0 && (3.0..6.0).contains(&(long / short)), "{short} {long}");
}

#[test]
fn errors_in_variables_are_exact_without_noise() {
    let mut random = Random(8);
    for (n, m, p, feedthrough) in [(2, 1, 1, false), (3, 1, 1, true), (4, 2, 2, true)] {
        let mut truth = random.system(n, m, p);
        if !feedthrough {
            truth.d = Mat::zeros(p, m);
        }
        let phases = random.matrix(m, 16);
        let u = Mat::from_fn(m, 800, |i, t| {
            let sine = |k: usize| (0.19 * (k + 1) as f64 * t as f64 + 9.0 * phases[(i, k)]).sin();
            (0..16).map(|k| (1.0 + 0.1 * ((k + 3 * i) % 5) as f64) * sine(k)).sum()
        });
        let y = simulate(&truth, u.as_ref(), &vec![0.0; n]);
        let data = DataSet::single(1.0, u, y).unwrap();
        let found = errors_in_variables::identify(&data, 12, n + 2, n, feedthrough).unwrap();
        let markov = markov_distance(&truth, &found.model, 30);
        let poles = pole_distance(&found.model, &truth);
        assert!(markov < 1e-8 && poles < 1e-8, "{n} {m} {p}: {markov:e} {poles:e}");
    }
}

#[test]
fn the_feedback_test_has_its_size_and_its_power() {
    let controlled = Drive::controlled();
    let open = Drive { gain: 0.0, ..controlled.clone() };
    let sines = Drive { gain: 0.0, input_noise: 0.0, ..Drive::white_sensors() };
    let found = |drive: &Drive, seeds: std::ops::Range<u64>| {
        seeds
            .filter(|seed| {
                let data = drive.record(2000, *seed).unwrap();
                closed_loop::feedback(&data, 1.0, 0.5).unwrap().detected
            })
            .count()
    };
    // At a significance level of 1 %, 200 records have 7 alarms or more in 1 of 200 cases.
    let alarms = found(&open, 0..150) + found(&sines, 150..200);
    assert!(alarms <= 6, "{alarms} false alarms of 200");
    assert_eq!(found(&controlled, 0..20), 20);
}

/// Of few samples and many coefficients too the statistic is χ² (Bartlett's correction): its mean is the
/// number of degrees of freedom.
#[test]
fn the_feedback_statistic_of_short_records_has_the_mean_of_its_distribution() {
    const RECORDS: u64 = 400;
    for outputs in [1, 2] {
        let mut sum = 0.0;
        let mut degrees = 0;
        for seed in 0..RECORDS {
            let mut random = Random(40_000 + seed);
            let (u, y) = (random.matrix(1, 121), random.matrix(outputs, 121));
            let factor = Factor::new(&DataSet::single(1.0, u, y).unwrap(), 11).unwrap();
            let outcome = closed_loop::feedback_in(&factor, 1, 20).unwrap();
            (sum, degrees) = (sum + outcome.statistic, outcome.degrees);
        }
        assert_eq!(degrees, 20 * outputs);
        let (mean, degrees) = (sum / RECORDS as f64, degrees as f64);
        let error = (2.0 * degrees / RECORDS as f64).sqrt();
        println!("{outputs}: {mean:.2} ± {error:.2} of {degrees}");
        assert!((mean - degrees).abs() < 3.5 * error, "{mean} of {degrees}");
    }
}

#[test]
fn the_feedback_test_finds_none_in_data_without_noise() {
    let mut random = Random(9);
    let truth = random.system(3, 1, 1);
    let u = random.matrix(1, 600);
    let y = simulate(&truth, u.as_ref(), &[0.0; 3]);
    let data = DataSet::single(1.0, u, y).unwrap();
    let outcome = closed_loop::feedback(&data, 10.0, 5.0).unwrap();
    assert!(!outcome.detected && outcome.statistic == 0.0, "{outcome:?}");
}

#[test]
fn the_past_horizon_is_the_order_of_an_autoregression() {
    // y(t) = 1.2 y(t−1) − 0.5 y(t−2) + u(t−1) + 0.4 u(t−3) + e(t)
    let mut random = Random(10);
    let count = 5000;
    let (u, e) = (random.matrix(1, count), random.matrix(1, count));
    let mut y = Mat::zeros(1, count);
    for t in 3..count {
        y[(0, t)] = 1.2 * y[(0, t - 1)] - 0.5 * y[(0, t - 2)]
            + u[(0, t - 1)]
            + 0.4 * u[(0, t - 3)]
            + e[(0, t)];
    }
    let data = DataSet::single(1.0, u, y).unwrap();
    let factor = closed_loop::factor(&data, 20, 1).unwrap();
    let order = |d| closed_loop::past_horizon(&factor, 20, d).unwrap();
    assert!((3..=8).contains(&order(false)) && (3..=8).contains(&order(true)));
    let predictor = closed_loop::Predictor::new(&factor, 3, false).unwrap();
    let expected = [[1.0, 1.2], [0.0, -0.5], [0.4, 0.0]];
    for (got, expected) in predictor.markov.iter().zip(expected) {
        assert!((got[(0, 0)] - expected[0]).abs() < 0.06, "{got:?}");
        assert!((got[(0, 1)] - expected[1]).abs() < 0.06, "{got:?}");
    }
    assert!((predictor.innovation[(0, 0)] - 1.0).abs() < 0.1);
}

#[test]
fn data_and_requests_that_cannot_be_met_are_errors() {
    let mut random = Random(11);
    let (u, y) = (random.matrix(1, 400), random.matrix(1, 400));
    let single = |u: &Mat<f64>, y: &Mat<f64>| DataSet::single(0.1, u.clone(), y.clone());
    let data = single(&u, &y).unwrap();
    let checked = |outcome: Result<(), Error>| {
        let error = outcome.expect_err("must be refused");
        assert!(!error.to_string().is_empty() && !error.hint().is_empty(), "{error}");
        error
    };
    let constant = Mat::from_fn(1, 400, |_, _| 3.0);
    let zero = Mat::zeros(1, 400);
    let huge = Mat::from_fn(1, 400, |_, t| 1e300 * y[(0, t)]);
    let few = |x: &Mat<f64>| x.get(.., ..30).to_owned();
    for method in ClosedLoopMethod::ALL {
        let request = |data: &DataSet, past, future, order| {
            closed_loop::identify(data, method, past, future, order, false).map(|_| ())
        };
        for still in [&constant, &zero] {
            for data in [single(still, &y), single(&u, still)] {
                let error = checked(request(&data.unwrap(), 10, 5, 2));
                assert!(matches!(error, Error::NotExciting { .. }), "{error}");
            }
        }
        let short = single(&few(&u), &few(&y)).unwrap();
        assert!(matches!(checked(request(&short, 10, 5, 2)), Error::TooFewSamples { .. }));
        assert!(matches!(checked(request(&data, 0, 5, 2)), Error::Option { .. }));
        assert!(matches!(checked(request(&data, 5, 6, 2)), Error::Option { .. }));
        assert!(matches!(checked(request(&data, usize::MAX, 6, 2)), Error::Option { .. }));
        assert!(matches!(checked(request(&data, 10, 5, 0)), Error::OrderAboveHorizon { .. }));
        assert!(matches!(checked(request(&data, 10, 5, 6)), Error::OrderAboveHorizon { .. }));
        let _ = request(&single(&u, &huge).unwrap(), 10, 5, 2).map_err(|e| checked(Err(e)));
        // Input and output in proportion, and one that is noise alone: a model or a clear error.
        let _ = request(&single(&u, &u).unwrap(), 10, 5, 2).map_err(|e| checked(Err(e)));
        let _ = request(&data, 10, 5, 5).map_err(|e| checked(Err(e)));
    }
    let nothing = DataSet::single(0.1, Mat::zeros(0, 400), y.clone()).unwrap();
    checked(closed_loop::feedback(&nothing, 2.0, 1.0).map(|_| ()));
    let one = DataSet::single(0.1, random.matrix(1, 1), random.matrix(1, 1)).unwrap();
    checked(closed_loop::feedback(&one, 2.0, 1.0).map(|_| ()));
    let still = single(&constant, &y).unwrap();
    checked(closed_loop::feedback(&still, 2.0, 1.0).map(|_| ()));
    checked(errors_in_variables::identify(&still, 10, 5, 2, false).map(|_| ()));
    checked(errors_in_variables::identify(&data, 10, 5, 5, false).map(|_| ()));
    let factor = closed_loop::factor(&data, 10, 5).unwrap();
    checked(closed_loop::decompose(&factor, ClosedLoopMethod::Pbsid, 20, 5, false).map(|_| ()));
    checked(closed_loop::past_horizon(&factor, 20, false).map(|_| ()));
    checked(closed_loop::past_horizon(&factor, 0, false).map(|_| ()));
}
