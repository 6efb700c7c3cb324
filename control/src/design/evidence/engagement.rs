//! The engagement envelope: the offsets and headings from which the loop returns to a path.
//!
//! The path is straight along x, the speed constant. An identified plant holds at its own speed alone,
//! unless it was identified with steering times speed; where its lateral acceleration clearly exceeds the
//! bound, it counts as off the path.

use crate::Error;
use crate::design::parallel::each;
use crate::guidance::guidance_for;
use crate::guidance::track::pid_input;
use crate::plants::behind_actuator::{bicycle_behind, plant_behind};
use crate::plants::design_plant::{DesignPlant, Family};
use crate::plants::plant_model::{PlantModel, model_error};
use std::collections::VecDeque;
use std::sync::Arc;
use steerwright_formats::{Engagement, EngagementRow, PathPoint, Pid as PidFile};
use steerwright_models::{PathFollower, PathGeometry, Pid};

/// Speeds as shares of the design's, where the model holds at others.
const SPEEDS: [f64; 3] = [0.6, 1.0, 1.4];
/// Heading errors, degrees, positive away from the path, and offsets, m.
const HEADINGS_DEG: [f64; 7] = [-90.0, -45.0, -20.0, 0.0, 20.0, 45.0, 90.0];
const OFFSETS_M: [f64; 5] = [0.0, 2.0, 5.0, 10.0, 20.0];
/// The vehicle has returned when it stays this near the path, m and rad, for a time, s, within the time, s.
const NEAR_M: f64 = 0.3;
const NEAR_RAD: f64 = 0.03;
const STAYS_S: f64 = 1.0;
const WITHIN_S: f64 = 60.0;
/// Sideslip at which a vehicle spins, rad, and lateral acceleration over its bound off the path.
const SPINS_RAD: f64 = 0.5;
const BEYOND: f64 = 1.3;
/// Length of the path, m.
const LENGTH_M: f64 = 10_000.0;

/// The envelope of a controller on the plant that it was designed on; `None` for a plant without a document.
pub(crate) fn engagement(plant: &DesignPlant, pid: &PidFile) -> Result<Option<Engagement>, Error> {
    let actuator = plant.actuator.unwrap_or_default();
    let (model, scheduled, description) = match &plant.family {
        Family::Alone => return Ok(None),
        Family::Identified(file) => {
            let description = "the identified plant, which is linear";
            let driven = PlantModel::from_plant(&plant_behind(file, actuator))?;
            (driven, plant.is_speed_scheduled(), description)
        }
        Family::Bicycle(file) => {
            let rate = pid.limits.max_rate_radps / file.vehicle.steering_ratio;
            match &plant.vehicle {
                Some(vehicle) => {
                    let driven = PlantModel::from_vehicle(vehicle, actuator, rate)?;
                    (driven, true, "the identified vehicle with its tyres")
                }
                None => {
                    let driven = PlantModel::saturating(&bicycle_behind(file, actuator), rate)?;
                    (driven, true, "the bicycle with saturating tyres, friction 1.05")
                }
            }
        }
    };
    let speeds: Vec<f64> = SPEEDS
        .into_iter()
        .filter(|share| scheduled || *share == 1.0)
        .map(|share| share * plant.speed)
        .collect();
    let cells: Vec<(f64, f64)> = speeds
        .iter()
        .flat_map(|v| HEADINGS_DEG.map(|heading| (*v, heading.to_radians())))
        .collect();
    let path = straight().map_err(model_error(&plant.name))?;
    let rows =
        each(&cells, |(speed, heading)| -> Result<EngagementRow, steerwright_models::Error> {
            let mut largest_offset_m = None;
            for offset in OFFSETS_M {
                let mut driven = model.clone();
                driven.start([0.0, offset, *heading], *speed)?;
                if !returns(&mut driven, pid, &path, *speed)? {
                    break;
                }
                largest_offset_m = Some(offset);
            }
            Ok(EngagementRow { speed_mps: *speed, heading_error_rad: *heading, largest_offset_m })
        })?;
    let rows = rows.into_iter().collect::<Result<Vec<_>, _>>().map_err(model_error(&plant.name))?;
    Ok(Some(Engagement { plant: description.into(), offsets_m: OFFSETS_M.to_vec(), rows }))
}

fn straight() -> Result<Arc<PathGeometry>, steerwright_models::Error> {
    let at = |x: f64| PathPoint::from([x + LENGTH_M, x, 0.0, 0.0, 0.0]);
    PathGeometry::new(&[at(-LENGTH_M), at(0.0), at(LENGTH_M)], false).map(Arc::new)
}

/// Whether the vehicle slides, or leaves the range in which its model holds.
fn is_out_of_range(plant: &PlantModel, speed: f64, max_acceleration: f64) -> bool {
    match plant {
        PlantModel::Nonlinear(p) => p.lateral_velocity().abs() > SPINS_RAD * speed,
        linear => (linear.outputs()[3] * speed).abs() > BEYOND * max_acceleration,
    }
}

/// Whether the vehicle returns to the path under a Gauss–Seidel coupling.
fn returns(
    plant: &mut PlantModel,
    pid: &PidFile,
    path: &Arc<PathGeometry>,
    speed: f64,
) -> Result<bool, steerwright_models::Error> {
    let law = steerwright_models::files::guidance_parameters(&guidance_for(pid, speed), speed);
    let parameters = steerwright_models::files::pid_parameters_at(pid, speed);
    let acceleration = parameters.lateral_acceleration.max_mps2;
    let mut follower = PathFollower::new(Arc::clone(path));
    let mut controller = Pid::default();
    let h = pid.sample_time_s;
    // The delay of the outer loop in whole ticks.
    let delay_s = pid.designed_for.path_delay_s.max(pid.designed_for.loop_delay_s);
    let mut sent = VecDeque::from(vec![0.0; (delay_s / h).round() as usize]);
    let mut near_since = 0.0;
    for k in 0..(WITHIN_S / h) as usize {
        let time = k as f64 * h;
        let [x, y, yaw, _] = plant.outputs();
        let guide = follower.evaluate(&law, x, y, yaw, speed);
        follower.commit(&guide);
        let near = guide.cross_track_error.abs() < NEAR_M && guide.heading_error.abs() < NEAR_RAD;
        if !near {
            near_since = time;
        } else if time - near_since >= STAYS_S {
            return Ok(true);
        }
        let input = pid_input(&guide, yaw, speed);
        sent.push_back(controller.tick(&parameters, &input).steering_angle);
        plant.step(sent.pop_front().unwrap_or_default(), h)?;
        follower.integrate(&law, &guide, speed, h);
        if is_out_of_range(plant, speed, acceleration) {
            return Ok(false);
        }
    }
    Ok(false)
}
