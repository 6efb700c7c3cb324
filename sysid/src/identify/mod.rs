//! From a recording to `plant.json`: prepare → select → refine → validate → model.

pub(crate) mod accumulated;
mod automatic;
mod evidence;
pub(crate) mod plant;

use crate::Error;
use crate::data::scaled::Data;
use crate::identify::evidence::Found;
use crate::identify::plant::{Identified, continuous_form, discrete, traces};
use crate::model::conversion::to_continuous;
use crate::selection::candidate::{Candidate, Choice};
use crate::selection::filter::{filter, uncertainty};
use crate::selection::input_delay::{InputDelay, delayed};
use crate::selection::logarithm;
use crate::selection::options::IdentifyOptions;
use crate::selection::search::choose;
use crate::sideslip::sideslip;
use drivelog::DriveLog;
use formats::{Document, Noise, Plant, Provenance};

pub use automatic::{Automatic, TriedOrder, automatic};

/// Identifies the lateral dynamics in `log`.
///
/// The validation data, the end of the log, estimate and choose nothing: the quality depends on the
/// fits on them, and their one-step residuals are those that are tested.
///
/// # Errors
/// [`Error`] where the log or the options allow no model. A poor model is no error: the evidence
/// and the quality report it.
pub fn identify(log: &DriveLog, options: &IdentifyOptions) -> Result<Identified, Error> {
    options.check()?;
    let measured = log;
    let (log, delay) = delayed(measured, options)?;
    let log = &*log;
    let data = Data::new(log, &options.preparation())?;

    let choice = choose(&data, options)?;
    let chosen = &choice.candidates[choice.chosen];
    let data = match chosen.initial_conditions.offsets.as_deref() {
        Some([offset]) => data.about(*offset)?,
        _ => data,
    };
    let from_fixes = sideslip(log);
    let mut warnings = log.warnings.clone();
    warnings.extend(from_fixes.warnings);
    warnings.extend(reports(log, &data, &choice, options, &delay));

    let filter = filter(&data, &choice.factor, chosen, options.refine, &mut warnings)?;
    // Back to SI: u' = (u − ū)/s_u, y' = (y − ȳ)/s_y.
    let model = chosen.model.scaled(&[data.input_scale], &[data.output_scale]);
    let gain: Vec<f64> =
        (0..model.order()).map(|i| filter.gain[(i, 0)] / data.output_scale).collect();
    let continuous = to_continuous(model.a.as_ref(), model.b.as_ref(), data.sample_time);
    warnings.extend(chosen.mirroring_cost.map(logarithm::mirroring_warning));
    if let Err(reason) = &continuous {
        warnings.push(format!("the model stays discrete: {reason}"));
    }
    let continuous = continuous.ok();
    warnings.extend(stabilised(chosen, options));
    let residual =
        filter.residuals.iter().map(|e| e * e).sum::<f64>() / filter.residuals.len().max(1) as f64;
    let uncertainty = uncertainty(&data, &choice, &filter.gain, options.refine);
    if let Err(error) = &uncertainty {
        warnings.push(format!("the model's uncertainty cannot be computed: {error}"));
    }
    let uncertainty = uncertainty.ok();
    if log.speed.is_none() {
        warnings.push("no speed channel: the operating point's speed is written as 0".into());
    }

    let mut traces = traces(log, &data, chosen, options)?;
    traces.steering_rad.clone_from(&measured.input);
    let found = Found {
        measured,
        log,
        options,
        delay: &delay,
        data: &data,
        choice: &choice,
        filter: &filter,
        model: &model,
        continuous: continuous.as_ref(),
        uncertainty: uncertainty.as_ref(),
        residual,
    };
    let (evidence, quality, point) = found.validated(&traces, warnings)?;

    let mut used = log.options.clone();
    used.extend(options.to_map());
    used.insert("realization".into(), chosen.realization.name().into());
    let plant = Plant {
        schema: Plant::SCHEMA.into(),
        name: log.name.clone(),
        input: options.input_kind,
        steering_ratio: log.steering_ratio,
        input_delay_s: delay.seconds,
        operating_point: point,
        discrete: discrete(&model, &gain, &chosen.initial_conditions.x0[0], data.sample_time),
        continuous: continuous.map(|c| continuous_form(&c, &model)),
        noise: Noise { innovation_variance: residual * data.output_scale * data.output_scale },
        sideslip: from_fixes.sideslip,
        uncertainty,
        evidence,
        quality,
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            sources: log.sources.clone(),
            options: used,
        },
    };
    plant.checked("plant.json").map_err(|e| Error::NoModel { problem: e.to_string() })?;
    Ok(Identified { plant, traces })
}

/// What the log, its preparation and the choice are reported with.
fn reports(
    log: &DriveLog,
    data: &Data,
    choice: &Choice,
    options: &IdentifyOptions,
    delay: &InputDelay,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let could_estimate = log.len() - data.validation.len();
    if options
        .max_samples
        .is_some_and(|most| (data.estimation.len()..could_estimate).contains(&most))
    {
        warnings.push(format!(
            "the log is long: {} of {} estimation samples are used, in {} blocks spread over them",
            data.estimation.len(),
            could_estimate,
            data.estimation.ranges.len()
        ));
    }
    warnings.extend(delay.warning.clone());
    if choice.factor.conditioning.is_reduced() {
        warnings.push(choice.factor.conditioning.to_string());
    }
    warnings
}

/// What stability cost the subspace estimate, where it was unstable.
fn stabilised(chosen: &Candidate, options: &IdentifyOptions) -> Option<String> {
    chosen.stabilised.map(|s| {
        let refined = if options.refine {
            format!("; refinement brought it to {:.1} %", chosen.estimation_fit)
        } else {
            String::new()
        };
        format!(
            "the subspace estimate was unstable (spectral radius {:.4}) and has been stabilised, which changed its fit on estimation data from {} to {:.1} %{refined}",
            s.radius,
            // An unstable simulation may fit by minus any number.
            if s.fit_before > -100.0 { format!("{:.1}", s.fit_before) } else { "nothing".into() },
            s.fit_after
        )
    })
}
