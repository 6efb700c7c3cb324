//! Times as ISO 8601 writes them: `2024-03-01T10:00:00.010Z`, without a zone, with the week or the day of the year, or
//! the time of day alone; dates with slashes, hyphens or points that end with the year, or with the name of the month;
//! days as spreadsheets and MATLAB count them; durations as MATLAB (`0.01 sec`), pandas (`0 days 00:00:00.01`) and stop
//! watches (`1:02.5`) write them.

use super::instants::{DAY_S, Order, Slashed, StampForm, read, slashed, time_of_day};

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
            "2024-03-01 10:00:00:000",
            "2024-03-01T10:00:00:000000Z",
            "2024-03-01_10-00-00.000",
            "2024.03.01-10:00:00.000",
            "2024/03/01 10:00:00.000 AM",
            "2024-03-01 10:00:00 a.m.",
            "2024. 03. 01. 10:00:00",
            "2024-03-01T10-00-00",
            "2024年03月01日 10:00:00.000",
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
            "2024-03-01 10:00:00:50",
            "2024年",
            "2024-03-01 13:00:00 PM",
            "2024-03-01m",
            "2024-03-0é m",
            "年月日",
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
            ("10:00:00:250000", 36_000.25),
            ("9:00:00.250", 32_400.25),
            ("002:10:00:00.250", 122_400.25),
            ("002:10:00:00", 122_400.0),
            ("0.25s", 0.25),
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
            "10:00:00:2500",
            "400:10:00:00",
            "12s",
            "1.xs",
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
