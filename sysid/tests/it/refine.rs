//! The refinement and its covariance: against the scatter over many drives of a known system.

use crate::known::{Random, markov_distance, pole_distance};
use faer::Mat;
use std::f64::consts::PI;
use steerwright_formats::NORMAL_95;
use steerwright_sysid::pem::{
    Focus, Refined, Stop, Uncertain, refine_gain, refine_prediction, uncertain,
};
use steerwright_sysid::{DataSet, Innovation, Segment, StateSpace, simulate};

const STOP: Stop = Stop { steps: 30, least_gain: 1e-9 };
const RUNS: usize = 150;

/// A car at speed sampled at 25 Hz, roughly, with a filter.
fn vehicle() -> Innovation {
    let model = StateSpace {
        a: Mat::from_fn(2, 2, |i, j| [[0.75, 0.3], [-0.3, 0.7]][i][j]),
        b: Mat::from_fn(2, 1, |i, _| [0.9, 0.4][i]),
        c: Mat::from_fn(1, 2, |_, j| [1.0, 0.3][j]),
        d: Mat::zeros(1, 1),
    };
    Innovation { model, gain: Mat::from_fn(2, 1, |i, _| [0.4, -0.2][i]) }
}

/// `x⁺ = A x + B u + K e`, `y = C x + D u + e` from x(0) = 0.
fn driven(of: &Innovation, u: &Mat<f64>, e: &Mat<f64>) -> Mat<f64> {
    let (m, p) = (of.model.inputs(), of.model.outputs());
    let side_by_side = |left: &Mat<f64>, right: &Mat<f64>| {
        Mat::from_fn(
            left.nrows(),
            m + p,
            |i, j| if j < m { left[(i, j)] } else { right[(i, j - m)] },
        )
    };
    let both = StateSpace {
        b: side_by_side(&of.model.b, &of.gain),
        d: side_by_side(&of.model.d, &Mat::identity(p, p)),
        ..of.model.clone()
    };
    let signals =
        Mat::from_fn(m + p, u.ncols(), |i, t| if i < m { u[(i, t)] } else { e[(i - m, t)] });
    simulate(&both, signals.as_ref(), &vec![0.0; of.model.order()]).as_ref().to_owned()
}

fn refined(start: &Innovation, data: &DataSet, focus: Focus) -> Refined {
    let x0s = vec![vec![0.0; start.model.order()]; data.segments().len()];
    refine_prediction(start, &x0s, data, false, focus, STOP, 0.9999).unwrap()
}

/// What the covariance is held against: (estimate, standard error) of quantities without a basis.
fn quantities(of: &Uncertain) -> Vec<(f64, f64)> {
    let mut poles = of.poles().unwrap();
    poles.sort_by(|a, b| a.im.total_cmp(&b.im));
    let upper = poles[poles.len() - 1];
    let mut all = vec![(upper.re, upper.variance_re.sqrt()), (upper.im, upper.variance_im.sqrt())];
    all.push(of.steady_state_gain(0, 0).unwrap());
    for omega in [0.1, 0.4, 1.0] {
        let r = of.frequency_response(0, 0, omega * PI / 2.0);
        all.push((r.re, r.re_error));
        all.push((r.im, r.im_error));
        all.push((r.re.hypot(r.im), r.magnitude_error));
        all.push((r.im.atan2(r.re), r.phase_error));
    }
    let steps = of.step_response(0, 0, 12);
    all.extend([steps[2], steps[6], steps[11]]);
    all
}

/// Refines on many drives of `truth` and holds the standard errors against the scatter.
fn scatter(truth: &Innovation, focus: Focus, seed: u64, noise: impl Fn(&mut Random) -> Mat<f64>) {
    let mut random = Random(seed);
    let exact = Uncertain { innovation: truth.clone(), factor: Mat::zeros(11, 1), focus };
    let exact: Vec<f64> = quantities(&exact).into_iter().map(|(value, _)| value).collect();
    let mut all = Vec::new();
    for _ in 0..RUNS {
        let e = noise(&mut random);
        // An input with little power at high frequency, as steering has.
        let white = random.matrix(1, e.ncols());
        let mut state = 0.0;
        let u = Mat::from_fn(1, e.ncols(), |_, t| {
            state = 0.7 * state + white[(0, t)];
            state
        });
        let white_gain = Innovation { gain: Mat::zeros(2, 1), ..truth.clone() };
        let y = match focus {
            Focus::Prediction => driven(truth, &u, &e),
            Focus::Simulation => {
                let clean = driven(&white_gain, &u, &Mat::zeros(1, e.ncols()));
                &clean + &e
            }
        };
        let data = DataSet::single(0.04, u, y).unwrap();
        let found = refined(truth, &data, focus);
        let of = uncertain(&found.innovation, &found.x0s, &data, false, focus).unwrap();
        all.push(quantities(&of));
    }
    let mut covered = 0;
    for (k, exact) in exact.iter().enumerate() {
        let column = || all.iter().map(move |q| q[k]);
        let mean = column().map(|(value, _)| value).sum::<f64>() / RUNS as f64;
        let spread = column().map(|(value, _)| (value - mean).powi(2)).sum::<f64>() / RUNS as f64;
        let stated = column().map(|(_, error)| error * error).sum::<f64>() / RUNS as f64;
        let ratio = (stated / spread).sqrt();
        let inside =
            column().filter(|(value, error)| (value - exact).abs() <= NORMAL_95 * error).count();
        println!("{k}: stated/scatter {ratio:.2}, covered {inside} of {RUNS}");
        assert!((0.7..1.4).contains(&ratio), "quantity {k}: {ratio}");
        covered += inside;
    }
    let coverage = covered as f64 / (RUNS * exact.len()) as f64;
    println!("coverage {coverage:.3}");
    assert!((0.90..=0.99).contains(&coverage), "{coverage}");
}

/// C·K and C·A·K of the innovation form with their standard errors: what of K no basis changes.
fn gains(of: &Uncertain) -> [(f64, f64); 2] {
    let (m, k) = (&of.innovation.model, &of.innovation.gain);
    let (first, second) = ((&m.c * k)[(0, 0)], (&m.c * &m.a * k)[(0, 0)]);
    let mut squares = [0.0; 2];
    for column in of.factor.col_iter() {
        // Entries of A, B, C, D, K of a model of order 2.
        let da = Mat::from_fn(2, 2, |i, j| column[2 * i + j]);
        let dc = Mat::from_fn(1, 2, |_, j| column[6 + j]);
        let dk = Mat::from_fn(2, 1, |i, _| column[9 + i]);
        let moves = [&dc * k + &m.c * &dk, &dc * &m.a * k + &m.c * &da * k + &m.c * &m.a * &dk];
        for (sum, by) in squares.iter_mut().zip(moves) {
            *sum += by[(0, 0)].powi(2);
        }
    }
    [(first, squares[0].sqrt()), (second, squares[1].sqrt())]
}

/// In open loop, the gain that follows the model of the least simulation errors has the stated scatter.
#[test]
#[ignore = "slow: cargo xtask test"]
fn standard_errors_of_the_gain_are_its_scatter() {
    let truth = vehicle();
    for focus in [Focus::Prediction, Focus::Simulation] {
        let mut random = Random(14);
        let all: Vec<[(f64, f64); 2]> = (0..RUNS)
            .map(|_| {
                let (u, white) = (random.matrix(1, 500), random.matrix(1, 500));
                let e = Mat::from_fn(1, 500, |_, t| 0.7 * white[(0, t)]);
                let data = DataSet::single(0.04, u.clone(), driven(&truth, &u, &e)).unwrap();
                let found = refined(&truth, &data, focus);
                gains(&uncertain(&found.innovation, &found.x0s, &data, false, focus).unwrap())
            })
            .collect();
        for k in 0..2 {
            let n = RUNS as f64;
            let mean = all.iter().map(|q| q[k].0).sum::<f64>() / n;
            let spread = all.iter().map(|q| (q[k].0 - mean).powi(2)).sum::<f64>() / n;
            let stated = all.iter().map(|q| q[k].1.powi(2)).sum::<f64>() / n;
            let ratio = (stated / spread).sqrt();
            println!("{focus:?} {k}: stated/scatter {ratio:.3}");
            assert!((0.8..1.25).contains(&ratio), "{focus:?} {k}: {ratio}");
        }
    }
}

/// From nought as from the truth, with one output and with two, the gain of the least prediction errors.
#[test]
fn the_gain_of_a_given_model_is_found_from_anywhere() {
    let mut random = Random(15);
    let two = Innovation {
        model: StateSpace {
            a: Mat::from_fn(2, 2, |i, j| [[0.8, 0.3], [-0.2, 0.7]][i][j]),
            b: Mat::from_fn(2, 1, |i, _| [1.0, 0.5][i]),
            c: Mat::from_fn(2, 2, |i, j| [[1.0, 0.2], [-0.3, 1.0]][i][j]),
            d: Mat::zeros(2, 1),
        },
        gain: Mat::from_fn(2, 2, |i, j| [[0.5, 0.1], [-0.2, 0.4]][i][j]),
    };
    for truth in [vehicle(), two] {
        let (u, e) = (random.matrix(1, 4000), random.matrix(truth.model.outputs(), 4000));
        let data = DataSet::single(0.04, u.clone(), driven(&truth, &u, &e)).unwrap();
        let stop = Stop { steps: 60, least_gain: 1e-14 };
        let from = |k: &Mat<f64>| {
            refine_gain(&truth.model, k.as_ref(), &data, &[vec![0.0; 2]], stop).unwrap()
        };
        let none = from(&Mat::zeros(2, truth.model.outputs()));
        let apart = (&none - from(&truth.gain)).norm_max();
        let off = (&none - &truth.gain).norm_max();
        assert!(apart < 1e-4 && off < 0.06, "{apart:e} {off}");
    }
}

#[test]
fn standard_errors_of_the_prediction_focus_are_the_scatter() {
    scatter(&vehicle(), Focus::Prediction, 11, |random| {
        let white = random.matrix(1, 500);
        Mat::from_fn(1, 500, |_, t| 0.5 * white[(0, t)])
    });
}

#[test]
fn standard_errors_of_the_simulation_focus_are_the_scatter_with_white_noise() {
    scatter(&vehicle(), Focus::Simulation, 12, |random| random.matrix(1, 500));
}

#[test]
fn standard_errors_of_the_simulation_focus_are_the_scatter_with_coloured_noise() {
    scatter(&vehicle(), Focus::Simulation, 13, |random| {
        let white = random.matrix(1, 500);
        let mut state = 0.0;
        Mat::from_fn(1, 500, |_, t| {
            state = 0.9 * state + 0.3 * white[(0, t)];
            state
        })
    });
}

/// A driver steers against the yaw rate: the output error is biased, the prediction error is not.
#[test]
fn under_feedback_the_prediction_focus_is_right_and_the_simulation_focus_is_not() {
    let truth = vehicle();
    let mut random = Random(21);
    let count = 20_000;
    let (r, e) = (random.matrix(1, count), random.matrix(1, count));
    let (mut x, mut last) = (vec![0.0; 2], 0.0);
    let (mut u, mut y) = (Mat::zeros(1, count), Mat::zeros(1, count));
    for t in 0..count {
        let m = &truth.model;
        // u(t) depends on y(t − 1): the model has no feedthrough, and the driver a sample's delay.
        u[(0, t)] = 0.5 * r[(0, t)] - 0.15 * last;
        y[(0, t)] = m.c[(0, 0)] * x[0] + m.c[(0, 1)] * x[1] + e[(0, t)];
        last = y[(0, t)];
        x = (0..2)
            .map(|i| {
                m.a[(i, 0)] * x[0]
                    + m.a[(i, 1)] * x[1]
                    + m.b[(i, 0)] * u[(0, t)]
                    + truth.gain[(i, 0)] * e[(0, t)]
            })
            .collect();
    }
    let data = DataSet::single(0.04, u, y).unwrap();
    let error = |focus| {
        let found = refined(&truth, &data, focus);
        markov_distance(&truth.model, &found.innovation.model, 30)
    };
    let (prediction, simulation) = (error(Focus::Prediction), error(Focus::Simulation));
    println!("prediction {prediction:.4} simulation {simulation:.4}");
    assert!(prediction < 0.03, "{prediction}");
    assert!(simulation > 3.0 * prediction, "{simulation} {prediction}");
}

fn enlarged(truth: &StateSpace, by: f64) -> StateSpace {
    let scaled = |m: &Mat<f64>, k: f64| Mat::from_fn(m.nrows(), m.ncols(), |i, j| k * m[(i, j)]);
    StateSpace { a: scaled(&truth.a, 1.0 - by), b: scaled(&truth.b, 1.0 + by), ..truth.clone() }
}

/// Several inputs, outputs and segments without noise: both foci find the system again.
#[test]
fn without_noise_it_is_exact() {
    let mut random = Random(31);
    for (n, m, p) in [(2, 1, 1), (3, 2, 1), (4, 1, 2), (3, 2, 3)] {
        let truth = StateSpace { d: Mat::zeros(p, m), ..random.system(n, m, p) };
        let segments: Vec<Segment> = [150, 60, 200]
            .into_iter()
            .map(|count| {
                let u = random.matrix(m, count);
                let x0: Vec<f64> = (0..n).map(|_| random.normal()).collect();
                Segment::new(&u, simulate(&truth, u.as_ref(), &x0))
            })
            .collect();
        let data = DataSet::new(1.0, segments).unwrap();
        let start = Innovation { model: enlarged(&truth, 0.05), gain: Mat::zeros(n, p) };
        for focus in [Focus::Simulation, Focus::Prediction] {
            let x0s = vec![vec![0.0; n]; 3];
            let stop = Stop { steps: 100, least_gain: 1e-12 };
            let found =
                refine_prediction(&start, &x0s, &data, false, focus, stop, 0.99999).unwrap();
            let error = markov_distance(&truth, &found.innovation.model, 30);
            assert!(error < 1e-8, "{n} {m} {p} {focus:?}: {error:.1e} after {}", found.steps);
        }
    }
}

/// In other units of the outputs the same model comes out, also of several outputs.
#[test]
fn units_do_not_matter() {
    let mut random = Random(32);
    let truth = StateSpace { d: Mat::zeros(2, 1), ..random.system(3, 1, 2) };
    let u = random.matrix(1, 600);
    let clean = simulate(&truth, u.as_ref(), &[0.0; 3]);
    let noise = random.matrix(2, 600);
    let factors = [1e-3, 1e4];
    let y = Mat::from_fn(2, 600, |i, t| clean[(i, t)] + 0.1 * noise[(i, t)]);
    let scaled_y = Mat::from_fn(2, 600, |i, t| factors[i] * y[(i, t)]);
    let scaled =
        StateSpace { c: Mat::from_fn(2, 3, |i, j| factors[i] * truth.c[(i, j)]), ..truth.clone() };
    for focus in [Focus::Simulation, Focus::Prediction] {
        let start =
            |model: &StateSpace| Innovation { model: model.clone(), gain: Mat::zeros(3, 2) };
        let one = DataSet::single(1.0, u.clone(), y.clone()).unwrap();
        let two = DataSet::single(1.0, u.clone(), scaled_y.clone()).unwrap();
        let one = refined(&start(&truth), &one, focus).innovation.model;
        let two = refined(&start(&scaled), &two, focus).innovation.model;
        let back =
            StateSpace { c: Mat::from_fn(2, 3, |i, j| two.c[(i, j)] / factors[i]), ..two.clone() };
        let (poles, markov) = (pole_distance(&one, &two), markov_distance(&one, &back, 30));
        assert!(poles < 1e-5 && markov < 1e-5, "{focus:?}: {poles:.1e} {markov:.1e}");
    }
}

fn estimated(focus: Focus) -> Uncertain {
    let truth = vehicle();
    let mut random = Random(41);
    let (u, white) = (random.matrix(1, 2000), random.matrix(1, 2000));
    let e = Mat::from_fn(1, 2000, |_, t| 0.3 * white[(0, t)]);
    let data = DataSet::single(0.04, u.clone(), driven(&truth, &u, &e)).unwrap();
    let found = refined(&truth, &data, focus);
    uncertain(&found.innovation, &found.x0s, &data, false, focus).unwrap()
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn an_ensemble_scatters_by_the_standard_errors() {
    const MEMBERS: usize = 2000;
    for focus in [Focus::Prediction, Focus::Simulation] {
        let of = estimated(focus);
        let members = of.ensemble(MEMBERS, 5).unwrap();
        assert_eq!(members, of.ensemble(MEMBERS, 5).unwrap());
        assert_ne!(members[0], of.ensemble(1, 6).unwrap()[0]);
        let stated = quantities(&of);
        let of_members: Vec<Vec<(f64, f64)>> = members
            .iter()
            .map(|m| quantities(&Uncertain { innovation: m.clone(), ..of.clone() }))
            .collect();
        for (k, (value, error)) in stated.iter().enumerate() {
            let n = MEMBERS as f64;
            let mean = of_members.iter().map(|q| q[k].0).sum::<f64>() / n;
            let spread = of_members.iter().map(|q| (q[k].0 - mean).powi(2)).sum::<f64>() / n;
            let ratio = spread.sqrt() / error;
            println!("{focus:?} {k}: {ratio:.3}, shifted by {:.3}", (mean - value) / error);
            assert!((0.9..1.12).contains(&ratio), "{focus:?} {k}: {ratio}");
            assert!((mean - value).abs() < 0.2 * error, "{focus:?} {k}");
        }
    }
}

#[test]
fn a_change_of_units_goes_through_to_every_quantity() {
    let of = estimated(Focus::Prediction);
    let (input, output) = (0.01, 3.0);
    let scaled = of.scaled(&[input], &[output]);
    let factor = output / input;
    let (gain, error) = of.steady_state_gain(0, 0).unwrap();
    let (scaled_gain, scaled_error) = scaled.steady_state_gain(0, 0).unwrap();
    assert!((scaled_gain / (factor * gain) - 1.0).abs() < 1e-12);
    assert!((scaled_error / (factor * error) - 1.0).abs() < 1e-10);
    for (a, b) in of.poles().unwrap().iter().zip(scaled.poles().unwrap()) {
        assert!((a.re - b.re).abs() < 1e-12 && (a.variance_re / b.variance_re - 1.0).abs() < 1e-8);
    }
}

#[test]
fn the_file_holds_what_was_stated() {
    let of = estimated(Focus::Simulation);
    let file = of.to_file(0.04).unwrap();
    assert_eq!(file.directions.rows(), 6, "n(nu + ny) of the model and n of K");
    assert_eq!((file.frequency_response.len(), file.step_response.len()), (30, 26));
    let (gain, error) = of.steady_state_gain(0, 0).unwrap();
    let stated = file.steady_state_gain.unwrap();
    assert!((stated.value - gain).abs() < 1e-12 && (stated.standard_error - error).abs() < 1e-12);
    let last = file.step_response[25];
    assert!((last.value - gain).abs() < 0.05 * gain.abs() && last.standard_error < 2.0 * error);
}

/// Two poles where the system has one, and an input without information: no covariance, with the reason
/// in words.
#[test]
fn what_the_data_do_not_determine_has_no_covariance() {
    let truth = vehicle();
    let mut random = Random(51);
    let e = random.matrix(1, 500);
    let u = Mat::zeros(1, 500);
    let data = DataSet::single(0.04, u.clone(), driven(&truth, &u, &e)).unwrap();
    for focus in [Focus::Prediction, Focus::Simulation] {
        let error = uncertain(&truth, &[vec![0.0; 2]], &data, false, focus).unwrap_err();
        assert!(error.to_string().contains("do not determine"), "{focus:?}: {error}");
    }
}

#[test]
fn an_unstable_initial_estimate_is_refused_in_words() {
    let truth = vehicle();
    let model =
        StateSpace { a: Mat::from_fn(2, 2, |i, j| if i == j { 1.2 } else { 0.0 }), ..truth.model };
    let start = Innovation { model, gain: Mat::zeros(2, 1) };
    let data = DataSet::single(0.04, Mat::zeros(1, 50), Mat::zeros(1, 50)).unwrap();
    for focus in [Focus::Prediction, Focus::Simulation] {
        let x0s = [vec![0.0; 2]];
        let error = refine_prediction(&start, &x0s, &data, false, focus, STOP, 0.999).unwrap_err();
        assert!(error.to_string().contains("stable"), "{error}");
    }
}
