//! Reading files as drives, and drives as one recording.

use crate::channel_units::unit_of;
use crate::channels::Opened;
use crate::drive::{Drive, grouped};
use crate::error::{last_part, stem};
use crate::expression::terms;
use crate::gnss::Gnss;
use crate::log::DriveLog;
use crate::options::{LogOptions, Response};
use crate::recording::Group;
use crate::recording::{self, LogFile, Recording};
use crate::role::Role;
use crate::series::Series;
use crate::units::Quantity;
use crate::{Error, channel_units, segments};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use steerwright_formats::ChannelSummary;

/// Reads log files that are in memory, of any format, each with a clock of its own.
///
/// Files with steering and yaw rate are drives of their own; other files are channels of one drive.
/// [`read_drives`] accepts files that are grouped already, and describes the rest.
///
/// # Errors
/// [`Error`] with file, line and column.
pub fn read_log(files: &[(String, Vec<u8>)], options: &LogOptions) -> Result<DriveLog, Error> {
    let files = files.iter().map(|(name, bytes)| LogFile::of_bytes(name, bytes)).collect();
    read_drives(files, Vec::new(), options)
}

/// Reads drives as one recording on one sample time: `files`, which are grouped by what they bring,
/// and `drives`, each the files of one drive.
///
/// The mapped columns of a drive are merged onto a uniform grid over the time that all of them cover within
/// the windows. Blank cells and gaps up to `max_gap_s` are bridged by straight lines; a longer gap splits the
/// drive, and so does a speed window. Segments too short to identify from are left out, with a warning.
///
/// The sample time is the requested one, or else the multiple of the log's own period that comes
/// nearest to 0.02 s from below (0.02 s where the clocks differ or are irregular), or the log's own
/// period where there is next to no noise; the longest of those of the drives.
///
/// # Errors
/// [`Error`] with file, line and column.
pub fn read_drives(
    files: Vec<LogFile<'_>>,
    drives: Vec<Vec<LogFile<'_>>>,
    options: &LogOptions,
) -> Result<DriveLog, Error> {
    check_options(options)?;
    let files = open(files, options)?;
    let drives = drives.into_iter().filter(|files| !files.is_empty());
    let drives = drives.map(|files| open(files, options)).collect::<Result<Vec<_>, Error>>()?;
    let groups: Vec<&Group> =
        files.iter().chain(drives.iter().flatten()).flat_map(Opened::groups).collect();
    let options = for_channels(options, &groups)?;
    let mut all = grouped(files, &options)?;
    all.extend(drives);
    merged(all, &options)
}

/// Reads recordings of one drive, such as columns [in memory](crate::in_memory), as [`read_drives`] reads
/// files.
///
/// # Errors
/// [`Error`] with recording, row and channel.
pub fn read_recordings(
    recordings: Vec<Box<dyn Recording + '_>>,
    options: &LogOptions,
) -> Result<DriveLog, Error> {
    check_options(options)?;
    let files = recordings.into_iter().map(|recording| opened(recording, options));
    let files = files.collect::<Result<Vec<_>, Error>>()?;
    let groups: Vec<&Group> = files.iter().flat_map(Opened::groups).collect();
    let options = for_channels(options, &groups)?;
    merged(grouped(files, &options)?, &options)
}

/// The options for [`Response::Channels`] where several inputs or outputs are named, or one of each that is no steering
/// and no yaw rate; otherwise those that are there.
fn for_channels<'o>(
    options: &'o LogOptions,
    groups: &[&Group],
) -> Result<Cow<'o, LogOptions>, Error> {
    /// Of either.
    const MOST: usize = 64;
    let (inputs, outputs) = (&options.inputs, &options.outputs);
    let is_stated = options.response == Response::Channels;
    let of_motion = matches!(options.response, Response::YawRate | Response::Motion);
    let is_open = of_motion && inputs.len() == 1 && outputs.len() == 1;
    let is_several = of_motion && inputs.len().max(outputs.len()) > 1;
    if !(is_stated || is_several || is_open && !are_of_a_vehicle(options, groups)) {
        return Ok(Cow::Borrowed(options));
    }
    let count = 1..=MOST;
    if !(count.contains(&inputs.len()) && count.contains(&outputs.len())) {
        return Err(Error::NamedChannels { inputs: inputs.len(), outputs: outputs.len() });
    }
    let mut seen = BTreeSet::new();
    for name in inputs.iter().chain(outputs) {
        let name = name.strip_prefix('-').unwrap_or(name);
        if !seen.insert(name) {
            let is_in =
                |names: &[String]| names.iter().any(|own| own.trim_start_matches('-') == name);
            let roles = match [is_in(inputs), is_in(outputs)] {
                [true, true] => "as an input and as an output",
                [true, false] => "as an input twice",
                _ => "as an output twice",
            };
            return Err(Error::NamedTwice { column: name.into(), roles });
        }
    }
    let mut options = options.clone();
    options.response = Response::Channels;
    // Rows without a clock are as far apart as the samples that are wanted.
    options.row_period_s = options.row_period_s.or(options.sample_time_s);
    check_options(&options)?;
    Ok(Cow::Owned(options))
}

/// Whether one input and one output are the steering and the yaw rate of a vehicle, by their units and names; of a
/// combination of channels by those of the first.
fn are_of_a_vehicle(options: &LogOptions, groups: &[&Group]) -> bool {
    let unit = |names: &[String], role: Role| {
        let name = names[0].strip_prefix('-').unwrap_or(&names[0]);
        let combined = terms(&names[0]);
        let mut first = combined.iter().flatten().flat_map(|(_, names)| names);
        let name = first.next().copied().unwrap_or(name);
        let name = name.rsplit_once(':').map_or(name, |(_, name)| name);
        let (group, channel) = groups.iter().find_map(|g| Some((g, g.find(name)?)))?;
        let is_named_like = group.channels[channel].is_named_like(role);
        Some((is_named_like, unit_of(group, channel, options).ok().map(|unit| unit.quantity)))
    };
    let input = unit(&options.inputs, Role::Steering);
    let output = unit(&options.outputs, Role::YawRate);
    // What is no column of that name is left to the reader, which names the columns that there are.
    let (Some((is_steering, input)), Some((is_yaw_rate, output))) = (input, output) else {
        return true;
    };
    let is_angle = is_steering || input == Some(Quantity::Angle);
    let is_angular = matches!(output, Some(Quantity::AngularRate | Quantity::Angle));
    let is_rate =
        is_yaw_rate || is_angular || (output == Some(Quantity::Dimensionless) && is_angle);
    (is_angle || input == Some(Quantity::Dimensionless)) && is_rate
}

fn merged(groups: Vec<Vec<Opened<'_>>>, options: &LogOptions) -> Result<DriveLog, Error> {
    let first = groups.first().and_then(|files| files[0].recording.groups().first());
    let Some(first) = first else { return Err(Error::NoFiles) };
    let name = stem(&first.file);
    channel_units::check_units_are_used(groups.iter().flatten().flat_map(Opened::groups), options)?;
    let mut warnings: Vec<String> = options.without_effect();
    let all = groups.iter().flatten().flat_map(Opened::groups);
    warnings.extend(channel_units::unused_databases(all, options));
    let drives = groups
        .into_iter()
        .map(|files| {
            let mut drive = Drive::read(files, options, &mut warnings)?;
            segments::leave_out_unusable(&mut drive, options, &mut warnings);
            Ok(drive)
        })
        .collect::<Result<Vec<_>, Error>>()?;
    check_repeated(&drives)?;
    let mut used = options.to_map();
    if drives.len() > 1 {
        let names: Vec<&str> = drives.iter().map(|d| d.name.as_str()).collect();
        used.insert("drives".into(), names.join("; "));
    }
    if drives.iter().any(|d| d.start_s != 0.0) {
        let starts: Vec<String> = drives.iter().map(|d| d.start_s.to_string()).collect();
        used.insert("log_start_s".into(), starts.join("; "));
    }
    let mut log = DriveLog {
        name,
        sample_time_s: 0.0,
        response: options.response,
        segments: Vec::new(),
        input: Vec::new(),
        output: Vec::new(),
        speed: if has_speed(&drives, options, &mut warnings)? { Some(Vec::new()) } else { None },
        others: others(&drives, options, &mut warnings),
        steering_ratio: drives[0].steering_ratio,
        vehicle_class: options.vehicle_class,
        gnss: None,
        channels: channels(&drives),
        warnings,
        sources: drives.iter().flat_map(|d| d.files.iter().cloned()).collect(),
        options: used,
    };
    log.fill(&drives, options)?;
    log.gnss = Gnss::from_drives(&drives, options);
    let has_receiver = options.gnss_latency_s.is_some() || options.antenna_x_m != 0.0;
    if has_receiver && log.gnss.is_none() && options.response.is_of_yaw_rate() {
        log.warnings.push(
            "the log has no fixes (x_m and y_m, or latitude and longitude): the stated latency of the receiver and place of the antenna are not used".into(),
        );
    }
    log.options.insert("sample_time_used_s".into(), log.sample_time_s.to_string());
    let mut seen = std::collections::BTreeSet::new();
    log.warnings.retain(|warning| seen.insert(warning.clone()));
    Ok(log)
}

fn open<'a>(files: Vec<LogFile<'a>>, options: &LogOptions) -> Result<Vec<Opened<'a>>, Error> {
    files.into_iter().map(|file| opened(recording::open(file, options)?, options)).collect()
}

/// The recording with the groups that the options name, or all.
pub(crate) fn opened<'a>(
    recording: Box<dyn Recording + 'a>,
    options: &LogOptions,
) -> Result<Opened<'a>, Error> {
    let groups = recording.groups();
    let is_used = |place: &usize| {
        options.topics.is_empty() || options.topics.iter().any(|t| groups[*place].is_called(t))
    };
    let places: Vec<usize> = (0..groups.len()).filter(is_used).collect();
    if places.is_empty() {
        let file = match groups.first() {
            Some(group) => group.file.clone(),
            None => String::new(),
        };
        let names: Vec<&str> = groups.iter().map(|group| group.name.as_str()).collect();
        let (topics, available) = (options.topics.join(", "), names.join(", "));
        return Err(Error::NoSuchTopic { file, topics, available });
    }
    Ok(Opened { recording, places })
}

pub(crate) fn check_options(options: &LogOptions) -> Result<(), Error> {
    let positive = |option, value: Option<f64>| match value {
        Some(x) if !(x.is_finite() && x > 0.0) => {
            Err(Error::Option { option, value: x.to_string(), expected: "a number above 0".into() })
        }
        _ => Ok(()),
    };
    if let Some(ratio) = options.steering_ratio.filter(|r| !(0.01..=1000.0).contains(r)) {
        let (option, value) = ("steering ratio", format!("{ratio:?}"));
        return Err(Error::Option { option, value, expected: "0.01 to 1000".into() });
    }
    for role in options.channels.keys() {
        let known: Vec<&str> = options.response.others().iter().map(|role| role.key()).collect();
        if !known.contains(&role.as_str()) {
            let used = match &known[..] {
                [] => "no further channel".into(),
                known => format!("one of {}", known.join(", ")),
            };
            let response = options.response.name();
            return Err(Error::UnusedRole { role: role.clone(), response, used });
        }
    }
    positive("steering full scale", options.steering_full_scale_rad)?;
    positive("sample time", options.sample_time_s)?;
    positive("row period", options.row_period_s)?;
    positive("max gap", Some(options.max_gap_s))?;
    let range = |option, range: &(f64, f64), expected: &str| match *range {
        (from, to) if from.is_finite() && to.is_finite() && from < to => Ok(()),
        (from, to) => {
            let value = format!("{from}..{to}");
            Err(Error::Option { option, value, expected: expected.into() })
        }
    };
    for window in &options.windows {
        range("window", window, "the start before the end")?;
    }
    match &options.speed_window {
        Some(window) => range("speed window", window, "the lower speed before the higher"),
        None => Ok(()),
    }
}

/// A drive that is named twice would be both estimation and validation data.
fn check_repeated(drives: &[Drive]) -> Result<(), Error> {
    for (i, drive) in drives.iter().enumerate() {
        let hashes = |d: &Drive| d.files.iter().map(|f| f.sha256.clone()).collect::<Vec<_>>();
        if let Some(first) = drives[..i].iter().find(|d| hashes(d) == hashes(drive)) {
            let (first, second) = (first.name.clone(), drive.name.clone());
            return Err(Error::RepeatedDrive { first, second });
        }
    }
    Ok(())
}

fn has_speed(
    drives: &[Drive],
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<bool, Error> {
    let without: Vec<&str> = drives
        .iter()
        .filter(|d| d.channel(Role::Speed).is_none())
        .map(|d| d.name.as_str())
        .collect();
    if !without.is_empty() && options.speed_window.is_some() {
        return Err(Error::NoSpeedForWindow { drive: without[0].into() });
    }
    if !without.is_empty() && without.len() < drives.len() {
        let names = without.join(", ");
        warnings.push(format!("no speed in {names}: the speed of the other drives is not used"));
    }
    Ok(without.is_empty())
}

/// The further channels that every drive has, without samples.
fn others(
    drives: &[Drive],
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> BTreeMap<Role, Vec<f64>> {
    let roles = options.further_roles().into_iter().filter(|role| !role.is_switch());
    let of_all = roles.filter(|role| {
        let without = drives.iter().filter(|d| d.channel(*role).is_none());
        let without: Vec<&str> = without.map(|d| d.name.as_str()).collect();
        if !without.is_empty() && without.len() < drives.len() {
            let (name, without) = (role.name(), without.join(", "));
            warnings.push(format!(
                "no {name} in {without}: the {name} of the other drives is not used"
            ));
        }
        without.is_empty()
    });
    let mut others: BTreeMap<Role, Vec<f64>> = of_all.map(|role| (role, Vec::new())).collect();
    if options.response == Response::Motion || others.contains_key(&Role::SteeringCommand) {
        others.insert(Role::Steering, Vec::new());
    }
    others
}

/// What was read from each column; of several drives, with the file.
fn channels(drives: &[Drive]) -> Vec<ChannelSummary> {
    let summary = |channel: &Series| {
        let summary = channel.summary();
        if drives.len() < 2 {
            return summary;
        }
        let column = format!("{}:{}", last_part(&channel.file), summary.column);
        ChannelSummary { column, ..summary }
    };
    drives.iter().flat_map(|d| d.channels.iter().map(summary)).collect()
}
