//! What is printed: lines, tables, progress, and the summaries of documents.

pub(crate) mod console;
pub(crate) mod evidence;
pub(crate) mod manoeuvre_summary;
pub(crate) mod multivariable;
pub(crate) mod overview;
pub(crate) mod profile_summary;
pub(crate) mod progress;
pub(crate) mod speed_controller_summary;
