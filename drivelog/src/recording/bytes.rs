//! Where the bytes of a log come from.

use super::compression::{Compression, single_member, unpacked};
use super::read_at::{At, ReadAt};
use crate::Error;
use std::io::{self, Cursor, Read};
use std::sync::Arc;

/// The bytes of a log.
enum Bytes<'a> {
    /// Read once, from the first to the last: standard input, a pipe. Text only.
    Stream(Box<dyn Read + 'a>),
    /// A stream whose first bytes are known, which come again.
    Begun(Vec<u8>, Box<dyn Read + 'a>),
    /// Read where they are needed.
    File(Arc<dyn ReadAt>),
}

/// A log file by name and bytes.
pub struct LogFile<'a> {
    /// The file as the caller names it.
    pub name: String,
    bytes: Bytes<'a>,
}

impl std::fmt::Debug for LogFile<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LogFile").field("name", &self.name).finish_non_exhaustive()
    }
}

/// The first bytes of a file, by which its format is recognised.
pub(super) struct Head<'h> {
    pub(super) start: &'h [u8],
}

/// Bytes looked at for the format.
const START: u64 = 4096;

impl<'a> LogFile<'a> {
    /// A file whose bytes are here.
    #[must_use]
    pub fn of_bytes(name: &str, bytes: &[u8]) -> Self {
        Self::of_file(name, bytes.to_vec())
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

    /// Looks at the first bytes of a stream, which it still has afterwards.
    pub(super) fn look(&mut self) -> Result<(), Error> {
        let Bytes::Stream(reader) = &mut self.bytes else { return Ok(()) };
        let mut reader = std::mem::replace(reader, Box::new(io::empty()));
        let start = first(reader.as_mut()).map_err(|e| self.failed(&e))?;
        let whole = Cursor::new(start.clone()).chain(reader);
        let (start, reader): (Vec<u8>, Box<dyn Read + 'a>) = match Compression::recognise(&start) {
            Some(compression) => {
                let mut text = compression.decoder(whole);
                let start = first(&mut text).map_err(|e| self.failed(&e))?;
                (start.clone(), Box::new(Cursor::new(start).chain(text)))
            }
            None => (start, Box::new(whole)),
        };
        self.bytes = Bytes::Begun(start, reader);
        Ok(())
    }

    /// The first bytes, of a compressed file those of its content.
    pub(super) fn head(&self) -> Result<Vec<u8>, Error> {
        match &self.bytes {
            Bytes::Stream(_) => Ok(Vec::new()),
            Bytes::Begun(start, _) => Ok(start.clone()),
            Bytes::File(_) => first(self.reader()?.as_mut()).map_err(|e| self.failed(&e)),
        }
    }

    /// The bytes in their order, of a compressed file those of its content.
    pub(super) fn into_reader(self) -> Result<Box<dyn Read + 'a>, Error> {
        match self.bytes {
            Bytes::Stream(reader) | Bytes::Begun(_, reader) => Ok(reader),
            Bytes::File(_) => self.reader(),
        }
    }

    /// The same of a text that is read several times.
    pub(super) fn reader(&self) -> Result<Box<dyn Read>, Error> {
        let bytes = self.sought()?;
        Ok(self.content(&bytes)?.unwrap_or_else(|| Box::new(At::new(bytes))))
    }

    /// Unpacks a compressed file, so that it is read at any place; where it is damaged, at which byte of its content and how.
    pub(super) fn unpack(&mut self) -> Result<Option<(u64, String)>, Error> {
        let Bytes::File(bytes) = &self.bytes else { return Ok(None) };
        let Some(content) = self.content(bytes)? else { return Ok(None) };
        let (bytes, damage) = unpacked(content).map_err(|e| self.failed(&e))?;
        self.bytes = Bytes::File(bytes);
        Ok(damage)
    }

    /// What a compressed file contains; `None` of one that is not compressed.
    fn content(&self, bytes: &Arc<dyn ReadAt>) -> Result<Option<Box<dyn Read>>, Error> {
        let start = first(&mut At::new(Arc::clone(bytes))).map_err(|e| self.failed(&e))?;
        if start.starts_with(b"PK\x03\x04") {
            return Ok(single_member(bytes));
        }
        let compression = Compression::recognise(&start);
        Ok(compression.map(|own| own.decoder(At::new(Arc::clone(bytes)))))
    }

    /// The bytes as they are, read at any place.
    pub(super) fn sought(&self) -> Result<Arc<dyn ReadAt>, Error> {
        match &self.bytes {
            Bytes::File(bytes) => Ok(Arc::clone(bytes)),
            _ => Err(Error::NotSought { file: self.name.clone() }),
        }
    }

    fn failed(&self, error: &io::Error) -> Error {
        Error::Read { file: self.name.clone(), byte: 0, problem: error.to_string() }
    }
}

fn first(reader: &mut dyn Read) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    match reader.take(START).read_to_end(&mut start) {
        // What comes before the damage decides the format.
        Err(error) if start.is_empty() => Err(error),
        _ => Ok(start),
    }
}
