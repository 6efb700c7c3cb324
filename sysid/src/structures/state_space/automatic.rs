//! The same choice for any number of inputs and outputs, without a vehicle around it.

use crate::Error;
use crate::data::scaled::{Detrend, tapered_mean};
use crate::data::{DataSet, Segment, Signals};
use crate::model::StateSpace;
use crate::selection::choose::choose_from;
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::options::{IdentifyOptions, Method};
use crate::selection::order::fit;

/// A model chosen by [`automatic`], in the units of its data.
#[derive(Debug, Clone, PartialEq)]
pub struct Automatic {
    /// From `u − input_offsets` to `y − output_offsets`.
    pub model: StateSpace,
    /// Offsets of the inputs in the estimation data; zeros where they were to stay.
    pub input_offsets: Vec<f64>,
    /// Offsets of the outputs in the estimation data that belong to those of the inputs; zeros where
    /// they were to stay.
    pub output_offsets: Vec<f64>,
    /// The method that it was refined from.
    pub method: Method,
    /// Block rows of the subspace method that it was refined from.
    pub horizon: usize,
    /// Simulation fit on the estimation data, percent, over all outputs together, each in the unit of
    /// its standard deviation.
    pub estimation_fit: f64,
    /// The same on the validation data, means of the estimation data removed and the initial state
    /// estimated.
    pub validation_fit: f64,
    /// Simulation fit of each output on the validation data, percent.
    pub validation_fits: Vec<f64>,
    /// The orders that were tried.
    pub orders: Vec<TriedOrder>,
}

/// One order that was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriedOrder {
    /// Order n.
    pub order: usize,
    /// Simulation fit on the estimation data, percent.
    pub estimation_fit: f64,
    /// Simulation fit on the validation data, percent.
    pub validation_fit: f64,
    /// BIC of the prediction with a noise model, of which the least is chosen.
    pub criterion: f64,
    /// Largest eigenvalue modulus of A before stability was enforced on the subspace estimate, where
    /// it was.
    pub stabilised_from: Option<f64>,
    /// Simulation fit on the estimation data before stability was enforced (−∞ where the simulation
    /// overflows) and after, both without refinement.
    pub stabilised_fits: Option<(f64, f64)>,
}

/// A model of `estimation`, its order, horizon, weighting and feedthrough chosen where the options
/// leave them open, validated on `validation`, which takes no part in the choice.
///
/// # Errors
/// [`Error`] where the data or the options allow no model.
///
/// Lines ([`Detrend::Linear`]) are for logs with clocks: here their constants are taken off.
pub fn automatic(
    estimation: &DataSet,
    validation: &DataSet,
    options: &IdentifyOptions,
) -> Result<Automatic, Error> {
    options.check()?;
    let shape = |d: &DataSet| (d.inputs(), d.outputs());
    if shape(estimation) != shape(validation) {
        return Err(Error::data(format!(
            "{} inputs and {} outputs of estimation data, {} and {} of validation data",
            estimation.inputs(),
            estimation.outputs(),
            validation.inputs(),
            validation.outputs()
        )));
    }
    if estimation.inputs() == 0 {
        return Err(Error::data("there is no input"));
    }
    let units = Units::from_data(estimation, options.detrend != Detrend::None)?;
    let (data, validated) = (units.scaled(estimation)?, units.scaled(validation)?);
    let choice = choose_from(&data, &validated, options, false)?;
    let chosen = &choice.candidates[choice.chosen];
    let validated = chosen.initial_conditions.about_output_offset(&validated)?;
    let errors =
        InitialConditions::new(&chosen.model, &validated, false)?.errors(&chosen.model, &validated);
    let mut output_offsets = units.output.means;
    let offsets = chosen.initial_conditions.offsets.iter().flatten();
    for ((mean, offset), scale) in output_offsets.iter_mut().zip(offsets).zip(&units.output.scales)
    {
        *mean += offset * scale;
    }
    let validation_fits = (0..validated.outputs())
        .map(|i| {
            let row = |m: &Signals| Signals::from(m.row(i).to_vec());
            let segments = validated.segments().iter();
            let one = segments.map(|s| Segment::new(Signals::zeros(0, s.len()), row(&s.y)));
            let one = one.collect();
            let errors = errors.iter().map(row).collect();
            Ok(fit(&DataSet::new(validated.sample_time_s(), one)?, &errors))
        })
        .collect::<Result<_, Error>>()?;
    Ok(Automatic {
        model: chosen.model.scaled(&units.input.scales, &units.output.scales),
        input_offsets: units.input.means,
        output_offsets,
        method: chosen.method,
        horizon: chosen.horizon,
        estimation_fit: chosen.estimation_fit,
        validation_fit: chosen.validation_fit,
        validation_fits,
        orders: choice
            .candidates
            .iter()
            .map(|c| TriedOrder {
                order: c.model.order(),
                estimation_fit: c.estimation_fit,
                validation_fit: c.validation_fit,
                criterion: c.criterion,
                stabilised_from: c.stabilised.map(|s| s.radius),
                stabilised_fits: c.stabilised.map(|s| (s.fit_before, s.fit_after)),
            })
            .collect(),
    })
}

/// Offsets and scales of all channels.
pub(crate) struct Units {
    pub(crate) input: Unit,
    pub(crate) output: Unit,
}

/// Offset and standard deviation of each channel of one kind.
pub(crate) struct Unit {
    pub(crate) means: Vec<f64>,
    pub(crate) scales: Vec<f64>,
}

impl Units {
    /// Those of the estimation data; offsets are 0 where they are to stay.
    pub(crate) fn from_data(data: &DataSet, remove_means: bool) -> Result<Self, Error> {
        let unit = |signal: fn(&Segment) -> &Signals, count: usize, what: &str| {
            let (mut means, mut scales) = (Vec::new(), Vec::new());
            for i in 0..count {
                let all: Vec<f64> =
                    data.segments().iter().flat_map(|s| signal(s).row(i).iter().copied()).collect();
                // In units of the largest value, of which no square overflows.
                let largest = all.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                let unit = if largest > 0.0 { largest } else { 1.0 };
                let n = all.len() as f64;
                let mean = tapered_mean(data.segments().iter().map(|s| signal(s).row(i))) / unit;
                let spread = all.iter().map(|x| (x / unit - mean).powi(2)).sum::<f64>() / n;
                if spread.sqrt() < 1e-13 {
                    let problem = format!("{what} {i} does not move in the estimation data");
                    return Err(Error::no_model(problem));
                }
                means.push(if remove_means { unit * mean } else { 0.0 });
                scales.push(unit * spread.sqrt());
            }
            Ok(Unit { means, scales })
        };
        Ok(Self {
            input: unit(|s| &s.u, data.inputs(), "input")?,
            output: unit(|s| &s.y, data.outputs(), "output")?,
        })
    }

    /// The data about the offsets, in units of the scales.
    pub(crate) fn scaled(&self, data: &DataSet) -> Result<DataSet, Error> {
        let apply = |m: &Signals, by: &Unit| {
            Signals::from_fn(m.nrows(), m.ncols(), |i, t| (m[(i, t)] - by.means[i]) / by.scales[i])
        };
        let of = |s: &Segment| Segment::new(apply(&s.u, &self.input), apply(&s.y, &self.output));
        DataSet::new(data.sample_time_s(), data.segments().iter().map(of).collect())
    }
}
