//! The kind of an existing file at the place of an output: only files that this program wrote, of the
//! same kind, are overwritten without `--force`.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use steerwright_formats::{Document, Structure, Vehicle};
use steerwright_report::GENERATOR;

/// How far a header or a mark may stand from the start of a file.
const HEAD: u64 = 64 << 10;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OutputKind {
    /// A versioned JSON document: its schema without the version, such as `steerwright/plant/`.
    Document(&'static str),
    /// A model of the lateral dynamics: plant, bicycle or identified vehicle.
    Model,
    /// A vehicle that was identified; one without its provenance was written by hand.
    IdentifiedVehicle,
    /// Measured and simulated signals of an identification, CSV.
    Traces,
    /// A simulation's trajectories, CSV: `time`, then `instance.variable`.
    Recording,
    SweepResults,
    Svg,
    Html,
    Fmu,
    Ssp,
    ManPage,
    /// The parameters of a driving stack.
    Parameters,
    /// The steering of a manoeuvre, CSV.
    Manoeuvre,
}

impl OutputKind {
    /// The kind of a document, of any version.
    pub(crate) fn for_document<D: Document>() -> Self {
        Self::for_schema(D::SCHEMA)
    }

    /// The kind of the document of a schema, of any version.
    pub(crate) fn for_schema(schema: &'static str) -> Self {
        let end = schema.rfind('/').map_or(schema.len(), |slash| slash + 1);
        Self::Document(&schema[..end])
    }

    /// The kind of a model's file.
    pub(crate) fn of_model(structure: Structure) -> Self {
        match structure {
            Structure::SingleTrack => Self::IdentifiedVehicle,
            other => Self::for_schema(other.schema()),
        }
    }

    pub(crate) fn in_words(self) -> String {
        match self {
            Self::Document(schema) => format!("`{}` file", schema.trim_end_matches('/')),
            Self::Model => "plant, bicycle or identified vehicle file".into(),
            Self::IdentifiedVehicle => "identified vehicle".into(),
            Self::Traces => "CSV of an identification's signals".into(),
            Self::Recording => "CSV of simulated trajectories".into(),
            Self::SweepResults => "CSV of a sweep's results".into(),
            Self::Svg => "figure (SVG)".into(),
            Self::Html => "page (HTML)".into(),
            Self::Fmu => "FMU".into(),
            Self::Ssp => "system structure package".into(),
            Self::ManPage => "page of the manual".into(),
            Self::Parameters => "parameters of a driving stack".into(),
            Self::Manoeuvre => "CSV of a manoeuvre's steering".into(),
        }
    }

    /// Whether the file holds what this program writes of this kind. An empty file holds nothing
    /// that could be lost.
    pub(crate) fn is_in(self, path: &Path) -> std::io::Result<bool> {
        let mut file = File::open(path)?;
        if file.metadata()?.len() == 0 {
            return Ok(true);
        }
        Ok(match self {
            Self::Document(schema) => {
                schema_of(file).is_some_and(|found| found.starts_with(schema))
            }
            Self::Model => {
                for structure in Structure::ALL {
                    if structure.is_lateral() && Self::of_model(structure).is_in(path)? {
                        return Ok(true);
                    }
                }
                false
            }
            Self::IdentifiedVehicle => serde_json::from_reader::<_, Vehicle>(BufReader::new(file))
                .is_ok_and(|vehicle| vehicle.provenance.is_some()),
            Self::Traces => header(file).is_some_and(|cells| {
                let first =
                    ["time_s", "steering_rad", "yaw_rate_radps", "simulated_yaw_rate_radps"];
                let of_channels = cells.first().is_some_and(|cell| cell == "time_s")
                    && cells.last().is_some_and(|cell| cell == "held_out");
                of_channels || cells.iter().take(first.len()).eq(first.iter())
            }),
            Self::Recording => header(file).is_some_and(|cells| {
                let mut cells = cells.iter();
                let time = cells.next().is_some_and(|cell| cell == "time");
                time && cells.len() > 0 && cells.all(|cell| cell.contains('.'))
            }),
            Self::SweepResults => header(file).is_some_and(|cells| {
                let end = cells.len().saturating_sub(2);
                cells.first().is_some_and(|cell| cell == "run")
                    && cells[end..] == ["status", "study"]
            }),
            Self::Svg => {
                let mark = format!("data-generator=\"{GENERATOR}\"");
                head(file)?.split('>').next().is_some_and(|root| root.contains(&mark))
            }
            Self::Html => {
                head(file)?.contains(&format!("<meta name=\"generator\" content=\"{GENERATOR} "))
            }
            Self::ManPage => {
                let title = format!(".TH {GENERATOR}");
                head(file)?.lines().any(|line| line.starts_with(&title))
            }
            Self::Manoeuvre => {
                header(file).is_some_and(|cells| cells == ["time_s", "steering_rad", "speed_mps"])
            }
            Self::Parameters => head(file)?.starts_with(steerwright_stacks::MARK),
            Self::Fmu => entry(&mut file, "modelDescription.xml").is_some_and(is_ours),
            Self::Ssp => entry(&mut file, "SystemStructure.ssd").is_some_and(is_ours),
        })
    }
}

/// The attribute that both modelDescription.xml and SystemStructure.ssd have on their root.
fn is_ours(xml: String) -> bool {
    xml.contains(&format!("generationTool=\"{GENERATOR} "))
}

/// The schema of a JSON document, read no further than it is JSON.
fn schema_of(file: File) -> Option<String> {
    #[derive(serde::Deserialize)]
    struct Tag {
        schema: String,
    }
    serde_json::from_reader::<_, Tag>(BufReader::new(file)).ok().map(|tag| tag.schema)
}

/// The cells of a CSV file's first line.
pub(super) fn header(file: File) -> Option<Vec<String>> {
    let mut line = String::new();
    BufReader::new(file.take(HEAD)).read_line(&mut line).ok()?;
    let mut cells = Vec::new();
    let (mut cell, mut quoted) = (String::new(), false);
    for c in line.trim_end_matches(['\n', '\r']).chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(std::mem::take(&mut cell)),
            c => cell.push(c),
        }
    }
    cells.push(cell);
    Some(cells)
}

/// The start of a text.
fn head(text: impl Read) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    text.take(HEAD).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The start of a text in a zip archive.
fn entry(file: &mut File, name: &str) -> Option<String> {
    file.seek(SeekFrom::Start(0)).ok()?;
    let mut archive = zip::ZipArchive::new(file).ok()?;
    let entry = archive.by_name(name).ok()?;
    head(entry).ok()
}
