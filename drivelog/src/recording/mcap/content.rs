//! What a file holds and where: from its summary, or else from reading all of it once.

use super::chunk::{Chunk, plain, records};
use super::json::Paths;
use super::records::{
    Channel, ChunkIndex, Fields, HEAD, MAGIC, Message, Schema, Statistics, View, op,
};
use crate::recording::compression::ZSTANDARD;
use crate::recording::ros::{Encapsulation, seconds};
use std::collections::{BTreeMap, BTreeSet};
use std::io;

/// Longer messages of JSON are not looked at for their fields, and longer ones in Zstandard not for their time.
const MOST_LOOKED_AT: u64 = 1 << 20;
/// Bytes that the time at the start of a message is in.
const WITH_TIME: u64 = 64;
/// Of the first messages of JSON each is looked at for its fields, of later ones one in so many.
const FIRST: u64 = 256;
const ONE_IN: u64 = 16;
/// Log times of a topic that fall by more along the file, ns, are those of a clock that was set back or of two recordings.
const FALL: i64 = 2_000_000_000;
/// Bytes of the footer and the magic behind it.
const FOOTER: u64 = HEAD + 20 + 8;

/// A part of the file that is read at once.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub(super) at: u64,
    pub(super) end: u64,
    /// First and last log time, ns.
    pub(super) times: (u64, u64),
    /// The channels in it; `None` where they are unknown.
    pub(super) channels: Option<BTreeSet<u16>>,
    /// Whether it is a chunk; else it is records one by one.
    pub(super) is_chunk: bool,
}

/// The first and last message of a channel.
#[derive(Debug, Clone)]
pub(super) struct Ends {
    /// Log time and the time that the message begins with, ns.
    pub(super) first: (u64, Option<i64>),
    pub(super) last: (u64, Option<i64>),
    /// The fields of its messages, if they are JSON.
    pub(super) json: Paths,
}

/// The content of a file.
#[derive(Debug, Clone, Default)]
pub(super) struct Content {
    pub(super) schemas: BTreeMap<u16, Schema>,
    pub(super) channels: BTreeMap<u16, Channel>,
    /// Number of messages of each channel, where it is known.
    pub(super) counts: Option<BTreeMap<u16, u64>>,
    pub(super) blocks: Vec<Block>,
    pub(super) ends: BTreeMap<u16, Ends>,
    pub(super) losses: Vec<String>,
    /// Channels whose log times fall along the file.
    fallen: BTreeSet<u16>,
}

impl Content {
    /// # Errors
    /// What the file system returns.
    pub(super) fn open(view: &mut View) -> io::Result<Self> {
        if let Some(content) = Self::of_summary(view)? {
            return Ok(content);
        }
        let mut content = Self::default();
        content.scan(view, MAGIC.len() as u64, view.size)?;
        let mut counts: BTreeMap<u16, u64> = content.counts.take().unwrap_or_default();
        counts.retain(|id, _| content.channels.contains_key(id));
        content.counts = Some(counts);
        Ok(content)
    }

    /// What the summary at the end of the file states, if it is there and covers the file.
    fn of_summary(view: &mut View) -> io::Result<Option<Self>> {
        let Some(footer_at) = view.size.checked_sub(FOOTER) else { return Ok(None) };
        let footer = view.get(footer_at, FOOTER, view.size)?.to_vec();
        let mut fields = Fields(footer.get(HEAD as usize..).unwrap_or_default());
        let (Some(start), Some(_), Some(crc)) = (fields.u64(), fields.u64(), fields.u32()) else {
            return Ok(None);
        };
        let is_footer = footer.first() == Some(&op::FOOTER) && fields.0 == MAGIC;
        if !is_footer || start < MAGIC.len() as u64 || start >= footer_at {
            return Ok(None);
        }
        let summary = view.get(start, footer_at - start, footer_at)?.to_vec();
        if crc != 0 {
            let mut hasher = crc32fast::Hasher::new();
            hasher.update(&summary);
            hasher.update(&footer[..HEAD as usize + 16]);
            if hasher.finalize() != crc {
                return Ok(None);
            }
        }
        let mut content = Self::default();
        let mut statistics = Statistics::default();
        let mut chunks: Vec<ChunkIndex> = Vec::new();
        for (code, record) in records(&summary) {
            let is_read = match code {
                op::SCHEMA | op::CHANNEL => content.declare(code, record),
                op::STATISTICS => Statistics::parse(record).map(|own| statistics = own).is_some(),
                op::CHUNK_INDEX => ChunkIndex::parse(record).map(|own| chunks.push(own)).is_some(),
                _ => true,
            };
            if !is_read {
                return Ok(None);
            }
        }
        let is_whole = statistics.messages > 0
            && statistics.chunks as usize == chunks.len()
            && statistics.channels as usize == content.channels.len();
        chunks.sort_by_key(|chunk| chunk.at);
        // What stands between the chunks is looked at.
        let mut at = MAGIC.len() as u64;
        for chunk in &chunks {
            let end = chunk.at.checked_add(chunk.length);
            let next = end.and_then(|end| end.checked_add(chunk.indexes));
            let (Some(end), Some(next)) = (end, next.filter(|next| *next <= start)) else {
                return Ok(None);
            };
            if !is_whole || chunk.at < at || chunk.length < HEAD {
                return Ok(None);
            }
            content.scan(view, at, chunk.at)?;
            let channels = chunk.channels.iter().copied().collect();
            content.blocks.push(Block {
                at: chunk.at,
                end,
                times: chunk.times,
                channels: if chunk.channels.is_empty() { None } else { Some(channels) },
                is_chunk: true,
            });
            at = next;
        }
        if !is_whole {
            return Ok(None);
        }
        content.scan(view, at, start)?;
        let counts: BTreeMap<u16, u64> = statistics.counts.into_iter().collect();
        content.counts = if counts.is_empty() { None } else { Some(counts) };
        content.find_ends(view)?;
        Ok(Some(content))
    }

    fn declare(&mut self, code: u8, record: &[u8]) -> bool {
        if code == op::SCHEMA {
            Schema::parse(record)
                .map(|(id, schema)| self.schemas.entry(id).or_insert(schema))
                .is_some()
        } else {
            let channel = Channel::parse(record);
            channel.map(|(id, channel)| self.channels.entry(id).or_insert(channel)).is_some()
        }
    }

    pub(super) fn note_loss(&mut self, text: String) {
        if !self.losses.contains(&text) {
            self.losses.push(text);
        }
    }

    /// Reads the records from `at` to `end`, of messages outside chunks their first bytes only.
    fn scan(&mut self, view: &mut View, mut at: u64, end: u64) -> io::Result<()> {
        let mut loose: Option<Block> = None;
        while at + HEAD <= end {
            let Some((code, length)) = view.record(at, end)? else {
                self.blocks.extend(loose.take());
                at = self.pass_damage(view, at, end)?;
                continue;
            };
            let next = at + HEAD + length;
            match code {
                op::DATA_END | op::FOOTER => break,
                op::SCHEMA | op::CHANNEL => {
                    let whole = view.get(at, next - at, end)?.to_vec();
                    if !self.declare(code, whole.get(HEAD as usize..).unwrap_or_default()) {
                        self.note_loss(format!("byte {at}: a damaged definition is not read"));
                    }
                }
                op::MESSAGE => {
                    // The time that a message begins with is in its first bytes.
                    let some = (Message::START as u64 + WITH_TIME).min(length);
                    let mut whole = view.get(at, HEAD + some, end)?;
                    let message = Message::parse(whole.get(HEAD as usize..).unwrap_or_default());
                    let is_looked_at =
                        |m: Message<'_>| self.is_json(m.channel) || m.data.starts_with(ZSTANDARD);
                    if length < MOST_LOOKED_AT && message.is_some_and(is_looked_at) {
                        whole = view.get(at, next - at, end)?;
                    }
                    let content = whole.get(HEAD as usize..).unwrap_or_default();
                    if let Some(message) = Message::parse(content) {
                        let (id, time) = (message.channel, message.log_time);
                        self.note_fall(&message);
                        self.note(&message);
                        let block = loose.get_or_insert_with(|| Block {
                            at,
                            end: next,
                            times: (time, time),
                            channels: Some(BTreeSet::new()),
                            is_chunk: false,
                        });
                        block.end = next;
                        block.times = (block.times.0.min(time), block.times.1.max(time));
                        if let Some(ids) = &mut block.channels {
                            ids.insert(id);
                        }
                    }
                }
                op::CHUNK => {
                    self.blocks.extend(loose.take());
                    self.scan_chunk(view, at, next)?;
                }
                _ => {}
            }
            at = next;
        }
        self.blocks.extend(loose);
        Ok(())
    }

    /// The next place to read from, after what is no record.
    fn pass_damage(&mut self, view: &mut View, at: u64, end: u64) -> io::Result<u64> {
        if end == view.size && Chunk::is_cut(view, at)? {
            // The file was cut off: what is there of its last chunk.
            self.scan_chunk(view, at, end)?;
            return Ok(end);
        }
        let next = view.next_record(at + 1, end)?.unwrap_or(end);
        self.note_loss(format!("byte {at}: {} bytes are no records and are not read", next - at));
        Ok(next)
    }

    fn scan_chunk(&mut self, view: &mut View, at: u64, end: u64) -> io::Result<()> {
        let mut block = Block { at, end, times: (u64::MAX, 0), channels: None, is_chunk: true };
        let mut channels = BTreeSet::new();
        for (code, content) in records(&self.records(view, &block)?) {
            match code {
                op::SCHEMA | op::CHANNEL => {
                    self.declare(code, content);
                }
                op::MESSAGE => {
                    let Some(message) = Message::parse(content) else { continue };
                    self.note(&message);
                    channels.insert(message.channel);
                    let time = message.log_time;
                    block.times = (block.times.0.min(time), block.times.1.max(time));
                }
                _ => {}
            }
        }
        if !channels.is_empty() {
            self.blocks.push(Block { channels: Some(channels), ..block });
        }
        Ok(())
    }

    /// The records of a chunk, as far as they can be read.
    pub(super) fn records(&mut self, view: &mut View, block: &Block) -> io::Result<Vec<u8>> {
        let chunk = Chunk::read(view, block.at, block.end)?;
        if let Some(problem) = chunk.problem {
            self.note_loss(format!("byte {}: {problem}", block.at));
        }
        Ok(chunk.records)
    }

    fn is_json(&self, channel: u16) -> bool {
        self.channels.get(&channel).is_some_and(|channel| channel.encoding == "json")
    }

    /// Reports a message that was logged much before the one above it in the file.
    fn note_fall(&mut self, message: &Message<'_>) {
        let last = self.ends.get(&message.channel).map_or(0, |ends| ends.last.0);
        let Some(channel) = self.channels.get(&message.channel) else { return };
        // Times beyond those of the clocks are damage.
        let last = i64::try_from(last).unwrap_or_default();
        let time = i64::try_from(message.log_time).unwrap_or(i64::MAX);
        if !self.fallen.contains(&message.channel) && time.saturating_add(FALL) < last {
            let fall_s = seconds(last - time);
            let text = format!(
                "{}: the log times fall by {fall_s:.1} s, as where a clock was set back or two recordings were joined: the messages are put in the order of their times",
                channel.topic
            );
            self.fallen.insert(message.channel);
            self.note_loss(text);
        }
    }

    /// Notes a message of a block.
    fn note(&mut self, message: &Message<'_>) {
        let counts = self.counts.get_or_insert_default();
        let count = counts.entry(message.channel).or_insert(0);
        *count += 1;
        let is_looked_at = *count <= FIRST || count.is_multiple_of(ONE_IN);
        let is_json = is_looked_at && self.is_json(message.channel);
        let most = if is_json { MOST_LOOKED_AT } else { WITH_TIME };
        let time = message.log_time;
        let bytes = plain(message.data, most).unwrap_or_default();
        let own = (time, Encapsulation::first_time(&bytes));
        let ends = self.ends.entry(message.channel);
        let ends = ends.or_insert_with(|| Ends { first: own, last: own, json: Paths::default() });
        if time < ends.first.0 {
            ends.first = own;
        }
        if time >= ends.last.0 {
            ends.last = own;
        }
        if is_json && (bytes.len() as u64) < MOST_LOOKED_AT {
            ends.json.add_message(&bytes);
        }
    }

    /// Finds the first and last message of each channel in the chunks that begin and end with them.
    fn find_ends(&mut self, view: &mut View) -> io::Result<()> {
        let expected: BTreeSet<u16> = self.channels.keys().copied().collect();
        let counts = self.counts.clone();
        let mut blocks: Vec<Block> = self.blocks.iter().filter(|b| b.is_chunk).cloned().collect();
        let mut read = BTreeSet::new();
        for is_last in [false, true] {
            if is_last {
                blocks.sort_by_key(|block| std::cmp::Reverse(block.times.1));
            } else {
                blocks.sort_by_key(|block| block.times.0);
            }
            let mut missing = expected.clone();
            missing.retain(|id| {
                counts.as_ref().is_none_or(|all| all.get(id).is_some_and(|count| *count > 0))
            });
            for block in &blocks {
                if missing.is_empty() {
                    break;
                }
                if block.channels.as_ref().is_some_and(|ids| ids.is_disjoint(&missing)) {
                    continue;
                }
                if read.insert(block.at) || block.channels.is_none() {
                    let blocks = std::mem::take(&mut self.blocks);
                    self.scan_chunk(view, block.at, block.end)?;
                    // The chunk is known from the summary already.
                    let found = std::mem::replace(&mut self.blocks, blocks);
                    let ids = found.into_iter().filter_map(|b| b.channels).flatten();
                    for id in ids {
                        missing.remove(&id);
                    }
                }
                if let Some(ids) = &block.channels {
                    missing.retain(|id| !ids.contains(id));
                }
            }
        }
        self.counts = counts;
        Ok(())
    }
}
