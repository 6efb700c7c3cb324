//! The order, and whether there is feedthrough, by cross-validation: blocks of time of the estimation data are left out in
//! turn, and the model of the rest is simulated on them (M. Stone, Journal of the Royal Statistical Society B 36, 1974; L.
//! Ljung, *System Identification*, 2nd ed. 1999, section 16.4). A criterion of prediction errors with a model of the noise
//! takes one autoregression for all outputs, which is too simple for many of them.

use crate::Error;
use crate::data::{DataSet, Segment};
use crate::linalg::dense::dot;
use crate::pem::Stop;
use crate::selection::candidate::{Candidate, refine};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::initial_estimates::InitialEstimates;
use crate::selection::options::IdentifyOptions;
use crate::selection::order::Errors;
use std::ops::Range;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_formats::interruption::check;

/// Blocks that are left out in turn: of many samples halves, which determine the score as well.
const BLOCKS: usize = 4;
const BLOCKS_OF_MANY: usize = 2;
/// Samples times outputs that are many.
const MANY: usize = 6000;
/// Enough to compare orders on data that were left out.
const STOP: Stop = Stop { steps: 12, least_gain: 1e-4 };
/// Orders that are tried beyond the best so far.
const LOOK_AHEAD: usize = 4;
/// Shorter pieces have no initial state to simulate from.
const LEAST_PIECE: usize = 12;
/// A larger order has to simulate better by this share.
const CLEARLY: f64 = 0.005;
/// Share by which another order has to simulate better than that of BIC.
const CLEARLY_BETTER: f64 = 0.02;

/// A model's order, whether it has feedthrough and whether it is refined, with its errors on what was left out.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scored {
    pub(super) order: usize,
    pub(super) feedthrough: bool,
    pub(super) refined: bool,
    /// Of each block and output the root of the squared errors over those of the output's mean.
    errors: Vec<f64>,
    /// Their mean.
    pub(super) score: f64,
}

impl Scored {
    /// Whether it simulates better than another by more than 2 %, and by more than two standard errors of the difference over
    /// blocks and outputs.
    pub(super) fn is_clearly_better_than(&self, other: &Self) -> bool {
        let differences: Vec<f64> =
            other.errors.iter().zip(&self.errors).map(|(other, own)| other - own).collect();
        let error = standard_deviation(&differences) / (differences.len() as f64).sqrt();
        let gained = other.score - self.score;
        gained > CLEARLY_BETTER * self.score && gained > 2.0 * error
    }
}

struct Fold {
    estimation: DataSet,
    left_out: DataSet,
}

/// The scores of all orders on the data; none where the data are too few to leave blocks out.
pub(super) fn scores(data: &DataSet, options: &IdentifyOptions) -> Result<Vec<Scored>, Error> {
    let folds = folds(data)?;
    let mut estimates = Vec::new();
    for fold in &folds {
        let Ok(of_fold) = InitialEstimates::new(&fold.estimation, options) else {
            return Ok(Vec::new());
        };
        estimates.push(of_fold);
    }
    let Some(largest) = estimates.iter().map(InitialEstimates::largest_order).min() else {
        return Ok(Vec::new());
    };
    let orders = match options.order {
        Some(order) => order..=order,
        None => 1..=options.max_order.min(largest),
    };
    let mut all: Vec<Scored> = Vec::new();
    let start = options.feedthrough == Some(true);
    for order in orders {
        all.extend(scored(&folds, &estimates, (order, start), options));
        let best = least(&all).map_or(order, |best| best.order);
        if order >= best + LOOK_AHEAD {
            break;
        }
    }
    let without = least(&all);
    // At a stated order, a direct gain could represent states that are not allowed.
    let is_open = options.feedthrough.is_none() && options.order.is_none();
    if let (true, Some(best)) = (is_open, without) {
        for order in best.order.saturating_sub(1).max(1)..=(best.order + 1).min(largest) {
            all.extend(scored(&folds, &estimates, (order, true), options));
        }
    }
    Ok(all)
}

/// The simplest of about equal scores.
pub(super) fn least(all: &[Scored]) -> Option<Scored> {
    let best = all.iter().map(|s| s.score).fold(f64::INFINITY, f64::min);
    let near = all.iter().filter(|s| s.score <= (1.0 + CLEARLY) * best);
    // Of one order, a direct gain is nu·ny parameters more, and the refined model is the usual one.
    near.min_by_key(|s| (s.order, s.feedthrough, !s.refined)).cloned()
}

/// The scores of an order as it is estimated and refined; none where a fold has no such model.
fn scored(
    folds: &[Fold],
    estimates: &[InitialEstimates<'_>],
    (order, feedthrough): (usize, bool),
    options: &IdentifyOptions,
) -> Vec<Scored> {
    let mut all = [Vec::new(), Vec::new()];
    for (fold, estimates) in folds.iter().zip(estimates) {
        check();
        let Ok(mut candidate) = estimates.best(order, feedthrough) else { return Vec::new() };
        all[0].extend(errors(&candidate, &fold.left_out));
        if options.refine && refine(&fold.estimation, &mut candidate, STOP).is_err() {
            return Vec::new();
        }
        all[1].extend(errors(&candidate, &fold.left_out));
    }
    let row = |refined: bool, errors: Vec<f64>| Scored {
        order,
        feedthrough,
        refined,
        score: mean(&errors),
        errors,
    };
    let [estimated, refined] = all;
    let mut rows = vec![row(false, estimated)];
    if options.refine {
        rows.push(row(true, refined));
    }
    rows.retain(|row| row.score.is_finite());
    rows
}

/// Of each output the root of the squared simulation errors over those of the mean, less the part that the initial state
/// takes; infinite where there is no simulation.
fn errors(candidate: &Candidate, data: &DataSet) -> Vec<f64> {
    let outputs = data.outputs();
    let simulated = || -> Result<Errors, Error> {
        let data = candidate.initial_conditions.about_output_offset(data)?;
        let initial = InitialConditions::new(&candidate.model, &data, false)?;
        Ok(initial.errors(&candidate.model, &data))
    };
    let Ok(errors) = simulated() else { return vec![f64::INFINITY; outputs] };
    let count = data.samples() as f64;
    let states = (candidate.model.order() * data.segments().len()) as f64 / outputs as f64;
    let free = (count - states).max(1.0) / count;
    let of_output = |i: usize| {
        let squares: f64 = errors.iter().map(|e| dot(e.row(i), e.row(i))).sum();
        let rows = || data.segments().iter().flat_map(|s| s.y.row(i));
        let mean = rows().sum::<f64>() / count;
        let spread: f64 = rows().map(|y| (y - mean) * (y - mean)).sum();
        // In the unit of the estimation data's standard deviation, where the block hardly moves.
        (squares / free / spread.max(0.1 * count)).sqrt()
    };
    (0..outputs).map(of_output).collect()
}

fn folds(data: &DataSet) -> Result<Vec<Fold>, Error> {
    let count = data.samples();
    let blocks = if count * data.outputs() > MANY { BLOCKS_OF_MANY } else { BLOCKS };
    let mut folds = Vec::new();
    for block in 0..blocks {
        let (from, to) = (block * count / blocks, (block + 1) * count / blocks);
        let (mut kept, mut left_out) = (Vec::new(), Vec::new());
        let mut start = 0;
        for s in data.segments() {
            let inside = |at: usize| at.clamp(start, start + s.len()) - start;
            let part =
                |range: Range<usize>| Segment::new(s.u.columns(range.clone()), s.y.columns(range));
            let pieces = [0..inside(from), inside(to)..s.len()];
            kept.extend(pieces.into_iter().filter(|r| r.len() >= LEAST_PIECE).map(part));
            let range = inside(from)..inside(to);
            if range.len() >= LEAST_PIECE {
                left_out.push(part(range));
            }
            start += s.len();
        }
        if kept.is_empty() || left_out.is_empty() {
            continue;
        }
        folds.push(Fold {
            estimation: DataSet::new(data.sample_time_s(), kept)?,
            left_out: DataSet::new(data.sample_time_s(), left_out)?,
        });
    }
    Ok(folds)
}
