//! The quantity that a column represents, with its possible names, units and values.

use crate::units::{Quantity, plain_name, split_brackets};

/// The quantity that a column represents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Angle of the steering wheel or of the road wheels.
    Steering,
    /// Torque at the steering, or its normalised command.
    SteeringTorque,
    /// Yaw rate, or yaw.
    YawRate,
    /// Speed.
    Speed,
    /// Lateral acceleration.
    LateralAcceleration,
    /// Longitudinal acceleration.
    LongitudinalAcceleration,
    /// Lateral velocity.
    LateralVelocity,
    /// Sideslip angle.
    Sideslip,
    /// Roll of the vehicle on a banked road.
    Roll,
    /// Whether the controller steers.
    Engaged,
    /// Whether the driver steers against the controller.
    Override,
    /// Time.
    Time,
    /// East coordinate of a receiver's fix.
    East,
    /// North coordinate of a receiver's fix.
    North,
    /// Latitude of a receiver's fix.
    Latitude,
    /// Longitude of a receiver's fix.
    Longitude,
}

/// The place of a steering angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wheel {
    Steering,
    Road,
}

/// A unit for the hint about a column without one, by its name.
pub(crate) fn unit_in_place_of(column: &str) -> (&'static str, &'static str) {
    let roles = [Role::YawRate, Role::Speed, Role::Time, Role::Steering];
    let role = roles.into_iter().find(|r| r.is_named_like(column)).unwrap_or(Role::Steering);
    let [_, suffix, unit, _] = role.words();
    (suffix, unit)
}

impl Role {
    /// The word in messages; a unit that it often has, as the end of a name and as it is stated; all units
    /// that it may have.
    fn words(self) -> [&'static str; 4] {
        match self {
            Self::Steering => ["steering", "deg", "deg", "deg or rad"],
            Self::YawRate => ["yaw rate", "degps", "deg/s", "deg/s or rad/s, or deg or rad of yaw"],
            Self::Speed => ["speed", "kmh", "km/h", "m/s, km/h or mph"],
            Self::SteeringTorque => ["steering torque", "Nm", "Nm", "Nm, or 1 or % of a command"],
            Self::LateralAcceleration => ["lateral acceleration", "mps2", "m/s2", "m/s2 or g"],
            Self::LongitudinalAcceleration => {
                ["longitudinal acceleration", "mps2", "m/s2", "m/s2 or g"]
            }
            Self::LateralVelocity => ["lateral velocity", "mps", "m/s", "m/s, km/h or mph"],
            Self::Sideslip => ["sideslip", "deg", "deg", "deg or rad"],
            Self::Roll => ["roll", "deg", "deg", "deg or rad"],
            Self::Engaged => ["engagement", "1", "1", "1"],
            Self::Override => ["driver override", "1", "1", "1"],
            Self::Time => ["time", "s", "s", "s, ms, us or ns"],
            Self::East => ["x of the position", "m", "m", "m"],
            Self::North => ["y of the position", "m", "m", "m"],
            Self::Latitude => ["latitude", "deg", "deg", "deg or rad"],
            Self::Longitude => ["longitude", "deg", "deg", "deg or rad"],
        }
    }

    pub(crate) fn name(self) -> &'static str {
        self.words()[0]
    }

    /// The word in files.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::YawRate => "yaw_rate",
            Self::SteeringTorque => "steering_torque",
            Self::LateralAcceleration => "lateral_acceleration",
            Self::LongitudinalAcceleration => "longitudinal_acceleration",
            Self::LateralVelocity => "lateral_velocity",
            Self::Engaged => "engaged",
            Self::Override => "override",
            other => other.name(),
        }
    }

    /// The roles of a receiver's fixes.
    pub(crate) const PLACES: [Self; 4] = [Self::East, Self::North, Self::Latitude, Self::Longitude];

    /// The roles of channels.
    pub(crate) const OF_CHANNELS: [Self; 15] = [
        Self::Steering,
        Self::SteeringTorque,
        Self::YawRate,
        Self::Speed,
        Self::LateralAcceleration,
        Self::LongitudinalAcceleration,
        Self::LateralVelocity,
        Self::Sideslip,
        Self::Roll,
        Self::Engaged,
        Self::Override,
        Self::East,
        Self::North,
        Self::Latitude,
        Self::Longitude,
    ];

    /// Whether it is one of [`Self::PLACES`].
    pub(crate) fn is_place(self) -> bool {
        Self::PLACES.contains(&self)
    }

    /// Whether single bad samples are looked for.
    pub(crate) fn has_spikes(self) -> bool {
        matches!(self, Self::Steering | Self::YawRate)
    }

    /// Whether its values are true and false, which have no unit.
    pub(crate) fn is_switch(self) -> bool {
        matches!(self, Self::Engaged | Self::Override)
    }

    /// Whether a column of that name may be taken where none is stated: as people and the field's tools
    /// name it, in English and German. Names whose sign or axis differs between tools (`gyro_z`,
    /// `heading_rate`) are left to be stated.
    pub(crate) fn is_named_like(self, header: &str) -> bool {
        self.is_of(&Name::new(header))
    }

    /// The same of a name that several roles are compared with.
    pub(crate) fn is_of(self, name: &Name<'_>) -> bool {
        self.is_in(name) && self.exclusion(name).is_none()
    }

    /// The word of a name like that of the role by which it is something else, such as its limit.
    pub(crate) fn excluded_by(self, header: &str) -> Option<&'static str> {
        let name = Name::new(header);
        self.exclusion(&name).filter(|_| self.is_in(&name))
    }

    /// Whether the name has that of the role in it.
    fn is_in(self, Name { header, plain: name }: &Name<'_>) -> bool {
        let any = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
        let is = |names: &[&str]| names.contains(&name.as_str());
        let starts = |parts: &[&str]| parts.iter().any(|part| name.starts_with(part));
        match self {
            Self::Steering => {
                // CANape, CarMaker (`Car.SteerAngleFL`), Autoware (`steering_tire_angle`), openpilot (`steeringAngleDeg`),
                // VBOX.
                any(&[
                    "steer",
                    "roadwheel",
                    "frontwheelangle",
                    "tireangle",
                    "tyreangle",
                    "handwheel",
                    "stwhlang",
                    "lenkwinkel",
                    "lenkradwinkel",
                    "radeinschlag",
                ]) || is(&["delta", "deltaf", "deltav", "wheelangle", "swa"])
            }
            Self::YawRate => has_rate(name),
            Self::Speed => {
                starts(&["speed", "vx", "velocity", "geschwindigkeit", "longitudinalvelocity"])
                    || any(&["vehiclespeed", "vehspeed", "vehspd", "groundspeed"])
                    || any(&["fahrzeuggeschw", "fzggeschw"])
                    // openpilot, CarMaker.
                    || is(&["vego", "carv", "vfzg"])
            }
            Self::LateralAcceleration => {
                any(&["lateralacc", "latacc", "accellat", "acclat", "querbeschl"])
                    || is(&["ay", "accy", "alat", "accelerationy", "linearaccelerationy"])
            }
            Self::LongitudinalAcceleration => {
                any(&["longitudinalacc", "longacc", "accellong", "acclong", "laengsbeschl"])
                    || is(&["ax", "accx", "along", "accelerationx", "linearaccelerationx"])
            }
            Self::LateralVelocity => is(&["vy", "lateralvelocity", "velocityy"]),
            Self::Sideslip => any(&["sideslip", "schwimmwinkel", "slipangle"]),
            Self::SteeringTorque => {
                any(&["steertorque", "steeringtorque", "lenkmoment"]) || is(&["steerfiltered"])
            }
            Self::Roll => is(&["roll", "rollangle", "roadroll", "wankwinkel"]),
            Self::Engaged => is(&["latactive", "lateralactive", "steeringengaged"]),
            Self::Override => is(&["steeringpressed", "steeroverride", "steeringoverride"]),
            Self::Time => {
                let header = header.trim_start_matches('_').to_lowercase();
                header == "t"
                    || ["time", "stamp", "t_", "t ", "t[", "zeit", "uhrzeit"]
                        .into_iter()
                        .any(|start| header.starts_with(start))
            }
            Self::East => matches!(&*header.to_lowercase(), "x_m" | "x [m]" | "gnss_x_m"),
            Self::North => matches!(&*header.to_lowercase(), "y_m" | "y [m]" | "gnss_y_m"),
            Self::Latitude => header.to_lowercase().starts_with("latitude"),
            Self::Longitude => header.to_lowercase().starts_with("longitude"),
        }
    }

    /// The word by which a name is that of something else.
    fn exclusion(self, Name { header, plain: name }: &Name<'_>) -> Option<&'static str> {
        let any = |parts: &[&'static str]| parts.iter().copied().find(|part| name.contains(part));
        let words = words_of(header);
        let quantity = || word_of(&words, PARAMETERS);
        // A command is an input: it is taken for the steering.
        let command = || any(&["target", "desired", "soll"]).or_else(|| word_of(&words, COMMANDS));
        match self {
            Self::Steering => {
                any(&["speed", "velocity", "torque", "geschw", "status", "pressed", "override"])
                    .or_else(|| word_of(&words, &["rate", "ratio", "force", "moment"]))
                    .or_else(quantity)
                    // `current_steering_angle` is the one of now.
                    .or_else(|| word_of(words.get(1..).unwrap_or_default(), &["current"]))
            }
            Self::SteeringTorque => any(&["driver", "hand", "fahrer"]).or_else(quantity),
            Self::YawRate => {
                let is_reference = words.iter().any(|word| word.starts_with("ref"));
                command().or_else(quantity).or_else(|| is_reference.then_some("ref"))
            }
            // Of openpilot's steering angle.
            Self::LateralAcceleration => any(&["steeringangle"]).or_else(command).or_else(quantity),
            Self::Sideslip => any(&["tire", "tyre", "wheel"]).or_else(command).or_else(quantity),
            Self::Speed | Self::LongitudinalAcceleration | Self::LateralVelocity | Self::Roll => {
                command().or_else(quantity)
            }
            _ => None,
        }
    }

    /// Whether the name is that of a rate of yaw, whatever its unit is.
    pub(crate) fn is_rate(self, header: &str) -> bool {
        self == Self::YawRate && has_rate(&plain_name(header))
    }

    /// Whether a steering column is named like that of a steering wheel, or like that of a road wheel.
    pub(crate) fn wheel(header: &str) -> Option<Wheel> {
        let name = plain_name(header);
        let any = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
        if any(&["road", "front", "tire", "tyre", "radlenk", "radeinschlag"]) {
            return Some(Wheel::Road);
        }
        let is_steering_wheel = any(&["wheel", "lenkrad", "stwhl"]) || name == "swa";
        is_steering_wheel.then_some(Wheel::Steering)
    }

    pub(crate) fn takes(self, quantity: Quantity) -> bool {
        match self {
            Self::Steering => matches!(quantity, Quantity::Angle | Quantity::Dimensionless),
            Self::YawRate => matches!(
                quantity,
                Quantity::AngularRate | Quantity::Angle | Quantity::Dimensionless
            ),
            Self::SteeringTorque => {
                matches!(quantity, Quantity::Torque | Quantity::Dimensionless)
            }
            Self::Engaged | Self::Override => quantity == Quantity::Dimensionless,
            Self::Speed | Self::LateralVelocity => quantity == Quantity::Speed,
            Self::LateralAcceleration | Self::LongitudinalAcceleration => {
                quantity == Quantity::Acceleration
            }
            Self::Time => quantity == Quantity::Time,
            Self::East | Self::North => quantity == Quantity::Length,
            Self::Roll | Self::Sideslip | Self::Latitude | Self::Longitude => {
                quantity == Quantity::Angle
            }
        }
    }

    pub(crate) fn expected_units(self) -> &'static str {
        self.words()[3]
    }

    /// Least and largest value that a road vehicle can have, SI.
    pub(crate) fn limits(self, quantity: Quantity) -> Option<(f64, f64, &'static str)> {
        match (self, quantity) {
            // More than six turns of a steering wheel.
            (Self::Steering, Quantity::Angle) => Some((-40.0, 40.0, "rad")),
            (Self::YawRate, Quantity::AngularRate) => Some((-10.0, 10.0, "rad/s")),
            (Self::Roll | Self::Sideslip, Quantity::Angle) => Some((-1.6, 1.6, "rad")),
            // What is backwards is left out of the drive.
            (Self::Speed, _) => Some((-150.0, 150.0, "m/s")),
            _ => None,
        }
    }

    /// Units of the same kind that could have been meant, with the value in each of them.
    pub(crate) fn alternatives(self, raw: f64, unit: &str) -> String {
        let deg = std::f64::consts::PI / 180.0;
        let others: &[(&str, f64)] = match self {
            Self::Steering | Self::Roll | Self::Sideslip => &[("deg", deg), ("rad", 1.0)],
            Self::YawRate => &[("deg/s", deg), ("rad/s", 1.0)],
            Self::Speed => &[("m/s", 1.0), ("km/h", 1.0 / 3.6), ("mph", 0.447_04)],
            _ => &[],
        };
        let si = self.limits(match self {
            Self::YawRate => Quantity::AngularRate,
            _ => Quantity::Angle,
        });
        let fits: Vec<String> = others
            .iter()
            .filter(|(name, _)| *name != unit)
            .filter(|(_, k)| si.is_some_and(|(lo, hi, _)| (lo..=hi).contains(&(raw * k))))
            .map(|(name, k)| {
                format!("{name} would make it {:.3} {}", raw * k, si.map_or("", |s| s.2))
            })
            .collect();
        if fits.is_empty() {
            "no unit makes this possible: check the mapping and that row".into()
        } else {
            format!("state the right unit: {}", fits.join(", "))
        }
    }
}

/// The name of a column, and the same as names are compared.
pub(crate) struct Name<'h> {
    header: &'h str,
    plain: String,
}

impl<'h> Name<'h> {
    pub(crate) fn new(header: &'h str) -> Self {
        Self { header, plain: plain_name(header) }
    }
}

/// Whether a plain name has a rate of yaw in it.
fn has_rate(name: &str) -> bool {
    let rates = ["yawrate", "yawvel", "gierrate", "giergeschw", "psip", "psidot", "yawangularvel"];
    rates.iter().any(|part| name.contains(part))
}

/// What is stated about a quantity and is not the quantity.
const PARAMETERS: &[&str] = &[
    "gain",
    "factor",
    "bias",
    "offset",
    "variance",
    "sigma",
    "std",
    "stddev",
    "accuracy",
    "quality",
    "valid",
    "validity",
    "status",
    "limit",
    "min",
    "max",
    "minimum",
    "maximum",
    "threshold",
];
/// What a quantity is to be.
const COMMANDS: &[&str] = &["cmd", "command", "setpoint", "ref", "reference", "referenz"];
/// Behind the name of an error: the quantity without it.
const CORRECTED: [&str; 6] =
    ["corrected", "compensated", "removed", "free", "adjusted", "korrigiert"];

/// The words of a name in lower case, as `_`, punctuation, digits and the case set them off.
fn words_of(header: &str) -> Vec<String> {
    let (name, _) = split_brackets(header);
    let letters: Vec<char> = name.rsplit('/').next().unwrap_or(name).chars().collect();
    let mut words = vec![String::new()];
    for (i, c) in letters.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| letters[i]);
        let after = letters.get(i + 1);
        // `steerRate`, `EPSCurrent`.
        let begins = c.is_uppercase()
            && (before.is_some_and(char::is_lowercase) || after.is_some_and(|c| c.is_lowercase()));
        if begins || !c.is_alphabetic() {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| c.is_alphabetic()) {
            word.extend(c.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The ending that is a word, ends one, or follows within one on what it may be of; the `rate` in `calibrated` does not.
/// An offset that is corrected is none.
fn word_of(words: &[String], endings: &[&'static str]) -> Option<&'static str> {
    const OF: [&str; 6] = ["steer", "steering", "angle", "wheel", "winkel", "rate"];
    let is_compound = |word: &str, end: &str| {
        let follows = |of: &&str| {
            word.match_indices(*of).any(|(at, _)| word[at + of.len()..].starts_with(end))
        };
        word.ends_with(end) || OF.iter().any(follows)
    };
    let is_corrected = |at: usize, end: &str| {
        let next = words.get(at + 1).is_some_and(|word| CORRECTED.contains(&word.as_str()));
        next && matches!(end, "offset" | "bias")
    };
    let of_word = |(at, word): (usize, &String)| {
        let is = |end: &&&str| is_compound(word, end) && !is_corrected(at, end);
        endings.iter().find(is).copied()
    };
    words.iter().enumerate().find_map(of_word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_excluded_by_their_words() {
        for name in [
            "steering_angle_calibrated_deg",
            "integrated_steering_angle_rad",
            "SteerAngleCalibration",
            "current_steering_angle_deg",
            "CurrentSteerAngle",
            "momentary_steering_angle [deg]",
        ] {
            assert!(Role::Steering.is_named_like(name), "{name}");
        }
        for name in [
            "steering_rate",
            "steeringRateDeg",
            "steeringrate",
            "steeringratedeg",
            "STEERRATE",
            "SteerRate1",
            "lenkwinkelrate",
            "Lenkradwinkelgeschwindigkeit",
            "SteeringWheelSpeed",
            "steeringTorqueEps",
            "steertorque",
            "steering_ratio",
            "steerRatio",
            "steering_motor_current",
            "SteerEPSCurrent",
            "steer_force",
            "SteerMoment [Nm]",
            "steerOverride",
            "steeringPressed",
            "angle_offset_steer",
            "steering_gain",
            "SteerAngleValid",
            "/carState/steer_rate",
        ] {
            assert!(!Role::Steering.is_named_like(name), "{name}");
        }
        for name in ["yaw_rate_prefiltered", "YawRatePrefiltered", "Gierrate [°/s]"] {
            assert!(Role::YawRate.is_named_like(name), "{name}");
        }
        for name in [
            "yaw_rate_ref",
            "yawRateRef",
            "yawrateref",
            "refYawRate",
            "reference_yaw_rate",
            "yaw_rate_reference",
            "yawrate_target",
            "desiredYawRate",
            "SollGierrate",
            "gierratesoll",
            "yaw_rate_gain",
            "YawRateGain",
            "yawrate_offset",
            "yaw_rate_valid",
        ] {
            assert!(!Role::YawRate.is_named_like(name), "{name}");
        }
        for name in ["speed_limit_kmh", "speed_target", "SpeedGain", "velocity_ref"] {
            assert!(!Role::Speed.is_named_like(name), "{name}");
        }
        for name in ["speed_filtered_mps", "vehicle_speed_offset_corrected_mps", "speed_validated"]
        {
            assert!(Role::Speed.is_named_like(name), "{name}");
        }
        assert!(Role::YawRate.is_named_like("yaw_rate_bias_compensated"));
        assert_eq!(Role::Speed.excluded_by("vehicle_speed_offset_mps"), Some("offset"));
        // One list of words for all that is measured; a command is an input.
        let of_words = ["limit", "max", "min", "status", "std", "accuracy", "valid", "offset"];
        let measured = [
            (Role::YawRate, "yaw_rate"),
            (Role::Speed, "speed"),
            (Role::LateralAcceleration, "lateral_acceleration"),
            (Role::LongitudinalAcceleration, "longitudinal_acceleration"),
            (Role::Sideslip, "sideslip"),
        ];
        for (role, name) in measured {
            for word in of_words.iter().chain(&["setpoint", "cmd", "target"]) {
                assert!(!role.is_named_like(&format!("{name}_{word}")), "{name}_{word}");
            }
        }
        for word in of_words {
            assert!(!Role::Steering.is_named_like(&format!("steering_angle_{word}")), "{word}");
        }
        for name in ["steering_cmd_rad", "steering_angle_target_deg", "steer_setpoint"] {
            assert!(Role::Steering.is_named_like(name), "{name}");
        }
    }
}
