//! Dictionaries and batches of a file or stream of Arrow: where they are, and their bytes after a check.
//!
//! The library takes for granted what metadata state: lengths would reserve gigabytes, and buffers that overlap would be
//! numbers. A whole file lists its parts at the end; of a stream, and of a file that was cut off, the messages are
//! followed from one to the next.

use crate::recording::read_at::{At, ReadAt};
use arrow_array::RecordBatch as Rows;
use arrow_buffer::{Buffer, MutableBuffer};
use arrow_data::layout;
use arrow_ipc::convert::try_fb_to_schema;
use arrow_ipc::reader::FileDecoder;
use arrow_ipc::{Block, Message, MetadataVersion, RecordBatch, root_as_footer, root_as_message};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use std::fmt::Display;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

pub(super) const MAGIC: &[u8] = b"ARROW1";
/// Stands before the length of a message.
pub(super) const MARK: &[u8] = &[0xFF; 4];
/// No metadata of a message are longer, bytes.
const LONGEST: u64 = 1 << 26;
/// A buffer is never larger when decompressed, in bytes and in times of what it was.
const LARGEST: u64 = 1 << 30;
const MOST_TIMES: u64 = 1 << 15;
/// What begins in a file begins at a multiple of so many bytes.
const STEPS: [u64; 5] = [1, 8, 16, 32, 64];

pub(super) type Outcome<T> = Result<T, String>;

/// The first line of what the library reports.
fn in_words(error: impl Display) -> String {
    error.to_string().lines().next().unwrap_or_default().into()
}

/// A dictionary or a batch.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArrowPart {
    block: Block,
    /// Bytes before its metadata.
    prefix: u64,
    /// Of a batch.
    pub(super) rows: Option<u64>,
}

impl ArrowPart {
    pub(super) fn byte(&self) -> u64 {
        self.block.offset().unsigned_abs()
    }

    fn end(&self) -> u64 {
        let length = self.block.bodyLength().unsigned_abs();
        self.byte() + u64::from(self.block.metaDataLength().unsigned_abs()) + length
    }
}

/// The schema of a file or stream, and its parts in the order of their use.
pub(super) struct Contents {
    bytes: Arc<dyn ReadAt>,
    pub(super) schema: SchemaRef,
    pub(super) parts: Vec<ArrowPart>,
    /// What is damaged, and from which byte on.
    pub(super) damages: Vec<(u64, String)>,
}

impl Contents {
    pub(super) fn open(bytes: &Arc<dyn ReadAt>) -> Outcome<Self> {
        let size = bytes.size().map_err(in_words)?;
        let is_file = read(bytes, 0..size.min(6))? == MAGIC;
        if !is_file {
            return Self::from_messages(bytes, 0, size);
        }
        Self::from_footer(bytes, size).or_else(|problem| {
            let mut contents = Self::from_messages(bytes, 8, size).map_err(|_| problem.clone())?;
            if contents.damages.is_empty() {
                contents.damages.push((size, problem));
            }
            Ok(contents)
        })
    }

    /// Of a whole file, by the list at its end.
    fn from_footer(bytes: &Arc<dyn ReadAt>, size: u64) -> Outcome<Self> {
        let tail = read(bytes, size.saturating_sub(10)..size)?;
        let none = "the list at the end of the file is not there";
        let length = tail.strip_suffix(MAGIC).and_then(<[u8]>::first_chunk).ok_or(none)?;
        let length = u64::from(u32::from_le_bytes(*length));
        if length > LONGEST || size < 10 + length {
            return Err(none.into());
        }
        let start = size - 10 - length;
        let footer = read(bytes, start..size - 10)?;
        let footer = root_as_footer(&footer).map_err(in_words)?;
        let schema = footer.schema().ok_or("the list at the end of the file has no schema")?;
        let mut contents = Self::new(bytes, schema)?;
        for block in
            footer.dictionaries().iter().flatten().chain(footer.recordBatches().iter().flatten())
        {
            let place = u64::try_from(block.offset()).map_err(in_words)?;
            match message(bytes, place, start) {
                Ok(Some(own)) if own.block == *block => contents.add(&own),
                Ok(_) => contents.damages.push((place, "no batch is where one is listed".into())),
                Err(problem) => contents.damages.push((place, problem)),
            }
        }
        // A list of fewer batches than there are.
        let mut parts = contents.parts.clone();
        parts.sort_by_key(ArrowPart::byte);
        let ends = parts.iter().map(ArrowPart::end);
        let starts = parts.iter().skip(1).map(ArrowPart::byte).chain([start]);
        let gaps = ends.zip(starts).filter(|(end, start)| end + 64 < *start);
        let is_unlisted = |(end, start)| (end, format!("{} bytes are in no batch", start - end));
        if contents.damages.is_empty() {
            contents.damages = gaps.map(is_unlisted).collect();
        }
        Ok(contents)
    }

    /// Of messages from there to the end.
    fn from_messages(bytes: &Arc<dyn ReadAt>, from: u64, end: u64) -> Outcome<Self> {
        let first = message(bytes, from, end)?.ok_or("no schema of Arrow")?;
        let mut at = first.end();
        let first = first.parsed()?;
        let schema = first.header_as_schema().ok_or("no schema of Arrow")?;
        let mut contents = Self::new(bytes, schema)?;
        loop {
            match message(bytes, at, end) {
                Ok(Some(own)) => {
                    at = own.end();
                    contents.add(&own);
                }
                Ok(None) => {
                    // Of streams in one file the first is read.
                    if from == 0 && at + 8 < end {
                        let rest =
                            format!("{} bytes behind the end mark are not read", end - at - 8);
                        contents.damages.push((at + 8, rest));
                    }
                    break;
                }
                Err(problem) => {
                    let rest = if at < end { "; what follows is not read" } else { "" };
                    contents.damages.push((at, format!("{problem}{rest}")));
                    break;
                }
            }
        }
        Ok(contents)
    }

    fn new(bytes: &Arc<dyn ReadAt>, schema: arrow_ipc::Schema<'_>) -> Outcome<Self> {
        if !schema.endianness().equals_to_target_endianness() {
            return Err("numbers whose high byte comes first, which are not read here".into());
        }
        let schema = try_fb_to_schema(schema).map_err(in_words)?.into();
        Ok(Self { bytes: Arc::clone(bytes), schema, parts: Vec::new(), damages: Vec::new() })
    }

    fn add(&mut self, own: &Own) {
        let part = own.parsed().and_then(|message| {
            let rows =
                match (message.header_as_record_batch(), message.header_as_dictionary_batch()) {
                    (Some(batch), _) => Some(u64::try_from(batch.length()).map_err(in_words)?),
                    (_, Some(dictionary)) if self.has(dictionary.id()) => None,
                    _ => return Err("neither a batch nor a dictionary of the schema".into()),
                };
            Ok(ArrowPart { block: own.block, prefix: own.prefix, rows })
        });
        match part {
            Ok(part) => self.parts.push(part),
            Err(problem) => self.damages.push((own.block.offset().unsigned_abs(), problem)),
        }
    }

    /// The bytes of a part, with what the library takes for granted checked.
    fn read(&self, part: &ArrowPart) -> Outcome<Buffer> {
        let mut all = MutableBuffer::from_len_zeroed((part.end() - part.byte()) as usize);
        let mut reader = At::new(Arc::clone(&self.bytes));
        let read = reader.seek(SeekFrom::Start(part.byte()));
        read.and_then(|_| reader.read_exact(&mut all)).map_err(in_words)?;
        let (metadata, body) = all.split_at(part.block.metaDataLength().unsigned_abs() as usize);
        let message = root_as_message(&metadata[part.prefix as usize..]).map_err(in_words)?;
        let batch = message.header_as_record_batch();
        let of_views = |batch: RecordBatch<'_>| {
            batch.variadicBufferCounts().iter().flatten().fold(0, i64::wrapping_add)
        };
        if let Some((batch, buffers)) = batch.and_then(|batch| Some((batch, batch.buffers()?))) {
            let fields = self.schema.flattened_fields();
            let count = |field: &&Field| buffers_of(field.data_type(), message.version());
            let of_schema: usize = fields.iter().map(count).sum();
            if (of_schema as i64).wrapping_add(of_views(batch)) != buffers.len() as i64 {
                return Err(format!("{} buffers are not those of the schema", buffers.len()));
            }
        }
        let of_dictionary = || message.header_as_dictionary_batch()?.data();
        check(batch.or_else(of_dictionary).ok_or("no batch")?, body)?;
        Ok(all.into())
    }

    #[expect(deprecated)] // The library has no other way to the numbers of its dictionaries.
    fn has(&self, dictionary: i64) -> bool {
        !self.schema.fields_with_dict_id(dictionary).is_empty()
    }
}

/// Refuses what the library takes for granted.
fn check(batch: RecordBatch<'_>, body: &[u8]) -> Outcome<()> {
    if batch.nodes().iter().flatten().any(|node| node.null_count() < 0) {
        return Err("a negative number of missing cells".into());
    }
    let mut places = Vec::new();
    for buffer in batch.buffers().iter().flatten() {
        let place = u64::try_from(buffer.offset()).ok().zip(u64::try_from(buffer.length()).ok());
        let place = place.and_then(|(from, length)| Some(from..from.checked_add(length)?));
        let place = place.filter(|place| place.end <= body.len() as u64);
        let place = place.ok_or("a buffer is beyond its batch")?;
        let content = &body[place.start as usize..place.end as usize];
        let size = content.first_chunk().filter(|_| batch.compression().is_some());
        let size = size.and_then(|size| u64::try_from(i64::from_le_bytes(*size)).ok());
        let most = LARGEST.min(MOST_TIMES * content.len() as u64);
        if let Some(size) = size.filter(|size| *size > most) {
            return Err(format!("{size} bytes in {} that are compressed", content.len()));
        }
        if !content.is_empty() {
            places.push(place);
        }
    }
    // Each begins where the one before ends, at the next multiple of the same step.
    let follow = |step: &u64| {
        let ends = places.iter().map(|place| place.end.next_multiple_of(*step));
        places.iter().zip([0].into_iter().chain(ends)).all(|(place, end)| place.start == end)
    };
    let is_whole = STEPS.iter().any(follow);
    if !is_whole {
        return Err("the buffers do not follow one another".into());
    }
    Ok(())
}

/// Buffers of a column without those below it.
fn buffers_of(kind: &DataType, version: MetadataVersion) -> usize {
    let layout = layout(kind);
    let own = layout.buffers.len() + usize::from(layout.can_contain_null_mask);
    match kind {
        DataType::Union(..) if version < MetadataVersion::V5 => own + 1,
        DataType::RunEndEncoded(ends, _) => own + buffers_of(ends.data_type(), version),
        _ => own,
    }
}

/// The batches with columns at some places of the schema, one after the other.
pub(super) struct Batches<'c> {
    contents: &'c Contents,
    parts: std::slice::Iter<'c, ArrowPart>,
    decoder: FileDecoder,
    has_dictionaries: bool,
    /// A dictionary is damaged.
    fault: Option<String>,
}

impl<'c> Batches<'c> {
    pub(super) fn new(contents: &'c Contents, places: &[usize]) -> Self {
        // With this version the library takes that of each message.
        let decoder = FileDecoder::new(Arc::clone(&contents.schema), MetadataVersion::V1);
        let schema = contents.schema.project(places).unwrap_or_else(|_| Schema::empty());
        let is_dictionary = |field: &&Field| matches!(field.data_type(), DataType::Dictionary(..));
        let has_dictionaries = schema.flattened_fields().iter().any(is_dictionary);
        Self {
            contents,
            parts: contents.parts.iter(),
            decoder: decoder.with_projection(places.to_vec()),
            has_dictionaries,
            fault: None,
        }
    }

    fn add(&mut self, part: &ArrowPart) -> Outcome<()> {
        let buffer = self.contents.read(part)?;
        let read = super::contained(|| self.decoder.read_dictionary(&part.block, &buffer));
        read.ok_or("the bytes are damaged")?.map_err(in_words)
    }

    fn read(&self, part: &ArrowPart) -> Outcome<Rows> {
        let buffer = self.contents.read(part)?;
        let read = super::contained(|| self.decoder.read_record_batch(&part.block, &buffer));
        read.ok_or("the bytes are damaged")?.map_err(in_words)?.ok_or_else(|| "no batch".into())
    }
}

impl<'c> Iterator for Batches<'c> {
    type Item = (&'c ArrowPart, Outcome<Rows>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let part = self.parts.next()?;
            if part.rows.is_some() {
                let rows = match &self.fault {
                    Some(fault) => Err(fault.clone()),
                    None => self.read(part),
                };
                return Some((part, rows));
            }
            if self.has_dictionaries
                && let Err(problem) = self.add(part)
            {
                self.fault = Some(format!("the dictionary at byte {}: {problem}", part.byte()));
            }
        }
    }
}

/// Metadata of a message, and its place.
struct Own {
    metadata: Vec<u8>,
    prefix: u64,
    block: Block,
}

impl Own {
    fn parsed(&self) -> Outcome<Message<'_>> {
        root_as_message(&self.metadata).map_err(in_words)
    }

    fn end(&self) -> u64 {
        ArrowPart { block: self.block, prefix: self.prefix, rows: None }.end()
    }
}

/// The message at that byte; `None` at the end mark.
fn message(bytes: &Arc<dyn ReadAt>, at: u64, end: u64) -> Outcome<Option<Own>> {
    let cut = || "the file ends within a message".to_owned();
    let within = |from: u64, length: u64| {
        let until = from.checked_add(length).filter(|until| *until <= end).ok_or_else(cut)?;
        read(bytes, from..until)
    };
    if at == end {
        return Err("the file ends without an end mark and may have been cut off".into());
    }
    let start = within(at, 4)?;
    // Older writers state the length alone.
    let prefix = if start == MARK { 8 } else { 4 };
    let length = within(at + prefix - 4, 4)?;
    let length = u64::from(u32::from_le_bytes(length.try_into().unwrap_or_default()));
    if length == 0 {
        return Ok(None);
    }
    let metadata = if length > LONGEST { Err(cut()) } else { within(at + prefix, length) }?;
    let body = root_as_message(&metadata).map_err(in_words)?.bodyLength();
    let body = u64::try_from(body).map_err(|_| format!("a body of {body} bytes"))?;
    let is_within = (at + prefix + length).checked_add(body).is_some_and(|until| until <= end);
    let block = Block::new(at as i64, (prefix + length) as i32, body as i64);
    if !is_within {
        return Err(cut());
    }
    Ok(Some(Own { metadata, prefix, block }))
}

fn read(bytes: &Arc<dyn ReadAt>, range: Range<u64>) -> Outcome<Vec<u8>> {
    let mut reader = At::new(Arc::clone(bytes));
    let mut all = vec![0; (range.end - range.start) as usize];
    let read = reader.seek(SeekFrom::Start(range.start));
    read.and_then(|_| reader.read_exact(&mut all)).map_err(in_words)?;
    Ok(all)
}
