//! The whole loop in one process: plant, path and controller, stepped as an importer steps the FMUs.
//!
//! A Jacobi coupling delays the yaw loop by a step and the loop through the path by two. The step is the
//! controller's sample time. Tick 0 sees the initial pose, on the path and along it.

use crate::Error;
use crate::error::positive;
use crate::guidance::guidance_for;
use crate::plants::plant_model::{PlantModel, model_error};
use std::sync::Arc;
use steerwright_formats::{Guidance, LoopCoupling, Path, Pid as PidFile};
use steerwright_models::{PathFollower, PathOutput, Pid, PidInput};

/// A drive along a path; a row for each tick.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TrackTrace {
    /// Time, s.
    pub time: Vec<f64>,
    /// Position, m.
    pub x: Vec<f64>,
    /// Position, m.
    pub y: Vec<f64>,
    /// Yaw, rad.
    pub yaw: Vec<f64>,
    /// Yaw rate, rad/s.
    pub yaw_rate: Vec<f64>,
    /// Yaw reference of the path, rad.
    pub yaw_reference: Vec<f64>,
    /// Steering angle, rad, in steering coordinates.
    pub steering: Vec<f64>,
    /// Distance from the path, m, positive to the left.
    pub cross_track_error: Vec<f64>,
    /// Yaw minus the path's heading, rad.
    pub heading_error: Vec<f64>,
    /// Distance along the path, m.
    pub distance: Vec<f64>,
    /// Whether the end of the path was reached.
    pub finished: bool,
}

/// The input of the controller that follows a path.
pub(crate) fn pid_input(guide: &PathOutput, yaw: f64, speed: f64) -> PidInput {
    PidInput {
        yaw_reference: guide.yaw_reference,
        yaw,
        steering_feedforward: guide.steering_feedforward,
        enabled: true,
        speed,
    }
}

/// Drives along a path at its speed, with [`guidance_for`] the controller, until the path ends or
/// `duration` seconds are over.
///
/// # Errors
/// [`Error::Model`] where the path or the plant cannot be stepped.
pub fn track(
    plant: PlantModel,
    pid: &PidFile,
    path: &Path,
    duration: f64,
    coupling: LoopCoupling,
) -> Result<TrackTrace, Error> {
    track_with(plant, pid, path, &guidance_for(pid, path.speed_mps), duration, coupling)
}

/// As [`track`], with another guidance.
///
/// # Errors
/// As [`track`].
pub fn track_with(
    mut plant: PlantModel,
    pid: &PidFile,
    path: &Path,
    guidance: &Guidance,
    duration: f64,
    coupling: LoopCoupling,
) -> Result<TrackTrace, Error> {
    positive([("duration", duration, " s")])?;
    let Some(start) = path.points.first() else {
        return Err(Error::TooFewPoints { got: 0, need: 2 });
    };
    let law = steerwright_models::files::guidance_parameters(guidance, path.speed_mps);
    let speed = path.speed_mps;
    let geometry =
        steerwright_models::files::path_geometry(path).map_err(model_error(&path.name))?;
    let mut follower = PathFollower::new(Arc::new(geometry));
    let parameters = steerwright_models::files::pid_parameters_at(pid, speed);
    let mut controller = Pid::default();
    let mut tick = |guide: &PathOutput, yaw: f64| {
        controller.tick(&parameters, &pid_input(guide, yaw, speed)).steering_angle
    };
    let follow = |follower: &mut PathFollower, [x, y, yaw, _]: [f64; 4]| {
        let out = follower.evaluate(&law, x, y, yaw, speed);
        follower.commit(&out);
        out
    };
    let pose = [start.x_m, start.y_m, start.heading_rad];
    plant.start(pose, speed).map_err(model_error("plant"))?;
    let h = pid.sample_time_s;
    let ticks = (duration / h).round() as usize;
    let mut pose = plant.outputs();
    let mut guide = follow(&mut follower, pose);
    // The values on the connections of PID and path, which a Jacobi coupling reads a step later.
    let (mut stale_pose, mut stale_guide) = (pose, guide);
    let mut steering = tick(&guide, pose[2]);
    let mut trace = TrackTrace::default();
    for k in 0..=ticks {
        let used = if coupling == LoopCoupling::Jacobi { &stale_guide } else { &guide };
        trace.time.push(k as f64 * h);
        trace.x.push(pose[0]);
        trace.y.push(pose[1]);
        trace.yaw.push(pose[2]);
        trace.yaw_rate.push(pose[3]);
        trace.yaw_reference.push(used.yaw_reference);
        trace.steering.push(steering);
        trace.cross_track_error.push(guide.cross_track_error);
        trace.heading_error.push(guide.heading_error);
        trace.distance.push(guide.distance);
        if guide.finished {
            trace.finished = true;
            break;
        }
        plant.step(steering, h).map_err(model_error("plant"))?;
        pose = plant.outputs();
        let next = follow(&mut follower, pose);
        follower.integrate(&law, &next, speed, h);
        steering = match coupling {
            LoopCoupling::GaussSeidel => tick(&next, pose[2]),
            LoopCoupling::Jacobi => {
                let steering = tick(&stale_guide, stale_pose[2]);
                // The path used the pose at the start of the step: `guide`.
                (stale_pose, stale_guide) = (pose, guide);
                steering
            }
        };
        guide = next;
    }
    Ok(trace)
}
