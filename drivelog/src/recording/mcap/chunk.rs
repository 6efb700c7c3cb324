//! Chunks: records that are compressed together.

use super::records::{ChunkStart, HEAD, View, head, op};
use crate::recording::compression::{ZSTANDARD, Zstandard};
use lz4_flex::frame::FrameDecoder;
use ruzstd::decoding::StreamingDecoder;
use std::borrow::Cow;
use std::io::{self, Read};

/// Largest chunk that is decompressed, bytes.
const MOST: u64 = 1 << 28;
/// Most bytes of a message that are decompressed.
pub(super) const MOST_MESSAGE: u64 = 1 << 26;

/// The records of a chunk, as far as they can be read, and what is wrong with the rest.
pub(super) struct Chunk {
    pub(super) records: Vec<u8>,
    pub(super) problem: Option<String>,
}

impl Chunk {
    /// Whether a chunk begins at `at`, and the file ends before it does.
    pub(super) fn is_cut(view: &mut View, at: u64) -> io::Result<bool> {
        const MOST_START: u64 = 64;
        let size = view.size;
        let bytes = view.get(at, MOST_START, size)?;
        let start = bytes.get(HEAD as usize..).and_then(ChunkStart::parse);
        Ok(head(bytes).zip(start).is_some_and(|((code, length), start)| {
            let content = start.compressed.checked_add(start.at as u64);
            code == op::CHUNK && content == Some(length) && length > size - at - HEAD
        }))
    }

    /// The chunk whose record is at `at` and ends at `end` or, if it was cut off, with the file.
    pub(super) fn read(view: &mut View, at: u64, end: u64) -> io::Result<Self> {
        let lost = |problem: String| Self { records: Vec::new(), problem: Some(problem) };
        if end.min(view.size).saturating_sub(at) > MOST {
            return Ok(lost(format!("a chunk of more than {MOST} bytes is not read")));
        }
        let whole = view.get(at, end - at, end)?;
        let content = whole.get(HEAD as usize..).unwrap_or_default();
        let Some(start) = ChunkStart::parse(content) else {
            return Ok(lost("the start of a chunk is damaged".into()));
        };
        let bytes = &content[start.at..];
        let is_cut = (bytes.len() as u64) < start.compressed;
        let bytes = &bytes[..bytes.len().min(start.compressed as usize)];
        if start.uncompressed > MOST {
            return Ok(lost(format!("a chunk of {} bytes is not read", start.uncompressed)));
        }
        let (records, failure) = match start.compression.as_str() {
            "" => (bytes.to_vec(), None),
            "zstd" => match StreamingDecoder::new(bytes) {
                Ok(decoder) => decompressed(decoder, start.uncompressed),
                Err(error) => (Vec::new(), Some(error.to_string())),
            },
            "lz4" => decompressed(FrameDecoder::new(bytes), start.uncompressed),
            other => return Ok(lost(format!("chunks with `{other}` compression are not read"))),
        };
        if is_cut {
            let (some, all) = (records.len(), start.uncompressed);
            let problem = format!("a chunk is cut off: {some} of its {all} bytes are read");
            return Ok(Self { records, problem: Some(problem) });
        }
        // Any number of a damaged chunk may be wrong.
        let problem = if let Some(failure) = failure {
            format!("a chunk cannot be decompressed ({failure})")
        } else if records.len() as u64 != start.uncompressed {
            "a chunk is shorter than stated".into()
        } else if start.crc != 0 && crc32fast::hash(&records) != start.crc {
            "a chunk differs from its checksum".into()
        } else {
            return Ok(Self { records, problem: None });
        };
        Ok(lost(format!("{problem}: its {} bytes are not read", start.uncompressed)))
    }
}

fn decompressed(decoder: impl Read, count: u64) -> (Vec<u8>, Option<String>) {
    let mut records = Vec::new();
    let result = decoder.take(count).read_to_end(&mut records);
    (records, result.err().map(|error| error.to_string()))
}

/// At most so many bytes of a message as it was published: recorders of ROS 2 may compress each of them (Zstandard).
pub(super) fn plain(message: &[u8], most: u64) -> Result<Cow<'_, [u8]>, &'static str> {
    if !message.starts_with(ZSTANDARD) {
        return Ok(message.into());
    }
    let mut bytes = Vec::new();
    let read = Zstandard::new(message).take(most).read_to_end(&mut bytes);
    read.map_err(|_| "messages in Zstandard are damaged")?;
    Ok(bytes.into())
}

/// The records in a chunk: operation code and content; the rest of a damaged one is passed over.
pub(super) fn records(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = bytes;
    std::iter::from_fn(move || {
        let (code, length) = head(rest)?;
        let content = rest.get(HEAD as usize..)?.get(..usize::try_from(length).ok()?)?;
        rest = &rest[HEAD as usize + content.len()..];
        Some((code, content))
    })
}
