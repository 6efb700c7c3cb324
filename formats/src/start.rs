//! `start.json`: start values of an FMU that replace its defaults.
//!
//! It is one of the FMU's resources, so that a loop starts on its road also in tools that
//! set nothing: the binary reads it, and modelDescription.xml states what the binary reports.

use crate::document::{Checker, Document};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Start values of Real parameters and inputs, by name, in the variables' units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// `steerwright/start/1`.
    pub schema: String,
    /// A value for each variable.
    pub values: BTreeMap<String, f64>,
}

impl Start {
    /// The name of the file in `resources/`.
    pub const FILE: &'static str = "start.json";

    /// A file with these values.
    #[must_use]
    pub fn new(values: BTreeMap<String, f64>) -> Self {
        Self { schema: Self::SCHEMA.into(), values }
    }
}

impl Document for Start {
    const SCHEMA: &'static str = "steerwright/start/1";

    fn check(&self, c: &mut Checker) {
        for (name, value) in &self.values {
            c.finite(*value, &format!("values.{name}"));
        }
    }
}
