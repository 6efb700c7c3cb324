//! Models and controllers beside each other (the paper's Fig. 3, 5, 6 and 7).
//!
//! Each model is judged on a drive; a controller is taken or designed for each; every controller
//! follows one road on the plant of every model and on the truth, all as packed FMUs under the
//! master. What is the same for all: the specification, the road, the rule by which look-ahead,
//! preview and feedforward follow from a controller, and the sideslip that the path follower reckons
//! with, which is read for each plant in a turn.

mod drive;
mod loops;
mod models;
mod outcome;
mod overview;
mod page;
mod present;
mod tell;
mod truth;
mod verdict;

use crate::failure::Failure;
use crate::gate::GateArguments;
use control::{DesignOptions, Master, paths};
use drivelog::DriveLog;
use fmi2_host::Master as HostMaster;
use formats::{Guidance, Path as PathFile, SourceFile};
use std::path::PathBuf;
use sweep::Class;
use sysid::IdentifyOptions;

pub(crate) use drive::Drive;
pub(crate) use loops::{Plant, Run, Setting};
pub(crate) use models::{Controller, Model};
pub(crate) use outcome::Judgement;
pub(crate) use overview::json;
pub(crate) use present::write;
pub(crate) use tell::text;
pub(crate) use verdict::Verdict;

use truth::Limits;
use verdict::Judged;

/// Models of speeds within this share of each other are taken for models of one speed.
const SAME_SPEED: f64 = 0.02;
/// Beyond this a model does not hold.
const HOLDS_WITHIN: f64 = 0.2;
/// Lateral acceleration beyond which tyres are far from linear, m/s².
const LINEAR_UP_TO: f64 = 6.0;

/// What to compare.
pub(crate) struct Job {
    pub(crate) models: Vec<PathBuf>,
    pub(crate) pids: Vec<String>,
    pub(crate) design: DesignOptions,
    pub(crate) truth: Option<PathBuf>,
    pub(crate) drive: Option<(DriveLog, IdentifyOptions)>,
    pub(crate) road: Road,
    /// By default the road's.
    pub(crate) cross_track_integral_per_s: Option<f64>,
    pub(crate) master: Master,
    /// Whether models that failed validation are compared.
    pub(crate) gate: GateArguments,
    pub(crate) max_cross_track_error_m: f64,
}

/// What to drive along.
pub(crate) enum Road {
    /// A path file.
    File(Box<PathFile>, SourceFile),
    /// A road of its own, at a speed or that of the models.
    Standard { shape: Shape, speed: Option<f64>, lateral_acceleration: f64 },
}

/// The standard roads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Shape {
    /// A double lane change of 3.5 m, then an S-curve of 40° to each side
    Reference,
    /// The double lane change alone
    LaneChange,
    /// The S-curve alone
    SCurve,
}

/// What came out.
pub(crate) struct Comparison {
    pub(crate) models: Vec<Model>,
    pub(crate) controllers: Vec<Controller>,
    pub(crate) road: PathFile,
    pub(crate) plants: Vec<Plant>,
    /// Controller by controller, in the order of the plants.
    pub(crate) runs: Vec<Run>,
    /// What became of each run.
    pub(crate) judgements: Vec<Judgement>,
    pub(crate) drive: Option<Drive>,
    pub(crate) verdict: Verdict,
    pub(crate) master: Master,
    pub(crate) max_cross_track_error_m: f64,
    pub(crate) remarks: Vec<String>,
    /// The files that were read.
    pub(crate) sources: Vec<SourceFile>,
}

impl Comparison {
    pub(crate) fn run(&self, controller: usize, plant: usize) -> &Run {
        &self.runs[controller * self.plants.len() + plant]
    }

    pub(crate) fn judgement(&self, run: &Run) -> &Judgement {
        &self.judgements[run.controller * self.plants.len() + run.plant]
    }

    /// The place of the truth among the plants.
    pub(crate) fn truth(&self) -> Option<usize> {
        self.plants.iter().position(|p| p.model.is_none())
    }

    /// Largest lateral acceleration that the road asks for, m/s².
    pub(crate) fn lateral_acceleration(&self) -> f64 {
        largest_curvature(&self.road) * self.road.speed_mps * self.road.speed_mps
    }

    /// Whether a controller is on the model that it was designed on.
    fn is_own(&self, run: &Run) -> bool {
        self.plants[run.plant].model == Some(self.controllers[run.controller].model)
    }

    fn master_name(&self) -> &'static str {
        match self.master {
            Master::GaussSeidel => "gauss-seidel",
            Master::Jacobi => "jacobi",
        }
    }

    fn length(&self) -> f64 {
        let points = &self.road.points;
        let from = points.first().map_or(0.0, |p| p.distance_m);
        points.last().map_or(0.0, |p| p.distance_m - from)
    }

    /// The worst that became of a run.
    pub(crate) fn worst(&self) -> Class {
        self.judgements.iter().map(|j| j.outcome).max().unwrap_or(Class::Met)
    }
}

/// A controller's guidance along the road; how fast the integral grows is the road's.
fn guidance(road: &PathFile, controller: &Controller) -> Guidance {
    Guidance {
        cross_track_integral_gain_per_s: road.guidance.cross_track_integral_gain_per_s,
        ..control::guidance_for(&controller.pid, road.speed_mps)
    }
}

/// Compares.
pub(crate) fn compare(job: &Job) -> Result<Comparison, Failure> {
    if job.max_cross_track_error_m <= 0.0 {
        let hint = "give what is left of the lane, such as 1.75m";
        return Err(Failure::new("--max-cross-track-error must be greater than 0", hint));
    }
    let models = models::read(&job.models, job.gate)?;
    let mut remarks = Vec::new();
    let mut sources: Vec<SourceFile> = models.iter().map(|m| m.source.clone()).collect();
    let speed = speed(job, &models, &mut remarks)?;
    let mut road = match &job.road {
        Road::File(path, source) => {
            sources.push(source.clone());
            (**path).clone()
        }
        Road::Standard { shape, lateral_acceleration, .. } => {
            let options = paths::RoadOptions::default();
            match shape {
                Shape::Reference => paths::reference_road(speed, *lateral_acceleration)?,
                Shape::LaneChange => {
                    paths::double_lane_change(speed, *lateral_acceleration, &options)?
                }
                Shape::SCurve => paths::s_curve(speed, *lateral_acceleration, &options)?,
            }
        }
    };
    if let Some(gain) = job.cross_track_integral_per_s {
        road.guidance.cross_track_integral_gain_per_s = gain;
    }
    let drive = match &job.drive {
        Some((log, options)) => Some(drive::judge(&models, log, options)?),
        None => None,
    };
    if let Some(drive) = &drive {
        remarks.extend(drive.remarks.iter().cloned());
        sources.extend(drive.sources.iter().cloned());
    }
    let truth = job.truth.as_deref().map(truth::read).transpose()?;
    let limits = truth.as_ref().map(|truth| truth::limits(&truth.archive)).unwrap_or_default();
    let ratio = models.first().map_or(1.0, |m| m.design.steering_ratio);
    let (design, kept) = limits.applied(&job.design, ratio);
    let controllers = models::controllers(&models, &job.pids, &design, job.master)?;
    if controllers.iter().any(|c| c.source.is_none()) {
        remarks.extend(kept);
    }
    sources.extend(controllers.iter().filter_map(|c| c.source.clone()));
    steerable(&road, &models, &controllers)?;
    let lateral = largest_curvature(&road) * road.speed_mps * road.speed_mps;
    if lateral > LINEAR_UP_TO {
        remarks.push(format!(
            "the road asks for up to {lateral:.1} m/s2 of lateral acceleration: linear models know of \
             no tyre that gives way"
        ));
    }
    for controller in &controllers {
        let design = &controller.pid.evidence;
        if !design.met {
            let text = "does not meet its specification on its own model";
            remarks.push(format!("the controller of {} {text}", controller.label));
        }
    }
    remarks.extend(models.iter().filter_map(Model::doubt));
    let archive = truth.map(|truth| {
        remarks.extend(truth.remark);
        let of_it = |s: &SourceFile| s.sha256 == truth.source.sha256;
        let akin = |m: &&Model| of_it(&m.source) || m.provenance().sources.iter().any(of_it);
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
        master: match job.master {
            Master::GaussSeidel => HostMaster::GaussSeidel,
            Master::Jacobi => HostMaster::Jacobi,
        },
        max_cross_track_error_m: job.max_cross_track_error_m,
    };
    let plants = setting.plants(archive)?;
    let runs = setting.runs(&plants)?;
    let judgements: Vec<Judgement> = runs
        .iter()
        .map(|run| {
            let limits = plants[run.plant].model.map_or(limits, |_| Limits::default());
            outcome::of(run, &controllers[run.controller], limits)
        })
        .collect();
    let verdict = Judged {
        controllers: &controllers,
        plants: &plants,
        runs: &runs,
        judgements: &judgements,
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
        judgements,
        drive,
        master: job.master,
        max_cross_track_error_m: job.max_cross_track_error_m,
        remarks,
        sources,
    })
}

/// The speed to drive at: the road's, the one asked for, or that of the models.
fn speed(job: &Job, models: &[Model], remarks: &mut Vec<String>) -> Result<f64, Failure> {
    let mut all: Vec<f64> = models.iter().map(|m| m.design.speed).collect();
    all.sort_by(f64::total_cmp);
    let (low, high) = (all.first().copied().unwrap_or(0.0), all.last().copied().unwrap_or(0.0));
    let speed = match &job.road {
        Road::File(path, _) => path.speed_mps,
        Road::Standard { speed: Some(speed), .. } => *speed,
        Road::Standard { speed: None, .. } if high <= low * (1.0 + SAME_SPEED) => {
            // The same whatever the order of the models.
            let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
            (10.0 * mean).round() / 10.0
        }
        Road::Standard { .. } => {
            return Err(Failure::new(
                format!("the models are of speeds from {low:.2} to {high:.2} m/s"),
                "give the speed to compare them at with --road-speed, or make a bicycle.json of the \
                 other's speed",
            ));
        }
    };
    for model in models {
        let own = model.design.speed;
        let apart = (speed / own - 1.0).abs();
        let text = format!("is of {own:.2} m/s, the road is driven at {speed:.2} m/s");
        if apart > HOLDS_WITHIN {
            return Err(Failure::new(
                format!("{} {text}", model.path.display()),
                "a model holds near its own speed: identify it from a drive at that speed, make \
                 the bicycle.json with it, or give another --road-speed",
            ));
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

/// Refuses a road that is tighter than a controller may steer.
fn steerable(road: &PathFile, models: &[Model], controllers: &[Controller]) -> Result<(), Failure> {
    let curvature = largest_curvature(road);
    for controller in controllers {
        let Some(model) = models.get(controller.model) else { continue };
        let angle = curvature * road.speed_mps / model.design.gain();
        let limit = controller.pid.limits.max_angle_rad;
        if angle > limit {
            return Err(Failure::new(
                format!(
                    "the road's radius of {:.1} m asks {:.1} deg of steering of {}, whose controller \
                     may steer {:.1} deg",
                    1.0 / curvature,
                    angle.to_degrees(),
                    model.label,
                    limit.to_degrees()
                ),
                "drive a wider road, or a standard one with less --lateral-acceleration; the limit \
                 is --max-angle of the design",
            ));
        }
    }
    Ok(())
}
