//! The texts that are values of the schema's simple types (XML Schema, part 2).

use super::schema::AttributeKind;

/// The white space of XML, which most types ignore at both ends.
const SPACE: [char; 4] = [' ', '\t', '\r', '\n'];

impl AttributeKind {
    pub(super) fn accepts(self, text: &str) -> bool {
        let trimmed = text.trim_matches(SPACE);
        match self {
            Self::Text => true,
            Self::Boolean => matches!(trimmed, "true" | "false" | "1" | "0"),
            Self::Int => integer(trimmed).is_some_and(|value| i32::try_from(value).is_ok()),
            Self::UnsignedInt => is_unsigned_int(trimmed),
            Self::Double => is_special(trimmed) || is_decimal(trimmed),
            Self::DateTime => date_time(trimmed).is_some(),
            // The base of enumerations keeps white space.
            Self::Word(words) => words.contains(&text),
            Self::Indices => text.split(SPACE).filter(|w| !w.is_empty()).all(is_unsigned_int),
            Self::Words(words) => {
                text.split(SPACE).filter(|w| !w.is_empty()).all(|w| words.contains(&w))
            }
        }
    }

    pub(super) fn expected(self) -> String {
        match self {
            Self::Text => "a text".into(),
            Self::Boolean => "true, false, 1 or 0".into(),
            Self::Int => "a whole number of 32 bits".into(),
            Self::UnsignedInt => "a whole number from 0 to 4294967295".into(),
            Self::Double => "a number".into(),
            Self::DateTime => "a date and time such as 2009-12-08T14:33:22Z".into(),
            Self::Word([word]) => format!("\"{word}\""),
            Self::Word(words) => format!("one of {}", words.join(", ")),
            Self::Indices => "whole numbers separated by spaces".into(),
            Self::Words(words) => format!("words among {}", words.join(", ")),
        }
    }
}

/// The values that `xs:double` has and FMI forbids.
pub(super) fn is_special(text: &str) -> bool {
    matches!(text.trim_matches(SPACE), "INF" | "-INF" | "NaN")
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

fn unsigned(text: &str) -> &str {
    text.strip_prefix(['+', '-']).unwrap_or(text)
}

fn integer(text: &str) -> Option<i64> {
    if !is_digits(unsigned(text)) {
        return None;
    }
    text.parse().ok()
}

fn is_unsigned_int(text: &str) -> bool {
    integer(text).is_some_and(|value| u32::try_from(value).is_ok())
}

fn is_decimal(text: &str) -> bool {
    let (mantissa, exponent) = match text.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, Some(exponent)),
        None => (text, None),
    };
    let (whole, fraction) = unsigned(mantissa).split_once('.').unwrap_or((unsigned(mantissa), ""));
    let is_number = (!whole.is_empty() || !fraction.is_empty())
        && [whole, fraction].iter().all(|part| part.is_empty() || is_digits(part));
    is_number && exponent.is_none_or(|exponent| is_digits(unsigned(exponent)))
}

/// `xs:dateTime`: a date, `T`, a time of day, and perhaps a time zone.
fn date_time(text: &str) -> Option<()> {
    let (date, time) = text.split_once('T')?;
    let mut parts = date.strip_prefix('-').unwrap_or(date).split('-');
    let year = parts.next().filter(|y| is_digits(y) && y.len() >= 4)?;
    if year.len() > 4 && year.starts_with('0') || year.bytes().all(|b| b == b'0') {
        return None;
    }
    let month = two_digits(parts.next()?).filter(|month| (1..=12).contains(month))?;
    let leap = {
        // The last four digits decide: 10000 is a multiple of 400.
        let year: u32 = year[year.len() - 4..].parse().ok()?;
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let days = match month {
        2 if leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    two_digits(parts.next()?).filter(|day| (1..=days).contains(day))?;
    if parts.next().is_some() {
        return None;
    }
    let zone = time.find(['Z', '+', '-']).unwrap_or(time.len());
    let (time, zone) = time.split_at(zone);
    let mut parts = time.split(':');
    let hour = two_digits(parts.next()?).filter(|hour| *hour <= 24)?;
    let minute = two_digits(parts.next()?).filter(|minute| *minute <= 59)?;
    let seconds = parts.next()?;
    let (second, fraction) = match seconds.split_once('.') {
        Some((second, fraction)) => (second, Some(fraction)),
        None => (seconds, None),
    };
    let second = two_digits(second).filter(|second| *second <= 59)?;
    if parts.next().is_some() || fraction.is_some_and(|fraction| !is_digits(fraction)) {
        return None;
    }
    let zero_fraction = fraction.is_none_or(|fraction| fraction.bytes().all(|b| b == b'0'));
    if hour == 24 && !(minute == 0 && second == 0 && zero_fraction) {
        return None;
    }
    match zone.strip_prefix(['+', '-']) {
        Some(offset) => {
            let (hours, minutes) = offset.split_once(':')?;
            let (hours, minutes) = (two_digits(hours)?, two_digits(minutes)?);
            if minutes <= 59 && (hours < 14 || hours == 14 && minutes == 0) {
                Some(())
            } else {
                None
            }
        }
        None => {
            if matches!(zone, "" | "Z") {
                Some(())
            } else {
                None
            }
        }
    }
}

fn two_digits(text: &str) -> Option<u32> {
    if text.len() == 2 && is_digits(text) { text.parse().ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The results are those of libxml2 with FMPy's copy of the schema.
    #[test]
    fn values_are_those_of_xml_schema() {
        let good: &[(AttributeKind, &[&str])] = &[
            (AttributeKind::UnsignedInt, &["+5", "-0", " 5 ", "05", "4294967295", "\t5"]),
            (AttributeKind::Int, &["+5", "-0", "-2147483648", " 7 "]),
            (
                AttributeKind::Double,
                &["INF", "-INF", "NaN", "1E+5", ".5", "5.", " 1 ", "1e400", "+.5e-3"],
            ),
            (AttributeKind::Boolean, &["true", "1", " true "]),
            (
                AttributeKind::DateTime,
                &[
                    "2020-01-01T00:00:00Z",
                    "2020-01-01T00:00:00",
                    "2020-01-01T24:00:00Z",
                    "2020-01-01T00:00:00.123+01:00",
                    "-2020-01-01T00:00:00Z",
                    "12020-01-01T00:00:00Z",
                    "2020-01-01T00:00:00+14:00",
                    "2020-02-29T00:00:00Z",
                ],
            ),
            (AttributeKind::Indices, &["", "1 2", "1\n2"]),
            (AttributeKind::Words(&["a", "b"]), &["", "a  b", " a"]),
        ];
        for (kind, texts) in good {
            for text in *texts {
                assert!(kind.accepts(text), "{kind:?} {text:?}");
            }
        }
        let bad: &[(AttributeKind, &[&str])] = &[
            (AttributeKind::UnsignedInt, &["4294967296", "5.0", "", "-1", "0x1"]),
            (AttributeKind::Int, &["2147483648", "", "+"]),
            (
                AttributeKind::Double,
                &["+INF", "nan", "inf", "1d5", "", "0x1", ".", "infinity", "1_0", "1,5"],
            ),
            (AttributeKind::Boolean, &["TRUE", "yes", ""]),
            (
                AttributeKind::DateTime,
                &[
                    "2020-01-01",
                    "2020-13-01T00:00:00Z",
                    "2020-02-30T00:00:00Z",
                    "2019-02-29T00:00:00Z",
                    "2020-01-01T24:00:01Z",
                    "2020-01-01T00:00:60Z",
                    "2020-01-01T00:00:00+14:01",
                    "0000-01-01T00:00:00Z",
                    "02020-01-01T00:00:00Z",
                    "+2020-01-01T00:00:00Z",
                    "",
                ],
            ),
            (AttributeKind::Word(&["flat"]), &[" flat", "Flat"]),
            (AttributeKind::Indices, &["1 x", "1,2"]),
            (AttributeKind::Words(&["a", "b"]), &["a c"]),
        ];
        for (kind, texts) in bad {
            for text in *texts {
                assert!(!kind.accepts(text), "{kind:?} {text:?}");
            }
        }
    }
}
