//! What of the input owes nothing to the noise: identification under feedback by two stages (Van
//! den Hof and Schrama, Automatica 29, 1993; Qin and Ljung, IFAC SYSID 2003;
//! docs/methods/refinement.md).
//!
//! With e the innovations of a VARX model ([`Predictor`]), u_r of `u(t) = Σ_{k=1..L} Q_k e(t−k) +
//! u_r(t)` by least squares is the input that the loop would have without noise. The input of the
//! same sample is among the regressors of the VARX model, or its direct gain would make u_r look
//! like innovations. The first samples of each segment keep their input.

use crate::Error;
use crate::data::{DataSet, Segment, Signals};
use crate::linalg::dense::{dot, solve};
use crate::subspace::Factor;
use crate::subspace::closed_loop::Predictor;
use faer::Mat;

/// Innovations of a smaller share of the output are rounding.
const ROUNDING: f64 = 1e-8;

/// The data with u_r in place of u; `past` is the VARX order and L.
pub(crate) fn two_stage_input(
    data: &DataSet,
    factor: &Factor,
    past: usize,
) -> Result<DataSet, Error> {
    let predictor = Predictor::new(factor, past, true)?;
    let innovations: Vec<Signals> =
        data.segments().iter().map(|s| innovations(s, &predictor)).collect();
    let power = |m: &Signals| dot(m.values(), m.values());
    let (of_y, of_e) = data
        .segments()
        .iter()
        .zip(&innovations)
        .fold((0.0, 0.0), |sum, (s, e)| (sum.0 + power(&s.y), sum.1 + power(e)));
    if of_e.is_nan() || of_e <= ROUNDING * ROUNDING * of_y {
        return Ok(data.clone());
    }
    let feedback = feedback(data, &innovations, past);
    let p = data.outputs();
    let segments = data.segments().iter().zip(&innovations).map(|(s, e)| {
        let u = Signals::from_fn(s.u.nrows(), s.len(), |l, t| {
            let mut predicted = 0.0;
            for k in 1..=past.min(t) {
                for i in 0..p {
                    predicted += feedback[((k - 1) * p + i, l)] * e[(i, t - k)];
                }
            }
            s.u[(l, t)] - predicted
        });
        Segment { u, y: s.y.clone() }
    });
    DataSet::new(data.sample_time_s(), segments.collect())
}

/// e of a segment, ny by N; zero where the past is not known.
fn innovations(segment: &Segment, predictor: &Predictor) -> Signals {
    let (m, p, past) = (segment.u.nrows(), segment.y.nrows(), predictor.past());
    Signals::from_fn(p, segment.len(), |i, t| {
        if t < past {
            return 0.0;
        }
        let now: f64 = (0..m).map(|l| predictor.feedthrough[(i, l)] * segment.u[(l, t)]).sum();
        let mut predicted = now;
        for (j, markov) in predictor.markov.iter().enumerate() {
            let then = t - 1 - j;
            predicted += (0..m).map(|l| markov[(i, l)] * segment.u[(l, then)]).sum::<f64>();
            predicted += (0..p).map(|k| markov[(i, m + k)] * segment.y[(k, then)]).sum::<f64>();
        }
        segment.y[(i, t)] - predicted
    })
}

/// Q_1 … Q_L, transposed and stacked, from the correlations of u and e at the lags up to L.
fn feedback(data: &DataSet, innovations: &[Signals], lags: usize) -> Mat<f64> {
    let (m, p) = (data.inputs(), data.outputs());
    let own = correlations(innovations.iter().map(|e| (e, e)), lags, p, p);
    let with_input =
        correlations(data.segments().iter().map(|s| &s.u).zip(innovations), lags, m, p);
    // Σ e(t−a) e(t−b)ᵀ of a stationary sequence is a function of b − a.
    let gram = Mat::from_fn(lags * p, lags * p, |row, column| {
        let (a, b) = (row / p, column / p);
        let (i, j) = (row % p, column % p);
        if b >= a { own[b - a][(i, j)] } else { own[a - b][(j, i)] }
    });
    let right = Mat::from_fn(lags * p, m, |row, l| with_input[row / p + 1][(l, row % p)]);
    solve(gram.as_ref(), right.as_ref())
}

/// Σ_t x(t) e(t−k)ᵀ for the lags k from 0.
fn correlations<'a>(
    pairs: impl Iterator<Item = (&'a Signals, &'a Signals)>,
    lags: usize,
    rows: usize,
    columns: usize,
) -> Vec<Mat<f64>> {
    let mut sums = vec![Mat::<f64>::zeros(rows, columns); lags + 1];
    for (x, e) in pairs {
        for i in 0..rows {
            let x = x.row(i);
            for j in 0..columns {
                let e = e.row(j);
                for (k, sum) in sums.iter_mut().enumerate() {
                    let later = x.get(k..).unwrap_or_default();
                    sum[(i, j)] += dot(later, &e[..later.len()]);
                }
            }
        }
    }
    sums
}
