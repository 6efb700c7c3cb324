//! Vehicles drawn from the covariance of a longitudinal model.

use steerwright_formats::{Longitudinal, Matrix};
use steerwright_models::noise::gaussian;

/// Share of an estimate below which a drawn lag or gain is no vehicle's.
const LEAST_SHARE: f64 = 0.1;

/// `count` vehicles of a stream; streams of one seed are disjoint.
pub(crate) fn draw(
    model: &Longitudinal,
    seed: u64,
    stream: u64,
    count: usize,
) -> Vec<Longitudinal> {
    let factor = cholesky(&model.covariance);
    let n = factor.len() as u64;
    let seed = (seed % (1 << 30)) as i32;
    let mut vehicles = Vec::new();
    for k in 0..count as u64 {
        let first = (stream << 32) + k * n;
        let xi: Vec<f64> = (first..first + n).map(|i| gaussian(seed, i)).collect();
        let mut vehicle = model.clone();
        for (name, row) in model.parameters.iter().zip(&factor) {
            let moved: f64 = row.iter().zip(&xi).map(|(l, x)| l * x).sum();
            if let Some(estimate) = vehicle.estimate_mut(name) {
                let is_positive = name.contains("time_constant") || name.contains("gain");
                let least = if is_positive { LEAST_SHARE * estimate.value } else { f64::MIN };
                let least = if name.contains("delay") { 0.0 } else { least };
                estimate.value = (estimate.value + moved).max(least);
                if name == "pedal_curvature" {
                    estimate.value = estimate.value.clamp(-1.0, 1.0);
                }
            }
        }
        vehicles.push(vehicle);
    }
    vehicles
}

/// The lower factor of a covariance, row by row; a direction without variance has none.
fn cholesky(covariance: &Matrix) -> Vec<Vec<f64>> {
    let a = &covariance.0;
    let n = a.len();
    let mut l = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let before: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = a[i][j] - before;
            if i == j {
                // Rounding leaves a share of the variance.
                l[i][i] = if rest > 1e-12 * a[i][i] { rest.sqrt() } else { 0.0 };
            } else if l[j][j] > 0.0 {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use super::{cholesky, draw};
    use steerwright_formats::{Document, Longitudinal, Matrix};

    #[test]
    fn drawn_vehicles_have_the_covariance() {
        let text = include_str!("../../../fmu/longitudinal-plant/example.json");
        let mut model = Longitudinal::from_json(text, "it").unwrap();
        model.parameters = vec!["gains[0].gain".into(), "resistance_mps2".into()];
        let covariance = [[0.04, 0.003], [0.003, 0.0009]];
        model.covariance = Matrix(covariance.iter().map(|row| row.to_vec()).collect());
        let count = 20_000;
        let mut sums = [[0.0; 2]; 2];
        for vehicle in draw(&model, 1, 0, count) {
            let off = [
                vehicle.gains[0].gain.value - model.gains[0].gain.value,
                vehicle.resistance_mps2.value - model.resistance_mps2.value,
            ];
            for (i, row) in sums.iter_mut().enumerate() {
                for (j, sum) in row.iter_mut().enumerate() {
                    *sum += off[i] * off[j] / count as f64;
                }
            }
        }
        for (row, expected) in sums.iter().zip(covariance) {
            for (sum, expected) in row.iter().zip(expected) {
                assert!((sum - expected).abs() < 0.06 * (0.04_f64 * 0.0009).sqrt().max(expected));
            }
        }
        let singular = Matrix(vec![vec![1.0, 1.0], vec![1.0, 1.0]]);
        assert_eq!(cholesky(&singular), [[1.0, 0.0], [1.0, 0.0]]);
    }
}
