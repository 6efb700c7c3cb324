//! The closed loops of the comparison: every controller on every plant, as packed FMUs.

use crate::models::Controller;
use crate::plants::{Plant, Setting};
use crate::step::{step_of, ticks_before_step};
use crate::track::{CONTROLLER, Loop, add, drive_at, name_of};
use crate::{Error, packed};
use steerwright_control::model_behind;
use steerwright_formats::{Document, Path as PathFile, StepMetrics};
use steerwright_host::{Archive, Connection, Recording, System};
use steerwright_report::{StepResponse, Track, TrackErrors};

/// A controller on a plant.
#[allow(missing_docs)]
pub struct ComparedRun {
    pub controller: usize,
    pub plant: usize,
    /// All outputs and free inputs along the road.
    pub csv: String,
    pub track: Track,
    pub errors: TrackErrors,
    pub effort: Effort,
    /// Where the path was left, m along it.
    pub off_path_at_m: Option<f64>,
    /// The specification's step.
    pub step: StepMetrics,
    /// Yaw and steering of the step.
    pub response: StepResponse,
    /// Of the linear loop; absent where the plant has none.
    pub modulus_margin: Option<f64>,
}

/// The commanded steering angle of a run, in steering coordinates.
#[derive(Clone, Copy)]
#[allow(missing_docs)]
pub struct Effort {
    pub angle_max_rad: f64,
    pub rate_rms_radps: f64,
    pub rate_max_radps: f64,
}

impl Setting<'_> {
    /// Every controller on every plant, controller by controller.
    pub(crate) fn runs(&self, plants: &[Plant]) -> Result<Vec<ComparedRun>, Error> {
        let mut runs = Vec::new();
        for (index, controller) in self.controllers.iter().enumerate() {
            let road = self.road_for(controller);
            let path = packed::archive(&road.to_json(), "the road")?;
            let pid = packed::archive(&controller.pid.to_json(), "the controller")?;
            for (place, plant) in plants.iter().enumerate() {
                let run = self.run((index, controller), (place, plant), &road, &path, &pid);
                let what = format!("the controller of {} on {}", controller.label, plant.label);
                runs.push(run.map_err(|e| e.within(what))?);
            }
        }
        Ok(runs)
    }

    /// The road with a controller's guidance.
    pub(crate) fn road_for(&self, controller: &Controller) -> PathFile {
        PathFile { guidance: controller.guidance(self.road), ..self.road.clone() }
    }

    fn run(
        &self,
        (controller_index, controller): (usize, &Controller),
        (plant_index, plant): (usize, &Plant),
        road: &PathFile,
        path: &Archive,
        pid: &Archive,
    ) -> Result<ComparedRun, Error> {
        let step = controller.pid.sample_time_s;
        let actuator =
            plant.model.and_then(|model| controller.actuator_before(model, &self.models[model]));
        let behind = match (plant.model, actuator) {
            (Some(model), Some(_)) => {
                let model = &self.models[model];
                let document = model_behind(&model.document, actuator).to_json();
                Some(packed::archive(&document, &model.label)?)
            }
            _ => None,
        };
        let driven = behind.as_ref().unwrap_or(&plant.archive);
        let archives = Loop { plant: driven, path, controller: pid };
        let recording = archives.track(road, step, self.coupling, &plant.sideslip)?;
        let csv = recording.to_csv();
        let kept = with_pose_alone(recording, &name_of(driven));
        let track = Track::from_csv(kept.to_csv().as_bytes(), "the run")?;
        let (metrics, response) = self.step(driven, controller, pid)?;
        let margin = |model: usize| {
            let design = self.models[model].design.behind(actuator);
            steerwright_control::evaluate(&design, &controller.pid)
        };
        let modulus_margin = plant.model.map(margin).transpose()?.map(|e| e.margins.modulus_margin);
        Ok(ComparedRun {
            controller: controller_index,
            plant: plant_index,
            errors: track.errors(),
            effort: Effort::from_track(&track),
            off_path_at_m: self.off_path_at(&track),
            csv,
            track,
            step: metrics,
            response,
            modulus_margin,
        })
    }

    /// The specification's step, at the road's speed.
    fn step(
        &self,
        plant: &Archive,
        controller: &Controller,
        pid: &Archive,
    ) -> Result<(StepMetrics, StepResponse), Error> {
        let name = name_of(plant);
        let mut system = System::new();
        add(&mut system, plant, &name)?;
        add(&mut system, pid, CONTROLLER)?;
        system.connect(Connection::new(&name, "yaw", CONTROLLER, "yaw"))?;
        let steering = "steering_angle";
        system.connect(Connection::new(CONTROLLER, steering, &name, steering))?;
        drive_at(&mut system, plant, self.road.speed_mps)?;
        // The steering offset is taken up before.
        let first = ticks_before_step(&controller.pid);
        let step = step_of(system, &name, &controller.pid, first, self.coupling)?;
        Ok((step.metrics, step.response))
    }

    /// Where the path is left: sideways, or short of its end by more than the way of a second.
    fn off_path_at(&self, track: &Track) -> Option<f64> {
        let at = |k: usize| track.distance_m.get(k).copied().unwrap_or(f64::NAN);
        let sideways = track
            .cross_track_error_m
            .iter()
            .position(|e| e.abs() > self.max_cross_track_error_m || e.is_nan());
        let (first, last) = (self.road.points.first()?, self.road.points.last()?);
        let length = last.distance_m - first.distance_m;
        let end = at(track.distance_m.len().saturating_sub(1));
        let short = end < length - self.road.speed_mps || end.is_nan();
        sideways.map(at).or(if short { Some(end) } else { None })
    }
}

/// The recording with the pose alone of another tool's plant, whose `distance` may be anything.
fn with_pose_alone(mut recording: Recording, plant: &str) -> Recording {
    let own =
        |name: &str| name.strip_prefix(plant).and_then(|n| n.strip_prefix('.')).map(str::to_owned);
    let keep: Vec<bool> = recording
        .names
        .iter()
        .map(|name| own(name).is_none_or(|v| matches!(v.as_str(), "x" | "y" | "yaw")))
        .collect();
    let mut kept = keep.iter();
    recording.names.retain(|_| kept.next().copied().unwrap_or(true));
    let mut kept = keep.iter();
    recording.units.retain(|_| kept.next().copied().unwrap_or(true));
    for row in &mut recording.rows {
        let mut kept = keep.iter();
        row.retain(|_| kept.next().copied().unwrap_or(true));
    }
    recording
}

impl Effort {
    fn from_track(track: &Track) -> Self {
        let angle = &track.steering_rad;
        let rates = angle
            .windows(2)
            .zip(track.time_s.windows(2))
            .map(|(u, t)| (u[1] - u[0]) / (t[1] - t[0]));
        let (sum, most) =
            rates.fold((0.0, 0.0_f64), |(sum, most), r| (sum + r * r, most.max(r.abs())));
        Self {
            angle_max_rad: angle.iter().fold(0.0, |m, u| u.abs().max(m)),
            rate_rms_radps: (sum / angle.len().saturating_sub(1).max(1) as f64).sqrt(),
            rate_max_radps: most,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a foreign plant calls `distance` is not the road's.
    #[test]
    fn of_a_plant_its_pose_is_kept_alone() {
        let names = ["car.distance", "car.x", "car.body.x", "ReferencePath.distance"];
        let recording = Recording {
            names: names.map(str::to_owned).to_vec(),
            units: vec![None; 4],
            times: vec![0.0],
            rows: vec![vec![1.0, 2.0, 3.0, 4.0]],
            initial_passes: 1,
            initially_settled: true,
        };
        let kept = with_pose_alone(recording, "car");
        assert_eq!(kept.names, ["car.x", "ReferencePath.distance"]);
        assert_eq!((kept.rows, kept.units.len()), (vec![vec![2.0, 4.0]], 2));
    }
}
