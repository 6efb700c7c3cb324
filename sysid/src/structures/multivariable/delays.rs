//! Pure delays by the first lags of the impulse response: least squares of each output on its own past and on the lags of all
//! inputs; the first lag whose coefficient is beyond chance ends the delay (L. Ljung, *System Identification*, 2nd ed. 1999,
//! section 6.1, on correlation analysis with a prefilter).

use crate::data::DataSet;
use crate::linalg::dense::{is_finite, least_squares, r_factor, solve};
use faer::Mat;

/// Lags of each input, and the past of the output that whitens the errors.
const LAGS: usize = 30;
const PAST: usize = 4;
/// Samples for each coefficient.
const SAMPLES: usize = 4;
/// Standard errors from which a coefficient is beyond chance: of thirty lags by chance in one of thirty pairs.
const BEYOND: f64 = 3.3;

/// For each output and input the samples before the first response beyond that of a model without feedthrough; `None` where
/// no lag responds, or where the data are too few.
pub(super) fn first_responses(data: &DataSet) -> Vec<Vec<Option<usize>>> {
    let (m, p) = (data.inputs(), data.outputs());
    let lags = LAGS.min((data.samples() / SAMPLES).saturating_sub(PAST) / m);
    (0..p)
        .map(|output| if lags < 3 { None } else { of_output(data, output, lags) })
        .map(|found| found.unwrap_or_else(|| vec![None; m]))
        .collect()
}

fn of_output(data: &DataSet, output: usize, lags: usize) -> Option<Vec<Option<usize>>> {
    let m = data.inputs();
    let width = PAST + m * lags + 1;
    let rows: usize = data.segments().iter().map(|s| s.len().saturating_sub(lags.max(PAST))).sum();
    if rows < 2 * width {
        return None;
    }
    let mut all = Mat::<f64>::zeros(rows, width);
    let mut at = 0;
    for s in data.segments() {
        for t in lags.max(PAST)..s.len() {
            for k in 0..PAST {
                all[(at, k)] = s.y[(output, t - 1 - k)];
            }
            for j in 0..m {
                for k in 0..lags {
                    all[(at, PAST + j * lags + k)] = s.u[(j, t - k)];
                }
            }
            all[(at, width - 1)] = s.y[(output, t)];
            at += 1;
        }
    }
    let r = r_factor(all.as_ref());
    let q = width - 1;
    let own = r.get(..q, ..q);
    let theta = least_squares(own, r.get(..q, q..), 1e-10).ok()?;
    let inverse = solve(own, Mat::<f64>::identity(q, q).as_ref());
    if !is_finite(inverse.as_ref()) {
        return None;
    }
    let variance = r[(q, q)].powi(2) / (rows - q) as f64;
    let is_beyond = |k: usize| {
        let error = variance.sqrt() * inverse.row(k).norm_l2();
        theta[(k, 0)].abs() > BEYOND * error
    };
    let of_input = |j: usize| (0..lags).find(|k| is_beyond(PAST + j * lags + k));
    Some((0..m).map(|j| of_input(j).map(|lag| lag.saturating_sub(1))).collect())
}

/// The delay of each input: the least of its pairs.
pub(super) fn of_inputs(pairs: &[Vec<Option<usize>>], inputs: usize) -> Vec<usize> {
    let of = |j: usize| pairs.iter().filter_map(|row| row[j]).min().unwrap_or(0);
    (0..inputs).map(of).collect()
}

/// The data with each input delayed by so many samples; before the first sample of a segment it has its first value.
pub(super) fn delayed(data: &DataSet, samples: &[usize]) -> Result<DataSet, crate::Error> {
    let segments = data.segments().iter().map(|s| crate::data::Segment {
        u: crate::data::Signals::from_fn(s.u.nrows(), s.len(), |j, t| {
            s.u[(j, t.saturating_sub(samples[j]))]
        }),
        y: s.y.clone(),
    });
    DataSet::new(data.sample_time_s(), segments.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Signals;
    use crate::validation::residuals::correlation::tests::noise;

    #[test]
    fn delays_are_those_of_the_pairs() {
        let state = &mut 9;
        let count = 1500;
        let u: Vec<Vec<f64>> = (0..2).map(|_| (0..count).map(|_| noise(state)).collect()).collect();
        let late = |j: usize, t: usize, lag: usize| if t >= lag { u[j][t - lag] } else { 0.0 };
        let mut y = [Vec::new(), Vec::new()];
        let mut clean = [0.0; 2];
        for t in 0..count {
            clean[0] = 0.8 * clean[0] + late(0, t, 1) + 0.5 * late(1, t, 6);
            clean[1] = 0.5 * clean[1] + late(1, t, 4);
            for (y, clean) in y.iter_mut().zip(clean) {
                y.push(clean + 0.3 * noise(state));
            }
        }
        let data = DataSet::single(
            1.0,
            Signals::from_fn(2, count, |j, t| u[j][t]),
            Signals::from_fn(2, count, |i, t| y[i][t]),
        )
        .unwrap();
        let found = first_responses(&data);
        assert_eq!(found, [[Some(0), Some(5)], [None, Some(3)]]);
        assert_eq!(of_inputs(&found, 2), [0, 3]);
        let late = delayed(&data, &[0, 3]).unwrap();
        assert_eq!(late.segments()[0].u[(1, 10)], u[1][7]);
        assert_eq!(late.segments()[0].u[(1, 1)], u[1][0]);
    }
}
