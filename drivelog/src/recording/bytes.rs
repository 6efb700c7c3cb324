//! Where the bytes of a log come from.

use crate::error::Error;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::sync::Arc;

/// Bytes that are read at any place, from several threads at once.
pub trait ReadAt: Send + Sync {
    /// Number of bytes.
    ///
    /// # Errors
    /// What the file system returns.
    fn size(&self) -> io::Result<u64>;

    /// Reads from `offset` on; how many bytes, 0 at the end.
    ///
    /// # Errors
    /// What the file system returns.
    fn read_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<usize>;
}

impl ReadAt for std::fs::File {
    fn size(&self) -> io::Result<u64> {
        Ok(self.metadata()?.len())
    }

    #[cfg(unix)]
    fn read_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<usize> {
        std::os::unix::fs::FileExt::read_at(self, buffer, offset)
    }

    #[cfg(windows)]
    fn read_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<usize> {
        std::os::windows::fs::FileExt::seek_read(self, buffer, offset)
    }
}

impl ReadAt for Vec<u8> {
    fn size(&self) -> io::Result<u64> {
        Ok(self.len() as u64)
    }

    fn read_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<usize> {
        let from = usize::try_from(offset).unwrap_or(usize::MAX).min(self.len());
        Cursor::new(&self[from..]).read(buffer)
    }
}

/// The bytes of a log.
pub enum Bytes<'a> {
    /// Read once, from the first to the last: standard input, a pipe. Text only.
    Stream(Box<dyn Read + 'a>),
    /// Read where they are needed.
    File(Arc<dyn ReadAt>),
}

/// A log file by name and bytes.
pub struct LogFile<'a> {
    /// The file as the caller names it.
    pub name: String,
    /// Its bytes.
    pub bytes: Bytes<'a>,
}

impl std::fmt::Debug for LogFile<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LogFile").field("name", &self.name).finish_non_exhaustive()
    }
}

/// The name and the first bytes of a file, by which its format is recognised.
pub(super) struct Head<'h> {
    #[allow(dead_code)] // for formats without a mark
    pub(super) name: &'h str,
    pub(super) start: &'h [u8],
}

/// Bytes looked at for the format.
const START: u64 = 4096;

impl<'a> LogFile<'a> {
    /// A file whose bytes are here.
    #[must_use]
    pub fn of_bytes(name: &str, bytes: &[u8]) -> Self {
        Self { name: name.into(), bytes: Bytes::File(Arc::new(bytes.to_vec())) }
    }

    /// A file that is read at any place.
    #[must_use]
    pub fn of_file(name: &str, file: impl ReadAt + 'static) -> Self {
        Self { name: name.into(), bytes: Bytes::File(Arc::new(file)) }
    }

    /// A file that is read once, from the first byte to the last.
    #[must_use]
    pub fn of_stream(name: &str, reader: impl Read + 'a) -> Self {
        Self { name: name.into(), bytes: Bytes::Stream(Box::new(reader)) }
    }

    /// The first bytes, which a stream still has afterwards.
    pub(super) fn start(&mut self) -> Result<Vec<u8>, Error> {
        let mut start = Vec::new();
        let reader: &mut dyn Read = match &mut self.bytes {
            Bytes::Stream(reader) => reader,
            Bytes::File(bytes) => &mut At::new(Arc::clone(bytes)),
        };
        reader.take(START).read_to_end(&mut start).map_err(|e| self.failed(&e))?;
        if let Bytes::Stream(reader) = &mut self.bytes {
            let rest = std::mem::replace(reader, Box::new(io::empty()));
            *reader = Box::new(Cursor::new(start.clone()).chain(rest));
        }
        Ok(start)
    }

    /// The bytes in their order.
    pub(super) fn into_reader(self) -> Box<dyn Read + 'a> {
        match self.bytes {
            Bytes::Stream(reader) => reader,
            Bytes::File(bytes) => Box::new(At::new(bytes)),
        }
    }

    /// The bytes of a format that is read at several places.
    #[allow(dead_code)] // used by the formats
    pub(super) fn sought(&self) -> Result<Arc<dyn ReadAt>, Error> {
        match &self.bytes {
            Bytes::File(bytes) => Ok(Arc::clone(bytes)),
            Bytes::Stream(_) => Err(Error::NotSought { file: self.name.clone() }),
        }
    }

    fn failed(&self, error: &io::Error) -> Error {
        Error::Read { file: self.name.clone(), byte: 0, problem: error.to_string() }
    }
}

/// A place in bytes, from which they are read in order.
pub(super) struct At {
    bytes: Arc<dyn ReadAt>,
    offset: u64,
}

impl At {
    pub(super) fn new(bytes: Arc<dyn ReadAt>) -> Self {
        Self { bytes, offset: 0 }
    }
}

impl Read for At {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.bytes.read_at(buffer, self.offset)?;
        self.offset += count as u64;
        Ok(count)
    }
}

impl Seek for At {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let offset = match to {
            SeekFrom::Start(offset) => Some(offset),
            SeekFrom::End(by) => self.bytes.size()?.checked_add_signed(by),
            SeekFrom::Current(by) => self.offset.checked_add_signed(by),
        };
        let before = || io::Error::new(io::ErrorKind::InvalidInput, "before the start");
        self.offset = offset.ok_or_else(before)?;
        Ok(self.offset)
    }
}
