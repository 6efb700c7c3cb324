//! How the cells of a column of Parquet or Arrow are read as numbers.

use super::Channel;
use super::csv::missing::is_missing;
use super::csv::stamps::Stamps;
use super::half::half;
use crate::error::shortened;

/// How the cells of a column are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scale {
    /// As they are, unsigned where it says so.
    Plain { is_unsigned: bool },
    /// Divided by a power of ten: times and decimals.
    Divided(f64),
    /// Days and nanoseconds of a day.
    Int96,
    /// Of 16 bits.
    Half,
    /// Integers of any length, divided by a power of ten: decimals.
    Bytes(f64),
    /// Texts; times as CSV has them, once the first is known to be one.
    Text(Option<Stamps>),
}

impl Scale {
    pub(super) const INTEGER: Self = Self::Plain { is_unsigned: false };

    /// The number of a cell of bytes, or what is wrong.
    pub(super) fn of_bytes(&mut self, cell: &[u8]) -> Result<f64, String> {
        Ok(match self {
            Self::Half => half(u16::from_le_bytes(cell.try_into().unwrap_or_default())),
            Self::Bytes(by) => {
                let sign =
                    if cell.first().is_some_and(|byte| byte & 0x80 != 0) { -1.0 } else { 0.0 };
                cell.iter().fold(sign, |x, byte| 256.0 * x + f64::from(*byte)) / *by
            }
            Self::Text(Some(stamps)) => {
                let text = String::from_utf8_lossy(cell);
                let text = text.trim();
                match stamps.seconds(text) {
                    Some(seconds) => seconds,
                    None if is_missing(text) => f64::NAN,
                    None => return Err(format!("`{}` is no time", shortened(text))),
                }
            }
            _ => f64::NAN,
        })
    }

    pub(super) fn of_integer(self, x: i64, bits: u32) -> f64 {
        match self {
            Self::Plain { is_unsigned: true } if bits == 32 => f64::from(x as u32),
            Self::Plain { is_unsigned: true } => x as u64 as f64,
            Self::Divided(by) => x as f64 / by,
            _ => x as f64,
        }
    }

    /// Of texts that begin with these, of which the first that is not missing decides.
    pub(super) fn of_texts(texts: impl IntoIterator<Item = impl AsRef<str>>) -> Self {
        let mut texts = texts.into_iter();
        let first = texts.find(|text| !is_missing(text.as_ref().trim()));
        Self::Text(first.and_then(|text| Stamps::like(text.as_ref().trim())))
    }

    /// The channel of a column of that name; `is_time` where its type is a time.
    pub(super) fn channel(self, name: &str, is_time: bool) -> Channel {
        let mut channel = Channel::new(name, if is_time { Some("s") } else { None });
        channel.has_stamps = is_time || matches!(self, Self::Int96 | Self::Text(Some(_)));
        channel.is_text = self == Self::Text(None);
        channel
    }
}
