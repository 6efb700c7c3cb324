//! Log files of any format as channels in groups, each group with one clock.
//!
//! [`open`] recognises the format by the file's first bytes. A format is a file of this folder that
//! implements [`Recording`], and a line in [`FORMATS`].

mod arrow;
mod base64;
mod bytes;
mod can;
mod compression;
mod csv;
mod damaged;
mod foreign;
mod half;
mod mcap;
mod mdf;
mod memory;
mod parquet;
mod read_at;
mod ros;
mod scale;

pub use bytes::LogFile;
pub use csv::stamps::Dates;
pub use memory::in_memory;
pub use read_at::ReadAt;

use crate::Error;
use crate::error::{Place, in_one_line, last_part, shortened};
use crate::names::Name;
use crate::options::LogOptions;
use crate::role::Role;
use crate::units::split_brackets;
use bytes::Head;
use std::rc::Rc;

/// A log file of one format.
pub trait Recording {
    /// The groups, in the order of the file.
    fn groups(&self) -> &[Group];

    /// Reads channels piece by piece, in memory that does not grow with the file.
    ///
    /// Rows of a group come in their order; groups advance together, so that none is far behind. A stream
    /// is read once.
    ///
    /// # Errors
    /// [`Error`] with the file and the place in it; a piece may be one, too, and is then the last.
    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error>;

    /// The first instant of the clock of a group, s, where it is known without reading the rows.
    fn first_s(&self, wanted: &Wanted) -> Option<f64> {
        self.groups().get(wanted.group)?.span_s.map(|(first, _)| first)
    }

    /// Reads a cell of the first group that is no number as a missing value, which is an error by default: any of the
    /// `optional` channels, none of the `clock`, and of each other channel one in a hundred rows.
    fn tolerate(&mut self, _clock: Option<usize>, _optional: Vec<usize>) {}

    /// What could not be read, after [`Self::rows`]: what it is and at which byte.
    fn losses(&self) -> Vec<String> {
        Vec::new()
    }

    /// The dates of a clock of the first group, where they are texts, after [`Self::rows`].
    fn dates(&self, _clock: usize) -> Option<Dates> {
        None
    }

    /// Whether all of the file is read, and hashed on the way.
    fn hashes_bytes(&self) -> bool {
        false
    }

    /// SHA-256 of the file, if all of it has been read.
    fn sha256(&mut self) -> Option<String> {
        None
    }
}

/// Pieces of the rows of a log.
pub type Pieces<'r> = Box<dyn Iterator<Item = Result<Rows, Error>> + 'r>;

/// What is to be read.
#[derive(Debug, Clone, Copy)]
pub struct Request<'r> {
    /// The channels, each group once.
    pub wanted: &'r [Wanted],
    /// First and last time, s on the clocks of the groups: rows outside may be left out.
    pub window_s: Option<(f64, f64)>,
    /// Most rows of a piece.
    pub most: usize,
}

/// Channels to be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wanted {
    /// The group.
    pub group: usize,
    /// Its channels.
    pub channels: Vec<usize>,
}

/// Successive rows of a group.
#[derive(Debug, Clone)]
pub struct Rows {
    /// Which of the [`Wanted`].
    pub wanted: usize,
    /// The values.
    pub columns: Columns,
}

/// Values as written in the log, in the order of [`Wanted::channels`]; a missing one is NaN.
#[derive(Debug, Clone, Default)]
pub struct Columns {
    /// Values of each channel.
    pub values: Vec<Vec<f64>>,
    /// Line of each row in a text; else the number of the row in its group, from 1.
    pub lines: Rc<Vec<u64>>,
}

/// Rows of several groups as they follow each other in a file, in pieces.
pub(crate) struct Batches {
    columns: Vec<Columns>,
    most: usize,
}

impl Batches {
    pub(crate) fn new(request: &Request<'_>) -> Self {
        let empty = |wanted: &Wanted| Columns {
            values: vec![Vec::new(); wanted.channels.len()],
            lines: Rc::default(),
        };
        Self { columns: request.wanted.iter().map(empty).collect(), most: request.most }
    }

    /// Adds a row of a group: its line or number, and its values in the order of [`Wanted::channels`].
    pub(crate) fn push(&mut self, wanted: usize, line: u64, row: impl IntoIterator<Item = f64>) {
        let columns = &mut self.columns[wanted];
        columns.values.iter_mut().zip(row).for_each(|(values, x)| values.push(x));
        Rc::make_mut(&mut columns.lines).push(line);
    }

    /// Whether a group has as many rows as a piece may have.
    pub(crate) fn is_full(&self) -> bool {
        self.columns.iter().any(|columns| columns.lines.len() >= self.most)
    }

    /// Takes the rows of all groups, so that none is behind.
    pub(crate) fn drain(&mut self) -> Vec<Rows> {
        let all = self.columns.iter_mut().enumerate().filter(|(_, c)| !c.lines.is_empty());
        all.map(|(wanted, columns)| {
            let values = columns.values.iter_mut().map(std::mem::take).collect();
            let lines = std::mem::take(&mut columns.lines);
            Rows { wanted, columns: Columns { values, lines } }
        })
        .collect()
    }
}

impl Columns {
    pub(crate) fn and(mut self, later: Self) -> Self {
        if self.lines.is_empty() {
            return later;
        }
        self.append(later);
        self
    }

    pub(crate) fn append(&mut self, later: Self) {
        self.values.resize(later.values.len().max(self.values.len()), Vec::new());
        self.values.iter_mut().zip(later.values).for_each(|(all, mut new)| all.append(&mut new));
        Rc::make_mut(&mut self.lines).extend_from_slice(&later.lines);
    }

    pub(crate) fn split_off(&mut self, row: usize) -> Self {
        let values = self.values.iter_mut().map(|values| values.split_off(row)).collect();
        Self { values, lines: Rc::new(Rc::make_mut(&mut self.lines).split_off(row)) }
    }
}

/// Channels on one clock: a table, a topic, a message of a bus, a channel group.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The file as the caller names it.
    pub file: String,
    /// Its name within the file; empty where the file is one group.
    pub name: String,
    /// Its kind as the file states it, such as the type of a message; empty where there is none.
    pub kind: String,
    /// The channels.
    pub channels: Vec<Channel>,
    /// The channel that is the clock; `None` where its name decides.
    pub clock: Option<usize>,
    /// Number of rows, where it is known without reading them.
    pub rows: Option<u64>,
    /// First and last time, s, where they are known without reading the rows.
    pub span_s: Option<(f64, f64)>,
    /// Line of the header of a text.
    pub(crate) header_line: u64,
}

/// A channel of a group.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name in the file, of a message's field the path to it.
    pub name: String,
    /// Its unit as the file states it apart from the name.
    pub unit: Option<String>,
    /// Whether the file states apart from the name that it has no unit: `-`.
    pub(crate) is_without_unit: bool,
    /// What it represents, where the format or the type of the message defines it.
    pub(crate) role: Option<Role>,
    /// Whether its name decides what it represents, where nothing else does.
    pub(crate) has_role_by_name: bool,
    /// Whether its values are times as ISO 8601 writes them, which are read as seconds.
    pub(crate) has_stamps: bool,
    /// Whether its values are texts, and so are not read.
    pub(crate) is_text: bool,
    /// The first value that is neither a number nor a time, of a channel of which most are so, and its line.
    pub(crate) unread: Option<(u64, String)>,
}

impl Channel {
    pub(crate) fn new(name: &str, unit: Option<&str>) -> Self {
        let unit = unit.map(str::trim).filter(|unit| !unit.is_empty());
        let is_without_unit = unit == Some("-");
        Self {
            name: name.into(),
            unit: unit.filter(|_| !is_without_unit).map(Into::into),
            is_without_unit,
            role: None,
            has_role_by_name: true,
            has_stamps: false,
            is_text: false,
            unread: None,
        }
    }

    /// Whether it may be taken for the role where none is stated.
    pub(crate) fn may_be(&self, role: Role) -> bool {
        self.is_like(role, &Name::new(&self.name))
    }

    /// The roles that it may be taken for.
    pub(crate) fn roles(&self) -> impl Iterator<Item = Role> {
        let name = Name::new(&self.name);
        Role::OF_CHANNELS.into_iter().filter(move |role| self.is_like(*role, &name))
    }

    fn is_like(&self, role: Role, name: &Name<'_>) -> bool {
        !self.is_text && self.is_named(role, name)
    }

    /// Whether it is named like the role, whatever its values are.
    pub(crate) fn is_named_like(&self, role: Role) -> bool {
        self.is_named(role, &Name::new(&self.name))
    }

    fn is_named(&self, role: Role, name: &Name<'_>) -> bool {
        match self.role {
            Some(own) => own == role,
            None => self.has_role_by_name && role.is_of(name),
        }
    }
}

impl Group {
    pub(crate) fn new(file: &str, name: &str, channels: Vec<Channel>) -> Self {
        Self {
            file: file.into(),
            name: name.into(),
            kind: String::new(),
            channels,
            clock: None,
            rows: None,
            span_s: None,
            header_line: 0,
        }
    }

    /// The group in messages: the file, and of a file with several groups which of them.
    pub(crate) fn place(&self) -> String {
        if self.name.is_empty() {
            self.file.clone()
        } else {
            format!("{}:{}", self.file, self.name)
        }
    }

    /// One of its channels in messages.
    pub(crate) fn label(&self, channel: &str) -> String {
        if self.name.is_empty() { channel.into() } else { format!("{}.{channel}", self.name) }
    }

    pub(crate) fn names(&self) -> String {
        let names: Vec<String> = self.channels.iter().map(|c| shortened(&c.name)).collect();
        names.join(", ")
    }

    /// Whether several channels have the name of that one.
    pub(crate) fn is_repeated(&self, channel: usize) -> bool {
        let name = &self.channels[channel].name;
        self.channels.iter().filter(|own| own.name == *name).count() > 1
    }

    /// The error of a clock whose values are texts in a form that is not read.
    pub(crate) fn unread_time(&self, channel: usize) -> Option<Error> {
        let (line, text) = self.channels[channel].unread.as_ref()?;
        let at = Place::new(&self.place(), *line, &self.channels[channel].name);
        Some(Error::UnreadTime { at, text: shortened(text) })
    }

    pub(crate) fn repeated(&self, channel: usize) -> Error {
        Error::RepeatedColumn {
            file: self.place(),
            line: self.header_line,
            column: self.channels[channel].name.clone(),
        }
    }

    /// The channel of that name: with or without its unit in brackets, in one line, and with the group before it.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        let names = || self.channels.iter().map(|c| c.name.as_str());
        let found = names()
            .position(|own| own == name)
            .or_else(|| names().position(|own| is_short(own, name)));
        if found.is_some() || self.name.is_empty() {
            return found;
        }
        // `/imu/data/angular_velocity/z` is `angular_velocity.z` of `/imu/data`.
        let plain = |text: &str| text.trim_start_matches('/').replace(['/', ':'], ".");
        let (group, name) = (plain(&self.name), plain(name));
        let rest = name.strip_prefix(&group)?.strip_prefix('.')?;
        names()
            .position(|own| plain(own) == rest)
            .or_else(|| names().position(|own| plain(split_brackets(own).0) == rest))
    }

    /// Whether `name` is that of the file, of the group, or of both.
    pub(crate) fn is_called(&self, name: &str) -> bool {
        let file = [self.file.as_str(), last_part(&self.file)];
        file.contains(&name) || !self.name.is_empty() && (self.name == name || self.place() == name)
    }
}

/// Whether the name is another one in one line, with or without its unit in brackets.
fn is_short(own: &str, name: &str) -> bool {
    let own = in_one_line(own);
    own == name || split_brackets(&own).0 == name
}

type Opened<'a> = Result<Box<dyn Recording + 'a>, Error>;

/// A name without the marks of the comment that it stands in, in the header of a file; `None` of one without.
pub(crate) fn uncommented(name: &str) -> Option<&str> {
    let name = name.trim_start();
    let bare = name.trim_start_matches(['#', '%', '/']).trim_start();
    if bare.is_empty() || bare.len() == name.len() { None } else { Some(bare) }
}

/// A format of log files.
struct Format {
    /// Whether it is read at several places.
    is_sought: bool,
    recognises: fn(&Head<'_>) -> bool,
    open: for<'a> fn(LogFile<'a>, &LogOptions) -> Opened<'a>,
}

/// The formats; a text that no other one recognises is CSV.
const FORMATS: &[Format] = &[
    Format { is_sought: true, recognises: mdf::recognises, open: mdf::open },
    Format { is_sought: true, recognises: parquet::recognises, open: parquet::open },
    Format { is_sought: true, recognises: arrow::recognises, open: arrow::open },
    Format { is_sought: true, recognises: mcap::recognises, open: mcap::open },
    Format { is_sought: false, recognises: foreign::recognises, open: foreign::open },
    Format { is_sought: false, recognises: can::recognises, open: can::open },
    Format { is_sought: false, recognises: |_| true, open: csv::open },
];

/// Opens a log: recognises its format and lists its channels.
///
/// # Errors
/// [`Error`] where the format is none of those known, or the file's head or index is damaged.
pub fn open<'a>(
    mut file: LogFile<'a>,
    options: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    file.look()?;
    let start = file.head()?;
    let head = Head { start: &start };
    let format = FORMATS.iter().find(|format| (format.recognises)(&head));
    let Some(format) = format else { return Err(Error::EmptyFile { file: file.name }) };
    let damage = if format.is_sought { file.unpack()? } else { None };
    let name = file.name.clone();
    let opened = (format.open)(file, options);
    let Some((byte, problem)) = damage else { return opened };
    let damage = Error::Read { file: name, byte, problem: format!("decompressed: {problem}") };
    match opened {
        Ok(recording) => Ok(Box::new(damaged::Damaged { recording, damage })),
        // A format with its index at the end.
        Err(_) => Err(damage),
    }
}

/// Calls a library that may panic on damaged bytes; `None` where it did.
fn contained<T>(call: impl FnOnce() -> T) -> Option<T> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(call)).ok()
}

/// The last part of a path, as it is stored in provenance.
pub(crate) fn file_name(path: &str) -> String {
    let name = std::path::Path::new(path).file_name();
    name.map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}
