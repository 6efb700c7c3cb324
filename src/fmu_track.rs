//! A run along a road in the loop of packed FMUs: plant, path follower, controller.
//!
//! The plant may be any tool's: it takes `steering_angle` and `speed`, gives `x`, `y` and `yaw`, and
//! starts at `initial_x`, `initial_y` and `initial_yaw` where it has them.

use crate::failure::Failure;
use crate::lateral_loop::sideslip_parameters;
use control::Sideslip;
use fmi2_host::{Archive, Causality, Connection, Coupling, Instance, Recording, System};
use formats::Path as PathFile;

pub(crate) const PATH: &str = "ReferencePath";
pub(crate) const CONTROLLER: &str = "LateralPid";

/// The archives of a loop, each instantiated for every run.
#[derive(Clone, Copy)]
pub(crate) struct Loop<'a> {
    pub(crate) plant: &'a Archive,
    pub(crate) path: &'a Archive,
    pub(crate) controller: &'a Archive,
}

impl Loop<'_> {
    /// A run along the path at its speed, from its first point until it would be at its end.
    pub(crate) fn track(
        &self,
        path: &PathFile,
        step: f64,
        master: Coupling,
        sideslip: &Sideslip,
    ) -> Result<Recording, Failure> {
        let (Some(first), Some(last)) = (path.points.first(), path.points.last()) else {
            return Err(Failure::new("the path has no points", "make the path again"));
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
                return Err(Failure::new(
                    format!("{plant} has no `{name}`, and the road starts at {value}"),
                    "give a road that starts at the origin along x, or an FMU with initial_x, \
                     initial_y and initial_yaw",
                ));
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
        Ok(system.run(master, 0.0, steps * step, step)?)
    }
}

/// What a plant's instance is called: its model, without the dots that part it from variables.
pub(crate) fn name_of(plant: &Archive) -> String {
    plant.model().description().model_name.replace('.', "_")
}

pub(crate) fn add(system: &mut System, archive: &Archive, name: &str) -> Result<(), Failure> {
    system.add(Instance::new(archive, name)?)?;
    Ok(())
}

/// Gives a plant its speed, if it does not drive itself.
pub(crate) fn drive_at(system: &mut System, plant: &Archive, speed: f64) -> Result<(), Failure> {
    let takes = |c: Causality| matches!(c, Causality::Input | Causality::Parameter);
    if plant.model().variable("speed").is_some_and(|v| takes(v.causality)) {
        system.set(&name_of(plant), "speed", speed)?;
    }
    Ok(())
}
