//! Files that are compressed as a whole: gzip, Zstandard, bzip2, and a ZIP archive with one file.

use super::read_at::{At, ReadAt};
use bzip2::read::MultiBzDecoder;
use flate2::bufread::GzDecoder;
use flate2::read::DeflateDecoder;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::sync::Arc;
use zip::{CompressionMethod, ZipArchive};

/// First bytes of a frame of Zstandard.
pub(super) const ZSTANDARD: &[u8] = b"\x28\xb5\x2f\xfd";
/// Bytes that are decompressed at once.
const STEP: usize = 1 << 16;
/// Most bytes of a file that is read at several places: they are kept in a temporary file.
const MOST_BYTES: u64 = 1 << 33;

/// How a stream of bytes is compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compression {
    Gzip,
    Zstandard,
    Bzip2,
}

impl Compression {
    /// By the first bytes; `None` where they are the log itself.
    pub(super) fn recognise(start: &[u8]) -> Option<Self> {
        let is_bzip2 = start.starts_with(b"BZh") && start.get(4..10) == Some(b"1AY&SY");
        match start {
            _ if start.starts_with(b"\x1F\x8B") => Some(Self::Gzip),
            _ if start.starts_with(ZSTANDARD) => Some(Self::Zstandard),
            _ => {
                if is_bzip2 {
                    Some(Self::Bzip2)
                } else {
                    None
                }
            }
        }
    }

    /// The bytes of the log.
    pub(super) fn decoder<'a>(self, reader: impl Read + 'a) -> Box<dyn Read + 'a> {
        let reader = BufReader::with_capacity(STEP, reader);
        match self {
            Self::Gzip => Box::new(Gzip { member: Some(GzDecoder::new(reader)) }),
            Self::Zstandard => Box::new(Zstandard::new(reader)),
            Self::Bzip2 => Box::new(MultiBzDecoder::new(reader)),
        }
    }
}

/// The members of gzip, one after the other; zeros at the end, as of a tape or a memory card, are no member.
struct Gzip<R> {
    member: Option<GzDecoder<R>>,
}

impl<R: BufRead> Read for Gzip<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let count = member.read(buffer)?;
            if count > 0 || buffer.is_empty() {
                return Ok(count);
            }
            let Some(mut source) = self.member.take().map(GzDecoder::into_inner) else { break };
            loop {
                let rest = source.fill_buf()?;
                let zeros = rest.iter().take_while(|byte| **byte == 0).count();
                if rest.is_empty() {
                    return Ok(0);
                }
                if zeros < rest.len() {
                    source.consume(zeros);
                    break;
                }
                source.consume(zeros);
            }
            if source.fill_buf()?[0] != 0x1F {
                return Err(io::Error::other("bytes that are no gzip follow the compressed file"));
            }
            self.member = Some(GzDecoder::new(source));
        }
        Ok(0)
    }
}

/// The frames of Zstandard, one after the other.
pub(super) struct Zstandard<R> {
    source: R,
    decoder: FrameDecoder,
    is_begun: bool,
}

impl<R: BufRead> Zstandard<R> {
    pub(super) fn new(source: R) -> Self {
        Self { source, decoder: FrameDecoder::new(), is_begun: false }
    }
}

impl<R: BufRead> Read for Zstandard<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.decoder.can_collect() == 0 {
            if self.is_begun && !self.decoder.is_finished() {
                let step = BlockDecodingStrategy::UptoBytes(STEP);
                self.decoder.decode_blocks(&mut self.source, step).map_err(io::Error::other)?;
                continue;
            }
            if self.source.fill_buf()?.is_empty() {
                return Ok(0);
            }
            match self.decoder.reset(&mut self.source) {
                Ok(()) => self.is_begun = true,
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                    length,
                    ..
                })) => {
                    let frame = &mut (&mut self.source).take(u64::from(length));
                    io::copy(frame, &mut io::sink())?;
                }
                Err(error) => return Err(io::Error::other(error)),
            }
        }
        self.decoder.read(buffer)
    }
}

/// The file of a ZIP archive that has no other one; `None` of another archive or another file.
pub(super) fn single_member(bytes: &Arc<dyn ReadAt>) -> Option<Box<dyn Read>> {
    let mut archive = ZipArchive::new(BufReader::new(At::new(Arc::clone(bytes)))).ok()?;
    let is_file = |name: &String| !name.ends_with('/') && !name.starts_with("__MACOSX/");
    let names = archive.file_names().map(|name| name.map(String::from));
    let names = names.collect::<Result<Vec<String>, _>>().ok()?;
    let mut files = names.iter().filter(|name| is_file(name));
    let (Some(name), None) = (files.next(), files.next()) else { return None };
    let index = archive.index_for_name(name)?;
    let member = archive.by_index_raw(index).ok()?;
    let (method, length) = (member.compression(), member.compressed_size());
    let mut at = At::new(Arc::clone(bytes));
    at.seek(SeekFrom::Start(member.data_start()?)).ok()?;
    let content = BufReader::with_capacity(STEP, at).take(length);
    match method {
        _ if member.encrypted() => None,
        CompressionMethod::Stored => Some(Box::new(content)),
        CompressionMethod::Deflated => Some(Box::new(DeflateDecoder::new(content))),
        _ => None,
    }
}

/// A byte, and what is wrong from there on.
type Damage = (u64, String);

/// The bytes of a log that is read at several places, in a file that ends with the process; what comes before a damage
/// is read as of a file that was cut off there.
pub(super) fn unpacked(mut reader: impl Read) -> io::Result<(Arc<dyn ReadAt>, Option<Damage>)> {
    let mut file = tempfile::tempfile()?;
    let mut buffer = vec![0; STEP];
    let mut size = 0;
    let mut damage = None;
    loop {
        let count = match reader.read(&mut buffer) {
            Ok(0) => break,
            Err(error) if size > 0 => {
                damage = Some((size, error.to_string()));
                break;
            }
            count => count?,
        };
        size += count as u64;
        if size > MOST_BYTES {
            let problem = "more than 8 GiB when decompressed: decompress the file first";
            return Err(io::Error::other(problem));
        }
        file.write_all(&buffer[..count])?;
    }
    Ok((Arc::new(file), damage))
}
