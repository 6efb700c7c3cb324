//! The fields of messages in JSON: those of their schema, and those of the messages that are looked at.

use serde_json::Value;
use std::collections::BTreeSet;

/// Deepest nesting and most fields of a JSON message.
const MOST_DEPTH: usize = 16;
const MOST_FIELDS: usize = 4096;
/// Most parts of a schema that are looked at.
const MOST_PARTS: usize = 1 << 14;

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

    /// Adds the fields of a JSON schema that are numbers, also of what it refers to and combines.
    pub(super) fn add_schema(&mut self, text: &str) {
        if let Ok(schema) = serde_json::from_str(text) {
            let mut left = MOST_PARTS;
            self.add_property(&schema, &schema, &mut Vec::new(), 0, &mut left);
        }
    }

    /// A part may refer to itself: it is `depth` references away from its field, and so many parts may still be looked at.
    fn add_property(
        &mut self,
        whole: &Value,
        part: &Value,
        path: &mut Vec<String>,
        depth: usize,
        left: &mut usize,
    ) {
        let Some(rest) = left.checked_sub(1).filter(|_| depth < MOST_DEPTH) else { return };
        *left = rest;
        let is = |kind: &Value| matches!(kind.as_str(), Some("number" | "integer" | "boolean"));
        match part.get("type") {
            Some(Value::Array(kinds)) if kinds.iter().any(is) => self.insert(path),
            Some(kind) if is(kind) => self.insert(path),
            _ => {}
        }
        if let Some(Value::Object(fields)) = part.get("properties") {
            let add = |own: &mut Self, value: &Value, path: &mut Vec<String>| {
                own.add_property(whole, value, path, 0, left);
            };
            self.nested(fields.iter(), path, add);
        }
        let reference = part.get("$ref").and_then(Value::as_str);
        let reference = reference.and_then(|place| whole.pointer(place.strip_prefix('#')?));
        let combined = ["allOf", "anyOf", "oneOf"].into_iter().filter_map(|key| part.get(key));
        let combined = combined.filter_map(Value::as_array).flatten();
        for other in reference.into_iter().chain(combined) {
            self.add_property(whole, other, path, depth + 1, left);
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
        mut add: impl FnMut(&mut Self, &Value, &mut Vec<String>),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_a_schema_with_references() {
        let schema = r##"{"$defs": {"v": {"properties": {"x": {"type": "number"}, "again": {"$ref": "#/$defs/v"}}}},
            "allOf": [{"properties": {"a": {"$ref": "#/$defs/v"}}}, {"$ref": "#"}],
            "properties": {"b": {"anyOf": [{"type": "null"}, {"type": "integer"}]}, "name": {"type": "string"}}}"##;
        let mut paths = Paths::default();
        paths.add_schema(schema);
        let names: Vec<String> = paths.0.iter().map(|path| path.join(".")).collect();
        assert!(
            ["a.x", "a.again.x", "b"].iter().all(|name| names.iter().any(|own| own == name)),
            "{names:?}"
        );
        assert!(!names.iter().any(|name| name == "name"));
    }
}
