//! Changes of an archive's own bytes.

/// The position of the first signature.
pub(super) fn find(bytes: &[u8], signature: &[u8]) -> usize {
    bytes.windows(signature.len()).position(|window| window == signature).unwrap()
}

fn rfind(bytes: &[u8], signature: &[u8]) -> usize {
    bytes.windows(signature.len()).rposition(|window| window == signature).unwrap()
}

/// Writes into the local header of the first entry and into its header in the directory.
pub(super) fn on_first(bytes: &mut [u8], local: usize, central: usize, value: &[u8]) {
    let (l, c) = (find(bytes, b"PK\x03\x04") + local, find(bytes, b"PK\x01\x02") + central);
    bytes[l..l + value.len()].copy_from_slice(value);
    bytes[c..c + value.len()].copy_from_slice(value);
}

/// The same for the last entry.
pub(super) fn on_last(bytes: &mut [u8], local: usize, central: usize, value: &[u8]) {
    let (l, c) = (rfind(bytes, b"PK\x03\x04") + local, rfind(bytes, b"PK\x01\x02") + central);
    bytes[l..l + value.len()].copy_from_slice(value);
    bytes[c..c + value.len()].copy_from_slice(value);
}

pub(super) fn on_last_central(bytes: &mut [u8], central: usize, value: &[u8]) {
    let c = rfind(bytes, b"PK\x01\x02") + central;
    bytes[c..c + value.len()].copy_from_slice(value);
}
