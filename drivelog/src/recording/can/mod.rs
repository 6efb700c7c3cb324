//! Raw CAN buses in text, decoded by CAN databases (DBC).

mod asc;
mod bits;
mod busmaster;
mod candump;
mod dbc;
mod decode;
mod frame;
mod kvaser;
mod table;
mod text;
mod trc;

use super::bytes::{Head, LogFile};
use super::{Batches, Group, Pieces, Recording, Request};
use crate::Error;
use crate::options::LogOptions;
use asc::Names;
pub(in crate::recording) use decode::{Decoder, Identifier, Seen};
use frame::Frame;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use text::{CanTextForm, Frames};

pub(super) fn recognises(head: &Head<'_>) -> bool {
    CanTextForm::recognise(head.start).is_some()
}

/// Opens a bus log; reads through it once for the kinds of frames.
pub(super) fn open<'a>(
    file: LogFile<'a>,
    options: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    let mut form = CanTextForm::recognise(&file.head()?).unwrap_or(CanTextForm::Candump);
    if form == CanTextForm::NoTime {
        return Err(Error::FramesWithoutTime { file: file.name });
    }
    let mut decoder = Decoder::new(options);
    let names = decoder.names();
    let mut survey = Survey::new(&file, form, &names)?;
    if form == CanTextForm::Candump && survey.has_steps() {
        form = CanTextForm::Steps;
        survey = Survey::new(&file, form, &names)?;
        survey.losses.push(format!(
            "{}: the times count from the frame before (candump -t d): they are added up",
            file.name
        ));
    }
    let Survey { seen, requests, mut losses, .. } = survey;
    if options.dbc.is_empty() && !seen.is_empty() {
        let ids: BTreeSet<u32> = seen.keys().map(|i| i.id).collect();
        return Err(Error::NoDatabase { file: file.name, kinds: ids.len() });
    }
    let groups = decoder.groups(&file.name, &seen);
    losses.extend(decoder.losses(&file.name));
    if groups.is_empty() {
        const SHOWN: usize = 4;
        losses.truncate(SHOWN);
        let faults = losses.iter().map(|loss| format!("; {loss}")).collect();
        if seen.is_empty() {
            return Err(Error::NoFrames { file: file.name, faults });
        }
        return Err(Error::NotInDatabase { file: file.name, kinds: seen.len(), faults });
    }
    Ok(Box::new(Bus { file, form, decoder, groups, names, requests, losses }))
}

/// What a log has, by one pass through it.
struct Survey {
    seen: BTreeMap<Identifier, Seen>,
    /// Kinds of frames whose requests are logged in addition to the frames themselves.
    requests: BTreeSet<Identifier>,
    losses: Vec<String>,
    frames: u64,
    /// Frames after the one above them, frames before it, and by how much, s.
    rises: u64,
    falls: u64,
    fallen_s: f64,
    /// The first and the last instant in order of time, s, of the frames after the first one, whose time between frames is 0.
    span_s: (f64, f64),
    trend: Trend,
}

/// Sums for the straight line through the instants over the numbers of the frames.
#[derive(Default)]
struct Trend {
    count: f64,
    time: f64,
    product: f64,
}

impl Trend {
    fn note(&mut self, time: f64) {
        self.product += self.count * time;
        self.count += 1.0;
        self.time += time;
    }

    /// By how much the line rises from the first frame to the last, s.
    fn rise_s(&self) -> f64 {
        let n = self.count;
        let covariance = self.product - 0.5 * (n - 1.0) * self.time;
        12.0 * covariance / (n * (n + 1.0))
    }
}

impl Survey {
    fn new(file: &LogFile<'_>, form: CanTextForm, names: &Names) -> Result<Self, Error> {
        let mut seen = BTreeMap::new();
        let mut of_requests = BTreeMap::new();
        let mut frames = Frames::new(file.reader()?, form);
        frames.asc.names = names.clone();
        let mut losses = Vec::new();
        let (mut count, mut rises, mut falls, mut fallen_s) = (0, 0, 0, 0.0);
        let mut trend = Trend::default();
        let (mut last, mut span_s) = (f64::NEG_INFINITY, (f64::INFINITY, f64::NEG_INFINITY));
        loop {
            match frames.next() {
                Ok(Some(frame)) => {
                    let time = frame.time;
                    count += 1;
                    if time < last {
                        falls += 1;
                        fallen_s += last - time;
                    }
                    rises += u64::from(time > last);
                    last = time;
                    if count > 1 {
                        trend.note(time);
                        span_s = (span_s.0.min(time), span_s.1.max(time));
                    }
                    let all = if frame.is_request { &mut of_requests } else { &mut seen };
                    Seen::note(all, identifier(frame), time);
                }
                Ok(None) => break,
                Err(error) => {
                    losses.push(format!(
                        "{}: nothing is read after line {}, byte {}: {error}",
                        file.name, frames.line, frames.byte
                    ));
                    break;
                }
            }
        }
        losses.extend(frames.loss(&file.name));
        let mut requests = BTreeSet::new();
        let mut left_out = 0;
        for (identifier, own) in of_requests {
            match seen.entry(identifier) {
                Entry::Occupied(entry) => {
                    left_out += own.frames;
                    requests.insert(entry.key().clone());
                }
                Entry::Vacant(entry) => {
                    entry.insert(own);
                }
            }
        }
        if left_out > 0 {
            losses.push(format!(
                "{}: {left_out} requests (TxRq) of frames that are logged as sent, too: left out",
                file.name
            ));
        }
        Ok(Self { seen, requests, losses, frames: count, rises, falls, fallen_s, span_s, trend })
    }

    /// Whether the times are those between frames: they do not rise along the file, and fall by more in sum than all of
    /// them span, also where most of many frames share an instant. Times between frames rise about as often as they fall;
    /// those of recordings that follow each other rise through each of them and fall once.
    fn has_steps(&self) -> bool {
        const LARGEST_S: f64 = 1e6;
        const MOST_IN_ORDER: u64 = 200;
        const MOST_RISES: u64 = 10;
        const FEWEST: u64 = 8;
        let span_s = self.span_s.1 - self.span_s.0;
        // Frames of a bus follow each other: no two have one instant, let alone all.
        if self.frames >= FEWEST && span_s == 0.0 && self.span_s.1 > 0.0 {
            return true;
        }
        self.frames >= FEWEST
            && self.span_s.1 < LARGEST_S
            && self.falls * MOST_IN_ORDER > self.frames
            && self.falls * MOST_RISES > self.rises
            && self.fallen_s > span_s
            && self.trend.rise_s().abs() < 0.2 * span_s
    }
}

fn identifier(frame: Frame) -> Identifier {
    Identifier { bus: frame.bus, id: frame.id, is_extended: frame.is_extended }
}

struct Bus<'a> {
    file: LogFile<'a>,
    form: CanTextForm,
    decoder: Decoder,
    groups: Vec<Group>,
    names: Names,
    /// Kinds of frames whose requests are left out.
    requests: BTreeSet<Identifier>,
    losses: Vec<String>,
}

impl Recording for Bus<'_> {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let mut frames = Frames::new(self.file.reader()?, self.form);
        frames.asc.names = self.names.clone();
        let mut batches = Batches::new(&request);
        let mut ready = VecDeque::new();
        let mut is_read = false;
        let mut rows = vec![0; request.wanted.len()];
        let (decoder, requests) = (&self.decoder, &self.requests);
        Ok(Box::new(std::iter::from_fn(move || {
            while ready.is_empty() && !is_read {
                // An error here is that of the first pass, which has reported it.
                let Ok(Some(mut frame)) = frames.next() else {
                    is_read = true;
                    ready.extend(batches.drain());
                    break;
                };
                let (time, data) = (frame.time, std::mem::take(&mut frame.data));
                let is_request = frame.is_request;
                let identifier = identifier(frame);
                if is_request && requests.contains(&identifier) {
                    continue;
                }
                for group in decoder.of_frame(&identifier) {
                    let Some(w) = request.wanted.iter().position(|w| w.group == *group) else {
                        continue;
                    };
                    let values = decoder.values(*group, &request.wanted[w].channels, time, &data);
                    let Some(values) = values else { continue };
                    rows[w] += 1;
                    batches.push(w, rows[w], values);
                }
                if batches.is_full() {
                    ready.extend(batches.drain());
                }
            }
            ready.pop_front().map(Ok)
        })))
    }

    fn losses(&self) -> Vec<String> {
        self.losses.clone()
    }
}
