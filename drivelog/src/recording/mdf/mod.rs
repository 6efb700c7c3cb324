//! MDF of ASAM: CANape, INCA, vMeasure and data loggers. Read by `falcon_mdf`.
//!
//! A group is a channel group. Times are those of the master channel, s from the start of the measurement.
//! Raw CAN frames of a bus log are decoded by the databases.

mod version3;

use super::bytes::{Head, LogFile, ReadAt};
use super::can::{Decoder, Identifier, Seen};
use super::{Batches, Channel, Columns, Group, Pieces, Recording, Request, Rows, contained};
use crate::Error;
use crate::options::LogOptions;
use falcon_mdf::error::Mf4Error;
use falcon_mdf::io::{ByteSlice, ByteSource};
use falcon_mdf::model::{Signal, SignalValues, ValueKind};
use falcon_mdf::stream::SignalsChunks;
use falcon_mdf::{ChannelGroup, Mf4File};
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;
use std::sync::Arc;

pub(super) fn recognises(head: &Head<'_>) -> bool {
    head.start.starts_with(b"MDF     ") || head.start.starts_with(b"UnFinMF ")
}

/// Opens a measurement; reads its blocks but the samples, and of a bus log the identifiers.
pub(super) fn open<'a>(
    file: LogFile<'a>,
    options: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    let bytes = file.sought()?;
    let failed = |byte, problem: String| Error::Read { file: file.name.clone(), byte, problem };
    let size = bytes.size().map_err(|e| failed(0, e.to_string()))?;
    let source = Source { bytes, size };
    // The version, as text: `4.10`, `3.30`.
    if file.head()?.get(8).is_some_and(|digit| (b'0'..b'4').contains(digit)) {
        return version3::open(&file, source);
    }
    let mdf = contained(|| Mf4File::from_source(Arc::new(source))).unwrap_or_else(damaged);
    let mdf = mdf.map_err(|e| failed(place(&e), e.to_string()))?;
    let (mut groups, mut parts, mut losses) = (Vec::new(), Vec::new(), Vec::new());
    let mut buses = Vec::new();
    for (d, data) in mdf.data_groups().iter().enumerate() {
        for (c, own) in data.channel_groups.iter().enumerate() {
            if own.is_vlsd() {
                continue;
            }
            if Fields::of(own).is_some() {
                buses.push((d, c));
                continue;
            }
            let (group, channels) = plain(&file.name, own, &groups);
            if channels.len() > usize::from(group.clock.is_some()) {
                groups.push(group);
                parts.push(Part::Plain { data: d, group: c, channels });
            }
        }
    }
    let mut decoder = Decoder::new(options);
    if options.dbc.is_empty() {
        if !buses.is_empty() {
            let count = buses.len();
            losses.push(format!(
                "{}: {count} groups of CAN frames, which a database decodes",
                file.name
            ));
        }
    } else {
        let mut seen = BTreeMap::new();
        for &(d, c) in &buses {
            losses.extend(scan(&mdf, d, c, &mut seen).err().map(|e| format!("{}: {e}", file.name)));
        }
        let decoded = decoder.groups(&file.name, &seen);
        parts.extend((0..decoded.len()).map(Part::Decoded));
        groups.extend(decoded);
        losses.extend(decoder.losses(&file.name));
    }
    if groups.is_empty() {
        let problem = losses.first().cloned().unwrap_or_else(|| "no channel has numbers".into());
        return Err(failed(0, problem));
    }
    Ok(Box::new(Mdf { name: file.name, mdf, groups, parts, buses, decoder, losses }))
}

struct Mdf {
    name: String,
    mdf: Mf4File,
    groups: Vec<Group>,
    /// What each group is in the file.
    parts: Vec<Part>,
    /// Data group and channel group of CAN frames.
    buses: Vec<(usize, usize)>,
    decoder: Decoder,
    losses: Vec<String>,
}

enum Part {
    Plain {
        data: usize,
        group: usize,
        channels: Vec<usize>,
    },
    /// A message of the decoder.
    Decoded(usize),
}

/// A channel group with its numeric channels, and their places in it.
fn plain(file: &str, own: &ChannelGroup, others: &[Group]) -> (Group, Vec<usize>) {
    let is_number = |c: &falcon_mdf::Channel| {
        let numeric =
            !matches!(c.raw_value_kind(), ValueKind::Str | ValueKind::Bytes | ValueKind::Complex);
        numeric && c.is_numeric() && c.unreadable().is_none() && !c.is_array()
    };
    let places: Vec<usize> = (0..own.channels.len())
        .filter(|&k| is_number(&own.channels[k]) || own.channels[k].is_time_channel())
        .collect();
    let channels = places.iter().map(|&k| {
        let channel = &own.channels[k];
        let is_time = channel.is_time_channel();
        Channel::new(&channel.name, Some(if is_time { "s" } else { &channel.unit }))
    });
    let name = match own.acquisition_name.trim() {
        "" => format!("group {}", others.len() + 1),
        name if others.iter().any(|g| g.name == name) => format!("{name} {}", others.len() + 1),
        name => name.to_owned(),
    };
    let mut group = Group::new(file, &name, channels.collect());
    group.clock = places.iter().position(|&k| own.channels[k].is_time_channel());
    group.rows = Some(own.sample_count);
    (group, places)
}

impl Recording for Mdf {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let Self { name, mdf, parts, buses, decoder, losses, .. } = self;
        let mut sources = Vec::new();
        let mut lost = |error: &Mf4Error, what: &str| {
            losses.push(format!("{name}: {what}: byte {}: {error}", place(error)));
        };
        let mut reads_buses = false;
        for (w, wanted) in request.wanted.iter().enumerate() {
            let Part::Plain { data, group, channels } = &parts[wanted.group] else {
                reads_buses = true;
                continue;
            };
            let all = &mdf.data_groups()[*data].channel_groups[*group].channels;
            let own: Vec<&falcon_mdf::Channel> =
                wanted.channels.iter().map(|&c| &all[channels[c]]).collect();
            match mdf.signals_chunks(&own, request.most) {
                Ok(chunks) => sources.push(Reading::new(Kind::Plain(w), chunks)),
                Err(error) => lost(&error, "a channel group is not read"),
            }
        }
        for &(d, c) in buses.iter().filter(|_| reads_buses) {
            match bus(mdf, d, c, true, request.most) {
                Ok((fields, chunks)) => sources.push(Reading::new(Kind::Bus(fields), chunks)),
                Err(error) => lost(&error, "CAN frames are not read"),
            }
        }
        let of_wanted: BTreeMap<usize, usize> = request
            .wanted
            .iter()
            .enumerate()
            .filter_map(|(w, wanted)| match parts[wanted.group] {
                Part::Decoded(group) => Some((group, w)),
                Part::Plain { .. } => None,
            })
            .collect();
        let mut batches = Batches::new(&request);
        let mut rows = vec![0; request.wanted.len()];
        let mut ready: VecDeque<Rows> = VecDeque::new();
        Ok(Box::new(std::iter::from_fn(move || {
            while ready.is_empty() {
                // The one that is behind goes on.
                let behind =
                    sources.iter_mut().enumerate().min_by(|a, b| a.1.time.total_cmp(&b.1.time));
                let Some((k, reading)) = behind else {
                    ready.extend(batches.drain());
                    break;
                };
                let next = contained(|| reading.chunks.next()).unwrap_or_else(|| Some(damaged()));
                let signals = match next {
                    Some(Ok(signals)) => signals,
                    Some(Err(error)) => {
                        losses.push(format!(
                            "{name}: nothing more of a channel group after row {}: byte {}: {error}",
                            reading.rows,
                            place(&error)
                        ));
                        sources.swap_remove(k);
                        continue;
                    }
                    None => {
                        sources.swap_remove(k);
                        continue;
                    }
                };
                let count = signals.first().map_or(0, Signal::len);
                match &reading.kind {
                    Kind::Plain(w) => {
                        let values: Vec<Vec<f64>> = signals.iter().map(numbers).collect();
                        if let Some(t) = values.first().and_then(|v| v.last()) {
                            reading.time = *t;
                        }
                        let from = reading.rows as u64;
                        let lines = Rc::new((from + 1..=from + count as u64).collect());
                        ready.push_back(Rows { wanted: *w, columns: Columns { values, lines } });
                    }
                    Kind::Bus(fields) => {
                        let frames = fields.frames(&signals);
                        frames.each(count, |identifier, time, data| {
                            for group in decoder.of_frame(&identifier) {
                                let Some(&w) = of_wanted.get(group) else { continue };
                                let channels = &request.wanted[w].channels;
                                let values = decoder.values(*group, channels, time, data);
                                let Some(values) = values else { continue };
                                rows[w] += 1;
                                batches.push(w, rows[w], values);
                            }
                            reading.time = time;
                        });
                        if batches.is_full() {
                            ready.extend(batches.drain());
                        }
                    }
                }
                reading.rows += count;
            }
            ready.pop_front().map(Ok)
        })))
    }

    fn losses(&self) -> Vec<String> {
        self.losses.clone()
    }
}

struct Reading<'m> {
    kind: Kind,
    chunks: SignalsChunks<'m>,
    rows: usize,
    /// Its last instant, s.
    time: f64,
}

enum Kind {
    /// Channels of one of the wanted groups.
    Plain(usize),
    Bus(Fields),
}

impl<'m> Reading<'m> {
    fn new(kind: Kind, chunks: SignalsChunks<'m>) -> Self {
        Self { kind, chunks, rows: 0, time: f64::NEG_INFINITY }
    }
}

/// Physical values; invalid ones are missing, and of a number with a text the number.
fn numbers(signal: &Signal) -> Vec<f64> {
    let values = match signal.channel().value_kind() {
        ValueKind::Str => signal.raw_values(),
        _ => signal.values(),
    };
    let mut values = values.map_or_else(|_| Vec::new(), |values| values.to_f64());
    values.resize(signal.len(), f64::NAN);
    if let Some(valid) = signal.validity() {
        values.iter_mut().zip(valid).filter(|(_, is)| !is).for_each(|(x, _)| *x = f64::NAN);
    }
    values
}

fn damaged<T>() -> Result<T, Mf4Error> {
    Err(Mf4Error::parse_error("the bytes are damaged"))
}

/// The byte that an error names.
fn place(error: &Mf4Error) -> u64 {
    match error {
        Mf4Error::TruncatedFile { offset, .. }
        | Mf4Error::MissingBlock { offset, .. }
        | Mf4Error::InvalidBlockId { offset, .. } => *offset,
        _ => 0,
    }
}

/// Places of the parts of a CAN frame among the channels that are read.
struct Fields {
    names: Vec<usize>,
    time: usize,
    id: usize,
    is_extended: Option<usize>,
    bus: Option<usize>,
    length: Option<usize>,
    data: Option<usize>,
}

impl Fields {
    /// The parts of the frames of a group; `None` where it has none.
    fn of(group: &ChannelGroup) -> Option<Self> {
        let find = |name: &str| {
            let name = format!("CAN_DataFrame.{name}");
            group.channels.iter().position(|c| c.name == name)
        };
        let time = group.channels.iter().position(falcon_mdf::Channel::is_time_channel)?;
        let (id, data) = (find("ID")?, find("DataBytes")?);
        let optional = [find("IDE"), find("BusChannel"), find("DataLength"), Some(data)];
        let mut names = vec![time, id];
        let mut place = |k: Option<usize>| {
            names.extend(k);
            k.map(|_| names.len() - 1)
        };
        let [is_extended, bus, length, data] = optional.map(&mut place);
        Some(Self { names, time: 0, id: 1, is_extended, bus, length, data })
    }

    fn frames<'s>(&self, signals: &'s [Signal]) -> FrameColumns {
        let column = |k: Option<usize>| k.map(|k| numbers(&signals[k]));
        let _: &'s [Signal] = signals;
        FrameColumns {
            time: numbers(&signals[self.time]),
            id: numbers(&signals[self.id]),
            is_extended: column(self.is_extended),
            bus: column(self.bus),
            length: column(self.length),
            data: self.data.and_then(|k| signals.get(k)).and_then(|s| s.values().ok()),
        }
    }
}

struct FrameColumns {
    time: Vec<f64>,
    id: Vec<f64>,
    is_extended: Option<Vec<f64>>,
    bus: Option<Vec<f64>>,
    length: Option<Vec<f64>>,
    data: Option<SignalValues>,
}

impl FrameColumns {
    fn each(&self, count: usize, mut take: impl FnMut(Identifier, f64, &[u8])) {
        for k in 0..count {
            let raw = self.id[k] as u32;
            let is_extended = match &self.is_extended {
                Some(flags) => flags[k] != 0.0,
                None => raw & 0x8000_0000 != 0 || raw & 0x1FFF_FFFF > 0x7FF,
            };
            let bus = self.bus.as_ref().map_or(0.0, |bus| bus[k]);
            let data = self.data.as_ref().and_then(|data| data.bytes_at(k)).unwrap_or_default();
            let length = self.length.as_ref().map_or(data.len(), |length| length[k] as usize);
            let data = &data[..length.min(data.len())];
            let id = raw & 0x1FFF_FFFF;
            take(Identifier { bus: format!("CAN{bus}"), id, is_extended }, self.time[k], data);
        }
    }
}

/// The parts of the frames of a group, with or without the data.
fn bus(
    mdf: &Mf4File,
    data: usize,
    group: usize,
    with_data: bool,
    most: usize,
) -> Result<(Fields, SignalsChunks<'_>), Mf4Error> {
    let own = &mdf.data_groups()[data].channel_groups[group];
    let none = || Mf4Error::parse_error("no CAN frames");
    let mut fields = Fields::of(own).ok_or_else(none)?;
    if !with_data {
        fields.names.pop();
        fields.data = None;
    }
    let channels: Vec<&falcon_mdf::Channel> =
        fields.names.iter().map(|&k| &own.channels[k]).collect();
    let chunks = mdf.signals_chunks(&channels, most)?;
    Ok((fields, chunks))
}

/// Counts the kinds of frames of a group.
fn scan(
    mdf: &Mf4File,
    data: usize,
    group: usize,
    seen: &mut BTreeMap<Identifier, Seen>,
) -> Result<(), Mf4Error> {
    let (fields, chunks) = bus(mdf, data, group, false, 1 << 14)?;
    for signals in chunks {
        let signals = signals?;
        let count = signals.first().map_or(0, Signal::len);
        fields
            .frames(&signals)
            .each(count, |identifier, time, _| Seen::note(seen, identifier, time));
    }
    Ok(())
}

/// Our bytes as the library reads them.
struct Source {
    bytes: Arc<dyn ReadAt>,
    size: u64,
}

impl ByteSource for Source {
    fn len(&self) -> u64 {
        self.size
    }

    fn read_bytes(&self, offset: u64, len: usize) -> Result<ByteSlice<'_>, Mf4Error> {
        let left = usize::try_from(self.size.saturating_sub(offset)).unwrap_or(usize::MAX);
        if len > left {
            return Err(Mf4Error::truncated(offset, len, left));
        }
        let mut buffer = vec![0; len];
        let mut at = 0;
        while at < len {
            match self.bytes.read_at(&mut buffer[at..], offset + at as u64)? {
                0 => return Err(Mf4Error::truncated(offset, len, at)),
                count => at += count,
            }
        }
        Ok(ByteSlice::owned(buffer))
    }
}
