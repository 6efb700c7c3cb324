//! `steerwright identify` from R factors of accumulated drives, merged.

use crate::commands::identify::present::design_of;
use crate::documents::files;
use crate::failure::{Failure, Outcome};
use crate::options::log::{IdentifyArguments, LogArguments};
use crate::output::Output;
use crate::terminal::console;
use crate::terminal::progress::Progress;
use std::io::Read;
use std::path::{Path, PathBuf};
use steerwright_drivelog::{LogOptions, Response};
use steerwright_formats::{AccumulatedDrives, Model};
use steerwright_report::Report;
use steerwright_sysid::{Accumulated, IdentifyOptions};

/// Whether all files are R factors instead of logs.
pub(crate) fn are_factors(paths: &[PathBuf]) -> Result<bool, Failure> {
    let mut factors = Vec::new();
    for path in paths {
        // A pipe is opened once, since what writes to it ends when it is closed.
        let is_pipe = |path| std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir());
        if path == Path::new("-") || path.is_dir() || is_pipe(path) {
            factors.push(false);
            continue;
        }
        // An R factor is a JSON object with its schema at the start.
        let mut start = Vec::new();
        let read = files::open(path)?.take(200).read_to_end(&mut start);
        read.map_err(|e| Failure::file(path, &e))?;
        factors.push(String::from_utf8_lossy(&start).contains("\"steerwright/factor/"));
    }
    match (factors.iter().position(|f| *f), factors.iter().position(|f| !f)) {
        (Some(factor), Some(log)) => Err(Failure::new(
            format!(
                "{} is an R factor, {} is a log",
                paths[factor].display(),
                paths[log].display()
            ),
            "accumulate the log first: steerwright accumulate LOG -o LOG.rfactor",
        )),
        (factor, _) => Ok(factor.is_some()),
    }
}

/// The R factor of all drives, each read when it is merged.
pub(crate) fn merged(
    mut each: impl Iterator<Item = Result<Accumulated, Failure>>,
) -> Result<Accumulated, Failure> {
    let mut all = each.next().ok_or(steerwright_drivelog::Error::NoFiles)??;
    for one in each {
        let one = one?;
        let name = one.name().to_owned();
        if !all.merge(one)? {
            console::warning(format!("{name}: its logs are there already, and count once"));
        }
    }
    Ok(all)
}

/// The drives in a file.
pub(crate) fn factor(path: &Path) -> Result<Accumulated, Failure> {
    let (file, _) = files::read_document::<AccumulatedDrives>(path)?;
    Ok(Accumulated::from_file(&file, &path.display().to_string())?)
}

/// The options of an identification from R factors; those that only a log has are rejected.
pub(crate) fn check_factor_options(
    log: &LogArguments,
    identify: Option<&IdentifyArguments>,
) -> Result<IdentifyOptions, Failure> {
    if log.options(Response::YawRate)? != LogOptions::default() || !log.drives.is_empty() {
        return Err(Failure::new(
            "options for reading a log have no effect on an R factor",
            "pass them to steerwright accumulate",
        ));
    }
    let options = identify.map(IdentifyArguments::options).unwrap_or_default();
    if options.validation != IdentifyOptions::default().validation {
        return Err(Failure::new(
            "--validation-fraction and --validation-place: the validation data of an R factor were chosen when the logs were accumulated",
            "omit both",
        ));
    }
    if options.max_samples != IdentifyOptions::default().max_samples {
        return Err(Failure::new("--max-samples: an R factor holds no samples", "omit it"));
    }
    Ok(options)
}

pub(crate) fn run(
    paths: &[PathBuf],
    log: &LogArguments,
    identify: &IdentifyArguments,
    out: &Output,
) -> Result<Outcome, Failure> {
    let options = check_factor_options(log, Some(identify))?;
    let progress = Progress::start("identifying");
    let all = merged(paths.iter().map(|path| factor(path)))?;
    let model = Model::StateSpace(Box::new(all.identify(&options)?));
    drop(progress);
    out.model(&model)?;
    let sections = Report { model: Some(&model), ..Report::default() }.sections();
    console::result(&console::page(&sections, design_of(&model, out).as_deref()), &model)?;
    console::note(format!("written to {out}"));
    Ok(Outcome::from_quality(model.quality()))
}
