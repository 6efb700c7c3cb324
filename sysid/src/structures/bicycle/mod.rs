//! The structure `bicycle`: the two-wheel model of eq 13 from a drive whose speed varies, in the
//! body frame and with the speed of each sample (docs/methods/bicycle.md). The result is a
//! `bicycle.json` for the BicyclePlant.
//!
//! The focus is simulation, unweighted: a model this small is wrong somewhere on every drive (tyres
//! saturate, load shifts), and its errors are slow; whitening them would fit what remains at high
//! frequency, at the expense of the turns.

mod estimate;
mod evidence;
pub(crate) mod information;
mod options;
mod parameters;
mod quality;
mod rate_limit;
pub(crate) mod reference;
mod response;
mod simulate;
mod simulation;
mod transitions;
mod uncertainty;
mod validate;
mod wheelbase;

use crate::Error;
use crate::data::moving::{least_speed, moving};
use crate::data::recording::Recording;
use crate::data::split::{CRUMB, Split};
use crate::error::check_yaw_rate;
use crate::selection::options::IdentifyOptions;
use crate::sideslip::other_sideslip;
use crate::structures::bicycle::estimate::{Estimate, Problem};
use crate::structures::bicycle::parameters::DELAY;
use crate::structures::bicycle::rate_limit::Estimates;
use crate::structures::bicycle::simulate::within;
use crate::structures::bicycle::simulation::{Simulation, segments};
use crate::structures::held::Steering;
use crate::structures::model::{IdentifiedModel, StructureOptions};
use crate::structures::state_space::plant::Traces;
use crate::validation::residuals::one_sided;
use std::ops::Range;
use steerwright_drivelog::{DriveLog, Response};
use steerwright_formats::{
    Bicycle, Document, Model, Provenance, Structure, VehicleData, WithDelay,
};

pub use crate::structures::bicycle::options::BicycleOptions;
pub(crate) use crate::structures::bicycle::response::{
    response_errors, response_in_gentle_driving,
};
pub use crate::structures::bicycle::validate::validate_bicycle;
pub(crate) use crate::structures::bicycle::wheelbase::wheelbase;

/// A bicycle with the signals behind its plots.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedBicycle {
    /// What goes into `bicycle.json`; its evidence is there.
    pub bicycle: Bicycle,
    /// Measured and simulated signals.
    pub traces: Traces,
}

impl StructureOptions for BicycleOptions {
    fn structure(&self) -> Structure {
        Structure::Bicycle
    }

    fn response(&self) -> Response {
        Response::YawRate
    }

    fn identify(&self, log: &DriveLog) -> Result<IdentifiedModel, Error> {
        Ok(identify_bicycle(log, self)?.into())
    }
}

impl From<IdentifiedBicycle> for IdentifiedModel {
    fn from(found: IdentifiedBicycle) -> Self {
        Self {
            model: Model::Bicycle(Box::new(found.bicycle)),
            traces: Some(found.traces),
            channels: None,
        }
    }
}

/// Identifies the bicycle in `log`, which must have a speed; the validation data take no part.
///
/// # Errors
/// [`Error`] where the log or the options allow no model. A poor model is no error: the evidence and
/// the quality report it.
pub fn identify_bicycle(
    log: &DriveLog,
    options: &BicycleOptions,
) -> Result<IdentifiedBicycle, Error> {
    options.check()?;
    check_yaw_rate(log)?;
    let least_mps = least_speed(log, options.least_speed_mps, options.wheelbase_m);
    let log = &*moving(log, least_mps)?;
    identify_moving(&Steering::new(log, &IdentifyOptions::default()), least_mps, options)
}

/// The same of a log that has nothing below the least speed, m/s.
pub(crate) fn identify_moving(
    steering: &Steering<'_>,
    least_mps: f64,
    options: &BicycleOptions,
) -> Result<IdentifiedBicycle, Error> {
    options.check()?;
    // A log that is too short to show how its steering is held is taken as it was read.
    let log = steering.read().map_or(steering.log, |read| &*read.held.log);
    let recording = Recording::new(log, &|turned| {
        Split::new(log, turned, options.validation).thinned(options.max_samples, log.sample_time_s)
    })?;
    let segments = segments(&recording, log);
    let geometry =
        parameters::Geometry { wheelbase: options.wheelbase_m, is_angle: log.has_steering_angle() };
    if !geometry.is_angle && geometry.wheelbase.is_none() {
        return Err(Error::WheelbaseNeeded);
    }
    let problem = |ranges: &[Range<usize>], delay: bool| {
        Problem::new(within(&segments, ranges), options.front_share(), geometry, delay)
    };
    let [prompt, delayed] = [false, true].map(|delay| problem(&recording.split.estimation, delay));
    let Estimates { prompt, without_delay, delayed, with_delay } = Estimates::new(prompt, delayed)?;
    let validation = problem(&recording.split.validation, false);
    let split = &recording.split;
    let mut unused = Split::unused(log, [&split.estimation, &split.validation]);
    unused.retain(|range| range.len() >= CRUMB);
    let rest = problem(&unused, false);
    let simulate = |e: &Estimate| -> Result<Simulation, Error> {
        let estimation = prompt.errors(&e.parameters, &e.initial_states);
        let initial_states = validation.initial_states(&e.parameters)?;
        let validation = initial_states
            .and_then(|initial_states| validation.errors(&e.parameters, &initial_states));
        let mut simulation = Simulation::new(log, &recording, estimation, validation);
        if let Some(initial_states) = rest.initial_states(&e.parameters)?
            && let Some(errors) = rest.errors(&e.parameters, &initial_states)
        {
            simulation.add(log, &unused, errors);
        }
        Ok(simulation)
    };
    let of_delayed = (simulate(&with_delay)?, uncertainty::covariance(&delayed, &with_delay)?);
    let summary = WithDelay {
        input_delay_s: with_delay.parameters[DELAY],
        standard_error_s: of_delayed.1[DELAY][DELAY].max(0.0).sqrt(),
        actuator_time_constant_s: with_delay.parameters[parameters::LAG].exp(),
        estimation_fit: of_delayed.0.estimation_fit,
        validation_fit: of_delayed.0.validation_fit.fit,
    };
    // Chosen on the estimation data.
    let (found, (simulation, covariance)) =
        if summary.input_delay_s > 0.0 && evidence::is_determined(&summary) {
            (with_delay, of_delayed)
        } else {
            let covariance = uncertainty::covariance(&prompt, &without_delay)?;
            (without_delay.clone(), (simulate(&without_delay)?, covariance))
        };
    let from_fixes = steering.fixes();
    let known = evidence::Known {
        log,
        steering,
        options,
        recording: &recording,
        estimate: &found,
        covariance: &covariance,
        simulation: &simulation,
        with_delay: summary,
    };
    let mut evidence = known.evidence()?;
    let mut used = log.options.clone();
    used.extend(options.to_map());
    used.insert("least_speed_mps".into(), least_mps.to_string());
    let vehicle = VehicleData {
        name: log.name.clone(),
        speed_mps: evidence.speed.mean_mps,
        ..parameters::vehicle(&found.parameters, options, log.steering_ratio)
    };
    let quality = from_fixes.graded(known.quality(&evidence, &vehicle));
    let quality = one_sided::graded(quality, log, evidence.yaw_rate_offset_radps);
    evidence
        .warnings
        .extend(from_fixes.sideslip.as_ref().and_then(|found| other_sideslip(&vehicle, found)));
    let provenance = Provenance {
        version: env!("CARGO_PKG_VERSION").into(),
        sources: log.sources.clone(),
        options: used,
    };
    let bicycle = Bicycle {
        sideslip: from_fixes.sideslip,
        evidence: Some(evidence),
        quality,
        provenance,
        ..Bicycle::new(vehicle)
    };
    bicycle.checked("bicycle.json").map_err(|e| Error::no_model(e.to_string()))?;
    let mut traces = Traces::new(log, simulation.simulated, &recording.split.validation);
    traces.steering_rad.clone_from(&steering.log.input);
    Ok(IdentifiedBicycle { bicycle, traces })
}
