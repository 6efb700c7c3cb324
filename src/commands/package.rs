//! `steerwright package`: FMU archives from the stages' files.

use crate::documents::files;
use crate::documents::gate::{self, GateArguments};
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::quantity;
use crate::output::{Output, OutputKind, Outputs};
use crate::terminal::console;
use crate::terminal::progress::Progress;
use serde::Serialize;
use std::path::{Path, PathBuf};
use steerwright_comparison::BehindActuator;
use steerwright_formats::StatedActuator;
use steerwright_packaging::Fmu;

/// Pack FMUs: one archive for each plant, bicycle, vehicle, longitudinal, controller, path or estimator file,
/// without a compiler
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// plant.json, bicycle.json, vehicle.json, longitudinal.json, pid.json, speed_controller.json, path.json or
    /// estimator.json
    #[arg(required = true, value_name = "FILE.json")]
    files: Vec<PathBuf>,
    /// Folder for the archives
    #[arg(long, short, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Step size that the archives recommend, such as 10ms; by default the controller's sample time in its archive,
    /// and with --ssp in all, otherwise 10ms
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    step: Option<f64>,
    /// Also connect variables of equal name and write the FMUs as a system structure package (SSP 1.0)
    /// into the folder. With a path file they start on its first point, at its speed. With an estimator
    /// file, path and controller use its pose; its fixes are the pose of the plant, as of a receiver
    /// without latency or antenna offset: one every gnss.period_s (by default 0.1 s) of gnss.std_m
    /// (0.02 m). A path or estimator without a sideslip uses that of the plant. A plant of a measured angle is packed behind
    /// the actuator that the controller was designed for. The variant SpeedInput of the
    /// package has one input, speed, for all FMUs
    #[arg(long, value_name = "NAME.ssp")]
    ssp: Option<PathBuf>,
    #[command(flatten)]
    gate: GateArguments,
}

/// The files written, for scripts.
#[derive(Serialize, Default)]
struct WrittenArchive {
    /// Absent for the package of the loop.
    #[serde(skip_serializing_if = "Option::is_none")]
    fmu: Option<&'static str>,
    file: PathBuf,
    #[serde(skip_serializing_if = "Option::is_none")]
    guid: Option<String>,
    bytes: usize,
    /// What stands before the model in this archive.
    #[serde(skip_serializing_if = "Option::is_none")]
    actuator: Option<StatedActuator>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    platforms: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    connections: Option<Vec<String>>,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let documents = arguments
        .files
        .iter()
        .map(|file| Ok((file, files::read_text(file)?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let mut known: Vec<(Fmu, &PathBuf)> = Vec::new();
    for (file, text) in &documents {
        let fmu = steerwright_comparison::fmu_of(text, &file.display().to_string())?;
        if let Some((_, other)) = known.iter().find(|(other, _)| *other == fmu) {
            return Err(Failure::new(
                format!("{} and {} both make {}.fmu", other.display(), file.display(), fmu.name()),
                "pack them into different folders",
            ));
        }
        if let Some(quality) = gate::quality_of(text, &file.display().to_string())? {
            arguments.gate.check(&file.display().to_string(), &quality)?;
        }
        known.push((fmu, file));
    }
    let mut outputs = Outputs::new(global.force, &arguments.files);
    let mut archives: Vec<(Fmu, Output)> = Vec::new();
    for (fmu, _) in known {
        let file = arguments.out.join(format!("{}.fmu", fmu.name()));
        archives.push((fmu, outputs.file(file, OutputKind::Fmu)?));
    }
    let ssp = match &arguments.ssp {
        None => None,
        Some(file) => {
            Some((ssp_name(file)?, outputs.file(arguments.out.join(file), OutputKind::Ssp)?))
        }
    };
    let names: Vec<String> = documents.iter().map(|(file, _)| file.display().to_string()).collect();
    let mut named: Vec<(&str, &str)> = documents
        .iter()
        .zip(&names)
        .map(|((_, text), name)| (text.as_str(), name.as_str()))
        .collect();
    let behind = steerwright_comparison::behind_stated_actuator(&named)?;
    // Of the plant in the loop; alone it is its document.
    let mut actuator = None;
    if let Some(BehindActuator { file, document: Some(document), actuator: stated }) = &behind
        && ssp.is_some()
    {
        actuator = Some(*stated);
        for (text, name) in &mut named {
            if *name == file {
                *text = document;
            }
        }
    }
    let progress = Progress::start("packing");
    let (packed, package) = match &ssp {
        None => {
            let each = named
                .iter()
                .map(|(text, file)| steerwright_comparison::pack(text, file, arguments.step));
            (each.collect::<Result<Vec<_>, _>>()?, None)
        }
        Some((name, out)) => {
            let packed = steerwright_comparison::pack_loop(name, &named, arguments.step)?;
            (packed.fmus, Some((out, packed.connections, packed.bytes)))
        }
    };
    drop(progress);
    let mut written = Vec::new();
    for archive in &packed {
        let Some((_, out)) = archives.iter().find(|(fmu, _)| *fmu == archive.fmu) else { continue };
        out.write(&archive.bytes)?;
        written.push(WrittenArchive {
            fmu: Some(archive.fmu.name()),
            file: out.path().into(),
            guid: Some(archive.description.guid.clone()),
            bytes: archive.bytes.len(),
            actuator: if archive.fmu.is_plant() { actuator } else { None },
            platforms: steerwright_binaries::libraries_of(archive.fmu.name())
                .map(|l| l.platform)
                .collect(),
            ..WrittenArchive::default()
        });
    }
    let mut wired = String::new();
    if let Some((out, connections, bytes)) = package {
        out.write(&bytes)?;
        let connections: Vec<String> = connections.iter().map(ToString::to_string).collect();
        wired = match connections.is_empty() {
            true => format!("\nnothing is wired in {out}: no output has the name of an input"),
            false => format!("\nwired in {out}:\n  {}", connections.join("\n  ")),
        };
        written.push(WrittenArchive {
            file: out.path().into(),
            bytes: bytes.len(),
            connections: Some(connections),
            ..WrittenArchive::default()
        });
    }
    let mut table = steerwright_report::Table::new(["archive", "size", "platforms", "GUID"]);
    for w in &written {
        table = table.row([
            w.file.display().to_string(),
            format!("{} kB", w.bytes.div_ceil(1000)),
            w.platforms.join(" "),
            w.guid.clone().unwrap_or_default(),
        ]);
    }
    if let Some(behind) = &behind {
        report_actuator(behind, ssp.is_some());
    }
    console::result(&format!("{}{wired}", console::table(&table)), &written)?;
    Ok(Outcome::Done)
}

/// Says whether the archive of a model has the actuator that the controller was designed for.
fn report_actuator(behind: &BehindActuator, is_in_loop: bool) {
    let [lag, delay] = [behind.actuator.time_constant_s, behind.actuator.delay_s].map(|s| 1e3 * s);
    let actuator = format!(
        "the controller's actuator, with a lag of {lag:.1} ms and a delay of {delay:.1} ms"
    );
    let file = &behind.file;
    match (&behind.document, is_in_loop) {
        (Some(_), true) => console::note(format_args!("{file} is packed behind {actuator}")),
        (Some(_), false) => console::warning(format_args!(
            "{file} is packed without {actuator}; --ssp packs it behind the actuator"
        )),
        (None, _) => console::warning(format_args!(
            "{file} is packed without {actuator}: it is not the model of the design, and has an actuator of its own"
        )),
    }
}

/// The name of a package's system: that of its file.
fn ssp_name(file: &Path) -> Result<&str, Failure> {
    let is_ssp = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("ssp"));
    file.file_stem().and_then(|stem| stem.to_str()).filter(|_| is_ssp).ok_or_else(|| {
        let hint = "use a name such as LateralLoop.ssp";
        Failure::new(format!("--ssp {}: not the name of an .ssp file", file.display()), hint)
    })
}
