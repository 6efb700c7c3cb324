//! From where the loop comes back to a path: the engagement envelope.
//!
//! A straight path along x, the vehicle beside it and turned, at constant speed; look-ahead guidance and
//! controller are those of the design, the limits follow the speed. A bicycle is driven with saturating
//! tyres, load transfer and an actuator of the rate designed for; what its data do not state is that of
//! [`NonlinearParameters::default`]. An identified plant is linear and holds at its own speed alone unless
//! it was identified with steering times speed; where it is asked for clearly more lateral acceleration
//! than the bound, it counts as lost.

use crate::Error;
use crate::design::optimise::each;
use crate::guidance::guidance_for;
use crate::plants::DesignPlant;
use crate::plants::family::Family;
use formats::{Engagement, EngagementRow, Pid as PidFile};
use std::collections::VecDeque;
use std::sync::Arc;
use vehicle_models::{
    IdentifiedModel, IdentifiedPlant, NonlinearParameters, NonlinearVehicle, PathFollower,
    PathGeometry, PathPoint, Pid, PidInput,
};

/// Speeds as shares of the design's, where the model holds at others.
const SPEEDS: [f64; 3] = [0.6, 1.0, 1.4];
/// Heading errors, degrees, positive away from the path, and offsets, m.
const HEADINGS_DEG: [f64; 7] = [-90.0, -45.0, -20.0, 0.0, 20.0, 45.0, 90.0];
const OFFSETS_M: [f64; 5] = [0.0, 2.0, 5.0, 10.0, 20.0];
/// It is back when it stays this near the path, m and rad, for so long, s, within the time, s.
const NEAR_M: f64 = 0.3;
const NEAR_RAD: f64 = 0.03;
const STAYS_S: f64 = 1.0;
const WITHIN_S: f64 = 60.0;
/// Sideslip at which a vehicle spins, rad, and lateral acceleration over its bound beyond which a linear
/// plant says nothing.
const SPINS_RAD: f64 = 0.5;
const BEYOND: f64 = 1.3;
/// Length of the path, m.
const LENGTH_M: f64 = 10_000.0;

/// A plant on its way.
enum Driven {
    Linear(Box<IdentifiedPlant>),
    Nonlinear(Box<NonlinearVehicle>),
}

/// The plant to drive, at any of some speeds.
enum Source {
    Linear(Arc<IdentifiedModel>),
    Nonlinear(NonlinearParameters),
}

/// The envelope of a controller on the plant that it was designed on; `None` where the plant comes from no
/// file.
pub(crate) fn engagement(plant: &DesignPlant, pid: &PidFile) -> Result<Option<Engagement>, Error> {
    let fault = |e: vehicle_models::Error| Error::Model {
        model: plant.name.clone(),
        problem: e.to_string(),
    };
    let (source, scheduled, words) = match &plant.family {
        Family::Alone => return Ok(None),
        Family::Identified(file) => {
            let model = model_loading::identified_model(file).map_err(fault)?;
            let words = "the identified plant, which is linear";
            (Source::Linear(Arc::new(model)), plant.is_speed_scheduled(), words)
        }
        Family::Bicycle(file) => {
            let rate = pid.limits.max_rate_radps / file.vehicle.steering_ratio;
            let words = "the bicycle with saturating tyres, friction 1.05";
            (Source::Nonlinear(nonlinear(&file.vehicle, rate)), true, words)
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
    let path = straight().map_err(fault)?;
    let rows = each(&cells, |(speed, heading)| -> Result<EngagementRow, vehicle_models::Error> {
        let mut largest_offset_m = None;
        for offset in OFFSETS_M {
            let mut driven = source.start(*speed, offset, *heading)?;
            if !comes_back(&mut driven, pid, &path, *speed)? {
                break;
            }
            largest_offset_m = Some(offset);
        }
        Ok(EngagementRow { speed_mps: *speed, heading_error_rad: *heading, largest_offset_m })
    })?;
    let rows = rows.into_iter().collect::<Result<Vec<_>, _>>().map_err(fault)?;
    Ok(Some(Engagement { plant: words.into(), offsets_m: OFFSETS_M.to_vec(), rows }))
}

/// The vehicle of a data sheet up to its limits.
fn nonlinear(vehicle: &formats::VehicleData, road_wheel_rate_max: f64) -> NonlinearParameters {
    NonlinearParameters {
        mass: vehicle.mass_kg,
        yaw_inertia: vehicle.yaw_inertia_kgm2,
        distance_front: vehicle.distance_front_m,
        distance_rear: vehicle.distance_rear_m,
        cornering_stiffness_front: vehicle.cornering_stiffness_front_npr,
        cornering_stiffness_rear: vehicle.cornering_stiffness_rear_npr,
        steering_ratio: vehicle.steering_ratio,
        actuator_time_constant: vehicle.actuator_time_constant_s,
        road_wheel_rate_max,
        ..NonlinearParameters::default()
    }
}

fn straight() -> Result<Arc<PathGeometry>, vehicle_models::Error> {
    let at = |x: f64| PathPoint { distance: x + LENGTH_M, x, y: 0.0, heading: 0.0, curvature: 0.0 };
    PathGeometry::new(&[at(-LENGTH_M), at(0.0), at(LENGTH_M)], false).map(Arc::new)
}

impl Source {
    fn start(&self, speed: f64, y: f64, yaw: f64) -> Result<Driven, vehicle_models::Error> {
        Ok(match self {
            Self::Linear(model) => {
                let mut p = IdentifiedPlant::new(Arc::clone(model));
                (p.initial_y, p.initial_yaw, p.speed) = (y, yaw, speed);
                p.start();
                Driven::Linear(Box::new(p))
            }
            Self::Nonlinear(parameters) => {
                let mut p = NonlinearVehicle::new(*parameters)?;
                (p.initial_y, p.initial_yaw, p.speed) = (y, yaw, speed);
                p.start()?;
                Driven::Nonlinear(Box::new(p))
            }
        })
    }
}

impl Driven {
    fn step(&mut self, steering: f64, h: f64) -> Result<(), vehicle_models::Error> {
        match self {
            Self::Linear(p) => {
                p.steering_angle = steering;
                p.step(h)
            }
            Self::Nonlinear(p) => {
                p.steering_angle = steering;
                p.step(h)
            }
        }
    }

    fn pose(&self) -> [f64; 3] {
        match self {
            Self::Linear(p) => [p.x(), p.y(), p.yaw()],
            Self::Nonlinear(p) => [p.x(), p.y(), p.yaw()],
        }
    }

    /// Whether it slides, or is asked for what its model does not know.
    fn is_lost(&self, speed: f64, acceleration: f64) -> bool {
        match self {
            Self::Linear(p) => (p.yaw_rate() * speed).abs() > BEYOND * acceleration,
            Self::Nonlinear(p) => p.lateral_velocity().abs() > SPINS_RAD * speed,
        }
    }
}

/// Whether the loop, Gauss–Seidel, brings the vehicle back.
fn comes_back(
    driven: &mut Driven,
    pid: &PidFile,
    path: &Arc<PathGeometry>,
    speed: f64,
) -> Result<bool, vehicle_models::Error> {
    let law = model_loading::guidance_parameters(&guidance_for(pid, speed));
    let parameters = model_loading::pid_parameters(pid);
    let acceleration = parameters.max_lateral_acceleration;
    let mut follower = PathFollower::new(Arc::clone(path));
    let mut controller = Pid::default();
    let h = pid.sample_time_s;
    // What the outer loop is late by, in whole ticks.
    let delay_s = pid.designed_for.path_delay_s.max(pid.designed_for.loop_delay_s);
    let mut sent = VecDeque::from(vec![0.0; (delay_s / h).round() as usize]);
    let mut near_since = 0.0;
    for k in 0..(WITHIN_S / h) as usize {
        let time = k as f64 * h;
        let [x, y, yaw] = driven.pose();
        let guide = follower.evaluate(&law, x, y, yaw, speed);
        follower.commit(&guide);
        let near = guide.cross_track_error.abs() < NEAR_M && guide.heading_error.abs() < NEAR_RAD;
        if !near {
            near_since = time;
        } else if time - near_since >= STAYS_S {
            return Ok(true);
        }
        let input = PidInput {
            yaw_reference: guide.yaw_reference,
            yaw,
            steering_feedforward: guide.steering_feedforward,
            enabled: true,
            speed,
        };
        sent.push_back(controller.tick(&parameters, &input).steering_angle);
        driven.step(sent.pop_front().unwrap_or_default(), h)?;
        follower.integrate(&law, &guide, speed, h);
        if driven.is_lost(speed, acceleration) {
            return Ok(false);
        }
    }
    Ok(false)
}
