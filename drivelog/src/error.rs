//! The errors of the crate with their places and numbers, and a hint for each.

use crate::formats::LOG_FORMATS;
use crate::role::unit_in_place_of;
use crate::units::known_units;
use miette::Diagnostic;
use std::borrow::Cow;

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
        write!(f, "{}:{}: column `{}`", self.file, self.line, shortened(&self.column))
    }
}

/// Why a log was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error, Diagnostic)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("no log is named")]
    #[diagnostic(help("{}", name_a_log()))]
    NoFiles,
    #[error("{file}: byte {byte}: {problem}")]
    #[diagnostic(help(
        "the file is damaged or was not written to its end: copy it again, or export the part that can be read"
    ))]
    Read { file: String, byte: u64, problem: String },
    #[error("{file}: no column has numbers")]
    #[diagnostic(help("export time, steering, yaw rate and speed as columns of numbers"))]
    NoNumbers { file: String },
    #[error(
        "{file}: a file of this format is read at several places, and a stream cannot be sought"
    )]
    #[diagnostic(help("name the file itself, not standard input or a pipe"))]
    NotSought { file: String },
    #[error("{file}: a raw bus with {kinds} kinds of frames, and no database is named")]
    #[diagnostic(help("name the CAN database (DBC) of the vehicle"))]
    NoDatabase { file: String, kinds: usize },
    #[error("{file}: none of the {kinds} kinds of frames is in the databases{faults}")]
    #[diagnostic(help("name the database of this vehicle and bus"))]
    NotInDatabase { file: String, kinds: usize, faults: String },
    #[error("{file}: no data frame of CAN was read{faults}")]
    #[diagnostic(help(
        "log a CAN bus with numbers for identifiers, or name the database of the messages' names; LIN, FlexRay and Ethernet are not read"
    ))]
    NoFrames { file: String, faults: String },
    #[error("{file}: the frames of candump have no time")]
    #[diagnostic(help(
        "record with candump -ta or candump -L, which write the time of each frame"
    ))]
    FramesWithoutTime { file: String },
    #[error("{file}: this is {format}, which is not read here")]
    #[diagnostic(help("{help}"))]
    OtherFormat { file: String, format: &'static str, help: &'static str },
    #[error("{file}: {problem}")]
    #[diagnostic(help("use columns of equal length with different names"))]
    Columns { file: String, problem: String },
    #[error("{file}: {problem}")]
    #[diagnostic(help(
        "a mapping has steering, yaw_rate, speed, time, units, topics, dbc, steering_ratio and the like, for all vehicles or under [vehicle.NAME]"
    ))]
    Mapping { file: String, problem: String },
    #[error("{file}: there is no topic {topics}; there are: {available}")]
    #[diagnostic(help(
        "spell the topic, message or channel group as inspect lists it; a table has none"
    ))]
    NoSuchTopic { file: String, topics: String, available: String },
    #[error("the channels of `{expression}` (for the {role}) have different clocks")]
    #[diagnostic(help(
        "combine channels of one topic, message or channel group, or log them with one clock"
    ))]
    SeveralClocks { role: &'static str, expression: String },
    #[error("{file}: the file is empty")]
    #[diagnostic(help("{}", name_a_log()))]
    EmptyFile { file: String },
    #[error("{file}: this is a JSON document, not a log")]
    #[diagnostic(help("{}", name_a_log()))]
    Json { file: String },
    #[error("{file}:{line}: the file is not text (UTF-8)")]
    #[diagnostic(help("{}", name_a_log()))]
    NotText { file: String, line: u64 },
    #[error("{file}: the text is UTF-16, and UTF-8 is expected")]
    #[diagnostic(help("save it as UTF-8, as with: iconv -f UTF-16 -t UTF-8 LOG > UTF8.csv"))]
    Utf16 { file: String },
    #[error("{file}:{line}: {problem}")]
    #[diagnostic(help("{}", complete_rows(0, 0)))]
    Csv { file: String, line: u64, problem: String },
    #[error("{file}:{line}: the row has {}, the header has {expected}", counted(*.got, "cell"))]
    #[diagnostic(help("{}", if *blanks { BLANKS } else { complete_rows(*got, *expected) }))]
    RaggedRow { file: String, line: u64, got: usize, expected: usize, blanks: bool },
    #[error(
        "{file}:{line}: a quote that begins in this row is not closed; it takes in the rest of the file"
    )]
    #[diagnostic(help("close the quote, or remove it"))]
    OpenQuote { file: String, line: u64 },
    #[error(
        "{file}:{line}: a quote that begins in this line is closed in line {last} only; it takes in {}",
        counted(*.rows, "row")
    )]
    #[diagnostic(help(
        "remove the quotes of both lines; a quote that belongs to a text is written twice, within quotes"
    ))]
    LongQuote { file: String, line: u64, last: u64, rows: usize },
    #[error(
        "{file}:{line}: the header names the column `{name}` twice",
        name = shortened(.column)
    )]
    #[diagnostic(help("use a different name for each column"))]
    RepeatedColumn { file: String, line: u64, column: String },
    #[error(
        "no column `{name}` (for the {role}); there are: {available}",
        name = shortened(.column)
    )]
    #[diagnostic(help("{}", CHANNEL))]
    MissingColumn { role: &'static str, column: String, available: String },
    #[error("which column is the {role}? {problem}; there are: {available}")]
    #[diagnostic(help("{}", CHANNEL))]
    RoleNotFound { role: &'static str, problem: String, available: String },
    #[error(
        "the column `{name}` (for the {role}) is in more than one file: {files}",
        name = shortened(.column)
    )]
    #[diagnostic(help("{}", one_file(column, files)))]
    AmbiguousColumn { role: &'static str, column: String, files: String },
    #[error("{at}: `{text}` is not a number")]
    #[diagnostic(help("{}", numbers(text)))]
    NotANumber { at: Box<Place>, text: String },
    #[error("{first}: {bad} of {rows} rows, at most 1 in 100")]
    #[diagnostic(help("{}", first.hint()))]
    TooManyBadCells { first: Box<Self>, bad: u64, rows: u64 },
    #[error(
        "{at}: `{text}` has a decimal {}, {}",
        if text.contains(',') { "comma or groups of digits" } else { "point" },
        other.map_or("and the first rows leave open which".into(), |other| format!("and the file's decimal mark is a {other}"))
    )]
    #[diagnostic(help(
        "state the decimal mark, a comma or a point; export numbers without groups of digits"
    ))]
    DecimalMark { at: Box<Place>, text: String, other: Option<&'static str> },
    #[error("{at}: `{text}` is not a time written like those above it (ISO 8601)")]
    #[diagnostic(help(
        "write all times of a column alike, as in 2024-03-01T10:00:00.010Z or 10:00:00.010; leave a cell blank where it is missing"
    ))]
    NotATime { at: Box<Place>, text: String },
    #[error("{at}: `{text}` is neither a number nor a time in a form that is read")]
    #[diagnostic(help(
        "write times as in 2024-03-01T10:00:00.010Z, 01.03.2024 10:00:00.010, 3/1/2024 10:00:00 AM, 01-Mar-2024 10:00:00 or 10:00:00.010, or as numbers with the unit in the name (time_s, t_ms)"
    ))]
    UnreadTime { at: Box<Place>, text: String },
    #[error("{at}: `{text}` is not a finite number")]
    #[diagnostic(help("leave the cell blank where a sample is missing"))]
    NotFinite { at: Box<Place>, text: String },
    #[error("{file}: the first date is {} or {}: day and month are open", dates[0], dates[1])]
    #[diagnostic(help(
        "the files of the drive begin on different dates, and no date shows which number is the day: write dates as in {}", dates[0]
    ))]
    OpenDates { file: String, dates: [String; 2] },
    #[error("{at}: the unit is not stated")]
    #[diagnostic(help("{}", state_unit(&at.column)))]
    UnitNotStated { at: Box<Place> },
    #[error(
        "{file}: column `{name}`: `{own}` is not a known unit",
        name = shortened(.column), own = shortened(.unit)
    )]
    #[diagnostic(help("known units: {}", known_units()))]
    UnknownUnit { file: String, column: String, unit: String },
    #[error("{at}: the header has the unit {header}, the row under it {row}")]
    #[diagnostic(help("state the unit that is right"))]
    UnitsDiffer { at: Box<Place>, header: &'static str, row: &'static str },
    #[error("{at}: {value} is beyond ±1, and a full scale is stated for this steering command")]
    #[diagnostic(help(
        "state the unit % where 100 is the full scale, or the angle's unit; state no full scale where 1 is not the full scale"
    ))]
    BeyondFullScale { at: Box<Place>, value: f64 },
    #[error(
        "a unit is stated for `{name}`, which is not a column that is read",
        name = shortened(.column)
    )]
    #[diagnostic(help("spell the name as in the header, or leave its unit out"))]
    UnusedUnit { column: String },
    #[error(
        "{file}: column `{name}` is in {unit}, which is no unit of the {role} (expected {expected})",
        name = shortened(.column)
    )]
    #[diagnostic(help("map another column, or state the unit where the name is misleading"))]
    WrongQuantity {
        file: String,
        column: String,
        role: &'static str,
        unit: &'static str,
        expected: &'static str,
    },
    #[error("{file}: no column is the time; there are: {available}")]
    #[diagnostic(help(
        "name the time column, with its unit in the name (time_s, t_ms, stamp_ns), or state the time between rows"
    ))]
    NoTime { file: String, available: String },
    #[error("{inputs} inputs and {outputs} outputs are named; a model needs 1 to 64 of each")]
    #[diagnostic(help(
        "name the outputs and the inputs that drive them, each channel by its name in the log"
    ))]
    NamedChannels { inputs: usize, outputs: usize },
    #[error("column `{}` is named {roles}", shortened(.column))]
    #[diagnostic(help("name each channel once"))]
    NamedTwice { column: String, roles: &'static str },
    #[error("{at}: time {time} s does not come after {before} s in the row before")]
    #[diagnostic(help(
        "sort the rows by time; where two recordings were joined, use one at a time"
    ))]
    TimeNotIncreasing { at: Box<Place>, time: f64, before: f64 },
    #[error(
        "{file}: column `{name}`: {values} values share {instants} instants: the clock is too coarse",
        name = shortened(.column)
    )]
    #[diagnostic(help(
        "export the time with more digits, or leave its column out and state the time between rows"
    ))]
    CoarseClock { file: String, column: String, values: usize, instants: usize },
    #[error(
        "{at}: nothing from {from_s} s to {} s, a gap of {} s where at most {limit_s} s are bridged",
        short(*.to_s), short(*.gap_s)
    )]
    #[diagnostic(help("the longest part without such a gap, {}s..{}s, is too short to identify from; a larger bound on gaps bridges it by a straight line, which is wrong where the vehicle turned", longest.0, longest.1))]
    Gap { at: Box<Place>, from_s: f64, to_s: f64, gap_s: f64, limit_s: f64, longest: (f64, f64) },
    #[error(
        "which files form one drive? {complete} have steering and yaw rate each, {other} does not"
    )]
    #[diagnostic(help(
        "state which files form one drive, such as {first} and {other}, or leave {other} out"
    ))]
    AmbiguousDrives { complete: String, first: String, other: String },
    #[error("{second} is the same recording as {first}")]
    #[diagnostic(help("name {second} once"))]
    RepeatedDrive { first: String, second: String },
    #[error(
        "the speed stays within {from:.1} to {to:.1} m/s for {kept_s:.1} s only (in segments of {shortest_s:.1} s or more); it goes from {least:.1} to {most:.1} m/s"
    )]
    #[diagnostic(help("half of the time it is between {:.1} and {:.1} m/s: widen the speed window, or leave it out", quartiles.0, quartiles.1))]
    SpeedWindow {
        from: f64,
        to: f64,
        kept_s: f64,
        shortest_s: f64,
        least: f64,
        most: f64,
        quartiles: (f64, f64),
    },
    #[error(
        "the controller is engaged for {kept_s:.1} s only (in segments of {shortest_s:.1} s or more)"
    )]
    #[diagnostic(help(
        "use a log of longer drives with the controller engaged, or check its channel"
    ))]
    NotEngaged { kept_s: f64, shortest_s: f64 },
    #[error("a speed window needs a speed column, and {drive} has none")]
    #[diagnostic(help("name the channel of the speed, or leave the speed window out"))]
    NoSpeedForWindow { drive: String },
    #[error(
        "{file}: column `{name}`: the {role} is {} throughout",
        quantity(*.value, unit), name = shortened(.column)
    )]
    #[diagnostic(help("{}", moving(role)))]
    Constant { file: String, column: String, role: &'static str, value: f64, unit: String },
    #[error(
        "{at}: the {role} would be {} (read as {unit}), beyond {}",
        quantity(*.value, si), quantity(*.limit, si)
    )]
    #[diagnostic(help("{alternatives}"))]
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
        "{file}: column `{name}` is a steering wheel's angle, and no steering ratio is stated",
        name = shortened(.column)
    )]
    #[diagnostic(help(
        "state the steering ratio, the steering angle over the road-wheel angle, such as 15; 1 where the column is the road wheel's"
    ))]
    SteeringRatioUnknown { file: String, column: String },
    #[error(
        "{at}: {largest_deg:.0}° is more than a road wheel can turn, and no steering ratio is stated"
    )]
    #[diagnostic(help(
        "state the steering ratio (about 15 for a car's steering wheel), or the right unit"
    ))]
    NotARoadWheel { at: Box<Place>, largest_deg: f64 },
    #[error(
        "{at}: the vehicle reverses for {reversing_s:.1} s and drives forward for {forward_s:.1} s only"
    )]
    #[diagnostic(help(
        "models are of forward driving: use a log of it; where the vehicle did drive forward, the speed has the other sign: put a - before its column"
    ))]
    Reversing { at: Box<Place>, reversing_s: f64, forward_s: f64 },
    #[error(
        "{file}: column `{name}`: a speed of {mean_mps:.2} m/s on average is a standstill",
        name = shortened(.column)
    )]
    #[diagnostic(help(
        "map the channel of the speed, state its unit, or use the part that is driven; without any speed column the dynamics can be identified, but no position"
    ))]
    Standstill { file: String, column: String, mean_mps: f64 },
    #[error(
        "{file}: column `{name}` has {got} values with a time, a log needs {need} or more",
        name = shortened(.column)
    )]
    #[diagnostic(help(
        "check that the file has rows with a time and a value in this column; a minute of driving or more is needed"
    ))]
    TooFewRows { file: String, column: String, got: usize, need: usize },
    #[error("{file}: more than {limit} rows, which are not read into memory at once")]
    #[diagnostic(help(
        "accumulate the log, which takes memory that does not grow with it, and identify what is accumulated; or use a part of the drive"
    ))]
    TooManyRows { file: String, limit: usize },
    #[error("{got} samples of {} s are too few: {need} are needed", short(*.sample_time_s))]
    #[diagnostic(help(
        "record longer (a minute or more), use a longer part of the log, or a shorter sample time; where the drive was longer, check the unit of the time"
    ))]
    TooFewSamples { got: usize, need: usize, sample_time_s: f64 },
    #[error("{} s by samples of {} s: more than {limit} samples", short(*.duration_s), short(*.sample_time_s))]
    #[diagnostic(help(
        "check the time column and its unit; accumulate the log, use a part of the drive, or a longer sample time"
    ))]
    TooManySamples { duration_s: f64, sample_time_s: f64, limit: usize },
    #[error(
        "the clocks do not overlap: {first} covers {} to {} s, {second} {} to {} s",
        round_ms(*.first_from), round_ms(*.first_to), round_ms(*.second_from), round_ms(*.second_to)
    )]
    #[diagnostic(help(
        "the files must be of one drive and count time from one origin; a window counts from the log's first sample"
    ))]
    NoOverlap {
        first: String,
        first_from: f64,
        first_to: f64,
        second: String,
        second_from: f64,
        second_to: f64,
    },
    #[error("a sample time of {requested} s is shorter than the log's own {} s", short(*.least))]
    #[diagnostic(help("use {} s or more, or leave the sample time out", short(*least)))]
    SampleTimeTooShort { requested: f64, least: f64 },
    #[error("{option}: {value} is out of range, expected {expected}")]
    #[diagnostic(help("use a value that is expected, or omit the option"))]
    Option { option: &'static str, value: String, expected: String },
    #[error("{option}: `{word}` is unknown, expected {expected}")]
    #[diagnostic(help("spell it as expected, or leave it out"))]
    UnknownWord { option: &'static str, word: String, expected: String },
    #[error("channel: `{role}` is not read for the response {response}, expected {used}")]
    #[diagnostic(help("leave it out, or identify the structure that uses this channel"))]
    UnusedRole { role: String, response: &'static str, used: String },
    #[error(
        "steering full scale: it is that of a command in 1 or %, and the steering is in {unit}"
    )]
    #[diagnostic(help("leave the full scale out, or map the channel of the command"))]
    NoCommand { unit: &'static str },
    #[error("{option}: not available where logs are read in pieces")]
    #[diagnostic(help("leave it out, or identify from the log itself"))]
    InPieces { option: &'static str },
    #[error("{file}: the file has no {role}, and each file is read as a drive of its own here")]
    #[diagnostic(help(
        "name the channel; where a drive's channels are in several files, merge them into one, or identify from the files together"
    ))]
    NotADrive { file: String, role: &'static str },
    #[error(
        "{file}:{line}: column `{name}`: the clock's period changes from {} s to {} s",
        short(*.before_s), short(*.period_s), name = shortened(.column)
    )]
    #[diagnostic(help(
        "cut the file where its rate changes and accumulate the parts one by one, with one sample time"
    ))]
    ClockChanged { file: String, line: u64, column: String, before_s: f64, period_s: f64 },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }

    /// The column and its unit as [`LogOptions::units`](crate::LogOptions::units) would state it, where
    /// that is missing.
    #[must_use]
    pub fn suggested_unit(&self) -> Option<(&str, &'static str)> {
        let (column, unit) = match self {
            Self::UnitNotStated { at } => (at.column.as_str(), unit_in_place_of(&at.column).1),
            Self::UnitsDiffer { at, row, .. } => (at.column.as_str(), *row),
            _ => return None,
        };
        // Nobody types a longer name.
        if shortened(column) == column { Some((column, unit)) } else { None }
    }
}

fn name_a_log() -> String {
    format!(
        "name a log: {LOG_FORMATS} with its database; a table has a header line and a row for each sample"
    )
}

const CHANNEL: &str =
    "name the channel, with a leading - (as in -gyro_down_radps) where its sign is opposite";

const BLANKS: &str = "between blanks an empty cell is not seen, and a blank in a name begins the next column: write NaN where a sample is missing and _ in names, or export with commas or tabs between the cells";

/// What to do about a row with other cells than expected.
fn complete_rows(got: usize, expected: usize) -> &'static str {
    if got > expected {
        return "each row needs a cell for each column; where numbers have decimal commas, export them with ; or tabs between the cells, or with decimal points";
    }
    "correct the row, or cut the file before it; each row needs a cell for each column"
}

fn numbers(text: &str) -> &'static str {
    if text.contains(':') {
        return "write times as numbers, or as ISO 8601 does: 2024-03-01T10:00:00.010Z";
    }
    "write numbers; leave a cell blank (or NaN) where a sample is missing"
}

fn state_unit(column: &str) -> String {
    let (suffix, unit) = unit_in_place_of(column);
    let column = shortened(column);
    if suffix.is_empty() {
        return format!(
            "write `{column} [%]`, or `{column} [1]` where it is from 0 to 1, or state the unit of the column"
        );
    }
    let normalised = match unit {
        "deg" => "; a normalised command (−1 to 1) has the unit 1",
        "s" => "; known units of time are s, ms, us, ns, min, h and d",
        _ => "",
    };
    format!(
        "end the column's name in its unit, as in {column}_{suffix}, write `{column} [{unit}]`, or state the unit of the column{normalised}"
    )
}

fn moving(role: &str) -> &'static str {
    if role == "steering" {
        return "nothing can be identified from a steering angle that does not move: check the mapping, or record a slalom";
    }
    if role == "input" || role == "output" {
        return "leave the channel out, or record it while it moves";
    }
    "check the mapping and the sensor"
}

/// How a column that is in several files is named.
fn one_file(column: &str, files: &str) -> String {
    let mut files = files.split(", ");
    let first = files.next().unwrap_or_default();
    let column = shortened(column.rsplit_once(':').map_or(column, |(_, column)| column));
    if files.next() == Some(first) {
        format!("name {first} once")
    } else {
        format!("name the file too, as in {first}:{column}")
    }
}

/// A number for readers: nine digits, with an exponent where it is large or small.
pub(crate) fn short(x: f64) -> String {
    if x == 0.0 || (1e-4..1e7).contains(&x.abs()) {
        let scale = 10f64.powi(8 - x.abs().max(1e-4).log10().floor() as i32);
        ((x * scale).round() / scale).to_string()
    } else {
        format!("{x:.3e}")
    }
}

/// A number with its unit, where it has one.
fn quantity(value: f64, unit: &str) -> String {
    if unit == "1" { short(value) } else { format!("{} {unit}", short(value)) }
}

/// The start of a text of a file, such as a cell or a name, in one line, as messages quote it.
pub(crate) fn shortened(text: &str) -> String {
    const MOST: usize = 80;
    let start: String = text.chars().take(MOST).collect();
    let is_whole = start.len() == text.len();
    in_one_line(&start).into_owned() + if is_whole { "" } else { "…" }
}

/// The text with a blank in place of each end of a line.
pub(crate) fn in_one_line(text: &str) -> Cow<'_, str> {
    if !text.contains(['\r', '\n']) {
        return text.into();
    }
    let lines = text.split(['\r', '\n']).map(str::trim).filter(|line| !line.is_empty());
    lines.collect::<Vec<_>>().join(" ").into()
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
