//! The comparison: its job, its steps and its result.

use crate::Error;
use crate::drive::{self, ComparedDrive};
use crate::models::{self, ComparedModel, Controller, ControllerFile};
use crate::outcome::{self, Outcome};
use crate::plants::{Plant, Setting};
use crate::runs::ComparedRun;
use crate::step::coupling_of_host;
use crate::truth::{self, Limits, Truth};
use crate::verdict::{Compared, Verdict};
use steerwright_control::{DesignOptions, paths};
use steerwright_drivelog::DriveLog;
use steerwright_formats::{LoopCoupling, Path as PathFile, SourceFile};
use steerwright_sweep::Class;
use steerwright_sysid::IdentifyOptions;

/// Models whose speeds differ by a smaller share have one speed.
const SAME_SPEED: f64 = 0.02;
/// Beyond this share of its speed a model is not valid.
const HOLDS_WITHIN: f64 = 0.2;
/// Lateral acceleration beyond which tyres are far from linear, m/s².
const LINEAR_UP_TO: f64 = 6.0;

/// The options of a comparison.
#[allow(missing_docs)]
pub struct Job {
    /// Two or more, or one with two controllers.
    pub models: Vec<ComparedModel>,
    /// A controller is designed for each model without one.
    pub controllers: Vec<ControllerFile>,
    pub design: DesignOptions,
    pub truth: Option<Truth>,
    pub drive: Option<(DriveLog, IdentifyOptions)>,
    pub road: Road,
    /// Growth of the path follower's integral, 1/s; by default the road's.
    pub cross_track_integral_per_s: Option<f64>,
    pub coupling: LoopCoupling,
    /// A cross-track error beyond this is off the path, m.
    pub max_cross_track_error_m: f64,
}

/// What to drive along.
#[allow(missing_docs)]
pub enum Road {
    File(Box<PathFile>, SourceFile),
    Standard {
        shape: Shape,
        /// Speed, m/s; by default that of the models.
        speed: Option<f64>,
        /// Largest lateral acceleration, m/s².
        lateral_acceleration: f64,
    },
}

/// The standard roads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A double lane change of 3.5 m, then an S-curve of 40° to each side
    Reference,
    /// The double lane change alone
    LaneChange,
    /// The S-curve alone
    SCurve,
}

/// The result.
#[allow(missing_docs)]
pub struct Comparison {
    pub models: Vec<ComparedModel>,
    pub controllers: Vec<Controller>,
    /// The road; guidance is each controller's own.
    pub road: PathFile,
    /// The models' plants, and the truth after them.
    pub plants: Vec<Plant>,
    /// Controller by controller, in the order of the plants.
    pub runs: Vec<ComparedRun>,
    pub outcomes: Vec<Outcome>,
    pub drive: Option<ComparedDrive>,
    pub verdict: Verdict,
    pub coupling: LoopCoupling,
    /// A cross-track error beyond this is off the path, m.
    pub max_cross_track_error_m: f64,
    /// What limits the result.
    pub remarks: Vec<String>,
    pub sources: Vec<SourceFile>,
}

impl Comparison {
    /// A controller on a plant.
    pub(crate) fn run(&self, controller: usize, plant: usize) -> &ComparedRun {
        &self.runs[controller * self.plants.len() + plant]
    }

    /// The outcome of a run.
    pub(crate) fn outcome(&self, run: &ComparedRun) -> &Outcome {
        &self.outcomes[run.controller * self.plants.len() + run.plant]
    }

    /// The place of the truth among the plants.
    pub(crate) fn truth(&self) -> Option<usize> {
        self.plants.iter().position(|p| p.model.is_none())
    }

    /// Largest lateral acceleration of the road, m/s².
    pub(crate) fn lateral_acceleration(&self) -> f64 {
        largest_curvature(&self.road) * self.road.speed_mps * self.road.speed_mps
    }

    /// Whether a controller is on the model that it was designed on.
    pub(crate) fn is_own(&self, run: &ComparedRun) -> bool {
        self.plants[run.plant].model == Some(self.controllers[run.controller].model)
    }

    pub(crate) fn length(&self) -> f64 {
        let points = &self.road.points;
        let from = points.first().map_or(0.0, |p| p.distance_m);
        points.last().map_or(0.0, |p| p.distance_m - from)
    }

    /// The worst outcome of a run.
    #[must_use]
    pub fn worst(&self) -> Class {
        self.outcomes.iter().map(|j| j.outcome).max().unwrap_or(Class::Met)
    }
}

/// Compares.
///
/// # Errors
/// Models, controllers, road and truth that cannot be compared, and those of designing, packing and
/// running.
pub fn compare(job: Job) -> Result<Comparison, Error> {
    if job.max_cross_track_error_m <= 0.0 {
        return Err(Error::MaxCrossTrackError { metres: job.max_cross_track_error_m });
    }
    let Job { models, truth, .. } = job;
    let mut remarks = Vec::new();
    let mut sources: Vec<SourceFile> = models.iter().map(|m| m.source.clone()).collect();
    let speed = speed(&job.road, &models, &mut remarks)?;
    let mut road = match job.road {
        Road::File(path, source) => {
            sources.push(source);
            *path
        }
        Road::Standard { shape, lateral_acceleration, .. } => {
            let options = paths::RoadOptions::default();
            match shape {
                Shape::Reference => paths::reference_road(speed, lateral_acceleration)?,
                Shape::LaneChange => {
                    paths::double_lane_change(speed, lateral_acceleration, &options)?
                }
                Shape::SCurve => paths::s_curve(speed, lateral_acceleration, &options)?,
            }
        }
    };
    if let Some(gain) = job.cross_track_integral_per_s {
        road.guidance.cross_track_integral_gain_per_s = gain;
    }
    let drive = job.drive.as_ref();
    let drive = drive.map(|(log, options)| drive::validate(&models, log, options)).transpose()?;
    if let Some(drive) = &drive {
        remarks.extend(drive.remarks.iter().cloned());
        sources.extend(drive.sources.iter().cloned());
    }
    let limits = truth.as_ref().map(|truth| truth::limits(&truth.archive)).unwrap_or_default();
    let ratio = models.first().map_or(1.0, |m| m.design.steering_ratio);
    let (design, kept) = limits.applied(&job.design, ratio);
    let controllers = models::controllers(&models, job.controllers, &design, job.coupling)?;
    if controllers.iter().any(|c| c.source.is_none()) {
        remarks.extend(kept);
    }
    sources.extend(controllers.iter().filter_map(|c| c.source.clone()));
    steerable(&road, &models, &controllers)?;
    let lateral = largest_curvature(&road) * road.speed_mps * road.speed_mps;
    if lateral > LINEAR_UP_TO {
        remarks.push(format!(
            "the road needs up to {lateral:.1} m/s² of lateral acceleration: linear models have no \
             tyre that saturates"
        ));
    }
    for controller in &controllers {
        let design = &controller.pid.evidence;
        if !design.met {
            let text = "does not meet its specification on its own model";
            remarks.push(format!("the controller of {} {text}", controller.label));
        }
    }
    remarks.extend(models.iter().filter_map(ComparedModel::doubt));
    let archive = truth.map(|truth| {
        remarks.extend(truth.remark);
        let of_it = |s: &SourceFile| s.sha256 == truth.source.sha256;
        let akin = |m: &&ComparedModel| {
            of_it(&m.source) || m.document.provenance().is_some_and(|p| p.sources.iter().any(of_it))
        };
        remarks.extend(models.iter().filter(akin).map(|m| {
            let file = &truth.source.name;
            format!("the truth is made of {file}, as {} is: that favours it", m.label)
        }));
        sources.push(truth.source);
        truth.archive
    });
    let sample_time = controllers.first().map_or(0.01, |c| c.pid.sample_time_s);
    remarks.extend(archive.as_ref().and_then(|archive| truth::step_remark(archive, sample_time)));
    let setting = Setting {
        models: &models,
        controllers: &controllers,
        road: &road,
        coupling: coupling_of_host(job.coupling),
        max_cross_track_error_m: job.max_cross_track_error_m,
    };
    let plants = setting.plants(archive)?;
    let runs = setting.runs(&plants)?;
    let outcomes: Vec<Outcome> = runs
        .iter()
        .map(|run| {
            let limits = plants[run.plant].model.map_or(limits, |_| Limits::default());
            outcome::outcome_of_run(run, &controllers[run.controller], limits)
        })
        .collect();
    let verdict = Compared {
        controllers: &controllers,
        plants: &plants,
        runs: &runs,
        outcomes: &outcomes,
        drive: drive.as_ref(),
        models: &models,
    }
    .verdict();
    Ok(Comparison {
        verdict,
        models,
        controllers,
        road,
        plants,
        runs,
        outcomes,
        drive,
        coupling: job.coupling,
        max_cross_track_error_m: job.max_cross_track_error_m,
        remarks,
        sources,
    })
}

/// The speed to drive at: that of the road, the stated one, or that of the models.
fn speed(road: &Road, models: &[ComparedModel], remarks: &mut Vec<String>) -> Result<f64, Error> {
    let mut all: Vec<f64> = models.iter().map(|m| m.design.speed).collect();
    all.sort_by(f64::total_cmp);
    let (low, high) = (all.first().copied().unwrap_or(0.0), all.last().copied().unwrap_or(0.0));
    let speed = match road {
        Road::File(path, _) => path.speed_mps,
        Road::Standard { speed: Some(speed), .. } => *speed,
        Road::Standard { speed: None, .. } if high <= low * (1.0 + SAME_SPEED) => {
            // The same whatever the order of the models.
            let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
            (10.0 * mean).round() / 10.0
        }
        Road::Standard { .. } => {
            return Err(Error::Speeds { low_mps: low, high_mps: high });
        }
    };
    for model in models {
        let own = model.design.speed;
        let apart = (speed / own - 1.0).abs();
        let text = format!("is of {own:.2} m/s, the road is driven at {speed:.2} m/s");
        if apart > HOLDS_WITHIN {
            return Err(Error::OtherSpeed {
                model: model.path.display().to_string(),
                model_mps: own,
                road_mps: speed,
            });
        }
        if apart > SAME_SPEED {
            remarks.push(format!("{} {text}", model.label));
        }
    }
    Ok(speed)
}

fn largest_curvature(road: &PathFile) -> f64 {
    road.points.iter().map(|p| p.curvature_per_m.abs()).fold(0.0, f64::max)
}

/// Rejects a road that is tighter than a controller may steer.
fn steerable(
    road: &PathFile,
    models: &[ComparedModel],
    controllers: &[Controller],
) -> Result<(), Error> {
    let curvature = largest_curvature(road);
    for controller in controllers {
        let Some(model) = models.get(controller.model) else { continue };
        let angle = curvature * road.speed_mps / model.design.gain();
        let limit = controller.pid.limits.max_angle_rad;
        if angle > limit {
            return Err(Error::TightRoad {
                radius_m: 1.0 / curvature,
                needed_deg: angle.to_degrees(),
                model: model.label.clone(),
                limit_deg: limit.to_degrees(),
            });
        }
    }
    Ok(())
}
