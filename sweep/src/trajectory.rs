//! Trajectories of single runs, as CSV: `time`, then every connected output and every variable that
//! a metric or `record` names.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use crate::error::Error;
use crate::plan::Plan;
use crate::quantity::shortest;
use crate::rig::{Ended, Rig};

/// Makes a run and writes `run-<index>.csv`, also where the run ends early.
pub(crate) fn write(
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
    let result = rig.run(run, quantities, stop, Some(&mut see));
    let path = folder.join(format!("run-{run}.csv"));
    let io = |source| Error::Io { path: path.clone(), source };
    std::fs::create_dir_all(folder).map_err(io)?;
    std::fs::write(&path, csv.into_inner().unwrap_or_default()).map_err(io)?;
    Ok(result)
}
