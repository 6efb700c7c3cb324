//! From CSV files to one uniform recording of steering angle and yaw rate.

mod mapping;
mod options;
mod resample;
mod role;
mod series;
mod table;
mod units;

use crate::signal::mean;
use crate::{Error, Place};
use formats::{ChannelSummary, SourceFile};
use resample::{Grid, Hold, resample};
use role::Role;
use series::Series;
use std::collections::BTreeMap;
use std::ops::Range;
use table::Table;
use units::Quantity;

pub use options::LogOptions;
pub(crate) use role::unit_in_place_of;
pub(crate) use units::known_units;

/// Fewest samples of the merged recording.
pub(crate) const LEAST_SAMPLES: usize = 100;
/// Most samples of the merged recording, and of the fine grid it is filtered on.
const MOST_SAMPLES: usize = 20_000_000;
/// Sample time that is aimed at: a Nyquist frequency of 12.5 Hz, two and a half times the about
/// 5 Hz up to which lateral dynamics respond, and ten samples or more in a rise time.
const AIMED_SAMPLE_TIME: f64 = 0.04;
/// Slower on average, a vehicle stands, m/s: yaw dynamics of it are none, and a column that says so
/// while the vehicle turns is dead, in another unit or another signal.
const LEAST_MEAN_SPEED: f64 = 0.5;
/// A road wheel turns no further, rad.
const LARGEST_ROAD_WHEEL_ANGLE: f64 = 0.8;

/// A drive on one uniform grid, SI and radians, ISO 8855 signs.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveLog {
    /// Name for people: the first file's, without its ending.
    pub name: String,
    /// Sample time T, s.
    pub sample_time_s: f64,
    /// The stretches without a gap, in order; together they are all samples.
    pub segments: Vec<Stretch>,
    /// Steering angle, rad, in the log's coordinates, held over each sample.
    pub input: Vec<f64>,
    /// Yaw rate, rad/s.
    pub output: Vec<f64>,
    /// Speed, m/s.
    pub speed: Option<Vec<f64>>,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// What was read from each column.
    pub channels: Vec<ChannelSummary>,
    /// What the reader had to do or doubts.
    pub warnings: Vec<String>,
    /// The files, by name and hash.
    pub sources: Vec<SourceFile>,
    /// The options in force, by name.
    pub options: BTreeMap<String, String>,
}

/// Samples of a log that follow each other without a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// The log's time at the first sample, s.
    pub time0_s: f64,
    /// Which of the log's samples they are.
    pub range: Range<usize>,
}

impl DriveLog {
    /// The log's time at each sample, s.
    #[must_use]
    pub fn time_s(&self) -> Vec<f64> {
        let times = |s: &Stretch| {
            let (from, step) = (s.time0_s, self.sample_time_s);
            (0..s.range.len()).map(move |k| from + k as f64 * step)
        };
        self.segments.iter().flat_map(times).collect()
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.input.len()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.input.is_empty()
    }
}

/// Reads CSV files, each with a header and a clock of its own, and merges the mapped columns onto
/// one uniform grid over the time that all of them cover.
///
/// The sample time is the one asked for, else the multiple of the log's own period that comes
/// nearest to 0.04 s from below (0.04 s where the clocks differ or are irregular). Anti-alias
/// filtering and its effect on the held input are described in the module `resample`.
///
/// # Errors
/// [`Error`] with file, line and column.
pub fn read_log(files: &[(String, Vec<u8>)], options: &LogOptions) -> Result<DriveLog, Error> {
    check_options(options)?;
    if files.is_empty() {
        return Err(Error::NoFiles);
    }
    let tables = files.iter().map(|(n, b)| Table::open(n, b)).collect::<Result<Vec<_>, _>>()?;
    mapping::check_units_are_used(&tables, options)?;
    let mut warnings = Vec::new();
    let mut channels = Vec::new();
    for role in [Role::Steering, Role::YawRate, Role::Speed] {
        if let Some(source) = mapping::find(&tables, options, role, &mut warnings)? {
            channels.push(series::read(&tables, source, role, options, &mut warnings)?);
        }
    }
    for channel in channels.iter().take(2) {
        check_constant(channel)?;
    }
    let steering_ratio = steering_ratio(&channels[0], options, &mut warnings)?;
    let grid = common_grid(&channels, options)?;
    let margin = if grid.per_step > 1 { 9.0 * grid.step } else { 0.0 };
    let (from, to) =
        (grid.start - margin, grid.start + (grid.count as f64 - 1.0) * grid.step + margin);
    for channel in &channels {
        channel.check_gaps(from, to, options.max_gap_s, &mut warnings)?;
    }
    let on_grid = |role: Role| {
        let channel = channels.iter().find(|c| c.role == role)?;
        let hold = match role {
            Role::Steering => Hold::Held(channel.period),
            _ => Hold::Sampled,
        };
        Some(resample(&channel.time, &channel.value, &grid, hold))
    };
    let speed: Option<Vec<f64>> =
        on_grid(Role::Speed).map(|v| v.into_iter().map(|x| x.max(0.0)).collect());
    if let (Some(speed), Some(channel)) = (&speed, channels.iter().find(|c| c.role == Role::Speed))
    {
        check_moves(speed, channel)?;
    }
    let mut used = options.to_map();
    used.insert("sample_time_used_s".into(), grid.step.to_string());
    Ok(DriveLog {
        name: stem(&files[0].0),
        sample_time_s: grid.step,
        segments: vec![Stretch { time0_s: grid.start, range: 0..grid.count }],
        input: on_grid(Role::Steering).unwrap_or_default(),
        output: on_grid(Role::YawRate).unwrap_or_default(),
        speed,
        steering_ratio,
        channels: channels.iter().map(Series::summary).collect(),
        warnings,
        sources: files
            .iter()
            .map(|(name, bytes)| SourceFile::of(std::path::Path::new(name), bytes))
            .collect(),
        options: used,
    })
}

fn check_options(options: &LogOptions) -> Result<(), Error> {
    let positive = |option, value: Option<f64>| match value {
        Some(x) if !(x.is_finite() && x > 0.0) => {
            Err(Error::Option { option, value: x.to_string(), expected: "a number above 0".into() })
        }
        _ => Ok(()),
    };
    if let Some(ratio) = options.steering_ratio.filter(|r| !(0.01..=1000.0).contains(r)) {
        let (option, value) = ("--steering-ratio", format!("{ratio:?}"));
        return Err(Error::Option { option, value, expected: "0.01 to 1000".into() });
    }
    positive("--sample-time", options.sample_time_s)?;
    positive("--row-period", options.row_period_s)?;
    positive("--max-gap", Some(options.max_gap_s))?;
    match options.window {
        Some((from, to)) if from.is_nan() || to.is_nan() || from >= to => Err(Error::Option {
            option: "--window",
            value: format!("{from},{to}"),
            expected: "the start before the end".into(),
        }),
        _ => Ok(()),
    }
}

fn check_constant(channel: &Series) -> Result<(), Error> {
    let first = channel.value[0];
    if channel.value.iter().any(|x| (x - first).abs() > 1e-12 * (1.0 + first.abs())) {
        return Ok(());
    }
    Err(Error::Constant {
        file: channel.file.clone(),
        column: channel.column.clone(),
        role: channel.role.name(),
        value: first / channel.unit.to_si,
        unit: channel.unit.name,
    })
}

/// The speed of the part that is used is no standstill's.
fn check_moves(speed: &[f64], channel: &Series) -> Result<(), Error> {
    let mean_mps = mean(speed);
    if mean_mps >= LEAST_MEAN_SPEED {
        return Ok(());
    }
    Err(Error::Standstill { file: channel.file.clone(), column: channel.column.clone(), mean_mps })
}

/// The ratio stated, or 1 where the column may be a road wheel's.
fn steering_ratio(
    steering: &Series,
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<f64, Error> {
    if let Some(ratio) = options.steering_ratio {
        return Ok(ratio);
    }
    let name = steering.column.to_lowercase();
    if name.contains("wheel") && !name.contains("road") {
        return Err(Error::SteeringRatioUnknown {
            file: steering.file.clone(),
            column: steering.column.clone(),
        });
    }
    if steering.unit.quantity == Quantity::Angle {
        let angles = steering.value.iter().map(|x| x.abs()).zip(&steering.line);
        let (largest, line) = angles.fold((0.0, &0), |m, x| if x.0 > m.0 { x } else { m });
        if largest > LARGEST_ROAD_WHEEL_ANGLE {
            return Err(Error::NotARoadWheel {
                at: Place::new(&steering.file, *line, &steering.column),
                largest_deg: largest.to_degrees(),
            });
        }
    }
    if !name.contains("road") {
        warnings.push(format!(
            "no steering ratio is given: column `{}` is taken for the road-wheel angle (ratio 1)",
            steering.column
        ));
    }
    Ok(1.0)
}

/// The grid over the time all channels cover, within the window.
fn common_grid(channels: &[Series], options: &LogOptions) -> Result<Grid, Error> {
    let latest = |a: usize, b: usize| if channels[b].start() > channels[a].start() { b } else { a };
    let earliest = |a: usize, b: usize| if channels[b].end() < channels[a].end() { b } else { a };
    let first = (1..channels.len()).fold(0, latest);
    let last = (1..channels.len()).fold(0, earliest);
    let (mut from, mut to) = (channels[first].start(), channels[last].end());
    if from >= to {
        let (a, b) = (&channels[last], &channels[first]);
        return Err(Error::NoOverlap {
            first: format!("{} ({})", a.column, a.file),
            first_from: a.start(),
            first_to: a.end(),
            second: format!("{} ({})", b.column, b.file),
            second_from: b.start(),
            second_to: b.end(),
        });
    }
    if let Some((start, end)) = options.window {
        if start >= to || end <= from {
            return Err(Error::NoOverlap {
                first: "the window".into(),
                first_from: start,
                first_to: end,
                second: "the log".into(),
                second_from: from,
                second_to: to,
            });
        }
        from = from.max(start);
        to = to.min(end);
    }
    // Steering and yaw rate set the rate; a slower speed follows.
    let periods = [channels[0].period, channels[1].period];
    let (fast, slow) = (periods[0].min(periods[1]), periods[0].max(periods[1]));
    let shared = is_uniform(&channels[0]) && same_clock(&channels[0], &channels[1]);
    let step = match options.sample_time_s {
        Some(asked) if asked < fast * (1.0 - 1e-3) => {
            return Err(Error::SampleTimeTooShort { asked, least: fast });
        }
        Some(asked) => asked,
        None if shared => fast * (AIMED_SAMPLE_TIME / fast + 1e-6).floor().max(1.0),
        None => AIMED_SAMPLE_TIME.max(slow),
    };
    // Decimal clocks leave digits like 0.03999999999999915.
    let step = (step * 1e9).round() / 1e9;
    let per_step = (step / fast - 1e-3).ceil().max(1.0);
    if per_step * ((to - from) / step + 20.0) > MOST_SAMPLES as f64 {
        // One wild instant makes a gap, which says where.
        for channel in channels {
            channel.check_gaps(from, to, options.max_gap_s, &mut Vec::new())?;
        }
        let (duration_s, sample_time_s) = (to - from, step / per_step);
        return Err(Error::TooManySamples { duration_s, sample_time_s, limit: MOST_SAMPLES });
    }
    let per_step = per_step as usize;
    // Start on a sample of a shared clock, so that interpolation changes nothing.
    if shared {
        let i = channels[0].time.partition_point(|t| *t < from - 1e-9);
        from = channels[0].time.get(i).copied().unwrap_or(from);
    }
    let grid = Grid::within(from, to, step, per_step);
    if grid.count < LEAST_SAMPLES {
        return Err(Error::TooFewSamples {
            got: grid.count,
            need: LEAST_SAMPLES,
            sample_time_s: step,
        });
    }
    Ok(grid)
}

fn is_uniform(series: &Series) -> bool {
    series.time.windows(2).all(|w| ((w[1] - w[0]) / series.period - 1.0).abs() < 0.05)
}

fn same_clock(a: &Series, b: &Series) -> bool {
    let apart = (a.start() - b.start()) / a.period;
    (a.period / b.period - 1.0).abs() < 1e-3 && (apart - apart.round()).abs() < 1e-3
}

/// `1 gap`, `2 gaps`.
fn signal_words(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

fn stem(path: &str) -> String {
    let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}
