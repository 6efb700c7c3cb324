//! From a study to a wired system: archives opened, connections made, times found.

use crate::Error;
use crate::study::Study;
use std::path::PathBuf;
use steerwright_host::{
    Archive, Connection, Error as HostError, Grid, Instance, Linear, Measurement, System,
    SystemPackage, Unit, recommended_experiment,
};
use toml::Spanned;

/// The opened archives, kept for as long as instances are made of them.
#[derive(Debug)]
pub(crate) enum Source {
    Package(Box<SystemPackage>),
    Files(Vec<(String, Archive)>),
}

impl Source {
    /// The archives, in the order of the system's instances.
    pub(crate) fn archives(&self) -> Vec<&Archive> {
        match self {
            Self::Package(package) => package.archives().collect(),
            Self::Files(files) => files.iter().map(|(_, archive)| archive).collect(),
        }
    }
}

pub(crate) struct Wired {
    pub(crate) source: Source,
    /// One instance of each archive, for its description; it is not run.
    pub(crate) system: System,
    pub(crate) files: Vec<PathBuf>,
    /// Ignored parts of a package.
    pub(crate) remarks: Vec<String>,
    pub(crate) grid: Grid,
}

pub(crate) fn connect(study: &Study, measurements: &[Measurement<'_>]) -> Result<Wired, Error> {
    let (source, files) = open(study)?;
    let (grid, differing) = grid(study, &source)?;
    let mut remarks = Vec::new();
    let system = match &source {
        Source::Package(package) => {
            let at = study.raw.ssp.as_ref();
            let (mut system, left_out) = package.system().map_err(|e| host(study, at, e))?;
            remarks.extend(left_out);
            explicit(study, &mut system)?;
            system
        }
        Source::Files(files) => {
            let mut system = System::new();
            for ((name, archive), entry) in files.iter().zip(&study.raw.fmu) {
                let located = |e| host(study, Some(entry), e);
                system.add(Instance::new(archive, name).map_err(located)?).map_err(located)?;
            }
            explicit(study, &mut system)?;
            by_name(study, measurements, &mut system)?;
            system
        }
    };
    remarks.extend(differing.map(|differing| format!("{differing}; start_s is {}", grid.start)));
    Ok(Wired { source, system, files, remarks, grid })
}

/// An error of the host, with the entry of the study that led to it.
pub(crate) fn host<T>(study: &Study, at: Option<&Spanned<T>>, error: HostError) -> Error {
    let at = match at {
        Some(entry) => study.place(entry),
        None => study.top(),
    };
    Error::System { at, source: Box::new(error) }
}

/// `instance.variable`.
pub(crate) fn split<'a>(
    study: &Study,
    path: &'a Spanned<String>,
) -> Result<(&'a str, &'a str), Error> {
    path.get_ref().split_once('.').ok_or_else(|| {
        let error = HostError::BadPath { text: path.get_ref().clone(), with_value: false };
        host(study, Some(path), error)
    })
}

fn open(study: &Study) -> Result<(Source, Vec<PathBuf>), Error> {
    if let Some(ssp) = &study.raw.ssp {
        if let Some(fmu) = study.raw.fmu.first() {
            let hint = "keep one of the two: a package has its FMUs in it";
            return Err(study.fault(fmu, "an [[fmu]] and an ssp", hint));
        }
        let path = study.file(ssp.get_ref());
        let package = SystemPackage::open(&path).map_err(|e| host(study, Some(ssp), e))?;
        return Ok((Source::Package(Box::new(package)), vec![path]));
    }
    if study.raw.fmu.is_empty() {
        return Err(Error::Study {
            at: study.top(),
            problem: "no system: there is neither an ssp nor an [[fmu]]".to_owned(),
            hint: "name a package, ssp = \"LateralLoop.ssp\", or a file in each [[fmu]]",
        });
    }
    let mut archives = Vec::new();
    let mut paths = Vec::new();
    for entry in &study.raw.fmu {
        let fmu = entry.get_ref();
        let path = study.file(fmu.file.get_ref());
        let archive = Archive::open(&path).map_err(|e| host(study, Some(&fmu.file), e))?;
        let name = fmu.name.clone().unwrap_or_else(|| archive.unit_name());
        archives.push((name, archive));
        paths.push(path);
    }
    Ok((Source::Files(archives), paths))
}

/// Start, step and number of steps: of the study, else of the package, else as the FMUs
/// recommend, with a remark where their starts differ.
fn grid(study: &Study, source: &Source) -> Result<(Grid, Option<String>), Error> {
    let archives = source.archives();
    let (recommended, differing) = recommended_experiment(archives.iter().copied());
    let (of_package, stop_of_package, step_of_package) = match source {
        Source::Package(package) => {
            let structure = package.structure();
            (structure.start_time, structure.stop_time, structure.step)
        }
        Source::Files(_) => (None, None, None),
    };
    let stated_start = study.raw.start_s.or(of_package);
    let start = stated_start.or(recommended.start_time).unwrap_or(0.0);
    let step = study.raw.step_s.as_ref().map(|s| *s.get_ref()).or(step_of_package);
    let stop = study.raw.stop_s.as_ref().map(|s| *s.get_ref()).or(stop_of_package);
    let missing = |key: &str, hint| Error::Study {
        at: study.top(),
        problem: format!("no {key}, and no FMU recommends one"),
        hint,
    };
    let step = step.or(recommended.step_size);
    let step = step.ok_or_else(|| missing("step_s", "set it, as in step_s = 0.01"))?;
    let stop = stop.or(recommended.stop_time);
    let stop = stop.ok_or_else(|| missing("stop_s", "set it, as in stop_s = 20.0"))?;
    let stated = study.raw.step_s.as_ref().or(study.raw.stop_s.as_ref());
    let steps = steerwright_host::grid(start, stop, step).map_err(|e| host(study, stated, e))?;
    let grid = Grid { start, stop, step, steps };
    // The FMUs get the last communication point.
    let differing = differing.filter(|_| stated_start.is_none());
    Ok((Grid { stop: grid.time(steps), ..grid }, differing))
}

/// The connections that the study writes out.
fn explicit(study: &Study, system: &mut System) -> Result<(), Error> {
    for entry in &study.raw.connect {
        let stated = entry.get_ref();
        let (from, output) = split(study, &stated.from)?;
        let (to, input) = split(study, &stated.to)?;
        let connection = Connection::new(from, output, to, input);
        let located = |e| host(study, Some(entry), e);
        if stated.factor.is_none() && stated.offset.is_none() {
            system.connect(connection).map_err(located)?;
            continue;
        }
        let scale =
            Linear { factor: stated.factor.unwrap_or(1.0), offset: stated.offset.unwrap_or(0.0) };
        if !(scale.factor.is_finite() && scale.offset.is_finite()) {
            let hint = "use finite numbers";
            return Err(study.fault(entry, "factor or offset is no finite number", hint));
        }
        system.connect_scaled(connection, scale).map_err(located)?;
    }
    Ok(())
}

/// Wires each free input by its name, as renamed: [`steerwright_host::wires_by_name`].
fn by_name(
    study: &Study,
    measurements: &[Measurement<'_>],
    system: &mut System,
) -> Result<(), Error> {
    let all = system.instances();
    for (instance, entry) in all.iter().zip(&study.raw.fmu) {
        for variable in entry.get_ref().rename.keys() {
            instance.variable(variable.get_ref()).map_err(|e| host(study, Some(variable), e))?;
        }
    }
    let units: Vec<Unit<'_>> = all
        .iter()
        .zip(&study.raw.fmu)
        .map(|(instance, entry)| {
            let renamed = entry.get_ref().rename.iter();
            Unit {
                renamed: renamed.map(|(own, new)| (own.get_ref().as_str(), &**new)).collect(),
                ..Unit::new(instance.name(), instance.model().variables())
            }
        })
        .collect();
    let is_fed = |unit: &Unit<'_>, input: &str| {
        system.connections().iter().any(|c| c.to == unit.name && c.input == input)
    };
    let index_of = |name: &str| all.iter().position(|i| i.name() == name).unwrap_or(0);
    let found =
        steerwright_host::wires_by_name(&units, measurements, &is_fed).map_err(|error| {
            let at = match &error {
                HostError::Ambiguous { to, .. } => index_of(to.split('.').next().unwrap_or(to)),
                _ => 0,
            };
            host(study, study.raw.fmu.get(at), error)
        })?;
    let found: Vec<(usize, Connection)> = found.into_iter().map(|c| (index_of(&c.to), c)).collect();
    for (to, connection) in found {
        let located = |e| host(study, Some(&study.raw.fmu[to]), e);
        system.connect(connection).map_err(located)?;
    }
    Ok(())
}
