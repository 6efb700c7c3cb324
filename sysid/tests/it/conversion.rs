//! Discrete and continuous models under both holds: against scipy, against the definition, and back.

use crate::known::Random;
use faer::Mat;
use steerwright_sysid::model::conversion::{
    ContinuousStateSpace, Hold, discretize_held, to_continuous_held,
};
use steerwright_sysid::{StateSpace, simulate};

const SAMPLE_TIME: f64 = 0.04;

fn matrix<const R: usize, const C: usize>(rows: [[f64; C]; R]) -> Mat<f64> {
    Mat::from_fn(R, C, |i, j| rows[i][j])
}

/// Lateral velocity and yaw rate of a car behind an actuator lag of 50 ms.
fn vehicle() -> ContinuousStateSpace {
    ContinuousStateSpace {
        f: matrix([[-5.0, -14.0, 60.0], [1.3, -6.0, 40.0], [0.0, 0.0, -20.0]]),
        g: matrix([[0.0], [0.0], [20.0]]),
        h: matrix([[1.0, 0.2, 0.0]]),
        d: matrix([[0.3]]),
    }
}

fn distance(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (a - b).norm_max() / b.norm_max().max(1e-300)
}

/// scipy 1.17.1: `cont2discrete((F, G, H, D), 0.04, method='foh')`.
#[test]
fn first_order_hold_is_that_of_scipy() {
    let got = discretize_held(&vehicle(), SAMPLE_TIME, Hold::First);
    let a = matrix([
        [8.069_958_412_219_122e-1, -4.472_624_354_510_806e-1, 1.171_177_198_251_984],
        [4.153_151_186_331_464e-2, 7.750_485_244_039_779e-1, 9.998_673_403_958_249e-1],
        [0.0, 0.0, 4.493_289_641_172_217e-1],
    ]);
    let b =
        matrix([[0.852_940_566_633_345_6], [0.752_922_769_068_299_2], [0.379_048_237_200_265_26]]);
    assert!(distance(&got.a, &a) < 1e-14);
    assert!(distance(&got.b, &b) < 1e-14);
    assert_eq!(got.c, vehicle().h);
    assert!(distance(&got.d, &matrix([[0.561_845_368_260_442_6]])) < 1e-14);
}

/// The same input with a hundred times as many samples, where the hold hardly matters.
#[test]
fn between_samples_the_input_stays_or_moves_straight() {
    const FINER: usize = 100;
    let u = |k: usize| (0.3 * k as f64).sin() + if k > 5 { 1.0 } else { 0.0 };
    let count = 40;
    let coarse = Mat::from_fn(1, count, |_, k| u(k));
    for hold in [Hold::Zero, Hold::First] {
        // Held finely, the middle of each fine step representing it.
        let fine_u = Mat::from_fn(1, (count - 1) * FINER, |_, t| {
            let (k, part) = (t / FINER, (t % FINER) as f64 + 0.5);
            match hold {
                Hold::Zero => u(k),
                Hold::First => u(k) + (u(k + 1) - u(k)) * part / FINER as f64,
            }
        });
        let fine = ContinuousStateSpace { d: Mat::zeros(1, 1), ..vehicle() };
        let fine_model = discretize_held(&fine, SAMPLE_TIME / FINER as f64, Hold::Zero);
        let fine_y = simulate(&fine_model, fine_u.as_ref(), &[0.0; 3]);
        let model = discretize_held(&vehicle(), SAMPLE_TIME, hold);
        // The first-order hold's state is x − Γ₂u, and x(0) is 0: found from the first output.
        let x0 = if hold == Hold::Zero {
            vec![0.0; 3]
        } else {
            let g = vehicle().g;
            let ramp = {
                let with = |h: Mat<f64>| {
                    let system =
                        ContinuousStateSpace { h, d: Mat::zeros(3, 1), g: g.clone(), ..vehicle() };
                    discretize_held(&system, SAMPLE_TIME, Hold::First).d
                };
                with(Mat::identity(3, 3))
            };
            (0..3).map(|i| -ramp[(i, 0)] * u(0)).collect()
        };
        let y = simulate(&model, coarse.as_ref(), &x0);
        for k in 0..count - 1 {
            let expected = fine_y[(0, k * FINER)] + 0.3 * u(k);
            let error = (y[(0, k)] - expected).abs();
            assert!(error < 2e-5, "{hold:?} {k}: {} {expected}", y[(0, k)]);
        }
    }
}

#[test]
fn there_and_back_to_rounding() {
    let mut random = Random(7);
    for (n, m, p) in [(1, 1, 1), (2, 1, 1), (4, 2, 1), (6, 1, 2), (8, 2, 3)] {
        // A random stable continuous system with poles up to about half the Nyquist rate.
        let f = random.matrix(n, n);
        let shift = 2.5 * (n as f64).sqrt();
        let system = ContinuousStateSpace {
            f: Mat::from_fn(n, n, |i, j| 5.0 * (f[(i, j)] - if i == j { shift } else { 0.0 })),
            g: random.matrix(n, m),
            h: random.matrix(p, n),
            d: random.matrix(p, m),
        };
        for hold in [Hold::Zero, Hold::First] {
            let model = discretize_held(&system, SAMPLE_TIME, hold);
            let (back, round_trip) = to_continuous_held(&model, SAMPLE_TIME, hold).unwrap();
            assert!(round_trip <= 1e-10, "{hold:?} {n}: {round_trip:e}");
            for (got, was) in [(&back.f, &system.f), (&back.g, &system.g), (&back.d, &system.d)] {
                assert!(distance(got, was) < 1e-9, "{hold:?} {n}: {:e}", distance(got, was));
            }
        }
    }
}

#[test]
fn without_a_real_logarithm_it_stays_discrete_with_the_reason() {
    for (pole, word) in [(-0.4, "negative"), (0.0, "zero")] {
        let model = StateSpace {
            a: matrix([[pole, 0.3], [0.0, 0.5]]),
            b: matrix([[1.0], [1.0]]),
            c: matrix([[1.0, 0.0]]),
            d: matrix([[0.1]]),
        };
        for hold in [Hold::Zero, Hold::First] {
            let reason = to_continuous_held(&model, SAMPLE_TIME, hold).unwrap_err();
            assert!(reason.contains(word), "{reason}");
        }
    }
}

/// An integrator has φ₁ = 1 there: both holds go through.
#[test]
fn integrators_convert() {
    let system = ContinuousStateSpace {
        f: matrix([[0.0, 1.0], [0.0, 0.0]]),
        g: matrix([[0.0], [1.0]]),
        h: matrix([[1.0, 0.0]]),
        d: matrix([[0.0]]),
    };
    let model = discretize_held(&system, SAMPLE_TIME, Hold::First);
    // The double integrator's first-order hold: T²/6, 2T²/3, T²/6 over (z − 1)².
    let markov = model.markov_parameters(3);
    let t2 = SAMPLE_TIME * SAMPLE_TIME;
    for (got, expected) in markov.iter().zip([1.0 / 6.0, 1.0, 2.0]) {
        assert!((got[(0, 0)] - t2 * expected).abs() < 1e-15, "{} {}", got[(0, 0)], t2 * expected);
    }
    let (back, _) = to_continuous_held(&model, SAMPLE_TIME, Hold::First).unwrap();
    assert!(distance(&back.f, &system.f) < 1e-12 && distance(&back.g, &system.g) < 1e-12);
    assert!(back.d.norm_max() < 1e-12);
}
