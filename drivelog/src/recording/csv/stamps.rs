//! Times as ISO 8601 writes them: `2024-03-01T10:00:00.010Z`, without a zone, or the time of day alone.

use jiff::civil::{Date, Time};
use jiff::fmt::temporal::DateTimeParser;
use jiff::tz::Offset;

const PARSER: DateTimeParser = DateTimeParser::new();
const DAY_S: f64 = 86_400.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stamps {
    form: Form,
    /// Seconds of the last time of day, with the midnights before it.
    last: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Zoned,
    /// Date and time of an unstated zone.
    Local,
    TimeOfDay,
}

impl Stamps {
    pub(super) fn like(text: &str) -> Option<Self> {
        let (form, _) = read(text)?;
        Some(Self { form, last: f64::NEG_INFINITY })
    }

    /// Seconds since 1970, or since the first midnight where there is no date; `None` where the text is
    /// no time of this form. A time of day half a day or more before the last is one of the next day.
    pub(super) fn seconds(&mut self, text: &str) -> Option<f64> {
        let (form, mut seconds) = read(text)?;
        if form != self.form {
            return None;
        }
        if form == Form::TimeOfDay {
            if self.last.is_finite() {
                let days = ((self.last - seconds) / DAY_S).round().max(0.0);
                seconds += days * DAY_S;
            }
            self.last = seconds.max(self.last);
        }
        Some(seconds)
    }
}

fn read(text: &str) -> Option<(Form, f64)> {
    // Numbers are none, though 20240301 and 1000 are forms of ISO 8601.
    let bytes = text.as_bytes();
    let is_mark = |at: usize, mark: u8| bytes.get(at) == Some(&mark);
    if is_mark(2, b':') {
        let time = PARSER.parse_time(text).ok()?;
        return Some((Form::TimeOfDay, of_day(time)));
    }
    if !(is_mark(4, b'-') && is_mark(7, b'-')) {
        return None;
    }
    let pieces = PARSER.parse_pieces(text).ok()?;
    let time = pieces.time()?;
    match pieces.to_numeric_offset() {
        Some(zone) => Some((Form::Zoned, since_1970(pieces.date(), time, zone)?)),
        None => Some((Form::Local, since_1970(pieces.date(), time, Offset::UTC)?)),
    }
}

fn of_day(time: Time) -> f64 {
    let whole = i32::from(time.hour()) * 3600 + i32::from(time.minute()) * 60;
    let nanoseconds = f64::from(time.subsec_nanosecond());
    f64::from(whole + i32::from(time.second())) + 1e-9 * nanoseconds
}

fn since_1970(date: Date, time: Time, zone: Offset) -> Option<f64> {
    let instant = zone.to_timestamp(date.to_datetime(time)).ok()?;
    Some(instant.as_second() as f64 + 1e-9 * f64::from(instant.subsec_nanosecond()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(texts: &[&str]) -> Vec<Option<f64>> {
        let mut stamps = Stamps::like(texts[0]).unwrap();
        texts.iter().map(|text| stamps.seconds(text)).collect()
    }

    #[test]
    fn dates_with_and_without_a_zone() {
        // `date -u -d '2024-03-01T10:00:00Z' +%s`
        let ten = 1_709_287_200.0;
        let at = |text| seconds(&[text])[0].unwrap() - ten;
        assert_eq!(at("2024-03-01T10:00:00Z"), 0.0);
        assert_eq!(at("2024-03-01T11:00:00+01:00"), 0.0);
        assert_eq!(at("2024-03-01 10:00:00"), 0.0);
        assert!((at("2024-03-01T10:00:00.010Z") - 0.01).abs() < 1e-6);
        assert!((at("2024-03-01 10:00:00,250") - 0.25).abs() < 1e-6);
        assert_eq!(at("2024-03-02T00:00:00Z") - at("2024-03-01T23:59:59Z"), 1.0);
        // A zone now and none then cannot be put in order.
        assert_eq!(seconds(&["2024-03-01T10:00:00Z", "2024-03-01T10:00:01"])[1], None);
        for none in ["20240301", "1000", "10.5", "", "2024-03-01", "2024-13-01T10:00:00", "1:2"] {
            assert_eq!(Stamps::like(none), None, "{none}");
        }
    }

    #[test]
    fn times_of_day_go_on_after_midnight() {
        let read = seconds(&["23:59:59.5", "23:59:59.9", "00:00:00.1", "00:00:00.05", "00:00:01"]);
        let read: Vec<f64> = read.into_iter().flatten().collect();
        let expected = [-0.5, -0.1, 0.1, 0.05, 1.0].map(|s| s + DAY_S);
        assert!(read.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{read:?}");
    }
}
