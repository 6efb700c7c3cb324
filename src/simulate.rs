//! `steerwright simulate`: archives, or a system structure package, in closed loop.

use crate::failure::{Failure, Outcome};
use crate::output::{Kind, Outputs};
use crate::progress::Progress;
use crate::{Global, console, quantity};
use serde::Serialize;
use std::path::PathBuf;
use steerwright_host::{
    Archive, Connection, Coupling, Error, InputTable, Instance, Status, System, SystemPackage,
    Value,
};

/// Simulate FMUs together; outputs and inputs of equal name are connected, or as an .ssp states
///
/// With a PoseEstimator, path and controller use the estimate, and its gnss_x and gnss_y are the x and
/// y of the plant unless --input has columns for them. It uses such a fix every gnss_period, which a
/// package (`package --ssp`) sets; the fixes of --input are marked by gnss_fix_count and gnss_std.
///
/// The binaries of the FMUs run in this process: a crash ends it without a message. To try an FMU in a
/// separate process, run `steerwright check --run` on it.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Archives, in the order in which a Gauss–Seidel master steps them: plant, pose estimator, path,
    /// controller; or one .ssp with its connections
    #[arg(required = true, value_name = "FMU|SSP")]
    fmus: Vec<PathBuf>,
    /// Write the trajectories here as CSV
    #[arg(long = "output", short = 'o', value_name = "CSV", default_value = "result.csv")]
    out: PathBuf,
    /// Communication step; by default the smallest that an FMU recommends
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    step: Option<f64>,
    /// Length of the simulation; by default the longest that an FMU recommends
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    stop: Option<f64>,
    /// Order of the FMUs within a step
    #[arg(long, value_enum, default_value = "gauss-seidel")]
    master: MasterName,
    /// Set a parameter or a free input, such as LateralPid.kp=1.2; may be repeated
    #[arg(long, value_name = "NAME.VARIABLE=VALUE")]
    set: Vec<String>,
    /// CSV of free inputs with a column `time`; values are held between rows
    #[arg(long, value_name = "CSV")]
    input: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum MasterName {
    /// Each FMU sees what those before it have just computed
    GaussSeidel,
    /// All FMUs see the values at the start of the step
    Jacobi,
}

/// The result, for scripts.
#[derive(Serialize)]
struct Done {
    file: PathBuf,
    connections: Vec<String>,
    steps: usize,
    step_s: f64,
    last: std::collections::BTreeMap<String, f64>,
    warnings: Vec<String>,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let inputs = arguments.fmus.iter().chain(&arguments.input);
    let out = Outputs::new(global.force, inputs).file(&arguments.out, Kind::Recording)?;
    let Setup { mut system, connections, start, step, stop, remarks } = setup(arguments)?;
    out.check_columns(&system.recorded()?)?;
    // Before the run, since they may explain its failure.
    for remark in &remarks {
        console::warning(remark);
    }
    for text in &arguments.set {
        system.set_text(text)?;
    }
    let master = match arguments.master {
        MasterName::GaussSeidel => Coupling::GaussSeidel,
        MasterName::Jacobi => Coupling::Jacobi,
    };
    let progress = Progress::start(format!("simulating {stop} s"));
    let recording = system.run(master, start, stop, step)?;
    drop(progress);
    let of_the_run = warnings(&mut system)?;
    out.write(recording.to_csv().as_bytes())?;

    let last = recording.rows.last().cloned().unwrap_or_default();
    of_the_run.iter().for_each(console::warning);
    let done = Done {
        file: arguments.out.clone(),
        connections: connections.iter().map(ToString::to_string).collect(),
        steps: recording.times.len().saturating_sub(1),
        step_s: step,
        last: recording.names.iter().cloned().zip(last.iter().copied()).collect(),
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
    console::note(format!("written to {out}"));
    Ok(Outcome::Done)
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
fn setup(arguments: &Arguments) -> Result<Setup, Failure> {
    let is_ssp = |file: &PathBuf| file.extension().is_some_and(|e| e.eq_ignore_ascii_case("ssp"));
    if let [file] = &arguments.fmus[..]
        && is_ssp(file)
    {
        let package = SystemPackage::open(file)?;
        let structure = package.structure();
        let stated = Experiment {
            start: structure.start_time.unwrap_or(0.0),
            stop: structure.stop_time,
            step: structure.step,
        };
        let (start, step, stop) = experiment(arguments, package.archives(), stated)?;
        let (mut system, remarks) = package.system().map_err(explained)?;
        if let Some(input) = &arguments.input {
            system.feed(InputTable::open(input)?);
        }
        let connections = system.connections().to_vec();
        return Ok(Setup { system, connections, start, step, stop, remarks });
    }
    if let Some(file) = arguments.fmus.iter().find(|file| is_ssp(file)) {
        return Err(Failure::new(
            format!("{} is combined with other files", file.display()),
            "use one .ssp alone, or .fmu files",
        ));
    }
    let archives = arguments
        .fmus
        .iter()
        .map(|file| Ok(Archive::open(file)?))
        .collect::<Result<Vec<_>, Failure>>()?;
    let (start, step, stop) = experiment(arguments, archives.iter(), Experiment::default())?;
    let mut system = system_of(&archives)?;
    if let Some(input) = &arguments.input {
        system.feed(InputTable::open(input)?);
    }
    let connections =
        system.connect_by_name(&steerwright_packaging::ssp::MEASUREMENTS).map_err(explained)?;
    let remarks = unused_receiver(&system, &connections, &arguments.set);
    Ok(Setup { system, connections, start, step, stop, remarks })
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

/// The experiment of a package, s.
#[derive(Default)]
struct Experiment {
    start: f64,
    stop: Option<f64>,
    step: Option<f64>,
}

/// Start, step and stop: of the options, otherwise of the package, otherwise as the archives recommend.
fn experiment<'a>(
    arguments: &Arguments,
    archives: impl Iterator<Item = &'a Archive>,
    stated: Experiment,
) -> Result<(f64, f64, f64), Failure> {
    let recommended: Vec<_> =
        archives.filter_map(|a| a.model().description().default_experiment).collect();
    let steps = recommended.iter().filter_map(|e| e.step_size);
    let stops = recommended.iter().filter_map(|e| e.stop_time);
    let step = arguments.step.or(stated.step).or_else(|| steps.reduce(f64::min));
    let stop = arguments.stop.or(stated.stop).or_else(|| stops.reduce(f64::max));
    match (step, stop) {
        (Some(step), Some(stop)) if step > 0.0 && stop > stated.start => {
            Ok((stated.start, step, stop))
        }
        (None, _) => {
            Err(Failure::new("no FMU recommends a step", "state one, such as --step 10ms"))
        }
        (_, None) => {
            Err(Failure::new("no FMU recommends a stop time", "state one, such as --stop 10s"))
        }
        (Some(step), Some(stop)) => Err(Failure::new(
            format!(
                "step {step} s and stop {stop} s: the step must be above 0, the stop after the \
                 start at {} s",
                stated.start
            ),
            "change --step or --stop",
        )),
    }
}

/// One instance of each archive, named after its model.
fn system_of(archives: &[Archive]) -> Result<System, Failure> {
    let mut system = System::new();
    for archive in archives {
        let name = archive.model().description().model_name.clone();
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
            Failure::new(&error, "use one FMU of each model: its name identifies their variables")
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
