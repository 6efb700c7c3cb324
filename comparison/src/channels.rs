//! Plants of named channels compared with a log.

use crate::Error;
use crate::models::labels;
use crate::page::OutputFile;
use serde::Serialize;
use std::path::PathBuf;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{Model, MultivariablePlant, SourceFile};
use steerwright_report::{ChannelSignals, Table, WIDTH, figures};
use steerwright_sysid::multivariable::{LogSimulation, simulate_log};

/// A plant of named channels with its file and the log that it simulates.
#[allow(missing_docs)]
pub struct SimulatedPlant {
    /// Short and unique.
    pub label: String,
    pub source: SourceFile,
    pub plant: MultivariablePlant,
    pub simulation: LogSimulation,
}

/// The comparison for scripts.
#[derive(Serialize)]
pub struct ChannelOverview<'a> {
    models: Vec<SimulationOverview<'a>>,
    files: &'a [SourceFile],
}

#[derive(Serialize)]
struct SimulationOverview<'a> {
    name: &'a str,
    file: &'a SourceFile,
    order: usize,
    outputs: Vec<OutputOverview<'a>>,
}

#[derive(Serialize)]
struct OutputOverview<'a> {
    name: &'a str,
    fit_percent: f64,
    validation_fit_percent: Option<f64>,
}

/// Simulates with each plant the log that `read` returns for it.
///
/// # Errors
/// Those of `read`, and a log that is not of the channels of a plant.
pub fn simulated_plants<E: From<Error>>(
    files: Vec<(PathBuf, SourceFile, MultivariablePlant)>,
    read: impl Fn(&MultivariablePlant) -> Result<DriveLog, E>,
) -> Result<Vec<SimulatedPlant>, E> {
    let paths: Vec<PathBuf> = files.iter().map(|(path, ..)| path.clone()).collect();
    let mut simulated = Vec::new();
    for ((path, source, plant), label) in files.into_iter().zip(labels(&paths)) {
        let log = read(&plant)?;
        let simulation = simulate_log(&plant, &log)
            .map_err(|error| Error::Identification(Box::new(error)).within(path.display()))?;
        simulated.push(SimulatedPlant { label, source, plant, simulation });
    }
    Ok(simulated)
}

impl SimulatedPlant {
    /// Name, fit on the log, and the stated fit on the validation data of its own log, percent, of each output.
    fn fits(&self) -> impl Iterator<Item = (&str, f64, Option<f64>)> {
        let stated = self.plant.evidence.outputs.iter().map(|output| output.fit.validation);
        let stated = stated.map(Some).chain(std::iter::repeat(None));
        let outputs = self.plant.outputs.iter().map(|output| output.name.as_str());
        outputs.zip(&self.simulation.fits).zip(stated).map(|((name, fit), own)| (name, *fit, own))
    }
}

/// The fits in a table of at most so many columns of text.
#[must_use]
pub fn channel_text(plants: &[SimulatedPlant], columns: usize) -> String {
    let mut table = Table::new(["model", "order", "output", "fit on this log", "stated fit"]);
    for plant in plants {
        for (name, fit, stated) in plant.fits() {
            table.push([
                plant.label.clone(),
                plant.plant.order().to_string(),
                name.to_owned(),
                format!("{fit:.2} %"),
                stated.map_or("–".into(), |stated| format!("{stated:.2} %")),
            ]);
        }
    }
    let best: Vec<String> =
        best(plants).map(|(output, label)| format!("{output} by {label}")).collect();
    let best =
        if plants.len() > 1 { format!("best fit: {}\n\n", best.join(", ")) } else { String::new() };
    best + &table.text(columns)
}

/// Of each output of the first plant the label of the plant that fits it best.
fn best(plants: &[SimulatedPlant]) -> impl Iterator<Item = (&str, &str)> {
    let outputs = plants.first().map(|plant| &plant.plant.outputs).into_iter().flatten();
    outputs.filter_map(move |output| {
        let of =
            |plant: &SimulatedPlant| plant.fits().find(|fit| fit.0 == output.name).map(|fit| fit.1);
        let fits = plants.iter().filter_map(|plant| Some((plant.label.as_str(), of(plant)?)));
        let best = fits.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((output.name.as_str(), best.0))
    })
}

/// The comparison for scripts; `files` were written.
#[must_use]
pub fn channel_json<'a>(
    plants: &'a [SimulatedPlant],
    files: &'a [SourceFile],
) -> ChannelOverview<'a> {
    let output = |(name, fit_percent, validation_fit_percent)| OutputOverview {
        name,
        fit_percent,
        validation_fit_percent,
    };
    let model = |plant: &'a SimulatedPlant| SimulationOverview {
        name: &plant.label,
        file: &plant.source,
        order: plant.plant.order(),
        outputs: plant.fits().map(output).collect(),
    };
    ChannelOverview { models: plants.iter().map(model).collect(), files }
}

/// The figures of each plant (SVG): outputs over time, and gains over frequency.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn channel_files(plants: &[SimulatedPlant]) -> Result<Vec<OutputFile>, Error> {
    let mut files = Vec::new();
    for plant in plants {
        let traces = &plant.simulation.traces;
        let signals = ChannelSignals {
            time_s: traces.time_s.clone(),
            outputs: traces.outputs.clone(),
            is_validation: Vec::new(),
        };
        let model = Model::Multivariable(Box::new(plant.plant.clone()));
        for (name, height, figure) in figures::of_channels(&model, Some(&signals)) {
            let svg = figure.to_svg(WIDTH, height)?;
            let name = format!("{}-{name}.svg", crate::figures::file_name(&plant.label));
            files.push(OutputFile {
                source: SourceFile::named(name, svg.as_bytes()),
                bytes: svg.into_bytes(),
            });
        }
    }
    Ok(files)
}
