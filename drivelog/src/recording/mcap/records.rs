//! Records of an MCAP file: an operation code, a length and the content. Source: [MCAP format
//! specification](https://mcap.dev/spec).

use super::super::read_at::ReadAt;
use std::io;
use std::sync::Arc;

pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Operation codes.
pub(super) mod op {
    pub(in super::super) const FOOTER: u8 = 0x02;
    pub(in super::super) const SCHEMA: u8 = 0x03;
    pub(in super::super) const CHANNEL: u8 = 0x04;
    pub(in super::super) const MESSAGE: u8 = 0x05;
    pub(in super::super) const CHUNK: u8 = 0x06;
    pub(in super::super) const CHUNK_INDEX: u8 = 0x08;
    pub(in super::super) const STATISTICS: u8 = 0x0B;
    pub(in super::super) const DATA_END: u8 = 0x0F;
}

/// Bytes of operation code and length.
pub(super) const HEAD: u64 = 9;

/// Operation code and length of the content.
pub(super) fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let mut fields = Fields(bytes);
    Some((fields.u8()?, fields.u64()?))
}

/// Little-endian fields of a record's content.
#[derive(Clone, Copy)]
pub(super) struct Fields<'b>(pub(super) &'b [u8]);

impl<'b> Fields<'b> {
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    fn u8(&mut self) -> Option<u8> {
        self.array().map(u8::from_le_bytes)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes with their number in 32 bits before them.
    fn bytes(&mut self) -> Option<&'b [u8]> {
        let count = self.u32()? as usize;
        let (bytes, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(bytes)
    }

    fn text(&mut self) -> Option<&'b str> {
        std::str::from_utf8(self.bytes()?).ok()
    }
}

#[derive(Debug, Clone)]
pub(super) struct Schema {
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) text: String,
}

impl Schema {
    pub(super) fn parse(content: &[u8]) -> Option<(u16, Self)> {
        let mut fields = Fields(content);
        let id = fields.u16()?;
        let (name, encoding) = (fields.text()?.into(), fields.text()?.into());
        let text = String::from_utf8_lossy(fields.bytes()?).into_owned();
        Some((id, Self { name, encoding, text }))
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Channel {
    pub(super) schema: u16,
    pub(super) topic: String,
    pub(super) encoding: String,
}

impl Channel {
    pub(super) fn parse(content: &[u8]) -> Option<(u16, Self)> {
        let mut fields = Fields(content);
        let (id, schema) = (fields.u16()?, fields.u16()?);
        Some((id, Self { schema, topic: fields.text()?.into(), encoding: fields.text()?.into() }))
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Message<'b> {
    pub(super) channel: u16,
    /// ns
    pub(super) log_time: u64,
    /// ns
    pub(super) publish_time: u64,
    pub(super) data: &'b [u8],
}

impl<'b> Message<'b> {
    /// Bytes before the data.
    pub(super) const START: usize = 22;

    pub(super) fn parse(content: &'b [u8]) -> Option<Self> {
        let mut fields = Fields(content);
        let channel = fields.u16()?;
        fields.u32()?;
        let (log_time, publish_time) = (fields.u64()?, fields.u64()?);
        Some(Self { channel, log_time, publish_time, data: fields.0 })
    }
}

/// What stands before the records of a chunk.
#[derive(Debug, Clone)]
pub(super) struct ChunkStart {
    pub(super) uncompressed: u64,
    /// CRC-32 of the uncompressed records; 0 if there is none.
    pub(super) crc: u32,
    pub(super) compression: String,
    /// The records, as the chunk has them.
    pub(super) compressed: u64,
    /// Where they begin in the content.
    pub(super) at: usize,
}

impl ChunkStart {
    pub(super) fn parse(content: &[u8]) -> Option<Self> {
        let mut fields = Fields(content);
        // First and last time, which those of the messages replace.
        fields.u64()?;
        fields.u64()?;
        let (uncompressed, crc) = (fields.u64()?, fields.u32()?);
        let compression = fields.text()?.into();
        let compressed = fields.u64()?;
        let at = content.len() - fields.0.len();
        Some(Self { uncompressed, crc, compression, compressed, at })
    }
}

/// Where a chunk is, as the summary states it.
#[derive(Debug, Clone)]
pub(super) struct ChunkIndex {
    /// ns
    pub(super) times: (u64, u64),
    pub(super) at: u64,
    pub(super) length: u64,
    /// Bytes of the message indexes behind it.
    pub(super) indexes: u64,
    /// Its channels; empty where they are not stated.
    pub(super) channels: Vec<u16>,
}

impl ChunkIndex {
    pub(super) fn parse(content: &[u8]) -> Option<Self> {
        let mut fields = Fields(content);
        let times = (fields.u64()?, fields.u64()?);
        let (at, length) = (fields.u64()?, fields.u64()?);
        let mut map = Fields(fields.bytes()?);
        let mut channels = Vec::new();
        while !map.0.is_empty() {
            channels.push(map.u16()?);
            map.u64()?;
        }
        Some(Self { times, at, length, indexes: fields.u64()?, channels })
    }
}

#[derive(Debug, Clone, Default)]
pub(super) struct Statistics {
    pub(super) messages: u64,
    pub(super) channels: u32,
    pub(super) chunks: u32,
    /// Number of messages by channel.
    pub(super) counts: Vec<(u16, u64)>,
}

impl Statistics {
    pub(super) fn parse(content: &[u8]) -> Option<Self> {
        let mut fields = Fields(content);
        let messages = fields.u64()?;
        fields.u16()?;
        let channels = fields.u32()?;
        // Attachments and metadata.
        fields.u32()?;
        fields.u32()?;
        let chunks = fields.u32()?;
        // First and last time.
        fields.u64()?;
        fields.u64()?;
        let mut map = Fields(fields.bytes()?);
        let mut counts = Vec::new();
        while !map.0.is_empty() {
            counts.push((map.u16()?, map.u64()?));
        }
        Some(Self { messages, channels, chunks, counts })
    }
}

/// A part of the file that is moved along it.
pub(super) struct View {
    bytes: Arc<dyn ReadAt>,
    pub(super) size: u64,
    at: u64,
    buffer: Vec<u8>,
}

/// Bytes read at once.
const AHEAD: u64 = 1 << 18;

impl View {
    pub(super) fn new(bytes: Arc<dyn ReadAt>) -> io::Result<Self> {
        let size = bytes.size()?;
        Ok(Self { bytes, size, at: 0, buffer: Vec::new() })
    }

    /// Up to `count` bytes from `at` on; fewer only at the end of the file. Up to `end` is read ahead.
    pub(super) fn get(&mut self, at: u64, count: u64, end: u64) -> io::Result<&[u8]> {
        let count = count.min(self.size.saturating_sub(at));
        let held = self.at + self.buffer.len() as u64;
        if at < self.at || at + count > held {
            let ahead = AHEAD.min(end.min(self.size).saturating_sub(at));
            self.buffer.resize(count.max(ahead) as usize, 0);
            self.at = at;
            let mut filled = 0;
            while filled < self.buffer.len() {
                match self.bytes.read_at(&mut self.buffer[filled..], at + filled as u64) {
                    Ok(0) => break,
                    Ok(more) => filled += more,
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(error) => {
                        self.buffer.clear();
                        return Err(error);
                    }
                }
            }
            self.buffer.truncate(filled);
        }
        let from = ((at - self.at) as usize).min(self.buffer.len());
        let to = (from + count as usize).min(self.buffer.len());
        Ok(&self.buffer[from..to])
    }

    /// Operation code and length of the record at `at`, if it ends in the file.
    pub(super) fn record(&mut self, at: u64, end: u64) -> io::Result<Option<(u8, u64)>> {
        let size = self.size;
        let head = head(self.get(at, HEAD, end)?);
        Ok(head.filter(|(code, length)| {
            let last = at.checked_add(HEAD).and_then(|at| at.checked_add(*length));
            *code != 0 && last.is_some_and(|last| last <= size)
        }))
    }

    /// The next place at or after `at` where several records follow each other.
    pub(super) fn next_record(&mut self, mut at: u64, end: u64) -> io::Result<Option<u64>> {
        /// Places that are tried.
        const MOST: usize = 1 << 20;
        let mut tried = 0;
        while at + HEAD <= end && tried < MOST {
            let first = head(self.get(at, HEAD, end)?);
            if matches!(first, Some((1..=op::DATA_END, length)) if length < end - at) {
                tried += 1;
                if self.starts_records(at, end) {
                    return Ok(Some(at));
                }
            }
            at += 1;
        }
        Ok(None)
    }

    /// Whether records follow each other from there on, as far as can be seen at a few places.
    fn starts_records(&self, mut at: u64, end: u64) -> bool {
        const IN_A_ROW: usize = 4;
        for _ in 0..IN_A_ROW {
            let mut bytes = [0; HEAD as usize];
            let is_read =
                matches!(self.bytes.read_at(&mut bytes, at), Ok(count) if count == bytes.len());
            match head(&bytes).filter(|_| is_read) {
                Some((1..=op::DATA_END, length)) if length < end.saturating_sub(at + HEAD) => {
                    at += HEAD + length;
                }
                _ => return false,
            }
        }
        true
    }
}
