//! Which files are one drive, and the channels of it.
//!
//! Files that each bring both steering and yaw rate are drives of their own. Files of which none or one does
//! are channels of one drive on one clock. The rest is ambiguous, and rejected until the files of each drive
//! are stated.

use crate::Error;
use crate::channels::{self, Opened};
use crate::error::{Place, last_part, shortened};
use crate::expression::terms;
use crate::faults::{Freezes, Moving, Sampled};
use crate::mapping::{self, Source};
use crate::names::Wheel;
use crate::options::{LogOptions, Response};
use crate::recording::Group;
use crate::role::Role;
use crate::series::Series;
use crate::signal::resolution;
use crate::units::Quantity;
use steerwright_formats::SourceFile;

/// A road wheel turns no further, rad.
const LARGEST_ROAD_WHEEL_ANGLE: f64 = 0.8;

/// How far a normalised command may be beyond ±1, by rounding and calibration.
const FULL_SCALE_TOLERANCE: f64 = 1.02;

pub(crate) struct Drive {
    pub(crate) name: String,
    /// Input, output, and what else there is of the response.
    pub(crate) channels: Vec<Series>,
    pub(crate) places: Vec<Series>,
    pub(crate) files: Vec<SourceFile>,
    pub(crate) steering_ratio: f64,
    /// The instant on the log's clock from which time is counted, s: its first sample.
    pub(crate) start_s: f64,
}

/// Files whose drives are not stated, by drive.
pub(crate) fn grouped<'a>(
    files: Vec<Opened<'a>>,
    options: &LogOptions,
) -> Result<Vec<Vec<Opened<'a>>>, Error> {
    let brings = |file: &Opened<'_>, role| file.groups().any(|g| brings(g, role, options));
    let whole = |file: &Opened<'_>| options.response.roles().iter().all(|r| brings(file, *r));
    let complete: Vec<&str> = files.iter().filter(|f| whole(f)).map(name).collect();
    if files.len() > 1 && complete.len() == files.len() {
        return Ok(files.into_iter().map(|f| vec![f]).collect());
    }
    if complete.len() > 1 {
        let other = files.iter().find(|f| !whole(f)).map_or("", name);
        return Err(Error::AmbiguousDrives {
            complete: complete.join(", "),
            first: complete[0].into(),
            other: other.into(),
        });
    }
    Ok(if files.is_empty() { Vec::new() } else { vec![files] })
}

fn name<'f>(file: &'f Opened<'_>) -> &'f str {
    file.recording.groups().first().map_or("", |group| &group.file)
}

/// Whether the group has a channel for the role, whatever its unit.
pub(crate) fn brings(group: &Group, role: Role, options: &LogOptions) -> bool {
    let has = |name: &str| group.find(name).is_some();
    match options.stated_channel(role) {
        Some(name) => {
            has(name.strip_prefix('-').unwrap_or(name))
                || terms(name).is_some_and(|terms| terms.iter().all(|t| t.1.iter().all(|n| has(n))))
        }
        None => group.channels.iter().any(|channel| channel.may_be(role)),
    }
}

/// The sources of a drive's channels.
pub(crate) fn sources(
    groups: &[Group],
    roles: impl IntoIterator<Item = Role>,
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<Vec<(Role, Source)>, Error> {
    let mut sources = Vec::new();
    for role in roles {
        let found = mapping::find(groups, options, role, warnings)?;
        sources.extend(found.map(|source| (role, source)));
    }
    Ok(sources)
}

impl Drive {
    pub(crate) fn read(
        files: Vec<Opened<'_>>,
        options: &LogOptions,
        warnings: &mut Vec<String>,
    ) -> Result<Self, Error> {
        let names: Vec<&str> = files.iter().map(|file| last_part(name(file))).collect();
        let name = names.join(" + ");
        let groups: Vec<Group> = files.iter().flat_map(Opened::groups).cloned().collect();
        let response = options.response;
        let of_channels = response == Response::Channels;
        let is_speed = |role: &Role| !of_channels && !response.roles().contains(role);
        let speed = [Role::Speed].into_iter().filter(is_speed);
        let roles = response.roles().into_iter().chain(speed);
        let others = options.further_roles();
        let of_yaw = response.is_of_yaw_rate();
        let places = Role::PLACES.into_iter().filter(|_| of_yaw);
        let roles = roles.chain(others).chain(places);
        let sources = sources(&groups, roles, options, warnings)?;
        let read = channels::read(files, &sources, options, warnings)?;
        let (files, start_s) = (read.files, read.start_s);
        let (places, mut channels): (Vec<_>, Vec<_>) =
            read.series.into_iter().partition(|c| c.role.is_place());
        // Of the motion, and of a command beside the angle, further channels that are stated too.
        let stated =
            |c: &Series| response.others().contains(&c.role) && !options.is_optional(c.role);
        for (place, channel) in channels.iter().enumerate() {
            if let Some(value) = channel.constant_value()
                && (place < 2 || of_channels || of_yaw && stated(channel))
            {
                return Err(channel.constant(value));
            }
        }
        let mut ratio = 1.0;
        if of_yaw {
            ratio = steering_ratio(&channels[0], options, warnings)?;
            leave_out_frozen(&mut channels);
        }
        warnings.extend(channels.iter().filter_map(Series::frozen_in_words));
        Ok(Self { name, channels, places, files, steering_ratio: ratio, start_s })
    }

    pub(crate) fn channel(&self, role: Role) -> Option<&Series> {
        self.channels.iter().find(|c| c.role == role)
    }
}

/// Leaves out the samples of a gyro that is frozen while the vehicle moves and is steered.
fn leave_out_frozen(channels: &mut [Series]) {
    let [steering, yaw_rate, rest @ ..] = channels else { return };
    let mut freezes = Freezes::default();
    freezes.note(&yaw_rate.value, &steering.value);
    let rows = Moving {
        yaw_rate: Sampled::from_series(yaw_rate),
        steering: Sampled::from_series(steering),
        speed: rest.iter().find(|c| c.role == Role::Speed).map(Sampled::from_series),
        resolution: resolution(&yaw_rate.value),
    };
    (_, yaw_rate.frozen) = freezes.find(rows, None);
    let frozen = yaw_rate.frozen.clone();
    yaw_rate.leave_out(&frozen);
}

/// The ratio stated, or 1 where the column may be that of a road wheel.
pub(crate) fn steering_ratio(
    steering: &Series,
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<f64, Error> {
    normalised(steering, options, warnings)?;
    if let Some(ratio) = options.steering_ratio {
        return Ok(ratio);
    }
    let wheel = Role::wheel(&steering.column);
    if wheel == Some(Wheel::Steering) {
        return Err(Error::SteeringRatioUnknown {
            file: steering.file.clone(),
            column: steering.column.clone(),
        });
    }
    if steering.unit.quantity == Quantity::Angle {
        let angles = steering.value.iter().map(|x| x.abs()).zip(steering.line.iter());
        let (largest, line) = angles.fold((0.0, &0), |m, x| if x.0 > m.0 { x } else { m });
        if largest > LARGEST_ROAD_WHEEL_ANGLE {
            return Err(Error::NotARoadWheel {
                at: Place::new(&steering.file, *line, &steering.column),
                largest_deg: largest.to_degrees(),
            });
        }
    }
    if wheel.is_none() && steering.unit.quantity == Quantity::Angle {
        warnings.push(format!(
            "no steering ratio is stated: column `{}` is taken for the road-wheel angle (ratio 1)",
            shortened(&steering.column)
        ));
    }
    Ok(1.0)
}

/// A normalised steering command: within its full scale where that is stated.
fn normalised(
    steering: &Series,
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<(), Error> {
    let Some(angle) = options.steering_full_scale_rad else {
        if steering.unit.quantity == Quantity::Dimensionless {
            warnings.push(format!(
                "column `{}` has no angle's unit: 1 of it is taken for 1 rad, so angles of the model and of its controller are in that unit; the steering full scale states the angle at 1",
                shortened(&steering.column)
            ));
        }
        return Ok(());
    };
    let beyond = |x: &f64| x.abs() > FULL_SCALE_TOLERANCE * angle;
    if let Some(i) = steering.value.iter().position(beyond) {
        return Err(Error::BeyondFullScale {
            at: Place::new(&steering.file, steering.line[i], &steering.column),
            value: steering.value[i] / steering.unit.to_si,
        });
    }
    warnings.push(format!(
        "column `{}` is a normalised command: 1 is {:.2}°, as stated",
        shortened(&steering.column),
        angle.to_degrees()
    ));
    Ok(())
}
