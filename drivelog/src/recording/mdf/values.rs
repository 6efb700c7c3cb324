//! Values of signals, and where errors are.

use crate::recording::half::half;
use falcon_mdf::Channel;
use falcon_mdf::blocks::DataType;
use falcon_mdf::error::Mf4Error;
use falcon_mdf::model::{Signal, ValueKind};

/// Whether the values have 16 bits, which the library reads as 0.
fn is_half(channel: &Channel) -> bool {
    channel.is_float() && channel.bit_count == 16
}

/// The channel as the library reads it: numbers of 16 bits by their bits.
pub(super) fn readable(channel: &Channel) -> Channel {
    let mut own = channel.clone();
    if is_half(channel) {
        let is_little = channel.is_little_endian();
        own.data_type = if is_little { DataType::UIntLe } else { DataType::UIntBe };
    }
    own
}

/// Physical values of a channel; invalid ones are missing, and of a number with a text the number.
pub(super) fn numbers(channel: &Channel, signal: &Signal) -> Vec<f64> {
    let values = match signal.channel().value_kind() {
        _ if is_half(channel) => signal.raw_values(),
        ValueKind::Str => signal.raw_values(),
        _ => signal.values(),
    };
    let mut values = values.map_or_else(|_| Vec::new(), |values| values.to_f64());
    if is_half(channel) {
        values.iter_mut().for_each(|x| *x = channel.convert(half(*x as u16)));
    }
    values.resize(signal.len(), f64::NAN);
    if let Some(valid) = signal.validity() {
        values.iter_mut().zip(valid).filter(|(_, is)| !is).for_each(|(x, _)| *x = f64::NAN);
    }
    values
}

pub(super) fn damaged<T>() -> Result<T, Mf4Error> {
    Err(Mf4Error::parse_error("the bytes are damaged"))
}

/// The byte that an error names.
pub(super) fn place(error: &Mf4Error) -> u64 {
    match error {
        Mf4Error::TruncatedFile { offset, .. }
        | Mf4Error::MissingBlock { offset, .. }
        | Mf4Error::InvalidBlockId { offset, .. } => *offset,
        _ => 0,
    }
}
