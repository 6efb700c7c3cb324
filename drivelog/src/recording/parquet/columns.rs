//! How the cells of a column of Parquet are read as numbers.

use super::pages::{Source, reader};
use crate::recording::scale::Scale;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::ColumnReader;
use parquet::data_type::AsBytes;
use parquet::errors::{ParquetError, Result as Outcome};
use parquet::file::metadata::ParquetMetaData;
use parquet::schema::types::ColumnDescPtr;
use std::sync::Arc;

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

/// `None` for a column that is repeated or no number.
pub(super) fn scale_of(column: &ColumnDescPtr) -> Option<Scale> {
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
        ) => Some(Scale::Divided(of_unit(&time.unit))),
        (Type::INT32 | Type::INT64, Some(LogicalType::Decimal(decimal))) => {
            Some(Scale::Divided(10_f64.powi(decimal.scale)))
        }
        (Type::INT32 | Type::INT64, Some(LogicalType::Integer(kind))) => {
            Some(Scale::Plain { is_unsigned: !kind.is_signed })
        }
        (Type::INT32 | Type::INT64, None) => Some(of_converted(column)),
        (Type::BOOLEAN | Type::INT32 | Type::INT64 | Type::FLOAT | Type::DOUBLE, _) => {
            Some(Scale::Plain { is_unsigned: false })
        }
        (Type::INT96, _) => Some(Scale::Int96),
        (Type::FIXED_LEN_BYTE_ARRAY, Some(LogicalType::Float16)) => Some(Scale::Half),
        (Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY, Some(LogicalType::Decimal(own))) => {
            Some(Scale::Bytes(10_f64.powi(own.scale)))
        }
        (Type::BYTE_ARRAY, Some(LogicalType::String)) => Some(Scale::Text(None)),
        (Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY, None) => match column.converted_type() {
            ConvertedType::DECIMAL => Some(Scale::Bytes(10_f64.powi(column.type_scale()))),
            ConvertedType::UTF8 => Some(Scale::Text(None)),
            _ => None,
        },
        _ => None,
    }
}

/// By the older statement of an integer's type, which DuckDB writes alone.
fn of_converted(column: &ColumnDescPtr) -> Scale {
    use ConvertedType as Is;
    match column.converted_type() {
        Is::UINT_8 | Is::UINT_16 | Is::UINT_32 | Is::UINT_64 => Scale::Plain { is_unsigned: true },
        Is::TIME_MILLIS | Is::TIMESTAMP_MILLIS => Scale::Divided(1e3),
        Is::TIME_MICROS | Is::TIMESTAMP_MICROS => Scale::Divided(1e6),
        Is::DECIMAL => Scale::Divided(10_f64.powi(column.type_scale())),
        _ => Scale::Plain { is_unsigned: false },
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
                number.unwrap_or_else(|problem| {
                    fault.get_or_insert(ParquetError::General(problem));
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

/// The texts of the first rows of a column that are not null.
pub(super) fn first_texts(
    source: &Arc<Source>,
    metadata: &ParquetMetaData,
    column: usize,
) -> Option<Vec<String>> {
    const ROWS: usize = 1000;
    let filled = metadata.row_groups().iter().position(|group| group.num_rows() > 0)?;
    let opened = reader(source, metadata, filled, column).ok()?;
    let ColumnReader::ByteArrayColumnReader(mut texts) = opened else { return None };
    let mut values = Vec::new();
    texts.read_records(ROWS, Some(&mut Vec::new()), None, &mut values).ok()?;
    Some(values.iter().map(|text| String::from_utf8_lossy(text.data()).into_owned()).collect())
}
