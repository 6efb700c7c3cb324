//! Frames → signals: which groups a bus has, and the values of a frame.

use super::asc::Names;
use super::dbc::{Condition, Database, Message};
use crate::options::LogOptions;
use crate::recording::{Channel, Group};
use std::collections::BTreeMap;

/// A kind of frame on a bus.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::recording) struct Identifier {
    pub(in crate::recording) bus: String,
    pub(in crate::recording) id: u32,
    pub(in crate::recording) is_extended: bool,
}

/// How often a kind of frame is in a log, and from when to when, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::recording) struct Seen {
    pub(in crate::recording) frames: u64,
    pub(in crate::recording) span_s: (f64, f64),
}

impl Seen {
    /// Counts a frame.
    pub(in crate::recording) fn note(
        seen: &mut BTreeMap<Identifier, Self>,
        id: Identifier,
        time: f64,
    ) {
        let new = Self { frames: 0, span_s: (time, time) };
        let own = seen.entry(id).or_insert(new);
        own.frames += 1;
        own.span_s = (own.span_s.0.min(time), own.span_s.1.max(time));
    }
}

/// The databases, and which message each group of a log is.
#[derive(Debug)]
pub(in crate::recording) struct Decoder {
    databases: Vec<Database>,
    /// Message (database and place in it) and signals of each group.
    groups: Vec<DecodedGroup>,
    of_frames: BTreeMap<Identifier, Vec<usize>>,
}

/// The signals of a message that have the same conditions: these have one clock.
#[derive(Debug)]
struct DecodedGroup {
    database: usize,
    message: usize,
    conditions: Vec<Condition>,
    signals: Vec<usize>,
}

impl Decoder {
    /// Reads the databases.
    pub(in crate::recording) fn new(options: &LogOptions) -> Self {
        let databases = options.dbc.iter().map(|(name, text)| Database::of_text(name, text));
        Self { databases: databases.collect(), groups: Vec::new(), of_frames: BTreeMap::new() }
    }

    /// The messages by name, of names that one message has.
    pub(super) fn names(&self) -> Names {
        let mut names = BTreeMap::new();
        let mut repeated = Vec::new();
        for message in self.databases.iter().flat_map(|database| &database.messages) {
            let own = (message.id, message.is_extended);
            if names.insert(message.name.clone(), own).is_some_and(|other| other != own) {
                repeated.push(&message.name);
            }
        }
        repeated.into_iter().for_each(|name| {
            names.remove(name);
        });
        names.into()
    }

    /// What of the databases could not be read, and which kinds of frames they do not have.
    pub(in crate::recording) fn losses(&self, file: &str) -> Vec<String> {
        let mut losses: Vec<String> =
            self.databases.iter().flat_map(|d| d.faults.iter().cloned()).collect();
        let unknown = self.of_frames.iter().filter(|(_, groups)| groups.is_empty());
        let ids: Vec<String> = unknown.map(|(id, _)| format!("{:#X}", id.id)).collect();
        if !ids.is_empty() {
            const SHOWN: usize = 8;
            let more = if ids.len() > SHOWN { ", …" } else { "" };
            losses.push(format!(
                "{file}: {} kinds of frames are in no database: {}{more}",
                ids.len(),
                ids[..ids.len().min(SHOWN)].join(", ")
            ));
        }
        losses
    }

    /// The groups of a log with these frames: the messages, and those of their signals that a multiplexer
    /// selects. The first channel is the time.
    pub(in crate::recording) fn groups(
        &mut self,
        file: &str,
        seen: &BTreeMap<Identifier, Seen>,
    ) -> Vec<Group> {
        let mut all = Vec::new();
        for (identifier, seen_here) in seen {
            let same = |other: &Identifier| {
                (other.id, other.is_extended) == (identifier.id, identifier.is_extended)
            };
            let is_on_several = seen.keys().filter(|other| same(other)).count() > 1;
            let mut own = Vec::new();
            if let Some((database, place)) = self.find(identifier, seen) {
                let message = &self.databases[database].messages[place];
                let source = match identifier.id == message.id {
                    true => String::new(),
                    false => format!("[SA={:#04X}]", identifier.id & 0xFF),
                };
                let bus =
                    if is_on_several { format!("{}:", identifier.bus) } else { String::new() };
                for (conditions, signals) in parts(message) {
                    let name =
                        format!("{bus}{}{source}{}", message.name, in_words(message, &conditions));
                    all.push(group(file, &name, message, &signals, &conditions, *seen_here));
                    own.push(self.groups.len());
                    self.groups.push(DecodedGroup {
                        database,
                        message: place,
                        conditions,
                        signals,
                    });
                }
            }
            self.of_frames.insert(identifier.clone(), own);
        }
        all
    }

    /// The message with this identifier, or else that of the same parameter group (J1939): one for all sources, or one
    /// whose own source is not on the bus.
    fn find(
        &self,
        identifier: &Identifier,
        seen: &BTreeMap<Identifier, Seen>,
    ) -> Option<(usize, usize)> {
        let is_same = |m: &Message, i: &Identifier| (m.id, m.is_extended) == (i.id, i.is_extended);
        let of_group = |m: &Message| {
            m.is_extended
                && identifier.is_extended
                && parameter_group(m.id) == parameter_group(identifier.id)
        };
        let is_any = |m: &Message| m.id & 0xFF == ANY_SOURCE;
        let is_absent = |m: &Message| {
            is_standard(parameter_group(m.id)) && !seen.keys().any(|other| is_same(m, other))
        };
        let find = |is: &dyn Fn(&Message) -> bool| {
            let mut all = self.databases.iter().enumerate();
            all.find_map(|(d, database)| Some((d, database.messages.iter().position(is)?)))
        };
        find(&|m| is_same(m, identifier))
            .or_else(|| find(&|m| of_group(m) && is_any(m)))
            .or_else(|| find(&|m| of_group(m) && is_absent(m)))
    }

    /// The groups that frames of a kind are in.
    pub(in crate::recording) fn of_frame(&self, identifier: &Identifier) -> &[usize] {
        self.of_frames.get(identifier).map_or(&[], Vec::as_slice)
    }

    /// The values of the channels of a group, the time among them; `None` where the multiplexer selects
    /// others.
    pub(in crate::recording) fn values(
        &self,
        group: usize,
        channels: &[usize],
        time: f64,
        data: &[u8],
    ) -> Option<Vec<f64>> {
        let part = &self.groups[group];
        let signals = &self.databases[part.database].messages[part.message].signals;
        let selects = |condition: &Condition| {
            let value = signals[condition.multiplexer].bits.raw(data);
            let Some(super::bits::Raw::Integer(value)) = value else { return false };
            condition
                .ranges
                .iter()
                .any(|(from, to)| (i128::from(*from)..=i128::from(*to)).contains(&value))
        };
        if !part.conditions.iter().all(selects) {
            return None;
        }
        let value = |c: &usize| match c.checked_sub(1) {
            None => time,
            Some(k) => signals[part.signals[k]].value(data).unwrap_or(f64::NAN),
        };
        Some(channels.iter().map(value).collect())
    }
}

/// The source address of J1939 in databases that hold for all sources.
const ANY_SOURCE: u32 = 0xFE;

/// The number of the parameter group (J1939) of an identifier: without priority, source and, where there is one, the
/// destination.
fn parameter_group(id: u32) -> u32 {
    const BROADCAST: u32 = 240;
    let group = id >> 8 & 0x3_FFFF;
    if group >> 8 & 0xFF < BROADCAST { group & 0x3_FF00 } else { group }
}

/// Whether the parameter group has one meaning on all vehicles: to all receivers, and not left to the makers.
fn is_standard(group: u32) -> bool {
    const BROADCAST: u32 = 0xF000;
    const OF_MAKERS: u32 = 0xFF00;
    (BROADCAST..OF_MAKERS).contains(&(group & 0xFFFF))
}

/// The signals of a message by their conditions, those without first.
fn parts(message: &Message) -> Vec<(Vec<Condition>, Vec<usize>)> {
    let mut parts: Vec<(Vec<Condition>, Vec<usize>)> = Vec::new();
    for (k, signal) in message.signals.iter().enumerate() {
        match parts.iter_mut().find(|(conditions, _)| *conditions == signal.conditions) {
            Some((_, signals)) => signals.push(k),
            None => parts.push((signal.conditions.clone(), vec![k])),
        }
    }
    parts.sort_by_key(|(conditions, _)| conditions.len());
    parts
}

/// Such as `[Mode=1]`.
fn in_words(message: &Message, conditions: &[Condition]) -> String {
    let range = |&(from, to): &(u64, u64)| {
        if from == to { from.to_string() } else { format!("{from}-{to}") }
    };
    let condition = |c: &Condition| {
        let ranges: Vec<String> = c.ranges.iter().map(range).collect();
        format!("{}={}", message.signals[c.multiplexer].name, ranges.join("+"))
    };
    let all: Vec<String> = conditions.iter().map(condition).collect();
    if all.is_empty() { String::new() } else { format!("[{}]", all.join(",")) }
}

fn group(
    file: &str,
    name: &str,
    message: &Message,
    signals: &[usize],
    conditions: &[Condition],
    seen: Seen,
) -> Group {
    let time = std::iter::once(Channel::new("time", Some("s")));
    let signals = signals.iter().map(|&k| &message.signals[k]);
    let signals = signals.map(|signal| Channel::new(&signal.name, Some(&signal.unit)));
    let mut group = Group::new(file, name, time.chain(signals).collect());
    group.kind = format!("CAN {:#X}", message.id);
    group.clock = Some(0);
    group.span_s = Some(seen.span_s);
    group.rows = if conditions.is_empty() { Some(seen.frames) } else { None };
    group
}
