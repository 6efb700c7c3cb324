//! `steerwright package`: FMU archives from the stages' files.

use crate::failure::{Failure, Outcome};
use crate::files;
use crate::quantity;
use crate::tell::Tell;
use packaging::{Binary, Packed};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Pack FMUs: one archive for each plant, bicycle, controller or path file; no compiler needed
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// plant.json, bicycle.json, pid.json or path.json
    #[arg(required = true, value_name = "FILE.json")]
    files: Vec<PathBuf>,
    /// Folder for the archives
    #[arg(long, short, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Step size that the archives recommend, such as 10ms; by default the controller's sample time
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    step: Option<f64>,
    /// Print the result as JSON on stdout
    #[arg(long)]
    json: bool,
}

/// What was written, for scripts.
#[derive(Serialize)]
struct Written {
    fmu: &'static str,
    file: PathBuf,
    guid: String,
    bytes: usize,
    platforms: Vec<&'static str>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let documents = arguments
        .files
        .iter()
        .map(|file| Ok((file, files::read_text(file)?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let mut packed = Vec::new();
    for (file, text) in &documents {
        let archive = pack(text, &file.display().to_string(), arguments.step)?;
        if let Some((other, _)) =
            packed.iter().find(|(_, p): &&(&PathBuf, Packed)| p.fmu == archive.fmu)
        {
            return Err(Failure::new(
                format!(
                    "{} and {} both make {}.fmu",
                    other.display(),
                    file.display(),
                    archive.fmu.name()
                ),
                "pack them into different folders",
            ));
        }
        packed.push((*file, archive));
    }
    let mut written = Vec::new();
    for (_, archive) in &packed {
        let file = write(&arguments.out, archive)?;
        written.push(Written {
            fmu: archive.fmu.name(),
            file,
            guid: archive.description.guid.clone(),
            bytes: archive.bytes.len(),
            platforms: fmu_binaries::of(archive.fmu.name()).map(|l| l.platform).collect(),
        });
    }
    let mut table = report::Table::new(["archive", "size", "platforms", "GUID"]);
    for w in &written {
        table = table.row([
            w.file.display().to_string(),
            format!("{} kB", w.bytes.div_ceil(1000)),
            w.platforms.join(" "),
            w.guid.clone(),
        ]);
    }
    Tell::new(arguments.json).result(&table.to_string(), &written)?;
    Ok(Outcome::Done)
}

/// Packs one document with every library this program holds.
pub(crate) fn pack(document: &str, file: &str, step: Option<f64>) -> Result<Packed, Failure> {
    // What is no JSON has no schema either, but a place to name.
    serde_json::from_str::<serde::de::IgnoredAny>(document).map_err(|e| {
        let (line, column) = (e.line(), e.column());
        let text = e.to_string();
        let problem = text.rsplit_once(" at line ").map_or(text.as_str(), |(head, _)| head);
        Failure::new(
            format!("{file}:{line}:{column}: {problem}"),
            "give a JSON file that steerwright wrote",
        )
    })?;
    let fmu = packaging::fmu_of(document, file)?;
    let binaries: Vec<Binary<'_>> = fmu_binaries::of(fmu.name())
        .map(|l| Binary { platform: l.platform, bytes: l.bytes })
        .collect();
    packaging::package(document, file, &binaries, step).map_err(|e| {
        // A slave's own hint stands in its message, since an importer shows nothing else.
        match e.to_string().split_once("; hint: ") {
            Some((message, hint)) => Failure::new(message, hint),
            None => e.into(),
        }
    })
}

/// Writes an archive under its FMU's name.
pub(crate) fn write(folder: &Path, archive: &Packed) -> Result<PathBuf, Failure> {
    let file = folder.join(format!("{}.fmu", archive.fmu.name()));
    files::write(&file, &archive.bytes)?;
    Ok(file)
}
