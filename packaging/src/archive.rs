//! One archive from one document.

use crate::documentation::Sections;
use crate::platform::Platform;
use crate::provenance::Origin;
use crate::terminals::DOMAIN;
use crate::{Error, documentation, provenance, reference, terminals};
use model_description::{DefaultExperiment, ModelDescription};
use std::io::{Cursor, Write};
use steerwright_formats::{Document, Start};
use steerwright_units::{Fmu, Icon};
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

const TERMINAL: Icon = Icon {
    png: include_bytes!("../icons/terminal.png"),
    svg: include_bytes!("../icons/terminal.svg"),
};

/// An FMU's library for one platform.
#[derive(Debug, Clone, Copy)]
pub struct Binary<'a> {
    /// FMI's name of the platform: `linux64`, `win64`, `darwin64`, `aarch64-linux` …
    pub platform: &'a str,
    /// The library.
    pub bytes: &'a [u8],
}

/// An archive in memory.
#[derive(Debug, Clone)]
pub struct Packed {
    /// Which FMU it is; the archive's name is this name and `.fmu`.
    pub fmu: Fmu,
    /// Its modelDescription.xml.
    pub description: ModelDescription,
    /// The archive.
    pub bytes: Vec<u8>,
}

/// Which FMU is made from a document, by its schema.
///
/// # Errors
/// [`Error::NotPackable`]; `file` is named in it.
pub fn fmu_of(document: &str, file: &str) -> Result<Fmu, Error> {
    let schema = steerwright_formats::schema_of(document);
    Fmu::ALL.into_iter().find(|fmu| Some(fmu.schema()) == schema.as_deref()).ok_or_else(|| {
        let found = match schema {
            Some(s) => format!("`{s}`"),
            None => "a file without a schema".into(),
        };
        Error::NotPackable { file: file.into(), found }
    })
}

/// Packs the FMU of a document. `file` is named in errors; `step` is the step size that
/// `DefaultExperiment` declares, in seconds, by default the controller's sample time or 0.01;
/// `start` replaces start values of the FMU, in `resources/start.json`.
///
/// # Errors
/// An invalid document, step or start value, or no binary.
pub fn package(
    document: &str,
    file: &str,
    binaries: &[Binary<'_>],
    step: Option<f64>,
    start: Option<&Start>,
) -> Result<Packed, Error> {
    let fmu = fmu_of(document, file)?;
    let origin = Origin::new(fmu, document, file)?;
    let (step, duration) = fmu.times_s(document, file, step)?;
    if !(step.is_finite() && step > 0.0) {
        return Err(Error::Step { step });
    }
    if binaries.is_empty() {
        return Err(Error::NoBinary { fmu: fmu.name() });
    }
    let platforms = platforms(fmu, binaries)?;

    let start = start.map(|start| (Start::FILE.to_owned(), start.to_json().into_bytes()));
    let mut entries = vec![(fmu.resource().to_owned(), document.as_bytes().to_vec())];
    entries.extend(start.clone());
    let experiment = DefaultExperiment {
        start_time: Some(0.0),
        stop_time: Some(duration),
        step_size: Some(step),
        tolerance: None,
    };
    let mut description = fmu
        .describe(entries.clone(), experiment)
        .map_err(|source| Error::CoSimulationUnit { file: file.into(), source })?;
    description.generation_tool = Some(provenance::TOOL.into());
    description.license = Some("MIT OR Apache-2.0".into());
    description.vendor_annotations = vec![origin.annotation()];

    let icon = fmu.icon();
    let reference = reference::run(fmu, document, file, entries, &description, [step, duration])?;
    let extra = format!("extra/{DOMAIN}");
    let mut sorted = platforms.clone();
    sorted.sort_by(|(a, _), (b, _)| a.cmp(b));
    let sections = Sections { origin: &origin, platforms: &sorted, extra: &extra };
    let page = documentation::page(fmu, &description, &sections);
    let mut files: Vec<(String, Vec<u8>)> = vec![
        ("documentation/index.html".into(), page.into()),
        ("documentation/licenses/LICENSE-APACHE".into(), LICENSE_APACHE.into()),
        ("documentation/licenses/LICENSE-MIT".into(), LICENSE_MIT.into()),
        ("documentation/licenses/license.txt".into(), LICENSES.into()),
        (format!("{extra}/provenance.json"), origin.json().into()),
        (format!("{extra}/reference/input.csv"), reference.input),
        (format!("{extra}/reference/reference.json"), reference.description.into()),
        (format!("{extra}/reference/result.csv"), reference.result),
        ("model.png".into(), icon.png.into()),
        (format!("resources/{}", fmu.resource()), document.into()),
        ("terminalsAndIcons/icon.png".into(), icon.png.into()),
        ("terminalsAndIcons/icon.svg".into(), icon.svg.into()),
        ("terminalsAndIcons/terminal.png".into(), TERMINAL.png.into()),
        ("terminalsAndIcons/terminal.svg".into(), TERMINAL.svg.into()),
        ("terminalsAndIcons/terminalsAndIcons.xml".into(), terminals::xml(&description).into()),
    ];
    files.extend(start.map(|(name, bytes)| (format!("resources/{name}"), bytes)));
    for (binary, (folder, platform)) in binaries.iter().zip(&platforms) {
        let name = format!("binaries/{folder}/{}.{}", fmu.name(), platform.extension());
        files.push((name, binary.bytes.to_vec()));
    }
    // The description first, for readers of a stream; the rest sorted.
    files.sort();
    files.insert(0, ("modelDescription.xml".into(), description.to_xml().into_bytes()));
    let files =
        files.iter().map(|(name, bytes)| (name.clone(), &**bytes, CompressionMethod::Deflated));
    let bytes = zipped(files).map_err(|source| Error::Zip { fmu: fmu.name(), source })?;
    Ok(Packed { fmu, description, bytes })
}

/// Each library's folder and platform, none twice.
fn platforms(fmu: Fmu, binaries: &[Binary<'_>]) -> Result<Vec<(String, Platform)>, Error> {
    let mut platforms: Vec<(String, Platform)> = Vec::new();
    for Binary { platform, .. } in binaries {
        if platforms.iter().any(|(folder, _)| folder == platform) {
            return Err(Error::TwoBinaries { fmu: fmu.name(), platform: (*platform).to_owned() });
        }
        platforms.push(((*platform).to_owned(), Platform::from_folder(platform)?));
    }
    Ok(platforms)
}

const LICENSES: &str = include_str!("../licenses/license.txt");
const LICENSE_MIT: &str = include_str!("../../LICENSE-MIT");
const LICENSE_APACHE: &str = include_str!("../../LICENSE-APACHE");

/// A zip of named files without clock or user: the same files give the same bytes.
pub(crate) fn zipped<'a>(
    files: impl Iterator<Item = (String, &'a [u8], CompressionMethod)>,
) -> ZipResult<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes, method) in files {
        zip.start_file(name, options.compression_method(method))?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}
