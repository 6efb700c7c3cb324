//! `steerwright compare` of plants of named channels: each simulates a log of its channels.

use super::{Arguments, RoadArguments, Shape};
use crate::failure::{Failure, Outcome};
use crate::output::Folder;
use crate::pipeline::Writer;
use crate::terminal::console;
use std::path::PathBuf;
use steerwright_comparison::{channel_files, channel_json, channel_text, simulated_plants};
use steerwright_drivelog::{DriveLog, Response};
use steerwright_formats::{Model, MultivariablePlant, SourceFile};

/// Whether one of the models is of named channels.
pub(super) fn is_of_channels(files: &[(PathBuf, SourceFile, Model)]) -> bool {
    files.iter().any(|(.., model)| model.multivariable().is_some())
}

pub(super) fn run(
    arguments: &Arguments,
    files: Vec<(PathBuf, SourceFile, Model)>,
    folder: Option<Folder>,
) -> Result<Outcome, Failure> {
    arguments.reject_what_needs_a_vehicle()?;
    let mut plants = Vec::new();
    for (path, source, model) in files {
        let Some(plant) = model.multivariable() else {
            return Err(Failure::new(
                format!(
                    "{}: a model of a vehicle, beside a plant of named channels",
                    path.display()
                ),
                "compare plants of named channels with each other",
            ));
        };
        plants.push((path, source, plant.clone()));
    }
    let compared = simulated_plants(plants, |plant| arguments.log_of(plant))?;
    let written = match folder {
        Some(folder) => {
            let mut out = Writer::new(folder.stage());
            for file in channel_files(&compared)? {
                out.bytes(&file.source.name, &file.bytes)?;
            }
            folder.commit()?;
            out.into_written()
        }
        None => Vec::new(),
    };
    let mut text = channel_text(&compared, console::columns());
    if let Some(folder) = &arguments.out {
        text.push_str(&format!("\n{} figures in {}\n", written.len(), folder.display()));
    }
    console::result(&text, &channel_json(&compared, &written))?;
    Ok(Outcome::when(true))
}

impl Arguments {
    /// No option is left out in silence.
    fn reject_what_needs_a_vehicle(&self) -> Result<(), Failure> {
        let RoadArguments {
            path,
            road,
            road_speed,
            lateral_acceleration,
            cross_track_integral,
            max_cross_track_error,
        } = &self.road;
        let stated = [
            ("--truth", self.truth.is_some()),
            ("--pid", !self.pids.is_empty()),
            ("--validation-fraction", self.validation_fraction.is_some()),
            ("--path", path.is_some()),
            ("--road", !matches!(road, Shape::Reference)),
            ("--road-speed", road_speed.is_some()),
            ("--lateral-acceleration", *lateral_acceleration != 4.0),
            ("--cross-track-integral", cross_track_integral.is_some()),
            ("--max-cross-track-error", *max_cross_track_error != 1.75),
            ("the specification", self.specification.is_stated()),
        ];
        if let Some((name, _)) = stated.iter().find(|(_, is_stated)| *is_stated) {
            return Err(Failure::new(
                format!("{name} has no effect on plants of named channels, which follow no road"),
                "omit it",
            ));
        }
        if self.logs.is_empty() && self.log.drives.is_empty() {
            return Err(Failure::new(
                "plants of named channels are compared on a log",
                "add a log with their channels: --log LOG",
            ));
        }
        Ok(())
    }

    /// The log with the channels and the sample time of a plant, where the options do not name them.
    fn log_of(&self, plant: &MultivariablePlant) -> Result<DriveLog, Failure> {
        let mut log = self.log.clone();
        if log.input_channels.is_empty() {
            log.input_channels = plant.inputs.iter().map(|input| input.column.clone()).collect();
        }
        if log.output_channels.is_empty() {
            log.output_channels =
                plant.outputs.iter().map(|output| output.column.clone()).collect();
        }
        log.sample_time.get_or_insert(plant.discrete.sample_time_s);
        log.read(&self.logs, Response::Channels)
    }
}
