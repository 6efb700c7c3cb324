//! The buffers of a batch of Arrow as numbers.

use super::flatbuffer::{Table, integer};
use super::schema::{Column, Kind, Layout};
use crate::recording::compression::Zstandard;
use crate::recording::read_at::{At, ReadAt};
use crate::recording::scale::Scale;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::sync::Arc;

/// No text of a time is longer, bytes.
const LONGEST_TEXT: u64 = 4096;
/// Bytes of a buffer that are read at once.
const STEP: usize = 1 << 14;
/// Code of a batch of rows among the messages.
const ROWS: u8 = 3;

/// A batch of rows: the places of its buffers.
#[derive(Debug)]
pub(super) struct Batch {
    pub(super) rows: u64,
    /// The byte at which the buffers begin.
    pub(super) body: u64,
    /// Missing cells of each column.
    missing: Vec<i64>,
    /// Place and length of each buffer.
    buffers: Vec<[u64; 2]>,
    /// Further buffers of the columns that have as many as a batch states.
    views: Vec<u64>,
    /// LZ4 or Zstandard.
    codec: Option<u8>,
}

impl Batch {
    /// Of a message whose body begins there; `None` of another message.
    pub(super) fn of(message: &[u8], body: u64) -> Option<Self> {
        let message = Table::of(message, 0)?;
        let batch = message.table(2).filter(|_| message.byte(1) == Some(ROWS))?;
        let number = |bytes: &[u8]| u64::try_from(integer(bytes)?).ok();
        let missing = batch.list(1, 16)?.into_iter().map(|node| integer(&node[8..]));
        let buffers = batch.list(2, 16)?.into_iter();
        let buffers = buffers.map(|place| Some([number(&place[..8])?, number(&place[8..])?]));
        let views = batch.list(4, 8)?.into_iter().map(number);
        Some(Self {
            rows: u64::try_from(batch.number::<8>(0)?).ok()?,
            body,
            missing: missing.collect::<Option<_>>()?,
            buffers: buffers.collect::<Option<_>>()?,
            views: views.collect::<Option<_>>()?,
            codec: batch.table(3).map(|compression| compression.byte(0).unwrap_or(0)),
        })
    }

    /// The bytes of a buffer of a column, decompressed.
    fn buffer(&self, bytes: &Arc<dyn ReadAt>, column: &Column, at: usize) -> Outcome<Bytes> {
        let views: u64 = self.views.iter().take(column.views).sum();
        let place = usize::try_from(views).ok().and_then(|views| views.checked_add(at));
        let place = place.and_then(|at| self.buffers.get(at));
        let [from, length] = *place.ok_or("a buffer is missing")?;
        let mut reader = At::new(Arc::clone(bytes));
        let from = self.body.checked_add(from).ok_or("a buffer is beyond the file")?;
        reader.seek(SeekFrom::Start(from)).map_err(in_words)?;
        let mut reader = BufReader::with_capacity(STEP, reader).take(length);
        let Some(codec) = self.codec.filter(|_| length > 0) else { return Ok(Box::new(reader)) };
        let mut size = [0; 8];
        reader.read_exact(&mut size).map_err(in_words)?;
        let size = i64::from_le_bytes(size);
        Ok(match (codec, u64::try_from(size)) {
            // It would have become longer.
            (_, Err(_)) => Box::new(reader),
            (0, Ok(size)) => Box::new(lz4_flex::frame::FrameDecoder::new(reader).take(size)),
            (1, Ok(size)) => Box::new(Zstandard::new(reader).take(size)),
            _ => return Err("the compression is not known here".into()),
        })
    }
}

type Bytes = Box<dyn Read>;
type Outcome<T> = Result<T, String>;

fn in_words(error: io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "a buffer ends before its rows".into(),
        _ => error.to_string(),
    }
}

/// The cells of a column in a batch, from the first to the last.
pub(super) struct Cells {
    /// Which are there, in the column and in the structures that it is in.
    are_there: Vec<Bits>,
    values: Bytes,
    bits: Option<Bits>,
    texts: Option<Bytes>,
    /// Where the text before ended.
    offset: u64,
}

impl Cells {
    pub(super) fn of(bytes: &Arc<dyn ReadAt>, batch: &Batch, column: &Column) -> Outcome<Self> {
        let mut are_there = Vec::new();
        for [node, buffer] in column.parents.iter().copied().chain([[column.node, column.buffer]]) {
            if batch.missing.get(node).is_some_and(|missing| *missing != 0) {
                are_there.push(Bits::new(batch.buffer(bytes, column, buffer)?));
            }
        }
        let at = column.buffer + 1;
        let mut cells = Self {
            are_there,
            values: batch.buffer(bytes, column, at)?,
            bits: None,
            texts: None,
            offset: 0,
        };
        match column.layout {
            Layout::Bits => {
                cells.bits =
                    Some(Bits::new(std::mem::replace(&mut cells.values, Box::new(io::empty()))));
            }
            Layout::Texts(width) => {
                let mut texts = batch.buffer(bytes, column, at + 1)?;
                cells.offset = cells.next_offset(width)?;
                io::copy(&mut texts.by_ref().take(cells.offset), &mut io::sink())
                    .map_err(in_words)?;
                cells.texts = Some(texts);
            }
            Layout::Bytes(_) => {}
        }
        Ok(cells)
    }

    fn next_offset(&mut self, width: usize) -> Outcome<u64> {
        let mut bytes = [0; 8];
        let bytes = bytes.get_mut(..width).ok_or("the offsets are damaged")?;
        self.values.read_exact(bytes).map_err(in_words)?;
        let offset = integer(bytes).and_then(|offset| u64::try_from(offset).ok());
        offset
            .filter(|offset| *offset >= self.offset)
            .ok_or_else(|| "the offsets are damaged".into())
    }

    /// The next text.
    fn next_text(&mut self, width: usize) -> Outcome<Vec<u8>> {
        let end = self.next_offset(width)?;
        let length = end - std::mem::replace(&mut self.offset, end);
        let mut text = Vec::new();
        if let Some(texts) = &mut self.texts {
            texts
                .by_ref()
                .take(length.min(LONGEST_TEXT))
                .read_to_end(&mut text)
                .map_err(in_words)?;
            let rest = length.saturating_sub(LONGEST_TEXT);
            io::copy(&mut texts.by_ref().take(rest), &mut io::sink()).map_err(in_words)?;
        }
        Ok(text)
    }

    fn is_there(&mut self) -> Outcome<bool> {
        let mut is_there = true;
        for bits in &mut self.are_there {
            is_there &= bits.next()?;
        }
        Ok(is_there)
    }

    /// The first text, among the first rows.
    pub(super) fn first_text(mut self, width: usize) -> Outcome<Option<String>> {
        for _ in 0..1000 {
            let (is_there, text) = (self.is_there()?, self.next_text(width)?);
            if is_there {
                return Ok(Some(String::from_utf8_lossy(&text).into_owned()));
            }
        }
        Ok(None)
    }

    /// The numbers of so many rows; one that is missing is NaN.
    pub(super) fn read(&mut self, column: &mut Column, count: usize) -> Outcome<Vec<f64>> {
        let mut numbers = match (column.layout, &mut self.bits) {
            (Layout::Bytes(width), _) => {
                let mut bytes = vec![0; width * count];
                self.values.read_exact(&mut bytes).map_err(in_words)?;
                bytes.chunks_mut(width).map(|cell| number(column, cell)).collect::<Outcome<_>>()?
            }
            (Layout::Bits, Some(bits)) => {
                let bits = (0..count).map(|_| bits.next().map(|bit| f64::from(u8::from(bit))));
                bits.collect::<Outcome<Vec<f64>>>()?
            }
            _ => vec![f64::NAN; count],
        };
        for number in &mut numbers {
            let is_there = self.is_there()?;
            if let Layout::Texts(width) = column.layout {
                let text = self.next_text(width)?;
                if is_there {
                    *number = column.scale.of_bytes(&text)?;
                }
            }
            if !is_there {
                *number = f64::NAN;
            }
        }
        Ok(numbers)
    }
}

/// The number of a cell.
fn number(column: &mut Column, cell: &mut [u8]) -> Outcome<f64> {
    Ok(match (column.kind, column.scale, &*cell) {
        (Kind::Float, Scale::Half, bytes) => Scale::Half.of_bytes(bytes)?,
        (Kind::Float, _, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        (Kind::Float, _, bytes) => f64::from_le_bytes(bytes.try_into().unwrap_or_default()),
        (Kind::Integer, Scale::Divided(by), bytes) if bytes.len() > 8 => {
            cell.reverse();
            Scale::Bytes(by).of_bytes(cell)?
        }
        (Kind::Integer, scale, bytes) => {
            let x = integer(bytes).unwrap_or_default();
            let is_unsigned = scale == Scale::Plain { is_unsigned: true };
            let is_short = is_unsigned && bytes.len() < 8;
            scale.of_integer(if is_short { x & ((1 << (8 * bytes.len())) - 1) } else { x }, 64)
        }
        (Kind::Text, ..) => f64::NAN,
    })
}

/// Bits one after the other, the lowest of a byte first.
struct Bits {
    bytes: Bytes,
    byte: u8,
    left: u8,
}

impl Bits {
    fn new(bytes: Bytes) -> Self {
        Self { bytes, byte: 0, left: 0 }
    }

    fn next(&mut self) -> Outcome<bool> {
        if self.left == 0 {
            self.bytes.read_exact(std::slice::from_mut(&mut self.byte)).map_err(in_words)?;
            self.left = 8;
        }
        let bit = self.byte & 1 != 0;
        (self.byte, self.left) = (self.byte >> 1, self.left - 1);
        Ok(bit)
    }
}
