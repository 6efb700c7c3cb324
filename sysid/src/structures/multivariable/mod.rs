//! A linear plant of any system, from several named inputs to several named outputs (docs/methods/multivariable.md): the
//! structure `state-space` of a log that is read for named channels.
//!
//! Channels keep their units, and are scaled to unit spread inside. The end of the log validates.

mod choice;
mod delays;
mod evidence;
mod filter;
mod held_out;
mod log_simulation;
mod quality;
pub(crate) mod traces;

use crate::Error;
use crate::data::scaled::Detrend;
use crate::data::split::Split;
use crate::data::{DataSet, Segment, Signals};
use crate::model::Innovation;
use crate::model::conversion::to_continuous;
use crate::pem::{Neighbours, Uncertain, uncertain_simulation};
use crate::selection::candidate::Choice;
use crate::selection::filter::{replicas, rivals};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::options::IdentifyOptions;
use crate::selection::order::errors;
use crate::selection::search::mirroring_warning;
use crate::structures::model::IdentifiedModel;
use crate::structures::multivariable::evidence::Found;
use crate::structures::multivariable::filter::{Filter, Scaled};
use crate::structures::state_space::automatic::Units;
use crate::structures::state_space::plant::matrix;
use faer::Mat;
use std::collections::BTreeSet;
use std::ops::Range;
use steerwright_drivelog::{DriveLog, Response, Role, without_unit};
use steerwright_formats::{
    ChannelSummary, Continuous, Discrete, Document, InputKind, Matrix, Model, MultivariablePlant,
    MultivariableUncertainty, PlantInput, PlantOutput, Provenance, variable_name,
};

pub use log_simulation::{LogSimulation, simulate_log};
pub use traces::ChannelTraces;

use crate::structures::multivariable::choice::choose;

/// A plant with the signals of its log.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedPlant {
    /// What goes into `plant.json`.
    pub plant: MultivariablePlant,
    /// Measured and simulated signals.
    pub traces: ChannelTraces,
}

impl From<IdentifiedPlant> for IdentifiedModel {
    fn from(found: IdentifiedPlant) -> Self {
        let model = Model::Multivariable(Box::new(found.plant));
        Self { model, traces: None, channels: Some(found.traces) }
    }
}

/// A named channel of the log.
struct Channel<'a> {
    name: String,
    column: String,
    unit: String,
    samples: &'a [f64],
}

/// Identifies the plant from the inputs to the outputs of a log that was read for [`Response::Channels`]; the validation
/// data estimate and choose nothing.
///
/// # Errors
/// [`Error`] where the log or the options allow no model. A poor model is no error: the evidence and the quality report it.
pub fn identify_channels(
    log: &DriveLog,
    options: &IdentifyOptions,
) -> Result<IdentifiedPlant, Error> {
    options.check_for(log.channels_of("output").count().max(1))?;
    if log.response != Response::Channels {
        return Err(Error::ChannelsNeeded { response: log.response });
    }
    if options.input_kind != InputKind::Steering {
        let (option, value) = ("model input", options.input_kind.name());
        return Err(Error::option(option, value, "no other input than the named channels"));
    }
    if options.detrend == Detrend::Linear {
        return Err(Error::option("detrend", "linear", "mean or none for named channels"));
    }
    let [inputs, outputs] = channels(log);
    let options = &general(options, outputs.len());
    let n = log.len();
    let split = Split::end(log, n, options.validation.fraction);
    let split = split.thinned(options.max_samples, log.sample_time_s);
    let part = |ranges: &[Range<usize>]| part(log, &inputs, &outputs, ranges);
    let (estimation, validation) = (part(&split.estimation)?, part(&split.validation)?);
    let units = Units::from_data(&estimation, options.detrend != Detrend::None)
        .map_err(|error| named(error, &inputs, &outputs))?;
    let whole = part(&log.segments.iter().map(|s| s.range.clone()).collect::<Vec<_>>())?;
    let scaled = Scaled {
        estimation: units.scaled(&estimation)?,
        validation: units.scaled(&validation)?,
        whole: units.scaled(&whole)?,
    };
    let mut warnings = log.warnings.clone();
    let used = log.len() - validation.samples();
    if estimation.samples() < used {
        warnings.push(format!(
            "the log is long: {} of {used} estimation samples are used, in {} blocks spread over them",
            estimation.samples(),
            estimation.segments().len()
        ));
    }
    let pair_delays = delays::first_responses(&scaled.estimation);
    let (scaled, delay, choice) = with_delays(scaled, &pair_delays, options)?;
    warnings.extend(choice.warning.clone());
    if choice.factor.conditioning.is_reduced() {
        warnings.push(choice.factor.conditioning.to_string());
    }
    let chosen = &choice.candidates[choice.chosen];
    warnings.extend(chosen.mirroring_cost.map(mirroring_warning));
    if let Some(s) = chosen.stabilised {
        warnings.push(format!(
            "the subspace estimate was unstable (spectral radius {:.4}) and has been stabilised",
            s.radius
        ));
    }
    let about = |data: &DataSet| chosen.initial_conditions.about_output_offset(data);
    let scaled = Scaled {
        estimation: about(&scaled.estimation)?,
        validation: about(&scaled.validation)?,
        whole: about(&scaled.whole)?,
    };
    let filter = Filter::new(&scaled, &choice, options.refine, &mut warnings)?;
    let (u, y) = (&units.input.scales, &units.output.scales);
    let model = chosen.model.scaled(u, y);
    let gain = Mat::from_fn(model.order(), model.outputs(), |i, j| filter.gain[(i, j)] / y[j]);
    let continuous = to_continuous(model.a.as_ref(), model.b.as_ref(), log.sample_time_s);
    if let Err(reason) = &continuous {
        warnings.push(format!("the model stays discrete: {reason}"));
    }
    let continuous = continuous.ok();
    let uncertain = uncertainty(&scaled, &choice, &filter.gain, options.refine);
    if let Err(error) = &uncertain {
        warnings.push(format!("the model's uncertainty cannot be computed: {error}"));
    }
    let uncertain = uncertain.ok().map(|found| found.scaled(u, y));
    let poles = uncertain.as_ref().and_then(|found| found.poles().ok());
    let uncertainty = uncertain.as_ref().zip(poles).map(|(found, poles)| {
        let (rows, columns) = (found.factor.ncols(), found.factor.nrows());
        MultivariableUncertainty {
            focus: found.focus,
            poles,
            directions: Matrix::from_fn(rows, columns, |i, j| found.factor[(j, i)]),
        }
    });
    let uncertain = uncertain.filter(|_| uncertainty.is_some());
    let traces = traces(log, [&inputs, &outputs], &scaled, &split, chosen, &units)?;
    let offsets: Vec<f64> = (0..outputs.len())
        .map(|i| {
            let own = chosen.initial_conditions.offsets.as_ref().map_or(0.0, |o| o[i]);
            units.output.means[i] + own * y[i]
        })
        .collect();
    let count = scaled.estimation.samples() as f64;
    let covariance = |i: usize, j: usize| {
        let products = filter
            .residuals
            .iter()
            .map(|e| e.row(i).iter().zip(e.row(j)).map(|(a, b)| a * b).sum::<f64>());
        products.sum::<f64>() / count * y[i] * y[j]
    };
    let found = Found {
        names: [&inputs, &outputs].map(|all| all.iter().map(|c| c.name.clone()).collect()),
        scaled: &scaled,
        choice: &choice,
        filter: &filter,
        units: &units,
        uncertain: uncertain.as_ref(),
        model: &model,
        pair_delays: &pair_delays,
        delay: &delay,
        warnings,
        channels: &log.channels,
        round_trip: continuous.as_ref().map(|c| c.round_trip),
    };
    let evidence = found.evidence()?;
    let quality = quality::quality(&evidence, continuous.is_some(), [u, y]);
    let mut used = log.options.clone();
    used.extend(options.to_map());
    used.insert("realization".into(), chosen.realization.name().into());
    let plant = MultivariablePlant {
        schema: MultivariablePlant::SCHEMA.into(),
        name: log.name.clone(),
        inputs: inputs
            .iter()
            .enumerate()
            .map(|(j, c)| PlantInput {
                name: c.name.clone(),
                column: c.column.clone(),
                unit: c.unit.clone(),
                offset: units.input.means[j],
                standard_deviation: u[j],
                delay_s: delay[j] as f64 * log.sample_time_s,
            })
            .collect(),
        outputs: outputs
            .iter()
            .zip(&offsets)
            .zip(y)
            .map(|((c, offset), scale)| PlantOutput {
                name: c.name.clone(),
                column: c.column.clone(),
                unit: c.unit.clone(),
                offset: *offset,
                standard_deviation: *scale,
            })
            .collect(),
        discrete: Discrete {
            sample_time_s: log.sample_time_s,
            a: matrix(&model.a),
            b: matrix(&model.b),
            c: matrix(&model.c),
            d: matrix(&model.d),
            k: matrix(&gain),
            x0: chosen.initial_conditions.x0[0].clone(),
        },
        continuous: continuous.map(|c| Continuous {
            f: matrix(&c.f),
            g: matrix(&c.g),
            h: matrix(&model.c),
        }),
        innovation_covariance: Matrix::from_fn(outputs.len(), outputs.len(), covariance),
        uncertainty,
        evidence,
        quality,
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            sources: log.sources.clone(),
            options: used,
        },
    };
    plant.checked("plant.json").map_err(|e| Error::no_model(e.to_string()))?;
    Ok(IdentifiedPlant { plant, traces })
}

/// The options for any system of so many outputs: a mode may be as slow as the record is long, as one that oscillates with little
/// damping is seen well in a few time constants; and each output may have states of its own.
fn general(options: &IdentifyOptions, outputs: usize) -> IdentifyOptions {
    const STATES: usize = 3;
    let default = IdentifyOptions::default().max_order;
    let most = if options.max_order == default {
        default.max(STATES * outputs)
    } else {
        options.max_order
    };
    IdentifyOptions { max_order: most, time_constants: 1.0, ..options.clone() }
}

/// The choice with the delay of each input, in samples: the one that is stated, or the one that the impulse responses show
/// where the model with it is no larger and likelier.
fn with_delays(
    scaled: Scaled,
    pairs: &[Vec<Option<usize>>],
    options: &IdentifyOptions,
) -> Result<(Scaled, Vec<usize>, Choice), Error> {
    let inputs = scaled.estimation.inputs();
    if let Some(delay_s) = options.delay_s {
        let samples = delay_s / scaled.estimation.sample_time_s();
        if (samples - samples.round()).abs() > 1e-6 {
            let expected = format!(
                "a whole number of samples of {} s for named channels",
                scaled.estimation.sample_time_s()
            );
            return Err(Error::option("delay", format!("{delay_s} s"), expected));
        }
        let delay = vec![samples.round() as usize; inputs];
        let scaled = scaled.delayed(&delay)?;
        let choice = choose(&scaled.estimation, &scaled.validation, options)?.choice;
        return Ok((scaled, delay, choice));
    }
    let without = choose(&scaled.estimation, &scaled.validation, options)?;
    let delay = delays::of_inputs(pairs, inputs);
    if delay.iter().any(|samples| *samples > 0) {
        let late = scaled.delayed(&delay)?;
        if let Ok(with) = choose(&late.estimation, &late.validation, options)
            && with.is_preferred_to(&without)
        {
            return Ok((late, delay, with.choice));
        }
    }
    Ok((scaled, vec![0; inputs], without.choice))
}

/// Frequencies at which neighbouring models are compared with the chosen one, rad per sample.
fn omegas() -> Vec<f64> {
    const COMPARED: usize = 30;
    const BETWEEN: [f64; 2] = [0.01, 2.5];
    let share = |k: usize| k as f64 / (COMPARED - 1) as f64;
    (0..COMPARED).map(|k| BETWEEN[0] * (BETWEEN[1] / BETWEEN[0]).powf(share(k))).collect()
}

/// The uncertainty of the chosen model and its gain, in scaled units, with that of its neighbours.
fn uncertainty(
    scaled: &Scaled,
    choice: &Choice,
    gain: &Mat<f64>,
    refined: bool,
) -> Result<Uncertain, Error> {
    let chosen = &choice.candidates[choice.chosen];
    let innovation = Innovation { model: chosen.model.clone(), gain: gain.clone() };
    let fitted = choice.fitted.as_ref().unwrap_or(&scaled.estimation);
    let x0 =
        |data: &DataSet| Ok::<_, Error>(InitialConditions::new(&chosen.model, data, false)?.x0);
    let replicas = if refined { replicas(chosen, fitted) } else { Vec::new() };
    let found = uncertain_simulation(
        &innovation,
        (&x0(fitted)?, fitted),
        (&x0(&scaled.estimation)?, &scaled.estimation),
        chosen.feedthrough,
        chosen.initial_conditions.offsets.is_some(),
        Neighbours { replicas: &replicas, rivals: &rivals(choice), omegas: &omegas() },
    )?;
    let is_finite = crate::linalg::dense::is_finite(found.factor.as_ref());
    if is_finite { Ok(found) } else { Err(Error::no_model("a variance is not finite")) }
}

/// The named channels of a log, inputs and outputs.
fn channels(log: &DriveLog) -> [Vec<Channel<'_>>; 2] {
    let mut taken = BTreeSet::new();
    let inputs = channels_of(log, ("input", &log.input), Role::Input, &mut taken);
    let outputs = channels_of(log, ("output", &log.output), Role::Output, &mut taken);
    [inputs, outputs]
}

/// The channels of a role, with the first of them, under names that no other one has.
fn channels_of<'l>(
    log: &'l DriveLog,
    (role, first): (&'l str, &'l [f64]),
    further: fn(u8) -> Role,
    taken: &mut BTreeSet<String>,
) -> Vec<Channel<'l>> {
    let further = (1..=u8::MAX).map_while(|k| log.others.get(&further(k)).map(Vec::as_slice));
    let samples = std::iter::once(first).chain(further);
    let channel = |(samples, summary): (&'l [f64], &ChannelSummary)| {
        // Of several drives the column has the name of its file before it.
        let column = match log.segments.len() > 1 {
            true => summary.column.rsplit(':').next().unwrap_or_default(),
            false => &summary.column,
        };
        let base = variable_name(without_unit(column));
        let (mut name, mut count) = (base.clone(), 1);
        while !taken.insert(name.clone()) {
            count += 1;
            name = format!("{base}_{count}");
        }
        Channel { name, column: column.to_owned(), unit: summary.unit.clone(), samples }
    };
    samples.zip(log.channels_of(role)).map(channel).collect()
}

fn part(
    log: &DriveLog,
    inputs: &[Channel<'_>],
    outputs: &[Channel<'_>],
    ranges: &[Range<usize>],
) -> Result<DataSet, Error> {
    let signals = |channels: &[Channel<'_>], range: &Range<usize>| {
        Signals::from_fn(channels.len(), range.len(), |i, t| channels[i].samples[range.start + t])
    };
    let segments = ranges.iter().map(|r| Segment::new(signals(inputs, r), signals(outputs, r)));
    DataSet::new(log.sample_time_s, segments.collect())
}

/// The error about a channel by its place with its name.
fn named(error: Error, inputs: &[Channel<'_>], outputs: &[Channel<'_>]) -> Error {
    let Error::NoModel { problem } = &error else { return error };
    for (word, channels) in [("input", inputs), ("output", outputs)] {
        for (k, channel) in channels.iter().enumerate() {
            if let Some(rest) = problem.strip_prefix(&format!("{word} {k} ")) {
                return Error::no_model(format!("{word} `{}` {rest}", channel.column));
            }
        }
    }
    error
}

/// Measured and simulated signals of the whole log.
fn traces(
    log: &DriveLog,
    [inputs, outputs]: [&[Channel<'_>]; 2],
    scaled: &Scaled,
    split: &Split,
    chosen: &crate::selection::candidate::Candidate,
    units: &Units,
) -> Result<ChannelTraces, Error> {
    let model = &chosen.model;
    let mut simulated: Vec<Vec<f64>> = outputs.iter().map(|c| c.samples.to_vec()).collect();
    let mut is_validation = vec![false; log.len()];
    split.validation.iter().for_each(|r| is_validation[r.clone()].fill(true));
    // Of a long log the samples that estimate nothing too, each segment from its start to the validation data.
    let mut put = |data: &DataSet, ranges: &[Range<usize>]| -> Result<(), Error> {
        let x0 = InitialConditions::new(model, data, false)?.x0;
        for ((e, s), range) in errors(model, &x0, data).iter().zip(data.segments()).zip(ranges) {
            for (i, simulated) in simulated.iter_mut().enumerate() {
                for (t, at) in range.clone().enumerate().take(s.len()) {
                    simulated[at] = outputs[i].samples[at] - units.output.scales[i] * e[(i, t)];
                }
            }
        }
        Ok(())
    };
    let whole: Vec<Range<usize>> = log.segments.iter().map(|s| s.range.clone()).collect();
    put(&scaled.whole, &whole)?;
    put(&scaled.estimation, &split.estimation)?;
    put(&scaled.validation, &split.validation)?;
    let named = |c: &Channel<'_>| (c.name.clone(), c.samples.to_vec());
    Ok(ChannelTraces {
        time_s: log.time_s(),
        inputs: inputs.iter().map(named).collect(),
        outputs: outputs
            .iter()
            .zip(simulated)
            .map(|(c, simulated)| (c.name.clone(), c.samples.to_vec(), simulated))
            .collect(),
        is_validation,
    })
}
