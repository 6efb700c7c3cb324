//! The fingerprint of an output: the hash of its text without numbers, and what its numbers amount to.
//!
//! Processors differ in the last digits of sums, since they add in another order, and mathematical libraries in
//! theirs. An identification amplifies this: its searches end where the steps are small. The numbers are thus
//! compared to a part of [`TOLERANCE`], which is above such differences and below what a change of a method causes.
//! Each number x is taken as asinh(x / [`SMALL`]), which is nearly its logarithm, so that a small number in a file of
//! large ones counts as much.

use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// Largest difference of sum and norm, as a part of the norm.
pub(super) const TOLERANCE: f64 = 1e-6;

/// Numbers below this are compared by their difference, above it by their ratio.
const SMALL: f64 = 1e-6;

/// The fingerprint of one output.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fingerprint {
    /// Of the text, each number as `#` and each hash as `<hash>`.
    text: String,
    /// How many numbers there are.
    count: usize,
    /// The sum of the numbers, with weights that depend on the place.
    sum: f64,
    /// The root of the sum of their squares.
    norm: f64,
}

impl Fingerprint {
    pub(super) fn new(text: &str) -> Self {
        let (text, numbers) = split(text);
        let scaled = || numbers.iter().map(|x| (x / SMALL).asinh());
        let weights = (0..).map(|k| 0.5 + (f64::from(k) * 0.618_033_988_75).fract());
        Self {
            text: hash(text.as_bytes()),
            count: numbers.len(),
            // From 0, since the sum of no number is -0.
            sum: scaled().zip(weights).fold(0.0, |sum, (x, weight)| sum + weight * x),
            norm: scaled().fold(0.0, |sum, x| sum + x * x).sqrt(),
        }
    }

    /// What differs from an earlier fingerprint, in words.
    pub(super) fn difference(&self, before: &Self) -> Option<String> {
        if self.text != before.text {
            let count = match self.count == before.count {
                true => String::new(),
                false => format!(", with {} numbers instead of {}", self.count, before.count),
            };
            return Some(format!("the text differs{count}"));
        }
        let largest = self.norm.max(before.norm);
        let part = |a: f64, b: f64| if a == b { 0.0 } else { (a - b).abs() / largest };
        let apart = part(self.sum, before.sum).max(part(self.norm, before.norm));
        if self.count != before.count || apart > TOLERANCE {
            Some(format!(
                "of {} numbers some differ, by {apart:.1e} (at most {TOLERANCE:.0e})",
                self.count
            ))
        } else {
            None
        }
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{:.8e},{:.8e}", self.text, self.count, self.sum, self.norm)
    }
}

impl FromStr for Fingerprint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let problem = || format!("{text:?} is no fingerprint");
        let cells: Vec<&str> = text.split(',').collect();
        let [text, count, sum, norm] = cells[..] else { return Err(problem()) };
        let number = |cell: &str| cell.parse::<f64>().map_err(|_| problem());
        let count = count.parse().map_err(|_| problem())?;
        Ok(Self { text: text.into(), count, sum: number(sum)?, norm: number(norm)? })
    }
}

/// A content as text: bytes that are none, such as an image, as their hash.
pub(super) fn to_text(content: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(content) {
        Ok(text) => text.into(),
        Err(_) => format!("bytes {}", hash(content)).into(),
    }
}

/// The first digits of a hash.
fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().take(6).map(|byte| format!("{byte:02x}")).collect()
}

/// A text without its numbers and hashes, and the numbers. Without white space too: it depends on how long numbers are.
fn split(text: &str) -> (String, Vec<f64>) {
    let (mut rest, mut without, mut numbers) = (text, String::with_capacity(text.len()), vec![]);
    while let Some(first) = rest.chars().next() {
        if first.is_whitespace() {
            rest = rest.trim_start();
            continue;
        }
        let length = hash_length(rest);
        if length > 0 {
            without += "<hash>";
            rest = &rest[length..];
            continue;
        }
        match number(rest) {
            Some((number, length)) => {
                without.push('#');
                numbers.push(number);
                rest = &rest[length..];
            }
            None => {
                let length = word_length(rest).max(first.len_utf8());
                without += &rest[..length];
                rest = &rest[length..];
            }
        }
    }
    (without, numbers)
}

fn word_length(text: &str) -> usize {
    text.bytes().take_while(u8::is_ascii_alphabetic).count()
}

/// The length of a hash at the start of a text: a GUID, or at least 32 hexadecimal digits.
///
/// Hashes are of texts whose numbers differ in the last digits: a GUID is one of the resources.
fn hash_length(text: &str) -> usize {
    let pure = text.bytes().take_while(u8::is_ascii_hexdigit).count();
    if pure >= 32 { pure } else { guid_length(text).unwrap_or(0) }
}

/// The length of a GUID, whose end may be in the next line of a table.
fn guid_length(text: &str) -> Option<usize> {
    let is_part = |byte: &u8| byte.is_ascii_hexdigit() || *byte == b'-';
    let first = text.bytes().take_while(is_part).count();
    let lengths: Vec<usize> = text[..first].split('-').map(str::len).collect();
    let [8, 4, 4, 4, last @ 1..=12] = lengths[..] else { return None };
    let rest = text[first..].trim_start();
    let missing = 12 - last;
    let is_complete = rest.bytes().take(missing).filter(u8::is_ascii_hexdigit).count() == missing;
    let space = if missing > 0 { text.len() - first - rest.len() } else { 0 };
    if is_complete { Some(first + space + missing) } else { None }
}

/// A number at the start of a text, with its length.
fn number(text: &str) -> Option<(f64, usize)> {
    let digits = |at: usize| text[at..].bytes().take_while(u8::is_ascii_digit).count();
    let is = |at: usize, of: &[u8]| text.as_bytes().get(at).is_some_and(|byte| of.contains(byte));
    let mut end = usize::from(is(0, b"-"));
    let whole = digits(end);
    end += whole;
    let fraction = if is(end, b".") { digits(end + 1) } else { 0 };
    if fraction > 0 {
        end += 1 + fraction;
    }
    if whole + fraction == 0 {
        return None;
    }
    if is(end, b"eE") {
        let sign = usize::from(is(end + 1, b"+-"));
        let exponent = digits(end + 1 + sign);
        end += if exponent > 0 { 1 + sign + exponent } else { 0 };
    }
    text[..end].parse().ok().filter(|x: &f64| x.is_finite()).map(|x| (x, end))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn difference(before: &str, now: &str) -> Option<String> {
        // As it is written and read.
        let before = Fingerprint::new(before).to_string().parse().unwrap();
        Fingerprint::new(now).difference(&before)
    }

    #[test]
    fn numbers_and_hashes_are_taken_out_of_a_text() {
        let guid = "0a1b2c3d-0a1b-0a1b-0a1b-0a1b2c3d4e5f";
        let text = format!("x-1 = -2.5e-3, .5; {guid} 1e999 a1.2.3 −7 abc {}", "d".repeat(64));
        let (without, numbers) = split(&text);
        assert_eq!(without, "x#=#,#;<hash>1e#a##−#abc<hash>");
        assert_eq!(numbers, [-1.0, -2.5e-3, 0.5, 999.0, 1.2, 0.3, 7.0]);
        // As a table has it, and what only looks like one.
        let (without, _) = split("a  0a1b2c3d-0a1b-0a1b-0a1b-0a1b2c3d4\n   e5f\n b");
        assert_eq!(without, "a<hash>b");
        let (without, _) = split("0a1b2c3d-0a1b-0a1b-0a1b-0a1b2c3d4 x");
        assert!(!without.contains("<hash>"), "{without}");
    }

    #[test]
    fn the_last_digits_of_numbers_are_no_difference() {
        let before =
            "{\"gain\": 0.3, \"mass\": 1500.0, \"guid\": \"0a1b2c3d-0a1b-0a1b-0a1b-0a1b2c3d4e5f\"}";
        let now = "{\"gain\": 0.30000000000000004, \"mass\":\n1500, \"guid\": \"1a1b2c3d-0a1b-0a1b-0a1b-0a1b2c3d4e5f\"}";
        assert_eq!(difference(before, now), None);
    }

    #[test]
    fn texts_numbers_their_order_and_their_count_are_differences() {
        let before = "gain 0.3, mass 1500.0, margins 1e-3 0";
        for now in [
            "gains 0.3, mass 1500.0, margins 1e-3 0",
            "gain 0.301, mass 1500.0, margins 1e-3 0",
            "gain 0.3, mass -1500.0, margins 1e-3 0",
            "gain 1500.0, mass 0.3, margins 1e-3 0",
            "gain 0.3, mass 1500.0, margins 1.0001e-3 0",
            "gain 0.3, mass 1500.0, margins 1e-3 0.001",
            "gain 0.3, mass 1500.0, margins 1e-3 0 0",
            "gain 0.3, mass 1500.0, margins 1e-3 nan",
        ] {
            assert!(difference(before, now).is_some(), "{now}");
        }
    }

    #[test]
    fn one_number_of_a_long_table_is_a_difference() {
        let table = |last: &str| "0.0123\n".repeat(20_000) + last;
        assert_eq!(difference(&table("0.5"), &table("0.5")), None);
        assert!(difference(&table("0.5"), &table("0.51")).is_some());
    }

    #[test]
    fn bytes_are_compared_by_their_hash() {
        assert_ne!(to_text(b"\x89PNG\xff"), to_text(b"\x89PNG\xfe"));
        assert_eq!(to_text(b"gain"), "gain");
    }
}
