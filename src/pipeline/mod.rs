//! All stages for one drive: identify, bicycle, design, package, track, report.
//!
//! Every file is written on the way, so each stage can be run again by its own subcommand.

mod present;

use crate::commands::identify::Wanted;
use crate::documents::feasibility::Feasibility;
use crate::documents::gate::GateArguments;
use crate::failure::Failure;
use crate::output::traces::traces_csv;
use crate::terminal::progress::Progress;
use std::path::{Path, PathBuf};
use steerwright_comparison::Loop;
use steerwright_control::paths::{self, PointOptions};
use steerwright_control::{DesignOptions, DesignPlant};
use steerwright_drivelog::DriveLog;
use steerwright_formats::{
    Bicycle, Document, Model, Path as PathFile, Pid, SourceFile, StepMetrics, Structure,
};
use steerwright_host::{Archive, Coupling};
use steerwright_report::{StepResponse, Traces, Track, TrackErrors};
use steerwright_sysid::IdentifyOptions;

/// The inputs and options.
pub(crate) struct Job {
    pub(crate) log: DriveLog,
    pub(crate) wanted: Wanted,
    /// The validation data of the bicycle to compare with.
    pub(crate) validation: IdentifyOptions,
    pub(crate) design: DesignOptions,
    /// Vehicle data (TOML) for a bicycle model to compare with.
    pub(crate) vehicle: Option<Text>,
    /// Recorded points (CSV) of a road to track, in addition to the standard road.
    pub(crate) track: Option<Text>,
    /// Largest lateral acceleration on the standard road, m/s².
    pub(crate) lateral_acceleration: f64,
    /// Folder for everything, empty yet.
    pub(crate) folder: PathBuf,
    /// Where that folder will be.
    pub(crate) out: PathBuf,
    /// Whether a controller is designed on a model that failed validation.
    pub(crate) gate: GateArguments,
}

pub(crate) struct Text {
    pub(crate) name: String,
    pub(crate) text: String,
}

pub(crate) struct Built {
    pub(crate) model: Model,
    /// The table of the structures, where the data chose among some.
    pub(crate) structures: Option<String>,
    /// Fit of the bicycle model on the validation data, percent.
    pub(crate) bicycle_fit: Option<f64>,
    /// The controllers that could be designed: on the identified model, on the bicycle model.
    pub(crate) controllers: Vec<Controller>,
    /// Missing results, with the reasons.
    pub(crate) remarks: Vec<String>,
    /// The folder, and what was written into it.
    pub(crate) out: PathBuf,
    pub(crate) files: Vec<SourceFile>,
}

/// A controller and its results in closed loop with the packed IdentifiedPlant.
pub(crate) struct Controller {
    pub(crate) basis: Basis,
    pub(crate) pid: Pid,
    pub(crate) step: StepResponse,
    pub(crate) step_metrics: StepMetrics,
    /// With the specification's steering offset, which only a plant in state space has.
    pub(crate) offset_metrics: Option<StepMetrics>,
    pub(crate) runs: Vec<RoadRun>,
}

impl Controller {
    /// Whether both steps in the loop of the FMUs meet the specification.
    pub(crate) fn step_meets(&self) -> bool {
        let specification = &self.pid.specification;
        specification.is_met_by(&self.step_metrics)
            && self.offset_metrics.is_none_or(|m| specification.error_is_met_by(&m))
    }

    /// The warnings of its roads.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let mut all = Vec::new();
        for run in &self.runs {
            let on_road = format!("{} controller on {}", self.basis.name(), run.road);
            all.extend(run.warnings.iter().map(|warning| format!("{on_road}: {warning}")));
        }
        all
    }
}

pub(crate) struct RoadRun {
    pub(crate) road: &'static str,
    pub(crate) path: PathFile,
    pub(crate) track: Track,
    pub(crate) errors: TrackErrors,
    /// What the road needs beyond the controller, before it is driven.
    pub(crate) warnings: Vec<String>,
}

/// The model that a controller was designed on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Basis {
    Identified,
    Bicycle,
}

impl Basis {
    /// For tables and legends.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Identified => "identification-based",
            Self::Bicycle => "bicycle-based",
        }
    }

    /// The end of its files' names.
    fn suffix(self) -> &'static str {
        match self {
            Self::Identified => "",
            Self::Bicycle => "-from-bicycle",
        }
    }
}

const LOOP: &str = "LateralLoop";
/// The order in which the FMUs of these loops are stepped.
const COUPLING: Coupling = Coupling::GaussSeidel;
/// The page to read.
pub(crate) const PAGE: &str = "report.html";
/// Name of the road every drive is tried on.
pub(crate) const STANDARD_ROAD: &str = "road";
/// Name of the road recorded with the drive.
pub(crate) const RECORDED_ROAD: &str = "recorded";

/// The error of a structure without a response of the yaw rate to the steering.
fn no_loop(structure: Option<Structure>) -> Failure {
    let structure = structure.map_or("", Structure::name);
    Failure::new(
        format!("a model of the structure {structure} has no steering loop to build"),
        format!("identify it alone: steerwright identify --structure {structure}"),
    )
}

pub(crate) fn build(job: &Job) -> Result<Built, Failure> {
    let mut out = Writer::new(&job.folder);
    let name = &job.log.name;
    let progress = Progress::start(format!("{name}: identifying"));
    let mut remarks = Vec::new();

    let (identified, structures) = job.wanted.identify(&job.log)?;
    let (model, Some(signals)) = (identified.model, identified.traces) else {
        return Err(no_loop(job.wanted.structure()));
    };
    let source = out.model(&model)?;
    let bicycle = job.vehicle.as_ref().map(|v| bicycle_at_speed_of(&model, v)).transpose()?;
    let validated = bicycle
        .as_ref()
        .map(|b| steerwright_sysid::bicycle::validate_bicycle(&job.log, &job.validation, b))
        .transpose()?;
    let bicycle_trace = validated.as_ref().map(|j| j.simulated_yaw_rate_radps.as_slice());
    let traces = traces_csv(&signals, bicycle_trace);
    out.bytes("traces.csv", traces.as_bytes())?;

    let controllers = if job.gate.allows(model.quality()) {
        progress.now(format!("{name}: designing and running the loops of FMUs"));
        controllers(job, &mut out, (&model, source), bicycle.as_ref(), &mut remarks)?
    } else {
        // The loops would run on the identified plant, which does not represent the vehicle.
        remarks.push(
            "no controller is designed and no FMU is packed: the identified model failed validation"
                .into(),
        );
        Vec::new()
    };

    progress.now(format!("{name}: drawing"));
    let traces = Traces::from_csv(traces.as_bytes(), "traces.csv")?;
    let bicycle_fit = validated.map(|j| j.validation_fit);
    let mut built = Built {
        model,
        structures,
        bicycle_fit,
        controllers,
        remarks,
        out: job.out.clone(),
        files: Vec::new(),
    };
    present::write(&mut out, &built, bicycle.as_ref(), &traces)?;
    built.files = out.into_written();
    Ok(built)
}

/// Packs the models, and designs, packs and drives a controller for each.
fn controllers(
    job: &Job,
    out: &mut Writer,
    (model, source): (&Model, SourceFile),
    bicycle: Option<&Bicycle>,
    remarks: &mut Vec<String>,
) -> Result<Vec<Controller>, Failure> {
    let document = model.to_json();
    let mut archive = Archive::open(out.archive("fmu", &document)?)?;
    // The loops are of the vehicle that takes the command.
    let plant = DesignPlant::from_model(model);
    let design = plant.as_ref().map_or(job.design, |plant| job.design.with_actuator_of(plant));
    let commanded = &steerwright_control::model_behind(model, design.actuator);
    if design.actuator.is_some() {
        let packed = steerwright_comparison::pack(&commanded.to_json(), "the model", None)?;
        archive = Archive::from_bytes(&packed.bytes, "the model")?;
    }
    let roads = roads(job, model.speed_mps(), remarks)?;
    let mut bases = vec![(Basis::Identified, plant, source, document)];
    if let Some(bicycle) = bicycle {
        // Next to an identified one its files have other names.
        let (name, folder) = if model.structure() == Structure::Bicycle {
            ("bicycle-from-data.json", "fmu-from-bicycle")
        } else {
            ("bicycle.json", "fmu")
        };
        let source = out.document(name, bicycle)?;
        let document = bicycle.to_json();
        out.archive(folder, &document)?;
        bases.push((Basis::Bicycle, DesignPlant::from_bicycle(bicycle), source, document));
    }
    let mut controllers = Vec::new();
    // The bicycle is of the same vehicle, and its data have no actuator rate.
    let driven = bases.iter().filter_map(|(_, plant, ..)| plant.as_ref().ok());
    let options = driven.fold(design, |options, plant| options.with_rate_of(plant));
    for (basis, plant, source, document) in bases {
        // A model that no controller can be designed on is reported, and does not end the rest.
        let designed = plant.and_then(|plant| {
            steerwright_control::design(&plant, &source, &options).map(|pid| (plant, pid))
        });
        match designed {
            Ok((plant, mut pid)) => {
                steerwright_comparison::verify(&mut pid, &document, &plant)?;
                let controller = run_loops(out, (&archive, commanded), basis, pid, &roads)?;
                remarks.extend(controller.warnings());
                controllers.push(controller);
            }
            Err(error) => {
                remarks.push(format!("no {} controller: {error}", basis.name()));
            }
        }
    }
    Ok(controllers)
}

/// The bicycle model at the speed of the drive, which is where the two are compared.
fn bicycle_at_speed_of(model: &Model, vehicle: &Text) -> Result<Bicycle, Failure> {
    let written = steerwright_control::bicycle_from_toml(&vehicle.text, &vehicle.name)?;
    let Some(speed_mps) = model.speed_mps() else { return Ok(written) };
    let data = steerwright_formats::VehicleData { speed_mps, ..written.vehicle };
    let mut bicycle = steerwright_control::bicycle(&data)?;
    bicycle.provenance = written.provenance;
    Ok(bicycle)
}

/// The standard road and, where points were recorded, theirs.
fn roads(
    job: &Job,
    speed: Option<f64>,
    remarks: &mut Vec<String>,
) -> Result<Vec<(&'static str, PathFile)>, Failure> {
    let Some(speed) = speed else {
        remarks.push("no road is tracked: the log has no speed".into());
        return Ok(Vec::new());
    };
    let mut roads = vec![(STANDARD_ROAD, paths::reference_road(speed, job.lateral_acceleration)?)];
    if let Some(Text { name, text }) = &job.track {
        let options = PointOptions { name: name.clone(), speed, ..PointOptions::default() };
        let recorded = paths::path_from_recording(text, name, &options)?;
        remarks.extend(recorded.warnings.iter().map(|w| format!("{name}: {w}")));
        remarks.extend(recorded.excess.map(|excess| format!("{name}: {excess}")));
        let mut path = recorded.path;
        path.provenance.sources = vec![SourceFile::named(name.clone(), text.as_bytes())];
        roads.push((RECORDED_ROAD, path));
    }
    Ok(roads)
}

/// Packs a controller with its roads and runs the loops of the packed FMUs.
fn run_loops(
    out: &mut Writer,
    (archive, model): (&Archive, &Model),
    basis: Basis,
    pid: Pid,
    roads: &[(&'static str, PathFile)],
) -> Result<Controller, Failure> {
    let suffix = basis.suffix();
    let folder = format!("fmu{suffix}");
    out.document(&format!("pid{suffix}.json"), &pid)?;
    let controller = Archive::open(out.archive(&folder, &pid.to_json())?)?;

    let step = steerwright_comparison::yaw_step(archive, &controller, &pid, COUPLING)?;
    out.bytes(&format!("step{suffix}.csv"), step.csv.as_bytes())?;
    let with_offset =
        steerwright_comparison::yaw_step_with_offset(model, &controller, &pid, COUPLING)?;
    if let Some(step) = &with_offset {
        out.bytes(&format!("step-with-offset{suffix}.csv"), step.csv.as_bytes())?;
    }
    let mut runs = Vec::new();
    for (road, path) in roads {
        let mut path = path.clone();
        let speed = path.speed_mps;
        let sideslip = steerwright_control::model_sideslip(model, Some(speed))?.unwrap_or_default();
        let guidance = steerwright_control::guidance_for(&pid, speed);
        path.guidance = steerwright_control::with_sideslip(guidance, &sideslip, speed);
        // The standard road is in the folder of the controller, others are in folders next to it.
        let own = if *road == STANDARD_ROAD { String::new() } else { format!("-{road}") };
        let (result, folder) = (format!("result{own}{suffix}.csv"), format!("{folder}{own}"));
        out.document(&format!("path{own}{suffix}.json"), &path)?;
        let path_archive = Archive::open(out.archive(&folder, &path.to_json())?)?;
        let documents = [model.to_json(), path.to_json(), pid.to_json()];
        let named = documents.each_ref().map(|text| (text.as_str(), folder.as_str()));
        let wired = steerwright_comparison::pack_loop(LOOP, &named, None)?;
        out.bytes(&format!("{folder}/{LOOP}.ssp"), &wired.bytes)?;
        let run = Loop { plant: archive, path: &path_archive, controller: &controller };
        let csv =
            run.track(&path, pid.sample_time_s, COUPLING, &sideslip.at_speed(speed))?.to_csv();
        out.bytes(&result, csv.as_bytes())?;
        let track = Track::from_csv(csv.as_bytes(), &result)?;
        let errors = track.errors();
        let warnings = Feasibility::new(&path, &pid, Some(model))?.warnings;
        runs.push(RoadRun { road, path, track, errors, warnings });
    }
    Ok(Controller {
        basis,
        pid,
        step: step.response,
        step_metrics: step.metrics,
        offset_metrics: with_offset.map(|step| step.metrics),
        runs,
    })
}

/// Writes files below a new folder and keeps the list.
pub(crate) struct Writer {
    folder: PathBuf,
    written: Vec<SourceFile>,
}

impl Writer {
    pub(crate) fn new(folder: &Path) -> Self {
        Self { folder: folder.into(), written: Vec::new() }
    }

    /// Writes bytes under a name relative to the folder.
    pub(crate) fn bytes(&mut self, name: &str, bytes: &[u8]) -> Result<PathBuf, Failure> {
        let path = self.folder.join(name);
        let folder = path.parent().unwrap_or(&self.folder);
        std::fs::create_dir_all(folder)
            .and_then(|()| std::fs::write(&path, bytes))
            .map_err(|e| Failure::file(&path, &e))?;
        self.written.push(SourceFile::named(name, bytes));
        Ok(path)
    }

    /// Writes a document; returns its reference for the files made from it.
    pub(crate) fn document<D: Document>(
        &mut self,
        name: &str,
        document: &D,
    ) -> Result<SourceFile, Failure> {
        document.checked(name)?;
        let text = document.to_json();
        self.bytes(name, text.as_bytes())?;
        Ok(SourceFile::from_bytes(Path::new(name), text.as_bytes()))
    }

    /// As [`Writer::document`], under the usual name.
    fn model(&mut self, model: &Model) -> Result<SourceFile, Failure> {
        let (name, text) = (model.structure().file_name(), model.to_json());
        model.checked(&name)?;
        self.bytes(&name, text.as_bytes())?;
        Ok(SourceFile::from_bytes(Path::new(&name), text.as_bytes()))
    }

    /// Packs a document's FMU into a folder below.
    fn archive(&mut self, folder: &str, document: &str) -> Result<PathBuf, Failure> {
        let packed = steerwright_comparison::pack(document, folder, None)?;
        self.bytes(&format!("{folder}/{}.fmu", packed.fmu.name()), &packed.bytes)
    }

    pub(crate) fn into_written(self) -> Vec<SourceFile> {
        self.written
    }

    /// The files written so far.
    pub(crate) fn written(&self) -> &[SourceFile] {
        &self.written
    }
}
