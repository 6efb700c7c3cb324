//! Closed loops of the packed FMUs under a Gauss–Seidel master.

use crate::failure::Failure;
use crate::fmu_track::Loop;
use crate::{fmu_step, package};
use control::Sideslip;
use fmi2_host::{Archive, Coupling};
use formats::{Document, Path as PathFile, Pid, Plant, StepMetrics};
use report::StepResponse;
use std::path::{Path, PathBuf};

/// How long the loop holds its course before the step: the integral action takes up the plant's
/// steering offset meanwhile, as it would on the road.
pub(crate) const BEFORE_STEP_S: f64 = 10.0;

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

    fn controller(&self) -> Result<&Archive, Failure> {
        self.pid.as_ref().ok_or_else(|| {
            Failure::new("no controller was packed", "pack the controller before the loop is run")
        })
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
        let step = fmu_step::step(plant, self.controller()?, pid, first, Coupling::GaussSeidel)?;
        Ok(Step {
            csv: step.csv,
            response: StepResponse {
                time_s: step.trace.time,
                yaw_rad: step.trace.yaw,
                steering_rad: step.trace.steering,
            },
            metrics: step.metrics,
        })
    }

    /// A run along a path, from its first point to its end; the trajectory as CSV.
    pub(super) fn track(
        &self,
        archive: &Path,
        path: &PathFile,
        ts: f64,
    ) -> Result<String, Failure> {
        let path_archive = Archive::open(archive)?;
        let (plant, controller) = (&self.plant, self.controller()?);
        let run = Loop { plant, path: &path_archive, controller };
        let sideslip = Sideslip::in_guidance(&path.guidance);
        Ok(run.track(path, ts, Coupling::GaussSeidel, &sideslip)?.to_csv())
    }
}
