//! A study as in its TOML file.
//!
//! Unknown keys, wrong types and missing keys are refused with their line and column. What a name
//! means is found when the FMUs are open, see [`crate::Sweep::prepare`]; every entry keeps its
//! place in the file until then.

use crate::Error;
use crate::error::StudyPlace;
use crate::metric::MetricKind;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use steerwright_host::Coupling;
use toml::Spanned;

/// A read study.
#[derive(Debug, Clone)]
pub struct Study {
    pub(crate) raw: Raw,
    file: String,
    text: String,
    folder: PathBuf,
}

/// The file's keys.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Raw {
    /// A system structure package, relative to the study.
    pub(crate) ssp: Option<Spanned<String>>,
    /// FMUs, in the order in which Gauss–Seidel coupling steps them.
    #[serde(default)]
    pub(crate) fmu: Vec<Spanned<Fmu>>,
    #[serde(default)]
    pub(crate) connect: Vec<Spanned<Connect>>,
    pub(crate) start_s: Option<f64>,
    pub(crate) stop_s: Option<Spanned<f64>>,
    pub(crate) step_s: Option<Spanned<f64>>,
    #[serde(default, alias = "master", with = "CouplingName")]
    pub(crate) coupling: Coupling,
    #[serde(default)]
    pub(crate) instances: Instances,
    pub(crate) seed: u64,
    /// Draws for each point of the grid.
    pub(crate) runs: Spanned<usize>,
    /// Whether the points of a grid share their draws.
    #[serde(default)]
    pub(crate) same_draws_on_grid: bool,
    /// A cross-track error beyond this is off the path, m.
    pub(crate) max_cross_track_error_m: Option<Spanned<f64>>,
    /// Values that all runs share.
    #[serde(default)]
    pub(crate) set: BTreeMap<Spanned<String>, Spanned<toml::Value>>,
    #[serde(default)]
    pub(crate) vary: Vec<Spanned<Vary>>,
    #[serde(default)]
    pub(crate) disturb: Vec<Spanned<Disturb>>,
    #[serde(default)]
    pub(crate) metric: Vec<Spanned<Metric>>,
    /// What else a trajectory shows.
    #[serde(default)]
    pub(crate) record: Vec<Spanned<String>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Fmu {
    pub(crate) file: Spanned<String>,
    /// What the study calls it; by default that of the model or the file.
    pub(crate) name: Option<String>,
    /// Names under which variables are wired: `rename = { delta = "steering_angle" }`.
    #[serde(default)]
    pub(crate) rename: BTreeMap<Spanned<String>, String>,
}

/// A connection that equal names do not make.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Connect {
    pub(crate) from: Spanned<String>,
    pub(crate) to: Spanned<String>,
    /// The input is `factor · output + offset`.
    pub(crate) factor: Option<f64>,
    pub(crate) offset: Option<f64>,
}

/// How values pass between FMUs within a step.
#[derive(Deserialize)]
#[serde(remote = "Coupling", rename_all = "kebab-case")]
enum CouplingName {
    GaussSeidel,
    Jacobi,
}

/// Whether instances serve several runs.
#[derive(Debug, Clone, Copy, Deserialize, Default, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Instances {
    /// One instance serves several runs where its reset is exact.
    #[default]
    Auto,
    /// A new one for each run.
    Fresh,
    /// One a thread, reset between runs.
    Reset,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Vary {
    /// Its column; by default the first variable.
    pub(crate) name: Option<String>,
    /// The variables that get the value; none for a quantity that only disturbances use.
    #[serde(default)]
    pub(crate) variables: Vec<Spanned<String>>,
    pub(crate) distribution: DistributionKind,
    /// The unit of the numbers here; by default that of the variables.
    pub(crate) unit: Option<String>,
    pub(crate) minimum: Option<f64>,
    pub(crate) maximum: Option<f64>,
    pub(crate) mean: Option<f64>,
    pub(crate) standard_deviation: Option<f64>,
    pub(crate) count: Option<usize>,
    pub(crate) values: Option<Vec<toml::Value>>,
    pub(crate) weights: Option<Vec<f64>>,
}

/// Names of distributions; the last two are not drawn from but gone through.
#[derive(Debug, Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum DistributionKind {
    Uniform,
    LogUniform,
    Normal,
    TruncatedNormal,
    Choice,
    Grid,
    Linspace,
}

/// A number, or the name of a varied quantity.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "a number or the name of a varied quantity is expected")]
pub(crate) enum Quantity {
    Number(f64),
    Name(String),
}

/// A signal that is added to an input.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Disturb {
    pub(crate) input: Spanned<String>,
    pub(crate) shape: Shape,
    pub(crate) amplitude: Spanned<Quantity>,
    /// The amplitude's unit; by default that of the input.
    pub(crate) unit: Option<String>,
    pub(crate) start_s: Option<Spanned<Quantity>>,
    pub(crate) duration_s: Option<Spanned<Quantity>>,
    pub(crate) bandwidth_hz: Option<f64>,
}

/// Shapes of disturbances; see [`crate::disturbance`].
#[derive(Debug, Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Shape {
    Step,
    Pulse,
    Gust,
    Noise,
}

/// A number that is computed of each run.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Metric {
    pub(crate) name: String,
    pub(crate) variable: Spanned<String>,
    pub(crate) kind: MetricKind,
    /// The unit of the numbers here and of the result; by default that of the variable.
    pub(crate) unit: Option<String>,
    pub(crate) from_s: Option<f64>,
    pub(crate) to_s: Option<f64>,
    /// Whether the variable's absolute value counts.
    #[serde(default)]
    pub(crate) absolute: bool,
    pub(crate) above: Option<f64>,
    pub(crate) below: Option<f64>,
    /// What is taken off the variable: a number, a varied quantity or another variable.
    pub(crate) target: Option<Spanned<Quantity>>,
    pub(crate) band: Option<f64>,
    pub(crate) band_percent: Option<f64>,
    pub(crate) at_most: Option<f64>,
    pub(crate) at_least: Option<f64>,
}

impl Metric {
    /// Refuses a metric whose keys do not fit its kind or contradict each other.
    pub(crate) fn check(&self) -> Result<(), String> {
        let (kind, name) = (self.kind, self.kind.name());
        let bounds = self.above.iter().chain(&self.below).count();
        let of_bounds = matches!(kind, MetricKind::Time | MetricKind::FirstTime);
        if of_bounds && bounds != 1 {
            return Err(format!("{name} needs either above or below"));
        } else if !of_bounds && bounds > 0 {
            let text = "has no above or below; at_most and at_least state requirements";
            return Err(format!("{name} {text}"));
        }
        let bands = self.band.iter().chain(&self.band_percent).count();
        if kind == MetricKind::SettlingTime {
            if bands != 1 || self.target.is_none() {
                return Err(format!("{name} needs a target, and either band or band_percent"));
            }
        } else if bands > 0 {
            return Err(format!("{name} has no band"));
        }
        if kind == MetricKind::Overshoot && (self.target.is_none() || self.absolute) {
            return Err(format!("{name} needs a target, and has a sign"));
        }
        for (key, value) in [("band", self.band), ("band_percent", self.band_percent)] {
            if let Some(value) = value
                && !(value > 0.0 && value.is_finite())
            {
                return Err(format!("{key} {value} is not above 0"));
            }
        }
        for (key, value) in [
            ("above", self.above),
            ("below", self.below),
            ("at_most", self.at_most),
            ("at_least", self.at_least),
        ] {
            if let Some(value) = value
                && !value.is_finite()
            {
                return Err(format!("{key} is {value}"));
            }
        }
        if let (Some(least), Some(most)) = (self.at_least, self.at_most)
            && least > most
        {
            return Err(format!("no value is at least {least} and at most {most}"));
        }
        Ok(())
    }
}

impl Study {
    /// Reads a study file; the files it names are relative to its folder.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let io = |source| Error::Io { path: path.to_path_buf(), source };
        let text = std::fs::read_to_string(path).map_err(io)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Self::read(text, path.display().to_string(), folder)
    }

    /// The files that the study names: a package, or FMUs.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        let fmus = self.raw.fmu.iter().map(|fmu| &fmu.get_ref().file);
        self.raw.ssp.iter().chain(fmus).map(|name| self.file(name.get_ref())).collect()
    }

    /// Reads a study; `file` is what errors call it, `folder` where the files lie that it names.
    pub fn read(text: String, file: String, folder: PathBuf) -> Result<Self, Error> {
        let raw = toml::from_str(&text).map_err(|error| Error::Study {
            at: place(&file, &text, error.span().map_or(0, |span| span.start)),
            problem: error.message().trim().replace('\n', "; "),
            hint: "a study is a TOML file with the keys of sweep/examples/lateral-loop.toml in the repository",
        })?;
        Ok(Self { raw, file, text, folder })
    }

    pub(crate) fn place<T>(&self, entry: &Spanned<T>) -> StudyPlace {
        place(&self.file, &self.text, entry.span().start)
    }

    /// The start of the file, for what is missing from it.
    pub(crate) fn top(&self) -> StudyPlace {
        place(&self.file, &self.text, 0)
    }

    pub(crate) fn fault<T>(
        &self,
        entry: &Spanned<T>,
        problem: impl Into<String>,
        hint: &'static str,
    ) -> Error {
        Error::Study { at: self.place(entry), problem: problem.into(), hint }
    }

    /// A file that the study names.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The study without its comments and layout, which change no number.
    pub(crate) fn canonical(&self) -> String {
        // It was read a moment ago; should that fail now, the text itself is as good.
        self.text.parse::<toml::Table>().map_or_else(|_| self.text.clone(), |t| t.to_string())
    }
}

fn place(file: &str, text: &str, offset: usize) -> StudyPlace {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    StudyPlace { file: file.to_owned(), line, column }
}
