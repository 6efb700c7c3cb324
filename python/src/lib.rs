//! The native part of the Python package `steerwright`: logs, stages and the command line. `_native.pyi` states
//! the types; the package in `steerwright/` makes of it what users see.

mod accumulated;
mod arrays;
mod options;
mod work;

use accumulated::Drives;
use arrays::{Log, Traces, source};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use steerwright::stages;
use steerwright_sysid::multivariable::ChannelTraces;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<Log>()?;
    module.add_class::<Traces>()?;
    module.add_class::<Drives>()?;
    module.add_class::<Scratch>()?;
    for function in [
        wrap_pyfunction!(main, module)?,
        wrap_pyfunction!(describe, module)?,
        wrap_pyfunction!(words, module)?,
        wrap_pyfunction!(in_python, module)?,
        wrap_pyfunction!(read, module)?,
        wrap_pyfunction!(save, module)?,
        wrap_pyfunction!(response, module)?,
        wrap_pyfunction!(identify, module)?,
        wrap_pyfunction!(design, module)?,
        wrap_pyfunction!(yaw_step, module)?,
        wrap_pyfunction!(figures_of_model, module)?,
        wrap_pyfunction!(figures_of_controller, module)?,
        wrap_pyfunction!(page_of_model, module)?,
        wrap_pyfunction!(notebook, module)?,
    ] {
        module.add_function(function)?;
    }
    Ok(())
}

/// The command line; returns the exit status. `program` starts it in another process.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>, program: Vec<OsString>) -> u8 {
    py.detach(|| steerwright::run(arguments, Some(program)))
}

/// A message of the command line with its options as keywords.
#[pyfunction]
fn in_python(text: &str) -> String {
    work::in_python(text)
}

/// Options of a subcommand, or of reading a log: (name, value, values, repeated, default, help).
#[pyfunction]
fn describe(subcommand: &str) -> PyResult<Vec<options::Described>> {
    options::described(subcommand)
}

/// Keyword arguments as words of the command line.
#[pyfunction]
fn words(subcommand: &str, keywords: &Bound<'_, PyDict>) -> PyResult<Vec<String>> {
    let options = options::of_keywords(subcommand, keywords)?;
    let word = |(name, value): (String, Option<String>)| match value {
        Some(value) => format!("--{name}={value}"),
        None => format!("--{name}"),
    };
    Ok(options.into_iter().map(word).collect())
}

/// Writes a document as the command line does.
#[pyfunction]
fn save(py: Python<'_>, path: PathBuf, document: String, force: bool) -> PyResult<()> {
    work::done(py, None, move || stages::save(&path, &document, force))
}

/// A temporary folder that a killed process does not leave for good.
#[pyclass(frozen, module = "steerwright._native")]
struct Scratch(Mutex<Option<stages::Scratch>>);

#[pymethods]
impl Scratch {
    #[new]
    fn new() -> PyResult<Self> {
        Ok(Self(Mutex::new(Some(stages::Scratch::new()?))))
    }

    fn __enter__(&self) -> Option<PathBuf> {
        let folder = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        folder.as_ref().map(|folder| folder.path().to_path_buf())
    }

    #[pyo3(signature = (*_raised))]
    fn __exit__(&self, _raised: &Bound<'_, PyTuple>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
    }
}

/// Reads a log.
#[pyfunction]
fn read(
    py: Python<'_>,
    files: Option<Vec<PathBuf>>,
    tables: Option<&Bound<'_, PyList>>,
    keywords: &Bound<'_, PyDict>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Log> {
    let options = options::of_keywords("read", keywords)?;
    let source = source(files, tables)?;
    Ok(Log::new(work::done(py, progress, move || stages::read(source, &options))?))
}

/// Signals of named channels: time, inputs, outputs and simulated outputs by name, and which samples validate.
type Channels = (Py<PyAny>, Py<PyDict>, Py<PyDict>, Py<PyDict>, Py<PyAny>);

fn channels(py: Python<'_>, traces: ChannelTraces) -> PyResult<Channels> {
    let (inputs, outputs, simulated) = (PyDict::new(py), PyDict::new(py), PyDict::new(py));
    for (name, values) in traces.inputs {
        inputs.set_item(name, arrays::owned(py, values)?)?;
    }
    for (name, measured, of_model) in traces.outputs {
        outputs.set_item(&name, arrays::owned(py, measured)?)?;
        simulated.set_item(&name, arrays::owned(py, of_model)?)?;
    }
    let is_validation = traces.is_validation.into_pyarray(py).into_any().unbind();
    let time = arrays::owned(py, traces.time_s)?;
    Ok((time, inputs.unbind(), outputs.unbind(), simulated.unbind(), is_validation))
}

/// What `identify` with these options reads a log for.
#[pyfunction]
fn response(py: Python<'_>, keywords: &Bound<'_, PyDict>) -> PyResult<&'static str> {
    let options = options::of_keywords("identify", keywords)?;
    stages::response(&options).map_err(|failure| work::error(py, &failure))
}

/// Identifies a model: its document, and the signals of a vehicle's log or of named channels.
#[pyfunction]
fn identify(
    py: Python<'_>,
    log: &Bound<'_, Log>,
    keywords: &Bound<'_, PyDict>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, Option<Traces>, Option<Channels>)> {
    let options = options::of_keywords("identify", keywords)?;
    let log = log.get().shared();
    let found = work::done(py, progress, move || stages::identify(&log, &options))?;
    let signals = found.channels.map(|signals| channels(py, signals)).transpose()?;
    Ok((found.model.to_json(), found.traces.map(Traces::new), signals))
}

/// Designs a controller: its document.
#[pyfunction]
fn design(
    py: Python<'_>,
    document: String,
    file: String,
    keywords: &Bound<'_, PyDict>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<String> {
    let options = options::of_keywords("design", keywords)?;
    work::done(py, progress, move || stages::design(&document, &file, &options))
}

/// The yaw step of a controller on its model.
#[pyfunction]
fn yaw_step(
    py: Python<'_>,
    document: String,
    controller: String,
    until_s: f64,
) -> PyResult<Vec<Py<PyAny>>> {
    let step = work::done(py, None, move || stages::yaw_step(&document, &controller, until_s))?;
    step.into_iter().map(|values| arrays::owned(py, values)).collect()
}

/// The figures of a model, SVG by name.
#[pyfunction]
fn figures_of_model(
    py: Python<'_>,
    document: String,
    traces: &Bound<'_, Traces>,
) -> PyResult<Vec<(String, String)>> {
    let traces = traces.get().shared();
    work::done(py, None, move || stages::figures_of_model(&document, &traces))
}

/// The figures of a controller, SVG by name.
#[pyfunction]
fn figures_of_controller(
    py: Python<'_>,
    document: String,
    controller: String,
) -> PyResult<Vec<(String, String)>> {
    work::done(py, None, move || stages::figures_of_controller(&document, &controller))
}

/// The page of a model, HTML.
#[pyfunction]
fn page_of_model(py: Python<'_>, document: String, traces: &Bound<'_, Traces>) -> PyResult<String> {
    let traces = traces.get().shared();
    work::done(py, None, move || stages::page_of_model(&document, &traces))
}

/// A document for a notebook, HTML; with figures of a controller where its model is there, and of a model with signals.
#[pyfunction]
#[pyo3(signature = (document, model=None, traces=None))]
fn notebook(
    py: Python<'_>,
    document: String,
    model: Option<String>,
    traces: Option<&Bound<'_, Traces>>,
) -> PyResult<String> {
    let traces = traces.map(|traces| traces.get().shared());
    work::done(py, None, move || stages::notebook(&document, model.as_deref(), traces.as_deref()))
}
