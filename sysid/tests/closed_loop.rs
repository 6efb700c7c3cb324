//! Identification from closed-loop data.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use faer::Mat;
use sysid::closed_loop::{self, Method};
use sysid::{DataSet, StateSpace, simulate};
use sysid_evaluation::{Random, markov_distance, pole_distance};

#[test]
fn without_noise_both_methods_are_exact() {
    let mut random = Random(1);
    for (n, m, p) in [(1, 1, 1), (2, 1, 1), (4, 1, 1), (3, 2, 1), (4, 1, 2), (5, 2, 3)] {
        for feedthrough in [false, true] {
            let mut truth = random.system(n, m, p);
            if !feedthrough {
                truth.d = Mat::zeros(p, m);
            }
            let u = random.matrix(m, 500);
            let y = simulate(&truth, u.as_ref(), &vec![1.0; n]);
            let data = DataSet::single(1.0, u, y).unwrap();
            for method in Method::ALL {
                let found =
                    closed_loop::identify(&data, method, n + 4, n + 2, n, feedthrough).unwrap();
                let model = &found.model;
                let (poles, markov) =
                    (pole_distance(model, &truth), markov_distance(&truth, model, 30));
                let what = format!("{method:?} {n} {m} {p} D {feedthrough}");
                println!("{what}: {poles:.1e} {markov:.1e}");
                assert!(poles < 1e-8 && markov < 1e-8, "{what}: {poles:.1e} {markov:.1e}");
                if !feedthrough {
                    assert_eq!(model.d, Mat::<f64>::zeros(p, m), "{what}");
                }
            }
            let _: &StateSpace = &truth;
        }
    }
}
