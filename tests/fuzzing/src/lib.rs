//! The fuzzing targets: each is a function of bytes that must return for any bytes.
//!
//! The functions stand here, and not in the fuzzer's own programs under `fuzz/`, so that the
//! corpora and all that was ever found run as ordinary tests (`tests/corpora.rs`) on a stable
//! compiler. `cargo xtask fuzz` runs the fuzzer itself.

mod archives;
#[allow(unsafe_code)]
mod calls;
mod cursor;
mod documents;
mod logs;
mod model_files;
mod resource_uris;

/// A target: panics where a promise is broken.
pub type Target = fn(&[u8]);

/// Every target by its name, which is also its corpus' folder.
pub const TARGETS: [(&str, Target); 8] = [
    ("model_files", model_files::model_files),
    ("resource_uris", resource_uris::resource_uris),
    ("archives", archives::archives),
    ("calls", calls::calls),
    ("logs", logs::logs),
    ("databases", logs::databases),
    ("tables", logs::tables),
    ("definitions", logs::definitions),
];

/// The target of that name.
#[must_use]
pub fn target(name: &str) -> Option<Target> {
    TARGETS.iter().find(|(known, _)| *known == name).map(|(_, target)| *target)
}
