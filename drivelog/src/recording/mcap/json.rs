//! The fields of messages in JSON: those of their schema, and those of the messages that are looked at.

use serde_json::Value;
use std::collections::BTreeSet;

/// Deepest nesting and most fields of a JSON message.
const MOST_DEPTH: usize = 16;
const MOST_FIELDS: usize = 4096;

/// The paths to the fields that are numbers, or may be.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Paths(pub(super) BTreeSet<Vec<String>>);

impl Paths {
    /// Adds the fields of a message; one that is null may be a number in another message.
    pub(super) fn add_message(&mut self, json: &[u8]) {
        if let Ok(value) = serde_json::from_slice(json) {
            self.add(&value, &mut Vec::new());
        }
    }

    fn add(&mut self, value: &Value, path: &mut Vec<String>) {
        match value {
            Value::Bool(_) | Value::Number(_) | Value::Null => self.insert(path),
            Value::Object(map) => self.nested(map.iter(), path, Self::add),
            _ => {}
        }
    }

    /// Adds the fields of a JSON schema that are numbers.
    pub(super) fn add_schema(&mut self, text: &str) {
        if let Ok(schema) = serde_json::from_str(text) {
            self.add_property(&schema, &mut Vec::new());
        }
    }

    fn add_property(&mut self, schema: &Value, path: &mut Vec<String>) {
        let is = |kind: &Value| matches!(kind.as_str(), Some("number" | "integer" | "boolean"));
        match schema.get("type") {
            Some(Value::Array(kinds)) if kinds.iter().any(is) => self.insert(path),
            Some(kind) if is(kind) => self.insert(path),
            _ => {}
        }
        if let Some(Value::Object(fields)) = schema.get("properties") {
            self.nested(fields.iter(), path, Self::add_property);
        }
    }

    fn insert(&mut self, path: &[String]) {
        if !path.is_empty() && self.0.len() < MOST_FIELDS {
            self.0.insert(path.to_vec());
        }
    }

    fn nested<'v>(
        &mut self,
        fields: impl Iterator<Item = (&'v String, &'v Value)>,
        path: &mut Vec<String>,
        add: fn(&mut Self, &Value, &mut Vec<String>),
    ) {
        if path.len() < MOST_DEPTH {
            for (name, value) in fields {
                path.push(name.clone());
                add(self, value, path);
                path.pop();
            }
        }
    }
}
