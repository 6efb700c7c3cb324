//! From a recording to `plant.json`: prepare → select → refine → validate → model.

pub(crate) mod accumulated;
pub(crate) mod automatic;
mod evidence;
mod open_response;
pub(crate) mod plant;

use crate::Error;
use crate::data::held_input::ContinuousResponse;
use crate::data::moving::{least_speed, moving};
use crate::data::scaled::Data;
use crate::model::conversion::to_continuous;
use crate::selection::candidate::{Candidate, Choice};
use crate::selection::choose::choose;
use crate::selection::delay::{Delay, Estimated};
use crate::selection::filter::{filter, uncertainty};
use crate::selection::options::IdentifyOptions;
use crate::selection::search::mirroring_warning;
use crate::structures::held::{Read, Steering};
use crate::structures::model::{IdentifiedModel, StructureOptions};
use crate::structures::multivariable::identify_channels;
use crate::structures::state_space::evidence::Found;
use crate::structures::state_space::open_response::{with_other_orders, with_uncertain_delay};
use crate::structures::state_space::plant::{Identified, Outcome, traces};
use crate::validation::faults::open_hold::with_uncertain_lines;
use std::borrow::Cow;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_drivelog::{DriveLog, Response};
use steerwright_formats::{DelayEstimate, Model, Structure};

pub use automatic::{Automatic, TriedOrder, automatic};

impl StructureOptions for IdentifyOptions {
    fn structure(&self) -> Structure {
        Structure::StateSpace
    }

    fn response(&self) -> Response {
        Response::YawRate
    }

    fn identify(&self, log: &DriveLog) -> Result<IdentifiedModel, Error> {
        if log.response == Response::Channels {
            return Ok(identify_channels(log, self)?.into());
        }
        Ok(identify(log, self)?.into())
    }
}

impl From<Identified> for IdentifiedModel {
    fn from(found: Identified) -> Self {
        Self {
            model: Model::StateSpace(Box::new(found.plant)),
            traces: Some(found.traces),
            channels: None,
        }
    }
}

/// Identifies the lateral dynamics in `log`; the validation data estimate and choose nothing. Segments below the least
/// speed of all structures, 3 m/s·√(L/2.6 m) with the wheelbase L of the steady turn, are left out, unless the vehicle
/// is nowhere faster.
///
/// # Errors
/// [`Error`] where the log or the options allow no model. A poor model is no error: the evidence
/// and the quality report it.
pub fn identify(log: &DriveLog, options: &IdentifyOptions) -> Result<Identified, Error> {
    let log = match moving(log, least_speed(log, None, None)) {
        Ok(moving) => moving,
        Err(_) => Cow::Borrowed(log),
    };
    identify_judged(&Steering::new(&log, options), options)
}

/// The same of a log of which all is used.
pub(crate) fn identify_judged(
    steering: &Steering<'_>,
    options: &IdentifyOptions,
) -> Result<Identified, Error> {
    options.check()?;
    let logged = steering.log;
    let Read { held, lines_s, warning: as_held, .. } = steering.read()?;
    let (log, delay) = delayed(&held.log, held.estimated.as_ref(), options);
    let log = &*log;
    let data = Data::new(log, &options.preparation())?;

    let choice = choose(&data, options)?;
    let chosen = &choice.candidates[choice.chosen];
    let data = match chosen.initial_conditions.offsets.as_deref() {
        Some([offset]) => data.about(*offset)?,
        _ => data,
    };
    let from_fixes = steering.fixes();
    let mut warnings = log.warnings.clone();
    warnings.extend(from_fixes.warnings.iter().cloned());
    warnings.extend(as_held.clone());
    warnings.extend(reports(log, &data, &choice, options, &delay));

    let filter = filter(&data, &choice.factor, chosen, options.refine, &mut warnings)?;
    // Back to SI: u' = (u − ū)/s_u, y' = (y − ȳ)/s_y.
    let model = chosen.model.scaled(&[data.input_scale], &[data.output_scale]);
    let gain: Vec<f64> =
        (0..model.order()).map(|i| filter.gain[(i, 0)] / data.output_scale).collect();
    let continuous = to_continuous(model.a.as_ref(), model.b.as_ref(), data.sample_time);
    warnings.extend(chosen.mirroring_cost.map(mirroring_warning));
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
    let mut uncertainty = uncertainty.ok();
    if let Some(stated) = &mut uncertainty {
        with_other_orders(stated, &data, &choice);
        if let Some(period_s) = lines_s {
            with_uncertain_lines(stated, *period_s);
        }
        if let (Some(estimated), None) = (&held.estimated, options.delay_s) {
            with_uncertain_delay(stated, &held.log, &estimated.delay, chosen, options);
        }
    }
    if log.speed.is_none() {
        warnings.push("no speed channel: the operating point's speed is written as 0".into());
    }

    let mut traces = traces(log, &data, &chosen.model)?;
    traces.steering_rad.clone_from(&logged.input);
    let mut used = log.options.clone();
    used.extend(options.to_map());
    used.insert("realization".into(), chosen.realization.name().into());
    let speed = log.speed.as_deref().unwrap_or_default();
    let outcome = Outcome {
        options,
        name: &log.name,
        input_kind: options.input_kind,
        steering_ratio: log.steering_ratio,
        vehicle_class: log.vehicle_class,
        wheelbase: steering.wheelbase(),
        delay_s: delay.seconds,
        sample_time_s: data.sample_time,
        model: &model,
        continuous: continuous.as_ref(),
        gain: &gain,
        x0: &chosen.initial_conditions.x0[0],
        means: (data.input_mean, data.output_mean),
        scales: [data.input_scale, data.output_scale],
        speed: if speed.is_empty() { (0.0, 0.0) } else { (mean(speed), standard_deviation(speed)) },
        steering: &log.input,
        seconds: log.len() as f64 * data.sample_time,
        residual,
        uncertainty,
        open_hold_s: steering.open_hold_s(),
        sideslip: from_fixes.sideslip,
        sources: &log.sources,
        used,
    };
    let found = Found {
        log,
        delay: delay.estimate,
        data: &data,
        choice: &choice,
        filter: &filter,
        steering_faults: steering.faults(),
    };
    let mut evidence = found.evidence(&outcome, &traces, warnings)?;
    evidence.held_for = held.vehicle.as_ref().map(ContinuousResponse::to_file);
    let mut plant = outcome.plant(evidence)?;
    plant.quality = from_fixes.graded(plant.quality);
    Ok(Identified { plant, traces })
}

/// The warnings about the log, its preparation and the choice.
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
    warnings.extend(choice.warning.clone());
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

/// A delay that was estimated, or given.
struct InputDelay {
    seconds: f64,
    warning: Option<String>,
    /// The estimate, where the data determine the delay.
    estimate: Option<DelayEstimate>,
}

/// Delays the steering by the delay of the options, or the one that the estimation data determine.
fn delayed<'a>(
    log: &'a DriveLog,
    estimated: Option<&Estimated>,
    options: &IdentifyOptions,
) -> (Cow<'a, DriveLog>, InputDelay) {
    let delay = match (options.delay_s, estimated) {
        (Some(seconds), _) => InputDelay { seconds, warning: None, estimate: None },
        (None, Some(estimated)) => InputDelay::new(&estimated.delay),
        // A log too short to determine a delay has none.
        (None, None) => InputDelay { seconds: 0.0, warning: None, estimate: None },
    };
    if delay.seconds == 0.0 {
        return (Cow::Borrowed(log), delay);
    }
    (Cow::Owned(log.with_input_delayed(delay.seconds)), delay)
}

impl InputDelay {
    fn new(delay: &Delay) -> Self {
        let warning = if delay.seconds > 0.0 { Some(words(delay)) } else { None };
        let estimate = DelayEstimate {
            estimate_s: delay.estimate_s,
            standard_error_s: Some(delay.standard_error_s).filter(|e| e.is_finite()),
            lag_without_s: delay.lag_without_s,
            evidence: delay.evidence,
            taken: delay.seconds > 0.0,
        };
        let finite = [estimate.estimate_s, estimate.lag_without_s, estimate.evidence];
        let estimate = Some(estimate).filter(|_| finite.iter().all(|x| x.is_finite()));
        Self { seconds: delay.seconds, warning, estimate }
    }
}

fn words(delay: &Delay) -> String {
    format!(
        "the yaw rate follows the steering after {:.3} ± {:.3} s of pure delay, which is taken as the delay of the input: a model of order {} without it needs a lag of {:.3} s and fits worse; the ± includes what the lag of a servo can replace, and the sum of both is more certain; a stated delay of 0 s omits it",
        delay.seconds,
        2.0 * delay.standard_error_s,
        delay.order_without,
        delay.lag_without_s
    )
}
