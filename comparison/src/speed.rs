//! The responses of a speed controller in the loop of packed FMUs.

use crate::Error;
use crate::packed::archive;
use steerwright_control::speed_responses;
use steerwright_formats::{Document, SpeedController};
use steerwright_host::{Archive, Instance};

/// `SpeedController` and `LongitudinalPlant`, coupled as by Gauss and Seidel: the plant first.
struct SpeedLoop {
    plant: Instance,
    control: Instance,
    step_s: f64,
    steps: u64,
}

impl SpeedLoop {
    /// Both at a speed, m/s, with a speed reference, m/s, and a step, s.
    fn new(
        plant: &Archive,
        control: &Archive,
        speed: f64,
        speed_reference: f64,
        step_s: f64,
    ) -> Result<Self, Error> {
        let mut plant = Instance::new(plant, "plant")?;
        let mut control = Instance::new(control, "control")?;
        for fmu in [&mut plant, &mut control] {
            fmu.setup_experiment(0.0, None, None)?;
            fmu.enter_initialization_mode()?;
        }
        plant.set("initial_speed", speed)?;
        control.set("speed", speed)?;
        control.set("speed_reference", speed_reference)?;
        for fmu in [&mut plant, &mut control] {
            fmu.exit_initialization_mode()?;
        }
        Ok(Self { plant, control, step_s, steps: 0 })
    }

    /// The speeds, m/s, at the ticks of a time, s, with a speed reference, m/s, and a grade that is not measured, rad: from
    /// the tick at which the controller first reads the reference.
    fn run(&mut self, seconds: f64, speed_reference: f64, grade: f64) -> Result<Vec<f64>, Error> {
        let count = (seconds / self.step_s).round() as usize + 1;
        let mut speeds = Vec::with_capacity(count);
        for _ in 0..count {
            for name in ["accelerator", "brake", "acceleration_command"] {
                let value = self.control.real(name)?;
                self.plant.set(name, value)?;
            }
            self.plant.set("grade", grade)?;
            let time = self.steps as f64 * self.step_s;
            self.plant.do_step(time, self.step_s)?;
            let speed = self.plant.real("speed")?;
            self.control.set("speed", speed)?;
            self.control.set("speed_reference", speed_reference)?;
            self.control.do_step(time, self.step_s)?;
            self.steps += 1;
            speeds.push(speed);
        }
        Ok(speeds)
    }
}

/// Fills in the responses of the packed controller and of the packed model that it was designed on, at the speeds of its
/// evidence.
///
/// # Errors
/// Those of packing and running the FMUs.
pub fn verify_speed(controller: &mut SpeedController) -> Result<(), Error> {
    let control = archive(&controller.to_json(), "the controller")?;
    let plant = archive(&controller.model.to_json(), "the model")?;
    let mut found = Vec::new();
    for row in &controller.evidence.speeds {
        let speed = row.speed_mps;
        let mut fmus = SpeedLoop::new(&plant, &control, speed, speed, controller.sample_time_s)?;
        found.push(speed_responses(controller, speed, |seconds, speed_reference, grade| {
            fmus.run(seconds, speed_reference, grade)
        })?);
    }
    controller.evidence.fmu_loop = found;
    Ok(())
}
