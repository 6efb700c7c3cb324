//! The layer through its C functions, with a small slave and a host that keeps the log.

mod arguments;
mod call_table;
mod host;
mod lifecycle;
mod panics;
mod probe;
mod states;
mod times;
