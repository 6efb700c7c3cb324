//! Bicycle models from vehicle data: `vehicle.toml` → `bicycle.json`, by the equations of the FMU (eq 13).

use crate::Error;
use steerwright_formats::{Bicycle, Document, SourceFile, Vehicle, VehicleData, VehicleEvidence};
use steerwright_models::files::bicycle_parameters;

fn read_vehicle(text: &str, file: &str) -> Result<VehicleData, Error> {
    let vehicle: VehicleData = toml::from_str(text).map_err(|e| {
        let (line, column) = e.span().map_or((1, 1), |span| place(text, span.start));
        let problem = e.message().replace('\n', "; ");
        Error::VehicleFile { file: file.into(), line, column, problem }
    })?;
    // Checked here as well as in the document, since the line is known here.
    document(&vehicle).checked(file).map_err(|e| match e {
        steerwright_formats::Error::Value { path, problem, .. } => {
            let key = path.rsplit('.').next().unwrap_or_default();
            let (line, column) = place_of_key(text, key);
            let problem = format!("{key}: {problem}");
            Error::VehicleFile { file: file.into(), line, column, problem }
        }
        other => other.into(),
    })?;
    Ok(vehicle)
}

/// The bicycle model of a vehicle.
///
/// # Errors
/// [`Error::Document`] or [`Error::Model`] where a value is impossible.
pub fn bicycle(vehicle: &VehicleData) -> Result<Bicycle, Error> {
    let bicycle = document(vehicle);
    bicycle.checked(&vehicle.name)?;
    bicycle_parameters(vehicle)
        .check()
        .map_err(|e| Error::Model { model: vehicle.name.clone(), problem: e.to_string() })?;
    Ok(bicycle)
}

/// Reads vehicle data and returns the bicycle model, with the file in its provenance.
///
/// # Errors
/// [`Error::VehicleFile`] with line and column of a missing, unknown or impossible value, and as
/// [`bicycle`].
pub fn bicycle_from_toml(text: &str, file: &str) -> Result<Bicycle, Error> {
    let mut bicycle = bicycle(&read_vehicle(text, file)?).map_err(|e| match e {
        Error::Model { problem, .. } => Error::Model { model: file.into(), problem },
        other => other,
    })?;
    bicycle.provenance.sources =
        vec![SourceFile::from_bytes(std::path::Path::new(file), text.as_bytes())];
    Ok(bicycle)
}

/// The bicycle model that a vehicle is in gentle driving, with its uncertainty and quality.
///
/// # Errors
/// As [`bicycle`].
pub fn bicycle_of_vehicle(vehicle: &Vehicle) -> Result<Bicycle, Error> {
    let own = bicycle(&vehicle.in_gentle_driving())?;
    Ok(Bicycle {
        sideslip: vehicle.sideslip,
        evidence: vehicle.evidence.as_ref().map(VehicleEvidence::of_bicycle),
        quality: vehicle.quality.clone(),
        provenance: vehicle.provenance.clone().unwrap_or(own.provenance),
        ..own
    })
}

fn document(vehicle: &VehicleData) -> Bicycle {
    let mut bicycle = Bicycle::new(vehicle.clone());
    bicycle.provenance.version = env!("CARGO_PKG_VERSION").into();
    bicycle
}

/// Line and column, from 1, of a byte.
pub(crate) fn place(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    (line, column)
}

/// Line and column, from 1, of the value of a key.
fn place_of_key(text: &str, key: &str) -> (usize, usize) {
    for (i, line) in text.lines().enumerate() {
        if let Some((name, value)) = line.split_once('=')
            && name.trim().trim_matches(['"', '\'']) == key
        {
            let blanks = value.len() - value.trim_start().len();
            return (i + 1, name.chars().count() + 1 + blanks + 1);
        }
    }
    (1, 1)
}
