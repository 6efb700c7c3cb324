//! Closed loops of the packed FMUs under a Gauss–Seidel master.

use crate::failure::Failure;
use crate::package;
use crate::simulate::system_of;
use fmi2_host::{Archive, InputTable, Master, Recording, System};
use formats::{Document, Path as PathFile, Pid, Plant, Specification, StepMetrics};
use report::StepResponse;
use std::path::{Path, PathBuf};

const PLANT: &str = "IdentifiedPlant";
const PID: &str = "LateralPid";

/// How long the loop holds its course before the step: the integral action takes up the plant's
/// steering offset meanwhile, as it would on the road.
const BEFORE_STEP_S: f64 = 10.0;

/// The archives that a loop is made of.
pub(super) struct Archives {
    plant: Archive,
    /// What the plant is made from.
    document: Plant,
    pid: Option<Archive>,
}

/// The specification's step in the loop.
pub(super) struct Step {
    pub(super) csv: String,
    pub(super) response: StepResponse,
    pub(super) metrics: StepMetrics,
}

impl Archives {
    /// `file` is the packed plant.
    pub(super) fn new(file: PathBuf, plant: &Plant) -> Result<Self, Failure> {
        Ok(Self { plant: Archive::open(file)?, document: plant.clone(), pid: None })
    }

    /// Takes the controller of the loops that follow.
    pub(super) fn pid(&mut self, archive: PathBuf) -> Result<(), Failure> {
        self.pid = Some(Archive::open(archive)?);
        Ok(())
    }

    /// Plant, path where there is one, controller, in the order of a loop without delay.
    fn system(&self, plant: &Archive, path: Option<&Archive>) -> Result<System, Failure> {
        let pid = self.pid.as_ref().ok_or_else(|| {
            Failure::new("no controller was packed", "pack the controller before the loop is run")
        })?;
        let mut system = system_of([Some(plant), path, Some(pid)].into_iter().flatten())?;
        system.connect_by_name()?;
        Ok(system)
    }

    /// The specification's step of the yaw reference, from a straight course.
    pub(super) fn step(&self, pid: &Pid) -> Result<Step, Failure> {
        self.step_on(&self.plant, pid, (BEFORE_STEP_S / pid.sample_time_s).round() as usize)
    }

    /// The same at the moment at which a steering offset appears.
    pub(super) fn step_with_offset(&self, pid: &Pid) -> Result<Step, Failure> {
        let name = "the plant with a steering offset";
        let mut plant = self.document.clone();
        plant.operating_point.steering_offset_rad =
            -pid.specification.steering_offset_rad * plant.steering_ratio;
        plant.operating_point.yaw_rate_offset_radps = 0.0;
        let packed = package::pack(&plant.to_json(), name, None)?;
        self.step_on(&Archive::from_bytes(&packed.bytes, name)?, pid, 0)
    }

    /// The step at tick `first`.
    fn step_on(&self, plant: &Archive, pid: &Pid, first: usize) -> Result<Step, Failure> {
        let s = &pid.specification;
        let ts = pid.sample_time_s;
        let steps = first + (s.steady_state_time_s / ts).round() as usize;
        let mut system = self.system(plant, None)?;
        // What holds from one communication point on is what the tick at the next one sees.
        let mut table = format!("time,{PID}.yaw_reference\n0,{}\n", step_at(first == 0, s));
        if first > 0 {
            table.push_str(&format!("{},{}\n", (first as f64 - 1.0) * ts, s.step_rad));
        }
        system.feed(InputTable::read(table.as_bytes(), "the step")?);
        let recording = system.run(Master::GaussSeidel, 0.0, steps as f64 * ts, ts)?;
        let column = |name: &str| column(&recording, name);
        let yaw = column("IdentifiedPlant.yaw")?;
        let steering = column("LateralPid.steering_angle")?;
        let trace = control::Trace {
            time: recording.times[first..].iter().map(|t| t - recording.times[first]).collect(),
            yaw_reference: vec![s.step_rad; recording.times.len() - first],
            yaw: yaw[first..].iter().map(|y| y - yaw[first]).collect(),
            steering: steering[first..].to_vec(),
        };
        let metrics = control::metrics_of(&trace, s.step_rad, s.steady_state_error_percent)
            .ok_or_else(|| Failure::new("the step has no samples", "report this as a fault"))?
            .step;
        Ok(Step {
            csv: recording.to_csv(),
            response: StepResponse {
                time_s: trace.time,
                yaw_rad: trace.yaw,
                steering_rad: trace.steering,
            },
            metrics,
        })
    }

    /// A run along a path, from its first point to its end; the trajectory as CSV.
    pub(super) fn track(
        &self,
        archive: &Path,
        path: &PathFile,
        ts: f64,
    ) -> Result<String, Failure> {
        let archive = Archive::open(archive)?;
        let mut system = self.system(&self.plant, Some(&archive))?;
        if let (Some(first), Some(last)) = (path.points.first(), path.points.last()) {
            system.set(PLANT, "initial_x", first.x_m)?;
            system.set(PLANT, "initial_y", first.y_m)?;
            system.set(PLANT, "initial_yaw", first.heading_rad)?;
            let steps = ((last.distance_m - first.distance_m) / path.speed_mps / ts).floor();
            Ok(system.run(Master::GaussSeidel, 0.0, steps * ts, ts)?.to_csv())
        } else {
            Err(Failure::new("the path has no points", "make the path again"))
        }
    }
}

/// The reference before the step, or from the start where the step is there.
fn step_at(start: bool, specification: &Specification) -> f64 {
    if start { specification.step_rad } else { 0.0 }
}

fn column(recording: &Recording, name: &str) -> Result<Vec<f64>, Failure> {
    recording
        .column(name)
        .ok_or_else(|| Failure::new(format!("{name} was not recorded"), "report this as a fault"))
}
