//! What is printed: lines, tables, progress, and the summaries of documents.

pub(crate) mod console;
pub(crate) mod overview;
pub(crate) mod profile_summary;
pub(crate) mod progress;
