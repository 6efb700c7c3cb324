//! The results: a CSV with a row for each run, in the order of the runs, that a later call can continue.
//!
//! Columns are `run`, the varied quantities as the study states them, the metrics, `passed` where
//! the study requires anything, `outcome` (see [`crate::Class`]), `status` (`ok`, or an error; then the
//! metrics are empty), and `study`, the hash of study, FMUs and program version. Each row is written at
//! once, whole, so that the file always holds the results of the first runs; a last line that a crash
//! of the machine cut short is removed by the next call.

use crate::Error;
use crate::metric::Outcome;
use crate::plan::Plan;
use crate::prepare::Sweep;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What is printed to goes on where it is: opened by its name, a redirected file would be truncated.
#[cfg(unix)]
fn stdout() -> std::io::Result<File> {
    use std::os::fd::AsFd;
    Ok(File::from(std::io::stdout().as_fd().try_clone_to_owned()?))
}

#[cfg(windows)]
fn stdout() -> std::io::Result<File> {
    use std::os::windows::io::AsHandle;
    Ok(File::from(std::io::stdout().as_handle().try_clone_to_owned()?))
}

/// A file for this process alone to write and for all to read: of two runs the second is refused. What is no plain
/// file has no end that two could share.
#[cfg(unix)]
fn claim(path: &Path) -> Result<File, Error> {
    use std::fs::TryLockError;
    use std::io::ErrorKind;
    use std::os::unix::fs::MetadataExt;
    let io = |source| Error::Io { path: path.to_path_buf(), source };
    loop {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).open(path);
        let file = file.map_err(io)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(Error::Taken { path: path.to_path_buf() }),
            // A file system without locks.
            Err(TryLockError::Error(e)) if e.kind() == ErrorKind::Unsupported => return Ok(file),
            Err(TryLockError::Error(e)) => return Err(io(e)),
        }
        // Another process may have removed or renamed it between the two calls.
        let here = file.metadata().map_err(io)?;
        if std::fs::metadata(path).is_ok_and(|m| (m.dev(), m.ino()) == (here.dev(), here.ino())) {
            return Ok(file);
        }
    }
}

#[cfg(windows)]
fn claim(path: &Path) -> Result<File, Error> {
    use std::os::windows::fs::OpenOptionsExt;
    const SHARE_READ: u32 = 1;
    const SHARING_VIOLATION: i32 = 32;
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false).share_mode(SHARE_READ);
    options.open(path).map_err(|source| match source.raw_os_error() {
        Some(SHARING_VIOLATION) => Error::Taken { path: path.to_path_buf() },
        _ => Error::Io { path: path.to_path_buf(), source },
    })
}

/// Removes a file that a killed process left, unless a process has it claimed.
pub(crate) fn remove_left(path: &Path) {
    #[cfg(unix)]
    let is_left = File::options().write(true).open(path).is_ok_and(|file| {
        // Removed while it is held, so that it is not another run's.
        file.try_lock().is_ok() && std::fs::remove_file(path).is_ok()
    });
    // Which Windows refuses while a process has it open.
    #[cfg(windows)]
    let is_left = std::fs::remove_file(path).is_ok();
    // What cannot be removed stays.
    let _ = is_left;
}

/// A results file, open at its end.
#[derive(Debug)]
pub(crate) struct Results {
    file: File,
    path: PathBuf,
}

impl Results {
    /// A new file with its header; what is there already is written over, unless it is unfinished
    /// results of the same study and `overwrite` is off.
    pub(crate) fn create(sweep: &Sweep, path: &Path, overwrite: bool) -> Result<Self, Error> {
        let io = |source| Error::Io { path: path.to_path_buf(), source };
        // A FIFO is not looked into: it would wait for a writer.
        let mut file = if path == Path::new("-") {
            stdout().map_err(io)?
        } else if std::fs::metadata(path).is_ok_and(|m| !m.is_file()) {
            File::create(path).map_err(io)?
        } else {
            if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
                std::fs::create_dir_all(folder).map_err(io)?;
            }
            let mut file = claim(path)?;
            if !overwrite {
                let (rows, _, _) = read(sweep, 0, &mut file, path).unwrap_or_default();
                if !rows.is_empty() && rows.len() < sweep.runs() {
                    let (rows, runs) = (rows.len(), sweep.runs());
                    return Err(Error::Unfinished { path: path.to_path_buf(), rows, runs });
                }
            }
            file.set_len(0).and_then(|()| file.rewind()).map_err(io)?;
            file
        };
        file.write_all(&line(&header(&sweep.plan))).map_err(io)?;
        Ok(Self { file, path: path.to_path_buf() })
    }

    /// Goes on with a file, or begins one that is not there; returns its rows.
    pub(crate) fn resume(
        sweep: &Sweep,
        runs: &Range<usize>,
        path: &Path,
    ) -> Result<(Self, Vec<Outcome>), Error> {
        let io = |source| Error::Io { path: path.to_path_buf(), source };
        // Neither stdout, nor what is not there, nor a device holds results.
        if path == Path::new("-") || !std::fs::metadata(path).is_ok_and(|m| m.is_file()) {
            return Ok((Self::create(sweep, path, true)?, Vec::new()));
        }
        let mut file = claim(path)?;
        let (rows, end, has_header) = read(sweep, runs.start, &mut file, path)?;
        file.set_len(end).map_err(io)?;
        file.seek(SeekFrom::End(0)).map_err(io)?;
        if !has_header {
            file.write_all(&line(&header(&sweep.plan))).map_err(io)?;
        }
        Ok((Self { file, path: path.to_path_buf() }, rows))
    }

    /// Has the rows on the disk.
    pub(crate) fn finish(&mut self) -> Result<(), Error> {
        match self.file.metadata() {
            Ok(metadata) if metadata.is_file() => {
                self.file.sync_all().map_err(|source| Error::Io { path: self.path.clone(), source })
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn append(&mut self, row: &[u8]) -> Result<(), Error> {
        self.file.write_all(row).map_err(|source| Error::Io { path: self.path.clone(), source })
    }
}

/// The row of a run, as it is appended.
pub(crate) fn row(sweep: &Sweep, run: usize, quantities: &[f64], outcome: &Outcome) -> Vec<u8> {
    let plan = &sweep.plan;
    let mut cells = vec![run.to_string()];
    for (value, varied) in quantities.iter().zip(&plan.varied) {
        cells.push(if varied.whole { format!("{value:.0}") } else { shortest(*value) });
    }
    let status = match outcome {
        Outcome::Done(metrics) => {
            cells.extend(metrics.iter().map(|value| shortest(*value)));
            "ok"
        }
        Outcome::Failed(text) => {
            cells.extend(plan.metrics.iter().map(|_| String::new()));
            text
        }
    };
    if plan.requires() {
        cells.push(plan.passes(outcome).to_string());
    }
    let class = plan.class(outcome).name();
    cells.extend([class.to_owned(), status.to_owned(), sweep.id.clone()]);
    line(&cells)
}

fn header(plan: &Plan) -> Vec<String> {
    let mut names = vec!["run".to_owned()];
    names.extend(plan.varied.iter().map(|v| v.name.clone()));
    names.extend(plan.metrics.iter().map(|m| m.name.clone()));
    if plan.requires() {
        names.push("passed".to_owned());
    }
    names.extend(["outcome", "status", "study"].map(str::to_owned));
    names
}

/// Cells as a line of CSV.
fn line(cells: &[String]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = writer.write_record(cells);
    writer.into_inner().unwrap_or_default()
}

/// The content of a file: its rows, where the last whole one ends, and whether its header is whole.
pub(crate) type Held = (Vec<Outcome>, u64, bool);

/// The rows of consecutive runs, of which `first` is the first.
pub(crate) fn read(
    sweep: &Sweep,
    first: usize,
    mut file: impl Read,
    path: &Path,
) -> Result<Held, Error> {
    let bad = |problem: String| Error::Resume { path: path.to_path_buf(), problem };
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)
        .map_err(|source| Error::Io { path: path.to_path_buf(), source })?;
    // No cell holds a line break, so a line is whole if it has its end.
    let end = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
    if end == 0 {
        if line(&header(&sweep.plan)).starts_with(&bytes) {
            return Ok((Vec::new(), 0, false));
        }
        return Err(bad("it is no results of this study".to_owned()));
    }
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(&bytes[..end]);
    let mut records = reader.records();
    let expected = header(&sweep.plan);
    let found = records.next().and_then(Result::ok).unwrap_or_default();
    if found.iter().ne(expected.iter().map(String::as_str)) {
        return Err(bad("its header is not that of this study".to_owned()));
    }
    let mut rows = Vec::new();
    for record in records {
        let number = first + rows.len();
        let record = record.map_err(|e| bad(format!("row of run {number}: {e}")))?;
        rows.push(outcome(sweep, number, &record).map_err(bad)?);
    }
    Ok((rows, end as u64, true))
}

/// The outcome in a row; an error if it is not that of the run.
fn outcome(sweep: &Sweep, run: usize, record: &csv::StringRecord) -> Result<Outcome, String> {
    let cell = |index: usize| record.get(index).unwrap_or_default();
    let last = record.len().saturating_sub(1);
    let (status, id) = (cell(last.saturating_sub(1)), cell(last));
    if id != sweep.id {
        return Err(format!(
            "the row of run {run} is of study {id:?}, and study and FMUs are now {:?}",
            sweep.id
        ));
    }
    if cell(0) != run.to_string() || run >= sweep.runs() {
        return Err(format!("run {run} is expected, the row is of run {:?}", cell(0)));
    }
    if status != "ok" {
        return Ok(Outcome::Failed(status.to_owned()));
    }
    let first = 1 + sweep.plan.varied.len();
    let value = |index| {
        let text = cell(index);
        text.parse().map_err(|_| format!("row of run {run}: {text:?} is no number"))
    };
    (first..first + sweep.plan.metrics.len())
        .map(value)
        .collect::<Result<_, _>>()
        .map(Outcome::Done)
}

/// A row from its line.
pub(crate) fn row_of_line(sweep: &Sweep, run: usize, line: &str) -> Result<Outcome, String> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
    let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
    outcome(sweep, run, &record)
}

/// A float in the shortest decimal that reads back as the same float.
pub(crate) fn shortest(value: f64) -> String {
    format!("{value:?}")
}
