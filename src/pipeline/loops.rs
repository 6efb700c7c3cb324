//! Closed loops of the packed FMUs under a Gauss–Seidel master.

use crate::failure::Failure;
use crate::simulate::system_of;
use fmi2_host::{Archive, InputTable, Master, Recording, System};
use formats::{Path as PathFile, Pid, StepMetrics};
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
    pid: Option<Archive>,
}

/// The specification's step in the loop.
pub(super) struct Step {
    pub(super) csv: String,
    pub(super) response: StepResponse,
    pub(super) metrics: StepMetrics,
}

impl Archives {
    pub(super) fn new(plant: PathBuf) -> Result<Self, Failure> {
        Ok(Self { plant: Archive::open(plant)?, pid: None })
    }

    /// Takes the controller of the loops that follow.
    pub(super) fn pid(&mut self, archive: PathBuf) -> Result<(), Failure> {
        self.pid = Some(Archive::open(archive)?);
        Ok(())
    }

    /// Plant, path where there is one, controller, in the order of a loop without delay.
    fn system(&self, path: Option<&Archive>) -> Result<System, Failure> {
        let pid = self.pid.as_ref().ok_or_else(|| {
            Failure::new("no controller was packed", "pack the controller before the loop is run")
        })?;
        let mut system = system_of([Some(&self.plant), path, Some(pid)].into_iter().flatten())?;
        system.connect_by_name()?;
        Ok(system)
    }

    /// A step of the yaw reference, from rest on a straight course.
    pub(super) fn step(&self, pid: &Pid) -> Result<Step, Failure> {
        let s = &pid.specification;
        let ts = pid.sample_time_s;
        let before = (BEFORE_STEP_S / ts).round();
        let steps = before + (s.steady_state_time_s / ts).round();
        let mut system = self.system(None)?;
        let table = format!("time,{PID}.yaw_reference\n0,0\n{},{}\n", before * ts, s.step_rad);
        system.feed(InputTable::read(table.as_bytes(), "the step")?);
        let recording = system.run(Master::GaussSeidel, 0.0, steps * ts, ts)?;
        let column = |name: &str| column(&recording, name);
        let yaw = column("IdentifiedPlant.yaw")?;
        let steering = column("LateralPid.steering_angle")?;
        let first = before as usize;
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
        let mut system = self.system(Some(&archive))?;
        if let (Some(first), Some(last)) = (path.points.first(), path.points.last()) {
            system.set(PLANT, "initial_x", first.x_m)?;
            system.set(PLANT, "initial_y", first.y_m)?;
            system.set(PLANT, "initial_yaw", first.heading_rad)?;
            let steps = ((last.distance_m - first.distance_m) / path.speed_mps / ts).floor();
            system.record(&[
                "IdentifiedPlant.x",
                "IdentifiedPlant.y",
                "IdentifiedPlant.yaw",
                "IdentifiedPlant.yaw_rate",
                "ReferencePath.yaw_reference",
                "ReferencePath.steering_feedforward",
                "ReferencePath.cross_track_error",
                "ReferencePath.heading_error",
                "ReferencePath.curvature",
                "ReferencePath.distance",
                "LateralPid.steering_angle",
                "LateralPid.saturated",
            ])?;
            Ok(system.run(Master::GaussSeidel, 0.0, steps * ts, ts)?.to_csv())
        } else {
            Err(Failure::new("the path has no points", "make the path again"))
        }
    }
}

fn column(recording: &Recording, name: &str) -> Result<Vec<f64>, Failure> {
    recording
        .column(name)
        .ok_or_else(|| Failure::new(format!("{name} was not recorded"), "report this as a fault"))
}
