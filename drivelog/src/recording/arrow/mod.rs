//! Arrow IPC: files, which are Feather's second version, and streams; flat columns of numbers, a batch at a time.
//!
//! Columns are read as those of Parquet are. Buffers may be compressed with LZ4 or Zstandard, both in Rust, and are
//! read from their start to their end, so that memory does not grow with a batch. The metadata are flatbuffers of a few
//! tables, which [`flatbuffer`] reads; a crate for all of Arrow would bring the arrays, too, and Zstandard in C.

mod cells;
mod flatbuffer;
pub(super) mod schema;

use super::bytes::{Head, LogFile};
use super::read_at::{At, ReadAt};
use super::scale::Scale;
use super::{Columns, Group, Pieces, Recording, Request, Rows, contained};
use crate::Error;
use crate::options::LogOptions;
use cells::{Batch, Cells};
use schema::{Column, Layout, Schema};
use std::io::{self, Read, Seek, SeekFrom};
use std::rc::Rc;
use std::sync::Arc;

const MAGIC: &[u8] = b"ARROW1";
/// Stands before the length of a message.
const MARK: &[u8] = &[0xFF; 4];
/// No metadata of a message are longer.
const LONGEST: u64 = 1 << 26;

pub(super) fn recognises(head: &Head<'_>) -> bool {
    let of_stream = || {
        let message = head.start.strip_prefix(MARK).and_then(|rest| rest.get(4..));
        // The schema may be longer than what is looked at.
        let table = message.and_then(|message| flatbuffer::Table::of(message, 0));
        table.is_some_and(|table| table.byte(1) == Some(schema::CODE))
    };
    head.start.starts_with(b"ARROW1\0\0") || of_stream()
}

/// Opens a table; lists its batches.
pub(super) fn open<'a>(
    file: LogFile<'a>,
    _: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    let bytes = file.sought()?;
    let name = file.name;
    let failed = |byte, problem: String| Error::Read { file: name.clone(), byte, problem };
    let mut messages = Messages::of(&bytes).map_err(|e| failed(0, e.to_string()))?;
    let first = messages.next().map_err(|e| failed(0, e.to_string()))?;
    let schema = first.and_then(|(_, message)| Schema::of(&message));
    let schema = schema.ok_or_else(|| failed(messages.at, "no schema of Arrow".into()))?;
    let mut losses: Vec<String> = Vec::new();
    let mut batches = Vec::new();
    loop {
        match messages.next() {
            Ok(Some((body, message))) => batches.extend(Batch::of(&message, body)),
            Ok(None) => break,
            Err(error) => {
                losses.push(format!(
                    "{name}: byte {}: {error}: what follows is not read",
                    messages.at
                ));
                break;
            }
        }
    }
    let unread = schema.unread.iter();
    losses.extend(unread.map(|(own, what)| format!("{name}: column `{own}` is not read: {what}")));
    let mut columns = schema.columns;
    for column in &mut columns {
        let Layout::Texts(width) = column.layout else { continue };
        let filled = batches.iter().find(|batch| batch.rows > 0);
        let first = |batch| Cells::of(&bytes, batch, column)?.first_text(width);
        let text = filled.and_then(|batch| contained(|| first(batch))?.ok().flatten());
        column.scale = Scale::of_text(text.as_deref());
    }
    let channels = columns.iter().map(|own| own.scale.channel(&own.name, own.is_time));
    let mut group = Group::new(&name, "", channels.collect());
    if group.channels.iter().all(|channel| channel.is_text) {
        return Err(failed(0, "no column has numbers".into()));
    }
    group.rows = batches.iter().try_fold(0_u64, |sum, batch| sum.checked_add(batch.rows));
    Ok(Box::new(Ipc { bytes, groups: [group], columns, batches, losses }))
}

/// The messages of a file or stream, one after the other.
struct Messages {
    reader: At,
    /// Where the next one begins, and where they end.
    at: u64,
    end: u64,
    is_cut: bool,
}

impl Messages {
    fn of(bytes: &Arc<dyn ReadAt>) -> io::Result<Self> {
        let size = bytes.size()?;
        let mut reader = At::new(Arc::clone(bytes));
        let mut start = [0; 8];
        reader.read_exact(&mut start)?;
        let (mut at, mut end, mut is_cut) = (0, size, false);
        if start.starts_with(MAGIC) {
            // The list of the batches, its length and the mark end a file; the messages stand before it as in a stream.
            let mut tail = [0; 10];
            reader.seek(SeekFrom::Start(size.saturating_sub(10)))?;
            reader.read_exact(&mut tail)?;
            is_cut = !tail.ends_with(MAGIC);
            let [a, b, c, d, ..] = tail;
            let list = if is_cut { 0 } else { 10 + u64::from(u32::from_le_bytes([a, b, c, d])) };
            (at, end) = (8, size.saturating_sub(list));
        }
        Ok(Self { reader, at, end, is_cut })
    }

    /// The place of the body of the next message, and its metadata.
    fn next(&mut self) -> io::Result<Option<(u64, Vec<u8>)>> {
        let cut = || io::Error::other("the file ends within a message");
        let mut word = [0; 4];
        if self.at + 4 > self.end {
            return if self.is_cut { Err(cut()) } else { Ok(None) };
        }
        self.reader.seek(SeekFrom::Start(self.at))?;
        self.reader.read_exact(&mut word)?;
        // Older writers state the length alone.
        let mut start = self.at + 4;
        if word == MARK {
            self.reader.read_exact(&mut word)?;
            start += 4;
        }
        let length = u64::from(u32::from_le_bytes(word));
        if length == 0 {
            return Ok(None);
        }
        if length > LONGEST || start + length > self.end {
            return Err(cut());
        }
        let mut message = vec![0; length as usize];
        self.reader.read_exact(&mut message)?;
        let body = start + length;
        let of_body = flatbuffer::Table::of(&message, 0).and_then(|table| table.number::<8>(3));
        let of_body = of_body.and_then(|length| u64::try_from(length).ok());
        let of_body = of_body.ok_or_else(|| io::Error::other("the message is damaged"))?;
        if body.checked_add(of_body).is_none_or(|end| end > self.end) {
            return Err(cut());
        }
        self.at = body + of_body;
        Ok(Some((body, message)))
    }
}

struct Ipc {
    bytes: Arc<dyn ReadAt>,
    groups: [Group; 1],
    columns: Vec<Column>,
    batches: Vec<Batch>,
    losses: Vec<String>,
}

impl Recording for Ipc {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let wanted = request.wanted.first().filter(|wanted| !wanted.channels.is_empty());
        let Some(wanted) = wanted else { return Ok(Box::new(std::iter::empty())) };
        let Self { bytes, groups, columns, batches, losses } = self;
        let mut own: Vec<Column> = wanted.channels.iter().map(|&c| columns[c].clone()).collect();
        let mut batches = batches.iter();
        let mut current: Option<&Batch> = None;
        let mut cells: Vec<Cells> = Vec::new();
        // Rows so far, and those left of the batch.
        let (mut row, mut left) = (0_u64, 0_u64);
        Ok(Box::new(std::iter::from_fn(move || {
            loop {
                if left == 0 {
                    let batch = batches.next()?;
                    (current, left) = (Some(batch), batch.rows);
                    let opened = own.iter().map(|column| Cells::of(bytes, batch, column));
                    cells = match opened.collect() {
                        Ok(cells) => cells,
                        Err(problem) => {
                            losses.push(lost(&groups[0].file, batch, left, &problem));
                            row += std::mem::take(&mut left);
                            continue;
                        }
                    };
                }
                let count = usize::try_from(left).unwrap_or(usize::MAX).min(request.most);
                let read = cells.iter_mut().zip(&mut own).map(|(cells, column)| {
                    let damaged = || Err("the bytes are damaged".into());
                    contained(|| cells.read(column, count)).unwrap_or_else(damaged)
                });
                match read.collect::<Result<Vec<Vec<f64>>, String>>() {
                    Ok(values) => {
                        let lines = Rc::new((row + 1..=row + count as u64).collect());
                        row += count as u64;
                        left -= count as u64;
                        return Some(Ok(Rows { wanted: 0, columns: Columns { values, lines } }));
                    }
                    Err(problem) => {
                        losses.extend(current.map(|b| lost(&groups[0].file, b, left, &problem)));
                        row += std::mem::take(&mut left);
                    }
                }
            }
        })))
    }

    fn losses(&self) -> Vec<String> {
        self.losses.clone()
    }
}

fn lost(name: &str, batch: &Batch, rows: u64, problem: &str) -> String {
    format!("{name}: {rows} rows of the batch at byte {} are not read: {problem}", batch.body)
}
