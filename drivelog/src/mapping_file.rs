//! The mapping file of a team: which channels are what in the logs of its vehicles.
//!
//! ```toml
//! steering_ratio = 15.3              # of all vehicles, unless one states another
//!
//! [vehicle.rav4]
//! dbc = ["toyota.dbc"]               # next to the mapping file
//! steering = "STEER_ANGLE + STEER_FRACTION"
//! yaw_rate = "YAW_RATE"
//! speed = "can0:SPEED.SPEED"
//! units = { YAW_RATE = "deg/s" }
//! ```

use crate::Error;
use crate::options::{LogOptions, Response};
use crate::role::Role;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use steerwright_formats::UnknownWord;

/// How logs are read, as far as it is stated.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mapping {
    /// Steering angle.
    pub steering: Option<String>,
    /// Yaw rate, or yaw.
    pub yaw_rate: Option<String>,
    /// Steering torque, or its normalised command.
    pub steering_torque: Option<String>,
    /// Accelerator pedal, or acceleration command.
    pub longitudinal_command: Option<String>,
    /// Lateral acceleration.
    pub lateral_acceleration: Option<String>,
    /// Further channels, as [`LogOptions::channels`].
    #[serde(default)]
    pub channels: BTreeMap<String, String>,
    /// As [`LogOptions::speed`].
    pub speed: Option<String>,
    /// As [`LogOptions::time`].
    pub time: Option<String>,
    /// As [`LogOptions::units`].
    #[serde(default)]
    pub units: BTreeMap<String, String>,
    /// As [`LogOptions::topics`].
    #[serde(default)]
    pub topics: Vec<String>,
    /// CAN databases, as paths relative to the mapping file.
    #[serde(default)]
    pub dbc: Vec<String>,
    /// As [`LogOptions::header_line`].
    pub header_line: Option<u64>,
    /// `point` or `comma`.
    pub decimal: Option<String>,
    /// As [`LogOptions::steering_ratio`].
    pub steering_ratio: Option<f64>,
    /// As [`LogOptions::steering_full_scale_rad`], deg.
    pub steering_full_scale_deg: Option<f64>,
    /// `zoh`, `foh` or `bl`.
    pub intersample: Option<String>,
    /// As [`LogOptions::row_period_s`].
    pub row_period_s: Option<f64>,
    /// As [`LogOptions::gnss_latency_s`].
    pub gnss_latency_s: Option<f64>,
    /// As [`LogOptions::antenna_x_m`].
    pub antenna_x_m: Option<f64>,
}

#[derive(Deserialize)]
struct File {
    #[serde(default)]
    vehicle: BTreeMap<String, Mapping>,
    #[serde(flatten)]
    all: toml::Table,
}

impl Mapping {
    /// Reads a mapping file: what it states for all vehicles, and over it what it states for one.
    ///
    /// A vehicle must be named where the file has several.
    ///
    /// # Errors
    /// [`Error::Mapping`] with the line.
    pub fn of_toml(text: &str, file: &str, vehicle: Option<&str>) -> Result<Self, Error> {
        let refused = |problem: String| Error::Mapping { file: file.into(), problem };
        let parsed: File = toml::from_str(text).map_err(|e| refused(in_one_line(&e, text)))?;
        let all: Self = parsed.all.try_into().map_err(|e| refused(in_one_line(&e, text)))?;
        let names: Vec<&str> = parsed.vehicle.keys().map(String::as_str).collect();
        let name = match (vehicle, &names[..]) {
            (Some(name), _) => name,
            (None, []) => return Ok(all),
            (None, [one]) => one,
            (None, _) => {
                return Err(refused(format!("which vehicle? There are: {}", names.join(", "))));
            }
        };
        let own = parsed.vehicle.get(name).cloned().ok_or_else(|| {
            refused(format!("there is no vehicle `{name}`; there are: {}", names.join(", ")))
        })?;
        Ok(own.over(all))
    }

    /// What this one states, and the rest as `other` states it.
    fn over(self, other: Self) -> Self {
        let list = |own: Vec<String>, other| if own.is_empty() { other } else { own };
        let mut units = other.units;
        units.extend(self.units);
        let mut channels = other.channels;
        channels.extend(self.channels);
        Self {
            steering: self.steering.or(other.steering),
            yaw_rate: self.yaw_rate.or(other.yaw_rate),
            steering_torque: self.steering_torque.or(other.steering_torque),
            longitudinal_command: self.longitudinal_command.or(other.longitudinal_command),
            lateral_acceleration: self.lateral_acceleration.or(other.lateral_acceleration),
            channels,
            speed: self.speed.or(other.speed),
            time: self.time.or(other.time),
            units,
            topics: list(self.topics, other.topics),
            dbc: list(self.dbc, other.dbc),
            header_line: self.header_line.or(other.header_line),
            decimal: self.decimal.or(other.decimal),
            steering_ratio: self.steering_ratio.or(other.steering_ratio),
            steering_full_scale_deg: self.steering_full_scale_deg.or(other.steering_full_scale_deg),
            intersample: self.intersample.or(other.intersample),
            row_period_s: self.row_period_s.or(other.row_period_s),
            gnss_latency_s: self.gnss_latency_s.or(other.gnss_latency_s),
            antenna_x_m: self.antenna_x_m.or(other.antenna_x_m),
        }
    }

    /// Fills in what the options leave open, for their response; the databases are for the caller to read.
    ///
    /// # Errors
    /// [`Error::UnknownWord`] for an unknown word.
    pub fn apply(self, options: &mut LogOptions) -> Result<(), Error> {
        let fill = |own: &mut Option<String>, stated| *own = own.take().or(stated);
        // Those of other responses are left out.
        let known = Response::ALL.into_iter().flat_map(Response::others).map(|role| role.key());
        let known: BTreeSet<&str> = known.collect();
        if let Some(role) = self.channels.keys().find(|role| !known.contains(role.as_str())) {
            let known: Vec<&str> = known.into_iter().collect();
            return Err(unknown("channels", role, format!("one of {}", known.join(", "))));
        }
        let mut further: Vec<(&str, Option<String>)> =
            self.channels.iter().map(|(role, name)| (role.as_str(), Some(name.clone()))).collect();
        match options.response {
            Response::YawRate => {
                fill(&mut options.input, self.steering);
                fill(&mut options.output, self.yaw_rate);
            }
            Response::Motion => {
                fill(&mut options.input, self.steering);
                fill(&mut options.output, self.yaw_rate);
                further.push((Role::LateralAcceleration.key(), self.lateral_acceleration));
            }
            Response::LateralAcceleration => {
                fill(&mut options.input, self.steering_torque);
                fill(&mut options.output, self.lateral_acceleration);
                further.push((Role::Steering.key(), self.steering));
            }
            Response::Speed => fill(&mut options.input, self.longitudinal_command),
            Response::Channels => {}
        }
        for (role, channel) in further {
            let is_of_response = options.response.others().iter().any(|own| own.key() == role);
            if let (Some(channel), true) = (channel, is_of_response) {
                options.channels.entry(role.into()).or_insert(channel);
            }
        }
        fill(&mut options.speed, self.speed);
        fill(&mut options.time, self.time);
        for (name, unit) in self.units {
            options.units.entry(name).or_insert(unit);
        }
        if options.topics.is_empty() {
            options.topics = self.topics;
        }
        if let Some(word) = self.decimal {
            let mark =
                word.parse().map_err(|e: UnknownWord| unknown("decimal", &word, e.expected()))?;
            options.decimal = options.decimal.or(Some(mark));
        }
        if let Some(word) = self.intersample {
            let found = word
                .parse()
                .map_err(|e: UnknownWord| unknown("intersample", &word, e.expected()))?;
            options.intersample = options.intersample.or(Some(found));
        }
        options.header_line = options.header_line.or(self.header_line);
        options.steering_ratio = options.steering_ratio.or(self.steering_ratio);
        options.steering_full_scale_rad =
            options.steering_full_scale_rad.or(self.steering_full_scale_deg.map(f64::to_radians));
        options.row_period_s = options.row_period_s.or(self.row_period_s);
        options.gnss_latency_s = options.gnss_latency_s.or(self.gnss_latency_s);
        if options.antenna_x_m == 0.0 {
            options.antenna_x_m = self.antenna_x_m.unwrap_or_default();
        }
        Ok(())
    }
}

fn unknown(option: &'static str, word: &str, expected: String) -> Error {
    Error::UnknownWord { option, word: word.into(), expected }
}

/// The fault with its line.
fn in_one_line(error: &toml::de::Error, text: &str) -> String {
    let at = error.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count());
    let line = match at {
        Some(line) => format!("line {line}: "),
        None => String::new(),
    };
    format!("{line}{}", error.message())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEAM: &str = "steering_ratio = 15.0\nunits = { v = \"km/h\" }\n[vehicle.one]\nsteering = \"A + B\"\n\
        [vehicle.two]\nsteering = \"delta\"\nsteering_ratio = 1\nunits = { delta = \"rad\" }\n";

    #[test]
    fn a_vehicle_states_its_own_over_those_of_all() {
        let of = |vehicle| Mapping::of_toml(TEAM, "mapping.toml", vehicle);
        let mut options = LogOptions { speed: Some("v".into()), ..LogOptions::default() };
        Mapping::of_toml("header_line = 7", "m", None).unwrap().apply(&mut options).unwrap();
        assert_eq!(options.header_line.take(), Some(7));
        of(Some("two")).unwrap().apply(&mut options).unwrap();
        assert_eq!(options.steering_ratio, Some(1.0));
        assert_eq!(options.input.as_deref(), Some("delta"));
        assert_eq!(options.speed.as_deref(), Some("v"));
        assert_eq!(options.units.len(), 2);
        // What is stated with the command goes before the file.
        let mut stated = LogOptions { steering_ratio: Some(16.0), ..LogOptions::default() };
        of(Some("one")).unwrap().apply(&mut stated).unwrap();
        assert_eq!(stated.steering_ratio, Some(16.0));
        assert_eq!(stated.input.as_deref(), Some("A + B"));
        let message = |vehicle| of(vehicle).unwrap_err().to_string();
        assert_eq!(message(None), "mapping.toml: which vehicle? There are: one, two");
        assert!(message(Some("tow")).contains("no vehicle `tow`; there are: one, two"));
    }

    #[test]
    fn channels_are_those_of_the_response() {
        let text = "steering = \"angle\"\nyaw_rate = \"gyro\"\nsteering_torque = \"eps\"\nchannels = { roll = \"bank\" }\n";
        let of = |response| {
            let mut options = LogOptions { response, ..LogOptions::default() };
            let mapping = Mapping::of_toml(text, "mapping.toml", None).unwrap();
            mapping.apply(&mut options).unwrap();
            options
        };
        let yaw = of(Response::YawRate);
        assert_eq!(yaw.input.as_deref(), Some("angle"));
        assert!(yaw.channels.is_empty());
        // The roll is a channel of the other response.
        let motion = of(Response::Motion);
        assert_eq!(motion.output.as_deref(), Some("gyro"));
        assert!(motion.channels.is_empty());
        let torque = of(Response::LateralAcceleration);
        assert_eq!([torque.input.as_deref(), torque.output.as_deref()], [Some("eps"), None]);
        let channels: Vec<(&str, &str)> =
            torque.channels.iter().map(|(role, name)| (role.as_str(), name.as_str())).collect();
        assert_eq!(channels, [("roll", "bank"), ("steering", "angle")]);
    }

    #[test]
    fn faults_are_named_with_their_line() {
        for (text, part) in [
            ("steerin = \"a\"\n", "unknown field `steerin`"),
            ("\n\n[vehicle.x]\nratio = 3\n", "line 4: unknown field `ratio`"),
            ("steering = 3\n", "invalid type"),
            ("steering = \n", "line 1"),
        ] {
            let error = Mapping::of_toml(text, "m.toml", None).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
            assert!(!error.hint().is_empty());
        }
    }
}
