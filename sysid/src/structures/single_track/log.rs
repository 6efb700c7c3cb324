//! From a drive log to `vehicle.json`.

use crate::Error;
use crate::actuator::identified_actuator;
use crate::data::moving::{least_speed, moving};
use crate::data::recording::{Recording, count, samples_in};
use crate::data::split::Split;
use crate::selection::options::IdentifyOptions;
use crate::sideslip::other_sideslip;
use crate::structures::held::Steering;
use crate::structures::model::{IdentifiedModel, StructureOptions};
use crate::structures::single_track::directions::directions;
use crate::structures::single_track::drive::{Drive, DriveSegment};
use crate::structures::single_track::identify::{
    SingleTrack, identify_near, identify_single_track,
};
use crate::structures::single_track::log_options::IdentifyVehicleOptions;
use crate::structures::single_track::options::SingleTrackOptions;
use crate::structures::single_track::parameters::Parameter;
use crate::structures::single_track::quality::{check_signs, quality};
use crate::structures::single_track::simulate::LONGEST_BEFORE_S;
use crate::structures::single_track::vehicle::VehicleOptions;
use crate::structures::state_space::plant::Traces;
use crate::validation::residuals::one_sided;
use std::ops::Range;
use steerwright_drivelog::{DriveLog, Response, Role, Segment};
use steerwright_formats::{
    Document, Intersample, Matrix, Model, Provenance, Structure, Vehicle, VehicleEvidence,
    VehicleParameter,
};

/// Shorter pieces of a segment hold little more than the transient of an initial state, s.
const SHORTEST_S: f64 = 3.0;
/// Fits that differ by less are the same, %: a file reproduces its own to that.
const SAME_FIT: f64 = 0.1;
/// Share of the samples whose lateral acceleration is at most that of the evidence.
const PERCENTILE: f64 = 0.99;

/// A vehicle with the signals behind its plots.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedVehicle {
    /// What goes into `vehicle.json`; its evidence is there.
    pub vehicle: Vehicle,
    /// Measured and simulated signals.
    pub traces: Traces,
}

impl StructureOptions for IdentifyVehicleOptions {
    fn structure(&self) -> Structure {
        Structure::SingleTrack
    }

    fn response(&self) -> Response {
        Response::Motion
    }

    fn identify(&self, log: &DriveLog) -> Result<IdentifiedModel, Error> {
        Ok(identify_vehicle(log, self)?.into())
    }
}

impl From<IdentifiedVehicle> for IdentifiedModel {
    fn from(found: IdentifiedVehicle) -> Self {
        Self {
            model: Model::SingleTrack(Box::new(found.vehicle)),
            traces: Some(found.traces),
            channels: None,
        }
    }
}

/// Identifies the single-track model in `log`, which must have a speed; the validation data take no part.
/// Lateral acceleration, lateral velocity and sideslip are those of a log that was read for the
/// motion ([`Response::Motion`]).
///
/// # Errors
/// [`Error`] where the log or the options allow no model. A poor model is no error: the evidence and
/// the quality report it.
pub fn identify_vehicle(
    log: &DriveLog,
    options: &IdentifyVehicleOptions,
) -> Result<IdentifiedVehicle, Error> {
    options.check()?;
    let least_mps = least_speed(log, options.least_speed_mps, options.wheelbase_m);
    let log = &*moving(log, least_mps)?;
    identify_moving(&Steering::new(log, &IdentifyOptions::default()), least_mps, options)
}

/// The same of a log that has nothing below the least speed, m/s.
pub(crate) fn identify_moving(
    steering: &Steering<'_>,
    least_mps: f64,
    options: &IdentifyVehicleOptions,
) -> Result<IdentifiedVehicle, Error> {
    options.check()?;
    let log = steering.log;
    // A log that is too short to show how its steering is held is taken as it was read.
    let read = steering.read().ok();
    let held = read.map_or(log, |read| &*read.held.log);
    let recording = Recording::new(log, &|turned| {
        Split::new(log, turned, options.validation).thinned(options.max_samples, log.sample_time_s)
    })?;
    check_signs(log)?;
    let estimator = options.estimator(log)?;
    let shortest = (SHORTEST_S / log.sample_time_s).ceil() as usize;
    let long = |ranges: &[Range<usize>]| -> Vec<Range<usize>> {
        ranges.iter().filter(|range| range.len() >= shortest).cloned().collect()
    };
    let ranges = [long(&recording.split.estimation), long(&recording.split.validation)];
    if ranges[0].is_empty() {
        return Err(Error::too_few(
            count(&recording.split.estimation),
            shortest,
            log.sample_time_s,
        ));
    }
    let [estimation, validation] = [&ranges[0], &ranges[1]].map(|ranges| drive(held, ranges));
    let validated = if ranges[1].is_empty() { None } else { Some(&validation) };
    let (found, mut warnings) = consistent(&estimation, validated, &estimator)?;
    let from_fixes = steering.fixes();
    let as_held = read.and_then(|read| read.warning.clone());
    warnings.splice(
        0..0,
        log.warnings.iter().cloned().chain(from_fixes.warnings.iter().cloned()).chain(as_held),
    );
    if log.others.contains_key(&Role::LongitudinalAcceleration) {
        warnings.push(
            "the longitudinal acceleration is compared with the speed, and not used: what braking does follows from the speed".into(),
        );
    }
    let mut simulated = log.output.clone();
    let [estimated, validated] = &ranges;
    let unused = long(&Split::unused(log, [estimated, validated]));
    let rest = drive(held, &unused);
    for (drive, ranges) in [(&estimation, estimated), (&validation, validated), (&rest, &unused)] {
        if ranges.is_empty() {
            continue;
        }
        for (range, segment) in ranges.iter().zip(found.model.simulate(drive)?) {
            simulated[range.clone()].copy_from_slice(&segment.yaw_rate_radps);
        }
    }
    let mut evidence = evidence(log, &recording, &ranges, &found, warnings)?;
    evidence.channels.clone_from(&held.channels);
    evidence.open_hold_s = steering.open_hold_s();
    let mut used = log.options.clone();
    used.extend(options.to_map());
    used.insert("least_speed_mps".into(), least_mps.to_string());
    let mut vehicle = found.model.vehicle(&VehicleOptions {
        name: log.name.clone(),
        mass_kg: options.mass(),
        track_width_m: options.track_width_m,
        steering_ratio: log.steering_ratio,
        speed_mps: evidence.speed.mean_mps,
    });
    let gentle = vehicle.in_gentle_driving();
    let quality = from_fixes.graded(quality(steering, &recording, &found, &evidence, &gentle));
    let offset = found.parameter(Parameter::YawRateOffset).value;
    vehicle.quality = one_sided::graded(quality, log, offset);
    vehicle.sideslip = from_fixes.sideslip;
    evidence
        .warnings
        .extend(vehicle.sideslip.as_ref().and_then(|found| other_sideslip(&gentle, found)));
    vehicle.provenance = Some(Provenance {
        version: env!("CARGO_PKG_VERSION").into(),
        sources: log.sources.clone(),
        options: used,
    });
    vehicle.evidence = Some(evidence);
    vehicle.checked("vehicle.json").map_err(|e| Error::no_model(e.to_string()))?;
    let traces = Traces::new(log, simulated, &ranges[1]);
    Ok(IdentifiedVehicle { vehicle, traces })
}

/// The model of the yaw rate alone, or of all signals that a single-track model can have, with a warning where these are
/// not fitted: lateral acceleration or velocity may be that of a body that rolls much, or of a sensor elsewhere. The
/// errors of the yaw rate on the validation data decide: all signals are fitted where these are smaller then, by a standard
/// error or with a spin that is no nearer. With a lateral velocity, which alone determines where the centre of gravity is,
/// they may be larger by less than a standard error.
fn consistent(
    estimation: &Drive,
    validation: Option<&Drive>,
    options: &SingleTrackOptions,
) -> Result<(SingleTrack, Vec<String>), Error> {
    let all = identify_single_track(estimation, validation, options);
    if let Ok(all) = &all
        && all.noise[1].is_none()
        && all.noise[2].is_none()
    {
        return Ok((all.clone(), Vec::new()));
    }
    let yaw_rate = SingleTrackOptions {
        fit_lateral_acceleration: false,
        fit_lateral_velocity: false,
        ..options.clone()
    };
    let near = all.as_ref().ok().map(|all| &all.model);
    let alone = identify_near(near, estimation, validation, &yaw_rate);
    // One of the two may spin; then there is nothing to compare.
    let (all, alone) = match (all, alone) {
        (Ok(all), Ok(alone)) => (all, alone),
        (Ok(one), Err(_)) | (Err(_), Ok(one)) => return Ok((one, Vec::new())),
        (Err(error), Err(_)) => return Err(error),
    };
    let fits = all.validation.zip(alone.validation);
    if let Some((with, without)) = fits {
        let difference = with.yaw_rate - without.yaw_rate;
        let error = without.yaw_rate_standard_error.unwrap_or(0.0).max(SAME_FIT);
        let least = if all.noise[2].is_some() { -error } else { 0.0 };
        let is_no_nearer = difference >= error || all.spin_margin >= alone.spin_margin;
        if difference > least && is_no_nearer {
            return Ok((all, Vec::new()));
        }
    }
    let why = match fits {
        Some((with, without)) => {
            format!(
                "with them the fit on the validation data is {:.1} %, without {:.1} %",
                with.yaw_rate, without.yaw_rate
            )
        }
        None => "there are no validation data to compare by".to_owned(),
    };
    let warning = format!(
        "lateral acceleration and velocity are compared, and the yaw rate alone is fitted: {why}"
    );
    Ok((alone, vec![warning]))
}

/// The signals of a log within ranges.
fn drive(log: &DriveLog, ranges: &[Range<usize>]) -> Drive {
    let speed = log.speed.as_deref().unwrap_or_default();
    let other = |role, range: &Range<usize>| Some(log.others.get(&role)?[range.clone()].to_vec());
    let steering = log.others.get(&Role::Steering).unwrap_or(&log.input);
    let most_before = (LONGEST_BEFORE_S / log.sample_time_s).ceil() as usize;
    let before = |range: &Range<usize>| {
        let holds = |s: &&Segment| s.range.start <= range.start && range.end <= s.range.end;
        let first = log.segments.iter().find(holds).map_or(range.start, |s| s.range.start);
        first.max(range.start.saturating_sub(most_before))
    };
    let channel = log.channels.iter().find(|c| c.role == Role::Steering.key());
    let held = channel.filter(|c| c.intersample == Some(Intersample::Zoh) && c.rate_hz > 0.0);
    let is_other = log.others.contains_key(&Role::Steering);
    let segment = |range: &Range<usize>| {
        let lateral_velocity = other(Role::LateralVelocity, range).or_else(|| {
            let angles = other(Role::Sideslip, range)?;
            Some(angles.iter().zip(&speed[range.clone()]).map(|(beta, v)| v * beta.tan()).collect())
        });
        DriveSegment {
            steering_rad: steering[range.clone()].to_vec(),
            steering_before_rad: steering[before(range)..range.start].to_vec(),
            steering_held_rad: if is_other && held.is_some() {
                Some(log.input[before(range)..range.end].to_vec())
            } else {
                None
            },
            speed_mps: speed[range.clone()].to_vec(),
            yaw_rate_radps: log.output[range.clone()].to_vec(),
            lateral_acceleration_mps2: other(Role::LateralAcceleration, range),
            lateral_velocity_mps: lateral_velocity,
        }
    };
    let steering_delay_s = match (is_other, held) {
        // The input of a log is held over each sample.
        (false, _) => 0.5 * log.sample_time_s,
        (true, held) => held.map_or(0.0, |channel| 0.5 / channel.rate_hz),
    };
    Drive {
        sample_time_s: log.sample_time_s,
        steering_ratio: log.steering_ratio,
        steering_delay_s,
        segments: ranges.iter().map(segment).collect(),
    }
}

fn evidence(
    log: &DriveLog,
    recording: &Recording,
    ranges: &[Vec<Range<usize>>; 2],
    found: &SingleTrack,
    mut warnings: Vec<String>,
) -> Result<VehicleEvidence, Error> {
    let [speed, rate] =
        [&recording.speed, &log.output].map(|signal| samples_in(signal, &ranges[0]));
    let mut lateral: Vec<f64> = speed.iter().zip(&rate).map(|(v, r)| (v * r).abs()).collect();
    lateral.sort_by(f64::total_cmp);
    let at = (PERCENTILE * lateral.len().saturating_sub(1) as f64) as usize;
    let has = |role| log.others.contains_key(&role);
    let [_, acceleration, velocity] = found.noise.map(|noise| noise.is_some());
    let fitted = [
        (Role::YawRate, true),
        (Role::LateralAcceleration, acceleration),
        (Role::LateralVelocity, velocity && has(Role::LateralVelocity)),
        (Role::Sideslip, velocity && !has(Role::LateralVelocity)),
    ];
    let n = found.parameters.len();
    Ok(VehicleEvidence {
        channels: log.channels.clone(),
        estimation_samples: count(&ranges[0]),
        validation_samples: count(&ranges[1]),
        sample_time_s: log.sample_time_s,
        speed: recording.speed_summary(),
        lateral_acceleration_mps2: lateral.get(at).copied().unwrap_or_default(),
        fitted: fitted.iter().filter(|f| f.1).map(|f| f.0.key().into()).collect(),
        open_hold_s: None,
        estimation: found.estimation,
        validation: found.validation,
        parameters: found.parameters.iter().map(VehicleParameter::from).collect(),
        covariance: Matrix::from_fn(n, n, |i, j| found.covariance[i][j]),
        directions: directions(found)?,
        largest_steering_rate_radps: log.fastest_steering(),
        actuator: identified_actuator(log, &mut warnings),
        spin_margin: found.spin_margin,
        yaw_rate_noise_density: found.noise[0].map(|noise| noise * noise * log.sample_time_s),
        warnings,
    })
}
