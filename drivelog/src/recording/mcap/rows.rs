//! Rows in the order of their times: chunks may overlap, and stamps be logged late.

use super::chunk::records;
use super::content::Block;
use super::file::Mcap;
use super::records::{HEAD, Message, op};
use super::topic::{FIELDS, LOG_TIME, PUBLISH_TIME, Topic};
use crate::Error;
use crate::error::counted;
use crate::recording::ros::seconds;
use crate::recording::{Batches, Request, Rows};
use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap, VecDeque};
use std::io;

/// Bytes of records outside chunks that are read at once.
const STEP: u64 = 1 << 20;
/// How much later than its successor a message outside chunks may have been logged, ns.
const LATE: u64 = 2_000_000_000;
/// Most values that wait for earlier ones in later chunks.
const MOST_WAITING: usize = 1 << 22;
/// Rows of a topic within which they are sorted by their stamps.
const SORTED: usize = 512;
/// A stamp that falls by more, s, was not logged late: the clock of the sender was set back, or begins again.
const FALL_S: f64 = 1.0;
/// Messages that overtake each other by less, s, are usual.
const LATE_S: f64 = 0.05;

/// A row that is waiting, ordered by its time and then as it was read.
struct Row<T> {
    time: T,
    number: u64,
    wanted: usize,
    values: Box<[f64]>,
}

type Waiting<T> = BinaryHeap<Reverse<Row<T>>>;

/// How the messages of a topic become rows.
struct Extraction {
    topic: usize,
    /// Number of values in a row.
    width: usize,
    /// Places in the row of log time and publish time; beyond its width where they are not wanted.
    times: [usize; 2],
    /// Place in the row of each field.
    fields: Vec<usize>,
    /// Channels that are wanted again, and the place of the first.
    copies: Vec<(usize, usize)>,
    /// Place in the row of the stamp by which rows are sorted.
    stamp: Option<usize>,
    /// First and last log time, ns.
    log_times: (u64, u64),
    /// Messages that are damaged, and why.
    damaged: BTreeMap<&'static str, (u64, u64)>,
    sorted: Waiting<f64>,
    rows: u64,
    /// The latest stamp, s.
    latest: f64,
    /// Messages with a stamp well before that of one that was logged earlier, which are sorted.
    late: u64,
}

pub(super) struct McapReader<'r> {
    mcap: &'r mut Mcap,
    of_channels: BTreeMap<u16, usize>,
    extractions: Vec<Extraction>,
    /// Blocks to be read, the first last.
    blocks: Vec<Block>,
    waiting: Waiting<u64>,
    values: usize,
    number: u64,
    batches: Batches,
    ready: VecDeque<Rows>,
    is_done: bool,
}

impl<'r> McapReader<'r> {
    pub(super) fn new(mcap: &'r mut Mcap, request: &Request<'_>) -> Self {
        let mut of_channels = BTreeMap::new();
        let mut extractions = Vec::new();
        for (index, wanted) in request.wanted.iter().enumerate() {
            let topic = &mcap.topics[wanted.group];
            of_channels.extend(topic.ids.iter().map(|id| (*id, index)));
            extractions.push(Extraction::new(mcap, wanted.group, &wanted.channels, request));
        }
        let is_wanted = |block: &&Block| {
            of_channels.iter().any(|(id, index)| {
                let (from, to) = extractions[*index].log_times;
                block.channels.as_ref().is_none_or(|ids| ids.contains(id))
                    && block.times.0 <= to
                    && block.times.1 >= from
            })
        };
        let mut blocks: Vec<Block> =
            mcap.content.blocks.iter().filter(is_wanted).cloned().collect();
        blocks.sort_by_key(|block| Reverse(block.times.0));
        Self {
            mcap,
            of_channels,
            extractions,
            blocks,
            waiting: Waiting::new(),
            values: 0,
            number: 0,
            batches: Batches::new(request),
            ready: VecDeque::new(),
            is_done: false,
        }
    }

    /// Reads the next block, or takes rows that no later block comes before.
    fn advance(&mut self) -> io::Result<()> {
        let until = self.blocks.last().map_or(u64::MAX, |block| block.times.0);
        while let Some(Reverse(first)) = self.waiting.peek() {
            if !self.blocks.is_empty() && first.time >= until && self.values < MOST_WAITING {
                break;
            }
            let Some(Reverse(row)) = self.waiting.pop() else { break };
            self.values -= row.values.len() + 1;
            self.sort(row);
            if self.batches.is_full() {
                self.ready.extend(self.batches.drain());
                return Ok(());
            }
        }
        match self.blocks.pop() {
            Some(block) if block.is_chunk => self.read_chunk(&block),
            Some(block) => self.read_loose(block),
            None => {
                self.finish();
                Ok(())
            }
        }
    }

    /// Passes a row on when those with earlier stamps must have come.
    fn sort(&mut self, row: Row<u64>) {
        let own = &mut self.extractions[row.wanted];
        let time = own.stamp.map(|place| row.values[place]).filter(|time| !time.is_nan());
        let Some(time) = time else { return self.push(row.wanted, &row.values) };
        let (number, wanted) = (row.number, row.wanted);
        own.late += u64::from((LATE_S..=FALL_S).contains(&(own.latest - time)));
        if time < own.latest - FALL_S {
            // What reads the rows reports that their times fall.
            own.latest = time;
            let mut before = std::mem::take(&mut own.sorted);
            while let Some(Reverse(row)) = before.pop() {
                self.push(wanted, &row.values);
                if self.batches.is_full() {
                    self.ready.extend(self.batches.drain());
                }
            }
        }
        let own = &mut self.extractions[wanted];
        own.latest = own.latest.max(time);
        own.sorted.push(Reverse(Row { time, number, wanted, values: row.values }));
        if own.sorted.len() > SORTED
            && let Some(Reverse(row)) = own.sorted.pop()
        {
            self.push(wanted, &row.values);
        }
    }

    fn push(&mut self, wanted: usize, values: &[f64]) {
        let own = &mut self.extractions[wanted];
        own.rows += 1;
        self.batches.push(wanted, own.rows, values.iter().copied());
    }

    fn finish(&mut self) {
        for wanted in 0..self.extractions.len() {
            let mut rest = std::mem::take(&mut self.extractions[wanted].sorted);
            while let Some(Reverse(row)) = rest.pop() {
                self.push(wanted, &row.values);
                if self.batches.is_full() {
                    self.ready.extend(self.batches.drain());
                }
            }
            let own = &mut self.extractions[wanted];
            let group = self.mcap.groups[own.topic].place();
            for (why, (count, at)) in std::mem::take(&mut own.damaged) {
                let text = format!("byte {at}: {group}: {why}: {count} of them left out");
                self.mcap.content.note_loss(text);
            }
            if own.late > 0 {
                let late = counted(usize::try_from(own.late).unwrap_or(usize::MAX), "message");
                self.mcap.content.note_loss(format!(
                    "{group}: {late} with a stamp before that of one logged earlier: put in the order of their stamps"
                ));
            }
            if let Some(why) = self.mcap.topics[own.topic].unread() {
                self.mcap.content.note_loss(format!("{group}: {why}"));
            }
        }
        self.ready.extend(self.batches.drain());
        self.is_done = true;
    }

    fn read_chunk(&mut self, block: &Block) -> io::Result<()> {
        let bytes = self.mcap.content.records(&mut self.mcap.view, block)?;
        for (code, content) in records(&bytes) {
            if code == op::MESSAGE
                && let Some(message) = Message::parse(content)
            {
                self.take(&message, block.at);
            }
        }
        Ok(())
    }

    /// Reads some of the records outside chunks; the rest becomes a block of its own.
    fn read_loose(&mut self, mut block: Block) -> io::Result<()> {
        let stop = block.end.min(block.at + STEP);
        let mut last = block.times.0;
        while block.at < stop {
            let Some((code, length)) = self.mcap.view.record(block.at, block.end)? else {
                return Ok(());
            };
            if code == op::MESSAGE {
                let start = HEAD + length.min(Message::START as u64);
                let whole = self.mcap.view.get(block.at, start, block.end)?;
                let message = Message::parse(whole.get(HEAD as usize..).unwrap_or_default());
                let Some((channel, time)) = message.map(|m| (m.channel, m.log_time)) else {
                    return Ok(());
                };
                last = last.max(time);
                if self.is_wanted(channel, time) {
                    let whole = self.mcap.view.get(block.at, HEAD + length, block.end)?.to_vec();
                    let content = whole.get(HEAD as usize..).unwrap_or_default();
                    if let Some(message) = Message::parse(content) {
                        self.take(&message, block.at);
                    }
                }
            }
            block.at += HEAD + length;
        }
        if block.at < block.end {
            block.times.0 = block.times.0.max(last.saturating_sub(LATE));
            let at = self.blocks.partition_point(|other| other.times.0 > block.times.0);
            self.blocks.insert(at, block);
        }
        Ok(())
    }

    fn is_wanted(&self, channel: u16, log_time: u64) -> bool {
        self.of_channels.get(&channel).is_some_and(|index| {
            let (from, to) = self.extractions[*index].log_times;
            (from..=to).contains(&log_time)
        })
    }

    /// Adds a message of the block at `at`.
    fn take(&mut self, message: &Message<'_>, at: u64) {
        let Some(&wanted) = self.of_channels.get(&message.channel) else { return };
        if !self.is_wanted(message.channel, message.log_time) {
            return;
        }
        let own = &mut self.extractions[wanted];
        match own.row(&self.mcap.topics[own.topic], message) {
            Ok(values) => {
                self.number += 1;
                self.values += values.len() + 1;
                let (time, number) = (message.log_time, self.number);
                self.waiting.push(Reverse(Row { time, number, wanted, values }));
            }
            Err(why) => own.damaged.entry(why).or_insert((0, at)).0 += 1,
        }
    }
}

impl Extraction {
    fn new(mcap: &Mcap, topic: usize, channels: &[usize], request: &Request<'_>) -> Self {
        let group = &mcap.groups[topic];
        let width = channels.len();
        let place = |channel| channels.iter().position(|c| *c == channel).unwrap_or(usize::MAX);
        let copies = channels.iter().enumerate().map(|(at, c)| (at, place(*c)));
        let is_time = |channel: &&usize| {
            **channel < FIELDS || group.clock.is_some_and(|clock| clock == **channel)
        };
        // The clock in use is the first of the times that are wanted.
        let clock = channels.iter().find(is_time).filter(|clock| **clock != LOG_TIME);
        Self {
            topic,
            width,
            times: [place(LOG_TIME), place(PUBLISH_TIME)],
            fields: (FIELDS..group.channels.len()).map(place).collect(),
            copies: copies.filter(|(at, first)| at != first).collect(),
            stamp: clock.map(|clock| place(*clock)),
            log_times: mcap.topics[topic].log_times(request.window_s),
            damaged: BTreeMap::new(),
            sorted: Waiting::new(),
            rows: 0,
            latest: f64::NEG_INFINITY,
            late: 0,
        }
    }

    fn row(&self, topic: &Topic, message: &Message<'_>) -> Result<Box<[f64]>, &'static str> {
        let mut row = vec![f64::NAN; self.width].into_boxed_slice();
        for (place, time) in self.times.iter().zip([message.log_time, message.publish_time]) {
            if let Some(to) = row.get_mut(*place) {
                *to = seconds(i64::try_from(time).unwrap_or(i64::MAX));
            }
        }
        topic.read(message.data, &self.fields, &mut row)?;
        self.copies.iter().for_each(|(to, from)| row[*to] = row[*from]);
        Ok(row)
    }
}

impl Iterator for McapReader<'_> {
    type Item = Result<Rows, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.ready.is_empty() && !self.is_done {
            let byte = self.blocks.last().map_or(0, |block| block.at);
            if let Err(error) = self.advance() {
                self.is_done = true;
                return Some(Err(self.mcap.failed(byte, &error)));
            }
        }
        self.ready.pop_front().map(Ok)
    }
}

/// A time that rows are ordered by.
trait Instant {
    fn compare(&self, other: &Self) -> Ordering;
}

impl Instant for u64 {
    fn compare(&self, other: &Self) -> Ordering {
        self.cmp(other)
    }
}

impl Instant for f64 {
    fn compare(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

impl<T: Instant> Ord for Row<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.time.compare(&other.time).then(self.number.cmp(&other.number))
    }
}

impl<T: Instant> PartialOrd for Row<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T: Instant> PartialEq for Row<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T: Instant> Eq for Row<T> {}
