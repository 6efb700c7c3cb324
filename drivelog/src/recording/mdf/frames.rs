//! CAN frames of a bus log.

use super::values::numbers;
use crate::recording::can::{Identifier, Seen};
use falcon_mdf::error::Mf4Error;
use falcon_mdf::model::{Signal, SignalValues};
use falcon_mdf::stream::SignalsChunks;
use falcon_mdf::{ChannelGroup, Mf4File};
use std::collections::BTreeMap;

/// Places of the parts of a CAN frame among the channels that are read.
pub(super) struct Fields {
    names: Vec<usize>,
    time: usize,
    id: usize,
    is_extended: Option<usize>,
    bus: Option<usize>,
    length: Option<usize>,
    data: Option<usize>,
}

impl Fields {
    /// The parts of the frames of a group; `None` where it has none.
    pub(super) fn from_group(group: &ChannelGroup) -> Option<Self> {
        let find = |name: &str| {
            let name = format!("CAN_DataFrame.{name}");
            group.channels.iter().position(|c| c.name == name)
        };
        let time = group.channels.iter().position(falcon_mdf::Channel::is_time_channel)?;
        let (id, data) = (find("ID")?, find("DataBytes")?);
        let optional = [find("IDE"), find("BusChannel"), find("DataLength"), Some(data)];
        let mut names = vec![time, id];
        let mut place = |k: Option<usize>| {
            names.extend(k);
            k.map(|_| names.len() - 1)
        };
        let [is_extended, bus, length, data] = optional.map(&mut place);
        Some(Self { names, time: 0, id: 1, is_extended, bus, length, data })
    }

    pub(super) fn frames(&self, signals: &[Signal]) -> FrameColumns {
        let own = |k: usize| numbers(signals[k].channel(), &signals[k]);
        let column = |k: Option<usize>| k.map(own);
        FrameColumns {
            time: own(self.time),
            id: own(self.id),
            is_extended: column(self.is_extended),
            bus: column(self.bus),
            length: column(self.length),
            data: self.data.and_then(|k| signals.get(k)).and_then(|s| s.values().ok()),
        }
    }
}

pub(super) struct FrameColumns {
    time: Vec<f64>,
    id: Vec<f64>,
    is_extended: Option<Vec<f64>>,
    bus: Option<Vec<f64>>,
    length: Option<Vec<f64>>,
    data: Option<SignalValues>,
}

impl FrameColumns {
    pub(super) fn each(&self, count: usize, mut take: impl FnMut(Identifier, f64, &[u8])) {
        for k in 0..count {
            let raw = self.id[k] as u32;
            let is_extended = match &self.is_extended {
                Some(flags) => flags[k] != 0.0,
                None => raw & 0x8000_0000 != 0 || raw & 0x1FFF_FFFF > 0x7FF,
            };
            let bus = self.bus.as_ref().map_or(0.0, |bus| bus[k]);
            let data = self.data.as_ref().and_then(|data| data.bytes_at(k)).unwrap_or_default();
            let length = self.length.as_ref().map_or(data.len(), |length| length[k] as usize);
            let data = &data[..length.min(data.len())];
            let id = raw & 0x1FFF_FFFF;
            take(Identifier { bus: format!("CAN{bus}"), id, is_extended }, self.time[k], data);
        }
    }
}

/// The parts of the frames of a group, with or without the data.
pub(super) fn bus(
    mdf: &Mf4File,
    data: usize,
    group: usize,
    with_data: bool,
    most: usize,
) -> Result<(Fields, SignalsChunks<'_>), Mf4Error> {
    let own = &mdf.data_groups()[data].channel_groups[group];
    let none = || Mf4Error::parse_error("no CAN frames");
    let mut fields = Fields::from_group(own).ok_or_else(none)?;
    if !with_data {
        fields.names.pop();
        fields.data = None;
    }
    let channels: Vec<&falcon_mdf::Channel> =
        fields.names.iter().map(|&k| &own.channels[k]).collect();
    let chunks = mdf.signals_chunks(&channels, most)?;
    Ok((fields, chunks))
}

/// Counts the kinds of frames of a group.
pub(super) fn scan(
    mdf: &Mf4File,
    data: usize,
    group: usize,
    seen: &mut BTreeMap<Identifier, Seen>,
) -> Result<(), Mf4Error> {
    let (fields, chunks) = bus(mdf, data, group, false, 1 << 14)?;
    for signals in chunks {
        let signals = signals?;
        let count = signals.first().map_or(0, Signal::len);
        fields
            .frames(&signals)
            .each(count, |identifier, time, _| Seen::note(seen, identifier, time));
    }
    Ok(())
}
