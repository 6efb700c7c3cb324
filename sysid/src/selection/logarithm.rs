//! A continuous form for a model that hardly lacks one ([`off_branch_cut`]).

use crate::Error;
use crate::data::DataSet;
use crate::model::conversion::{costs_nothing, has_logarithm, off_branch_cut};
use crate::selection::candidate::{Candidate, FINE, refine};
use crate::selection::initial_estimates::refit_about;
use crate::selection::order::sum_of_squares;

/// The chosen model taken off the branch cut, or one of lower order that has a continuous form or is brought to
/// one, whichever costs least, where that is nearly nothing; returns which is chosen then. `data` are those
/// whose simulation errors the chosen one makes small.
pub(crate) fn with_logarithm(
    data: &DataSet,
    candidates: &mut [Candidate],
    chosen: usize,
    refined: bool,
) -> Result<usize, Error> {
    if off_branch_cut(&candidates[chosen].model)?.is_empty() {
        return Ok(chosen);
    }
    let offset = candidates[chosen].initial_conditions.offsets.is_some();
    let least = mean_square(&candidates[chosen], data);
    let mut best: Option<(usize, Candidate, f64)> = None;
    for i in in_turn(candidates.iter().map(|c| c.model.order()), chosen) {
        let mut one = candidates[i].clone();
        if i != chosen {
            refit(&mut one, data, offset)?;
            if refined {
                refine(data, &mut one, FINE)?;
            }
        }
        let places = off_branch_cut(&one.model)?;
        let moved = !places.is_empty();
        let mut now = if moved { f64::INFINITY } else { mean_square(&one, data) };
        let from = one.clone();
        for model in places {
            let mut placed = Candidate { model, ..from.clone() };
            refit(&mut placed, data, offset)?;
            let square = mean_square(&placed, data);
            if square < now {
                (one, now) = (placed, square);
            }
        }
        one.has_logarithm = has_logarithm(&one.model);
        one.mirroring_cost = moved.then_some(now / least - 1.0);
        let is_best = best.as_ref().is_none_or(|(_, _, square)| now < *square);
        if one.has_logarithm && costs_nothing(least, now) && is_best {
            best = Some((i, one, now));
        }
    }
    let Some((i, one, _)) = best else { return Ok(chosen) };
    candidates[i] = one;
    Ok(i)
}

/// The chosen candidate, then those of lower order.
pub(crate) fn in_turn(orders: impl Iterator<Item = usize>, chosen: usize) -> Vec<usize> {
    let orders: Vec<usize> = orders.collect();
    let lower = (0..orders.len()).filter(|i| orders[*i] < orders[chosen]);
    std::iter::once(chosen).chain(lower).collect()
}

/// Sets B, D, initial states and output offset of least errors for the candidate's poles.
fn refit(candidate: &mut Candidate, data: &DataSet, offset: bool) -> Result<(), Error> {
    let (a, c) = (&candidate.model.a, &candidate.model.c);
    (candidate.model, candidate.initial_conditions, _) =
        refit_about(a, c, data, candidate.feedthrough, offset)?;
    Ok(())
}

fn mean_square(candidate: &Candidate, data: &DataSet) -> f64 {
    let count = (data.samples() * data.outputs()) as f64;
    sum_of_squares(&candidate.initial_conditions.errors(&candidate.model, data)) / count
}

/// The warning for a model that was taken off the branch cut at this cost of squared errors.
pub(crate) fn mirroring_warning(cost: f64) -> String {
    format!(
        "a mode that dies out within a sample alternated, which no mode of a continuous model does: it was replaced by one that decays, which adds {:.2} % to the squared errors",
        100.0 * cost.max(0.0)
    )
}
