//! Raw CAN buses in text, decoded by CAN databases (DBC).

mod bits;
mod dbc;
mod decode;
mod text;

use super::bytes::{Head, LogFile};
use super::{Batches, Group, Pieces, Recording, Request};
use crate::Error;
use crate::options::LogOptions;
pub(in crate::recording) use decode::{Decoder, Identifier, Seen};
use std::collections::{BTreeMap, VecDeque};
use text::{Form, Frame, Frames};

pub(super) fn recognises(head: &Head<'_>) -> bool {
    Form::of(head.start).is_some()
}

/// Opens a bus log; reads through it once for the kinds of frames.
pub(super) fn open<'a>(
    file: LogFile<'a>,
    options: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    let form = Form::of(&file.head()?).unwrap_or(Form::Candump);
    let mut seen = BTreeMap::new();
    let mut frames = Frames::new(file.reader()?, form);
    let mut losses = Vec::new();
    loop {
        match frames.next() {
            Ok(Some(frame)) => {
                let time = frame.time;
                Seen::note(&mut seen, identifier(frame), time);
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
    if options.dbc.is_empty() {
        let ids: std::collections::BTreeSet<u32> = seen.keys().map(|i| i.id).collect();
        return Err(Error::NoDatabase { file: file.name, kinds: ids.len() });
    }
    let mut decoder = Decoder::new(options);
    let groups = decoder.groups(&file.name, &seen);
    if groups.is_empty() {
        return Err(Error::NotInDatabase { file: file.name, kinds: seen.len() });
    }
    losses.extend(decoder.losses(&file.name));
    Ok(Box::new(Bus { file, form, decoder, groups, losses }))
}

fn identifier(frame: Frame) -> Identifier {
    Identifier { bus: frame.bus, id: frame.id, is_extended: frame.is_extended }
}

struct Bus<'a> {
    file: LogFile<'a>,
    form: Form,
    decoder: Decoder,
    groups: Vec<Group>,
    losses: Vec<String>,
}

impl Recording for Bus<'_> {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let mut frames = Frames::new(self.file.reader()?, self.form);
        let mut batches = Batches::new(&request);
        let mut ready = VecDeque::new();
        let mut is_read = false;
        let mut rows = vec![0; request.wanted.len()];
        let decoder = &self.decoder;
        Ok(Box::new(std::iter::from_fn(move || {
            while ready.is_empty() && !is_read {
                // An error here is that of the first pass, which has reported it.
                let Ok(Some(mut frame)) = frames.next() else {
                    is_read = true;
                    ready.extend(batches.drain());
                    break;
                };
                let (time, data) = (frame.time, std::mem::take(&mut frame.data));
                for group in decoder.of_frame(&identifier(frame)) {
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
