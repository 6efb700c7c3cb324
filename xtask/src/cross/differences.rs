//! The output of two runs of `tests/abi/host.c`, compared bit for bit.

use std::fmt;

/// How a column differs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Difference {
    pub(crate) column: String,
    /// The first line that differs; line 0 is what is read after initialization.
    pub(crate) first: usize,
    /// The largest difference in any line.
    pub(crate) largest: f64,
    /// The same, as a part of the column's largest value.
    pub(crate) relative: f64,
}

/// How two runs differ.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Differences {
    pub(crate) lines: usize,
    pub(crate) columns: Vec<Difference>,
    /// The largest relative difference of all columns.
    pub(crate) largest: f64,
}

impl fmt::Display for Differences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.columns.is_empty() {
            return write!(f, "the same bits in {} lines", self.lines);
        }
        let columns: Vec<_> = self
            .columns
            .iter()
            .map(|d| {
                format!(
                    "{} by at most {:.1e} ({:.1e} of its range), first in line {}",
                    d.column, d.largest, d.relative, d.first
                )
            })
            .collect();
        write!(f, "differs in {} lines: {}", self.lines, columns.join("; "))
    }
}

/// Compares line by line. The first column is the time, the others are named. Lines that begin with
/// `fmi2` state what a function returned, and must be the same.
pub(crate) fn differences(
    ours: &str,
    theirs: &str,
    columns: &[String],
) -> Result<Differences, String> {
    for (ours, theirs) in answers(ours).zip(answers(theirs)) {
        if ours != theirs {
            return Err(format!("{theirs} instead of {ours}"));
        }
    }
    if answers(ours).count() != answers(theirs).count() {
        return Err("one answered more calls than the other".into());
    }
    let (ours, theirs) = (table(ours)?, table(theirs)?);
    if ours.len() != theirs.len() || ours.is_empty() {
        return Err(format!("{} lines against {}", ours.len(), theirs.len()));
    }
    let width = columns.len() + 1;
    if let Some(line) = ours.iter().chain(&theirs).find(|line| line.len() != width) {
        return Err(format!("{} numbers in a line instead of {width}", line.len()));
    }
    let mut found = Vec::new();
    for column in 0..width {
        let pairs = || ours.iter().zip(&theirs).map(|(a, b)| (a[column], b[column]));
        let Some(first) = pairs().position(|(a, b)| a.to_bits() != b.to_bits()) else { continue };
        let range = pairs().map(|(a, _)| a.abs()).fold(0.0, f64::max);
        // A number on one side only must not get lost in a maximum.
        let apart =
            |(a, b): (f64, f64)| if (a - b).is_nan() { f64::INFINITY } else { (a - b).abs() };
        let largest = pairs().map(apart).fold(0.0, f64::max);
        let name = column.checked_sub(1).map_or("time", |index| &columns[index]);
        let relative = if largest == 0.0 { 0.0 } else { largest / range.max(f64::MIN_POSITIVE) };
        found.push(Difference { column: name.into(), first, largest, relative });
    }
    let largest = found.iter().map(|d| d.relative).fold(0.0, f64::max);
    Ok(Differences { lines: ours.len(), columns: found, largest })
}

fn answers(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| line.starts_with("fmi2"))
}

fn table(text: &str) -> Result<Vec<Vec<f64>>, String> {
    let number = |word: &str| hexadecimal(word).ok_or_else(|| format!("{word:?} is no number"));
    text.lines()
        .filter(|line| !line.starts_with("fmi2"))
        .map(|line| line.split_whitespace().map(number).collect())
        .collect()
}

/// Reads `+0x1.8000000000000p-3`, `-inf` and `+nan`, as the host prints them: each exactly.
fn hexadecimal(word: &str) -> Option<f64> {
    let (sign, rest) = match word.as_bytes().first()? {
        b'+' => (0, &word[1..]),
        b'-' => (1_u64 << 63, &word[1..]),
        _ => return None,
    };
    let bits = match rest {
        "inf" => f64::INFINITY.to_bits(),
        "nan" => f64::NAN.to_bits(),
        _ => {
            let (lead, rest) = rest.strip_prefix("0x")?.split_once('.')?;
            let (digits, exponent) = rest.split_once('p')?;
            if digits.len() != 13 {
                return None;
            }
            let fraction = u64::from_str_radix(digits, 16).ok()?;
            let exponent: i64 = exponent.parse().ok()?;
            match lead {
                "0" => fraction,
                "1" => u64::try_from(exponent + 1023).ok()? << 52 | fraction,
                _ => return None,
            }
        }
    };
    Some(f64::from_bits(sign | bits))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn numbers_are_read_exactly() {
        let cases = [
            ("+0x0.0000000000000p+0", 0.0),
            ("-0x1.8000000000000p-3", -0.1875),
            ("+0x1.999999999999ap-4", 0.1),
            ("+0x0.0000000000001p-1022", f64::from_bits(1)),
            ("+0x1.fffffffffffffp+1023", f64::MAX),
            ("-inf", f64::NEG_INFINITY),
        ];
        for (text, number) in cases {
            assert_eq!(hexadecimal(text).unwrap().to_bits(), number.to_bits(), "{text}");
        }
        assert!(hexadecimal("+nan").unwrap().is_nan());
        for text in ["", "+", "0x1.8000000000000p-3", "+0x1.8p-3", "+0x2.0000000000000p+0", "+1"] {
            assert_eq!(hexadecimal(text), None, "{text}");
        }
    }

    #[test]
    fn the_last_bit_of_one_number_is_a_difference() {
        let columns = ["x".to_owned()];
        let one = "+0x0.0000000000000p+0 +0x1.0000000000000p+0\n";
        let next = "+0x0.0000000000000p+0 +0x1.0000000000001p+0\n";
        let same = differences(one, one, &columns).unwrap();
        assert_eq!((same.columns.len(), same.largest), (0, 0.0));
        let found = differences(&[one, one].concat(), &[one, next].concat(), &columns).unwrap();
        assert_eq!(found.columns.len(), 1);
        assert_eq!(found.columns[0].column, "x");
        assert_eq!(found.columns[0].first, 1);
        assert_eq!(found.largest, f64::EPSILON);
    }

    #[test]
    fn a_number_that_is_none_is_no_small_difference() {
        let columns = ["x".to_owned()];
        let one = "+0x0.0000000000000p+0 +0x1.0000000000000p+0\n";
        let none = "+0x0.0000000000000p+0 +nan\n";
        assert_eq!(differences(one, none, &columns).unwrap().largest, f64::INFINITY);
        assert_eq!(differences(none, one, &columns).unwrap().largest, f64::INFINITY);
    }

    #[test]
    fn another_answer_is_an_error() {
        let with = |answer: &str| format!("+0x0.0000000000000p+0\n{answer}");
        let (one, other) = (with("fmi2CancelStep 3\n"), with("fmi2CancelStep 0\n"));
        assert!(differences(&one, &one, &[]).is_ok());
        assert!(differences(&one, &other, &[]).is_err());
        assert!(differences(&one, &with(""), &[]).is_err());
    }

    #[test]
    fn runs_of_another_shape_are_not_compared() {
        let columns = ["x".to_owned()];
        let one = "+0x0.0000000000000p+0 +0x1.0000000000000p+0\n";
        assert!(differences(one, &[one, one].concat(), &columns).is_err());
        assert!(differences("", "", &columns).is_err());
        assert!(differences(one, "+0x0.0000000000000p+0\n", &columns).is_err());
    }
}
