//! The same choice for any number of inputs and outputs, without a vehicle around it.

use crate::Error;
use crate::data::scaled::{Detrend, level};
use crate::data::{DataSet, Segment, Signals};
use crate::model::StateSpace;
use crate::selection::initial_conditions::Conditions;
use crate::selection::method::Approach;
use crate::selection::options::IdentifyOptions;
use crate::selection::order::fit;
use crate::selection::search::choose_from;

/// A model chosen by [`automatic`], in the units of its data.
#[derive(Debug, Clone, PartialEq)]
pub struct Automatic {
    /// From `u − input_levels` to `y − output_levels`.
    pub model: StateSpace,
    /// Levels of the inputs in the estimation data; zeros where they were to stay.
    pub input_levels: Vec<f64>,
    /// Levels of the outputs in the estimation data that go with those of the inputs; zeros where they
    /// were to stay.
    pub output_levels: Vec<f64>,
    /// The method that it was refined from.
    pub approach: Approach,
    /// Block rows of the subspace method that it was refined from.
    pub horizon: usize,
    /// Simulation fit on the estimation data, percent, over all outputs together, each in the unit of
    /// its standard deviation.
    pub estimation_fit: f64,
    /// The same on the held-out data, means of the estimation data removed and the initial state
    /// estimated.
    pub validation_fit: f64,
    /// Simulation fit of each output on the held-out data, percent.
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
    /// Simulation fit on the held-out data, percent.
    pub validation_fit: f64,
    /// Schwarz's criterion for the prediction with a noise model, of which the least is chosen.
    pub criterion: f64,
    /// Largest eigenvalue modulus of A before stability was enforced on the subspace estimate, where
    /// it was.
    pub stabilised_from: Option<f64>,
    /// Simulation fit on the estimation data before stability was enforced (−∞ where the simulation
    /// overflows) and after, both without refinement.
    pub stabilised_fits: Option<(f64, f64)>,
}

/// A model of `estimation`, its order, horizon, weighting and feedthrough chosen where the options
/// leave them open, judged on `held_out`, which takes no part in that.
///
/// # Errors
/// [`Error`] where the data or the options allow no model.
///
/// Lines ([`Detrend::Linear`]) are for logs with clocks: here their constants are taken off.
pub fn automatic(
    estimation: &DataSet,
    held_out: &DataSet,
    options: &IdentifyOptions,
) -> Result<Automatic, Error> {
    options.check()?;
    let shape = |d: &DataSet| (d.inputs(), d.outputs());
    if shape(estimation) != shape(held_out) {
        return Err(Error::Data {
            problem: format!(
                "{} inputs and {} outputs to estimate on, {} and {} held out",
                estimation.inputs(),
                estimation.outputs(),
                held_out.inputs(),
                held_out.outputs()
            ),
        });
    }
    if estimation.inputs() == 0 {
        return Err(Error::Data { problem: "there is no input".into() });
    }
    let units = Units::of(estimation, options.detrend != Detrend::None)?;
    let (data, judged) = (units.scaled(estimation)?, units.scaled(held_out)?);
    let choice = choose_from(&data, &judged, options, false)?;
    let chosen = &choice.candidates[choice.chosen];
    let judged = chosen.conditions.about_level(&judged)?;
    let errors = Conditions::new(&chosen.model, &judged, false)?.errors(&chosen.model, &judged);
    let mut output_levels = units.output.means;
    let levels = chosen.conditions.levels.iter().flatten();
    for ((mean, level), scale) in output_levels.iter_mut().zip(levels).zip(&units.output.scales) {
        *mean += level * scale;
    }
    let validation_fits = (0..judged.outputs())
        .map(|i| {
            let row = |m: &Signals| Signals::from(m.row(i).to_vec());
            let segments = judged.segments().iter();
            let one = segments.map(|s| Segment::new(Signals::zeros(0, s.len()), row(&s.y)));
            let one = one.collect();
            let errors = errors.iter().map(row).collect();
            Ok(fit(&DataSet::new(judged.sample_time_s(), one)?, &errors))
        })
        .collect::<Result<_, Error>>()?;
    Ok(Automatic {
        model: chosen.model.scaled(&units.input.scales, &units.output.scales),
        input_levels: units.input.means,
        output_levels,
        approach: chosen.approach,
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

/// What brings signals to zero mean and unit spread.
struct Units {
    input: Unit,
    output: Unit,
}

struct Unit {
    means: Vec<f64>,
    scales: Vec<f64>,
}

impl Units {
    fn of(data: &DataSet, remove_means: bool) -> Result<Self, Error> {
        let unit = |signal: fn(&Segment) -> &Signals, count: usize, what: &str| {
            let (mut means, mut scales) = (Vec::new(), Vec::new());
            for i in 0..count {
                let all: Vec<f64> =
                    data.segments().iter().flat_map(|s| signal(s).row(i).iter().copied()).collect();
                // In units of the largest value, of which no square overflows.
                let largest = all.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                let unit = if largest > 0.0 { largest } else { 1.0 };
                let n = all.len() as f64;
                let mut rest = all.as_slice();
                let stretches = data.segments().iter().map(|s| {
                    let (now, later) = rest.split_at(s.len());
                    rest = later;
                    now
                });
                let mean = level(stretches) / unit;
                let spread = all.iter().map(|x| (x / unit - mean).powi(2)).sum::<f64>() / n;
                if spread.sqrt() < 1e-13 {
                    return Err(Error::NoModel {
                        problem: format!("{what} {i} does not move in the estimation data"),
                    });
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

    fn scaled(&self, data: &DataSet) -> Result<DataSet, Error> {
        let apply = |m: &Signals, by: &Unit| {
            Signals::from_fn(m.nrows(), m.ncols(), |i, t| (m[(i, t)] - by.means[i]) / by.scales[i])
        };
        let segments = data
            .segments()
            .iter()
            .map(|s| Segment::new(apply(&s.u, &self.input), apply(&s.y, &self.output)));
        DataSet::new(data.sample_time_s(), segments.collect())
    }
}
