//! The subcommands, a file or folder each: it decides where it writes, reads, calls a stage, writes and prints.

pub(crate) mod accumulate;
pub(crate) mod bicycle;
pub(crate) mod build;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod demo;
pub(crate) mod design;
pub(crate) mod excite;
pub(crate) mod export;
pub(crate) mod identify;
pub(crate) mod inspect;
pub(crate) mod manual;
pub(crate) mod package;
pub(crate) mod path;
pub(crate) mod simulate;
pub(crate) mod sweep;
