//! Parquet: flat columns of numbers, a row group at a time.
//!
//! Codecs are Snappy, LZ4, gzip, Brotli and Zstandard, all in Rust. Times and timestamps are read as seconds,
//! timestamps as seconds since 1970, texts in ISO 8601 too. Null is a missing value; repeated columns are not read.

mod columns;
mod pages;

use super::arrow::columns::Columns as Schema;
use super::base64::base64;
use super::bytes::{Head, LogFile};
use super::scale::Scale;
use super::{Columns, Group, Pieces, Recording, Request, Rows, Wanted, contained};
use crate::Error;
use crate::error::shortened;
use crate::options::LogOptions;
use crate::role::Role;
use crate::units::{Quantity, unit_of_header};
use arrow_ipc::convert::try_schema_from_ipc_buffer;
use columns::{first_texts, is_time, read, scale_of};
use pages::{Source, reader};
use parquet::column::reader::ColumnReader;
use parquet::errors::{ParquetError, Result as Outcome};
use parquet::file::metadata::{ParquetMetaData, RowGroupMetaData};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::statistics::Statistics;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

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
    let source = Arc::new(source);
    let pairs = metadata.file_metadata().key_value_metadata().into_iter().flatten();
    let arrow = pairs.filter(|pair| pair.key == "ARROW:schema").find_map(|pair| pair.value.clone());
    let durations = durations(&arrow.unwrap_or_default());
    let (mut channels, mut columns, mut losses) = (Vec::new(), Vec::new(), Vec::new());
    for (k, column) in metadata.file_metadata().schema_descr().columns().iter().enumerate() {
        let column_name = column.path().string();
        let Some(mut scale) = scale_of(column) else {
            let is_list = column.max_rep_level() > 0;
            let what = if is_list { "lists" } else { "bytes that are no numbers" };
            let own = shortened(&column_name);
            losses.push(format!("{}: column `{own}` is not read: {what}", file.name));
            continue;
        };
        let duration = durations.get(&column_name).filter(|_| scale == Scale::INTEGER);
        if let Some(duration) = duration {
            scale = *duration;
        }
        if scale == Scale::Text(None) {
            match expanded(&metadata, k) {
                Some(what) => {
                    let own = shortened(&column_name);
                    losses.push(format!("{}: column `{own}` is not read: {what}", file.name));
                }
                None => {
                    let texts = contained(|| first_texts(&source, &metadata, k)).flatten();
                    scale = Scale::of_texts(texts.unwrap_or_default());
                }
            }
        }
        channels.push(scale.channel(&column_name, duration.is_some() || is_time(column)));
        columns.push((k, scale));
    }
    if channels.iter().all(|channel| channel.is_text) {
        return Err(Error::NoNumbers { file: file.name });
    }
    let mut group = Group::new(&file.name, "", channels);
    group.rows = u64::try_from(metadata.file_metadata().num_rows()).ok();
    let name = file.name;
    Ok(Box::new(Table { name, source, metadata, groups: [group], columns, losses }))
}

/// The columns that are durations, which the schema of Arrow has beyond that of Parquet.
fn durations(schema: &str) -> BTreeMap<String, Scale> {
    let schema = contained(|| try_schema_from_ipc_buffer(&base64(schema)).ok()).flatten();
    let columns = schema.map(|schema| Schema::from_fields(schema.fields())).unwrap_or_default();
    let own = columns.read.into_iter().filter(|column| column.is_duration);
    own.map(|column| (column.name, column.scale)).collect()
}

/// What a column of texts is that takes much more memory than its bytes in the file let expect: its dictionary is in
/// memory as a whole.
fn expanded(metadata: &ParquetMetaData, column: usize) -> Option<String> {
    const LARGE: i64 = 1 << 26;
    const MOST_TIMES: i64 = 1000;
    let chunks = metadata.row_groups().iter().map(|group| group.column(column));
    let sizes = chunks.map(|chunk| (chunk.uncompressed_size(), chunk.compressed_size()));
    let (size, compressed) = sizes.max()?;
    if size <= LARGE || size / MOST_TIMES <= compressed {
        return None;
    }
    Some(format!("{size} bytes in {compressed} that are compressed"))
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
                return Err(format!(
                    "column `{}` is not within the file",
                    shortened(&column.column_path().string())
                ));
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
        let mut own: Vec<(usize, Scale)> = wanted.channels.iter().map(|&c| columns[c]).collect();
        let mut groups = metadata.row_groups().iter().enumerate();
        let mut group = None;
        let mut readers: Vec<ColumnReader> = Vec::new();
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
                    let open = |(c, _): &(usize, Scale)| {
                        contained(|| reader(source, metadata, k, *c)).unwrap_or_else(damaged)
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
                let values = readers.iter_mut().zip(&mut own).map(|(reader, (_, scale))| {
                    contained(|| read(reader, scale, most)).unwrap_or_else(damaged)
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
