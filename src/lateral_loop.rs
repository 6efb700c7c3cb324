//! The FMUs of a steering loop, packed to start where its road starts, and the package that wires
//! them.

use crate::failure::Failure;
use crate::package;
use fmi2_host::Connection;
use formats::{Document, Path as PathFile, Pid};
use packaging::ssp::{self, Component, Experiment};
use packaging::{Fmu, Packed};

/// Name of the package that `build` and `demo` write.
pub(crate) const NAME: &str = "LateralLoop";

/// A document: its text, and the name it is known by.
pub(crate) type Named<'a> = (&'a str, &'a str);

/// A packed loop.
pub(crate) struct PackedLoop {
    /// In the order in which a Gauss–Seidel master steps them.
    pub(crate) fmus: Vec<Packed>,
    pub(crate) connections: Vec<Connection>,
    /// The system structure package.
    pub(crate) bytes: Vec<u8>,
}

/// Packs documents, one for each FMU, and wires variables of equal name. `step` is the base step,
/// by default the controller's sample time.
pub(crate) fn pack(
    name: &str,
    documents: &[Named<'_>],
    step: Option<f64>,
) -> Result<PackedLoop, Failure> {
    let (path, sample_time) = (path_of(documents)?, sample_time_of(documents)?);
    let step = step.or(sample_time).unwrap_or(0.01);
    let mut fmus = Vec::new();
    for (text, file) in documents {
        let packed = package::pack(text, file, Some(step))?;
        let values = path.as_ref().map(|path| ssp::start_values(&packed, path));
        // Importers that ignore a system's parameters start on the road all the same.
        match ssp::own_start(&packed, &values.unwrap_or_default()) {
            None => fmus.push(packed),
            start => fmus.push(package::pack_with_start(text, file, Some(step), start.as_ref())?),
        }
    }
    let ordered: Vec<Packed> = ssp::loop_order(&fmus).into_iter().cloned().collect();
    let connections = ssp::connections_by_name(&ordered.iter().collect::<Vec<_>>())?;
    let components: Vec<Component<'_>> = ordered
        .iter()
        .map(|packed| {
            let start = path.as_ref().map(|path| ssp::start_values(packed, path));
            Component { packed, start: start.unwrap_or_default() }
        })
        .collect();
    let stop = path.as_ref().map_or(10.0, |path| length(path, step));
    let stop = (stop / step).floor().max(1.0) * step;
    let bytes = ssp::ssp(name, &components, &connections, Experiment { step, stop })?;
    Ok(PackedLoop { fmus: ordered, connections, bytes })
}

/// How long a run along the path takes, s.
fn length(path: &PathFile, step: f64) -> f64 {
    match (path.points.first(), path.points.last()) {
        (Some(first), Some(last)) => (last.distance_m - first.distance_m) / path.speed_mps,
        _ => step,
    }
}

/// The document of an FMU.
fn of<'a>(documents: &[Named<'a>], fmu: Fmu) -> Option<Named<'a>> {
    let schema = Some(fmu.schema());
    documents.iter().copied().find(|(text, _)| formats::schema_of(text).as_deref() == schema)
}

fn path_of(documents: &[Named<'_>]) -> Result<Option<PathFile>, Failure> {
    let read = |(text, file)| PathFile::from_json(text, file);
    Ok(of(documents, Fmu::ReferencePath).map(read).transpose()?)
}

fn sample_time_of(documents: &[Named<'_>]) -> Result<Option<f64>, Failure> {
    let read = |(text, file)| Pid::from_json(text, file).map(|pid| pid.sample_time_s);
    Ok(of(documents, Fmu::LateralPid).map(read).transpose()?)
}
