//! Times as ISO 8601 writes them: `2024-03-01T10:00:00.010Z`, without a zone, with the week or the day of the year, or
//! the time of day alone; dates with slashes, hyphens or points that end with the year, or with the name of the month;
//! days as spreadsheets and MATLAB count them; durations as MATLAB (`0.01 sec`), pandas (`0 days 00:00:00.01`) and stop
//! watches (`1:02.5`) write them.

use jiff::civil::{Date, ISOWeekDate, Time, Weekday};
use jiff::fmt::temporal::DateTimeParser;
use jiff::tz::Offset;

const PARSER: DateTimeParser = DateTimeParser::new();
const DAY_S: f64 = 86_400.0;
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

#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::recording) struct Stamps {
    form: StampForm,
    /// Seconds of the last time of day, with the midnights before it.
    last: f64,
    /// The first date with slashes, and which of its numbers is the day, where that is known.
    first: Slashed,
    order: Option<Order>,
    /// Days by which the first date was taken for another one.
    shift: f64,
    /// Seconds since 1970 of the first date of ISO 8601.
    first_iso: Option<f64>,
}

/// A date that ends with the year, and the time of its day, s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Slashed {
    numbers: [i8; 2],
    /// With points, the day is first.
    has_points: bool,
    year: i16,
    /// Of a year of two digits between slashes it is open whether it is last.
    has_short_year: bool,
    of_day: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Order {
    MonthFirst,
    DayFirst,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum StampForm {
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

/// The numbers of 1 January 1970 where days are counted from 30 December 1899 (Excel, LibreOffice) and from the year 0
/// (`datenum` of MATLAB).
const SERIAL_1970: [i32; 2] = [25_569, 719_529];

/// The dates of a clock, as far as they show which number is the day.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dates(FirstDate);

#[derive(Debug, Clone, Copy, PartialEq)]
enum FirstDate {
    /// The first day since 1970, of dates that ISO 8601 writes.
    Iso(f64),
    /// The first date that ends with the year, and which of its numbers is the day, where that is known.
    Slashed(Slashed, Option<Order>),
}

impl Dates {
    /// By how many seconds each file is to be shifted so that all count their dates alike: by the order that its own
    /// dates show, or else those of the others, or else the only one near a date of ISO 8601; an error with both dates
    /// where the first open one has either.
    pub(crate) fn shifts(files: &[Self]) -> Result<Vec<f64>, [String; 2]> {
        let (mut days, mut slashed) = (Vec::new(), Vec::new());
        for dates in files {
            match &dates.0 {
                FirstDate::Iso(day) => days.push(*day),
                // Its own form, which says nothing of that of others.
                FirstDate::Slashed(first, _) if first.has_points => {
                    days.extend(first.days(Order::DayFirst));
                }
                FirstDate::Slashed(first, order) => slashed.push((first, order)),
            }
        }
        let mut known = slashed.iter().filter_map(|(_, order)| **order);
        let order = known.next().filter(|order| known.all(|other| other == *order));
        let is_one_date = slashed.windows(2).all(|pair| pair[0].0.is_date_of(pair[1].0));
        let shift = |dates: &Self| {
            let FirstDate::Slashed(first, own) = &dates.0 else { return Ok(0.0) };
            let read = first.order().unwrap_or(Order::MonthFirst);
            let shown = match own.or(order).or_else(|| first.order_near(&days)) {
                Some(order) => order,
                None if is_one_date => read,
                None => return Err([Order::MonthFirst, Order::DayFirst].map(|o| first.iso(o))),
            };
            let days = first.days(shown).zip(first.days(read)).map(|(a, b)| a - b);
            Ok(days.unwrap_or_default() * DAY_S)
        };
        files.iter().map(shift).collect()
    }
}

impl Stamps {
    pub(in crate::recording) fn like(text: &str) -> Option<Self> {
        let slashed = slashed(text);
        let form = if slashed.is_some() { StampForm::Slashed } else { read(text)?.0 };
        let first = slashed.unwrap_or_default();
        let order = first.order();
        let last = f64::NEG_INFINITY;
        Some(Self { form, last, first, order, shift: 0.0, first_iso: None })
    }

    /// Times of day without colons, such as `100059.99`, which are numbers elsewhere.
    pub(super) fn of_digits() -> Self {
        let first = Slashed::default();
        let (form, last) = (StampForm::Digits, f64::NEG_INFINITY);
        Self { form, last, first, order: None, shift: 0.0, first_iso: None }
    }

    /// Days as a spreadsheet or MATLAB counts them, of a column with the name of a time and no unit: days between 2000 and
    /// 2050 whose steps would be shorter than 0.1 ms if they were seconds.
    pub(super) fn of_serial_days(cells: &[f64]) -> Option<Self> {
        const DAYS: [f64; 2] = [10_957.0, 29_220.0];
        const LONGEST_STEP: f64 = 1e-4;
        const FEWEST: usize = 4;
        let is_of = |since: &i32| {
            let days = |x: &f64| (DAYS[0]..DAYS[1]).contains(&(x - f64::from(*since)));
            cells.iter().all(days)
        };
        let since = SERIAL_1970.into_iter().find(is_of)?;
        let steps = cells.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let is_fine = steps.clone().all(|step| step < LONGEST_STEP) && steps.sum::<f64>() > 0.0;
        if cells.len() < FEWEST || !is_fine {
            return None;
        }
        let (form, last) = (StampForm::Serial(since), f64::NEG_INFINITY);
        let first = Slashed::default();
        Some(Self { form, last, first, order: None, shift: 0.0, first_iso: None })
    }

    /// The clock of rows that follow each other in equal steps, s, whose cells are blank.
    pub(super) fn of_rows(first: f64, step: f64) -> Self {
        let form = StampForm::Rows { first, step, row: 0.0 };
        let last = f64::NEG_INFINITY;
        Self { form, last, first: Slashed::default(), order: None, shift: 0.0, first_iso: None }
    }

    /// The instant of the next row, s, where rows follow each other in equal steps.
    pub(super) fn next_row(&mut self) -> Option<f64> {
        let StampForm::Rows { first, step, row } = &mut self.form else { return None };
        *row += 1.0;
        Some(*first + *step * (*row - 1.0))
    }

    /// Begins with the first instant again, as below a repeated header.
    pub(super) fn restart_rows(&mut self) {
        if let StampForm::Rows { row, .. } = &mut self.form {
            *row = 0.0;
        }
    }

    /// Whether the texts are numbers elsewhere.
    pub(super) fn are_numbers(&self) -> bool {
        matches!(self.form, StampForm::Digits | StampForm::Serial(_))
    }

    /// Its dates, as far as they were read.
    pub(super) fn dates(&self) -> Option<Dates> {
        match self.form {
            StampForm::Slashed => Some(Dates(FirstDate::Slashed(self.first, self.order))),
            _ => Some(Dates(FirstDate::Iso((self.first_iso? / DAY_S).floor()))),
        }
    }

    /// What is open of the dates or how numbers were taken for dates, for people; neither changes a time between two rows.
    pub(super) fn remark(&self) -> Option<String> {
        if let StampForm::Serial(since) = self.form {
            let counted =
                if since == SERIAL_1970[0] { "a spreadsheet" } else { "MATLAB's datenum" };
            return Some(format!("the numbers are days, as {counted} counts them"));
        }
        if self.form != StampForm::Slashed {
            return None;
        }
        match (self.order, self.first.has_short_year) {
            (None, false) => Some("day and month are open and the month is taken to be first, which changes no time between rows".into()),
            (None, true) => Some("day, month and year are open; the month is taken to be first and the year to be last, which changes no time between rows".into()),
            (Some(_), true) => Some("a year of two digits is taken to be the last number of the dates, which changes no time between rows".into()),
            (Some(_), false) => None,
        }
    }

    /// Seconds since 1970 of a date with slashes; where day and month are open, the month is taken to be first until
    /// another date shows which is the day.
    fn of_slashed(&mut self, text: &str) -> Option<f64> {
        let own = slashed(text).filter(|own| own.is_written_like(&self.first))?;
        if self.order.is_none() {
            let [a, b] = self.first.numbers;
            self.order = own.order().or(match own.numbers {
                [_, d] if own.numbers[0] == a && d != b => Some(Order::MonthFirst),
                [d, _] if own.numbers[1] == b && d != a => Some(Order::DayFirst),
                _ if own.numbers == self.first.numbers => None,
                _ => return None,
            });
            if let Some(order) = self.order {
                self.shift = self.first.days(Order::MonthFirst)? - self.first.days(order)?;
            }
        }
        let days = own.days(self.order.unwrap_or(Order::MonthFirst))? + self.shift;
        Some(days * DAY_S + own.of_day)
    }

    /// Seconds since 1970, or since the first midnight where there is no date; `None` where the text is
    /// no time of this form. A time of day half a day or more before the last is one of the next day.
    pub(in crate::recording) fn seconds(&mut self, text: &str) -> Option<f64> {
        if self.form == StampForm::Slashed {
            return self.of_slashed(text);
        }
        if let StampForm::Serial(since) = self.form {
            let days: f64 = text.replace(',', ".").parse().ok()?;
            let seconds = (days - f64::from(since)) * DAY_S;
            self.first_iso.get_or_insert(seconds);
            return if seconds.is_finite() { Some(seconds) } else { None };
        }
        let mut form_and_seconds = read(text);
        if self.form == StampForm::Digits {
            // Zeros that lead may be missing.
            let whole = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
            let text = format!("{}{text}", "0".repeat(6_usize.checked_sub(whole)?));
            let (hours, rest) = text.split_at_checked(2)?;
            let (minutes, seconds) = rest.split_at_checked(2)?;
            let of_day = time_of_day(&format!("{hours}:{minutes}:{seconds}"))?;
            form_and_seconds = Some((StampForm::Digits, of_day));
        }
        let (form, mut seconds) = form_and_seconds?;
        if form != self.form {
            return None;
        }
        if matches!(form, StampForm::TimeOfDay | StampForm::Digits) {
            if self.last.is_finite() {
                let days = ((self.last - seconds) / DAY_S).round().max(0.0);
                seconds += days * DAY_S;
            }
            self.last = seconds.max(self.last);
        }
        if matches!(form, StampForm::Zoned | StampForm::Local) {
            self.first_iso.get_or_insert(seconds);
        }
        Some(seconds)
    }
}

impl Slashed {
    /// Which number is the day, where the other cannot be a month.
    fn order(&self) -> Option<Order> {
        match self.numbers {
            _ if self.has_points => Some(Order::DayFirst),
            [a, _] if a > 12 => Some(Order::DayFirst),
            [_, b] if b > 12 => Some(Order::MonthFirst),
            _ => None,
        }
    }

    /// The order by which the date, and by the other one it is not, is within a day of one of these days.
    fn order_near(&self, days: &[f64]) -> Option<Order> {
        let is_near = |order: &Order| {
            self.days(*order).is_some_and(|own| days.iter().any(|day| (day - own).abs() <= 1.0))
        };
        let near: Vec<Order> =
            [Order::MonthFirst, Order::DayFirst].into_iter().filter(is_near).collect();
        if let [order] = near[..] { Some(order) } else { None }
    }

    /// Whether both dates are of one form; a short year that changes alone is the day of a date that begins with the year.
    fn is_written_like(&self, other: &Self) -> bool {
        let is_other_year = self.numbers == other.numbers && self.year != other.year;
        (self.has_points, self.has_short_year) == (other.has_points, other.has_short_year)
            && !(self.has_short_year && is_other_year)
    }

    fn is_date_of(&self, other: &Self) -> bool {
        (self.numbers, self.year) == (other.numbers, other.year)
    }

    /// Month and day.
    fn date(&self, order: Order) -> [i8; 2] {
        match (order, self.numbers) {
            (Order::MonthFirst, numbers) => numbers,
            (Order::DayFirst, [day, month]) => [month, day],
        }
    }

    fn iso(&self, order: Order) -> String {
        let [month, day] = self.date(order);
        format!("{}-{month:02}-{day:02}", self.year)
    }

    /// Days since 1970.
    fn days(&self, order: Order) -> Option<f64> {
        let [month, day] = self.date(order);
        let date = Date::new(self.year, month, day).ok()?;
        let midnight = since_1970(date, Time::midnight(), Offset::UTC)?;
        Some(midnight / DAY_S)
    }
}

/// A text such as `02/29/2024 10:11:32.000`, `2/9/2024 1:00:00 PM` or `29.02.2024 10:11:32`.
fn slashed(text: &str) -> Option<Slashed> {
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

/// Seconds of a time of day: `9:00:00.5`, `10:00:00:500`, `1:00:00 PM`, `1:00:00 p.m.`.
fn time_of_day(text: &str) -> Option<f64> {
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
        if text.len() - at != 4 {
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

fn read(text: &str) -> Option<(StampForm, f64)> {
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
    if is_mark(4, b'-') && is_mark(7, b'-') && is_mark(10, b'_') {
        return read(&text.replacen('_', " ", 1));
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
        for text in [
            "2024-03-01 10:00:00 UTC",
            "2024-03-01 11:00:00 CET",
            "2024.03.01 10:00:00",
            "2024-03-01_10:00:00.000",
            "20240301T100000.000",
            "20240301-10:00:00.000",
            "01-Mar-2024 10:00:00.000",
            "01-Mär-2024 10:00:00",
            "Mar 1, 2024 10:00:00 AM",
            "1 March 2024 10:00:00",
            "01.03.24 10:00:00",
            "01-Mar-24 10:00:00",
            "1. März 2024 10:00:00",
            "1 mars 2024 10:00:00",
            "2024-W09-5T10:00:00",
            "2024-061T10:00:00Z",
            "Fri Mar  1 10:00:00 2024",
            "Fri, 01 Mar 2024 11:30:00 +0130",
            "01/Mar/2024 10:00:00 a.m.",
        ] {
            assert_eq!(at(text), 0.0, "{text}");
        }
        assert_eq!(at("2024-03-02T00:00:00Z") - at("2024-03-01T23:59:59Z"), 1.0);
        // A zone now and none then cannot be put in order.
        assert_eq!(seconds(&["2024-03-01T10:00:00Z", "2024-03-01T10:00:01"])[1], None);
        for none in [
            "20240301",
            "1000",
            "10.5",
            "",
            "2024-03-01",
            "2024-13-01T10:00:00",
            "1:2",
            "run 1 2024 10:00:00",
            "01-Mar-124 10:00:00",
            "2024-W54-1T10:00:00",
            "2024-366-1T10:00:00",
            "2023-366T10:00:00",
            "Fri Mar 01 10:00:00 GMT+01:00 2024",
        ] {
            assert_eq!(Stamps::like(none), None, "{none}");
        }
    }

    #[test]
    fn dates_with_slashes_and_times_of_other_tools() {
        // `date -u -d '2024-02-29T10:11:32Z' +%s`
        let leap = 1_709_201_492.0;
        for text in [
            "2024/02/29 10:11:32.000",
            "02/29/2024 10:11:32",
            "29/2/2024 10:11:32 AM",
            "29.02.2024 10:11:32,000",
            "29-02-2024 10:11:32",
            "2/29/24 10:11:32",
        ] {
            assert_eq!(seconds(&[text])[0], Some(leap), "{text}");
        }
        // With points the day is first, of a date with either order, too.
        let fourth = ["03.04.2024 23:59:59", "04.04.2024 00:00:00"];
        assert!(Stamps::like(fourth[0]).unwrap().remark().is_none());
        assert_eq!(seconds(&fourth), [1_712_188_799.0, 1_712_188_800.0].map(Some));
        assert_eq!(seconds(&["03.04.2024 10:00:00", "03/04/2024 10:00:00"])[1], None);
        assert_eq!(seconds(&["2/29/2024 10:11:32 PM"])[0], Some(leap + 0.5 * DAY_S));
        // 3 April or 4 March: open, and then the number that goes on is the day.
        for texts in [
            ["03/04/2024 23:59:59", "03/05/2024 00:00:00"],
            ["03/04/2024 23:59:59", "04/04/2024 00:00:00"],
        ] {
            assert!(Stamps::like(texts[0]).unwrap().remark().is_some());
            let read: Vec<f64> = seconds(&texts).into_iter().flatten().collect();
            assert_eq!(read[1] - read[0], 1.0, "{texts:?}");
        }
        assert_eq!(seconds(&["03/04/2024 10:00:00", "04/05/2024 10:00:00"])[1], None);
        for (text, expected) in [
            ("10:00:00:250", 36_000.25),
            ("9:00:00.250", 32_400.25),
            ("12:00:01 AM", 1.0),
            ("12:00:01 PM", 43_201.0),
            ("0.25 sec", 0.25),
            ("0 sec", 0.0),
            ("0.5 min", 30.0),
            ("0.5 hr", 1800.0),
            ("1.5 days", 129_600.0),
            ("1:02.5", 62.5),
            ("00:02.500", 2.5),
            ("0 days 00:00:01.250000", 1.25),
            ("-1 days +23:59:59", -1.0),
        ] {
            assert_eq!(seconds(&[text])[0], Some(expected), "{text}");
        }
        for none in [
            "1:23",
            "1/2",
            "13-01-24 10:00:00",
            "x sec",
            "30/30/2024 10:00:00",
            "13:00:00 PM",
            "1:72.5",
            "x days 00:00:00",
        ] {
            assert_eq!(Stamps::like(none).and_then(|mut s| s.seconds(none)), None, "{none}");
        }
    }

    #[test]
    fn short_years_are_last_unless_only_the_last_number_goes_on() {
        let remark = |text: &str| Stamps::like(text).unwrap().remark().unwrap_or_default();
        assert!(remark("03/04/24 10:00:00").starts_with("day, month and year are open"));
        assert!(remark("24/03/14 10:00:00").starts_with("a year of two digits"));
        assert_eq!(remark("03.04.24 10:00:00"), "");
        // The day after 14 March 2024 that begins with its year is not a year later.
        assert_eq!(seconds(&["24/03/14 23:59:59", "24/03/15 00:00:00"])[1], None);
        let read = seconds(&["03/14/24 23:59:59", "03/15/24 00:00:00"]);
        assert_eq!(read[1].unwrap() - read[0].unwrap(), 1.0);
    }

    #[test]
    fn days_of_spreadsheets_and_of_matlab_differ_from_seconds_by_their_steps() {
        let cells = |first: f64, step: f64| [0.0, 1.0, 2.0, 3.0].map(|k| first + step * k);
        // `date -u -d '2024-03-01T12:00:00Z' +%s`; 45352 in Excel, `datenum(2024,3,1)`.
        for first in [45_352.5, 739_312.5] {
            let mut days = Stamps::of_serial_days(&cells(first, 1e-7)).unwrap();
            assert_eq!(days.seconds(&first.to_string()), Some(1_709_294_400.0), "{first}");
            assert!(days.remark().unwrap().starts_with("the numbers are days"), "{first}");
        }
        let mut days = Stamps::of_serial_days(&cells(45_352.5, 1e-7)).unwrap();
        assert_eq!(days.seconds("45352,5"), Some(1_709_294_400.0));
        for (first, step) in [(45_352.5, 0.01), (0.5, 1e-7), (45_352.5, 0.0), (36.0, 1e-7)] {
            assert!(Stamps::of_serial_days(&cells(first, step)).is_none(), "{first} {step}");
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
