//! The bytes of a measurement, of which the last block of samples may be cut off.

use crate::recording::read_at::ReadAt;
use falcon_mdf::error::Mf4Error;
use falcon_mdf::io::{ByteSlice, ByteSource};
use std::sync::{Arc, OnceLock};

/// Our bytes as the library reads them.
#[derive(Clone)]
pub(super) struct Source {
    pub(super) bytes: Arc<dyn ReadAt>,
    pub(super) size: u64,
    /// The block of samples that the file ends in.
    pub(super) cut: Arc<OnceLock<u64>>,
}

impl Source {
    /// States the length that is there in the header of a data block in which the file ends.
    fn shorten(&self, offset: u64, bytes: &mut [u8]) {
        const LENGTH: std::ops::Range<usize> = 8..16;
        let is_data = [b"##DT", b"##DV", b"##SD"].iter().any(|kind| bytes.starts_with(*kind));
        if let Some(length) = bytes.get_mut(LENGTH).filter(|_| is_data) {
            let left = (self.size - offset).to_le_bytes();
            if u64::from_le_bytes(left) < length.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b))
            {
                length.copy_from_slice(&left);
                let _ = self.cut.set(offset);
            }
        }
    }
}

/// The place of the number of the version in the file, and the last one that the library knows.
const VERSION: std::ops::Range<u64> = 28..30;
const KNOWN: u16 = 420;

/// States the last version that is known in place of a later one of MDF 4, of which blocks that are not known are
/// faults of their own.
fn state_known_version(offset: u64, bytes: &mut [u8]) {
    let place = |at: u64| usize::try_from(at.checked_sub(offset)?).ok();
    let Some(range) = place(VERSION.start).zip(place(VERSION.end)) else { return };
    let Some(version) = bytes.get_mut(range.0..range.1) else { return };
    if (KNOWN + 1..500).contains(&u16::from_le_bytes([version[0], version[1]])) {
        version.copy_from_slice(&KNOWN.to_le_bytes());
    }
}

impl ByteSource for Source {
    fn len(&self) -> u64 {
        self.size
    }

    fn read_bytes(&self, offset: u64, len: usize) -> Result<ByteSlice<'_>, Mf4Error> {
        let left = usize::try_from(self.size.saturating_sub(offset)).unwrap_or(usize::MAX);
        if len > left {
            return Err(Mf4Error::truncated(offset, len, left));
        }
        let mut buffer = vec![0; len];
        let mut at = 0;
        while at < len {
            match self.bytes.read_at(&mut buffer[at..], offset + at as u64)? {
                0 => return Err(Mf4Error::truncated(offset, len, at)),
                count => at += count,
            }
        }
        state_known_version(offset, &mut buffer);
        self.shorten(offset, &mut buffer);
        Ok(ByteSlice::owned(buffer))
    }
}
