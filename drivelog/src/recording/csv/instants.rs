//! The time that one text states, and the form in which it does.

use jiff::civil::{Date, ISOWeekDate, Time, Weekday};
use jiff::fmt::temporal::DateTimeParser;
use jiff::tz::Offset;

const PARSER: DateTimeParser = DateTimeParser::new();
pub(super) const DAY_S: f64 = 86_400.0;
/// Names of zones that have one meaning in logs, h.
const ZONES: [(&str, f64); 11] = [
    ("UTC", 0.0),
    ("GMT", 0.0),
    ("CET", 1.0),
    ("MEZ", 1.0),
    ("CEST", 2.0),
    ("MESZ", 2.0),
    ("JST", 9.0),
    ("EST", -5.0),
    ("EDT", -4.0),
    ("PST", -8.0),
    ("PDT", -7.0),
];

/// A date that ends with the year, and the time of its day, s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Slashed {
    pub(super) numbers: [i8; 2],
    /// With points, the day is first.
    pub(super) has_points: bool,
    pub(super) year: i16,
    /// Of a year of two digits between slashes it is open whether it is last.
    pub(super) has_short_year: bool,
    pub(super) of_day: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    MonthFirst,
    DayFirst,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum StampForm {
    Zoned,
    /// Date and time of an unstated zone.
    Local,
    TimeOfDay,
    /// `0.01 sec`, `0.5 min`.
    Duration,
    /// `1:02.5`.
    Minutes,
    /// `0 days 00:00:01`.
    Days,
    /// A date that ends with the year.
    Slashed,
    /// A time of day without colons.
    Digits,
    /// Days, of which the one of 1970 has this number.
    Serial(i32),
    /// No text: rows of equal steps.
    Rows {
        first: f64,
        step: f64,
        row: f64,
    },
}

impl Slashed {
    /// Which number is the day, where the other cannot be a month.
    pub(super) fn order(&self) -> Option<Order> {
        match self.numbers {
            _ if self.has_points => Some(Order::DayFirst),
            [a, _] if a > 12 => Some(Order::DayFirst),
            [_, b] if b > 12 => Some(Order::MonthFirst),
            _ => None,
        }
    }

    /// The order by which the date, and by the other one it is not, is within a day of one of these days.
    pub(super) fn order_near(&self, days: &[f64]) -> Option<Order> {
        let is_near = |order: &Order| {
            self.days(*order).is_some_and(|own| days.iter().any(|day| (day - own).abs() <= 1.0))
        };
        let near: Vec<Order> =
            [Order::MonthFirst, Order::DayFirst].into_iter().filter(is_near).collect();
        if let [order] = near[..] { Some(order) } else { None }
    }

    /// Whether both dates are of one form; a short year that changes alone is the day of a date that begins with the year.
    pub(super) fn is_written_like(&self, other: &Self) -> bool {
        let is_other_year = self.numbers == other.numbers && self.year != other.year;
        (self.has_points, self.has_short_year) == (other.has_points, other.has_short_year)
            && !(self.has_short_year && is_other_year)
    }

    pub(super) fn is_date_of(&self, other: &Self) -> bool {
        (self.numbers, self.year) == (other.numbers, other.year)
    }

    /// Month and day.
    fn date(&self, order: Order) -> [i8; 2] {
        match (order, self.numbers) {
            (Order::MonthFirst, numbers) => numbers,
            (Order::DayFirst, [day, month]) => [month, day],
        }
    }

    pub(super) fn iso(&self, order: Order) -> String {
        let [month, day] = self.date(order);
        format!("{}-{month:02}-{day:02}", self.year)
    }

    /// Days since 1970.
    pub(super) fn days(&self, order: Order) -> Option<f64> {
        let [month, day] = self.date(order);
        let date = Date::new(self.year, month, day).ok()?;
        let midnight = since_1970(date, Time::midnight(), Offset::UTC)?;
        Some(midnight / DAY_S)
    }
}

/// A text such as `02/29/2024 10:11:32.000`, `2/9/2024 1:00:00 PM` or `29.02.2024 10:11:32`.
pub(super) fn slashed(text: &str) -> Option<Slashed> {
    let (date, time) = text.split_once([' ', 'T'])?;
    let mark = date.chars().find(|c| !c.is_ascii_digit()).filter(|c| "/-.".contains(*c))?;
    let mut numbers = date.split(mark);
    let mut next = |most: usize| {
        let number = numbers.next().filter(|n| (1..=most).contains(&n.len()))?;
        number.parse::<i16>().ok().filter(|n| *n > 0)
    };
    let (a, b) = (next(2)?, next(2)?);
    let last = numbers.next()?;
    // Between hyphens a year of two digits may come first, too.
    let year = year_of(last).filter(|_| mark != '-' || last.len() == 4)?;
    if numbers.next().is_some() {
        return None;
    }
    let numbers = [i8::try_from(a).ok()?, i8::try_from(b).ok()?];
    let (has_points, has_short_year) = (mark == '.', mark == '/' && last.len() == 2);
    let of_day = time_of_day(time.trim())?;
    Some(Slashed { numbers, has_points, year, has_short_year, of_day })
}

/// A year of four digits, or of two in this century.
fn year_of(text: &str) -> Option<i16> {
    let year: i16 = text.parse().ok()?;
    match text.len() {
        4 if year >= 1000 => Some(year),
        2 if year >= 0 => Some(year + 2000),
        _ => None,
    }
}

/// Seconds of a time of day: `9:00:00.5`, `10:00:00:500`, `10:00:00:500000`, `1:00:00 PM`, `1:00:00 p.m.`.
pub(super) fn time_of_day(text: &str) -> Option<f64> {
    let plain = text.strip_suffix(".m.").or_else(|| text.strip_suffix(".M."));
    let with_points = plain.map(|start| format!("{start}m"));
    let text = with_points.as_deref().unwrap_or(text);
    let end = text.len().checked_sub(2).and_then(|at| text.get(at..)).unwrap_or_default();
    let (is_am, is_pm) = (end.eq_ignore_ascii_case("am"), end.eq_ignore_ascii_case("pm"));
    let text = if is_am || is_pm { text[..text.len() - 2].trim_end() } else { text };
    let colons = text.bytes().filter(|b| *b == b':').count();
    let mut text = if text.as_bytes().get(1) == Some(&b':') && colons >= 2 {
        format!("0{text}")
    } else {
        text.to_owned()
    };
    if colons == 3 {
        let at = text.rfind(':')?;
        // Of fewer digits it is open whether they are milliseconds or a fraction.
        if !matches!(text.len() - at, 4 | 7 | 10) {
            return None;
        }
        text.replace_range(at..=at, ".");
    }
    let seconds = of_day(PARSER.parse_time(&text).ok()?);
    match (is_am || is_pm, seconds >= 0.5 * DAY_S) {
        (false, _) => Some(seconds),
        // The hour after midnight and that after noon are 12.
        (true, true) if seconds < 0.5 * DAY_S + 3600.0 => {
            Some(seconds - if is_am { 0.5 * DAY_S } else { 0.0 })
        }
        (true, false) => Some(seconds + if is_pm { 0.5 * DAY_S } else { 0.0 }),
        (true, true) => None,
    }
}

/// The instant of a date and time, s since 1970.
pub(in crate::recording) fn instant(text: &str) -> Option<f64> {
    read(text).filter(|(form, _)| *form != StampForm::TimeOfDay).map(|(_, seconds)| seconds)
}

pub(super) fn read(text: &str) -> Option<(StampForm, f64)> {
    // Numbers are none, though 20240301 and 1000 are forms of ISO 8601.
    let bytes = text.as_bytes();
    let is_mark = |at: usize, mark: u8| bytes.get(at) == Some(&mark);
    if let Some((days, time)) = text.split_once(" days ") {
        let of_day = time_of_day(time.trim_start_matches('+'))?;
        return Some((StampForm::Days, DAY_S * f64::from(days.parse::<i32>().ok()?) + of_day));
    }
    if let Some((minutes, seconds)) = text.split_once(':')
        && seconds.get(2..3) == Some(".")
    {
        let of_minute = seconds.parse::<f64>().ok().filter(|s| (0.0..60.0).contains(s))?;
        return Some((
            StampForm::Minutes,
            60.0 * f64::from(minutes.parse::<u16>().ok()?) + of_minute,
        ));
    }
    if is_mark(2, b':') || is_mark(1, b':') {
        return Some((StampForm::TimeOfDay, time_of_day(text)?));
    }
    // `060:10:11:32.5`, the day of the year as IRIG time codes have it; the year is not stated.
    if is_mark(3, b':') && text.bytes().filter(|b| *b == b':').count() == 3 {
        let (day, time) = text.split_at(3);
        let day = day.parse::<u16>().ok().filter(|day| (1..=366).contains(day))?;
        let of_day = time_of_day(time.strip_prefix(':')?)?;
        return Some((StampForm::Days, DAY_S * f64::from(day - 1) + of_day));
    }
    // `0.01s`.
    if let Some(number) = text.strip_suffix('s')
        && number.ends_with(|c: char| c.is_ascii_digit())
        && number.contains('.')
        && let Ok(seconds) = number.parse::<f64>()
    {
        return Some((StampForm::Duration, seconds));
    }
    // Durations of MATLAB.
    for (unit, seconds) in [(" sec", 1.0), (" min", 60.0), (" hr", 3600.0), (" days", DAY_S)] {
        if let Some(number) = text.strip_suffix(unit) {
            let number = number.trim().parse().ok().filter(|x: &f64| x.is_finite())?;
            return Some((StampForm::Duration, seconds * number));
        }
    }
    // `Thu Mar 14 10:00:00 2024` of C, `Thu, 14 Mar 2024 10:00:00` of mail.
    if let Some((name, rest)) = text.split_once([' ', ','])
        && DAYS.iter().any(|day| day.eq_ignore_ascii_case(name))
    {
        let (start, end) = rest.trim().rsplit_once(' ')?;
        let year_last = end.len() == 4 && end.bytes().all(|b| b.is_ascii_digit());
        return match start.rsplit_once(' ') {
            Some((date, time)) if year_last && time.contains(':') => {
                read(&format!("{} {end} {time}", date.trim()))
            }
            _ => read(rest.trim()),
        };
    }
    for mark in ['/', '.'] {
        if is_mark(4, mark as u8) && is_mark(7, mark as u8) {
            return read(&text.replacen(mark, "-", 2));
        }
    }
    // `2024. 02. 29. 10:11:32` of Hungarian settings.
    if is_mark(4, b'.') && is_mark(5, b' ') {
        return read(&text.replacen(". ", "-", 2).replacen(". ", " ", 1));
    }
    let is_year_first = is_mark(4, b'-')
        && is_mark(7, b'-')
        && [10, 11].into_iter().all(|at| text.is_char_boundary(at));
    if is_year_first && (is_mark(10, b'_') || is_mark(10, b'-') && is_mark(13, b':')) {
        return read(&format!("{} {}", &text[..10], &text[11..]));
    }
    // `2024-02-29 10:11:32 PM`.
    if is_year_first && text.ends_with(['m', 'M', '.']) {
        let (date, time) = text.split_at(10);
        let of_day = time_of_day(time[1..].trim())?;
        let (form, midnight) = read(&format!("{date} 00:00:00"))?;
        return Some((form, midnight + of_day));
    }
    // `2024-02-29T10-11-32.5`, `2024-02-29 10:11:32:500`.
    if is_year_first {
        let (date, time) = text.split_at(11);
        if is_mark(13, b'-') && is_mark(16, b'-') {
            return read(&format!("{date}{}", time.replacen('-', ":", 2)));
        }
        if is_mark(13, b':') && is_mark(16, b':') && is_mark(19, b':') {
            let fraction = time.split_at_checked(9)?.1;
            let digits = fraction.bytes().take_while(u8::is_ascii_digit).count();
            // Of fewer digits it is open whether they are milliseconds or a fraction.
            return match digits {
                3 | 6 | 9 => read(&format!("{date}{}.{fraction}", &time[..8])),
                _ => None,
            };
        }
    }
    // `2024年02月29日 10:11:32`.
    if text.contains('年') {
        let date = text.replacen(['年', '月'], "-", 2).replacen('日', "", 1);
        return if date.contains('年') { None } else { read(&date) };
    }
    // `20240301T100000.010`, `20240301-10:00:00.010`.
    if let Some((date, time)) = text.split_at_checked(8)
        && date.bytes().all(|b| b.is_ascii_digit())
        && let Some(time) = time.strip_prefix(['T', '-', '_', ' '])
    {
        return read(&format!("{}-{}-{} {time}", &date[..4], &date[4..6], &date[6..]));
    }
    if let Some((rest, zone)) = text.rsplit_once(' ')
        && let Some(hours) = zone_hours(zone)
    {
        return match read(rest)? {
            (StampForm::Local, seconds) => Some((StampForm::Zoned, seconds - 3600.0 * hours)),
            _ => None,
        };
    }
    if let Some(date) = with_week_or_day_of_year(text) {
        return read(&date);
    }
    if let Some(instant) = with_month_name(text) {
        return Some((StampForm::Local, instant));
    }
    if !(is_mark(4, b'-') && is_mark(7, b'-')) {
        return None;
    }
    let pieces = PARSER.parse_pieces(text).ok()?;
    let time = pieces.time()?;
    match pieces.to_numeric_offset() {
        Some(zone) => Some((StampForm::Zoned, since_1970(pieces.date(), time, zone)?)),
        None => Some((StampForm::Local, since_1970(pieces.date(), time, Offset::UTC)?)),
    }
}

/// Days of the week as they stand before a date.
const DAYS: [&str; 7] = ["mon", "tue", "wed", "thu", "fri", "sat", "sun"];

/// Hours of a zone by its name or as `+0100`; without a blank before it `+01:00` is read by the parser.
fn zone_hours(zone: &str) -> Option<f64> {
    if let Some((_, hours)) = ZONES.iter().find(|(name, _)| *name == zone) {
        return Some(*hours);
    }
    let sign = match zone.as_bytes() {
        [b'+', rest @ ..] if rest.len() == 4 && rest.iter().all(u8::is_ascii_digit) => 1.0,
        [b'-', rest @ ..] if rest.len() == 4 && rest.iter().all(u8::is_ascii_digit) => -1.0,
        _ => return None,
    };
    let number = |digits: &str| digits.parse::<f64>().ok();
    Some(sign * (number(&zone[1..3])? + number(&zone[3..5])? / 60.0))
}

/// `2024-W09-5T10:00:00` and `2024-061T10:00:00` with month and day.
fn with_week_or_day_of_year(text: &str) -> Option<String> {
    let (date, time) = text.split_once(['T', ' ']).filter(|(date, _)| date.is_ascii())?;
    let (year, rest) = date.split_once('-').filter(|(year, _)| year.len() == 4)?;
    let year = year.parse::<i16>().ok()?;
    let date = if let Some((week, day)) = rest.strip_prefix('W').and_then(|w| w.split_once('-')) {
        let day = Weekday::from_monday_one_offset(day.parse().ok()?).ok()?;
        ISOWeekDate::new(year, week.parse().ok()?, day).ok()?.date()
    } else {
        let number = rest.parse::<i16>().ok().filter(|_| rest.len() == 3)?;
        Date::new(year, 1, 1).ok()?.with().day_of_year(number).build().ok()?
    };
    Some(format!("{date} {time}"))
}

/// Seconds since 1970 of a date with the name of its month, such as `01-Mar-2024 10:00:00.010` of MATLAB,
/// `Mar 1, 2024 10:00:00` or `1. März 2024 10:00:00`.
fn with_month_name(text: &str) -> Option<f64> {
    // How they begin in English, German, French, Spanish and Italian.
    const MONTHS: [&[&str]; 12] = [
        &["jan", "ene", "gen"],
        &["feb", "fév", "fev"],
        &["mar", "mär", "mrz", "mae"],
        &["apr", "avr", "abr"],
        &["may", "mai", "mag"],
        &["jun", "juin", "giu"],
        &["jul", "juil", "lug"],
        &["aug", "aoû", "aou", "ago"],
        &["sep", "set"],
        &["oct", "okt", "ott"],
        &["nov"],
        &["dec", "dez", "déc", "dic"],
    ];
    let colon = text.find(':')?;
    let (date, time) = text.split_at(text[..colon].rfind([' ', 'T'])?);
    let parts = date.split([' ', '-', '/', ',']).filter(|part| !part.is_empty());
    let parts: Vec<&str> = parts.collect();
    let &[first, second, year] = &parts[..] else { return None };
    let month = |name: &str| {
        let name = name.to_lowercase();
        let is_it = |starts: &&[&str]| starts.iter().any(|start| name.starts_with(start));
        MONTHS.iter().position(is_it)
    };
    let (month, day) = match (month(first), month(second)) {
        (Some(month), _) => (month, second),
        (None, Some(month)) => (month, first),
        (None, None) => return None,
    };
    let day = day.trim_end_matches('.').parse().ok()?;
    let date = Date::new(year_of(year)?, i8::try_from(month + 1).ok()?, day).ok()?;
    let of_day = time_of_day(time.trim_start_matches(['T', ' ']))?;
    Some(since_1970(date, Time::midnight(), Offset::UTC)? + of_day)
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
