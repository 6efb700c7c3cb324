//! Which of several models the data make the likeliest, whatever the spectrum of the noise.
//!
//! A model is evaluated by the errors of one-step prediction that it makes along with a noise model of
//! its own, an autoregression of its simulation errors ([`AutoregressiveNoise`]) of one order for all
//! models: that of the noise as the largest model leaves it. These errors are white for the right
//! model, so all N samples count, and BIC ([`bic`]) holds. A superfluous state would have to
//! predict what the noise model does not, and under feedback such a direct prediction error is not
//! biased (Ljung, *System Identification*, 2nd ed. 1999, section 13.4).
//!
//! Plant and noise model are estimated in turn, each for the other as it is, which lowers one sum of
//! squares.

use crate::Error;
use crate::data::DataSet;
use crate::model::StateSpace;
use crate::pem::Stop;
use crate::selection::candidate::{Candidate, ROUGH, refine};
use crate::selection::initial_conditions::{InitialConditions, needs_output_offset};
use crate::selection::noise_model::AutoregressiveNoise;
use crate::selection::options::IdentifyOptions;
use crate::selection::order::{AS_LIKELY, bic, likeliest, log_square, of_a_vehicle, parameters};
use std::borrow::Cow;

/// Turns of plant and noise model, unless the errors fall by less than [`LEAST_GAIN`].
const TURNS: usize = 4;
const LEAST_GAIN: f64 = 1e-4;
/// What models are compared on.
pub(crate) struct Comparison<'a> {
    /// The estimation data.
    pub(crate) data: &'a DataSet,
    /// Order of the noise's autoregression.
    noise_order: usize,
    samples: f64,
    /// Whether the outputs have an offset to be found.
    pub(crate) offset: bool,
    /// Whether the data come from a loop.
    looped: bool,
    /// Whether the system is a vehicle.
    vehicle: bool,
}

impl<'a> Comparison<'a> {
    /// With the noise model of the errors of `largest`, a model of the largest order. Where there is
    /// none, since a stated order is not compared with others, they are taken for white.
    pub(crate) fn new(
        data: &'a DataSet,
        options: &IdentifyOptions,
        looped: bool,
        largest: Option<&StateSpace>,
    ) -> Result<Self, Error> {
        let offset = options.has_output_offset();
        let noise_order = match largest {
            Some(model) => AutoregressiveNoise::order(
                &InitialConditions::new(model, data, offset)?.errors(model, data),
                data,
            ),
            None => 0,
        };
        let samples = (data.samples() - noise_order * data.segments().len()) as f64;
        Ok(Self { data, noise_order, samples, offset, looped, vehicle: false })
    }

    /// For a vehicle or for any system.
    pub(crate) fn of(self, vehicle: bool) -> Self {
        Self { vehicle, ..self }
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

    /// Finds the prediction errors of a candidate, where `refined` those of the model that makes them
    /// least, sought from its own and, in a loop, from `another`.
    pub(crate) fn weigh(
        &self,
        candidate: &mut Candidate,
        another: Option<StateSpace>,
        refined: bool,
    ) -> Result<(), Error> {
        // Without a noise model these errors are those that were made small already.
        if !refined || (self.noise_order == 0 && !self.looped) {
            let data = self.whitened(candidate)?;
            let errors = candidate.initial_conditions.errors_on(&candidate.model, &data)?;
            candidate.log_square = log_square(&errors);
            return Ok(());
        }
        let another = another.filter(|_| self.looped);
        candidate.log_square = f64::INFINITY;
        for model in std::iter::once(candidate.model.clone()).chain(another) {
            let mut trial = Candidate { model, ..candidate.clone() };
            self.refine(&mut trial, ROUGH)?;
            if trial.log_square < candidate.log_square {
                candidate.log_square = trial.log_square;
                candidate.direct = Some(trial.model);
            }
        }
        Ok(())
    }

    /// Makes the prediction errors of a model small; returns the data that show them as simulation
    /// errors.
    pub(crate) fn refine(&self, of: &mut Candidate, stop: Stop) -> Result<DataSet, Error> {
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

    /// The data whitened by the noise model of a candidate's errors.
    fn whitened(&self, candidate: &Candidate) -> Result<Cow<'a, DataSet>, Error> {
        if self.noise_order == 0 {
            return Ok(Cow::Borrowed(self.data));
        }
        let errors = candidate.initial_conditions.errors_on(&candidate.model, self.data)?;
        let noise_order = AutoregressiveNoise::fitted(&errors, self.noise_order);
        Ok(Cow::Owned(noise_order.whitened(self.data)?))
    }

    /// BIC for the model, and AIC for the initial states of the segments after the first: a segment
    /// determines its own no better however many there are, but each lowers the errors by chance.
    pub(crate) fn criterion(&self, of: &Candidate) -> f64 {
        let (m, p) = (self.data.inputs(), self.data.outputs());
        let count = parameters(of.model.order(), m, p, of.feedthrough);
        let initial_states = of.model.order() * (self.data.segments().len() - 1);
        bic(of.log_square, p, count, self.samples) + 2.0 * initial_states as f64
    }

    /// Sets the criterion of all and returns the least.
    pub(crate) fn least(&self, candidates: &mut [Candidate]) -> usize {
        for c in candidates.iter_mut() {
            c.criterion = self.criterion(c);
        }
        (0..candidates.len())
            .min_by(|a, b| candidates[*a].criterion.total_cmp(&candidates[*b].criterion))
            .unwrap_or(0)
    }

    /// Whether the evidence for one against the other is strong.
    pub(crate) fn surely_less(&self, one: &Candidate, other: &Candidate) -> bool {
        one.criterion + AS_LIKELY < other.criterion
    }

    /// The order of least criterion, or of one about as likely whose A has a real logarithm; of a vehicle
    /// that which suits one.
    pub(crate) fn select(&self, candidates: &mut [Candidate]) -> usize {
        self.least(candidates);
        let each: Vec<_> = candidates.iter().map(|c| (c.criterion, c.has_logarithm)).collect();
        let chosen = likeliest(&each);
        if !self.vehicle {
            return chosen;
        }
        let each = candidates.iter().map(|c| (c.model.order(), c.criterion, c.has_logarithm));
        of_a_vehicle(chosen, &each.collect::<Vec<_>>(), self.samples)
    }
}
