//! Parquet: flat columns of numbers, a row group at a time.
//!
//! Codecs are Snappy, LZ4, gzip, Brotli and Zstandard, all in Rust. Times and timestamps are read as seconds,
//! timestamps as seconds since 1970. Null is a missing value; repeated columns are not listed.

use super::bytes::{At, Head, LogFile, ReadAt};
use super::{Channel, Columns, Group, Pieces, Recording, Request, Rows, Wanted, contained};
use crate::Error;
use crate::options::LogOptions;
use crate::role::Role;
use crate::units::{Quantity, unit_of_header};
use bytes::Bytes;
use parquet::basic::{Compression, ConvertedType, Encoding, LogicalType, TimeUnit, Type};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::column::reader::{ColumnReader, get_column_reader};
use parquet::errors::{ParquetError, Result as Outcome};
use parquet::file::metadata::{ParquetMetaData, RowGroupMetaData};
use parquet::file::reader::{ChunkReader, FileReader, Length, SerializedFileReader};
use parquet::file::serialized_reader::SerializedPageReader;
use parquet::file::statistics::Statistics;
use parquet::schema::types::ColumnDescPtr;
use std::io::{Read, Seek, SeekFrom};
use std::rc::Rc;
use std::sync::Arc;

/// A page is never larger, bytes.
const LARGEST_PAGE: u64 = 1 << 30;

pub(super) fn recognises(head: &Head<'_>) -> bool {
    head.start.starts_with(b"PAR1")
}

/// Opens a table; reads its footer.
pub(super) fn open<'a>(
    file: LogFile<'a>,
    _: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    let bytes = file.sought()?;
    let failed = |byte, problem: String| Error::Read { file: file.name.clone(), byte, problem };
    let size = bytes.size().map_err(|e| failed(0, e.to_string()))?;
    let source = Source { bytes, size };
    let reader = contained(|| SerializedFileReader::new(source.clone())).unwrap_or_else(damaged);
    let reader = reader.map_err(|e| failed(size.saturating_sub(8), e.to_string()))?;
    let metadata = reader.metadata().clone();
    check(&metadata, size).map_err(|problem| failed(size.saturating_sub(8), problem))?;
    let (mut channels, mut columns) = (Vec::new(), Vec::new());
    for (k, column) in metadata.file_metadata().schema_descr().columns().iter().enumerate() {
        if let Some(scale) = Scale::of(column) {
            let seconds = matches!(scale, Scale::Divided(_) if is_time(column));
            let name = column.path().string();
            let mut channel = Channel::new(&name, seconds.then_some("s"));
            channel.has_stamps = seconds || scale == Scale::Int96;
            channels.push(channel);
            columns.push((k, scale));
        }
    }
    if channels.is_empty() {
        return Err(failed(0, "no column has numbers".into()));
    }
    let mut group = Group::new(&file.name, "", channels);
    group.rows = u64::try_from(metadata.file_metadata().num_rows()).ok();
    let name = file.name;
    Ok(Box::new(Table {
        name,
        source: Arc::new(source),
        metadata,
        groups: [group],
        columns,
        losses: Vec::new(),
    }))
}

/// The library takes for granted that the places of a footer are in the file.
fn check(metadata: &ParquetMetaData, size: u64) -> Result<(), String> {
    for group in metadata.row_groups() {
        if group.num_rows() < 0 {
            return Err(format!("a row group of {} rows", group.num_rows()));
        }
        for column in group.columns() {
            let from = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
            let place = u64::try_from(from).ok().zip(u64::try_from(column.compressed_size()).ok());
            let end = place.and_then(|(from, length)| from.checked_add(length));
            if end.is_none_or(|end| end > size) || column.data_page_offset() < 0 {
                return Err(format!("column `{}` is not within the file", column.column_path()));
            }
        }
    }
    Ok(())
}

struct Table {
    name: String,
    source: Arc<Source>,
    metadata: ParquetMetaData,
    groups: [Group; 1],
    /// Column of the file of each channel.
    columns: Vec<(usize, Scale)>,
    losses: Vec<String>,
}

/// How the numbers of a column are read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scale {
    /// As they are, unsigned where it says so.
    Plain { is_unsigned: bool },
    /// Divided by a power of ten: times and decimals.
    Divided(f64),
    /// Days and nanoseconds of a day.
    Int96,
}

fn is_time(column: &ColumnDescPtr) -> bool {
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
    /// `None` for a column that is repeated or no number.
    fn of(column: &ColumnDescPtr) -> Option<Self> {
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
            (Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY, _) => None,
        }
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

    fn of_integer(self, x: i64, bits: u32) -> f64 {
        match self {
            Self::Plain { is_unsigned: true } if bits == 32 => f64::from(x as u32),
            Self::Plain { is_unsigned: true } => x as u64 as f64,
            Self::Divided(by) => x as f64 / by,
            _ => x as f64,
        }
    }
}

impl Table {
    /// Whether the rows of a row group may be in the window, by the statistics of the clock.
    fn is_within(
        clock: Option<(usize, Scale, f64)>,
        group: &RowGroupMetaData,
        window_s: Option<(f64, f64)>,
    ) -> bool {
        let (Some(clock), Some((from, to))) = (clock, window_s) else { return true };
        Self::span(clock, group).is_none_or(|(first, last)| last >= from && first <= to)
    }

    /// The least and the largest instant of a row group by its statistics, s.
    fn span(
        (column, scale, seconds): (usize, Scale, f64),
        group: &RowGroupMetaData,
    ) -> Option<(f64, f64)> {
        let range = group.column(column).statistics().and_then(|statistics| match statistics {
            Statistics::Int32(s) => {
                let of = |x: &i32| scale.of_integer(i64::from(*x), 32);
                Some((of(s.min_opt()?), of(s.max_opt()?)))
            }
            Statistics::Int64(s) => {
                let of = |x: &i64| scale.of_integer(*x, 64);
                Some((of(s.min_opt()?), of(s.max_opt()?)))
            }
            Statistics::Float(s) => Some((f64::from(*s.min_opt()?), f64::from(*s.max_opt()?))),
            Statistics::Double(s) => Some((*s.min_opt()?, *s.max_opt()?)),
            _ => None,
        });
        range.map(|(least, most)| (least * seconds, most * seconds))
    }

    /// The column of the clock, and its unit in s: the first of those wanted, if it is one.
    fn clock(&self, channels: &[usize]) -> Option<(usize, Scale, f64)> {
        let first = *channels.first()?;
        let channel = &self.groups[0].channels[first];
        let (column, scale) = self.columns[first];
        let unit = unit_of_header(&channel.name).filter(|u| u.quantity == Quantity::Time);
        let seconds = match unit {
            _ if channel.has_stamps => 1.0,
            Some(unit) if channel.may_be(Role::Time) => unit.to_si,
            _ => return None,
        };
        Some((column, scale, seconds))
    }
}

impl Recording for Table {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn first_s(&self, wanted: &Wanted) -> Option<f64> {
        let clock = self.clock(&wanted.channels)?;
        let first = |group: &RowGroupMetaData| Some(Self::span(clock, group)?.0);
        // Without statistics of all row groups the first may be earlier.
        let all = self.metadata.row_groups().iter().map(first);
        all.collect::<Option<Vec<_>>>()?.into_iter().reduce(f64::min)
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let Some(wanted) = request.wanted.first() else { return Ok(Box::new(std::iter::empty())) };
        let clock = self.clock(&wanted.channels);
        let Self { name, source, metadata, columns, losses, .. } = self;
        let metadata: &ParquetMetaData = metadata;
        let own: Vec<(usize, Scale)> = wanted.channels.iter().map(|&c| columns[c]).collect();
        let mut groups = metadata.row_groups().iter().enumerate();
        let mut group = None;
        let mut readers: Vec<(ColumnReader, Scale)> = Vec::new();
        let (mut row, mut end) = (0_u64, 0_u64);
        Ok(Box::new(std::iter::from_fn(move || {
            loop {
                if row >= end {
                    let (k, next) = groups.next()?;
                    group = Some(next);
                    (row, end) = (end, end + u64::try_from(next.num_rows()).unwrap_or_default());
                    if !Self::is_within(clock, next, request.window_s) {
                        row = end;
                        continue;
                    }
                    let open = |(c, scale): &(usize, Scale)| {
                        let opened = contained(|| reader(source, metadata, k, *c));
                        Ok((opened.unwrap_or_else(damaged)?, *scale))
                    };
                    match own.iter().map(open).collect::<Outcome<Vec<_>>>() {
                        Ok(opened) => readers = opened,
                        Err(error) => {
                            losses.push(lost(name, next, end - row, &error));
                            row = end;
                            continue;
                        }
                    }
                }
                let most = request.most.min(usize::try_from(end - row).unwrap_or(usize::MAX));
                let values = readers.iter_mut().map(|(reader, scale)| {
                    contained(|| read(reader, *scale, most)).unwrap_or_else(damaged)
                });
                let (mut values, fault) = match values.collect::<Outcome<Vec<Vec<f64>>>>() {
                    Ok(values) => (values, ParquetError::EOF("no more values".into())),
                    Err(error) => (vec![Vec::new(); own.len()], error),
                };
                let count = values.iter().map(Vec::len).min().unwrap_or(most);
                values.iter_mut().for_each(|v| v.truncate(count));
                let lines = Rc::new((row + 1..=row + count as u64).collect());
                row += count as u64;
                // Columns that end before the others leave no row whole.
                if count < most {
                    losses.extend(group.map(|group| lost(name, group, end - row, &fault)));
                    row = end;
                }
                if count > 0 {
                    return Some(Ok(Rows { wanted: 0, columns: Columns { values, lines } }));
                }
            }
        })))
    }

    fn losses(&self) -> Vec<String> {
        self.losses.clone()
    }
}

fn damaged<T>() -> Outcome<T> {
    Err(ParquetError::General("the bytes are damaged".into()))
}

fn lost(name: &str, group: &RowGroupMetaData, rows: u64, error: &ParquetError) -> String {
    let byte = group.file_offset().unwrap_or_else(|| group.column(0).byte_range().0 as i64);
    format!("{name}: {rows} rows of the row group at byte {byte} are not read: {error}")
}

/// The reader of a column of a row group.
fn reader(
    source: &Arc<Source>,
    metadata: &ParquetMetaData,
    group: usize,
    column: usize,
) -> Outcome<ColumnReader> {
    let group = metadata.row_group(group);
    let chunk = group.column(column);
    let is_zstd = matches!(chunk.compression(), Compression::ZSTD(_));
    // The pages come as they are, and are decompressed here.
    let plain = is_zstd
        .then(|| chunk.clone().into_builder().set_compression(Compression::UNCOMPRESSED).build());
    let plain = plain.transpose()?;
    let rows = usize::try_from(group.num_rows())?;
    let pages =
        SerializedPageReader::new(Arc::clone(source), plain.as_ref().unwrap_or(chunk), rows, None)?;
    let pages = Pages { inner: Box::new(pages), is_zstd, has_dictionary: false };
    Ok(get_column_reader(chunk.column_descr_ptr(), Box::new(pages)))
}

/// Reads the values of so many rows; null is NaN.
fn read(reader: &mut ColumnReader, scale: Scale, most: usize) -> Outcome<Vec<f64>> {
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
    Ok(match reader {
        ColumnReader::BoolColumnReader(r) => numbers!(r, |x| f64::from(u8::from(*x))),
        ColumnReader::Int32ColumnReader(r) => numbers!(r, |x| scale.of_integer(i64::from(*x), 32)),
        ColumnReader::Int64ColumnReader(r) => numbers!(r, |x| scale.of_integer(*x, 64)),
        ColumnReader::FloatColumnReader(r) => numbers!(r, |x| f64::from(*x)),
        ColumnReader::DoubleColumnReader(r) => numbers!(r, |x| *x),
        ColumnReader::Int96ColumnReader(r) => numbers!(r, |x| x.to_nanos() as f64 / 1e9),
        _ => return Err(ParquetError::NYI("a column of bytes".into())),
    })
}

/// Pages, those in Zstandard decompressed in Rust.
struct Pages {
    inner: Box<dyn PageReader>,
    is_zstd: bool,
    has_dictionary: bool,
}

impl Pages {
    /// Refuses a page whose dictionary is not there, at which the library panics.
    fn check(&mut self, page: &Page) -> Outcome<()> {
        let of_dictionary = [Encoding::RLE_DICTIONARY, Encoding::PLAIN_DICTIONARY];
        match page {
            Page::DictionaryPage { .. } => self.has_dictionary = true,
            _ if of_dictionary.contains(&page.encoding()) && !self.has_dictionary => {
                return Err(ParquetError::General("a page without its dictionary".into()));
            }
            _ => {}
        }
        Ok(())
    }

    fn decompressed(page: Page) -> Outcome<Page> {
        let text = |buffer: &[u8], plain: usize| -> Outcome<Bytes> {
            let failed = |e: String| ParquetError::General(format!("Zstandard: {e}"));
            let plain =
                buffer.get(..plain).ok_or_else(|| failed("levels beyond the page".into()))?;
            let mut all = plain.to_vec();
            let rest = &buffer[plain.len()..];
            if !rest.is_empty() {
                let decoder = ruzstd::decoding::StreamingDecoder::new(rest);
                let decoder = decoder.map_err(|e| failed(e.to_string()))?;
                let read = decoder.take(LARGEST_PAGE).read_to_end(&mut all);
                read.map_err(|e| failed(e.to_string()))?;
            }
            Ok(all.into())
        };
        Ok(match page {
            Page::DataPage {
                buf,
                num_values,
                encoding,
                def_level_encoding,
                rep_level_encoding,
                statistics,
            } => Page::DataPage {
                buf: text(&buf, 0)?,
                num_values,
                encoding,
                def_level_encoding,
                rep_level_encoding,
                statistics,
            },
            Page::DictionaryPage { buf, num_values, encoding, is_sorted } => {
                Page::DictionaryPage { buf: text(&buf, 0)?, num_values, encoding, is_sorted }
            }
            Page::DataPageV2 {
                buf,
                num_values,
                encoding,
                num_nulls,
                num_rows,
                def_levels_byte_len,
                rep_levels_byte_len,
                is_compressed,
                statistics,
            } => {
                let levels = def_levels_byte_len as usize + rep_levels_byte_len as usize;
                let buf = if is_compressed { text(&buf, levels)? } else { buf };
                Page::DataPageV2 {
                    buf,
                    num_values,
                    encoding,
                    num_nulls,
                    num_rows,
                    def_levels_byte_len,
                    rep_levels_byte_len,
                    is_compressed: false,
                    statistics,
                }
            }
        })
    }
}

impl Iterator for Pages {
    type Item = Outcome<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Outcome<Option<Page>> {
        let Some(page) = self.inner.get_next_page()? else { return Ok(None) };
        self.check(&page)?;
        Ok(Some(if self.is_zstd { Self::decompressed(page)? } else { page }))
    }

    fn peek_next_page(&mut self) -> Outcome<Option<PageMetadata>> {
        self.inner.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Outcome<()> {
        self.inner.skip_next_page()
    }
}

/// Our bytes as the library reads them.
#[derive(Clone)]
struct Source {
    bytes: Arc<dyn ReadAt>,
    size: u64,
}

impl Length for Source {
    fn len(&self) -> u64 {
        self.size
    }
}

impl ChunkReader for Source {
    type T = std::io::BufReader<At>;

    fn get_read(&self, start: u64) -> Outcome<Self::T> {
        let mut at = At::new(Arc::clone(&self.bytes));
        at.seek(SeekFrom::Start(start))?;
        Ok(std::io::BufReader::new(at))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Outcome<Bytes> {
        if start.checked_add(length as u64).is_none_or(|end| end > self.size) {
            let problem = format!("{length} bytes at byte {start} are beyond the end of the file");
            return Err(ParquetError::EOF(problem));
        }
        let mut buffer = vec![0; length];
        let mut at = At::new(Arc::clone(&self.bytes));
        at.seek(SeekFrom::Start(start))?;
        at.read_exact(&mut buffer)?;
        Ok(buffer.into())
    }
}
