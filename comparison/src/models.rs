//! The models that are compared, and the controllers that were designed on them or are.

use crate::Error;
use std::path::PathBuf;
use steerwright_control::{DesignOptions, DesignPlant};
use steerwright_formats::{
    Guidance, LoopCoupling, Model, Path as PathFile, Pid, SourceFile, StatedActuator, StepMetrics,
};

/// Ratios of one vehicle agree within a few percent; 1 and 15 are two places.
const SAME_PLACE: f64 = 1.25;

/// A model and its file.
#[allow(missing_docs)]
pub struct ComparedModel {
    /// Short and unique.
    pub label: String,
    pub path: PathBuf,
    pub source: SourceFile,
    /// A vehicle as the bicycle that it is in gentle driving.
    pub document: Model,
    /// The model for the design of controllers.
    pub design: DesignPlant,
}

/// A controller's file.
#[allow(missing_docs)]
pub struct ControllerFile {
    pub path: PathBuf,
    pub pid: Pid,
    pub source: SourceFile,
    /// Which of the models it goes with; by default that whose hash it carries.
    pub model: Option<usize>,
}

/// A controller and the model that it was designed on.
pub struct Controller {
    /// Short and unique.
    pub label: String,
    /// Which of the models.
    pub model: usize,
    /// Its gains, limits and evidence.
    pub pid: Pid,
    /// Its file; absent where it was designed here.
    pub source: Option<SourceFile>,
    /// The specification's step on the model, in the order of the coupling.
    pub predicted: StepMetrics,
}

impl ComparedModel {
    /// Why a design on it may mean little, from its evidence.
    pub(crate) fn doubt(&self) -> Option<String> {
        let quality = self.document.quality();
        let message =
            || format!("the quality of {} is {}: {}", self.label, quality.grade, quality.summary);
        if quality.allows_design() { None } else { Some(message()) }
    }

    /// For people.
    pub(crate) fn kind(&self) -> String {
        let structure = self.document.structure();
        match self.document.plant() {
            Some(plant) => format!("identified, order {}", plant.order()),
            None if self.document.channels().is_empty() => format!("{structure}, vehicle data"),
            None => format!("{structure}, identified"),
        }
    }
}

/// The models of these files, with labels. All must use the same steering angle.
///
/// # Errors
/// A model that no controller can be designed on, and [`Error::SteeringRatios`].
pub fn models(files: Vec<(PathBuf, SourceFile, Model)>) -> Result<Vec<ComparedModel>, Error> {
    let paths: Vec<PathBuf> = files.iter().map(|(path, ..)| path.clone()).collect();
    let mut models: Vec<ComparedModel> = Vec::new();
    for ((path, source, document), label) in files.into_iter().zip(labels(&paths)) {
        let failed = |e| Error::from(e).within(path.display());
        let design = DesignPlant::from_model(&document).map_err(failed)?;
        models.push(ComparedModel { label, path, source, document, design });
    }
    let by_ratio = |a: &&ComparedModel, b: &&ComparedModel| {
        a.design.steering_ratio.total_cmp(&b.design.steering_ratio)
    };
    if let (Some(low), Some(high)) =
        (models.iter().min_by(by_ratio), models.iter().max_by(by_ratio))
        && high.design.steering_ratio > SAME_PLACE * low.design.steering_ratio
    {
        return Err(Error::SteeringRatios {
            high: high.path.display().to_string(),
            high_ratio: high.design.steering_ratio,
            low: low.path.display().to_string(),
            low_ratio: low.design.steering_ratio,
        });
    }
    Ok(models)
}

/// Names of files without extensions, with as many of their folders as make them distinct.
pub(crate) fn labels(paths: &[PathBuf]) -> Vec<String> {
    let tail = |path: &PathBuf, count: usize| {
        let parts: Vec<String> = path
            .with_extension("")
            .components()
            .map(|c| c.as_os_str().to_string_lossy().into_owned())
            .collect();
        parts[parts.len().saturating_sub(count)..].join("/")
    };
    // At most three folders: those above belong to the machine.
    let named = |count| paths.iter().map(|p| tail(p, count)).collect::<Vec<_>>();
    let unlike = |names: &[String]| (1..names.len()).all(|k| !names[..k].contains(&names[k]));
    let found = (1..=3).map(named).find(|names| unlike(names));
    found.unwrap_or_else(|| {
        let names = named(1);
        names.iter().enumerate().map(|(k, name)| format!("{name} ({})", k + 1)).collect()
    })
}

/// The controllers: those of the files, and for every model without a file one that is designed here.
pub(crate) fn controllers(
    models: &[ComparedModel],
    files: Vec<ControllerFile>,
    options: &DesignOptions,
    coupling: LoopCoupling,
) -> Result<Vec<Controller>, Error> {
    let mut found = Vec::new();
    for file in files {
        let hash = &file.pid.designed_for.sha256;
        let by_hash = || models.iter().position(|m| m.source.sha256 == *hash);
        let Some(model) = file.model.or_else(by_hash) else {
            return Err(Error::OtherModel {
                file: file.path.display().to_string(),
                model: match models.first() {
                    Some(m) => m.label.clone(),
                    None => "plant".into(),
                },
            });
        };
        found.push((model, file));
    }
    let mut all: Vec<Controller> = Vec::new();
    // The models are of one vehicle: a data sheet takes the rate of the others' drive.
    let designs = models.iter().map(|m| &m.design);
    let options = designs.fold(*options, |options, design| options.with_rate_of(design));
    for (index, model) in models.iter().enumerate() {
        let own: Vec<_> = found.extract_if(.., |(of, _)| *of == index).collect();
        if own.is_empty() {
            let pid = steerwright_control::design(&model.design, &model.source, &options)
                .map_err(|e| Error::from(e).within(model.path.display()))?;
            all.push(Controller::new(model.label.clone(), (index, model), pid, None, coupling)?);
            continue;
        }
        let files: Vec<PathBuf> = own.iter().map(|(_, file)| file.path.clone()).collect();
        let several = own.len() > 1;
        for ((_, file), name) in own.into_iter().zip(labels(&files)) {
            let ControllerFile { path, pid, source, .. } = file;
            let label =
                if several { format!("{} ({name})", model.label) } else { model.label.clone() };
            let controller = Controller::new(label, (index, model), pid, Some(source), coupling);
            all.push(controller.map_err(|e| e.within(path.display()))?);
        }
    }
    if all.len() < 2 {
        return Err(Error::NothingToCompare);
    }
    let by_sample =
        |a: &&Controller, b: &&Controller| a.pid.sample_time_s.total_cmp(&b.pid.sample_time_s);
    if let (Some(low), Some(high)) = (all.iter().min_by(by_sample), all.iter().max_by(by_sample))
        && high.pid.sample_time_s > low.pid.sample_time_s * (1.0 + 1e-9)
    {
        return Err(Error::SampleTimes {
            high: high.label.clone(),
            high_s: high.pid.sample_time_s,
            low: low.label.clone(),
            low_s: low.pid.sample_time_s,
        });
    }
    Ok(all)
}

impl Controller {
    /// The actuator that it was designed for, before a model: that of its design, and others of a measured angle.
    pub(crate) fn actuator_before(
        &self,
        index: usize,
        model: &ComparedModel,
    ) -> Option<StatedActuator> {
        let is_before = index == self.model || model.design.lacks_actuator();
        self.pid.designed_for.actuator.filter(|_| is_before)
    }

    /// Its guidance along a road; the growth of the integral is the road's.
    pub(crate) fn guidance(&self, road: &PathFile) -> Guidance {
        Guidance {
            cross_track_integral_gain_per_s: road.guidance.cross_track_integral_gain_per_s,
            ..steerwright_control::guidance_for(&self.pid, road.speed_mps)
        }
    }

    fn new(
        label: String,
        (index, model): (usize, &ComparedModel),
        pid: Pid,
        source: Option<SourceFile>,
        coupling: LoopCoupling,
    ) -> Result<Self, Error> {
        // The delay of this coupling, whatever the design assumed.
        let delay = coupling.loop_delay_s(pid.sample_time_s);
        let plant = model.design.behind(pid.designed_for.actuator);
        let predicted = steerwright_control::step_metrics(&plant, &pid, delay)?;
        Ok(Self { label, model: index, pid, source, predicted })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short_and_distinct() {
        let of = |paths: &[&str]| labels(&paths.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["plant.json", "/home/me/bicycle.json"]), ["plant", "bicycle"]);
        assert_eq!(of(&["/x/a/plant.json", "/x/b/plant.json"]), ["a/plant", "b/plant"]);
        // The folders above belong to the machine.
        let deep = ["/p/a/b/c/d/plant.json", "/q/a/b/c/d/plant.json"];
        assert_eq!(of(&deep), ["plant (1)", "plant (2)"]);
    }
}
