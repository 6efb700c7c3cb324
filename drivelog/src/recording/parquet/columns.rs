//! How the cells of a column are read as numbers.

use super::pages::{Source, reader};
use crate::recording::csv::stamps::Stamps;
use crate::recording::half::half;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::ColumnReader;
use parquet::data_type::AsBytes;
use parquet::errors::{ParquetError, Result as Outcome};
use parquet::file::metadata::ParquetMetaData;
use parquet::schema::types::ColumnDescPtr;
use std::sync::Arc;

/// Most characters of a cell in a message.
const MOST_QUOTED: usize = 80;

/// How the numbers of a column are read.
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

pub(super) fn is_time(column: &ColumnDescPtr) -> bool {
    use ConvertedType::{TIME_MICROS, TIME_MILLIS, TIMESTAMP_MICROS, TIMESTAMP_MILLIS};
    match column.logical_type_ref() {
        Some(kind) => matches!(kind, LogicalType::Timestamp(_) | LogicalType::Time(_)),
        None => matches!(
            column.converted_type(),
            TIME_MICROS | TIME_MILLIS | TIMESTAMP_MICROS | TIMESTAMP_MILLIS
        ),
    }
}

impl Scale {
    pub(super) const INTEGER: Self = Self::Plain { is_unsigned: false };

    /// `None` for a column that is repeated or no number.
    pub(super) fn of(column: &ColumnDescPtr) -> Option<Self> {
        if column.max_rep_level() > 0 {
            return None;
        }
        let of_unit = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1e3,
            TimeUnit::MICROS => 1e6,
            TimeUnit::NANOS => 1e9,
        };
        match (column.physical_type(), column.logical_type_ref()) {
            (
                Type::INT32 | Type::INT64,
                Some(LogicalType::Timestamp(time) | LogicalType::Time(time)),
            ) => Some(Self::Divided(of_unit(&time.unit))),
            (Type::INT32 | Type::INT64, Some(LogicalType::Decimal(decimal))) => {
                Some(Self::Divided(10_f64.powi(decimal.scale)))
            }
            (Type::INT32 | Type::INT64, Some(LogicalType::Integer(kind))) => {
                Some(Self::Plain { is_unsigned: !kind.is_signed })
            }
            (Type::INT32 | Type::INT64, None) => Some(Self::of_converted(column)),
            (Type::BOOLEAN | Type::INT32 | Type::INT64 | Type::FLOAT | Type::DOUBLE, _) => {
                Some(Self::Plain { is_unsigned: false })
            }
            (Type::INT96, _) => Some(Self::Int96),
            (Type::FIXED_LEN_BYTE_ARRAY, Some(LogicalType::Float16)) => Some(Self::Half),
            (Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY, Some(LogicalType::Decimal(own))) => {
                Some(Self::Bytes(10_f64.powi(own.scale)))
            }
            (Type::BYTE_ARRAY, Some(LogicalType::String)) => Some(Self::Text(None)),
            (Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY, None) => {
                match column.converted_type() {
                    ConvertedType::DECIMAL => Some(Self::Bytes(10_f64.powi(column.type_scale()))),
                    ConvertedType::UTF8 => Some(Self::Text(None)),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// The number of a cell of bytes.
    fn of_bytes(&mut self, cell: &[u8]) -> Outcome<f64> {
        Ok(match self {
            Self::Half => half(u16::from_le_bytes(cell.try_into().unwrap_or_default())),
            Self::Bytes(by) => {
                let sign =
                    if cell.first().is_some_and(|byte| byte & 0x80 != 0) { -1.0 } else { 0.0 };
                cell.iter().fold(sign, |x, byte| 256.0 * x + f64::from(*byte)) / *by
            }
            Self::Text(Some(stamps)) => {
                let text = String::from_utf8_lossy(cell);
                let shown = || text.chars().take(MOST_QUOTED).collect::<String>();
                let seconds = stamps.seconds(text.trim());
                seconds.ok_or_else(|| ParquetError::General(format!("`{}` is no time", shown())))?
            }
            _ => f64::NAN,
        })
    }

    /// By the older statement of an integer's type, which DuckDB writes alone.
    fn of_converted(column: &ColumnDescPtr) -> Self {
        use ConvertedType as Is;
        match column.converted_type() {
            Is::UINT_8 | Is::UINT_16 | Is::UINT_32 | Is::UINT_64 => {
                Self::Plain { is_unsigned: true }
            }
            Is::TIME_MILLIS | Is::TIMESTAMP_MILLIS => Self::Divided(1e3),
            Is::TIME_MICROS | Is::TIMESTAMP_MICROS => Self::Divided(1e6),
            Is::DECIMAL => Self::Divided(10_f64.powi(column.type_scale())),
            _ => Self::Plain { is_unsigned: false },
        }
    }

    pub(super) fn of_integer(self, x: i64, bits: u32) -> f64 {
        match self {
            Self::Plain { is_unsigned: true } if bits == 32 => f64::from(x as u32),
            Self::Plain { is_unsigned: true } => x as u64 as f64,
            Self::Divided(by) => x as f64 / by,
            _ => x as f64,
        }
    }
}

/// Reads the values of so many rows; null is NaN.
pub(super) fn read(reader: &mut ColumnReader, scale: &mut Scale, most: usize) -> Outcome<Vec<f64>> {
    macro_rules! numbers {
        ($reader:expr, $number:expr) => {{
            let (mut values, mut levels) = (Vec::new(), Vec::new());
            let (rows, ..) = $reader.read_records(most, Some(&mut levels), None, &mut values)?;
            let mut numbers = values.iter().map($number);
            if levels.is_empty() {
                numbers.collect()
            } else {
                // A value is there at the highest level.
                let top = levels.iter().copied().max().unwrap_or_default();
                let is_there = |level: &i16| *level == top && values.len() > 0;
                let all = levels.iter().map(|level| match is_there(level) {
                    true => numbers.next().unwrap_or(f64::NAN),
                    false => f64::NAN,
                });
                all.take(rows).collect::<Vec<f64>>()
            }
        }};
    }
    macro_rules! bytes {
        ($reader:expr) => {{
            let mut fault = None;
            let number = |cell: &_| {
                let cell: &[u8] = AsBytes::as_bytes(cell);
                let number = scale.of_bytes(cell);
                number.unwrap_or_else(|error| {
                    fault.get_or_insert(error);
                    f64::NAN
                })
            };
            let numbers = numbers!($reader, number);
            if let Some(error) = fault {
                return Err(error);
            }
            numbers
        }};
    }
    Ok(match reader {
        ColumnReader::BoolColumnReader(r) => numbers!(r, |x| f64::from(u8::from(*x))),
        ColumnReader::Int32ColumnReader(r) => numbers!(r, |x| scale.of_integer(i64::from(*x), 32)),
        ColumnReader::Int64ColumnReader(r) => numbers!(r, |x| scale.of_integer(*x, 64)),
        ColumnReader::FloatColumnReader(r) => numbers!(r, |x| f64::from(*x)),
        ColumnReader::DoubleColumnReader(r) => numbers!(r, |x| *x),
        ColumnReader::Int96ColumnReader(r) => numbers!(r, |x| x.to_nanos() as f64 / 1e9),
        ColumnReader::ByteArrayColumnReader(r) => bytes!(r),
        ColumnReader::FixedLenByteArrayColumnReader(r) => bytes!(r),
    })
}

/// The first text of a column that is not null, among the first rows.
pub(super) fn first_text(
    source: &Arc<Source>,
    metadata: &ParquetMetaData,
    column: usize,
) -> Option<String> {
    const ROWS: usize = 1000;
    let filled = metadata.row_groups().iter().position(|group| group.num_rows() > 0)?;
    let opened = reader(source, metadata, filled, column).ok()?;
    let ColumnReader::ByteArrayColumnReader(mut texts) = opened else { return None };
    let mut values = Vec::new();
    texts.read_records(ROWS, Some(&mut Vec::new()), None, &mut values).ok()?;
    Some(String::from_utf8_lossy(values.first()?.data()).into_owned())
}
