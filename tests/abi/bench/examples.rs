//! The documents that the timed FMUs are made from, where one example is not enough.

use crate::documents;
use steerwright_formats::{Continuous, Document, Matrix, Path, Pid, Plant};
use steerwright_packaging::Fmu;

/// Suffix of the FMU's name, and the document.
pub(crate) fn timed_documents(fmu: Fmu) -> Vec<(&'static str, String)> {
    match fmu.schema() {
        Plant::SCHEMA => plants(),
        Pid::SCHEMA => vec![("", documents::pid().to_json())],
        Path::SCHEMA => vec![("", documents::path().to_json())],
        _ => vec![("", fmu.example().to_owned())],
    }
}

/// The identified plant as it usually is, with its continuous form: without and with its delay;
/// and without that form, which moves on the grid of its samples.
fn plants() -> Vec<(&'static str, String)> {
    let sampled = || Plant { input_delay_s: 0.0, ..documents::plant() };
    let continuous = || Plant { continuous: Some(logarithm(&sampled())), ..sampled() };
    vec![
        ("", continuous().to_json()),
        (" (25 ms delay)", Plant { input_delay_s: 0.025, ..continuous() }.to_json()),
        (" (no continuous form)", sampled().to_json()),
    ]
}

/// F and G of A and B by the series `log(I + X) = X − X²/2 + X³/3 − …` of `[A B; 0 I]`, which is
/// near I in the example.
fn logarithm(plant: &Plant) -> Continuous {
    let (discrete, n) = (&plant.discrete, plant.discrete.a.0.len());
    let x: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let mut row = discrete.a.0[i].clone();
            row[i] -= 1.0;
            row.push(discrete.b.0[i][0]);
            row
        })
        .collect();
    let (mut power, mut sum) = (x.clone(), x.clone());
    for k in 2..200 {
        let entry = |i: usize, j: usize| (0..n).map(|l| power[i][l] * x[l][j]).sum::<f64>();
        power = (0..n).map(|i| (0..=n).map(|j| entry(i, j)).collect()).collect();
        let factor = if k % 2 == 0 { -1.0 } else { 1.0 } / f64::from(k);
        for (sum, power) in sum.iter_mut().flatten().zip(power.iter().flatten()) {
            *sum += factor * power;
        }
    }
    let rate = |i: usize, j: usize| sum[i][j] / discrete.sample_time_s;
    Continuous {
        f: Matrix((0..n).map(|i| (0..n).map(|j| rate(i, j)).collect()).collect()),
        g: Matrix((0..n).map(|i| vec![rate(i, n)]).collect()),
        h: discrete.c.clone(),
    }
}
