//! Numbers out of messages in CDR, without a copy of the rest.
//!
//! Offsets count from behind the four bytes of encapsulation; a number is aligned to its size, in XCDR2 to at
//! most four. A text or sequence moves what follows it, so offsets are computed for each message. Source: OMG
//! [DDS-XTypes 1.3](https://www.omg.org/spec/DDS-XTypes/1.3), sections 7.4 and 7.6.2.

use super::schema::{Count, Field, FieldKind, Number, Schema};
use super::seconds;

/// Longest fixed array whose elements are channels.
const MOST_ELEMENTS: usize = 36;
/// Deepest nesting of types.
const MOST_DEPTH: usize = 24;
/// Most steps of a layout.
const MOST_STEPS: usize = 1 << 14;

/// How the bytes of a message are laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording) struct Encapsulation {
    is_big_endian: bool,
    is_xcdr2: bool,
}

impl Encapsulation {
    /// That of the message, and the bytes behind it.
    ///
    /// # Errors
    /// What it is, if it is not read.
    pub(in crate::recording) fn split(message: &[u8]) -> Result<(Self, &[u8]), &'static str> {
        let [high, low, _, _, body @ ..] = message else {
            return Err("messages are shorter than their type");
        };
        let id = u16::from_be_bytes([*high, *low]);
        match id {
            0 | 1 | 6 | 7 => {
                Ok((Self { is_big_endian: id.is_multiple_of(2), is_xcdr2: id > 1 }, body))
            }
            2 | 3 | 8..=11 => {
                Err("messages of mutable or appendable types (PL_CDR, D_CDR) are not read")
            }
            _ => Err("messages are not CDR"),
        }
    }

    /// The instant that a message begins with, ns.
    pub(in crate::recording) fn first_time(message: &[u8]) -> Option<i64> {
        let (encapsulation, body) = Self::split(message).ok()?;
        Cursor { body, at: 0, encapsulation }.time().ok()
    }
}

#[derive(Debug)]
enum Step {
    /// Successive numbers; which leaf the first of them is.
    Numbers(Number, usize, Option<usize>),
    Time(Option<usize>),
    Text,
    /// The length in bytes that XCDR2 writes before items that are not numbers.
    Length,
    /// Items, of a number that is fixed or stands before them.
    Items(Option<usize>, Vec<Step>),
}

/// The numbers of a type of message, and how they are reached.
#[derive(Debug)]
pub(in crate::recording) struct Layout {
    steps: Vec<Step>,
    /// Path of each number, and whether it is a time in s.
    pub(in crate::recording) leaves: Vec<(String, bool)>,
    /// Why what follows the last step is not read.
    pub(in crate::recording) ends_at: Option<String>,
    /// The leaf that is the time of the message: the stamp of its header, or a time that it begins with.
    pub(in crate::recording) stamp: Option<usize>,
}

impl Layout {
    /// The layout of a type.
    ///
    /// # Errors
    /// What of the definition is missing or beyond bounds.
    pub(in crate::recording) fn from_schema(schema: &Schema) -> Result<Self, String> {
        let mut builder = Builder { schema, leaves: Vec::new(), count: 0, ends_at: None };
        let mut steps = Vec::new();
        builder.message(schema.root(), Some(""), 0, &mut steps)?;
        let first = builder.leaves.first();
        let is_stamp = first.is_some_and(|(path, is_time)| {
            *is_time && matches!(steps.first(), Some(Step::Time(Some(0)))) && !path.contains('[')
        });
        let (leaves, ends_at) = (builder.leaves, builder.ends_at);
        Ok(Self { steps, leaves, ends_at, stamp: if is_stamp { Some(0) } else { None } })
    }

    /// Reads leaves: of each leaf the place in `row`, or none beyond its length.
    ///
    /// # Errors
    /// What is wrong with the message.
    pub(in crate::recording) fn read(
        &self,
        message: &[u8],
        places: &[usize],
        row: &mut [f64],
    ) -> Result<(), &'static str> {
        let (encapsulation, body) = Encapsulation::split(message)?;
        let mut cursor = Cursor { body, at: 0, encapsulation };
        let mut left = places.iter().filter(|place| **place < row.len()).count();
        for step in &self.steps {
            if left == 0 {
                break;
            }
            cursor.step(step, &mut |leaf, x| {
                if let Some(to) = places.get(leaf).and_then(|place| row.get_mut(*place)) {
                    *to = x;
                    left = left.saturating_sub(1);
                }
            })?;
        }
        Ok(())
    }
}

struct Builder<'s> {
    schema: &'s Schema,
    leaves: Vec<(String, bool)>,
    count: usize,
    ends_at: Option<String>,
}

impl Builder<'_> {
    /// Adds the steps of a message; its leaves are listed if it has a path.
    fn message(
        &mut self,
        name: &str,
        path: Option<&str>,
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<(), String> {
        if depth > MOST_DEPTH {
            return Err(format!("`{name}` contains itself"));
        }
        let schema = self.schema;
        let fields = match schema.fields(name) {
            // A message without fields has one byte.
            Some([]) => {
                steps.push(Step::Numbers(Number::U8, 1, None));
                return self.counted(1);
            }
            Some(fields) => fields,
            None => return Err(format!("`{name}` is not defined")),
        };
        for field in fields {
            if self.ends_at.is_some() {
                break;
            }
            let path = path.map(|path| match path {
                "" => field.name.clone(),
                path => format!("{path}.{}", field.name),
            });
            self.field(field, path.as_deref(), depth, steps)?;
        }
        Ok(())
    }

    fn field(
        &mut self,
        field: &Field,
        path: Option<&str>,
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<(), String> {
        self.counted(1)?;
        match (field.count, &field.kind) {
            (Count::One, kind) => self.item(kind, path, depth, steps)?,
            (Count::Fixed(count), FieldKind::Number(number)) => {
                let leaf = path.filter(|_| count <= MOST_ELEMENTS).map(|path| {
                    let first = self.leaves.len();
                    self.leaves.extend((0..count).map(|i| (format!("{path}[{i}]"), false)));
                    first
                });
                steps.push(Step::Numbers(*number, count, leaf));
            }
            (Count::Fixed(count), kind) if path.is_some() && count <= MOST_ELEMENTS => {
                steps.push(Step::Length);
                for i in 0..count {
                    let path = path.map(|path| format!("{path}[{i}]"));
                    self.item(kind, path.as_deref(), depth, steps)?;
                }
            }
            (count, kind) => {
                if !matches!(kind, FieldKind::Number(_)) {
                    steps.push(Step::Length);
                }
                let mut of_item = Vec::new();
                self.item(kind, None, depth, &mut of_item)?;
                let count = if let Count::Fixed(count) = count { Some(count) } else { None };
                steps.push(Step::Items(count, of_item));
            }
        }
        // A sequence of items that end early cannot be passed.
        if self.ends_at.is_some() && path.is_none() {
            steps.pop();
        }
        self.counted(0)
    }

    fn item(
        &mut self,
        kind: &FieldKind,
        path: Option<&str>,
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<(), String> {
        let mut leaf = |is_time| {
            path.map(|path| {
                self.leaves.push((path.into(), is_time));
                self.leaves.len() - 1
            })
        };
        match kind {
            FieldKind::Number(number) => steps.push(Step::Numbers(*number, 1, leaf(false))),
            FieldKind::Time => steps.push(Step::Time(leaf(true))),
            FieldKind::Text => steps.push(Step::Text),
            FieldKind::WideText => {
                self.ends_at = Some("a wstring, and what follows it,".into());
            }
            FieldKind::Message(name) => self.message(name, path, depth + 1, steps)?,
        }
        self.counted(1)
    }

    fn counted(&mut self, more: usize) -> Result<(), String> {
        self.count += more;
        if self.count.max(self.leaves.len()) > MOST_STEPS {
            return Err(format!("more than {MOST_STEPS} fields"));
        }
        Ok(())
    }
}

const SHORT: &str = "messages are shorter than their type";

struct Cursor<'m> {
    body: &'m [u8],
    at: usize,
    encapsulation: Encapsulation,
}

impl<'m> Cursor<'m> {
    fn step(&mut self, step: &Step, take: &mut impl FnMut(usize, f64)) -> Result<(), &'static str> {
        match step {
            Step::Numbers(number, count, leaf) => {
                let bytes = self.numbers(*number, *count)?;
                if let Some(first) = leaf {
                    for (i, bytes) in bytes.chunks_exact(number.size()).enumerate() {
                        take(first + i, value(*number, bytes, self.encapsulation.is_big_endian));
                    }
                }
            }
            Step::Time(leaf) => {
                let time = self.time()?;
                if let Some(leaf) = leaf {
                    take(*leaf, seconds(time));
                }
            }
            Step::Text => {
                let length = self.count()?;
                self.bytes(length)?;
            }
            Step::Length => {
                if self.encapsulation.is_xcdr2 {
                    self.count()?;
                }
            }
            Step::Items(count, steps) => {
                let count = match count {
                    Some(count) => *count,
                    None => self.count()?,
                };
                if let [Step::Numbers(number, 1, _)] = steps[..] {
                    if count > 0 {
                        self.numbers(number, count)?;
                    }
                    return Ok(());
                }
                for _ in 0..count {
                    let before = self.at;
                    steps.iter().try_for_each(|step| self.step(step, take))?;
                    if self.at == before {
                        return Err(SHORT);
                    }
                }
            }
        }
        Ok(())
    }

    fn numbers(&mut self, number: Number, count: usize) -> Result<&'m [u8], &'static str> {
        let most = if self.encapsulation.is_xcdr2 { 4 } else { 8 };
        self.at = self.at.next_multiple_of(number.size().min(most));
        self.bytes(number.size().checked_mul(count).ok_or(SHORT)?)
    }

    fn bytes(&mut self, count: usize) -> Result<&'m [u8], &'static str> {
        let end = self.at.checked_add(count).ok_or(SHORT)?;
        let bytes = self.body.get(self.at..end).ok_or(SHORT)?;
        self.at = end;
        Ok(bytes)
    }

    fn count(&mut self) -> Result<usize, &'static str> {
        let bytes = self.numbers(Number::U32, 1)?;
        Ok(value(Number::U32, bytes, self.encapsulation.is_big_endian) as usize)
    }

    /// Seconds and nanoseconds, in ns.
    fn time(&mut self) -> Result<i64, &'static str> {
        let is_big_endian = self.encapsulation.is_big_endian;
        let whole = value(Number::I32, self.numbers(Number::I32, 1)?, is_big_endian);
        let rest = value(Number::U32, self.numbers(Number::U32, 1)?, is_big_endian);
        Ok(whole as i64 * 1_000_000_000 + rest as i64)
    }
}

/// The number that the bytes are; they are as many as its size.
fn value(number: Number, bytes: &[u8], is_big_endian: bool) -> f64 {
    macro_rules! read {
        ($type:ty) => {{
            let bytes = bytes.try_into().unwrap_or_default();
            (if is_big_endian {
                <$type>::from_be_bytes(bytes)
            } else {
                <$type>::from_le_bytes(bytes)
            }) as f64
        }};
    }
    match number {
        Number::Bool => f64::from(u8::from(bytes != [0])),
        Number::I8 => read!(i8),
        Number::U8 => read!(u8),
        Number::I16 => read!(i16),
        Number::U16 => read!(u16),
        Number::I32 => read!(i32),
        Number::U32 => read!(u32),
        Number::I64 => read!(i64),
        Number::U64 => read!(u64),
        Number::F32 => read!(f32),
        Number::F64 => read!(f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "builtin_interfaces/Time stamp\nstring name\nfloat64 x\nuint8[] few\nInner[2] both\n\
        Inner[] many\nfloat32 last\n===\nMSG: p/Inner\nbool on\nint64 n\n";

    fn read(text: &str, message: &[u8]) -> Result<Vec<(String, f64)>, String> {
        let layout = Layout::from_schema(&Schema::parse("p/msg/T", text)?)?;
        let mut row = vec![f64::NAN; layout.leaves.len()];
        let places: Vec<usize> = (0..row.len()).collect();
        layout.read(message, &places, &mut row)?;
        Ok(layout.leaves.into_iter().map(|(path, _)| path).zip(row).collect())
    }

    /// A message written by the rules: alignment to the size, at most `most`; with the lengths of XCDR2.
    fn message(id: u8, most: usize) -> Vec<u8> {
        let mut body: Vec<u8> = Vec::new();
        let mut put = |little: &[u8]| {
            while !body.len().is_multiple_of(little.len().min(most)) {
                body.push(0xAA);
            }
            let bytes = little.iter().copied();
            if id.is_multiple_of(2) { body.extend(bytes.rev()) } else { body.extend(bytes) }
        };
        put(&7_i32.to_le_bytes());
        put(&500_000_000_u32.to_le_bytes());
        put(&3_u32.to_le_bytes());
        b"ab\0".iter().for_each(|b| put(&[*b]));
        put(&1.5_f64.to_le_bytes());
        put(&1_u32.to_le_bytes());
        put(&[9]);
        for count in [None, Some(2_u32)] {
            if id > 1 {
                put(&24_u32.to_le_bytes());
            }
            if let Some(count) = count {
                put(&count.to_le_bytes());
            }
            for n in [-1_i64, 1 << 40] {
                put(&[1]);
                put(&n.to_le_bytes());
            }
        }
        put(&0.1_f32.to_le_bytes());
        [&[0, id, 0, 0], &body[..]].concat()
    }

    #[test]
    fn all_encapsulations_have_the_same_numbers() {
        for (id, most) in [(0, 8), (1, 8), (6, 4), (7, 4)] {
            let read = read(TEXT, &message(id, most)).unwrap();
            let wanted = [
                ("stamp", 7.5),
                ("x", 1.5),
                ("both[0].on", 1.0),
                ("both[0].n", -1.0),
                ("both[1].on", 1.0),
                ("both[1].n", (1_i64 << 40) as f64),
                ("last", f64::from(0.1_f32)),
            ];
            assert_eq!(read, wanted.map(|(path, x)| (path.to_owned(), x)), "{id}");
        }
        assert!(read(TEXT, &message(1, 8)[..40]).unwrap_err().contains("shorter"));
        assert!(read(TEXT, &[0, 3, 0, 0]).unwrap_err().contains("mutable"));
    }

    #[test]
    fn hostile_types_and_counts_are_bounded() {
        assert!(read("T t\n", &[0, 1, 0, 0]).unwrap_err().contains("contains itself"));
        let nested = (0..20).map(|i| format!("===\nMSG: p/A{i}\nA{}[30] a\n", i + 1));
        let text = format!("A0[30] a\n{}===\nMSG: p/A20\nint8 x\n", nested.collect::<String>());
        assert!(read(&text, &[0, 1, 0, 0]).unwrap_err().contains("more than"));
        let text = "E[4000000000] e\nint8 x\n===\nMSG: p/E\n";
        assert!(read(text, &[0, 1, 0, 0, 1, 2, 3]).unwrap_err().contains("shorter"));
        let text = "string[] s\nint8 x\n";
        assert!(read(text, &[0, 1, 0, 0, 255, 255, 255, 255, 0]).unwrap_err().contains("shorter"));
        let wide = read("int8 a\nwstring w\nint8 b\n", &[0, 1, 0, 0, 5]).unwrap();
        assert_eq!(wide, [("a".to_owned(), 5.0)]);
    }
}
