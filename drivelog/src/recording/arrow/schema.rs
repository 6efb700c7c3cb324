//! The schema of Arrow: columns, how their cells are read, and which buffers of a batch are theirs.

use super::flatbuffer::Table;
use crate::recording::scale::Scale;

/// Code of a schema among the messages.
pub(super) const CODE: u8 = 1;
/// Nested more deeply nothing is looked at.
const DEEPEST: usize = 32;

/// How the cells of a column lie in its buffers, behind that of the bits that state which are there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Layout {
    /// A bit each.
    Bits,
    /// So many bytes each.
    Bytes(usize),
    /// Offsets of so many bytes each, and the texts.
    Texts(usize),
}

/// The numbers of the cells of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Integer,
    Float,
    Text,
}

/// A column that is read.
#[derive(Debug, Clone)]
pub(in crate::recording) struct Column {
    pub(in crate::recording) name: String,
    pub(super) layout: Layout,
    pub(super) kind: Kind,
    pub(in crate::recording) scale: Scale,
    pub(super) is_time: bool,
    pub(in crate::recording) is_duration: bool,
    /// Place of its node among those of a batch, and of its first buffer.
    pub(super) node: usize,
    pub(super) buffer: usize,
    /// Columns before it with as many buffers as the batch states.
    pub(super) views: usize,
    /// First buffers and nodes of the structures it is in.
    pub(super) parents: Vec<[usize; 2]>,
}

/// The columns of a schema, and what is not read.
#[derive(Debug, Default)]
pub(in crate::recording) struct Schema {
    pub(in crate::recording) columns: Vec<Column>,
    /// Name and kind of each column that is not read.
    pub(super) unread: Vec<(String, &'static str)>,
    nodes: usize,
    buffers: usize,
    views: usize,
    parents: Vec<[usize; 2]>,
}

impl Schema {
    /// Of a message; `None` where the bytes are none.
    pub(in crate::recording) fn of(message: &[u8]) -> Option<Self> {
        let message = Table::of(message, 0)?;
        let schema = message.table(2).filter(|_| message.byte(1) == Some(CODE))?;
        let mut all = Self::default();
        // Numbers in the order of other processors.
        if schema.number::<2>(0)? != 0 {
            return None;
        }
        for field in schema.tables(1)? {
            all.add(&field, "", 0)?;
        }
        Some(all)
    }

    fn add(&mut self, field: &Table<'_>, above: &str, depth: usize) -> Option<()> {
        let name = format!("{above}{}", field.text(0).unwrap_or_default());
        let kind = field.table(3);
        let number = |at: usize| kind.as_ref().map_or(Some(0), |kind| kind.number::<4>(at));
        let small = |at: usize| kind.as_ref().map_or(Some(0), |kind| kind.number::<2>(at));
        // Seconds, milliseconds, microseconds, nanoseconds; the default is not written.
        let unit = |default: i64| {
            let unit = kind.as_ref().is_some_and(|kind| kind.has(0)).then(|| small(0));
            let unit = unit.unwrap_or(Some(default))?;
            (0..4).contains(&unit).then(|| 1e3_f64.powi(unit as i32))
        };
        let bits = |at: usize, default: i64| {
            let bits = number(at).filter(|bits| *bits != 0).unwrap_or(default);
            usize::try_from(bits / 8).ok().filter(|bytes| (1..=32).contains(bytes))
        };
        let children = field.tables(5)?;
        let code = field.byte(2).unwrap_or_default();
        let [node, buffer, views] = [self.nodes, self.buffers, self.views];
        self.nodes += 1;
        let integer = Kind::Integer;
        let mut is_time = false;
        // What of the column is read: layout, numbers, scale; else what it is.
        let read = match code {
            _ if field.has(4) => Err("texts of a dictionary"),
            2 => {
                let is_unsigned = kind.as_ref().and_then(|kind| kind.byte(1)).unwrap_or(0) == 0;
                Ok((Layout::Bytes(bits(0, 0)?), integer, Scale::Plain { is_unsigned }))
            }
            3 => {
                let bytes = *[2, 4, 8].get(usize::try_from(small(0)?).ok()?)?;
                let scale = if bytes == 2 { Scale::Half } else { Scale::INTEGER };
                Ok((Layout::Bytes(bytes), Kind::Float, scale))
            }
            5 => Ok((Layout::Texts(4), Kind::Text, Scale::Text(None))),
            20 => Ok((Layout::Texts(8), Kind::Text, Scale::Text(None))),
            6 => Ok((Layout::Bits, integer, Scale::INTEGER)),
            7 => {
                let scale = 10_f64.powi(i32::try_from(number(1)?).ok()?);
                Ok((Layout::Bytes(bits(2, 128)?), integer, Scale::Divided(scale)))
            }
            8 => {
                let bytes = if kind.as_ref().is_some_and(|kind| kind.has(0)) && small(0)? == 0 {
                    4
                } else {
                    8
                };
                Ok((Layout::Bytes(bytes), integer, Scale::INTEGER))
            }
            9 | 10 | 18 => {
                is_time = true;
                let bytes = if code == 9 { bits(1, 32)? } else { 8 };
                let default = if code == 10 { 0 } else { 1 };
                Ok((Layout::Bytes(bytes), integer, Scale::Divided(unit(default)?)))
            }
            1 => Err("no values"),
            4 | 15 | 19 | 23 => Err("bytes that are no numbers"),
            11 => Err("intervals of a calendar"),
            12 | 16 | 17 | 21 | 25 | 26 => Err("lists"),
            13 => Err(""),
            24 => Err("texts"),
            _ => Err("a type that is not known here"),
        };
        self.buffers += match code {
            _ if field.has(4) => 2,
            1 | 22 => 0,
            13 | 16 => 1,
            4 | 5 | 19 | 20 | 25 | 26 => 3,
            // A union has the types, and where it is dense offsets.
            14 => 1 + usize::from(small(0)? == 1),
            _ => 2,
        };
        self.views += usize::from(matches!(code, 23 | 24));
        if code == 13 && depth < DEEPEST {
            self.parents.push([node, buffer]);
            for child in &children {
                self.add(child, &format!("{name}."), depth + 1)?;
            }
            self.parents.pop();
            return Some(());
        }
        match read {
            Ok((layout, kind, scale)) => self.columns.push(Column {
                name,
                layout,
                kind,
                scale,
                is_time,
                is_duration: code == 18,
                node,
                buffer,
                views,
                parents: self.parents.clone(),
            }),
            Err(what) => self.unread.push((name, what)),
        }
        // What is below is passed over.
        let (columns, unread) = (self.columns.len(), self.unread.len());
        if !field.has(4) {
            for child in children.iter().filter(|_| depth < DEEPEST) {
                self.add(child, "", depth + 1)?;
            }
        }
        self.columns.truncate(columns);
        self.unread.truncate(unread);
        Some(())
    }
}
