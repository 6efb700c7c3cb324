//! The choice of a model: by [cross-validation](crate::structures::multivariable::held_out) in open loop; by the rules of
//! closed-loop data where the data show feedback, since a simulation of data with feedback is no test of the plant.

use crate::Error;
use crate::data::DataSet;
use crate::selection::candidate::Choice;
use crate::selection::choose::choose_from;
use crate::selection::options::{IdentifyOptions, Method};
use crate::selection::order::{bic, log_square, parameters};
use crate::structures::multivariable::held_out::{self, Scored};

/// A choice, with the BIC of its simulation errors on the estimation data.
pub(crate) struct Chosen {
    pub(crate) choice: Choice,
    criterion: f64,
}

impl Chosen {
    fn new(choice: Choice, data: &DataSet) -> Result<Self, Error> {
        let chosen = &choice.candidates[choice.chosen];
        let log_square = log_square(&chosen.initial_conditions.errors_on(&chosen.model, data)?);
        let (inputs, outputs) = (data.inputs(), data.outputs());
        let count = parameters(chosen.model.order(), inputs, outputs, chosen.feedthrough);
        let criterion = bic(log_square, outputs, count, data.samples() as f64);
        Ok(Self { choice, criterion })
    }

    /// Whether the model, with delays in place of states, is no larger and the likelier one.
    pub(super) fn is_preferred_to(&self, other: &Self) -> bool {
        let order = |of: &Self| of.choice.candidates[of.choice.chosen].model.order();
        order(self) <= order(other) && self.criterion < other.criterion
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
        return Chosen::new(choice, data);
    }
    let scores = held_out::scores(data, options)?;
    let Some(best) = held_out::least(&scores) else {
        return Chosen::new(choice, data);
    };
    let is_same = |s: &Scored| {
        s.order == chosen.model.order()
            && s.feedthrough == chosen.feedthrough
            && s.refined == options.refine
    };
    // Blocks of short records are too short for the order that all of them determine.
    let Some(own) = scores.iter().find(|s| is_same(s)) else {
        return Chosen::new(choice, data);
    };
    if !best.is_clearly_better_than(own) {
        return Chosen::new(choice, data);
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
    Chosen::new(found, data)
}
