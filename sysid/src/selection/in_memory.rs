//! A data set in memory, as the [search](crate::selection::search) uses it: which of several models
//! it makes the likeliest, whatever the spectrum of the noise (docs/methods/selection.md).
//!
//! A model is refined by its simulation error, under feedback by that for the [two-stage input
//! estimate](crate::selection::two_stage). It is evaluated by the errors of one-step prediction
//! that it makes along with an [`AutoregressiveNoise`] of one order for all models: that of the
//! noise as the largest model leaves it. Plant and noise model are estimated in turn, each for the
//! other as it is, which lowers one sum of squares.

use crate::Error;
use crate::data::DataSet;
use crate::model::StateSpace;
use crate::pem::Stop;
use crate::selection::candidate::{Candidate, ROUGH, refine};
use crate::selection::initial_conditions::{InitialConditions, needs_output_offset};
use crate::selection::initial_estimates::{InitialEstimates, at_least_one, refit_about};
use crate::selection::noise_model::AutoregressiveNoise;
use crate::selection::options::IdentifyOptions;
use crate::selection::order::{log_square, sum_of_squares};
use crate::selection::predicted::Predicted;
use crate::selection::search::{Counts, Estimator, largest_estimate};
use crate::selection::vehicle;
use std::borrow::Cow;

/// Turns of plant and noise model, unless the errors fall by less than [`LEAST_GAIN`].
const TURNS: usize = 4;
const LEAST_GAIN: f64 = 1e-4;

pub(crate) struct InMemory<'a> {
    pub(crate) data: &'a DataSet,
    /// Those whose simulation errors are made small; under feedback the two-stage ones.
    pub(crate) fitted: &'a DataSet,
    pub(crate) options: &'a IdentifyOptions,
    pub(crate) estimates: Estimates<'a>,
    /// The initial estimate of the largest model, by which the noise order is chosen.
    largest: Option<Candidate>,
    noise_order: usize,
    pub(crate) offset: bool,
    vehicle: bool,
}

pub(crate) enum Estimates<'a> {
    OpenLoop(&'a InitialEstimates<'a>),
    /// The predictor-based ones, and the open-loop ones of the two-stage input.
    ClosedLoop(&'a Predicted, Option<InitialEstimates<'a>>),
}

impl<'a> InMemory<'a> {
    /// With the noise order of a largest model; errors of a stated open-loop order count as white.
    pub(crate) fn new(
        (data, fitted): (&'a DataSet, &'a DataSet),
        options: &'a IdentifyOptions,
        estimates: Estimates<'a>,
        vehicle: bool,
    ) -> Result<Self, Error> {
        let offset = options.has_output_offset();
        let largest = match &estimates {
            Estimates::OpenLoop(_) if options.order.is_some() => None,
            Estimates::OpenLoop(all) => {
                Some(largest_estimate(options, all.largest_order(), |n| all.best(n, true))?)
            }
            Estimates::ClosedLoop(all, _) => {
                let feedthrough = options.feedthrough == Some(true);
                let best = |order| all.best(data, order, feedthrough);
                Some(largest_estimate(options, all.largest_order(), best)?)
            }
        };
        let noise_order = match &largest {
            Some(Candidate { model, .. }) => AutoregressiveNoise::order(
                &InitialConditions::new(model, data, offset)?.errors(model, data),
                data,
            ),
            None => 0,
        };
        Ok(Self { data, fitted, options, estimates, largest, noise_order, offset, vehicle })
    }

    pub(crate) fn fitting(self, fitted: &'a DataSet) -> Self {
        Self { fitted, ..self }
    }

    fn looped(&self) -> bool {
        matches!(self.estimates, Estimates::ClosedLoop(..))
    }

    /// Leaves the offsets out where the chosen model does not need them.
    pub(crate) fn settle_output_offset(
        &mut self,
        candidates: &mut [Candidate],
        chosen: usize,
    ) -> Result<(), Error> {
        if self.offset && !needs_output_offset(&candidates[chosen].model, self.data)? {
            self.offset = false;
            candidates.iter_mut().for_each(|c| c.initial_conditions.offsets = None);
        }
        Ok(())
    }

    /// Makes the prediction errors small; returns the data that show them as simulation errors.
    pub(crate) fn refine_predictions(
        &self,
        of: &mut Candidate,
        stop: Stop,
    ) -> Result<DataSet, Error> {
        of.log_square = f64::INFINITY;
        let mut turn = 0;
        loop {
            let data = self.whitened(of)?;
            refine(&data, of, stop)?;
            let now = log_square(&of.initial_conditions.errors(&of.model, &data));
            let gain = of.log_square - now;
            of.log_square = now;
            turn += 1;
            if self.noise_order == 0
                || turn == TURNS
                || (turn > 1 && (gain.is_nan() || gain <= LEAST_GAIN))
            {
                return Ok(data.into_owned());
            }
        }
    }

    /// Σ_i ln V_i of the prediction errors of a candidate as it is.
    pub(crate) fn log_square(&self, of: &Candidate) -> Result<f64, Error> {
        let data = self.whitened(of)?;
        Ok(log_square(&of.initial_conditions.errors_on(&of.model, &data)?))
    }

    /// The data whitened by the noise model of a candidate's errors.
    fn whitened(&self, candidate: &Candidate) -> Result<Cow<'a, DataSet>, Error> {
        if self.noise_order == 0 {
            return Ok(Cow::Borrowed(self.data));
        }
        let errors = candidate.initial_conditions.errors_on(&candidate.model, self.data)?;
        let noise = AutoregressiveNoise::fitted(&errors, self.noise_order);
        Ok(Cow::Owned(noise.whitened(self.data)?))
    }

    /// An initial estimate, and one with the poles of a vehicle where the order is its own.
    fn with_physical(&self, estimate: Candidate) -> impl Iterator<Item = Candidate> {
        let own = self.vehicle && self.options.refine && estimate.model.order() == vehicle::ORDER;
        let physical = own.then(|| vehicle::initial_estimate(self.fitted, &estimate)).flatten();
        std::iter::once(estimate).chain(physical)
    }
}

impl Estimator for InMemory<'_> {
    fn options(&self) -> &IdentifyOptions {
        self.options
    }

    fn counts(&self) -> Counts {
        let segments = self.data.segments().len();
        Counts {
            inputs: self.data.inputs(),
            outputs: self.data.outputs(),
            samples: (self.data.samples() - self.noise_order * segments) as f64,
            segments,
            vehicle: self.vehicle,
        }
    }

    fn largest_order(&self) -> usize {
        match &self.estimates {
            Estimates::OpenLoop(all) => all.largest_order(),
            Estimates::ClosedLoop(all, _) => all.largest_order(),
        }
    }

    fn initial_estimates(&self, order: usize, feedthrough: bool) -> Result<Vec<Candidate>, Error> {
        let kept = self
            .largest
            .as_ref()
            .filter(|c| c.model.order() == order && c.feedthrough == feedthrough)
            .cloned();
        let mut all = match &self.estimates {
            Estimates::OpenLoop(all) => match kept {
                Some(kept) => vec![kept],
                None => vec![all.best(order, feedthrough)?],
            },
            Estimates::ClosedLoop(predicted, others) => {
                let first = match kept {
                    Some(kept) => Ok(kept),
                    None => predicted.best(self.data, order, feedthrough),
                };
                let other = others.as_ref().map(|o| o.best(order, feedthrough));
                at_least_one(std::iter::once(first).chain(other))?
            }
        };
        let last = all.pop();
        all.extend(last.into_iter().flat_map(|last| self.with_physical(last)));
        Ok(all)
    }

    fn refine(&self, of: &mut Candidate, stop: Stop) -> Result<(), Error> {
        refine(self.fitted, of, stop)
    }

    fn mean_square(&self, of: &Candidate) -> Result<f64, Error> {
        let count = (self.fitted.samples() * self.fitted.outputs()) as f64;
        Ok(sum_of_squares(&of.initial_conditions.errors(&of.model, self.fitted)) / count)
    }

    fn refit(&self, of: &mut Candidate) -> Result<(), Error> {
        let (a, c) = (&of.model.a, &of.model.c);
        (of.model, of.initial_conditions, _) =
            refit_about(a, c, self.fitted, of.feedthrough, self.offset)?;
        Ok(())
    }

    fn predict(&self, of: &Candidate) -> Result<(f64, Option<StateSpace>), Error> {
        // Without a noise model these errors are those that were made small already.
        if !self.options.refine || (self.noise_order == 0 && !self.looped()) {
            return Ok((self.log_square(of)?, None));
        }
        let mut trial = of.clone();
        self.refine_predictions(&mut trial, ROUGH)?;
        Ok((trial.log_square, Some(trial.model)))
    }

    fn other_models(&self, first: StateSpace, _: Option<&Candidate>) -> Vec<StateSpace> {
        let sought = self.options.refine && self.looped();
        Vec::from_iter(if sought { Some(first) } else { None })
    }
}
