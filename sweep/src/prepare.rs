//! A study made ready: FMUs open, names resolved, the first steps tried.

use crate::Error;
use crate::connect::{Source, Wired, connect};
use crate::plan::Plan;
use crate::resolve::{Resets, resolve};
use crate::rig::{Ended, Rig};
use crate::study::Study;
use sha2::{Digest, Sha256};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use steerwright_host::Measurement;

/// Bytes of the hash that results are marked with.
const ID_BYTES: usize = 8;

/// A study ready to run.
#[derive(Debug)]
pub struct Sweep {
    pub(crate) source: Source,
    pub(crate) plan: Plan,
    /// The hash of study, FMUs and program version that results are marked with.
    pub(crate) id: String,
    /// An FMU that may have one instance in a process.
    pub(crate) only_once: Option<String>,
    remarks: Vec<String>,
}

impl Sweep {
    /// The columns of trajectories after the time, in order.
    pub fn recorded(&self) -> impl Iterator<Item = &str> {
        self.plan.recorded.iter().map(|(name, _)| name.as_str())
    }

    /// Opens the FMUs, wires them and resolves every name of the study.
    ///
    /// FMU files are wired by name with the rules of `measurements`
    /// ([`steerwright_host::wires_by_name`]). `resets_exactly` reports for a generation tool whether
    /// `fmi2Reset` of its FMUs is as good as a new instance; their instances serve many runs, where
    /// the study leaves `instances` at `auto`.
    pub fn prepare(
        study: &Study,
        measurements: &[Measurement<'_>],
        resets_exactly: Resets<'_>,
    ) -> Result<Self, Error> {
        let mut wired = connect(study, measurements)?;
        let plan = resolve(study, &wired, resets_exactly)?;
        let id = id(study, &wired.files)?;
        let once = |a: &&steerwright_host::Archive| {
            a.model().co_simulation().can_be_instantiated_only_once_per_process
        };
        let only_once =
            wired.source.archives().iter().find(|a| once(a)).map(|a| a.name().to_owned());
        let remarks = std::mem::take(&mut wired.remarks);
        // An FMU may allow one instance: these have to be gone before the runs.
        let Wired { source, system, .. } = wired;
        drop(system);
        Ok(Self { source, plan, id, only_once, remarks })
    }

    /// The number of runs.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.plan.runs()
    }

    /// Ignored parts of a system structure package.
    #[must_use]
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Tries the first step of the first and the last run: one may fail for its draws, if both do it
    /// is the study's fault.
    pub fn try_first_step(&self, study: &Study) -> Result<(), Error> {
        let at = match study.raw.step_s.as_ref() {
            Some(step) => study.place(step),
            None => study.top(),
        };
        let mut rig = Rig::new(&self.plan, self.source.archives());
        let stop = AtomicBool::new(false);
        let mut failure = None;
        for run in [0, self.runs() - 1] {
            match rig.run(1, run, &self.plan.quantities(run), &stop, None) {
                Err(Ended::Failed(error)) => failure = Some(failure.unwrap_or(error)),
                _ => return Ok(()),
            }
        }
        failure.map_or(Ok(()), |source| Err(Error::FirstStep { at, source: Box::new(source) }))
    }
}

/// A hash of everything that the numbers of the results depend on.
fn id(study: &Study, files: &[PathBuf]) -> Result<String, Error> {
    let mut hash = Sha256::new();
    hash.update(env!("CARGO_PKG_VERSION"));
    hash.update([0]);
    hash.update(study.canonical());
    for path in files {
        let bytes =
            std::fs::read(path).map_err(|source| Error::Io { path: path.clone(), source })?;
        hash.update(Sha256::digest(bytes));
    }
    Ok(hash.finalize()[..ID_BYTES].iter().map(|byte| format!("{byte:02x}")).collect())
}
