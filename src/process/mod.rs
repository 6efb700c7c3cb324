//! Processes of this program: the one that runs FMUs, and how it is started.

pub(crate) mod guard;
pub(crate) mod program;
