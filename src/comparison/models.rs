//! The models that are compared, and the controllers that were designed on them or are.

use crate::design::read_plant;
use crate::failure::{Failure, design_hint};
use crate::files;
use crate::gate::GateArguments;
use control::{DesignOptions, DesignPlant, Master};
use formats::{Bicycle, Document, Pid, Plant, Provenance, SourceFile, StepMetrics};
use std::path::{Path, PathBuf};

/// Ratios of one car may be known to a few percent; 1 and 15 are two places.
const SAME_PLACE: f64 = 1.25;

/// A model and its file.
pub(crate) struct Model {
    /// Short, and unlike the others'.
    pub(crate) label: String,
    pub(crate) path: PathBuf,
    pub(crate) source: SourceFile,
    pub(crate) document: Kind,
    pub(crate) design: DesignPlant,
}

/// What a model is.
pub(crate) enum Kind {
    Identified(Box<Plant>),
    Bicycle(Box<Bicycle>),
}

/// A controller and the model that it was designed on.
pub(crate) struct Controller {
    /// Short, and unlike the others'.
    pub(crate) label: String,
    /// Which of the models.
    pub(crate) model: usize,
    pub(crate) pid: Pid,
    /// Its file; absent where it was designed here.
    pub(crate) source: Option<SourceFile>,
    /// The specification's step on the model, in the order of the master.
    pub(crate) predicted: StepMetrics,
}

impl Model {
    pub(crate) fn text(&self) -> String {
        match &self.document {
            Kind::Identified(plant) => plant.to_json(),
            Kind::Bicycle(bicycle) => bicycle.to_json(),
        }
    }

    pub(crate) fn provenance(&self) -> &Provenance {
        match &self.document {
            Kind::Identified(plant) => &plant.provenance,
            Kind::Bicycle(bicycle) => &bicycle.provenance,
        }
    }

    /// Why a design on it may mean little, where its evidence says so.
    pub(crate) fn doubt(&self) -> Option<String> {
        let quality = match &self.document {
            Kind::Identified(plant) => &plant.quality,
            Kind::Bicycle(bicycle) => &bicycle.quality,
        };
        let message =
            || format!("the quality of {} is {}: {}", self.label, quality.grade, quality.summary);
        (!quality.allows_design()).then(message)
    }

    /// For people.
    pub(crate) fn kind(&self) -> String {
        match &self.document {
            Kind::Identified(plant) => format!("identified, order {}", plant.order()),
            Kind::Bicycle(b) if b.evidence.is_some() => "bicycle, identified".into(),
            Kind::Bicycle(_) => "bicycle, vehicle data".into(),
        }
    }
}

/// Reads the models, of which each must be trusted. Those of one comparison must mean the same steering angle.
pub(crate) fn read(paths: &[PathBuf], gate: GateArguments) -> Result<Vec<Model>, Failure> {
    let mut models: Vec<Model> = Vec::new();
    for (path, label) in paths.iter().zip(labels(paths)) {
        let (design, source, text) = read_plant(path, gate)?;
        let file = path.display().to_string();
        let document = if design.model == "bicycle" {
            Kind::Bicycle(Box::new(Bicycle::from_json(&text, &file)?))
        } else {
            Kind::Identified(Box::new(Plant::from_json(&text, &file)?))
        };
        let path = path.clone();
        models.push(Model { label, path, source, document, design });
    }
    let by_ratio =
        |a: &&Model, b: &&Model| a.design.steering_ratio.total_cmp(&b.design.steering_ratio);
    if let (Some(low), Some(high)) =
        (models.iter().min_by(by_ratio), models.iter().max_by(by_ratio))
        && high.design.steering_ratio > SAME_PLACE * low.design.steering_ratio
    {
        return Err(Failure::new(
            format!(
                "{} has a steering ratio of {}, {} of {}",
                high.path.display(),
                high.design.steering_ratio,
                low.path.display(),
                low.design.steering_ratio
            ),
            "models are compared on one steering angle, that of the steering wheel or that of the \
             road wheel: make one of them again with the other's steering ratio",
        ));
    }
    Ok(models)
}

/// Names of files, with as much of their folders as tells them apart, without their extensions.
fn labels(paths: &[PathBuf]) -> Vec<String> {
    let tail = |path: &PathBuf, count: usize| {
        let parts: Vec<String> = path
            .with_extension("")
            .components()
            .map(|c| c.as_os_str().to_string_lossy().into_owned())
            .collect();
        parts[parts.len().saturating_sub(count)..].join("/")
    };
    // At most a few folders: what leads to them is the machine's own.
    let named = |count| paths.iter().map(|p| tail(p, count)).collect::<Vec<_>>();
    let unlike = |names: &[String]| (1..names.len()).all(|k| !names[..k].contains(&names[k]));
    let found = (1..=3).map(named).find(|names| unlike(names));
    found.unwrap_or_else(|| {
        let names = named(1);
        names.iter().enumerate().map(|(k, name)| format!("{name} ({})", k + 1)).collect()
    })
}

/// The controllers: those of the files, each with the model whose hash it carries or that is named
/// before `=`, and for every other model one that is designed here.
pub(crate) fn controllers(
    models: &[Model],
    pids: &[String],
    options: &DesignOptions,
    master: Master,
) -> Result<Vec<Controller>, Failure> {
    let mut found = Vec::new();
    for argument in pids {
        let named = argument.split_once('=').and_then(|(model, file)| {
            let is_it = |m: &Model| m.label == model || m.path.as_os_str() == model;
            Some((models.iter().position(is_it)?, file))
        });
        let file = Path::new(named.map_or(argument.as_str(), |(_, file)| file));
        let (pid, source) = files::read_document::<Pid>(file)?;
        let by_hash = || models.iter().position(|m| m.source.sha256 == pid.designed_for.sha256);
        let Some(model) = named.map(|(model, _)| model).or_else(by_hash) else {
            return Err(Failure::new(
                format!("{}: designed on another file than any given", file.display()),
                format!(
                    "give the model it was designed on, or name the one it goes with, as in \
                     --pid {}={}",
                    models.first().map_or("plant", |m| &m.label),
                    file.display()
                ),
            ));
        };
        found.push((model, file.to_path_buf(), pid, source));
    }
    let mut all: Vec<Controller> = Vec::new();
    // The models are of one vehicle: a data sheet takes the rate of the others' drive.
    let designs = models.iter().map(|m| &m.design);
    let options = designs.fold(*options, |options, design| options.with_rate_of(design));
    for (index, model) in models.iter().enumerate() {
        let mut own: Vec<_> = found.extract_if(.., |(of, ..)| *of == index).collect();
        if own.is_empty() {
            let pid = control::design(&model.design, &model.source, &options)
                .map_err(|e| Failure::in_file(&model.path, &e, design_hint(&e)))?;
            all.push(Controller::new(model.label.clone(), (index, model), pid, None, master)?);
            continue;
        }
        let files: Vec<PathBuf> = own.iter().map(|(_, file, ..)| file.clone()).collect();
        let several = own.len() > 1;
        for ((_, file, pid, source), name) in own.drain(..).zip(labels(&files)) {
            let label =
                if several { format!("{} ({name})", model.label) } else { model.label.clone() };
            let controller = Controller::new(label, (index, model), pid, Some(source), master);
            all.push(controller.map_err(|e| e.about(file.display()))?);
        }
    }
    if all.len() < 2 {
        return Err(Failure::new(
            "there is one model with one controller: nothing to compare",
            "give two models, or two controllers with --pid",
        ));
    }
    let by_sample =
        |a: &&Controller, b: &&Controller| a.pid.sample_time_s.total_cmp(&b.pid.sample_time_s);
    if let (Some(low), Some(high)) = (all.iter().min_by(by_sample), all.iter().max_by(by_sample))
        && high.pid.sample_time_s > low.pid.sample_time_s * (1.0 + 1e-9)
    {
        return Err(Failure::new(
            format!(
                "the controller of {} has a sample time of {} s, that of {} of {} s",
                high.label, high.pid.sample_time_s, low.label, low.pid.sample_time_s
            ),
            "design them with the same --pid-sample-time: else the sample time is what is compared",
        ));
    }
    Ok(all)
}

impl Controller {
    fn new(
        label: String,
        (index, model): (usize, &Model),
        pid: Pid,
        source: Option<SourceFile>,
        master: Master,
    ) -> Result<Self, Failure> {
        // What this master adds to the loop, whatever the design reckoned with.
        let delay = match master {
            Master::GaussSeidel => 0.0,
            Master::Jacobi => pid.sample_time_s,
        };
        let predicted = control::step_metrics(&model.design, &pid, delay)?;
        Ok(Self { label, model: index, pid, source, predicted })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short_and_tell_apart() {
        let of = |paths: &[&str]| labels(&paths.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["plant.json", "/home/me/bicycle.json"]), ["plant", "bicycle"]);
        assert_eq!(of(&["/x/a/plant.json", "/x/b/plant.json"]), ["a/plant", "b/plant"]);
        // What leads to them is the machine's own.
        let deep = ["/p/a/b/c/d/plant.json", "/q/a/b/c/d/plant.json"];
        assert_eq!(of(&deep), ["plant (1)", "plant (2)"]);
    }
}
