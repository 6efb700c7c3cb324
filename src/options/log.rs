//! Options for reading a drive log and identifying a model, shared by `identify` and `build`.

use crate::documents::{files, ros_definitions};
use crate::failure::Failure;
use crate::options::quantity;
use crate::terminal::progress::Progress;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use steerwright_drivelog::{
    DecimalMark, DriveLog, LogFile, LogOptions, Mapping, Response, VehicleClass,
};
use steerwright_formats::UnknownWord;
use steerwright_sysid::{
    Detrend, IdentifyOptions, InputKind, Intersample, Method, ValidationData, ValidationPlace,
};

/// How the channels in a log file are found.
#[derive(clap::Args, Debug, Clone)]
#[command(next_help_heading = "Log")]
pub(crate) struct SourceArguments {
    /// Column of the time in every file; by default the first one with such a name
    #[arg(long, value_name = "CHANNEL")]
    pub(crate) time_channel: Option<String>,
    /// Unit of a channel whose name does not state it, such as steer=deg; may be repeated
    #[arg(long = "unit", value_name = "CHANNEL=UNIT", value_parser = channel_unit)]
    pub(crate) units: Vec<(String, String)>,
    /// Topic, message or channel group to use; may be repeated. By default all
    #[arg(long = "topic", value_name = "NAME")]
    pub(crate) topics: Vec<String>,
    /// CAN database that decodes a raw bus; may be repeated
    #[arg(long = "dbc", value_name = "FILE")]
    pub(crate) dbc: Vec<PathBuf>,
    /// Folder with definitions of ROS messages (PACKAGE/msg/NAME.msg), for bags that have none; may be repeated
    #[arg(long = "ros-definitions", value_name = "DIR")]
    pub(crate) ros_definitions: Vec<PathBuf>,
    /// Mapping file with the channels, units and databases of a team's vehicles. Options of the command line
    /// override it
    #[arg(long, value_name = "TOML")]
    pub(crate) mapping: Option<PathBuf>,
    /// Vehicle of the mapping file
    #[arg(long, value_name = "NAME", requires = "mapping")]
    pub(crate) mapping_vehicle: Option<String>,
    /// Line of the header of text files, from 1; by default the row of names above the first row of values
    #[arg(long, value_name = "N")]
    pub(crate) header_line: Option<u64>,
    /// Decimal mark of the numbers; by default the one that the first rows determine
    #[arg(long, value_name = DecimalMark::WORDS)]
    pub(crate) decimal: Option<DecimalMark>,
    /// Time between rows of files without a clock
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    pub(crate) row_period: Option<f64>,
}

/// How the log is read. Columns are named as in the header, as `file.csv:column` where several
/// files have one of that name, and with a leading `-` where the sign is opposite.
#[derive(clap::Args, Debug, Clone)]
#[command(next_help_heading = "Log")]
pub(crate) struct LogArguments {
    #[command(flatten)]
    pub(crate) source: SourceArguments,
    /// Channel of the steering angle or, for the structure torque, of the torque, for longitudinal of the accelerator
    /// or of the acceleration command; recognised by its name by default. For
    /// all channels: -CHANNEL reverses the sign, FILE:CHANNEL selects one of several files, GROUP.CHANNEL one of
    /// several topics or messages, "A + 0.1 * B" combines channels of one of these. May be repeated: with several inputs
    /// or outputs, or with one of each that is no steering angle and no yaw rate, a plant of any system is identified,
    /// whose channels keep their units
    #[arg(long = "input-channel", value_name = "CHANNEL", allow_hyphen_values = true)]
    pub(crate) input_channels: Vec<String>,
    /// Channel of the yaw rate, or of the yaw, which is then differenced, or, for the structure torque, of the lateral
    /// acceleration, for longitudinal of the speed; recognised by its name by default. May be repeated, as inputs
    #[arg(long = "output-channel", value_name = "CHANNEL", allow_hyphen_values = true)]
    pub(crate) output_channels: Vec<String>,
    /// Channel of the speed; recognised by its name by default, and optional
    #[arg(long, value_name = "CHANNEL", allow_hyphen_values = true)]
    pub(crate) speed_channel: Option<String>,
    /// Further channel: steering_command beside a measured steering angle, from which the actuator between both is
    /// identified; for the structure torque steering (its angle), roll, engaged or override; for single-track
    /// and auto lateral_acceleration, longitudinal_acceleration, lateral_velocity or sideslip; for longitudinal brake,
    /// grade, pitch (positive with the nose down), altitude or gear; may be repeated.
    /// All but steering_command are recognised by their names by default
    #[arg(long = "channel", value_name = "ROLE=CHANNEL", value_parser = channel)]
    pub(crate) channels: Vec<(String, String)>,
    /// Steering angle at 1 of a normalised steering command, of unit 1 or %; by default the command is
    /// taken as it is
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, value_parser = quantity::angle)]
    pub(crate) steering_full_scale: Option<f64>,
    /// Steering angle over road-wheel angle; needed where the log has the steering wheel
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub(crate) steering_ratio: Option<f64>,
    /// Class of the vehicle: a model whose wheelbase or mean speed is not of this class fails. By default they must
    /// be those of one of the classes
    #[arg(long, value_name = VehicleClass::WORDS)]
    pub(crate) vehicle_class: Option<VehicleClass>,
    /// Files that form one drive; may be repeated. By default each file with steering and yaw rate is a
    /// drive, and all other files are channels of one drive
    #[arg(long = "drive", value_name = "FILE,FILE…", value_parser = drive)]
    pub(crate) drives: Vec<Files>,
    /// Part of each drive to use, counted from its first sample, such as 10s..60s; may be repeated
    #[arg(long = "window", value_name = "FROM..TO", allow_hyphen_values = true, value_parser = window)]
    pub(crate) windows: Vec<(f64, f64)>,
    /// Use the segments in which the speed, averaged over a second, stays within a range, such as 14..16
    /// (m/s) or 50km/h..60km/h
    #[arg(long, value_name = "FROM..TO", allow_hyphen_values = true, value_parser = speed_window)]
    pub(crate) speed_window: Option<(f64, f64)>,
    /// Sample time of the merged log; by default chosen from the log's rate
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    pub(crate) sample_time: Option<f64>,
    /// Behaviour of the steering between its samples: held (zoh, a command), band-limited (bl, a measured
    /// angle) or along straight lines (foh); auto decides by name, unit and values
    #[arg(long, value_name = or_auto(Intersample::WORDS), default_value = "auto")]
    pub(crate) intersample: Auto<Intersample>,
    /// Longest gap in a channel that is bridged; a longer one splits the drive
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time, default_value = "0.5s")]
    pub(crate) max_gap: f64,
    /// Age of a GNSS fix at the time the log states for it. From a log with fixes (x_m and y_m, or latitude and
    /// longitude) course and gyro determine the sideslip in plant.json, and an error of the age is an error of
    /// the sideslip. By default the age is estimated from speed changes on straights; without them no sideslip
    /// is stated
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    pub(crate) gnss_latency: Option<f64>,
    /// Position of the antenna ahead of the centre of gravity; negative behind it
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = quantity::length, default_value = "0m")]
    pub(crate) antenna_x: f64,
}

/// How the model is identified.
#[derive(clap::Args, Debug, Clone)]
#[command(next_help_heading = "Identification")]
pub(crate) struct IdentifyArguments {
    /// Subspace method: n4sid, moesp and cva for open-loop data, ssarx and pbsid for closed-loop data; auto
    /// decides by a test for feedback
    #[arg(long, value_name = or_auto(Method::WORDS), default_value = "auto")]
    pub(crate) method: Auto<Method>,
    /// Order of the model
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = number)]
    pub(crate) order: Auto<usize>,
    /// Highest order among which `--order auto` chooses
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = IdentifyOptions::default().max_order)]
    pub(crate) max_order: usize,
    /// Block rows of the Hankel matrices
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = number)]
    pub(crate) horizon: Auto<usize>,
    /// Input of the model: the steering angle, or its product with the speed
    #[arg(long, value_name = InputKind::WORDS, default_value = "steering")]
    pub(crate) model_input: InputKind,
    /// Pure delay of the steering; auto estimates it, and uses none if the data do not support one
    #[arg(long, value_name = "TIME|auto", allow_hyphen_values = true, default_value = "auto", value_parser = delay)]
    pub(crate) delay: Auto<f64>,
    /// Offsets and trends to remove: the means of the estimation data, a straight line over time for each
    /// drive, or none
    #[arg(long, value_name = Detrend::WORDS, default_value = "mean")]
    pub(crate) detrend: Detrend,
    /// Feedthrough: the yaw rate depends on the steering of the same sample
    #[arg(long, value_name = or_auto(Switch::WORDS), default_value = "auto", default_missing_value = "on", num_args = 0..=1, require_equals = true)]
    pub(crate) feedthrough: Auto<Switch>,
    /// Largest number of estimation samples, in blocks spread over a long log
    #[arg(long, value_name = "N|all", default_value = "60000", value_parser = samples)]
    pub(crate) max_samples: Auto<usize>,
    /// Share of the log that is validation data
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent, default_value = "50%")]
    pub(crate) validation_fraction: f64,
    /// Where the validation data are: at the end of the log, or, with auto, in blocks over the whole log where a part is
    /// hardly steered or the parts differ in speed or lateral acceleration
    #[arg(long, value_name = ValidationPlace::WORDS, default_value = "auto")]
    pub(crate) validation_place: ValidationPlace,
}

/// A value or `auto`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Auto<T>(pub(crate) Option<T>);

impl<T: FromStr<Err = UnknownWord>> FromStr for Auto<T> {
    type Err = UnknownWord;

    fn from_str(text: &str) -> Result<Self, UnknownWord> {
        match text {
            "auto" => Ok(Self(None)),
            _ => text.parse().map(|value| Self(Some(value))).map_err(|e: UnknownWord| e.or("auto")),
        }
    }
}

/// The words of an option that may also be `auto`.
pub(crate) fn or_auto(words: &str) -> String {
    format!("auto|{words}")
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Switch {
    On,
    Off,
}

steerwright_formats::words!(Switch { On = "on", Off = "off" });

/// Files that belong together.
#[derive(Debug, Clone)]
pub(crate) struct Files(Vec<PathBuf>);

impl SourceArguments {
    /// The options with the channels, units and databases that are stated here and in the mapping file.
    pub(crate) fn complete(&self, options: LogOptions) -> Result<LogOptions, Failure> {
        let mut options = LogOptions {
            time: self.time_channel.clone(),
            units: self.units.iter().cloned().collect(),
            topics: self.topics.clone(),
            header_line: self.header_line,
            decimal: self.decimal,
            row_period_s: self.row_period,
            ..options
        };
        for folder in &self.ros_definitions {
            options.ros_definitions.extend(ros_definitions::read(folder)?);
        }
        let mut databases = self.dbc.clone();
        if let Some(path) = &self.mapping {
            let (text, name) = (files::read_text(path)?, path.display().to_string());
            let mapping = Mapping::of_toml(&text, &name, self.mapping_vehicle.as_deref())?;
            if databases.is_empty() {
                let folder = path.parent().unwrap_or(Path::new(""));
                databases = mapping.dbc.iter().map(|name| folder.join(name)).collect();
            }
            mapping.apply(&mut options)?;
        }
        for path in databases {
            options.dbc.push((path.display().to_string(), files::read(&path)?));
        }
        Ok(options)
    }
}

impl LogArguments {
    /// The files of `--drive`.
    pub(crate) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.drives.iter().flat_map(|drive| &drive.0)
    }

    pub(crate) fn options(&self, response: Response) -> Result<LogOptions, Failure> {
        let (inputs, outputs) = (&self.input_channels, &self.output_channels);
        let of_motion =
            matches!(response, Response::YawRate | Response::Motion | Response::Channels);
        if !of_motion && inputs.len().max(outputs.len()) > 1 {
            return Err(Failure::new(
                format!(
                    "the response of the {response} has one --input-channel and one --output-channel"
                ),
                "name one of each, or omit --structure for a plant of several inputs and outputs",
            ));
        }
        let named = |names: &[String]| if of_motion { names.to_vec() } else { Vec::new() };
        self.source.complete(LogOptions {
            response,
            input: inputs.first().cloned(),
            output: outputs.first().cloned(),
            inputs: named(inputs),
            outputs: named(outputs),
            speed: self.speed_channel.clone(),
            channels: self.channels.iter().cloned().collect(),
            steering_full_scale_rad: self.steering_full_scale,
            steering_ratio: self.steering_ratio,
            vehicle_class: self.vehicle_class,
            windows: self.windows.clone(),
            speed_window: self.speed_window,
            sample_time_s: self.sample_time,
            intersample: self.intersample.0,
            max_gap_s: self.max_gap,
            gnss_latency_s: self.gnss_latency,
            antenna_x_m: self.antenna_x,
            ..LogOptions::default()
        })
    }

    /// Reads the files of the log: the positional ones and those of `--drive`.
    pub(crate) fn read(&self, paths: &[PathBuf], response: Response) -> Result<DriveLog, Failure> {
        let is_stdin = |path: &&PathBuf| path.as_path() == Path::new("-");
        if paths.iter().chain(self.files()).filter(is_stdin).count() > 1 {
            return Err(Failure::new("standard input is named twice", "name - once"));
        }
        let options = self.options(response)?;
        let progress = Progress::start("reading the log");
        let open = |paths: &[PathBuf]| {
            let paths = paths.iter().map(|path| files::of_log(path));
            let paths = paths.collect::<Result<Vec<_>, Failure>>()?.concat();
            paths.iter().map(|path| log_file(path, &progress)).collect::<Result<Vec<_>, Failure>>()
        };
        let drives =
            self.drives.iter().map(|files| open(&files.0)).collect::<Result<Vec<_>, Failure>>()?;
        Ok(steerwright_drivelog::read_drives(open(paths)?, drives, &options)?)
    }
}

impl IdentifyArguments {
    pub(crate) fn options(&self) -> IdentifyOptions {
        IdentifyOptions {
            method: self.method.0,
            order: self.order.0,
            max_order: self.max_order,
            horizon: self.horizon.0,
            delay_s: self.delay.0,
            detrend: self.detrend,
            feedthrough: self.feedthrough.0.map(|switch| switch == Switch::On),
            input_kind: self.model_input,
            max_samples: self.max_samples.0,
            validation: ValidationData {
                fraction: self.validation_fraction / 100.0,
                place: self.validation_place,
            },
            ..IdentifyOptions::default()
        }
    }
}

/// A log to be read from its start to its end; `-` is standard input.
pub(crate) fn log_file(path: &Path, progress: &Progress) -> Result<LogFile<'static>, Failure> {
    if path == Path::new("-") {
        return Ok(LogFile::of_stream("standard input", std::io::stdin().lock()));
    }
    let file = files::open(path)?;
    let metadata = file.metadata().map_err(|e| Failure::file(path, &e))?;
    let reader = progress.reading(file, metadata.len());
    let name = path.display().to_string();
    // A pipe cannot be read at any place.
    Ok(if metadata.is_file() {
        LogFile::of_file(&name, reader)
    } else {
        LogFile::of_stream(&name, reader)
    })
}

fn samples(text: &str) -> Result<Auto<usize>, String> {
    match text {
        "all" => Ok(Auto(None)),
        _ => number(text).map_err(|_| "expected a whole number or all".into()),
    }
}

fn channel_unit(text: &str) -> Result<(String, String), String> {
    text.rsplit_once('=')
        .filter(|(column, unit)| !column.is_empty() && !unit.is_empty())
        .map(|(column, unit)| (column.to_owned(), unit.to_owned()))
        .ok_or_else(|| "expected CHANNEL=UNIT, such as steer=deg".into())
}

fn channel(text: &str) -> Result<(String, String), String> {
    text.split_once('=')
        .filter(|(role, channel)| !role.is_empty() && !channel.is_empty())
        .map(|(role, channel)| (role.to_owned(), channel.to_owned()))
        .ok_or_else(|| "expected ROLE=CHANNEL, such as roll=roll_deg".into())
}

fn window(text: &str) -> Result<(f64, f64), String> {
    let (from, to) = text.split_once("..").ok_or("expected FROM..TO, such as 10s..60s")?;
    let (from, to) = (quantity::time(from)?, quantity::time(to)?);
    if from < to {
        Ok((from, to))
    } else {
        Err(format!("{from} s is not before {to} s: expected FROM..TO, such as 10s..60s"))
    }
}

/// Speeds in m/s; a number without a unit has that of the other, or m/s.
fn speed_window(text: &str) -> Result<(f64, f64), String> {
    let (from, to) = text.split_once("..").ok_or("expected FROM..TO, such as 14..16")?;
    let (from, to) = (from.trim(), to.trim());
    let unit = |text: &str| {
        let number = text.trim_end_matches(|c: char| c.is_alphabetic() || c == '/');
        text[number.len()..].to_owned()
    };
    let own = |text: &str, other: &str| match (unit(text).is_empty(), unit(other).is_empty()) {
        (false, _) => quantity::speed(text),
        (true, false) => quantity::speed(&format!("{text}{}", unit(other))),
        (true, true) => quantity::speed(&format!("{text}m/s")),
    };
    let (low, high) = (own(from, to)?, own(to, from)?);
    if low < high { Ok((low, high)) } else { Err(format!("{from} is not below {to}")) }
}

fn drive(text: &str) -> Result<Files, String> {
    let files: Vec<PathBuf> = text.split(',').map(PathBuf::from).collect();
    if files.iter().any(|f| f.as_os_str().is_empty()) {
        return Err("expected file names with commas between them, such as a.csv,b.csv".into());
    }
    Ok(Files(files))
}

fn delay(text: &str) -> Result<Auto<f64>, String> {
    if text == "auto" { Ok(Auto(None)) } else { Ok(Auto(Some(quantity::time(text)?))) }
}

fn number(text: &str) -> Result<Auto<usize>, String> {
    match (text, text.parse()) {
        ("auto", _) => Ok(Auto(None)),
        (_, Ok(number)) => Ok(Auto(Some(number))),
        _ => Err("expected a number or auto".into()),
    }
}
