//! What can go wrong with a log, with the place, the numbers and what to do next.

use crate::role::unit_in_place_of;
use crate::units::known_units;

/// A cell of a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file as the caller named it.
    pub file: String,
    /// Line, from 1.
    pub line: u64,
    /// The column's header.
    pub column: String,
}

impl Place {
    pub(crate) fn new(file: &str, line: u64, column: &str) -> Box<Self> {
        Box::new(Self { file: file.into(), line, column: column.into() })
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}: column `{}`", self.file, self.line, self.column)
    }
}

/// Why a log was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("no log was given")]
    NoFiles,
    #[error("{file}: the file is empty")]
    EmptyFile { file: String },
    #[error("{file}:{line}: the file is not text (UTF-8)")]
    NotText { file: String, line: u64 },
    #[error("{file}: the text is UTF-16, and UTF-8 is expected")]
    Utf16 { file: String },
    #[error("{file}:{line}: {problem}")]
    Csv { file: String, line: u64, problem: String },
    #[error("{file}:{line}: the row has {got} cells, the header has {expected}")]
    RaggedRow { file: String, line: u64, got: usize, expected: usize },
    #[error("{file}:{line}: the header names the column `{column}` twice")]
    RepeatedColumn { file: String, line: u64, column: String },
    #[error("no column `{column}` (for the {role}); there are: {available}")]
    MissingColumn { role: &'static str, column: String, available: String },
    #[error("which column is the {role}? {problem}; there are: {available}")]
    RoleNotFound { role: &'static str, problem: String, available: String },
    #[error("the column `{column}` (for the {role}) is in more than one file: {files}")]
    AmbiguousColumn { role: &'static str, column: String, files: String },
    #[error("{at}: `{text}` is not a number")]
    NotANumber { at: Box<Place>, text: String },
    #[error(
        "{at}: `{text}` has a decimal {}, {}",
        if text.contains(',') { "comma or groups of digits" } else { "point" },
        other.map_or("and the first rows leave open which".into(), |other| format!("and the file's decimal mark is a {other}"))
    )]
    DecimalMark { at: Box<Place>, text: String, other: Option<&'static str> },
    #[error("{at}: `{text}` is not a time written like those above it (ISO 8601)")]
    NotATime { at: Box<Place>, text: String },
    #[error("{at}: `{text}` is not a finite number")]
    NotFinite { at: Box<Place>, text: String },
    #[error("{at}: the unit is not stated")]
    UnitNotStated { at: Box<Place> },
    #[error("{file}: column `{column}`: `{unit}` is not a unit known here")]
    UnknownUnit { file: String, column: String, unit: String },
    #[error("{at}: the header has the unit {header}, the row under it {row}")]
    UnitsDiffer { at: Box<Place>, header: &'static str, row: &'static str },
    #[error("{at}: {value} is beyond ±1, and a full scale is stated for this steering command")]
    BeyondFullScale { at: Box<Place>, value: f64 },
    #[error("a unit is given for `{column}`, which is not a column that is read")]
    UnusedUnit { column: String },
    #[error(
        "{file}: column `{column}` is in {unit}, which is no unit of the {role} (expected {expected})"
    )]
    WrongQuantity {
        file: String,
        column: String,
        role: &'static str,
        unit: &'static str,
        expected: &'static str,
    },
    #[error("{file}: no column tells the time; there are: {available}")]
    NoTime { file: String, available: String },
    #[error("{at}: time {time} s does not come after {before} s in the row before")]
    TimeNotIncreasing { at: Box<Place>, time: f64, before: f64 },
    #[error(
        "{file}: column `{column}`: {values} values share {instants} instants: the clock is too coarse"
    )]
    CoarseClock { file: String, column: String, values: usize, instants: usize },
    #[error(
        "{at}: nothing from {from_s} s to {} s, a gap of {} s where at most {limit_s} s are bridged",
        short(*.to_s), short(*.gap_s)
    )]
    Gap { at: Box<Place>, from_s: f64, to_s: f64, gap_s: f64, limit_s: f64, longest: (f64, f64) },
    #[error(
        "which files are one drive? {complete} bring steering and yaw rate each, {other} does not"
    )]
    AmbiguousDrives { complete: String, first: String, other: String },
    #[error("{second} is the same recording as {first}")]
    RepeatedDrive { first: String, second: String },
    #[error(
        "the speed stays within {from:.1} to {to:.1} m/s for {kept_s:.1} s only (in stretches of {shortest_s:.1} s or more); it goes from {least:.1} to {most:.1} m/s"
    )]
    SpeedWindow {
        from: f64,
        to: f64,
        kept_s: f64,
        shortest_s: f64,
        least: f64,
        most: f64,
        quartiles: (f64, f64),
    },
    #[error("a speed window needs a speed column, and {drive} has none")]
    NoSpeedForWindow { drive: String },
    #[error("{file}: column `{column}`: the {role} is {value} {unit} throughout")]
    Constant { file: String, column: String, role: &'static str, value: f64, unit: &'static str },
    #[error("{at}: the {role} would be {} {si} (read as {unit}), beyond {limit} {si}", short(*.value))]
    Impossible {
        at: Box<Place>,
        role: &'static str,
        value: f64,
        si: &'static str,
        unit: &'static str,
        limit: f64,
        alternatives: String,
    },
    #[error(
        "{file}: column `{column}` is a steering wheel's angle, and no steering ratio is given"
    )]
    SteeringRatioUnknown { file: String, column: String },
    #[error(
        "{at}: {largest_deg:.0}° is more than a road wheel can turn, and no steering ratio is given"
    )]
    NotARoadWheel { at: Box<Place>, largest_deg: f64 },
    #[error("{file}: column `{column}`: a speed of {mean_mps:.2} m/s on average is a standstill")]
    Standstill { file: String, column: String, mean_mps: f64 },
    #[error("{file}: column `{column}` has {got} values with a time, a log needs {need} or more")]
    TooFewRows { file: String, column: String, got: usize, need: usize },
    #[error("{got} samples of {sample_time_s} s are too few: {need} are needed")]
    TooFewSamples { got: usize, need: usize, sample_time_s: f64 },
    #[error("{} s by samples of {} s: more than {limit} samples", short(*.duration_s), short(*.sample_time_s))]
    TooManySamples { duration_s: f64, sample_time_s: f64, limit: usize },
    #[error(
        "the clocks do not overlap: {first} covers {} to {} s, {second} {} to {} s",
        short(*.first_from), short(*.first_to), short(*.second_from), short(*.second_to)
    )]
    NoOverlap {
        first: String,
        first_from: f64,
        first_to: f64,
        second: String,
        second_from: f64,
        second_to: f64,
    },
    #[error("a sample time of {asked} s is shorter than the log's own {} s", short(*.least))]
    SampleTimeTooShort { asked: f64, least: f64 },
    #[error("option {option}: {value} is out of range, expected {expected}")]
    Option { option: &'static str, value: String, expected: String },
    #[error("{file}: the file has no {role}, and each file is read as a drive of its own here")]
    NotADrive { file: String, role: &'static str },
    #[error(
        "{file}:{line}: column `{column}`: the clock's period changes from {} s to {} s",
        short(*.before_s), short(*.period_s)
    )]
    ClockChanged { file: String, line: u64, column: String, before_s: f64, period_s: f64 },
}

impl Error {
    /// What the reader can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::NoFiles => "name a CSV file with a header line".into(),
            Self::EmptyFile { .. } | Self::NotText { .. } => {
                "the log must be CSV text with a header line and a row for each sample".into()
            }
            Self::Utf16 { .. } => {
                "save it as UTF-8, as with: iconv -f UTF-16 -t UTF-8 LOG > UTF8.csv".into()
            }
            Self::RaggedRow { got, expected, .. } if got > expected => {
                "each row needs a cell for each column; where numbers have decimal commas, export them with ; or tabs between the cells, or with decimal points".into()
            }
            Self::Csv { .. } | Self::RaggedRow { .. } => {
                "mend the row, or cut the file before it; each row needs a cell for each column"
                    .into()
            }
            Self::RepeatedColumn { .. } => "give each column a name of its own".into(),
            Self::MissingColumn { role, .. } | Self::RoleNotFound { role, .. } => format!(
                "name it with {}, with a leading - (as in --output-channel=-gyro_down_radps) where its sign is opposite",
                flag(role)
            ),
            Self::AmbiguousColumn { column, files, .. } => {
                let mut files = files.split(", ");
                let first = files.next().unwrap_or_default();
                let column = column.rsplit_once(':').map_or(column.as_str(), |(_, column)| column);
                if files.next() == Some(first) {
                    format!("give {first} once")
                } else {
                    format!("say which file, as in {first}:{column}")
                }
            }
            Self::DecimalMark { .. } => {
                "state the mark with --decimal comma or --decimal point; export numbers without groups of digits".into()
            }
            Self::NotATime { .. } => {
                "write all times of a column alike, as in 2024-03-01T10:00:00.010Z or 10:00:00.010; leave a cell blank where it is missing".into()
            }
            Self::NotANumber { text, .. } if text.contains(':') => {
                "write times as numbers, or as ISO 8601 does: 2024-03-01T10:00:00.010Z".into()
            }
            Self::NotANumber { .. } => {
                "write numbers; leave a cell blank (or NaN) where a sample is missing".into()
            }
            Self::NotFinite { .. } => "leave the cell blank where a sample is missing".into(),
            Self::UnitNotStated { at } => {
                let column = &at.column;
                let (suffix, unit) = unit_in_place_of(column);
                let stated = unit_option(column, unit);
                let normalised =
                    if unit == "deg" { "; a normalised command (−1 to 1) has the unit 1" } else { "" };
                format!(
                    "end the column's name in its unit, as in {column}_{suffix}, write `{column} [{unit}]`, or state it: --unit {stated}{normalised}"
                )
            }
            Self::UnitsDiffer { at, row, .. } => {
                format!("state the one that is right: --unit {}", unit_option(&at.column, row))
            }
            Self::BeyondFullScale { .. } => {
                "state the unit % where 100 is the full scale, or the angle's unit; leave --steering-full-scale out where 1 is not the full scale".into()
            }
            Self::UnknownUnit { .. } => format!("known units: {}", known_units()),
            Self::UnusedUnit { .. } => {
                "spell the name as in the header, or drop the --unit option".into()
            }
            Self::WrongQuantity { column, .. } => format!(
                "map another column, or state the unit where the name misleads: --unit {column}=UNIT"
            ),
            Self::NoTime { .. } => {
                "name it with --time-channel, its unit in the name (time_s, t_ms, stamp_ns), or state the rows' period with --row-period".into()
            }
            Self::TimeNotIncreasing { .. } => {
                "sort the rows by time; where two recordings were joined, give them one at a time".into()
            }
            Self::CoarseClock { .. } => {
                "export the time with more digits, or leave its column out and state --row-period".into()
            }
            Self::Gap { longest, .. } => format!(
                "the longest part without such a gap, {}s..{}s, is too short to identify from; a larger --max-gap bridges it by a straight line, which is wrong where the vehicle turned",
                longest.0, longest.1
            ),
            Self::AmbiguousDrives { first, other, .. } => format!(
                "say which belong together, as in --drive {first},{other}, or leave {other} out"
            ),
            Self::RepeatedDrive { second, .. } => format!("give {second} once"),
            Self::SpeedWindow { quartiles: (low, high), .. } => format!(
                "half of the time it is between {low:.1} and {high:.1} m/s: widen --speed-window, or leave it out"
            ),
            Self::NoSpeedForWindow { .. } => {
                "name it with --speed-channel, or leave --speed-window out".into()
            }
            Self::Constant { role, .. } if *role == "steering" => {
                "nothing can be identified from a steering angle that does not move: check the mapping, or record a slalom".into()
            }
            Self::Constant { .. } => "check the mapping and the sensor".into(),
            Self::Impossible { alternatives, .. } => alternatives.clone(),
            Self::SteeringRatioUnknown { .. } => {
                "state the steering angle over the road-wheel angle, as in --steering-ratio 15; 1 where the column is the road wheel's".into()
            }
            Self::NotARoadWheel { .. } => {
                "state --steering-ratio (about 15 for a car's steering wheel), or the right unit with --unit".into()
            }
            Self::Standstill { .. } => {
                "map the column that has the speed with --speed-channel NAME, state its unit with --unit, or cut to the part that is driven with --window; without any speed column the dynamics can be identified, but no position".into()
            }
            Self::TooFewSamples { .. } => {
                "record longer (a minute or more), widen --window, or give a shorter --sample-time; where the drive was longer, check the unit of the time".into()
            }
            Self::TooFewRows { .. } => {
                "check that the file has rows with a time and a value in this column; a minute of driving or more is needed".into()
            }
            Self::TooManySamples { .. } => {
                "check the time column and its unit; cut the drive with --window, or give a longer --sample-time".into()
            }
            Self::NoOverlap { .. } => {
                "the files must be of one drive and count time from one origin; check --window too".into()
            }
            Self::SampleTimeTooShort { least, .. } => {
                format!("give --sample-time {}s or more, or leave it out", short(*least))
            }
            Self::Option { option, .. } => format!("give {option} within that range, or leave it out"),
            Self::NotADrive { role, .. } => format!(
                "name the column with {}; where a drive's channels are in several files, merge them into one, or identify from the files together: steerwright identify A.csv B.csv",
                flag(role)
            ),
            Self::ClockChanged { .. } => {
                "cut the file where its rate changes and absorb the parts one by one, with one --sample-time".into()
            }
        }
    }
}

/// A number for people: nine digits, with an exponent where it is large or small.
pub(crate) fn short(x: f64) -> String {
    if x == 0.0 || (1e-4..1e7).contains(&x.abs()) {
        let scale = 10f64.powi(8 - x.abs().max(1e-4).log10().floor() as i32);
        ((x * scale).round() / scale).to_string()
    } else {
        format!("{x:.3e}")
    }
}

/// A column and its unit for a command line.
fn unit_option(column: &str, unit: &str) -> String {
    if column.contains(' ') { format!("\"{column}={unit}\"") } else { format!("{column}={unit}") }
}

fn flag(role: &str) -> &'static str {
    match role {
        "steering" => "--input-channel NAME",
        "yaw rate" => "--output-channel NAME",
        "speed" => "--speed-channel NAME",
        "time" => "--time-channel NAME",
        _ => "its option",
    }
}

/// `1 gap`, `2 gaps`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

pub(crate) fn round_ms(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

pub(crate) fn last_part(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

pub(crate) fn stem(path: &str) -> String {
    let name = last_part(path);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}
