//! A loop of three FMUs in C, packed into a folder, and studies of it.
#![allow(dead_code)] // each test file uses a part

#[path = "../../../../fmu/host/tests/it/support/mod.rs"]
pub(crate) mod fmus;

use self::fmus::{Behaviour, binary_path, library, xml, zip_of};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use steerwright_sweep::{Error, Finished, Options, Study, Sweep};
use tempfile::TempDir;

/// A folder with `plant.fmu` (integrator), `path.fmu` (static gain) and `pid.fmu` (sampled gain);
/// `None` where there is no C compiler. `edit` may change their descriptions.
pub(crate) fn folder(edit: impl Fn(&str, String) -> String) -> Option<TempDir> {
    let folder = tempfile::tempdir().unwrap();
    for (behaviour, name, input, output) in [
        (Behaviour::Integrator, "plant", "steering_angle", "yaw"),
        (Behaviour::Gain, "path", "yaw", "yaw_reference"),
        (Behaviour::Sampled, "pid", "yaw_reference", "steering_angle"),
    ] {
        let described = xml((input, "rad"), (output, "rad"));
        let display = r#"<Unit name="rad"><BaseUnit rad="1"/><DisplayUnit name="deg" factor="57.29577951308232"/></Unit>"#;
        let described = edit(name, described.replace(r#"<Unit name="rad"/>"#, display));
        let bytes = zip_of(&[
            ("modelDescription.xml", described.as_bytes()),
            (&binary_path(), library(behaviour)?),
        ]);
        std::fs::write(folder.path().join(format!("{name}.fmu")), bytes).unwrap();
    }
    Some(folder)
}

/// The start of every study here; lines that follow may still be keys of the top.
pub(crate) const TOP: &str = "seed = 5\nstep_s = 0.01\nstop_s = 1.0\n";

/// The loop, stable for gains around these.
pub(crate) const LOOP: &str = r#"
[[fmu]]
file = "plant.fmu"
name = "plant"
[[fmu]]
file = "path.fmu"
name = "path"
[[fmu]]
file = "pid.fmu"
name = "pid"
[set]
"path.gain" = -1.5
"path.offset" = 0.3
"plant.offset" = 0.1
[[vary]]
variables = ["pid.gain"]
distribution = "uniform"
minimum = 1.0
maximum = 3.0
[[vary]]
name = "kick"
distribution = "normal"
mean = 0.0
standard_deviation = 0.2
[[disturb]]
input = "plant.steering_angle"
shape = "pulse"
amplitude = "kick"
start_s = 0.2
duration_s = 0.1
[[disturb]]
input = "path.yaw"
shape = "noise"
amplitude = 0.5
unit = "deg"
bandwidth_hz = 3.0
[[metric]]
name = "yaw_rms"
variable = "plant.yaw"
kind = "rms"
at_most = 0.2
[[metric]]
name = "steering_max"
variable = "plant.steering_angle"
kind = "max-abs"
[[metric]]
name = "settled"
variable = "plant.yaw"
kind = "settling-time"
target = 0.2
band = 0.05
"#;

/// A study of the loop with so many runs.
pub(crate) fn study(runs: usize) -> String {
    format!("{TOP}runs = {runs}\n{LOOP}")
}

pub(crate) fn prepare(folder: &Path, text: &str) -> Result<Sweep, Error> {
    let study = Study::read(text.to_owned(), "study.toml".to_owned(), folder.to_path_buf())?;
    let sweep = Sweep::prepare(&study, &[], &|_| false)?;
    sweep.try_first_step(&study)?;
    Ok(sweep)
}

/// How a sweep is run in a test.
#[derive(Clone, Copy)]
pub(crate) struct How {
    pub(crate) threads: usize,
    pub(crate) resume: bool,
    /// The longest that a run may take.
    pub(crate) timeout: Option<std::time::Duration>,
    /// Stop after so many rows.
    pub(crate) stop_after: Option<usize>,
    /// Called with a run that hangs.
    pub(crate) hung: &'static (dyn Fn(usize, usize) + Sync),
}

impl Default for How {
    fn default() -> Self {
        Self { threads: 0, resume: false, timeout: None, stop_after: None, hung: &|_, _| {} }
    }
}

pub(crate) fn run(sweep: &Sweep, out: &Path, how: How) -> Result<Finished, Error> {
    run_with(sweep, out, how, None)
}

pub(crate) fn run_with(
    sweep: &Sweep,
    out: &Path,
    how: How,
    trajectories: Option<(PathBuf, Vec<usize>)>,
) -> Result<Finished, Error> {
    let stop = AtomicBool::new(false);
    sweep.run(&Options {
        results: out,
        runs: None,
        threads: Some(how.threads.max(1)),
        resume: how.resume,
        overwrite: false,
        trajectories,
        isolate: None,
        timeout: how.timeout,
        hung: how.hung,
        stop: &stop,
        progress: &|rows| {
            if how.stop_after.is_some_and(|most| rows >= most) {
                stop.store(true, std::sync::atomic::Ordering::Relaxed);
            }
        },
    })
}

/// The results of a study: text and what was finished.
pub(crate) fn results(folder: &Path, text: &str, threads: usize) -> (String, Finished) {
    let out = folder.join(format!("results-{threads}.csv"));
    let _ = std::fs::remove_file(&out);
    let sweep = prepare(folder, text).unwrap();
    let finished = run(&sweep, &out, How { threads, ..How::default() }).unwrap();
    (std::fs::read_to_string(out).unwrap(), finished)
}

/// A column of results, as text.
pub(crate) fn column(results: &str, name: &str) -> Vec<String> {
    let mut csv = csv::Reader::from_reader(results.as_bytes());
    let index = csv.headers().unwrap().iter().position(|n| n == name).unwrap();
    csv.records().map(|row| row.unwrap()[index].to_owned()).collect()
}

/// A column of results, as numbers.
pub(crate) fn numbers(results: &str, name: &str) -> Vec<f64> {
    column(results, name).iter().map(|text| text.parse().unwrap()).collect()
}
