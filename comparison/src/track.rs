//! A run along a road in the loop of packed FMUs: plant, path follower, controller.
//!
//! The plant may be any tool's: its inputs are `steering_angle` and `speed`, its outputs `x`, `y` and
//! `yaw`, and it starts at `initial_x`, `initial_y` and `initial_yaw` where it has them.

use crate::Error;
use crate::packed::sideslip_parameters;
use steerwright_control::Sideslip;
use steerwright_formats::Path as PathFile;
use steerwright_host::{Archive, Causality, Connection, Coupling, Instance, Recording, System};

const PATH: &str = "ReferencePath";
pub(crate) const CONTROLLER: &str = "LateralPid";

/// The archives of a loop, each instantiated for every run.
#[derive(Clone, Copy)]
#[allow(missing_docs)]
pub struct Loop<'a> {
    pub plant: &'a Archive,
    pub path: &'a Archive,
    pub controller: &'a Archive,
}

impl Loop<'_> {
    /// A run along the path at its speed, from its first point until it would be at its end. The path
    /// follower uses the plant's sideslip.
    ///
    /// # Errors
    /// An empty path, a plant that cannot start there, and those of running the FMUs.
    pub fn track(
        &self,
        path: &PathFile,
        step: f64,
        coupling: Coupling,
        sideslip: &Sideslip,
    ) -> Result<Recording, Error> {
        let (Some(first), Some(last)) = (path.points.first(), path.points.last()) else {
            return Err(Error::EmptyPath);
        };
        let plant = name_of(self.plant);
        let mut system = System::new();
        add(&mut system, self.plant, &plant)?;
        add(&mut system, self.path, PATH)?;
        add(&mut system, self.controller, CONTROLLER)?;
        for (from, to, name) in [
            (plant.as_str(), PATH, "x"),
            (&plant, PATH, "y"),
            (&plant, PATH, "yaw"),
            (PATH, CONTROLLER, "yaw_reference"),
            (PATH, CONTROLLER, "steering_feedforward"),
            (&plant, CONTROLLER, "yaw"),
            (CONTROLLER, &plant, "steering_angle"),
        ] {
            system.connect(Connection::new(from, name, to, name))?;
        }
        let pose = [
            ("initial_x", first.x_m),
            ("initial_y", first.y_m),
            ("initial_yaw", first.heading_rad),
        ];
        for (name, value) in pose {
            if self.plant.model().variable(name).is_some() {
                system.set(&plant, name, value)?;
            } else if value != 0.0 {
                return Err(Error::NoStartPose { plant, parameter: name, value });
            }
        }
        drive_at(&mut system, self.plant, path.speed_mps)?;
        system.set(PATH, "speed", path.speed_mps)?;
        if self.controller.model().variable("speed").is_some() {
            system.set(CONTROLLER, "speed", path.speed_mps)?;
        }
        for (name, value) in sideslip_parameters(sideslip) {
            system.set(PATH, name, value)?;
        }
        let steps = ((last.distance_m - first.distance_m) / path.speed_mps / step).floor();
        Ok(system.run(coupling, 0.0, steps * step, step)?)
    }
}

/// Name of a plant's instance: its model, without the dots that separate it from variables.
pub(crate) fn name_of(plant: &Archive) -> String {
    plant.model().description().model_name.replace('.', "_")
}

pub(crate) fn add(system: &mut System, archive: &Archive, name: &str) -> Result<(), Error> {
    system.add(Instance::new(archive, name)?)?;
    Ok(())
}

/// Sets a plant's speed, unless the speed is an output.
pub(crate) fn drive_at(system: &mut System, plant: &Archive, speed: f64) -> Result<(), Error> {
    let takes = |c: Causality| matches!(c, Causality::Input | Causality::Parameter);
    if plant.model().variable("speed").is_some_and(|v| takes(v.causality)) {
        system.set(&name_of(plant), "speed", speed)?;
    }
    Ok(())
}
