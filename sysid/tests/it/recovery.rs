//! Known systems are recovered: exactly from data without noise, closely from noisy data, and the
//! same from data in other units.

use crate::known::{Random, markov_distance, pole_distance};
use faer::Mat;
use steerwright_sysid::pem::{Stop, refine_output_error};
use steerwright_sysid::subspace::{
    Factor, Projections, eq12, noise_model, refit_output, shift_realization, structured_bd,
    subspace,
};
use steerwright_sysid::{DataSet, Segment, Signals, StateSpace, Weighting, simulate};

const SHAPES: [(usize, usize, usize); 6] =
    [(1, 1, 1), (2, 1, 1), (4, 1, 1), (3, 2, 1), (4, 1, 2), (5, 2, 3)];

fn estimate(u: &Mat<f64>, y: &Signals, n: usize, method: Weighting, d: bool) -> [StateSpace; 3] {
    let data = DataSet::single(1.0, u.clone(), y.clone()).unwrap();
    let factor = Factor::new(&data, n + 3).unwrap();
    let sub = subspace(&factor, method).unwrap();
    let (a, c) = shift_realization(&sub, n, y.nrows()).unwrap();
    let refit = refit_output(a.as_ref(), c.as_ref(), &data, d, false).unwrap();
    [
        refit.model,
        structured_bd(&factor, &sub, a.as_ref(), c.as_ref(), d).unwrap(),
        eq12(&factor, &Projections::new(&factor).unwrap(), &sub, n, d).unwrap(),
    ]
}

#[test]
fn without_noise_every_method_is_exact() {
    let mut random = Random(1);
    for (n, m, p) in SHAPES {
        for feedthrough in [true, false] {
            let mut truth = random.system(n, m, p);
            if !feedthrough {
                truth.d = Mat::zeros(p, m);
            }
            let u = random.matrix(m, 300);
            let x0 = vec![1.0; n];
            let y = simulate(&truth, u.as_ref(), &x0);
            for method in Weighting::ALL {
                for (i, model) in estimate(&u, &y, n, method, feedthrough).iter().enumerate() {
                    let poles = pole_distance(model, &truth);
                    let markov = markov_distance(&truth, model, 30);
                    let what = format!("{method:?} {n} {m} {p} D {feedthrough} route {i}");
                    assert!(poles < 1e-8 && markov < 1e-8, "{what}: {poles:.1e} {markov:.1e}");
                    if !feedthrough {
                        assert_eq!(model.d, Mat::<f64>::zeros(p, m), "{what}");
                    }
                }
            }
        }
    }
}

#[test]
fn units_of_the_signals_do_not_matter() {
    let mut random = Random(2);
    for method in Weighting::ALL {
        let mut truth = random.system(3, 1, 1);
        truth.d = Mat::zeros(1, 1);
        let u = random.matrix(1, 800);
        let noise = random.matrix(1, 800);
        let y = simulate(&truth, u.as_ref(), &[0.0; 3]);
        let y = Mat::from_fn(1, 800, |_, t| y[(0, t)] + 0.1 * noise[(0, t)]);
        let one = &estimate(&u, &y.clone().into(), 3, method, false)[0];
        let (ku, ky) = (1e-5, 3e4);
        let scaled = |m: &Mat<f64>, k: f64| Mat::from_fn(1, 800, |_, t| k * m[(0, t)]);
        let two = &estimate(&scaled(&u, ku), &scaled(&y, ky).into(), 3, method, false)[0];
        let back = StateSpace {
            b: Mat::from_fn(3, 1, |i, _| two.b[(i, 0)] * ku),
            c: Mat::from_fn(1, 3, |_, j| two.c[(0, j)] / ky),
            ..two.clone()
        };
        let (poles, markov) = (pole_distance(one, two), markov_distance(one, &back, 30));
        assert!(poles < 1e-8 && markov < 1e-8, "{method:?}: {poles:e} {markov:e}");
    }
}

/// A simulation in innovation form with the noise `e`, 1 by N.
fn innovation_form(m: &StateSpace, k: &Mat<f64>, u: &Mat<f64>, e: &Mat<f64>) -> Signals {
    let n = m.order();
    let joined = Mat::from_fn(2, u.ncols(), |i, t| if i == 0 { u[(0, t)] } else { e[(0, t)] });
    let both = StateSpace {
        a: m.a.clone(),
        b: Mat::from_fn(n, 2, |i, j| if j == 0 { m.b[(i, 0)] } else { k[(i, 0)] }),
        c: m.c.clone(),
        d: Mat::from_fn(1, 2, |_, j| if j == 0 { m.d[(0, 0)] } else { 1.0 }),
    };
    simulate(&both, joined.as_ref(), &vec![0.0; n])
}

fn vehicle_like() -> (StateSpace, Mat<f64>) {
    // A bicycle at 20 m/s sampled every 40 ms, roughly: poles 0.75 ± 0.12i, gain 5.
    let model = StateSpace {
        a: Mat::from_fn(2, 2, |i, j| [[0.75, 0.12], [-0.12, 0.75]][i][j]),
        b: Mat::from_fn(2, 1, |i, _| [0.9, 0.4][i]),
        c: Mat::from_fn(1, 2, |_, j| [1.0, 0.3][j]),
        d: Mat::zeros(1, 1),
    };
    (model, Mat::from_fn(2, 1, |i, _| [0.3, -0.1][i]))
}

#[test]
fn model_and_kalman_gain_come_out_of_noisy_data() {
    let (truth, gain) = vehicle_like();
    let mut random = Random(3);
    let count = 20_000;
    let (u, e) = (random.matrix(1, count), random.matrix(1, count));
    let y = innovation_form(&truth, &gain, &u, &e);
    let data = DataSet::single(0.04, u, y).unwrap();
    let factor = Factor::new(&data, 15).unwrap();
    for method in Weighting::ALL {
        let sub = subspace(&factor, method).unwrap();
        let (a, c) = shift_realization(&sub, 2, 1).unwrap();
        let model = refit_output(a.as_ref(), c.as_ref(), &data, false, false).unwrap().model;
        let (poles, markov) = (pole_distance(&model, &truth), markov_distance(&truth, &model, 30));
        let noise = noise_model(&factor, &model).unwrap();
        let filter = |m: &StateSpace, k: &Mat<f64>| StateSpace { b: k.clone(), ..m.clone() };
        let k = markov_distance(&filter(&truth, &gain), &filter(&model, &noise.gain), 20);
        println!(
            "{method:?}: poles {poles:.1e} markov {markov:.1e} K {k:.1e} {}",
            noise.innovation[(0, 0)]
        );
        assert!(poles < 0.02 && markov < 0.02, "{method:?}: {poles} {markov}");
        assert!(noise.solved && k < 0.1, "{method:?}: {k}");
        assert!((noise.innovation[(0, 0)] - 1.0).abs() < 0.05, "{method:?}");
    }
}

#[test]
fn refinement_reaches_the_optimum_from_a_distance() {
    let (truth, _) = vehicle_like();
    let mut random = Random(4);
    let u = random.matrix(1, 1000);
    let y = simulate(&truth, u.as_ref(), &[0.5, -0.5]);
    let start = StateSpace {
        a: Mat::from_fn(2, 2, |i, j| [[0.6, 0.2], [-0.05, 0.85]][i][j]),
        b: Mat::from_fn(2, 1, |_, _| 0.5),
        ..truth.clone()
    };
    let stop = Stop { steps: 60, least_gain: 1e-12 };
    let data = DataSet::single(1.0, u.clone(), y.clone()).unwrap();
    let (model, x0) =
        refine_output_error(&start, &[vec![0.0; 2]], &data, false, stop, 0.999).unwrap();
    let markov = markov_distance(&truth, &model, 30);
    assert!(markov < 1e-8, "{markov:e}");
    let error = &y - simulate(&model, u.as_ref(), &x0[0]);
    assert!(error.as_ref().norm_max() < 1e-8);
}

/// The same drive in three pieces, each from a state of its own.
#[test]
fn segments_are_no_continuation_of_each_other() {
    let mut random = Random(5);
    let truth = StateSpace { d: Mat::zeros(2, 1), ..random.system(3, 1, 2) };
    let segments: Vec<Segment> = [120, 300, 57]
        .into_iter()
        .map(|count| {
            let u = random.matrix(1, count);
            let x0: Vec<f64> = (0..3).map(|_| 3.0 * random.normal()).collect();
            Segment::new(&u, simulate(&truth, u.as_ref(), &x0))
        })
        .collect();
    let data = DataSet::new(1.0, segments.clone()).unwrap();
    let factor = Factor::new(&data, 6).unwrap();
    let (a, c) = shift_realization(&subspace(&factor, Weighting::Moesp).unwrap(), 3, 2).unwrap();
    let refit = refit_output(a.as_ref(), c.as_ref(), &data, false, false).unwrap();
    assert!(markov_distance(&truth, &refit.model, 30) < 1e-9);
    for (segment, x0) in segments.iter().zip(&refit.x0) {
        let error = &segment.y - simulate(&refit.model, segment.u.as_ref(), x0);
        assert!(error.as_ref().norm_max() < 1e-8);
    }
    // From wrong parameters the refinement finds all of it again.
    let start =
        StateSpace { b: Mat::from_fn(3, 1, |i, _| refit.model.b[(i, 0)] * 1.2), ..refit.model };
    let stop = Stop { steps: 60, least_gain: 1e-12 };
    let x0 = vec![vec![0.0; 3]; 3];
    let (model, _) = refine_output_error(&start, &x0, &data, false, stop, 0.9999).unwrap();
    assert!(markov_distance(&truth, &model, 30) < 1e-7);
}
