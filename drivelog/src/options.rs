//! How a log is read.

use crate::role::Role;
use std::collections::BTreeMap;
use steerwright_formats::Intersample;

/// The decimal separator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DecimalMark {
    /// `0.5`
    Point,
    /// `0,5`
    Comma,
}

steerwright_formats::words!(DecimalMark { Point = "point", Comma = "comma" });

/// What responds to what in a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Response {
    /// The yaw rate, to the steering angle.
    #[default]
    YawRate,
    /// The lateral acceleration, to a steering torque or its normalised command.
    LateralAcceleration,
    /// The speed, to an accelerator and a brake, or to an acceleration command.
    Speed,
    /// The yaw rate and, where they are logged, accelerations and lateral velocity or sideslip, to the steering angle.
    Motion,
    /// The named outputs to the named inputs, of any system and in the units of the log.
    Channels,
}

steerwright_formats::words!(Response {
    YawRate = "yaw-rate",
    LateralAcceleration = "lateral-acceleration",
    Speed = "speed",
    Motion = "motion",
    Channels = "channels",
});

impl Response {
    /// The roles of input and output.
    #[must_use]
    pub fn roles(self) -> [Role; 2] {
        match self {
            Self::YawRate | Self::Motion => [Role::Steering, Role::YawRate],
            Self::LateralAcceleration => [Role::SteeringTorque, Role::LateralAcceleration],
            Self::Speed => [Role::LongitudinalCommand, Role::Speed],
            Self::Channels => [Role::Input(0), Role::Output(0)],
        }
    }

    /// Whether the output is the yaw rate.
    #[must_use]
    pub fn is_of_yaw_rate(self) -> bool {
        self.roles()[1] == Role::YawRate
    }

    /// The roles of further channels, which are optional.
    pub(crate) fn others(self) -> &'static [Role] {
        match self {
            Self::YawRate => &[Role::SteeringCommand],
            Self::LateralAcceleration => {
                &[Role::Steering, Role::Roll, Role::Engaged, Role::Override]
            }
            Self::Speed => &[Role::Brake, Role::Grade, Role::Pitch, Role::Altitude, Role::Gear],
            Self::Channels => &[],
            Self::Motion => &[
                Role::LateralAcceleration,
                Role::LongitudinalAcceleration,
                Role::LateralVelocity,
                Role::Sideslip,
                Role::SteeringCommand,
            ],
        }
    }
}

/// Which column is what, and how the channels are brought onto one grid.
///
/// A column is named as in the header (with or without its bracketed unit), as `file.csv:column`
/// where several files have it, and with a leading `-` where its sign is opposite.
#[derive(Debug, Clone, PartialEq)]
pub struct LogOptions {
    /// What responds to what.
    pub response: Response,
    /// Steering angle or torque, or accelerator or acceleration command. `None`: the one column with such a name.
    pub input: Option<String>,
    /// Yaw rate, or yaw, which is then differenced; or lateral acceleration, or speed. `None`: the one column with such a
    /// name.
    pub output: Option<String>,
    /// Inputs of any system, by name: see [`LogOptions::outputs`].
    pub inputs: Vec<String>,
    /// Outputs of any system, by name. The log is read for [`Response::Channels`] where several inputs or outputs are
    /// named, or where the one of each could not be a steering angle and a yaw rate by unit and name.
    pub outputs: Vec<String>,
    /// Further channels of the response by role: `steering_command` beside the measured angle of yaw rate and motion, which
    /// is taken only where it is named; `steering`, `roll`, `engaged`, `override` of the lateral
    /// acceleration; `lateral_acceleration`, `longitudinal_acceleration`, `lateral_velocity`, `sideslip` of the
    /// motion; `brake`, `grade`, `pitch`, `altitude`, `gear` of the speed. A role that is not there: the one column
    /// with such a name, if there is one; of the motion, and of the speed but for the brake, only where it has values
    /// throughout the drive.
    pub channels: BTreeMap<String, String>,
    /// Speed. `None`: the one column with such a name, if there is one.
    pub speed: Option<String>,
    /// Time, in every file. `None`: the first column that is named and measured like one.
    pub time: Option<String>,
    /// Units by column name, where the header does not state them or states them wrongly.
    pub units: BTreeMap<String, String>,
    /// Topics, messages or channel groups to use, by name. Empty: all.
    pub topics: Vec<String>,
    /// CAN databases (DBC) for raw buses, as name and text.
    pub dbc: Vec<(String, Vec<u8>)>,
    /// Definitions of messages of ROS whose log has none, by package and name of the type.
    pub ros_definitions: BTreeMap<String, String>,
    /// Line of the header of text files, from 1. `None`: the row of names above the first row of values.
    pub header_line: Option<u64>,
    /// The decimal mark of the files. `None`: the one that the first rows of each file determine.
    pub decimal: Option<DecimalMark>,
    /// Steering angle at 1 of a normalised steering command (unit `1` or `%`), rad. `None`: such a
    /// command is taken as it is.
    pub steering_full_scale_rad: Option<f64>,
    /// Steering angle over road-wheel angle. `None`: 1, which is refused for a steering wheel.
    pub steering_ratio: Option<f64>,
    /// Class of the vehicle, whose dimensions a model must have. `None`: those of any.
    pub vehicle_class: Option<VehicleClass>,
    /// Parts of each drive to use, from and to, s from its first sample; none for all of it.
    pub windows: Vec<(f64, f64)>,
    /// Speeds to use, from and to, m/s: the segments where the speed, averaged over a second, stays within.
    pub speed_window: Option<(f64, f64)>,
    /// Sample time of the merged recording, s. `None`: about 0.04 s (see
    /// [`read_drives`](crate::read_drives)).
    pub sample_time_s: Option<f64>,
    /// Period of the rows, s, for files without a clock.
    pub row_period_s: Option<f64>,
    /// What the steering does between its samples. `None`: a command is held (zoh), a measured angle
    /// moves on (bl); its name, its unit and its values decide which it is.
    pub intersample: Option<Intersample>,
    /// Longest gap that is bridged by a straight line, s; a longer one splits the drive.
    pub max_gap_s: f64,
    /// Age of a fix at the instant that the log states for it, s. `None`: as far as speed changes on
    /// straights determine it.
    pub gnss_latency_s: Option<f64>,
    /// The antenna ahead of the centre of gravity, m.
    pub antenna_x_m: f64,
}

/// A class of road vehicles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VehicleClass {
    /// From a kart to a limousine; also race cars.
    Car,
    /// A truck without a trailer.
    Truck,
    /// A bus.
    Bus,
    /// A scale car, such as 1:10.
    Scale,
}

steerwright_formats::words!(VehicleClass {
    Car = "car",
    Truck = "truck",
    Bus = "bus",
    Scale = "scale",
});

impl Default for LogOptions {
    fn default() -> Self {
        Self {
            response: Response::default(),
            input: None,
            output: None,
            inputs: Vec::new(),
            outputs: Vec::new(),
            channels: BTreeMap::new(),
            speed: None,
            time: None,
            units: BTreeMap::new(),
            topics: Vec::new(),
            dbc: Vec::new(),
            ros_definitions: BTreeMap::new(),
            header_line: None,
            decimal: None,
            steering_full_scale_rad: None,
            steering_ratio: None,
            vehicle_class: None,
            windows: Vec::new(),
            speed_window: None,
            sample_time_s: None,
            row_period_s: None,
            intersample: None,
            max_gap_s: 0.5,
            gnss_latency_s: None,
            antenna_x_m: 0.0,
        }
    }
}

impl LogOptions {
    /// The channel that is stated for a role.
    pub(crate) fn stated_channel(&self, role: Role) -> Option<&str> {
        let [input, output] = self.response.roles();
        match role {
            Role::Input(place) => self.inputs.get(usize::from(place)).map(String::as_str),
            Role::Output(place) => self.outputs.get(usize::from(place)).map(String::as_str),
            // The output of one response.
            Role::Speed => {
                let stated = if output == Role::Speed { self.output.as_deref() } else { None };
                stated.or(self.speed.as_deref())
            }
            role if role == input => self.input.as_deref(),
            role if role == output => self.output.as_deref(),
            Role::Time => self.time.as_deref(),
            other => self.channels.get(other.key()).map(String::as_str),
        }
    }

    /// The roles of further channels, which are optional but for those of named inputs and outputs.
    pub(crate) fn further_roles(&self) -> Vec<Role> {
        if self.response != Response::Channels {
            return self.response.others().to_vec();
        }
        let places = |names: &[String]| 1..u8::try_from(names.len()).unwrap_or(u8::MAX);
        let inputs = places(&self.inputs).map(Role::Input);
        inputs.chain(places(&self.outputs).map(Role::Output)).collect()
    }

    /// Whether a channel of that role is used only where nothing is lost by it: one of the motion, or of the speed but for
    /// the brake, that is not stated.
    pub(crate) fn is_optional(&self, role: Role) -> bool {
        let is_further = match self.response {
            Response::Motion => self.response.others().contains(&role),
            Response::Speed => self.response.others().contains(&role) && role != Role::Brake,
            Response::YawRate | Response::LateralAcceleration | Response::Channels => false,
        };
        is_further && self.stated_channel(role).is_none()
    }

    /// What is stated and has no effect on the response, each in a sentence.
    pub(crate) fn without_effect(&self) -> Vec<String> {
        if self.response.is_of_yaw_rate() {
            return Vec::new();
        }
        let is_of_channels = self.response == Response::Channels;
        // The structure torque may read the steering angle.
        let has_steering = self.response == Response::LateralAcceleration;
        let all = [
            (self.steering_ratio.is_some(), "steering ratio"),
            (self.steering_full_scale_rad.is_some() && !has_steering, "steering full scale"),
            (self.vehicle_class.is_some(), "class of the vehicle"),
            (self.gnss_latency_s.is_some(), "latency of the GNSS receiver"),
            (self.antenna_x_m != 0.0, "place of the antenna"),
            (self.speed.is_some() && is_of_channels, "channel of the speed"),
            (self.speed_window.is_some() && is_of_channels, "speed window"),
        ];
        let model = match self.response {
            Response::Channels => "a plant of named channels",
            Response::Speed => "a model of the speed",
            _ => "a model of the lateral acceleration",
        };
        let mut sentences = Vec::new();
        for (_, option) in all.iter().filter(|(is_stated, _)| *is_stated) {
            sentences.push(format!("the stated {option} has no effect on {model}"));
        }
        sentences
    }

    /// The options in force by name, for the provenance.
    #[must_use]
    pub fn to_map(&self) -> BTreeMap<String, String> {
        let text = |s: &Option<String>| s.clone().unwrap_or_else(|| "auto".into());
        let number = |x: Option<f64>| match x {
            Some(x) => x.to_string(),
            None => "auto".into(),
        };
        let of_channels = |names: &[String], one: &Option<String>| match self.response {
            Response::Channels => names.join("; "),
            _ => text(one),
        };
        let mut map = BTreeMap::from([
            ("input".into(), of_channels(&self.inputs, &self.input)),
            ("output".into(), of_channels(&self.outputs, &self.output)),
            ("speed".into(), text(&self.speed)),
            ("time".into(), text(&self.time)),
            ("steering_ratio".into(), number(self.steering_ratio)),
            ("sample_time_s".into(), number(self.sample_time_s)),
            ("intersample".into(), self.intersample.map_or("auto", Intersample::name).into()),
            ("max_gap_s".into(), self.max_gap_s.to_string()),
        ]);
        if !self.windows.is_empty() {
            let windows: Vec<String> =
                self.windows.iter().map(|(from, to)| format!("{from},{to}")).collect();
            map.insert("window_s".into(), windows.join("; "));
        }
        if let Some((from, to)) = self.speed_window {
            map.insert("speed_window_mps".into(), format!("{from},{to}"));
        }
        if let Some(class) = self.vehicle_class {
            map.insert("vehicle_class".into(), class.name().into());
        }
        if self.antenna_x_m != 0.0 {
            map.insert("antenna_x_m".into(), self.antenna_x_m.to_string());
        }
        let optional = [
            ("gnss_latency_s", self.gnss_latency_s),
            ("row_period_s", self.row_period_s),
            ("steering_full_scale_rad", self.steering_full_scale_rad),
        ];
        for (name, value) in optional {
            value.map(|value| map.insert(name.into(), value.to_string()));
        }
        if let Some(line) = self.header_line {
            map.insert("header_line".into(), line.to_string());
        }
        if let Some(mark) = self.decimal {
            map.insert("decimal".into(), mark.name().into());
        }
        if !self.topics.is_empty() {
            map.insert("topics".into(), self.topics.join("; "));
        }
        for (name, text) in &self.dbc {
            map.insert(format!("dbc {name}"), steerwright_formats::sha256_hex(text));
        }
        if !self.ros_definitions.is_empty() {
            let texts: Vec<String> =
                self.ros_definitions.iter().map(|(kind, text)| format!("{kind}\n{text}")).collect();
            let hash = steerwright_formats::sha256_hex(texts.concat().as_bytes());
            map.insert("ros_definitions".into(), hash);
        }
        if self.response != Response::default() {
            map.insert("response".into(), self.response.name().into());
        }
        for (role, column) in &self.channels {
            map.insert(format!("channel {role}"), column.clone());
        }
        for (column, unit) in &self.units {
            map.insert(format!("unit {column}"), unit.clone());
        }
        map
    }
}
