//! The choice of a model: by [cross-validation](crate::structures::multivariable::held_out) in open loop; by the rules of
//! closed-loop data where the data show feedback, since a simulation of data with feedback is no test of the plant.

use crate::Error;
use crate::data::DataSet;
use crate::selection::candidate::{Candidate, Choice};
use crate::selection::choose::choose_from;
use crate::selection::options::{IdentifyOptions, Method};
use crate::structures::multivariable::held_out::{self, Scored};

/// Errors on data that were left out that are larger by this share are those of a worse model.
const CLEARLY: f64 = 1.02;

/// A choice, with its errors on data that were left out.
pub(crate) struct Chosen {
    pub(crate) choice: Choice,
    /// `None` where no data were left out.
    score: Option<f64>,
}

impl Chosen {
    pub(super) fn candidate(&self) -> &Candidate {
        &self.choice.candidates[self.choice.chosen]
    }

    /// Whether the model is smaller and simulates data that were left out no clearly worse, or is as large and no worse.
    pub(super) fn is_preferred_to(&self, other: &Self) -> bool {
        let order = |chosen: &Self| chosen.candidate().model.order();
        match (self.score, other.score) {
            (Some(own), Some(others)) if order(self) < order(other) => own <= CLEARLY * others,
            (Some(own), Some(others)) => order(self) == order(other) && own <= others,
            // In a loop the smaller model is taken, as a delay replaces states.
            _ => order(self) < order(other),
        }
    }
}

/// Chooses what the options leave open.
pub(crate) fn choose(
    data: &DataSet,
    validation: &DataSet,
    options: &IdentifyOptions,
) -> Result<Chosen, Error> {
    let choice = choose_from(data, validation, options, false)?;
    let chosen = &choice.candidates[choice.chosen];
    if matches!(chosen.method, Method::ClosedLoop(_)) {
        return Ok(Chosen { choice, score: None });
    }
    let scores = held_out::scores(data, options)?;
    let Some(best) = held_out::least(&scores) else {
        return Ok(Chosen { choice, score: None });
    };
    let is_same = |s: &Scored| {
        s.order == chosen.model.order()
            && s.feedthrough == chosen.feedthrough
            && s.refined == options.refine
    };
    // Blocks of short records are too short for the order that all of them determine.
    let Some(own) = scores.iter().find(|s| is_same(s)) else {
        return Ok(Chosen { choice, score: Some(best.score) });
    };
    if own.score <= CLEARLY * best.score {
        return Ok(Chosen { choice, score: Some(own.score) });
    }
    let stated = IdentifyOptions {
        order: Some(best.order),
        feedthrough: Some(best.feedthrough),
        ..options.clone()
    };
    let mut found = choose_from(data, validation, &stated, false)?;
    found.feedback = choice.feedback;
    let order = found.candidates[found.chosen].model.order();
    // The criterion of the search, which models the noise of all orders alike.
    if let Some(same) = choice.candidates.iter().find(|c| c.model.order() == order) {
        found.candidates[found.chosen].criterion = same.criterion;
    }
    // The orders that were tried stay in the table and in the uncertainty.
    let tried = choice.candidates.into_iter().filter(|c| c.model.order() != order);
    found.candidates.extend(tried);
    Ok(Chosen { choice: found, score: Some(best.score) })
}
