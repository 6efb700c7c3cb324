//! `steerwright simulate`: archives, or a system structure package, in closed loop.

use crate::documents::files;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::quantity;
use crate::options::specification::CouplingName;
use crate::output::{Output, OutputKind, Outputs};
use crate::process::guard::KeptRows;
use crate::terminal::console;
use crate::terminal::progress::Progress;
use serde::Serialize;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use steerwright_host::{
    Archive, Connection, Coupling, DefaultExperiment, Error, InputTable, Instance, Recording,
    Status, System, SystemPackage, Value, recommended_experiment,
};

/// Simulate FMUs together; outputs and inputs of equal name are connected, or as an .ssp states
///
/// With a PoseEstimator, path and controller use the estimate, and its gnss_x and gnss_y are the x and
/// y of the plant unless --input has columns for them. It uses such a fix every gnss_period, which a
/// package (`package --ssp`) sets; the fixes of --input are marked by gnss_fix_count and gnss_std.
///
/// The binaries of the FMUs run in a process of their own: one that crashes or ends it is an error, and the
/// rows until then are written. `steerwright check --run` names the call in which an FMU does so.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Archives, in the order in which a Gauss–Seidel coupling steps them: plant, pose estimator, path,
    /// controller; or one .ssp with its connections. A unit has the name of its model, of its file where
    /// that has dots, or NAME
    #[arg(required = true, value_name = "[NAME=]FMU|SSP")]
    fmus: Vec<OsString>,
    /// Write the trajectories here as CSV
    #[arg(long = "output", short = 'o', value_name = "CSV", default_value = "result.csv")]
    out: PathBuf,
    /// Communication step; by default the smallest that an FMU recommends
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    step: Option<f64>,
    /// Start time; by default the earliest that an FMU recommends, or 0
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    start: Option<f64>,
    /// Stop time; by default the latest that an FMU recommends
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    stop: Option<f64>,
    /// Order of the FMUs within a step
    #[arg(long, alias = "master", value_enum, default_value = "gauss-seidel")]
    coupling: CouplingName,
    /// Set a parameter or a free input, such as LateralPid.kp=1.2; may be repeated
    #[arg(long, value_name = "NAME.VARIABLE=VALUE")]
    set: Vec<String>,
    /// CSV of free inputs with a column `time`; values are held between rows and replace the start values of an
    /// .ssp. A column is named NAME.INPUT, as a connector of the .ssp, or INPUT for all of that name
    #[arg(long, value_name = "CSV")]
    input: Option<PathBuf>,
    /// Structure of the .ssp to run, the name of its .ssd file, such as SpeedInput; by default SystemStructure
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
}

/// The result, for scripts.
#[derive(Serialize)]
struct Done {
    file: PathBuf,
    connections: Vec<String>,
    steps: usize,
    step_s: f64,
    last: std::collections::BTreeMap<String, f64>,
    /// The FMU that ended the simulation before its stop time, and when.
    #[serde(skip_serializing_if = "Option::is_none")]
    ended: Option<String>,
    warnings: Vec<String>,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let units = arguments.units();
    let out = arguments.output(&units, global)?;
    let Setup { mut system, connections, start, step, stop, remarks } = setup(arguments, &units)?;
    out.check_columns(&system.recorded()?)?;
    // Before the run, since they may explain its failure.
    for remark in &remarks {
        console::warning(remark);
    }
    for text in &arguments.set {
        system.set_text(text)?;
    }
    let coupling = match arguments.coupling {
        CouplingName::GaussSeidel => Coupling::GaussSeidel,
        CouplingName::Jacobi => Coupling::Jacobi,
    };
    let progress = Progress::start(format!("simulating {} s", stop - start));
    let mut recording = Recording::default();
    let mut kept = KeptRows::new();
    let result = system.run_into(&mut recording, coupling, start, stop, step, |recording| {
        if recording.rows.len() == 1 {
            kept.write(&recording.csv_header());
        }
        kept.write(&recording.csv_last_row());
    });
    drop(progress);
    let mut of_the_run = warnings(&mut system)?;
    of_the_run.extend(kept.error().map(|error| {
        format!("an FMU that had crashed would have lost rows, since a temporary file cannot be written: {error}")
    }));
    if !recording.rows.is_empty() {
        out.write(recording.to_csv().as_bytes())?;
    }
    let ended = match result {
        Ok(()) => None,
        Err(error @ Error::Terminated { .. }) => Some(error.to_string()),
        Err(error) => return Err(failed(error, &recording, &out)),
    };

    of_the_run.iter().for_each(console::warning);
    let last = recording.rows.last().cloned().unwrap_or_default();
    let done = Done {
        file: arguments.out.clone(),
        connections: connections.iter().map(ToString::to_string).collect(),
        steps: recording.times.len().saturating_sub(1),
        step_s: step,
        last: recording.names.iter().cloned().zip(last.iter().copied()).collect(),
        ended,
        warnings: remarks.into_iter().chain(of_the_run).collect(),
    };
    let mut table = steerwright_report::Table::new(["variable", "unit", "last value"]);
    for ((name, unit), value) in recording.names.iter().zip(&recording.units).zip(&last) {
        let unit = unit.clone().unwrap_or_default();
        table = table.row([name.clone(), unit, format!("{value:.6}")]);
    }
    let wired = match done.connections.join("\n  ") {
        none if none.is_empty() => "nothing is wired".to_owned(),
        some => format!("wired:\n  {some}"),
    };
    let text = format!("{wired}\n\n{}\n{} steps of {step} s", console::table(&table), done.steps);
    console::result(&text, &done)?;
    if let Some(ended) = &done.ended {
        console::note(ended);
    }
    console::note(format!("written to {out}"));
    Ok(Outcome::Done)
}

impl Arguments {
    fn units(&self) -> Vec<Unit> {
        self.fmus.iter().map(|text| Unit::new(text)).collect()
    }

    fn output(&self, units: &[Unit], global: &Global) -> Result<Output, Failure> {
        let inputs = units.iter().map(|unit| &unit.file).chain(&self.input);
        Outputs::new(global.force, inputs).file(&self.out, OutputKind::Recording)
    }

    /// Writes the rows of a run that an FMU ended with the process, as CSV; returns a statement of where they are.
    pub(crate) fn keep(&self, rows: &str, global: &Global) -> Result<Option<String>, Failure> {
        let mut lines = rows.lines();
        let _header = lines.next();
        let Some(last) = lines.next_back() else { return Ok(None) };
        let out = self.output(&self.units(), global)?;
        out.write(rows.as_bytes())?;
        let time = last.split(',').next().unwrap_or_default();
        let count = lines.count() + 1;
        Ok(Some(format!("{out} has its {} until t = {time} s", counted(count))))
    }
}

fn counted(rows: usize) -> String {
    if rows == 1 { "1 row".into() } else { format!("{rows} rows") }
}

/// The failure of a run, with what is kept of it.
fn failed(error: Error, recording: &Recording, out: &impl std::fmt::Display) -> Failure {
    let Some(last) = recording.times.last() else { return error.into() };
    let rows = counted(recording.rows.len());
    let message = format!("the run failed after t = {last} s; {out} has its {rows}: {error}");
    Failure::new(message, error.hint())
}

/// A file of the command line, and the name of its unit where one is stated: `NAME=FILE`.
struct Unit {
    name: Option<String>,
    file: PathBuf,
}

impl Unit {
    fn new(text: &OsStr) -> Self {
        let whole = Self { name: None, file: text.into() };
        match text.to_str().and_then(|text| text.split_once('=')) {
            // The name of a file or of its folder may have the character.
            Some((name, file)) if !whole.file.exists() && !name.contains(['/', '\\']) => {
                Self { name: Some(name.into()), file: file.into() }
            }
            _ => whole,
        }
    }

    fn is_ssp(&self) -> bool {
        self.file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ssp"))
    }
}

struct Setup {
    system: System,
    connections: Vec<Connection>,
    start: f64,
    step: f64,
    stop: f64,
    /// Statements of a package that are not used.
    remarks: Vec<String>,
}

/// The system of the FMUs, wired by name, or of the package.
fn setup(arguments: &Arguments, units: &[Unit]) -> Result<Setup, Failure> {
    if let [Unit { name: None, file }] = units
        && units[0].is_ssp()
    {
        let package = match &arguments.variant {
            None => SystemPackage::open(file)?,
            Some(variant) => SystemPackage::open_variant(file, variant)?,
        };
        let structure = package.structure();
        let stated = DefaultExperiment {
            start_time: structure.start_time,
            stop_time: structure.stop_time,
            step_size: structure.step,
            tolerance: None,
        };
        let mut remarks = remarks(package.archives());
        let (start, step, stop) = experiment(arguments, package.archives(), stated, &mut remarks)?;
        let (mut system, of_package) = package.system().map_err(explained)?;
        remarks.extend(of_package);
        if let Some(input) = &arguments.input {
            system.feed(InputTable::open(input)?);
        }
        let connections = system.connections().to_vec();
        return Ok(Setup { system, connections, start, step, stop, remarks });
    }
    if let Some(unit) = units.iter().find(|unit| unit.is_ssp()) {
        let problem = match units {
            [_] => "a package is given the name of a unit",
            _ => "is combined with other files",
        };
        return Err(Failure::new(
            format!("{} {problem}", unit.file.display()),
            "use one .ssp alone, or .fmu files",
        ));
    }
    if arguments.variant.is_some() {
        let hint = "leave the option out, or simulate one .ssp";
        return Err(Failure::new(
            "--variant names a structure of an .ssp, and there is none",
            hint,
        ));
    }
    let archives =
        units.iter().map(|unit| open(&unit.file)).collect::<Result<Vec<_>, Failure>>()?;
    let mut remarks = remarks(archives.iter());
    let nothing = DefaultExperiment::default();
    let (start, step, stop) = experiment(arguments, archives.iter(), nothing, &mut remarks)?;
    let mut system = system_of(units, &archives)?;
    if let Some(input) = &arguments.input {
        system.feed(InputTable::open(input)?);
    }
    let connections =
        system.connect_by_name(&steerwright_packaging::ssp::MEASUREMENTS).map_err(explained)?;
    remarks.extend(unused_receiver(&system, &connections, &arguments.set));
    Ok(Setup { system, connections, start, step, stop, remarks })
}

/// The archive of a file; a document, from which one is made, is named as such.
fn open(file: &Path) -> Result<Archive, Failure> {
    match Archive::open(file) {
        Err(Error::NotAnArchive { .. }) if is_document(file) => Err(Failure::new(
            format!("{}: a document, which no FMU is", file.display()),
            format!("make its FMU first: steerwright package {}", file.display()),
        )),
        opened => Ok(opened?),
    }
}

fn is_document(file: &Path) -> bool {
    let text = files::read_text(file).unwrap_or_default();
    steerwright_formats::schema_of(&text).is_some_and(|schema| schema.starts_with("steerwright/"))
}

/// Breaches of the standard with which the archives are run all the same, each once.
fn remarks<'a>(archives: impl Iterator<Item = &'a Archive>) -> Vec<String> {
    let mut remarks: Vec<String> = archives.flat_map(|a| a.remarks().iter().cloned()).collect();
    remarks.dedup();
    remarks
}

/// Pose estimators that receive the position of the plant without an indication of fixes.
fn unused_receiver(system: &System, connections: &[Connection], set: &[String]) -> Vec<String> {
    let is_zero = |unit: &str, name: &str| {
        let instance = system.instances().iter().find(|i| i.name() == unit);
        let variable = instance.and_then(|i| i.variable(name).ok());
        let given = set.iter().any(|text| text.starts_with(&format!("{unit}.{name}=")));
        !given && variable.is_some_and(|v| v.start == Some(Value::Real(0.0)))
    };
    let fixed = connections.iter().filter(|c| c.input == "gnss_x" && c.output == "x");
    let unused =
        fixed.filter(|c| ["gnss_period", "gnss_std"].iter().any(|name| is_zero(&c.to, name)));
    unused
        .map(|c| {
            format!(
                "{to} receives {from}.x and y and uses none of them as a fix: it dead-reckons; set \
                 {to}.gnss_period, {to}.gnss_std and {to}.gnss_latency=0, or wire the loop by \
                 package --ssp",
                to = c.to,
                from = c.from
            )
        })
        .collect()
}

/// Start, step and stop, s: of the options, otherwise of the package, otherwise as the archives recommend.
fn experiment<'a>(
    arguments: &Arguments,
    archives: impl Iterator<Item = &'a Archive>,
    stated: DefaultExperiment,
    remarks: &mut Vec<String>,
) -> Result<(f64, f64, f64), Failure> {
    let (recommended, differing) = recommended_experiment(archives);
    let stated_start = arguments.start.or(stated.start_time);
    let start = stated_start.or(recommended.start_time).unwrap_or(0.0);
    if stated_start.is_none() {
        remarks
            .extend(differing.map(|text| format!("{text}: the run starts at {start} s (--start)")));
    }
    let step = arguments.step.or(stated.step_size).or(recommended.step_size);
    let stop = arguments.stop.or(stated.stop_time).or(recommended.stop_time);
    match (step, stop) {
        (Some(step), Some(stop)) if step > 0.0 && stop > start => Ok((start, step, stop)),
        (None, _) => {
            Err(Failure::new("no FMU recommends a step", "state one, such as --step 10ms"))
        }
        (_, None) => {
            Err(Failure::new("no FMU recommends a stop time", "state one, such as --stop 10s"))
        }
        (Some(step), Some(stop)) => Err(Failure::new(
            format!(
                "start {start} s, step {step} s and stop {stop} s: the step must be above 0, the \
                 stop after the start"
            ),
            "change --start, --step or --stop",
        )),
    }
}

/// One instance of each archive, with the name of its unit.
fn system_of(units: &[Unit], archives: &[Archive]) -> Result<System, Failure> {
    let mut system = System::new();
    for (unit, archive) in units.iter().zip(archives) {
        let name = unit.name.clone().unwrap_or_else(|| archive.unit_name());
        system.add(Instance::new(archive, &name)?).map_err(explained)?;
    }
    Ok(system)
}

/// Errors of the connections, with hints for the command line.
fn explained(error: Error) -> Failure {
    match error {
        Error::Ambiguous { .. } => {
            Failure::new(&error, "omit all but one of the FMUs that have this output")
        }
        Error::DuplicateInstance { .. } => {
            Failure::new(&error, "name the units, as in front=A.fmu rear=A.fmu")
        }
        Error::InstanceName { .. } => {
            Failure::new(&error, "name the unit without dots, as in car=Plants.Car.fmu")
        }
        error => error.into(),
    }
}

/// Warnings of the FMUs, each once.
fn warnings(system: &mut System) -> Result<Vec<String>, Failure> {
    let names: Vec<String> = system.instances().iter().map(|i| i.name().to_owned()).collect();
    let mut warnings = Vec::new();
    for name in names {
        for line in system.instance_mut(&name)?.take_log() {
            let text = format!("{name}: {}", line.message);
            if line.status != Status::Ok && !warnings.contains(&text) {
                warnings.push(text);
            }
        }
    }
    Ok(warnings)
}
