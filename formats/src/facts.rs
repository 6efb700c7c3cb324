//! What a document says of itself wherever it is packed.

use crate::{Document, Provenance, Quality};
use serde::Serialize;

/// A fact about a document, for people and for tools.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fact {
    /// Its name, the same in every version.
    pub key: &'static str,
    /// A number, a truth or a text.
    pub value: serde_json::Value,
    /// The unit of a number that has one.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub unit: &'static str,
}

impl Fact {
    pub(crate) fn new(
        key: &'static str,
        value: impl Into<serde_json::Value>,
        unit: &'static str,
    ) -> Self {
        Self { key, value: value.into(), unit }
    }
}

/// What a document says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// The name of what it describes.
    pub name: String,
    /// Where it is from; `None` of one that was written by hand.
    pub provenance: Option<Provenance>,
    /// Quality, fits and the point that it holds at.
    pub evidence: Vec<Fact>,
}

/// A document that says what it is from and what speaks for it.
pub trait Described: Document {
    /// What it says.
    fn facts(self) -> Facts;
}

/// The quality, line by line.
pub(crate) fn quality_facts(quality: Quality) -> Vec<Fact> {
    let mut facts = vec![
        Fact::new("quality", quality.grade.name(), ""),
        Fact::new("quality_summary", quality.summary, ""),
    ];
    facts.extend(quality.reasons.into_iter().map(|reason| {
        let line = format!("{} ({}): {}", reason.grade, reason.code.name(), reason.message);
        Fact::new("quality_reason", line, "")
    }));
    facts.extend(quality.remarks.into_iter().map(|line| Fact::new("remark", line, "")));
    facts.extend(quality.advice.into_iter().map(|line| Fact::new("advice", line, "")));
    facts
}
