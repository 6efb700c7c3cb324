//! Drives that are accumulated, in memory.

use crate::arrays::source;
use crate::{options, work};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use steerwright::stages;
use steerwright_sysid::Accumulated;

type Shared = Arc<Mutex<Option<Accumulated>>>;

/// Accumulated drives; none at the start.
#[pyclass(frozen, module = "steerwright._native")]
#[derive(Default)]
pub(crate) struct Drives {
    drives: Shared,
}

fn include(drives: &Shared, other: Accumulated) -> Result<(), stages::Failure> {
    let mut own = drives.lock().unwrap_or_else(PoisonError::into_inner);
    match &mut *own {
        // A copy, since drives that differ must change nothing.
        Some(all) => {
            let mut both = all.clone();
            stages::merge(&mut both, other)?;
            *all = both;
        }
        none => *none = Some(other),
    }
    Ok(())
}

impl Drives {
    fn accumulated(&self) -> PyResult<Accumulated> {
        let own = self.drives.lock().unwrap_or_else(PoisonError::into_inner);
        own.clone().ok_or_else(|| PyRuntimeError::new_err("nothing is accumulated"))
    }
}

#[pymethods]
impl Drives {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Adds logs.
    fn add(
        &self,
        py: Python<'_>,
        files: Option<Vec<PathBuf>>,
        tables: Option<&Bound<'_, PyList>>,
        keywords: &Bound<'_, PyDict>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let options = options::of_keywords("accumulate", keywords)?;
        let (source, drives) = (source(files, tables)?, Arc::clone(&self.drives));
        work::done(py, progress, move || include(&drives, stages::accumulate(source, &options)?))
    }

    /// Adds the drives of a document.
    fn load(&self, py: Python<'_>, document: String, file: String) -> PyResult<()> {
        let drives = Arc::clone(&self.drives);
        work::done(py, None, move || include(&drives, stages::accumulated(&document, &file)?))
    }

    /// Adds what another has accumulated.
    fn merge(&self, py: Python<'_>, other: &Bound<'_, Self>) -> PyResult<()> {
        let (drives, other) = (Arc::clone(&self.drives), other.get().accumulated()?);
        work::done(py, None, move || include(&drives, other))
    }

    /// The document.
    fn json(&self) -> PyResult<String> {
        Ok(stages::accumulated_json(&self.accumulated()?))
    }

    #[getter]
    fn is_empty(&self) -> bool {
        self.drives.lock().unwrap_or_else(PoisonError::into_inner).is_none()
    }

    /// Identifies the plant: its document.
    fn identify(
        &self,
        py: Python<'_>,
        keywords: &Bound<'_, PyDict>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        let options = options::of_keywords("identify", keywords)?;
        let drives = self.accumulated()?;
        work::done(py, progress, move || stages::identify_accumulated(&drives, &options))
    }
}
