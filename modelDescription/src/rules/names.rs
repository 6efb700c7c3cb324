//! Names of variables (section 2.2.9): the grammar of structured names, and arrays in order.

use super::Check;
use super::place::FindingPlace;
use crate::vocabulary::NamingConvention;
use std::collections::BTreeMap;

impl Check<'_> {
    pub(super) fn names(&mut self) {
        let description = self.description;
        let structured = description.naming_convention == NamingConvention::Structured;
        // Position and indices of the element last seen of each array.
        let mut arrays: BTreeMap<&str, (usize, Vec<u64>)> = BTreeMap::new();
        for (variable, position) in description.variables.iter().zip(0..) {
            let (name, place) = (variable.name.as_str(), FindingPlace::Variable(position));
            if name.is_empty() {
                self.report("name-empty", place, "the name is empty".into());
            } else if name.contains(['\r', '\n', '\t']) {
                let message = "the name has a line break or a tab".into();
                self.report("name-characters", place, message);
            } else if structured {
                if !is_structured(name) {
                    let message = format!("\"{name}\" is not a structured name");
                    self.report("name-structured", place, message);
                } else if let Some((array, indices)) = element(name) {
                    let last = arrays.insert(array, (position, indices.clone()));
                    if let Some((before, last)) = last
                        && (before + 1 != position || last >= indices)
                    {
                        let other = &description.variables[before].name;
                        let message = format!("does not directly follow `{other}` of its array");
                        self.report("array-order", place, message);
                    }
                }
            }
        }
    }
}

/// The array and the indices of a name that ends in some.
fn element(name: &str) -> Option<(&str, Vec<u64>)> {
    let (array, indices) = name.strip_suffix(']')?.rsplit_once('[')?;
    let values = indices.split(',').map(|text| text.parse().ok());
    Some((array, values.collect::<Option<_>>()?))
}

/// Whether a name follows the grammar of `variableNamingConvention="structured"`.
#[must_use]
pub(crate) fn is_structured(name: &str) -> bool {
    let name = match name.strip_prefix("der(").and_then(|rest| rest.strip_suffix(')')) {
        // A comma outside brackets and apostrophes leads the order of the derivative.
        Some(inner) => match inner.rsplit_once(',') {
            Some((head, order)) if is_unsigned(order) && is_identifier(head) => head,
            _ => inner,
        },
        None => name,
    };
    is_identifier(name)
}

/// `identifier = B-name [ arrayIndices ] { "." B-name [ arrayIndices ] }`.
fn is_identifier(text: &str) -> bool {
    let mut rest = text;
    loop {
        let Some(after) = base_name(rest) else { return false };
        rest = after;
        if let Some(indices) = rest.strip_prefix('[') {
            let Some((inside, after)) = indices.split_once(']') else { return false };
            if !inside.split(',').all(is_unsigned) {
                return false;
            }
            rest = after;
        }
        match rest.strip_prefix('.') {
            Some(next) => rest = next,
            None => return rest.is_empty(),
        }
    }
}

/// The text after the `B-name` at its head.
fn base_name(text: &str) -> Option<&str> {
    if let Some(quoted) = text.strip_prefix('\'') {
        return quoted_name(quoted);
    }
    let is_letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    if !text.starts_with(is_letter) {
        return None;
    }
    let end = text.find(|c: char| !is_letter(c) && !c.is_ascii_digit()).unwrap_or(text.len());
    Some(&text[end..])
}

/// The text after a `Q-name` whose first apostrophe has been read.
fn quoted_name(text: &str) -> Option<&str> {
    let mut characters = text.char_indices();
    let mut empty = true;
    while let Some((at, c)) = characters.next() {
        match c {
            '\'' => return if empty { None } else { Some(&text[at + 1..]) },
            '\\' => {
                let (_, escaped) = characters.next()?;
                if !"'\"?\\abfnrtv".contains(escaped) {
                    return None;
                }
            }
            // The standard's list has no `"`, no `'` and no backslash by themselves.
            c if c.is_ascii_alphanumeric() || "_!#$%&()*+,-./:;<>=?@[]^{}|~ ".contains(c) => {}
            _ => return None,
        }
        empty = false;
    }
    None
}

fn is_unsigned(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::is_structured;

    /// The examples of section 2.2.9, and names that break its grammar.
    #[test]
    fn structured_names_follow_the_grammar() {
        for name in [
            "vehicle.engine.speed",
            "resistor12.u",
            "v_min",
            "robot.axis.'motor #234'",
            "der(pipe[3,4].T[14],2)",
            "der(x)",
            "T[1,1,1]",
            "'a.b[\\n'.c",
            "'it\\'s'[0]",
            "_1",
        ] {
            assert!(is_structured(name), "{name}");
        }
        for name in [
            "",
            "1a",
            "a b",
            "a..b",
            ".a",
            "a.",
            "a[",
            "a[]",
            "a[1,]",
            "a[-1]",
            "a[1][2]",
            "der()",
            "der(a",
            "der(a,b)",
            "der(der(a))",
            "''",
            "'a",
            "'a\\x'",
            "'\u{e4}'",
            "\u{e4}",
            "a]",
            "der(a,1,2)",
            "a[1]b",
        ] {
            assert!(!is_structured(name), "{name}");
        }
    }
}
