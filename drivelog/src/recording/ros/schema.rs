//! Message definitions as rosbag2 stores them (`ros2msg`): the text of a type, and after lines of `=` those of
//! the types within it.
//!
//! Source: [ROS 2 interface definition](https://docs.ros.org/en/rolling/Concepts/Basic/About-Interfaces.html).

use std::collections::BTreeMap;

/// A number in a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording) enum Number {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "bool" => Self::Bool,
            "int8" => Self::I8,
            "uint8" | "byte" | "char" => Self::U8,
            "int16" => Self::I16,
            "uint16" => Self::U16,
            "int32" => Self::I32,
            "uint32" => Self::U32,
            "int64" => Self::I64,
            "uint64" => Self::U64,
            "float32" => Self::F32,
            "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum FieldKind {
    Number(Number),
    /// `builtin_interfaces/Time` or `Duration`.
    Time,
    Text,
    WideText,
    /// A message, by its package and name.
    Message(String),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    One,
    Fixed(usize),
    Variable,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: FieldKind,
    pub(super) count: Count,
}

/// A type of message with the types within it.
#[derive(Debug)]
pub(in crate::recording) struct Schema {
    types: BTreeMap<String, Vec<Field>>,
    root: String,
}

impl Schema {
    /// Parses the definition of `name`, such as `sensor_msgs/msg/Imu`.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub(in crate::recording) fn parse(name: &str, text: &str) -> Result<Self, String> {
        let root = plain(name);
        let mut types = BTreeMap::new();
        let mut own = root.clone();
        let mut fields = Vec::new();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if let Some(next) = line.strip_prefix("MSG:") {
                types.insert(std::mem::replace(&mut own, plain(next.trim())), fields);
                fields = Vec::new();
            } else if line.starts_with("IDL:") || line.starts_with("module ") {
                return Err("definitions in IDL are not read".into());
            } else if !line.is_empty() && !line.bytes().all(|b| b == b'=') {
                let package = own.split('/').next().unwrap_or_default();
                fields.extend(field(line, package)?);
            }
        }
        types.insert(own, fields);
        Ok(Self { types, root })
    }

    pub(super) fn root(&self) -> &str {
        &self.root
    }

    /// The fields of a type; `None` where it is not defined.
    pub(super) fn fields(&self, name: &str) -> Option<&[Field]> {
        self.types.get(name).map(Vec::as_slice)
    }
}

/// `package/Name` of `package/msg/Name`.
pub(super) fn plain(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// The field of a line; `None` of a constant.
fn field(line: &str, package: &str) -> Result<Option<Field>, String> {
    let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(|| format!("`{line}`"))?;
    let rest = rest.trim_start();
    let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
    let (name, rest) = rest.split_at(end);
    if name.is_empty() {
        return Err(format!("`{line}` has no name"));
    }
    if rest.trim_start().starts_with('=') {
        return Ok(None);
    }
    let (item, count) = match kind.strip_suffix(']').and_then(|kind| kind.rsplit_once('[')) {
        None => (kind, Count::One),
        Some((item, "")) => (item, Count::Variable),
        Some((item, bound)) if bound.starts_with("<=") => (item, Count::Variable),
        Some((item, count)) => match count.parse() {
            Ok(count) if count > 0 => (item, Count::Fixed(count)),
            _ => return Err(format!("`{line}` has a length of `{count}`")),
        },
    };
    // A string may be bounded, as in `string<=10`.
    let item = item.split("<=").next().unwrap_or(item);
    let kind = match item {
        "string" => FieldKind::Text,
        "wstring" => FieldKind::WideText,
        "time" | "duration" => FieldKind::Time,
        "Header" => FieldKind::Message("std_msgs/Header".into()),
        _ => match (Number::from_name(item), item.contains('/')) {
            (Some(number), _) => FieldKind::Number(number),
            (None, true) => FieldKind::Message(plain(item)),
            (None, false) => FieldKind::Message(format!("{package}/{item}")),
        },
    };
    let is_time = matches!(&kind, FieldKind::Message(name)
        if matches!(name.as_str(), "builtin_interfaces/Time" | "builtin_interfaces/Duration"));
    let kind = if is_time { FieldKind::Time } else { kind };
    Ok(Some(Field { name: name.into(), kind, count }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_read_as_they_are_spelt() {
        let text = "# a comment\nuint8 ON=1\nstring MODE = \"a # b\"\nstd_msgs/Header header\n\
            float64[9] covariance # row by row\nint32[<=4] few 5\nstring<=10 name \"x=1\"\nInner[2] both\n\
            ================\nMSG: p/Inner\nbyte b\nbuiltin_interfaces/Time at\nwstring w\n";
        let schema = Schema::parse("p/msg/Outer", text).unwrap();
        let fields = |name| {
            let fields = schema.fields(name).unwrap().iter();
            fields.map(|f| (f.name.as_str(), f.kind.clone(), f.count)).collect::<Vec<_>>()
        };
        let message = |name: &str| FieldKind::Message(name.into());
        assert_eq!(
            fields("p/Outer"),
            [
                ("header", message("std_msgs/Header"), Count::One),
                ("covariance", FieldKind::Number(Number::F64), Count::Fixed(9)),
                ("few", FieldKind::Number(Number::I32), Count::Variable),
                ("name", FieldKind::Text, Count::One),
                ("both", message("p/Inner"), Count::Fixed(2)),
            ]
        );
        assert_eq!(
            fields("p/Inner"),
            [
                ("b", FieldKind::Number(Number::U8), Count::One),
                ("at", FieldKind::Time, Count::One),
                ("w", FieldKind::WideText, Count::One),
            ]
        );
        for wrong in ["float64[0] x", "float64[-1] x", "float64", "float64 [3]"] {
            assert!(Schema::parse("p/msg/T", wrong).is_err(), "{wrong}");
        }
    }
}
