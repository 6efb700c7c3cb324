//! MDF of ASAM: CANape, INCA, vMeasure and data loggers. Read by `falcon_mdf`.
//!
//! A group is a channel group. Times are those of the master channel, s from the start of the measurement.
//! Raw CAN frames of a bus log are decoded by the databases.

mod frames;
mod source;
mod values;
mod version3;

use super::bytes::{Head, LogFile};
use super::can::Decoder;
use super::{Batches, Channel, Columns, Group, Pieces, Recording, Request, Rows, contained};
use crate::Error;
use crate::error::shortened;
use crate::options::LogOptions;
use falcon_mdf::error::Mf4Error;
use falcon_mdf::model::{Signal, ValueKind};
use falcon_mdf::stream::SignalsChunks;
use falcon_mdf::{ChannelGroup, Mf4File};
use frames::{Fields, bus, scan};
use source::Source;
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;
use std::sync::{Arc, OnceLock};
use values::{damaged, numbers, place, readable};

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
    let source = Source { bytes, size, cut: Arc::new(OnceLock::new()) };
    // The version, as text: `4.10`, `3.30`.
    if file.head()?.get(8).is_some_and(|digit| (b'0'..b'4').contains(digit)) {
        return version3::open(&file, source);
    }
    let cut = Arc::clone(&source.cut);
    let mdf = contained(|| Mf4File::from_source(Arc::new(source))).unwrap_or_else(damaged);
    let mdf = mdf.map_err(|e| failed(place(&e), e.to_string()))?;
    let (mut groups, mut parts, mut losses) = (Vec::new(), Vec::new(), Vec::new());
    let mut buses = Vec::new();
    for (d, data) in mdf.data_groups().iter().enumerate() {
        for (c, own) in data.channel_groups.iter().enumerate() {
            if own.is_vlsd() {
                continue;
            }
            if Fields::from_group(own).is_some() {
                buses.push((d, c));
                continue;
            }
            let (group, channels) = plain(&file.name, own, &groups);
            losses.extend(unread(&group, own, &channels));
            if channels.len() > usize::from(group.clock.is_some()) {
                groups.push(group);
                parts.push(MdfGroup::Plain { data: d, group: c, channels });
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
        parts.extend((0..decoded.len()).map(MdfGroup::Decoded));
        groups.extend(decoded);
        losses.extend(decoder.losses(&file.name));
    }
    if groups.is_empty() {
        let problem = losses.first().cloned().unwrap_or_else(|| "no channel has numbers".into());
        return Err(failed(0, problem));
    }
    Ok(Box::new(Mdf { name: file.name, mdf, groups, parts, buses, decoder, losses, cut }))
}

struct Mdf {
    name: String,
    mdf: Mf4File,
    groups: Vec<Group>,
    /// What each group is in the file.
    parts: Vec<MdfGroup>,
    /// Data group and channel group of CAN frames.
    buses: Vec<(usize, usize)>,
    decoder: Decoder,
    losses: Vec<String>,
    /// The block that the file ends in.
    cut: Arc<OnceLock<u64>>,
}

enum MdfGroup {
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

/// Why channels of a group are not read.
fn unread(group: &Group, own: &ChannelGroup, read: &[usize]) -> Vec<String> {
    let others = own.channels.iter().enumerate().filter(|(k, _)| !read.contains(k));
    let lines = others.map(|(_, channel)| {
        let why = match (channel.array_shape.as_deref(), channel.unreadable()) {
            (Some(shape), _) => {
                let sizes: Vec<String> = shape.iter().map(u64::to_string).collect();
                format!("an array of {} values", sizes.join(" x "))
            }
            (None, Some(reason)) => reason.detail().to_owned(),
            (None, None) => "no number".into(),
        };
        format!("{}: channel `{}` is not read: {why}", group.place(), shortened(&channel.name))
    });
    lines.collect()
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
            let MdfGroup::Plain { data, group, channels } = &parts[wanted.group] else {
                reads_buses = true;
                continue;
            };
            let all = &mdf.data_groups()[*data].channel_groups[*group].channels;
            let own: Vec<&falcon_mdf::Channel> =
                wanted.channels.iter().map(|&c| &all[channels[c]]).collect();
            let as_read: Vec<falcon_mdf::Channel> = own.iter().map(|c| readable(c)).collect();
            match mdf.signals_chunks(&as_read, request.most) {
                Ok(chunks) => sources.push(MdfSource::new(MdfSourceKind::Plain(w, own), chunks)),
                Err(error) => lost(&error, "a channel group is not read"),
            }
        }
        for &(d, c) in buses.iter().filter(|_| reads_buses) {
            match bus(mdf, d, c, true, request.most) {
                Ok((fields, chunks)) => {
                    sources.push(MdfSource::new(MdfSourceKind::Bus(fields), chunks))
                }
                Err(error) => lost(&error, "CAN frames are not read"),
            }
        }
        let of_wanted: BTreeMap<usize, usize> = request
            .wanted
            .iter()
            .enumerate()
            .filter_map(|(w, wanted)| match parts[wanted.group] {
                MdfGroup::Decoded(group) => Some((group, w)),
                MdfGroup::Plain { .. } => None,
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
                    MdfSourceKind::Plain(w, channels) => {
                        let all = channels.iter().zip(&signals);
                        let values: Vec<Vec<f64>> = all.map(|(c, s)| numbers(c, s)).collect();
                        if let Some(t) = values.first().and_then(|v| v.last()) {
                            reading.time = *t;
                        }
                        let from = reading.rows as u64;
                        let lines = Rc::new((from + 1..=from + count as u64).collect());
                        ready.push_back(Rows { wanted: *w, columns: Columns { values, lines } });
                    }
                    MdfSourceKind::Bus(fields) => {
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
        let cut = self.cut.get().map(|byte| {
            format!("{}: the file ends within the block of samples at byte {byte}: what is there is read", self.name)
        });
        self.losses.iter().cloned().chain(cut).collect()
    }
}

struct MdfSource<'m> {
    kind: MdfSourceKind<'m>,
    chunks: SignalsChunks<'m>,
    rows: usize,
    /// Its last instant, s.
    time: f64,
}

enum MdfSourceKind<'m> {
    /// One of the wanted groups, and its channels.
    Plain(usize, Vec<&'m falcon_mdf::Channel>),
    Bus(Fields),
}

impl<'m> MdfSource<'m> {
    fn new(kind: MdfSourceKind<'m>, chunks: SignalsChunks<'m>) -> Self {
        Self { kind, chunks, rows: 0, time: f64::NEG_INFINITY }
    }
}
