//! The result of a check: findings, each with its rule, location and hint.

use crate::rules::{Rule, Severity, rule};
use serde::Serialize;

/// The location of a finding in the archive.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Location {
    /// The entry of the archive; `None` for the archive as a whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub entry: Option<String>,
    /// Line in the entry, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// Column in the line, in characters from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<u32>,
    /// The XML element, with its name attribute if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element: Option<String>,
}

impl Location {
    /// The archive as a whole.
    #[must_use]
    pub fn archive() -> Self {
        Self::default()
    }

    /// An entry of the archive.
    #[must_use]
    pub fn entry(name: impl Into<String>) -> Self {
        Self { entry: Some(name.into()), ..Self::default() }
    }
}

impl std::fmt::Display for Location {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.entry {
            None => f.write_str("archive")?,
            Some(entry) => write!(f, "{}", entry.escape_debug())?,
        }
        if let (Some(line), Some(column)) = (self.line, self.column) {
            write!(f, ":{line}:{column}")?;
        }
        if let Some(element) = &self.element {
            write!(f, ": {element}")?;
        }
        Ok(())
    }
}

/// A violation of a rule, or information.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The rule's name, stable for scripts; see [`crate::RULES`].
    pub rule: &'static str,
    /// Its severity.
    pub severity: Severity,
    /// Section of the FMI 2.0.5 text.
    pub section: &'static str,
    /// The location in the archive.
    #[serde(flatten)]
    pub location: Location,
    /// The problem.
    pub message: String,
    /// The suggested fix.
    pub hint: &'static str,
}

impl Finding {
    pub(crate) fn new(name: &'static str, location: Location, message: impl Into<String>) -> Self {
        let Rule { name, severity, section, hint } = *rule(name);
        Self { rule: name, severity, section, location, message: message.into(), hint }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { rule, severity, section, location, message, hint } = self;
        write!(f, "{severity}: {location}: {message} [{rule}, FMI 2.0.5, {section}]")?;
        if *severity > Severity::Note { write!(f, "\n  hint: {hint}") } else { Ok(()) }
    }
}

/// All findings of one archive.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Report {
    /// The file name of the archive.
    pub archive: String,
    /// Number of errors.
    pub errors: usize,
    /// Number of warnings.
    pub warnings: usize,
    /// The findings of the archive, the description, the binaries and the run, in this order.
    pub findings: Vec<Finding>,
}

impl Report {
    pub(crate) fn new(archive: &str, findings: Vec<Finding>) -> Self {
        let mut report = Self { archive: archive.into(), errors: 0, warnings: 0, findings };
        report.count();
        report
    }

    /// Adds findings of a run.
    pub fn extend(&mut self, findings: Vec<Finding>) {
        self.findings.extend(findings);
        self.count();
    }

    fn count(&mut self) {
        let count = |severity| self.findings.iter().filter(|f| f.severity == severity).count();
        (self.errors, self.warnings) = (count(Severity::Error), count(Severity::Warning));
    }

    /// Whether there are no errors; warnings and notes do not count.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.errors == 0
    }
}

#[derive(Debug, Default)]
pub(crate) struct Findings {
    list: Vec<Finding>,
    counts: std::collections::BTreeMap<&'static str, usize>,
}

/// The largest number of findings that are listed for one rule.
const LISTED_PER_RULE: usize = 100;

impl Findings {
    pub(crate) fn add(
        &mut self,
        rule: &'static str,
        location: Location,
        message: impl Into<String>,
    ) {
        self.add_at(rule, || location, message);
    }

    /// Adds a finding whose location is expensive to compute, such as a line of a long text.
    pub(crate) fn add_at(
        &mut self,
        rule: &'static str,
        location: impl FnOnce() -> Location,
        message: impl Into<String>,
    ) {
        let count = self.counts.entry(rule).or_default();
        *count += 1;
        if *count <= LISTED_PER_RULE {
            self.list.push(Finding::new(rule, location(), message));
        }
    }

    pub(crate) fn errors(&self) -> usize {
        self.list.iter().filter(|finding| finding.severity == Severity::Error).count()
    }

    pub(crate) fn has(&self, rule: &str) -> bool {
        self.counts.contains_key(rule)
    }

    pub(crate) fn into_vec(mut self) -> Vec<Finding> {
        for (rule, count) in self.counts {
            if let Some(more) = count.checked_sub(LISTED_PER_RULE).filter(|more| *more > 0) {
                let message = format!("{more} more findings of this rule are not listed");
                self.list.push(Finding::new(rule, Location::archive(), message));
            }
        }
        self.list
    }
}
