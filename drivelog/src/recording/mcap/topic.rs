//! Topics: the channels of their messages, and how their numbers are read.

use super::chunk::{MOST_MESSAGE, plain};
use super::content::{Content, Ends};
use super::json::Paths;
use super::records::Schema;
use crate::recording::ros::{self, Definitions, Layout, describe, seconds};
use crate::recording::{Channel, Group};
use serde_json::Value;
use std::collections::BTreeMap;

/// Places of the channels that every message has.
pub(super) const LOG_TIME: usize = 0;
pub(super) const PUBLISH_TIME: usize = 1;
/// Where the fields follow.
pub(super) const FIELDS: usize = 2;
/// How much the delay from stamp to log may change within a file, and how far around a window is read, s.
const SAME_DELAY: f64 = 1.0;
const AROUND: f64 = 5.0;

/// The messages of a topic that are of one type.
#[derive(Debug)]
pub(super) struct Topic {
    pub(super) ids: Vec<u16>,
    pub(super) messages: Messages,
    /// Delays from the clock to the log time, s: smallest and largest; `None` where they are unsteady.
    delays: Option<(f64, f64)>,
}

#[derive(Debug)]
pub(super) enum Messages {
    Ros(Layout),
    /// The path to each field.
    Json(Vec<Vec<String>>),
    /// Why they are not read.
    Unread(String),
}

/// The topics of a file, with their groups.
pub(super) fn topics(
    file: &str,
    content: &Content,
    definitions: Definitions<'_>,
) -> (Vec<Group>, Vec<Topic>) {
    let mut ids: BTreeMap<(&str, &str, &str, u16), Vec<u16>> = BTreeMap::new();
    for (id, channel) in &content.channels {
        let schema = content.schemas.get(&channel.schema);
        // Publishers of one topic have channels of their own.
        let kind = schema.map_or("", |schema| schema.name.as_str());
        let other = if schema.is_none() { channel.schema } else { 0 };
        ids.entry((&channel.topic, kind, &channel.encoding, other)).or_default().push(*id);
    }
    let mut all: Vec<Vec<u16>> = ids.into_values().collect();
    all.sort();
    all.into_iter().filter_map(|ids| topic(file, content, definitions, ids)).unzip()
}

fn topic(
    file: &str,
    content: &Content,
    definitions: Definitions<'_>,
    ids: Vec<u16>,
) -> Option<(Group, Topic)> {
    let channel = content.channels.get(ids.first()?)?;
    let schema = content.schemas.get(&channel.schema);
    let ends: Vec<&Ends> = ids.iter().filter_map(|id| content.ends.get(id)).collect();
    let first = ends.iter().min_by_key(|ends| ends.first.0);
    let last = ends.iter().max_by_key(|ends| ends.last.0);
    let json = Paths(ends.iter().flat_map(|e| e.json.0.iter().cloned()).collect());
    let messages = messages(&channel.encoding, schema, definitions, json);
    let mut channels =
        vec![Channel::new("log_time", Some("s")), Channel::new("publish_time", Some("s"))];
    let mut clock = LOG_TIME;
    let kind = schema.map_or("", |schema| schema.name.as_str());
    match &messages {
        Messages::Ros(layout) => {
            for (path, is_time) in &layout.leaves {
                let mut channel = Channel::new(path, if *is_time { Some("s") } else { None });
                describe(kind, &mut channel);
                channels.push(channel);
            }
            let is_stamped = first.is_some_and(|ends| ends.first.1.is_some_and(|t| t != 0));
            if let Some(leaf) = layout.stamp.filter(|_| is_stamped) {
                clock = FIELDS + leaf;
            }
        }
        Messages::Json(paths) => {
            channels.extend(paths.iter().map(|path| Channel::new(&path.join("."), None)));
        }
        Messages::Unread(_) => {}
    }
    let times = |(log, stamp): (u64, Option<i64>)| {
        let log = ros::seconds(i64::try_from(log).unwrap_or(i64::MAX));
        (log, if clock == LOG_TIME { log } else { stamp.map_or(f64::NAN, seconds) })
    };
    let ends = first.zip(last).map(|(a, b)| [times(a.first), times(b.last)]);
    let mut group = Group::new(file, &channel.topic, channels);
    group.kind = kind.into();
    group.clock = Some(clock);
    let counts = content.counts.as_ref();
    group.rows = counts.map(|all| ids.iter().filter_map(|id| all.get(id)).sum());
    group.span_s = ends.map(|[(_, first), (_, last)]| (first, last)).filter(|(a, b)| a <= b);
    let delays = ends.map(|ends| ends.map(|(log, clock)| log - clock));
    let delays = delays.filter(|[a, b]| (a - b).abs() <= SAME_DELAY);
    let delays = delays.map(|[a, b]| (a.min(b), a.max(b)));
    Some((group, Topic { ids, messages, delays }))
}

fn messages(
    encoding: &str,
    schema: Option<&Schema>,
    definitions: Definitions<'_>,
    mut json: Paths,
) -> Messages {
    let unread = |why: String| Messages::Unread(why);
    match (encoding, schema) {
        ("cdr", Some(schema)) => {
            let is_in_file = schema.encoding == "ros2msg" && !schema.text.trim().is_empty();
            let own = if is_in_file {
                Some(ros::Schema::parse(&schema.name, &schema.text))
            } else {
                definitions.schema(&schema.name)
            };
            match own.map(|own| own.and_then(|own| Layout::from_schema(&own))) {
                Some(Ok(layout)) => Messages::Ros(layout),
                Some(Err(why)) => {
                    unread(format!("the definition of {} is not read: {why}", schema.name))
                }
                None if schema.text.trim().is_empty() => unread(format!(
                    "no definition of {}: its fields are not read; {DEFINE}",
                    schema.name
                )),
                None => unread(format!(
                    "definitions in {} are not read; {DEFINE}",
                    quoted(&schema.encoding)
                )),
            }
        }
        ("cdr", None) => unread("the messages have no definition".into()),
        ("json", _) => {
            if let Some(schema) = schema.filter(|schema| schema.encoding == "jsonschema") {
                json.add_schema(&schema.text);
            }
            Messages::Json(json.0.into_iter().collect())
        }
        _ => unread(format!("messages in {} are not read", quoted(encoding))),
    }
}

/// What to do about a type without a definition.
const DEFINE: &str = "state the folder of its package with --ros-definitions";

fn quoted(encoding: &str) -> String {
    if encoding.is_empty() { "an encoding without a name".into() } else { encoding.into() }
}

impl Topic {
    /// Log times of the messages in a window of the clock, ns.
    pub(super) fn log_times(&self, window_s: Option<(f64, f64)>) -> (u64, u64) {
        let Some(((from, to), (least, most))) = window_s.zip(self.delays) else {
            return (0, u64::MAX);
        };
        // A conversion beyond the range ends at its bounds.
        (((from + least - AROUND) * 1e9) as u64, ((to + most + AROUND) * 1e9) as u64)
    }

    /// Reads fields of a message: of each field the place in `row`, or none beyond its length.
    pub(super) fn read(
        &self,
        data: &[u8],
        places: &[usize],
        row: &mut [f64],
    ) -> Result<(), &'static str> {
        let data = &plain(data, MOST_MESSAGE)?;
        match &self.messages {
            Messages::Ros(layout) => layout.read(data, places, row),
            Messages::Json(paths) => {
                let value: Value =
                    serde_json::from_slice(data).map_err(|_| "messages are not JSON")?;
                for (path, place) in paths.iter().zip(places) {
                    let Some(to) = row.get_mut(*place) else { continue };
                    let field = path.iter().try_fold(&value, |value, key| value.get(key));
                    *to = match field {
                        Some(Value::Bool(on)) => f64::from(u8::from(*on)),
                        Some(Value::Number(x)) => x.as_f64().unwrap_or(f64::NAN),
                        _ => f64::NAN,
                    };
                }
                Ok(())
            }
            Messages::Unread(_) => Ok(()),
        }
    }
}
