//! MDF 3 and older: the values of a channel group are decoded as a whole.

use super::source::Source;
use super::values::place;
use crate::Error;
use crate::recording::bytes::LogFile;
use crate::recording::{Channel, Columns, Group, Pieces, Recording, Request, Rows};
use falcon_mdf::mdf3::{Mdf3ChannelGroup, Mdf3File};
use std::rc::Rc;
use std::sync::Arc;

/// Codes of data types that are texts or bytes.
const TEXTS: [u16; 2] = [7, 8];

struct Mdf3 {
    name: String,
    file: Mdf3File,
    groups: Vec<Group>,
    /// Data group, channel group and channels of each group.
    parts: Vec<(usize, usize, Vec<usize>)>,
    losses: Vec<String>,
}

pub(super) fn open<'a>(
    file: &LogFile<'a>,
    source: Source,
) -> Result<Box<dyn Recording + 'a>, Error> {
    let failed = |byte, problem: String| Error::Read { file: file.name.clone(), byte, problem };
    let mdf =
        Mdf3File::from_source(Arc::new(source)).map_err(|e| failed(place(&e), e.to_string()))?;
    let (mut groups, mut parts) = (Vec::new(), Vec::new());
    for (d, data) in mdf.data_groups().iter().enumerate() {
        for (c, own) in data.channel_groups.iter().enumerate() {
            let (group, channels) = group(&file.name, own, groups.len());
            if channels.len() > usize::from(group.clock.is_some()) {
                groups.push(group);
                parts.push((d, c, channels));
            }
        }
    }
    if groups.is_empty() {
        return Err(failed(0, "no channel has numbers".into()));
    }
    Ok(Box::new(Mdf3 { name: file.name.clone(), file: mdf, groups, parts, losses: Vec::new() }))
}

fn group(file: &str, own: &Mdf3ChannelGroup, before: usize) -> (Group, Vec<usize>) {
    let all = own.channels.iter().enumerate();
    let places: Vec<usize> =
        all.filter(|(_, c)| !TEXTS.contains(&c.data_type)).map(|(k, _)| k).collect();
    let channels = places.iter().map(|&k| {
        let channel = &own.channels[k];
        Channel::new(&channel.name, Some(if channel.is_time() { "s" } else { &channel.unit }))
    });
    let mut group = Group::new(file, &format!("group {}", before + 1), channels.collect());
    group.clock = places.iter().position(|&k| own.channels[k].is_time());
    group.rows = Some(own.cycle_count.into());
    (group, places)
}

impl Recording for Mdf3 {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let mut pieces = Vec::new();
        for (w, wanted) in request.wanted.iter().enumerate() {
            let (data, group, channels) = &self.parts[wanted.group];
            let values = wanted.channels.iter().map(|&c| {
                let read = self.file.channel_physical(*data, *group, channels[c]);
                read.map(|values| values.to_f64())
            });
            match values.collect::<Result<Vec<Vec<f64>>, _>>() {
                Ok(values) => pieces.push((w, values)),
                Err(error) => self.losses.push(format!(
                    "{}: a channel group is not read: byte {}: {error}",
                    self.name,
                    place(&error)
                )),
            }
        }
        Ok(Box::new(pieces.into_iter().flat_map(move |(w, values)| {
            let rows = values.first().map_or(0, Vec::len);
            (0..rows).step_by(request.most).map(move |from| {
                let part = from..from.saturating_add(request.most).min(rows);
                let lines = Rc::new((from as u64 + 1..=part.end as u64).collect());
                let values = values.iter().map(|values| values[part.clone()].to_vec()).collect();
                Ok(Rows { wanted: w, columns: Columns { values, lines } })
            })
        })))
    }

    fn losses(&self) -> Vec<String> {
        self.losses.clone()
    }
}
