//! Tables of known programs that state their units in documentation or in the text above the table.

use super::head::Head;
use super::stamps::Stamps;
use crate::recording::Channel;
use crate::role::Role;
use crate::units::{Quantity, parse_unit, unit_of_header};

/// comma.ai's steering-control data set: command from −1 to 1, speeds and accelerations in SI.
const STEERING_CONTROL: &[(&str, &str)] = &[
    ("t", "s"),
    ("latActive", "1"),
    ("steeringPressed", "1"),
    ("vEgo", "m/s"),
    ("aEgo", "m/s2"),
    ("steeringAngleDeg", "deg"),
    ("steer", "1"),
    ("steerFiltered", "1"),
    ("roll", "rad"),
    ("latAccelDesired", "m/s2"),
    ("latAccelSteeringAngle", "m/s2"),
    ("latAccelLocalizer", "m/s2"),
];

/// `rostopic echo -p`: both stamps are instants of ROS.
const ROSTOPIC: &[(&str, &str)] = &[("time", "ns"), ("field.header.stamp", "ns")];

/// RaceRender, which TrackAddict and others write: both are seconds.
const RACE_RENDER: &[(&str, &str)] = &[("Time", "s"), ("UTC Time", "s")];

/// The clock of PlotJuggler.
const PLOTJUGGLER: &[(&str, &str)] = &[("__time", "s")];

/// Units and roles of the columns of known programs, where the table does not state them.
pub(super) fn complete(head: &mut Head, channels: &mut [Channel]) {
    let has = |name: &str| head.header.iter().any(|own| own == name);
    let is_ros = has("time") && head.header.iter().any(|name| name.starts_with("field."));
    let is_control = STEERING_CONTROL.iter().all(|(name, _)| has(name));
    let units = [
        (is_control, STEERING_CONTROL),
        (is_ros, ROSTOPIC),
        (has("__time"), PLOTJUGGLER),
        (has("GPS_Update"), RACE_RENDER),
    ];
    let units = units.into_iter().filter(|(is_known, _)| *is_known).flat_map(|(_, units)| units);
    let units: Vec<(&str, &str)> = units.copied().collect();
    for channel in channels.iter_mut().filter(|channel| channel.unit.is_none()) {
        let unit = units.iter().find(|(name, _)| *name == channel.name);
        channel.unit = unit.map(|(_, unit)| (*unit).into());
    }
    for (place, channel) in channels.iter_mut().enumerate() {
        // LabVIEW, whose x is the time unless the user makes it another quantity or leaves it out.
        let is_x = channel.name == "X_Value" && channel.unit.is_none();
        if is_x && !head.text.iter().any(|line| is_other_x(line)) {
            let rows = if head.are_empty[place] { rows_of_labview(&head.text) } else { None };
            if rows.is_some() {
                (head.stamps[place], channel.has_stamps) = (rows, true);
            }
            if rows.is_some() || !head.are_empty[place] {
                (channel.role, channel.unit) = (Some(Role::Time), Some("s".into()));
            }
        }
        // ControlDesk of dSPACE.
        let unit = channel.unit.as_deref().and_then(parse_unit);
        if channel.name.eq_ignore_ascii_case("xaxis")
            && unit.is_some_and(|unit| unit.quantity == Quantity::Time)
        {
            channel.role = Some(Role::Time);
        }
    }
    of_race_capture(channels);
    let section = |name: &str| -> Vec<&str> {
        let lines = head.text.iter().map(String::as_str);
        let lines = lines.skip_while(|line| !line.eq_ignore_ascii_case(name));
        lines.skip(1).take_while(|line| !line.starts_with('[')).collect()
    };
    if head.text.iter().any(|line| line.eq_ignore_ascii_case("[column names]")) {
        let (mut names, mut units) = (section("[header]"), section("[channel units]"));
        // Blank lines end a section; others are channels without a unit.
        while names.pop_if(|line| line.is_empty()).is_some() {
            units.pop_if(|line| line.is_empty());
        }
        vbox(&names, &units, channels, &mut head.stamps);
    }
}

/// RaceCapture states name, unit, range and rate in each name: `"Speed"|"km/h"|0.0|150.0|10`.
fn of_race_capture(channels: &mut [Channel]) {
    let parts = |channel: &Channel| -> Vec<String> {
        channel.name.split('|').map(|part| part.trim_matches('"').to_owned()).collect()
    };
    if channels.len() < 2 || channels.iter().any(|channel| parts(channel).len() < 3) {
        return;
    }
    for channel in channels {
        let parts = parts(channel);
        *channel = Channel {
            has_stamps: channel.has_stamps,
            is_text: channel.is_text,
            unread: channel.unread.clone(),
            ..Channel::new(&parts[0], Some(&parts[1]))
        };
        if channel.name == "Interval" {
            channel.role = Some(Role::Time);
        }
    }
}

/// Whether the names are those of a table with a frame of a bus in each row.
pub(super) fn has_frames(names: &[String]) -> bool {
    let plain = |name: &String| name.replace([' ', '_'], "").to_lowercase();
    let names: Vec<String> = names.iter().map(plain).collect();
    let has = |all: &[&str]| names.iter().any(|name| all.contains(&name.as_str()));
    has(&["id", "addr", "address", "canid", "arbid", "arbitrationid", "identifier", "messageid"])
        && has(&["data", "databytes", "data0", "data1", "d0", "d1", "b0", "b1", "byte0", "byte1"])
}

/// `X_Dimension` of another quantity than time.
fn is_other_x(line: &str) -> bool {
    let mut words = line.split_whitespace();
    words.next() == Some("X_Dimension") && words.any(|word| word != "Time")
}

/// The clock of a file without a column for it: `X0` and `Delta_X`, which all channels share.
fn rows_of_labview(text: &[String]) -> Option<Stamps> {
    let shared = |key: &str| {
        let line = text.iter().rev().find_map(|line| line.strip_prefix(key))?;
        let numbers = line.split_whitespace().map(|x| x.replace(',', ".").parse::<f64>().ok());
        let numbers = numbers.collect::<Option<Vec<f64>>>()?;
        let first = *numbers.first()?;
        if numbers.iter().all(|x| *x == first) { Some(first) } else { None }
    };
    let step = shared("Delta_X").filter(|step| *step > 0.0)?;
    Some(Stamps::of_rows(shared("X0")?, step))
}

/// The columns of each clock: where the name of the first column is that of a time and stands again, each of them begins
/// the channels of another clock.
pub(super) fn parts(channels: &[Channel]) -> Vec<Vec<usize>> {
    let whole = || vec![(0..channels.len()).collect()];
    let Some(first) = channels.first().filter(|own| own.is_named_like(Role::Time)) else {
        return whole();
    };
    let mut parts: Vec<Vec<usize>> = Vec::new();
    for (column, channel) in channels.iter().enumerate() {
        if channel.name == first.name {
            parts.push(Vec::new());
        }
        parts.last_mut().into_iter().for_each(|part| part.push(column));
    }
    if parts.len() < 2 || parts.iter().any(|part| part.len() < 2) { whole() } else { parts }
}

/// Racelogic VBOX: the time of day as digits, the place in minutes with west positive; units of the speeds in the list
/// of names, and those of further channels, which are the last ones, in a list of their own.
fn vbox(names: &[&str], units: &[&str], channels: &mut [Channel], stamps: &mut [Option<Stamps>]) {
    for (channel, name) in channels.iter_mut().zip(names) {
        channel.unit = unit_of_header(name).map(|unit| unit.name.into());
    }
    let units = units.iter().rev().zip(channels.iter_mut().rev());
    for (unit, channel) in units.filter(|(unit, _)| !matches!(**unit, "" | "(null)")) {
        channel.unit = Some((*unit).into());
    }
    for (channel, stamps) in channels.iter_mut().zip(stamps) {
        let (role, unit) = match &*channel.name {
            "lat" => (Role::Latitude, "arcmin"),
            "long" => (Role::Longitude, "arcmin west"),
            "time" => {
                *stamps = Some(Stamps::of_digits());
                channel.has_stamps = true;
                continue;
            }
            _ => continue,
        };
        (channel.role, channel.unit) = (Some(role), Some(unit.into()));
    }
}
