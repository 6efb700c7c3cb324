//! One run, made in this process: its outcome, its row, its trajectory.

use crate::Error;
use crate::metric::Outcome;
use crate::plan::Plan;
use crate::prepare::Sweep;
use crate::results::{row, shortest};
use crate::rig::{Ended, Rig};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use steerwright_host::{Error as HostError, Status};

/// The options of a run of a study.
pub struct Options<'a> {
    /// The results file; `-` is stdout.
    pub results: &'a Path,
    /// The runs to make; by default all. The results then hold these only.
    pub runs: Option<Range<usize>>,
    /// Threads; by default as many as there are cores.
    pub threads: Option<usize>,
    /// Go on with the results file, if it is there.
    pub resume: bool,
    /// Write over unfinished results of the same study.
    pub overwrite: bool,
    /// Where to write trajectories, and of which runs.
    pub trajectories: Option<(PathBuf, Vec<usize>)>,
    /// Has the FMUs of each thread in a process of its own, started by this; see [`Sweep::serve`].
    pub isolate: Option<&'a (dyn Fn() -> Command + Sync)>,
    /// The longest that a run may take; one that takes longer is a row with an error.
    pub timeout: Option<Duration>,
    /// Called with a run, and the number of rows in the file, where an FMU in this process does not
    /// return, within the time or after a stop: it cannot be interrupted, so the process has to be ended.
    pub hung: &'a (dyn Fn(usize, usize) + Sync),
    /// Set, from any thread, to end as soon as possible.
    pub stop: &'a AtomicBool,
    /// Called with the number of rows in the file whenever it grows.
    pub progress: &'a (dyn Fn(usize) + Sync),
}

/// The end of a run.
pub(crate) struct Made {
    /// Nothing, where it was stopped or could not be begun.
    pub(crate) row: Option<(Outcome, Vec<u8>)>,
    /// Why nothing more can be run in the same process.
    pub(crate) fatal: Option<String>,
}

impl Sweep {
    /// Makes a run here, with its trajectory, if requested.
    pub(crate) fn make_here(
        &self,
        rig: &mut Rig<'_>,
        options: &Options<'_>,
        run: usize,
    ) -> Result<Made, Error> {
        let quantities = self.plan.quantities(run);
        rig.deadline = options.timeout.map(|timeout| Instant::now() + timeout);
        let wanted = options.trajectories.as_ref();
        let stop = options.stop;
        let result = match wanted {
            Some((folder, runs)) if runs.contains(&run) => {
                with_trajectory(&self.plan, rig, folder, run, &quantities, stop)?
            }
            _ => rig.run(usize::MAX, run, &quantities, stop, None),
        };
        let (outcome, fatal, aftermath) = match result {
            Ok(metrics) => (Outcome::Done(metrics), None, false),
            Err(Ended::Stopped) => return Ok(Made { row: None, fatal: None }),
            Err(Ended::TooLong) => (Outcome::Failed(too_long(options)), None, false),
            Err(Ended::Failed(error)) => {
                let text = in_a_line(&format!("error: {error}"));
                let fatal = if is_fatal(&error) { Some(error.to_string()) } else { None };
                (Outcome::Failed(text), fatal, matches!(error, HostError::Fatal { .. }))
            }
        };
        // Of an FMU that had ended before, the run itself is not to blame.
        let bytes = if aftermath { None } else { Some(row(self, run, &quantities, &outcome)) };
        Ok(Made { row: bytes.map(|bytes| (outcome, bytes)), fatal })
    }
}

/// The error in the row of a run that takes longer than the limit.
pub(crate) fn too_long(options: &Options<'_>) -> String {
    let limit = options.timeout.map_or(f64::INFINITY, |timeout| timeout.as_secs_f64());
    format!("error: the run takes longer than {limit} s")
}

/// Whether an FMU may not be called any more in this process.
fn is_fatal(error: &HostError) -> bool {
    matches!(
        error,
        HostError::Call { status: Status::Fatal, .. }
            | HostError::Step { status: Status::Fatal, .. }
            | HostError::Fatal { .. }
    )
}

/// Errors of FMUs have a line for each line of their log.
fn in_a_line(text: &str) -> String {
    text.lines().map(str::trim).collect::<Vec<_>>().join("; ").replace('\r', " ")
}

/// Makes a run and writes its trajectory as `run-<index>.csv`, also where the run ends early: `time`,
/// then every connected output and every variable that a metric or `record` names.
fn with_trajectory(
    plan: &Plan,
    rig: &mut Rig<'_>,
    folder: &Path,
    run: usize,
    quantities: &[f64],
    stop: &AtomicBool,
) -> Result<Result<Vec<f64>, Ended>, Error> {
    let mut names = vec!["time".to_owned()];
    names.extend(plan.recorded.iter().map(|(name, _)| name.clone()));
    let mut csv = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = csv.write_record(&names);
    let mut see = |time: f64, values: &[f64]| {
        let all = plan.recorded.iter().map(|(_, slot)| shortest(values[*slot]));
        let _ = csv.write_record(std::iter::once(shortest(time)).chain(all));
    };
    let result = rig.run(usize::MAX, run, quantities, stop, Some(&mut see));
    let path = folder.join(format!("run-{run}.csv"));
    let io = |source| Error::Io { path: path.clone(), source };
    std::fs::create_dir_all(folder).map_err(io)?;
    std::fs::write(&path, csv.into_inner().unwrap_or_default()).map_err(io)?;
    Ok(result)
}
