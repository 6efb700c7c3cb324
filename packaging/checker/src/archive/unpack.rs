//! Unpacking an entry, never beyond the size it promises.

use super::directory::Record;
use flate2::read::DeflateDecoder;
use std::io::Read;

/// Reads an entry through and holds it against its size and checksum.
pub(super) fn verify(record: &Record, bytes: &[u8]) -> Result<(), String> {
    let mut hasher = crc32fast::Hasher::new();
    let mut count = 0_u64;
    let mut buffer = vec![0; 64 << 10];
    let mut reader = reader(record, bytes);
    loop {
        let n = reader.read(&mut buffer).map_err(|e| format!("it cannot be unpacked: {e}"))?;
        if n == 0 {
            break;
        }
        count += n as u64;
        hasher.update(&buffer[..n]);
    }
    if count != u64::from(record.size) {
        let more = if count > u64::from(record.size) { "more" } else { "only" };
        let shown = count.min(u64::from(record.size) + 1);
        return Err(format!("it promises {} bytes and has {more}: {shown}", record.size));
    }
    if hasher.finalize() != record.crc {
        return Err("its checksum is another than the directory's".into());
    }
    Ok(())
}

/// The bytes of an entry that was verified.
pub(super) fn contents(record: &Record, bytes: &[u8]) -> Option<Vec<u8>> {
    let mut contents = Vec::new();
    reader(record, bytes).read_to_end(&mut contents).ok()?;
    Some(contents)
}

/// The unpacked bytes, at most one more than promised.
fn reader<'a>(record: &Record, bytes: &'a [u8]) -> impl Read + use<'a> {
    let data = bytes.get(record.data.clone()).unwrap_or_default();
    let limit = u64::from(record.size) + 1;
    let unpacked: Box<dyn Read + 'a> =
        if record.deflated { Box::new(DeflateDecoder::new(data)) } else { Box::new(data) };
    unpacked.take(limit)
}
