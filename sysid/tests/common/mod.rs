//! The repository's recordings, for the tests.
#![allow(clippy::unwrap_used, clippy::panic)]
#![allow(dead_code)] // each test binary uses a part of it

/// A file of the repository's test data.
pub(crate) fn data(path: &str) -> Vec<u8> {
    let path = format!("{}/../tests/data/{path}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}
