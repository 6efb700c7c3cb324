//! Arrow IPC: files, which are Feather's second version, and streams; flat columns of numbers, a batch at a time.
//!
//! Columns are read as those of Parquet are. The crate `arrow-ipc` decodes the batches.

pub(super) mod columns;
mod parts;

use super::bytes::{Head, LogFile};
use super::scale::Scale;
use super::{Columns, Group, Pieces, Recording, Request, Rows, contained};
use crate::Error;
use crate::error::shortened;
use crate::options::LogOptions;
use columns::{Cells, Column};
use parts::{ArrowPart, Batches, Contents, MAGIC, MARK, Outcome};
use std::collections::BTreeSet;
use std::rc::Rc;

pub(super) fn recognises(head: &Head<'_>) -> bool {
    // A stream begins with the length of its first message, and that with the place of its table.
    let stream = head.start.strip_prefix(MARK).unwrap_or(head.start);
    let number = |at: usize| {
        let bytes = stream.get(at..)?.first_chunk();
        bytes.map(|bytes| u32::from_le_bytes(*bytes))
    };
    // Aligned, as the mark of UTF-32 is not.
    let is_length = number(0).is_some_and(|n| (8..1 << 26).contains(&n) && n % 4 == 0);
    let is_place = number(4).is_some_and(|place| (4..256).contains(&place) && place % 4 == 0);
    head.start.starts_with(MAGIC) || is_length && is_place
}

/// Opens a table; lists its batches.
pub(super) fn open<'a>(
    file: LogFile<'a>,
    _: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    let bytes = file.sought()?;
    let name = file.name;
    let contents = contained(|| Contents::open(&bytes)).unwrap_or_else(damaged);
    let contents =
        contents.map_err(|problem| Error::Read { file: name.clone(), byte: 0, problem })?;
    let columns::Columns { read: mut columns, unread } =
        columns::Columns::from_fields(contents.schema.fields());
    let of_texts = |column: &&mut Column| column.scale == Scale::Text(None);
    let places = places(columns.iter().filter(|column| column.scale == Scale::Text(None)));
    let filled = |(part, _): &(&ArrowPart, _)| part.rows > Some(0);
    if !places.is_empty()
        && let Some((_, Ok(batch))) = Batches::new(&contents, &places).find(filled)
    {
        for column in columns.iter_mut().filter(of_texts) {
            if let Some(cells) = Cells::from_batch(&batch, &places, column) {
                column.scale = cells.scale_of_texts();
            }
        }
    }
    let channels = columns.iter().map(|own| own.scale.channel(&own.name, own.is_time));
    let mut group = Group::new(&name, "", channels.collect());
    if group.channels.iter().all(|channel| channel.is_text) {
        return Err(Error::NoNumbers { file: name });
    }
    let mut rows = contents.parts.iter().filter_map(|part| part.rows);
    group.rows = rows.try_fold(0_u64, u64::checked_add);
    let damages = contents.damages.iter().map(|(at, what)| format!("{name}: byte {at}: {what}"));
    let unread = unread
        .iter()
        .map(|(own, what)| format!("{name}: column `{}` is not read: {what}", shortened(own)));
    let losses = damages.chain(unread).collect();
    Ok(Box::new(Ipc { contents, groups: [group], columns, losses }))
}

/// The places of columns in the schema, in its order; of one within a structure that of the structure.
fn places<'c>(columns: impl Iterator<Item = &'c Column>) -> Vec<usize> {
    let places: BTreeSet<usize> = columns.filter_map(|own| own.path.first().copied()).collect();
    places.into_iter().collect()
}

struct Ipc {
    contents: Contents,
    groups: [Group; 1],
    columns: Vec<Column>,
    losses: Vec<String>,
}

impl Recording for Ipc {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let wanted = request.wanted.first().filter(|wanted| !wanted.channels.is_empty());
        let Some(wanted) = wanted else { return Ok(Box::new(std::iter::empty())) };
        let Self { contents, groups, columns, losses } = self;
        let mut own: Vec<Column> = wanted.channels.iter().map(|&c| columns[c].clone()).collect();
        let places = places(own.iter());
        let mut batches = Batches::new(contents, &places);
        // The batch, its cells, and how many of its rows were read.
        let mut current: Option<(&ArrowPart, Vec<Cells>, u64)> = None;
        let mut row = 0_u64;
        Ok(Box::new(std::iter::from_fn(move || {
            loop {
                let Some((part, cells, done)) = &mut current else {
                    let (part, batch) = batches.next()?;
                    let cells = batch.and_then(|batch| {
                        let cells =
                            own.iter().map(|column| Cells::from_batch(&batch, &places, column));
                        cells
                            .collect::<Option<Vec<Cells>>>()
                            .ok_or_else(|| "a column is missing".into())
                    });
                    match cells {
                        Ok(cells) => current = Some((part, cells, 0)),
                        Err(problem) => {
                            let rows = part.rows.unwrap_or_default();
                            losses.push(lost(&groups[0].file, part, rows, &problem));
                            row = row.saturating_add(rows);
                        }
                    }
                    continue;
                };
                let left = part.rows.unwrap_or_default() - *done;
                let count = left.min(request.most as u64);
                if count == 0 {
                    current = None;
                    continue;
                }
                let read = cells.iter().zip(&mut own).map(|(cells, column)| {
                    let read = || cells.read(*done as usize, count as usize, &mut column.scale);
                    contained(read).unwrap_or_else(damaged)
                });
                match read.collect::<Outcome<Vec<Vec<f64>>>>() {
                    Ok(values) => {
                        let lines = Rc::new((row + 1..=row + count).collect());
                        (row, *done) = (row + count, *done + count);
                        return Some(Ok(Rows { wanted: 0, columns: Columns { values, lines } }));
                    }
                    Err(problem) => {
                        losses.push(lost(&groups[0].file, part, left, &problem));
                        row += left;
                        current = None;
                    }
                }
            }
        })))
    }

    fn losses(&self) -> Vec<String> {
        self.losses.clone()
    }
}

fn damaged<T>() -> Outcome<T> {
    Err("the bytes are damaged".into())
}

fn lost(name: &str, part: &ArrowPart, rows: u64, problem: &str) -> String {
    format!("{name}: {rows} rows of the batch at byte {} are not read: {problem}", part.byte())
}
