//! Ljung's hair dryer against what SLICOT prints for it (IB01AD and IB01BD, METH = C: A and C by
//! MOESP, B and D by N4SID), n = 4, 15 block rows, all 1000 samples, means not removed.

use crate::common::data;
use crate::known::{Random, pole_distance, response_distance};
use faer::Mat;
use steerwright_drivelog::{LogOptions, read_log};
use steerwright_sysid::subspace::{
    Factor, noise_model, shift_realization, structured_bd, subspace,
};
use steerwright_sysid::{DataSet, IdentifyOptions, StateSpace, Weighting, identify};

/// SLICOT's printed matrices, four decimals.
struct Printed {
    model: StateSpace,
    gain: Mat<f64>,
}

fn printed() -> Printed {
    let text = String::from_utf8(data("dryer2/slicot_ib01bd_result.txt")).unwrap();
    let block = |title: &str, rows: usize| -> Mat<f64> {
        let lines: Vec<Vec<f64>> = text
            .lines()
            .skip_while(|l| !l.contains(title))
            .skip(1)
            .take(rows)
            .map(|l| l.split_whitespace().map(|x| x.parse().unwrap()).collect())
            .collect();
        Mat::from_fn(rows, lines[0].len(), |i, j| lines[i][j])
    };
    Printed {
        model: StateSpace {
            a: block("state matrix A", 4),
            b: block("input matrix B", 4),
            c: block("output matrix C", 1),
            d: block("input-output matrix D", 1),
        },
        gain: block("Kalman gain matrix K", 4),
    }
}

fn signals() -> (Mat<f64>, Mat<f64>) {
    let text = String::from_utf8(data("dryer2/dryer2_slicot_ib01ad.csv")).unwrap();
    let rows: Vec<[f64; 2]> = text
        .lines()
        .skip(1)
        .map(|l| {
            let (u, y) = l.split_once(',').unwrap();
            [u.parse().unwrap(), y.parse().unwrap()]
        })
        .collect();
    (Mat::from_fn(1, rows.len(), |_, j| rows[j][0]), Mat::from_fn(1, rows.len(), |_, j| rows[j][1]))
}

#[test]
fn the_combined_method_reproduces_slicots_model() {
    let reference = printed();
    let (u, y) = signals();
    let data = DataSet::single(0.08, u, y).unwrap();
    let factor = Factor::new(&data, 15).unwrap();
    let sub = subspace(&factor, Weighting::Moesp).unwrap();
    let (a, c) = shift_realization(&sub, 4, 1).unwrap();
    let model = structured_bd(&factor, &sub, a.as_ref(), c.as_ref(), true).unwrap();
    // What half a unit of the fourth printed decimal can move the reference by.
    let mut random = Random(1);
    let (mut pole_floor, mut response_floor): (f64, f64) = (0.0, 0.0);
    for _ in 0..50 {
        let mut rounded = |m: &Mat<f64>| {
            let noise: Vec<f64> = (0..16).map(|_| 1e-4 * (random.uniform() - 0.5)).collect();
            Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] + noise[4 * i + j])
        };
        let m = &reference.model;
        let other =
            StateSpace { a: rounded(&m.a), b: rounded(&m.b), c: rounded(&m.c), d: rounded(&m.d) };
        pole_floor = pole_floor.max(pole_distance(&other, m));
        response_floor = response_floor.max(response_distance(m, &other));
    }
    let poles = pole_distance(&model, &reference.model);
    let response = response_distance(&reference.model, &model);
    println!(
        "poles {poles:.1e} of {pole_floor:.1e}, response {response:.1e} of {response_floor:.1e}"
    );
    assert!(poles < pole_floor, "{poles:e}");
    assert!(response < response_floor.min(3e-3), "{response:e}");

    // The filter: the response from innovation to output. SLICOT takes its covariances from the states
    // of the singular vectors, this crate from those of the model itself.
    let noise = noise_model(&factor, &model).unwrap();
    let from_innovation = |m: &StateSpace, k: &Mat<f64>| StateSpace { b: k.clone(), ..m.clone() };
    let filter = response_distance(
        &from_innovation(&reference.model, &reference.gain),
        &from_innovation(&model, &noise.gain),
    );
    println!("filter {filter:.1e}");
    assert!(noise.solved && filter < 0.06, "{filter:e}");
}

#[test]
fn the_validation_half_is_simulated_at_least_as_well_as_by_n4sid() {
    let files = vec![("dryer2.csv".to_owned(), data("dryer2/dryer2_slicot_ib01ad.csv"))];
    let mut options = LogOptions {
        input: Some("u".into()),
        output: Some("y".into()),
        row_period_s: Some(0.08),
        steering_ratio: Some(1.0),
        ..LogOptions::default()
    };
    for name in ["u", "y"] {
        options.units.insert(name.into(), "1".into());
    }
    let log = read_log(&files, &options).unwrap();
    // Octave's n4sid with 10 block rows and order 3: 89.1 % and 85.9 %, with an initial state of the validation half.
    let fixed = IdentifyOptions {
        method: Some(Weighting::N4sid.into()),
        order: Some(3),
        horizon: Some(10),
        refine: false,
        ..IdentifyOptions::default()
    };
    let fit = identify(&log, &fixed).unwrap().plant.evidence.fit;
    println!("{fit:?}");
    assert!((fit.estimation - 89.1).abs() < 0.3 && (fit.validation - 85.9).abs() < 0.3, "{fit:?}");
    let plant = identify(&log, &IdentifyOptions::default()).unwrap().plant;
    println!("{:?} order {}", plant.evidence.fit, plant.order());
    let validated = plant.evidence.fit.validation;
    assert!(validated >= fit.validation && (3..=4).contains(&plant.order()), "{validated}");
}
