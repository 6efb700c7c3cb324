//! The log lines of a unit during a call, and the limit on repeated lines.
//!
//! A unit that warns at every step would flood the importer's log. Lines that differ only in numbers
//! are one kind. Of each kind the 1st, 10th, 100th line and so on is logged, with its number. After
//! [`KINDS`] kinds all new ones count as one kind. The status of a call does not depend on this. The
//! counts are not part of an FMU state, so restoring a state repeats no line; `fmi2Reset` clears them.

use crate::access_rules::Leniency;

/// The severity of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Logged if the importer has debug logging on.
    Info,
    /// Logged, and the call returns `fmi2Warning`.
    Warning,
}

/// Collects lines; the layer passes them to the importer's logger after the call.
#[derive(Debug, Default)]
pub struct Log {
    lines: Vec<(Level, String)>,
}

impl Log {
    /// Logs a line for debugging.
    pub fn info(&mut self, text: impl Into<String>) {
        self.lines.push((Level::Info, text.into()));
    }

    /// Logs a warning; the call returns `fmi2Warning`. Of lines that differ only in numbers, the
    /// layer logs the 1st, 10th, 100th and so on.
    pub fn warning(&mut self, text: impl Into<String>) {
        self.lines.push((Level::Warning, text.into()));
    }

    /// The lines so far.
    #[must_use]
    pub fn lines(&self) -> &[(Level, String)] {
        &self.lines
    }

    /// Takes the lines; without lines nothing is allocated or freed.
    pub(crate) fn take(&mut self) -> Vec<(Level, String)> {
        std::mem::take(&mut self.lines)
    }
}

/// The largest number of kinds of lines that are counted separately.
const KINDS: usize = 64;

/// How often an instance has logged each kind of line since its instantiation or last reset.
#[derive(Debug, Default)]
pub(crate) struct Repetitions {
    /// Each kind with its count.
    kinds: Vec<(String, u64)>,
    /// One bit for each logged leniency.
    leniencies: u8,
}

impl Repetitions {
    /// Whether a leniency occurs for the first time.
    #[inline]
    pub(crate) fn is_new(&mut self, leniency: Leniency) -> bool {
        let bit = 1 << leniency as u8;
        let new = self.leniencies & bit == 0;
        self.leniencies |= bit;
        new
    }

    /// Counts a line; returns the text to log, or `None` to log nothing.
    pub(crate) fn admit(&mut self, text: String) -> Option<String> {
        let kind = kind(&text);
        let known = self.kinds.iter().position(|(known, _)| *known == kind);
        let place = known.unwrap_or(self.kinds.len().min(KINDS));
        if place == self.kinds.len() {
            self.kinds.push((kind, 0));
        }
        let (_, count) = self.kinds.get_mut(place)?;
        *count += 1;
        match *count {
            1 => Some(text),
            count if is_power_of_ten(count) => Some(format!(
                "{text} (no. {count} of its kind; the next one logged is no. {count}0)"
            )),
            _ => None,
        }
    }
}

/// The text without its numbers.
fn kind(text: &str) -> String {
    text.chars().filter(|c| !c.is_ascii_digit() && !matches!(c, '.' | '-' | '+')).collect()
}

fn is_power_of_ten(count: u64) -> bool {
    10_u64.checked_pow(count.ilog10()) == Some(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_one_kind_are_logged_at_powers_of_ten() {
        let mut repetitions = Repetitions::default();
        let lines: Vec<_> = (0..100_000)
            .filter_map(|k| repetitions.admit(format!("{}.5 m/s is too fast", k)))
            .collect();
        assert_eq!(lines.len(), 6);
        assert_eq!(lines[0], "0.5 m/s is too fast");
        assert!(lines[3].starts_with("999.5 m/s") && lines[3].contains("no. 1000 "), "{lines:?}");
        assert_eq!(repetitions.admit("another".into()).as_deref(), Some("another"));
    }

    #[test]
    fn memory_is_bounded() {
        let mut repetitions = Repetitions::default();
        let lines = (0..10_000)
            .filter_map(|k: u32| {
                let letters = k.to_string().bytes().map(|b| char::from(b + 49)).collect();
                repetitions.admit(letters)
            })
            .count();
        // Each of the first kinds once, and the rest as one.
        assert_eq!((lines, repetitions.kinds.len()), (KINDS + 4, KINDS + 1));
    }
}
