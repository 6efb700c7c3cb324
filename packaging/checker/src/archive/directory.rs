//! The zip directory (APPNOTE 4.3), and the features of zip that FMI allows.

use crate::finding::{Findings, Location};
use std::ops::Range;
use steerwright_host::Limits;

const END: u32 = 0x0605_4b50;
const CENTRAL: u32 = 0x0201_4b50;
const LOCAL: u32 = 0x0403_4b50;
const ZIP64_LOCATOR: u32 = 0x0706_4b50;
const END_LENGTH: usize = 22;
const CENTRAL_LENGTH: usize = 46;
const LOCAL_LENGTH: usize = 30;

const ENCRYPTED: u16 = 1;
const DESCRIPTOR: u16 = 1 << 3;
const UTF8: u16 = 1 << 11;
const STORED: u16 = 0;
const DEFLATED: u16 = 8;

/// File type bits of a Unix mode, and the types of files and folders.
const TYPE_MASK: u32 = 0o170_000;
const TYPE_FILE: u32 = 0o100_000;
const TYPE_FOLDER: u32 = 0o040_000;

pub(super) struct Record {
    pub(super) name: String,
    pub(super) deflated: bool,
    pub(super) crc: u32,
    pub(super) compressed: u32,
    pub(super) size: u32,
    /// The position of the compressed bytes.
    pub(super) data: Range<usize>,
    /// Whether its bytes are complete and in a form that FMI allows.
    pub(super) is_readable: bool,
}

/// Reads little-endian numbers of the archive; `None` beyond its end.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn get(self, at: usize, length: usize) -> Option<&'a [u8]> {
        self.0.get(at..at.checked_add(length)?)
    }

    fn u16(self, at: usize) -> Option<u16> {
        Some(u16::from_le_bytes(self.get(at, 2)?.try_into().ok()?))
    }

    fn u32(self, at: usize) -> Option<u32> {
        Some(u32::from_le_bytes(self.get(at, 4)?.try_into().ok()?))
    }

    fn size(self, at: usize) -> Option<usize> {
        usize::try_from(self.u32(at)?).ok()
    }
}

/// Reads the directory; `None` if it is unreadable.
pub(super) fn read(bytes: &[u8], limits: &Limits, findings: &mut Findings) -> Option<Vec<Record>> {
    let bytes = Bytes(bytes);
    let report = |findings: &mut Findings, rule, message: String| {
        findings.add(rule, Location::archive(), message);
    };
    let Some(end) = end_of_directory(bytes) else {
        report(findings, "zip-unreadable", "the end of the zip directory is not found".into());
        return None;
    };
    let after_comment = end + END_LENGTH + usize::from(bytes.u16(end + 20)?);
    if after_comment < bytes.0.len() {
        let following = bytes.0.len() - after_comment;
        report(findings, "zip-outside-data", format!("{following} bytes follow the archive"));
    }
    let disks = [bytes.u16(end + 4)?, bytes.u16(end + 6)?];
    let (here, count) = (bytes.u16(end + 8)?, bytes.u16(end + 10)?);
    let (length, offset) = (bytes.size(end + 12)?, bytes.size(end + 16)?);
    let zip64 = end.checked_sub(20).and_then(|at| bytes.u32(at)) == Some(ZIP64_LOCATOR);
    if zip64 || count == u16::MAX || offset == u32::MAX as usize || length == u32::MAX as usize {
        findings.add("zip-version", Location::archive(), "it is a zip64 archive (version 4.5)");
        if !zip64 || count == u16::MAX || offset == u32::MAX as usize {
            return None;
        }
    }
    if disks != [0, 0] || here != count {
        let message = format!("disk {} of {}: the archive is split", disks[0], disks[1]);
        findings.add("zip-split", Location::archive(), message);
        return None;
    }
    let unreadable = |findings: &mut Findings, message| report(findings, "zip-unreadable", message);
    if usize::from(count) > limits.entries {
        let message = format!("{count} entries, more than {}", limits.entries);
        findings.add("not-examined", Location::archive(), message);
        return None;
    }
    // A zip64 end record is between the directory and the end; it is already an error.
    let start = if zip64 { Some(offset) } else { end.checked_sub(length) };
    let Some((start, shift)) = start.and_then(|start| Some((start, start.checked_sub(offset)?)))
    else {
        unreadable(findings, format!("a directory of {length} bytes at {offset} exceeds the file"));
        return None;
    };
    if shift > 0 {
        report(findings, "zip-outside-data", format!("{shift} bytes precede the archive"));
    }
    let mut records = Vec::new();
    let mut at = start;
    for number in 0..count {
        let Some((record, next)) = record(bytes, at, start, shift, findings) else {
            unreadable(
                findings,
                format!("the directory is truncated at entry {number} of {count}"),
            );
            return None;
        };
        records.push(record);
        at = next;
    }
    if at != start + length {
        let message = format!("the directory has {length} bytes, its entries have {}", at - start);
        unreadable(findings, message);
    }
    overlaps(&records, findings);
    Some(records)
}

/// The position of the end record: the last one whose comment fits.
fn end_of_directory(bytes: Bytes<'_>) -> Option<usize> {
    let last = bytes.0.len().checked_sub(END_LENGTH)?;
    let first = last.saturating_sub(usize::from(u16::MAX) * 2);
    (first..=last).rev().find(|&at| {
        let fits = |comment| at + END_LENGTH + usize::from(comment) <= bytes.0.len();
        bytes.u32(at) == Some(END) && bytes.u16(at + 20).is_some_and(fits)
    })
}

/// The entry with the central header at `at`, and the position of the next one.
fn record(
    bytes: Bytes<'_>,
    at: usize,
    directory: usize,
    shift: usize,
    findings: &mut Findings,
) -> Option<(Record, usize)> {
    if bytes.u32(at)? != CENTRAL {
        return None;
    }
    let [made_by, version, flags, method] =
        [bytes.u16(at + 4)?, bytes.u16(at + 6)?, bytes.u16(at + 8)?, bytes.u16(at + 10)?];
    let [crc, compressed, size] = [bytes.u32(at + 16)?, bytes.u32(at + 20)?, bytes.u32(at + 24)?];
    let name_length = usize::from(bytes.u16(at + 28)?);
    let rest = usize::from(bytes.u16(at + 30)?) + usize::from(bytes.u16(at + 32)?);
    let attributes = bytes.u32(at + 38)?;
    let raw = bytes.get(at + CENTRAL_LENGTH, name_length)?;
    let next = at + CENTRAL_LENGTH + name_length + rest;
    bytes.get(at, next - at)?;
    let name = String::from_utf8_lossy(raw).into_owned();
    let mut report = |rule, message: String| findings.add(rule, Location::entry(&name), message);

    let mut is_readable = true;
    if version & 0xff > 20 {
        let (major, minor) = ((version & 0xff) / 10, version % 10);
        report("zip-version", format!("version {major}.{minor} is needed to extract it"));
    }
    if flags & ENCRYPTED != 0 {
        report("zip-encrypted", "it is encrypted".into());
        is_readable = false;
    }
    if !matches!(method, STORED | DEFLATED) {
        report("zip-method", format!("its compression method is {method}"));
        is_readable = false;
    }
    if flags & DESCRIPTOR != 0 && method != DEFLATED {
        report("zip-stored-descriptor", "it is stored, but its sizes follow its data".into());
    }
    if !raw.is_ascii() && (flags & UTF8 == 0 || std::str::from_utf8(raw).is_err()) {
        report("zip-name-encoding", "its name is neither ASCII nor marked as UTF-8".into());
    }
    let is_unix = matches!(made_by >> 8, 3 | 19);
    let kind = (attributes >> 16) & TYPE_MASK;
    if is_unix && !matches!(kind, 0 | TYPE_FILE | TYPE_FOLDER) {
        report("zip-link", "it is a link or a device".into());
        is_readable = false;
    }
    let local = bytes.size(at + 42)?.checked_add(shift)?;
    let data = match local_header(bytes, local, raw, [flags, method], [crc, compressed, size]) {
        Err(problem) => {
            report("zip-local-header", problem.into());
            None
        }
        Ok(start) => {
            let end = start.checked_add(compressed as usize).filter(|end| *end <= directory);
            if end.is_none() {
                report("zip-entry-damaged", format!("its {compressed} bytes are incomplete"));
            }
            end.map(|end| start..end)
        }
    };
    let is_readable = is_readable && data.is_some();
    let data = data.unwrap_or(0..0);
    let deflated = method == DEFLATED;
    Some((Record { name, deflated, crc, compressed, size, data, is_readable }, next))
}

fn local_header(
    bytes: Bytes<'_>,
    at: usize,
    name: &[u8],
    [flags, method]: [u16; 2],
    [crc, compressed, size]: [u32; 3],
) -> Result<usize, &'static str> {
    let read = || {
        let lengths = [bytes.u16(at.checked_add(26)?)?, bytes.u16(at + 28)?].map(usize::from);
        Some((
            bytes.u32(at)?,
            [bytes.u16(at + 6)?, bytes.u16(at + 8)?],
            [bytes.u32(at + 14)?, bytes.u32(at + 18)?, bytes.u32(at + 22)?],
            bytes.get(at + LOCAL_LENGTH, lengths[0])?,
            at + LOCAL_LENGTH + lengths[0] + lengths[1],
        ))
    };
    let Some((signature, local, sizes, local_name, data)) = read() else {
        return Err("its local header is missing");
    };
    if signature != LOCAL {
        return Err("its local header is not at the offset in the directory");
    }
    if local_name != name {
        return Err("its name differs between local header and directory");
    }
    if local != [flags, method] {
        return Err("its method or flags differ between local header and directory");
    }
    if flags & DESCRIPTOR == 0 && sizes != [crc, compressed, size] {
        return Err("its sizes or checksum differ between local header and directory");
    }
    Ok(data)
}

/// Reports entries that share bytes: they multiply the unpacked size at an ordinary compression ratio.
fn overlaps(records: &[Record], findings: &mut Findings) {
    let mut sorted: Vec<&Record> = records.iter().filter(|r| !r.data.is_empty()).collect();
    sorted.sort_by_key(|record| record.data.start);
    for pair in sorted.windows(2) {
        if pair[1].data.start < pair[0].data.end {
            let message = format!("shares bytes with {:?}", pair[0].name);
            findings.add("zip-overlap", Location::entry(&pair[1].name), message);
        }
    }
}
