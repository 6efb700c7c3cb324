//! Prior knowledge of a vehicle's dynamics: two states with a natural frequency of 0.5 to 4 Hz. A
//! subspace estimate may spend one on noise near the Nyquist frequency, from where no refinement
//! finds back.

use crate::data::DataSet;
use crate::model::conversion::exponential;
use crate::selection::candidate::Candidate;
use crate::selection::initial_estimates::refit_about;
use crate::selection::order::sum_of_squares;
use faer::Mat;

/// Order of the lateral dynamics.
pub(crate) const ORDER: usize = 2;
/// Natural frequencies, rad/s, and dampings that are tried.
const FREQUENCIES: [f64; 4] = [3.0, 6.0, 12.0, 24.0];
const DAMPINGS: [f64; 2] = [0.6, 1.2];

/// The best simulator with a vehicle's poles; other fields are those of `another` of order 2.
pub(crate) fn initial_estimate(data: &DataSet, another: &Candidate) -> Option<Candidate> {
    let step = data.sample_time_s();
    let offset = another.initial_conditions.offsets.is_some();
    // B is free, so that every numerator is possible with this C.
    let c = Mat::from_fn(1, ORDER, |_, j| if j == 0 { 1.0 } else { 0.0 });
    let mut best: Option<Candidate> = None;
    for frequency in FREQUENCIES {
        for damping in DAMPINGS {
            let w = frequency * step;
            let f = Mat::from_fn(ORDER, ORDER, |i, j| match (i, j) {
                (0, 0) => 0.0,
                (0, _) => w,
                (_, 0) => -w,
                _ => -2.0 * damping * w,
            });
            let a = exponential(f.as_ref());
            let Ok((model, initial_conditions, _)) =
                refit_about(&a, &c, data, another.feedthrough, offset)
            else {
                continue;
            };
            let cost = sum_of_squares(&initial_conditions.errors(&model, data));
            if cost.is_finite() && best.as_ref().is_none_or(|best| cost < best.cost) {
                let own = Candidate { model, initial_conditions, cost, ..another.clone() };
                best = Some(Candidate { stabilised: None, ..own });
            }
        }
    }
    best
}
