//! What was told already, so that nothing told at every step floods the importer's log.
//!
//! Two lines are of one sort where they differ in numbers only. Of each sort the first is told,
//! then the 10th, the 100th and so on, with their number. Beyond [`SORTS`] sorts the new ones count
//! as one sort. The status of a call does not depend on it. It is no part of an FMU state: going
//! back to a state repeats no line. `fmi2Reset` forgets it.

use crate::calls::Leniency;

/// How many sorts of lines are told apart.
const SORTS: usize = 64;

/// What one instance told since it was made or reset.
#[derive(Debug, Default)]
pub(crate) struct Told {
    /// Each sort and how often it came.
    sorts: Vec<(String, u64)>,
    /// Bits of the leniencies.
    noted: u8,
}

impl Told {
    /// Whether this leniency comes for the first time.
    #[inline]
    pub(crate) fn is_new(&mut self, leniency: Leniency) -> bool {
        let bit = 1 << leniency as u8;
        let new = self.noted & bit == 0;
        self.noted |= bit;
        new
    }

    /// What to tell of a line that comes now; `None` is nothing.
    pub(crate) fn admit(&mut self, text: String) -> Option<String> {
        let sort = sort(&text);
        let known = self.sorts.iter().position(|(known, _)| *known == sort);
        let place = known.unwrap_or(self.sorts.len().min(SORTS));
        if place == self.sorts.len() {
            self.sorts.push((sort, 0));
        }
        let (_, count) = self.sorts.get_mut(place)?;
        *count += 1;
        match *count {
            1 => Some(text),
            count if is_power_of_ten(count) => {
                Some(format!("{text} (no. {count} of its sort, next told is no. {count}0)"))
            }
            _ => None,
        }
    }
}

/// The text without its numbers.
fn sort(text: &str) -> String {
    text.chars().filter(|c| !c.is_ascii_digit() && !matches!(c, '.' | '-' | '+')).collect()
}

fn is_power_of_ten(count: u64) -> bool {
    10_u64.checked_pow(count.ilog10()) == Some(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_one_sort_are_told_ever_more_rarely() {
        let mut told = Told::default();
        let lines: Vec<_> =
            (0..100_000).filter_map(|k| told.admit(format!("{}.5 m/s is too fast", k))).collect();
        assert_eq!(lines.len(), 6);
        assert_eq!(lines[0], "0.5 m/s is too fast");
        assert!(lines[3].starts_with("999.5 m/s") && lines[3].contains("no. 1000 "), "{lines:?}");
        assert_eq!(told.admit("another".into()).as_deref(), Some("another"));
    }

    #[test]
    fn nothing_grows_without_end() {
        let mut told = Told::default();
        let lines = (0..10_000)
            .filter_map(|k: u32| {
                let letters = k.to_string().bytes().map(|b| char::from(b + 49)).collect();
                told.admit(letters)
            })
            .count();
        // Each of the first sorts once, and the rest as one.
        assert_eq!((lines, told.sorts.len()), (SORTS + 4, SORTS + 1));
    }
}
