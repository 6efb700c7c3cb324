//! Columns of a schema of Arrow that are read, and their cells as numbers.

use crate::recording::half::half;
use crate::recording::scale::Scale;
use arrow_array::cast::AsArray;
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_buffer::{ArrowNativeType, NullBuffer, i256};
use arrow_data::ArrayData;
use arrow_schema::{DataType as Is, Fields, TimeUnit};

/// A column that is read.
#[derive(Debug, Clone)]
pub(in crate::recording) struct Column {
    /// Its name, within a structure behind that of the structure and a dot.
    pub(in crate::recording) name: String,
    /// Its place in the schema, within a structure behind that of the structure.
    pub(super) path: Vec<usize>,
    pub(in crate::recording) scale: Scale,
    pub(super) is_time: bool,
    pub(in crate::recording) is_duration: bool,
}

/// The columns of a schema, and name and kind of each that is not read.
#[derive(Debug, Default)]
pub(in crate::recording) struct Columns {
    pub(in crate::recording) read: Vec<Column>,
    pub(super) unread: Vec<(String, &'static str)>,
}

impl Columns {
    pub(in crate::recording) fn from_fields(fields: &Fields) -> Self {
        let mut all = Self::default();
        all.add(fields, "", &[]);
        all
    }

    fn add(&mut self, fields: &Fields, above: &str, place: &[usize]) {
        for (k, field) in fields.iter().enumerate() {
            let name = format!("{above}{}", field.name());
            let path = [place, &[k]].concat();
            let kind = match field.data_type() {
                Is::Struct(fields) => {
                    self.add(fields, &format!("{name}."), &path);
                    continue;
                }
                Is::Dictionary(_, values) => values,
                kind => kind,
            };
            let is_duration = matches!(kind, Is::Duration(_));
            let is_time =
                is_duration || matches!(kind, Is::Timestamp(..) | Is::Time32(_) | Is::Time64(_));
            match scale_of(kind) {
                Ok(scale) => self.read.push(Column { name, path, scale, is_time, is_duration }),
                Err(what) => self.unread.push((name, what)),
            }
        }
    }
}

/// The scale of a kind of values, or what they are.
fn scale_of(kind: &Is) -> Result<Scale, &'static str> {
    let divided = |digits: i8| Ok(Scale::Divided(10_f64.powi(i32::from(digits))));
    match kind {
        Is::Timestamp(unit, _) | Is::Time32(unit) | Is::Time64(unit) | Is::Duration(unit) => {
            divided(match unit {
                TimeUnit::Second => 0,
                TimeUnit::Millisecond => 3,
                TimeUnit::Microsecond => 6,
                TimeUnit::Nanosecond => 9,
            })
        }
        Is::Decimal32(_, digits) | Is::Decimal64(_, digits) | Is::Decimal128(_, digits) => {
            divided(*digits)
        }
        Is::Decimal256(_, digits) => Ok(Scale::Bytes(10_f64.powi(i32::from(*digits)))),
        Is::Utf8 | Is::LargeUtf8 | Is::Utf8View => Ok(Scale::Text(None)),
        Is::Boolean | Is::Date32 | Is::Date64 => Ok(Scale::INTEGER),
        kind if kind.is_numeric() => Ok(Scale::INTEGER),
        Is::Null => Err("no values"),
        Is::Binary | Is::LargeBinary | Is::BinaryView | Is::FixedSizeBinary(_) => {
            Err("bytes that are no numbers")
        }
        Is::Interval(_) => Err("intervals of a calendar"),
        Is::Map(..) => Err("maps"),
        Is::Union(..) => Err("values of several kinds"),
        Is::RunEndEncoded(..) => Err("runs of equal values"),
        Is::Struct(_) | Is::Dictionary(..) => Err("a dictionary of structures"),
        _ => Err("lists"),
    }
}

/// The cells of a column in a batch.
pub(super) struct Cells {
    array: ArrayRef,
    /// Which cells of the structures around it are there.
    parents: Vec<NullBuffer>,
}

impl Cells {
    /// Of a batch that has the columns of the schema at these places.
    pub(super) fn from_batch(
        batch: &RecordBatch,
        places: &[usize],
        column: &Column,
    ) -> Option<Self> {
        let (top, below) = column.path.split_first()?;
        let place = places.iter().position(|place| place == top)?;
        let mut cells = Self { array: batch.columns().get(place)?.clone(), parents: Vec::new() };
        for &child in below {
            cells.parents.extend(cells.array.nulls().cloned());
            cells.array = cells.array.as_struct_opt()?.columns().get(child)?.clone();
        }
        Some(cells)
    }

    /// The numbers of so many rows; one that is missing is NaN.
    pub(super) fn read(
        &self,
        from: usize,
        count: usize,
        scale: &mut Scale,
    ) -> Result<Vec<f64>, String> {
        let mut numbers = numbers(&self.array.slice(from, count), scale)?;
        for nulls in &self.parents {
            set_missing(&mut numbers, &nulls.slice(from, count));
        }
        Ok(numbers)
    }

    /// How texts are read, by those of the first rows.
    pub(super) fn scale_of_texts(&self) -> Scale {
        let array = self.array.slice(0, self.array.len().min(1000));
        Scale::of_texts(texts(&array).into_iter().flatten())
    }
}

fn set_missing(numbers: &mut [f64], nulls: &NullBuffer) {
    let missing = numbers.iter_mut().zip(nulls).filter(|(_, is_there)| !is_there);
    missing.for_each(|(number, _)| *number = f64::NAN);
}

fn numbers(array: &ArrayRef, scale: &mut Scale) -> Result<Vec<f64>, String> {
    let mut numbers = match array.as_any_dictionary_opt() {
        _ if matches!(scale, Scale::Text(_)) => {
            let number = |text: Option<&str>| match text {
                Some(text) => scale.of_bytes(text.as_bytes()),
                None => Ok(f64::NAN),
            };
            texts(array).into_iter().map(number).collect::<Result<_, _>>()?
        }
        Some(dictionary) => {
            let values = numbers(dictionary.values(), scale)?;
            by_key(dictionary, &values, f64::NAN)
        }
        None => plain(array, scale)?,
    };
    array.nulls().into_iter().for_each(|nulls| set_missing(&mut numbers, nulls));
    Ok(numbers)
}

/// The numbers of an array that is no dictionary; those of missing cells are any.
fn plain(array: &ArrayRef, scale: &mut Scale) -> Result<Vec<f64>, String> {
    let data = &array.to_data();
    let mut numbers: Vec<f64> = match array.data_type() {
        Is::Boolean => array.as_boolean().values().iter().map(|x| f64::from(u8::from(x))).collect(),
        Is::Int8 => all(data, |x: i8| x.into()),
        Is::Int16 => all(data, |x: i16| x.into()),
        Is::Int32 | Is::Date32 | Is::Time32(_) | Is::Decimal32(..) => all(data, |x: i32| x.into()),
        Is::UInt8 => all(data, |x: u8| x.into()),
        Is::UInt16 => all(data, |x: u16| x.into()),
        Is::UInt32 => all(data, |x: u32| x.into()),
        Is::UInt64 => all(data, |x: u64| x as f64),
        Is::Float16 => all(data, half),
        Is::Float32 => all(data, |x: f32| x.into()),
        Is::Float64 => all(data, |x: f64| x),
        Is::Decimal128(..) => all(data, |x: i128| x as f64),
        Is::Decimal256(..) => {
            let number = |x: &i256| scale.of_bytes(&x.to_be_bytes());
            return data.buffer(0)[..data.len()].iter().map(number).collect();
        }
        _ => all(data, |x: i64| x as f64),
    };
    if let Scale::Divided(by) = *scale {
        numbers.iter_mut().for_each(|x| *x /= by);
    }
    Ok(numbers)
}

fn all<T: ArrowNativeType>(data: &ArrayData, number: impl Fn(T) -> f64) -> Vec<f64> {
    data.buffer::<T>(0)[..data.len()].iter().map(|x| number(*x)).collect()
}

/// The value of each cell of a dictionary.
fn by_key<T: Copy>(
    dictionary: &dyn arrow_array::AnyDictionaryArray,
    values: &[T],
    none: T,
) -> Vec<T> {
    // Cells that are missing may have no value at all.
    if values.is_empty() {
        return vec![none; dictionary.len()];
    }
    dictionary.normalized_keys().into_iter().map(|key| values[key]).collect()
}

fn texts(array: &ArrayRef) -> Vec<Option<&str>> {
    match (array.data_type(), array.as_any_dictionary_opt()) {
        (_, Some(dictionary)) => {
            let all = by_key(dictionary, &texts(dictionary.values()), None);
            let is_there = |k| dictionary.is_valid(k);
            all.into_iter().enumerate().map(|(k, text)| text.filter(|_| is_there(k))).collect()
        }
        (Is::Utf8, _) => array.as_string::<i32>().iter().collect(),
        (Is::LargeUtf8, _) => array.as_string::<i64>().iter().collect(),
        _ => array.as_string_view().iter().collect(),
    }
}
