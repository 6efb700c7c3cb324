//! Archives with the libraries that this program carries: of one document, or those of a steering
//! loop, which start on its road, with the system structure package that wires them.

use crate::Error;
use steerwright_control::{DesignPlant, Sideslip, model_behind};
use steerwright_formats::{
    Document, Model, Path as PathFile, Pid, Start, StatedActuator, sha256_hex,
};
use steerwright_host::{Archive, Connection};
use steerwright_packaging::ssp::{self, Component, Experiment};
use steerwright_packaging::{Binary, Fmu, Packed};

/// A document: its text, and its name in messages.
pub type Named<'a> = (&'a str, &'a str);

/// The FMU that is made from a document.
///
/// # Errors
/// [`Error::NotJson`] with the place, or an unknown schema.
pub fn fmu_of(document: &str, file: &str) -> Result<Fmu, Error> {
    // Text that is not JSON has no schema either, but a place to name.
    serde_json::from_str::<serde::de::IgnoredAny>(document).map_err(|e| {
        let text = e.to_string();
        let problem = text.rsplit_once(" at line ").map_or(text.as_str(), |(head, _)| head);
        let (line, column) = (e.line(), e.column());
        Error::NotJson { file: file.into(), line, column, problem: problem.into() }
    })?;
    Ok(steerwright_packaging::fmu_of(document, file)?)
}

/// Packs one document. `step` is the recommended step, s, by default the controller's sample time.
///
/// # Errors
/// [`Error::NotJson`], and those of [`steerwright_packaging::package`].
pub fn pack(document: &str, file: &str, step: Option<f64>) -> Result<Packed, Error> {
    pack_with_start(document, file, step, None)
}

/// The archive of a document, opened.
pub(crate) fn archive(document: &str, name: &str) -> Result<Archive, Error> {
    Ok(Archive::from_bytes(&pack(document, name, None)?.bytes, name)?)
}

fn pack_with_start(
    document: &str,
    file: &str,
    step: Option<f64>,
    start: Option<&Start>,
) -> Result<Packed, Error> {
    let fmu = fmu_of(document, file)?;
    let binaries: Vec<Binary<'_>> = steerwright_binaries::libraries_of(fmu.name())
        .map(|l| Binary { platform: l.platform, bytes: l.bytes })
        .collect();
    Ok(steerwright_packaging::package(document, file, &binaries, step, start)?)
}

/// A model and the actuator that a controller was designed for.
#[derive(Debug, Clone, PartialEq)]
pub struct BehindActuator {
    /// Name of the model's file.
    pub file: String,
    /// The document of the model behind the actuator; `None` of a model with an actuator of its own.
    pub document: Option<String>,
    /// The actuator.
    pub actuator: StatedActuator,
}

/// The model among the documents of a loop, behind the actuator that the controller among them states: where the controller
/// was designed on that model, or the model has no actuator. `None` where there is nothing to add: no controller that
/// states an actuator with a lag or a delay.
///
/// # Errors
/// An invalid document of a controller or a model.
pub fn behind_stated_actuator(documents: &[Named<'_>]) -> Result<Option<BehindActuator>, Error> {
    let Some((text, file)) = document_of_fmu(documents, Fmu::LateralPid) else { return Ok(None) };
    let designed_for = Pid::from_json(text, file)?.designed_for;
    let Some(actuator) = designed_for.actuator.filter(|a| a.time_constant_s + a.delay_s > 0.0)
    else {
        return Ok(None);
    };
    let is_steered = |(text, file): &&Named<'_>| fmu_of(text, file).is_ok_and(Fmu::is_plant);
    let Some((text, file)) = documents.iter().find(is_steered) else {
        return Ok(None);
    };
    let model = Model::from_json(text, file)?;
    let is_own = sha256_hex(text.as_bytes()) == designed_for.sha256;
    let document = if is_own || DesignPlant::from_model(&model)?.lacks_actuator() {
        Some(model_behind(&model, Some(actuator)).to_json())
    } else {
        None
    };
    Ok(Some(BehindActuator { file: (*file).into(), document, actuator }))
}

/// A packed loop.
#[allow(missing_docs)]
pub struct PackedLoop {
    /// In the order in which a Gauss–Seidel coupling steps them.
    pub fmus: Vec<Packed>,
    pub connections: Vec<Connection>,
    pub bytes: Vec<u8>,
}

/// Packs documents, one for each FMU, and wires them by name. `step` is the base step, by default the
/// controller's sample time.
///
/// # Errors
/// Those of [`pack`] and of wiring.
pub fn pack_loop(
    name: &str,
    documents: &[Named<'_>],
    step: Option<f64>,
) -> Result<PackedLoop, Error> {
    let (path, sample_time) = (path_of(documents)?, sample_time_of(documents)?);
    let step = step.or(sample_time).unwrap_or(0.01);
    let sideslip = sideslip_of(documents, path.as_ref().map(|p| p.speed_mps))?;
    let packed = documents
        .iter()
        .map(|(text, file)| pack(text, file, Some(step)))
        .collect::<Result<Vec<_>, _>>()?;
    let connections = ssp::connections_by_name(&ssp::loop_order(&packed))?;
    let drives = packed.iter().any(|packed| packed.fmu == Fmu::LongitudinalPlant);
    let mut started = Vec::new();
    for (packed, (text, file)) in packed.into_iter().zip(documents) {
        let mut values = match path.as_ref() {
            Some(p) => ssp::start_values(&packed, p, drives),
            None => Vec::new(),
        };
        values.extend(ssp::receiver_values(&packed, &connections));
        values.extend(ssp::sideslip_values(&packed, &sideslip_parameters(&sideslip)));
        // Importers that ignore a system's parameters start with the same values all the same.
        let packed = match ssp::own_start(&packed, &values) {
            None => packed,
            start => pack_with_start(text, file, Some(step), start.as_ref())?,
        };
        started.push((packed, values));
    }
    let (fmus, mut values): (Vec<Packed>, Vec<_>) = started.into_iter().unzip();
    let components: Vec<Component<'_>> = ssp::loop_order(&fmus)
        .into_iter()
        .map(|packed| {
            let place = fmus.iter().position(|other| other.fmu == packed.fmu);
            let start = place.map(|place| std::mem::take(&mut values[place]));
            Component { packed, start: start.unwrap_or_default() }
        })
        .collect();
    let stop = path.as_ref().map_or(10.0, |path| length(path, drives, step));
    let stop = (stop / step).floor().max(1.0) * step;
    let bytes = ssp::ssp(name, &components, &connections, Experiment { step, stop })?;
    let fmus = ssp::loop_order(&fmus).into_iter().cloned().collect();
    Ok(PackedLoop { fmus, connections, bytes })
}

/// What a vehicle may take longer than the profile of its path, s: it starts and stops later by the lag of its drive.
const LATE: f64 = 5.0;

/// How long a run along the path takes, s; of a plant that moves by itself that of the profile.
fn length(path: &PathFile, drives: bool, step: f64) -> f64 {
    if let Some(profile) = path.profile.as_ref().filter(|_| drives) {
        return profile.time_s + LATE;
    }
    match (path.points.first(), path.points.last()) {
        (Some(first), Some(last)) => (last.distance_m - first.distance_m) / path.speed_mps,
        _ => step,
    }
}

/// The sideslip as parameters of the FMUs that use it.
pub(crate) fn sideslip_parameters(sideslip: &Sideslip) -> [(&'static str, f64); 5] {
    [
        ("sideslip_per_yaw_rate", sideslip.per_yaw_rate),
        ("sideslip_per_yaw_acceleration", sideslip.per_yaw_acceleration),
        ("sideslip_growth", sideslip.growth),
        ("distance_rear", sideslip.distance_rear),
        (ssp::REFERENCE_SPEED, sideslip.reference_speed),
    ]
}

/// The sideslip of the plant among the documents at the speed of the path, if there is one; all 0 where
/// it is unknown.
fn sideslip_of(documents: &[Named<'_>], speed: Option<f64>) -> Result<Sideslip, Error> {
    for (text, file) in documents {
        if let Some(sideslip) = steerwright_control::sideslip(text, file, speed)? {
            return Ok(sideslip);
        }
    }
    Ok(Sideslip::default())
}

/// The document of an FMU.
fn document_of_fmu<'a>(documents: &[Named<'a>], fmu: Fmu) -> Option<Named<'a>> {
    let schema = Some(fmu.schema());
    documents
        .iter()
        .copied()
        .find(|(text, _)| steerwright_formats::schema_of(text).as_deref() == schema)
}

fn path_of(documents: &[Named<'_>]) -> Result<Option<PathFile>, Error> {
    let read = |(text, file)| PathFile::from_json(text, file);
    Ok(document_of_fmu(documents, Fmu::ReferencePath).map(read).transpose()?)
}

fn sample_time_of(documents: &[Named<'_>]) -> Result<Option<f64>, Error> {
    for fmu in [Fmu::LateralPid, Fmu::SpeedController, Fmu::Excitation] {
        if let Some((text, file)) = document_of_fmu(documents, fmu) {
            return Ok(Some(fmu.times_s(text, file, None)?.0));
        }
    }
    Ok(None)
}
