//! Signals as NumPy arrays: lent without a copy and read-only, or taken from the caller by a copy.

use numpy::ndarray::ArrayView1;
use numpy::{Element, IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::Arc;
use steerwright::stages::{Source, Table};
use steerwright_drivelog::DriveLog;

/// Memory of an object as a read-only array that keeps the object alive.
#[allow(unsafe_code)]
fn lent<'py, T: Element, O: PyClass<Frozen = pyo3::pyclass::boolean_struct::True> + Sync>(
    owner: &Bound<'py, O>,
    values: impl FnOnce(&O) -> &[T],
) -> Bound<'py, PyArray1<T>> {
    let values = values(owner.get());
    // SAFETY: the memory belongs to `owner`, which is frozen, so it neither moves nor changes while the array,
    // whose base `owner` is, keeps it alive; and the array is made read-only before anyone sees it.
    let array =
        unsafe { PyArray1::borrow_from_array(&ArrayView1::from(values), owner.clone().into_any()) };
    drop(array.readwrite().make_nonwriteable());
    array
}

/// Values that Rust gives away.
pub(crate) fn owned(py: Python<'_>, values: Vec<f64>) -> PyResult<Py<PyAny>> {
    Ok(values.into_pyarray(py).into_any().unbind())
}

/// Copies of the caller's tables: each a name and a dict of float64 columns.
pub(crate) fn tables(tables: &Bound<'_, PyList>) -> PyResult<Vec<Table>> {
    let table = |item: Bound<'_, PyAny>| {
        let (name, columns): (String, Bound<'_, PyDict>) = item.extract()?;
        let columns = columns.iter().map(|(column, values)| {
            let values: PyReadonlyArray1<'_, f64> = values.extract()?;
            Ok((column.extract()?, values.as_array().to_vec()))
        });
        Ok((name, columns.collect::<PyResult<_>>()?))
    };
    tables.iter().map(table).collect()
}

/// Files, or tables: each a name and a dict of float64 columns, which are copied.
pub(crate) fn source(
    files: Option<Vec<PathBuf>>,
    tables: Option<&Bound<'_, PyList>>,
) -> PyResult<Source> {
    match tables {
        None => Ok(Source::Files(files.unwrap_or_default())),
        Some(tables) => Ok(Source::Tables(self::tables(tables)?)),
    }
}

/// A log on one grid: SI and radians, ISO 8855 signs.
#[pyclass(frozen, module = "steerwright._native")]
pub(crate) struct Log {
    log: Arc<DriveLog>,
    time: Vec<f64>,
}

impl Log {
    pub(crate) fn new(log: DriveLog) -> Self {
        Self { time: log.time_s(), log: Arc::new(log) }
    }

    pub(crate) fn shared(&self) -> Arc<DriveLog> {
        Arc::clone(&self.log)
    }
}

#[pymethods]
impl Log {
    #[getter]
    fn name(&self) -> &str {
        &self.log.name
    }

    #[getter]
    fn sample_time(&self) -> f64 {
        self.log.sample_time_s
    }

    #[getter]
    fn steering_ratio(&self) -> f64 {
        self.log.steering_ratio
    }

    #[getter]
    fn time<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, |log| &log.time)
    }

    #[getter]
    fn steering<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, |log| &log.log.input)
    }

    #[getter]
    fn yaw_rate<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, |log| &log.log.output)
    }

    #[getter]
    fn speed<'py>(slf: &Bound<'py, Self>) -> Option<Bound<'py, PyArray1<f64>>> {
        slf.get().log.speed.as_ref()?;
        Some(lent(slf, |log| log.log.speed.as_deref().unwrap_or_default()))
    }

    /// (first, one after the last) sample of each segment without a gap.
    #[getter]
    fn segments(&self) -> Vec<(usize, usize)> {
        self.log.segments.iter().map(|s| (s.range.start, s.range.end)).collect()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.log.warnings.clone()
    }

    /// Role, column, unit and number of rows of each channel.
    #[getter]
    fn channels(&self) -> Vec<(String, String, String, usize)> {
        let channels = self.log.channels.iter();
        channels.map(|c| (c.role.clone(), c.column.clone(), c.unit.clone(), c.rows)).collect()
    }

    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("steerwright.reading")?.call_method1("frame", (slf,))
    }

    fn __len__(&self) -> usize {
        self.log.len()
    }

    fn __repr__(&self) -> String {
        let log = &self.log;
        let drives = match log.segments.len() {
            1 => String::new(),
            n => format!(", {n} segments"),
        };
        format!("<Log {}: {} samples of {} s{drives}>", log.name, log.len(), log.sample_time_s)
    }
}

/// Measured and simulated signals of an identification.
#[pyclass(frozen, module = "steerwright._native")]
pub(crate) struct Traces {
    traces: Arc<steerwright_sysid::Traces>,
}

impl Traces {
    pub(crate) fn new(traces: steerwright_sysid::Traces) -> Self {
        Self { traces: Arc::new(traces) }
    }

    pub(crate) fn shared(&self) -> Arc<steerwright_sysid::Traces> {
        Arc::clone(&self.traces)
    }
}

#[pymethods]
impl Traces {
    #[getter]
    fn time<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, |t| &t.traces.time_s)
    }

    #[getter]
    fn steering<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, |t| &t.traces.steering_rad)
    }

    #[getter]
    fn yaw_rate<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, |t| &t.traces.yaw_rate_radps)
    }

    #[getter]
    fn simulated_yaw_rate<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, |t| &t.traces.simulated_yaw_rate_radps)
    }

    #[getter]
    fn yaw<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, |t| &t.traces.yaw_rad)
    }

    #[getter]
    fn simulated_yaw<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, |t| &t.traces.simulated_yaw_rad)
    }

    #[getter]
    fn is_validation<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<bool>> {
        lent(slf, |t| &t.traces.is_validation)
    }
}
