//! The layer through its C functions, with small units and hosts that keep the log.

mod arguments;
mod call_table;
mod derivatives;
mod everywhere;
mod exposed;
mod host;
mod lifecycle;
mod logging;
mod panics;
mod plant;
mod probe;
mod serialized;
mod states;
mod times;
