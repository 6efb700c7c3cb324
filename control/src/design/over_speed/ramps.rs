//! The evidence while the speed changes: the model in the plane at a speed that ramps through the range, with
//! the controller, and the path follower, that read the table at each tick.

use crate::Error;
use crate::closed_loop::metrics::metrics;
use crate::closed_loop::simulate::Trace;
use crate::guidance::track::pid_input;
use crate::guidance::{guidance_for, guidance_schedule, with_sideslip};
use crate::model::plant_sideslip;
use crate::paths::PathComposer;
use crate::plants::design_plant::{DesignPlant, Family};
use crate::plants::plant_model::{PlantModel, model_error};
use std::collections::VecDeque;
use std::sync::Arc;
use steerwright_formats::{Path, Pid as PidFile, SpeedRamp, SpeedRampKind};
use steerwright_models::{
    GuidanceParameters, PathFollower, Pid, PidInput, PidParameters, PidSchedule, Sideslip,
};

/// Changes of the speed, m/s².
const ACCELERATIONS_MPS2: [f64; 2] = [3.0, -3.0];
/// Shortest time between steps, s, and the same over the settling time.
const LEAST_PERIOD_S: f64 = 2.0;
const PERIOD_PER_SETTLING: f64 = 2.0;
/// Time at a constant speed before a ramp, s: on the path, that on the clothoid and on the arc before it.
const BEFORE_S: f64 = 1.0;
const CLOTHOID_S: f64 = 3.0;
const ON_ARC_S: f64 = 3.0;

/// Yaw steps and a path of constant radius, each at both changes of the speed.
pub(super) fn ramps(
    plant: &DesignPlant,
    pid: &PidFile,
    [low, high]: [f64; 2],
) -> Result<Vec<SpeedRamp>, Error> {
    let Some(model) = PlantModel::of_design(plant)? else { return Ok(Vec::new()) };
    let mut rows = Vec::new();
    for acceleration in ACCELERATIONS_MPS2 {
        let (from, to) = if acceleration > 0.0 { (low, high) } else { (high, low) };
        let ramp = Ramp { from, to, acceleration };
        rows.push(yaw_steps(
            RampDrive::new(&model, pid, pid.designed_for.loop_delay_s),
            pid,
            ramp,
        )?);
        let delay = pid.designed_for.path_delay_s.max(pid.designed_for.loop_delay_s);
        let drive = RampDrive::new(&model, pid, delay);
        rows.push(constant_radius(drive, pid, &sideslip(plant), high, ramp)?);
    }
    Ok(rows)
}

/// A speed that changes at a constant rate after `BEFORE_S`, in time from the start, s.
#[derive(Clone, Copy)]
struct Ramp {
    from: f64,
    to: f64,
    acceleration: f64,
}

impl Ramp {
    fn speed(&self, since: f64) -> f64 {
        let reached = self.from + self.acceleration * since.max(0.0);
        if self.acceleration > 0.0 { reached.min(self.to) } else { reached.max(self.to) }
    }

    fn duration(&self) -> f64 {
        (self.to - self.from) / self.acceleration
    }
}

/// The plant and its controller.
struct RampDrive<'a> {
    plant: PlantModel,
    parameters: PidParameters,
    schedule: Option<PidSchedule>,
    controller: Pid,
    sent: VecDeque<f64>,
    model: &'a str,
}

impl<'a> RampDrive<'a> {
    fn new(plant: &PlantModel, pid: &'a PidFile, delay_s: f64) -> Self {
        let parameters = steerwright_models::files::pid_parameters(pid);
        let ticks = (delay_s / pid.sample_time_s).round() as usize;
        Self {
            plant: plant.clone(),
            parameters,
            schedule: steerwright_models::files::pid_schedule(pid),
            controller: Pid::default(),
            sent: VecDeque::from(vec![0.0; ticks]),
            model: &pid.designed_for.name,
        }
    }

    /// Starts at the origin at a speed, m/s.
    fn start(&mut self, speed: f64) -> Result<(), Error> {
        self.plant.start([0.0; 3], speed).map_err(model_error(self.model))
    }

    /// One tick at the input's speed, and the motion to the next; returns the steering angle, rad.
    fn tick(&mut self, input: &PidInput) -> Result<f64, Error> {
        let schedule = self.schedule.as_ref();
        let now =
            schedule.map_or(self.parameters, |s| s.parameters_at(&self.parameters, input.speed));
        let steering = self.controller.tick(&now, input).steering_angle;
        self.sent.push_back(steering);
        self.plant.set_speed(input.speed);
        let arrived = self.sent.pop_front().unwrap_or_default();
        self.plant.step(arrived, now.sample_time).map_err(model_error(self.model))?;
        Ok(steering)
    }
}

/// Steps up and down by the height of the specification, one after the other.
fn yaw_steps(mut drive: RampDrive<'_>, pid: &PidFile, ramp: Ramp) -> Result<SpeedRamp, Error> {
    let (spec, h) = (&pid.specification, pid.sample_time_s);
    let settling = spec.settling_time_s.unwrap_or(0.0);
    let period = LEAST_PERIOD_S.max(PERIOD_PER_SETTLING * settling);
    let steps = ((ramp.duration() / period).floor() as usize).max(1);
    drive.start(ramp.from)?;
    let ticks = |time: f64| (time / h).round() as usize;
    let (before, each) = (ticks(BEFORE_S), ticks(period));
    let input = |reference: f64, yaw: f64, speed: f64| PidInput {
        yaw_reference: reference,
        yaw,
        speed,
        enabled: true,
        ..PidInput::default()
    };
    for _ in 0..before {
        let yaw = drive.plant.outputs()[2];
        drive.tick(&input(0.0, yaw, ramp.from))?;
    }
    let (mut overshoot, mut slowest) = (0.0_f64, Some(0.0_f64));
    for step in 0..steps {
        let up = step % 2 == 0;
        let reference = if up { spec.step_rad } else { 0.0 };
        let mut trace = Trace::default();
        for k in 0..each {
            let yaw = drive.plant.outputs()[2];
            trace.time.push(k as f64 * h);
            trace.yaw_reference.push(spec.step_rad);
            trace.yaw.push(if up { yaw } else { spec.step_rad - yaw });
            let speed = ramp.speed((step * each + k) as f64 * h);
            trace.steering.push(drive.tick(&input(reference, yaw, speed))?);
        }
        let reached = metrics(&trace, spec.step_rad, spec.settling_band_percent).step;
        overshoot = overshoot.max(reached.overshoot_percent);
        slowest = slowest.and_then(|s| Some(s.max(reached.settling_time_s?)));
    }
    Ok(SpeedRamp {
        manoeuvre: SpeedRampKind::YawSteps,
        acceleration_mps2: ramp.acceleration,
        from_mps: ramp.from,
        to_mps: ramp.speed((steps * each) as f64 * h),
        overshoot_percent: Some(overshoot),
        settling_time_s: slowest,
        radius_m: None,
        rms_cross_track_error_m: None,
        largest_cross_track_error_m: None,
    })
}

/// An arc with the lateral acceleration of the specification's curve at the highest speed.
fn constant_radius(
    mut drive: RampDrive<'_>,
    pid: &PidFile,
    sideslip: &Sideslip,
    high: f64,
    ramp: Ramp,
) -> Result<SpeedRamp, Error> {
    let h = pid.sample_time_s;
    let radius = high * high / pid.specification.curve_lateral_acceleration_mps2;
    let settled = BEFORE_S + CLOTHOID_S + ON_ARC_S;
    let arc = ramp.from * ON_ARC_S + high * (ramp.duration() + 2.0);
    let mut path = PathComposer::new()
        .straight(ramp.from * BEFORE_S)
        .clothoid(0.0, radius.recip(), ramp.from * CLOTHOID_S)
        .arc(radius.recip(), arc)
        .finish("constant radius", ramp.from)?;
    path.guidance = with_sideslip(guidance_for(pid, ramp.from), sideslip, ramp.from);
    path.schedule = guidance_schedule(pid);
    let (mut follower, law) = follower(&path)?;
    drive.start(ramp.from)?;
    let (mut squares, mut largest, mut counted) = (0.0, 0.0_f64, 0.0);
    for k in 0..=((settled + ramp.duration()) / h).round() as usize {
        let since = k as f64 * h - settled;
        let speed = ramp.speed(since);
        let [x, y, yaw, _] = drive.plant.outputs();
        let law = law(speed);
        let guide = follower.evaluate(&law, x, y, yaw, speed);
        follower.commit(&guide);
        drive.tick(&pid_input(&guide, yaw, speed))?;
        follower.integrate(&law, &guide, speed, h);
        if since >= 0.0 {
            squares += guide.cross_track_error.powi(2);
            largest = largest.max(guide.cross_track_error.abs());
            counted += 1.0;
        }
    }
    Ok(SpeedRamp {
        manoeuvre: SpeedRampKind::ConstantRadius,
        acceleration_mps2: ramp.acceleration,
        from_mps: ramp.from,
        to_mps: ramp.to,
        overshoot_percent: None,
        settling_time_s: None,
        radius_m: Some(radius),
        rms_cross_track_error_m: Some((squares / counted).sqrt()),
        largest_cross_track_error_m: Some(largest),
    })
}

/// The follower of a path, and its law at a speed.
fn follower(
    path: &Path,
) -> Result<(PathFollower, impl Fn(f64) -> GuidanceParameters + use<>), Error> {
    let geometry =
        steerwright_models::files::path_geometry(path).map_err(model_error(&path.name))?;
    let start = steerwright_models::files::guidance_parameters(&path.guidance, path.speed_mps);
    let schedule = steerwright_models::files::guidance_schedule(path);
    let law = move |speed: f64| schedule.as_ref().map_or(start, |s| s.parameters_at(&start, speed));
    Ok((PathFollower::new(Arc::new(geometry)), law))
}

/// The sideslip that the model states.
fn sideslip(plant: &DesignPlant) -> Sideslip {
    match &plant.family {
        Family::Bicycle(bicycle) => {
            let parameters = steerwright_models::files::bicycle_parameters(&bicycle.vehicle);
            parameters.sideslip(bicycle.vehicle.speed_mps.max(1.0))
        }
        Family::Identified(plant) => plant_sideslip(plant).unwrap_or_default(),
        Family::Alone => Sideslip::default(),
    }
}
