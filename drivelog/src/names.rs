//! Names of columns as people and the field's tools write them, in English and German: which quantity a name is that of,
//! and by which words it is that of something else.

use crate::role::Role;
use crate::units::{plain_name, split_brackets};

/// The place of a steering angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wheel {
    Steering,
    Road,
}

impl Role {
    /// Whether a column is named like an acceleration that is commanded.
    pub(crate) fn is_named_like_acceleration(header: &str) -> bool {
        is_acceleration_command(&plain_name(header))
    }

    /// Whether a column is named like a time in another way than [`Role::Time`], such as `Elapsed Time` or `LogTime`, and not
    /// like that of a lap or a difference.
    pub(crate) fn is_named_like_another_time(header: &str) -> bool {
        const OTHERS: [&str; 13] = [
            "lap",
            "delta",
            "diff",
            "rel",
            "delay",
            "split",
            "sector",
            "trip",
            "best",
            "predicted",
            "remaining",
            "dead",
            "response",
        ];
        let words = words_of(header);
        let is_time = words.last().is_some_and(|word| {
            ["time", "timestamp", "zeit", "clock"].iter().any(|end| word.ends_with(end))
        });
        is_time && !words.iter().any(|word| OTHERS.iter().any(|other| word.starts_with(other)))
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

    /// Whether a name is that of a speed of a GNSS receiver, which is taken where no other one is there.
    pub(crate) fn is_of_gnss(self, header: &str) -> bool {
        let name = plain_name(header);
        let speeds = ["gpsspeed", "gnssspeed", "speedgps", "speedgnss", "gpsvelocity"];
        self == Self::Speed && speeds.iter().any(|own| name.contains(own))
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
            // Where a command is the only steering there is, it is the input: beside an angle it has to be named.
            Self::SteeringCommand => false,
            Self::Input(_) | Self::Output(_) => false,
            Self::YawRate => has_rate(name),
            Self::Speed => {
                starts(SPEEDS)
                    || field_of(header).is_some_and(|own| SPEEDS.iter().any(|s| own.starts_with(s)))
                    || any(&["vehiclespeed", "vehspeed", "vehspd", "groundspeed"])
                    || self.is_of_gnss(header)
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
            Self::LongitudinalCommand => {
                let is_accelerator = any(&[
                    "accelerator",
                    "accelpedal",
                    "accpedal",
                    "gaspedal",
                    "throttle",
                    "fahrpedal",
                ]) || is(&["gas", "pedalgas"]);
                is_accelerator || is_acceleration_command(name)
            }
            Self::Brake => any(&["brake", "bremse", "bremspedal"]),
            Self::Grade => {
                any(&["roadgrade", "roadslope", "roadgradient", "roadinclination", "steigung"])
                    || is(&["grade", "slope", "gradeangle", "slopeangle"])
            }
            Self::Pitch => is(&["pitch", "pitchangle", "vehiclepitch", "roadpitch", "nickwinkel"]),
            Self::Altitude => is(&[
                "altitude",
                "alt",
                "elevation",
                "gpsaltitude",
                "gnssaltitude",
                "höhe",
                "hoehe",
            ]),
            Self::Gear => {
                is(&["gear", "currentgear", "actualgear", "gearactual", "gang", "istgang"])
            }
            Self::Roll => is(&["roll", "rollangle", "roadroll", "wankwinkel"]),
            Self::Engaged => is(&["latactive", "lateralactive", "steeringengaged"]),
            Self::Override => is(&["steeringpressed", "steeroverride", "steeringoverride"]),
            Self::Time => {
                let header = header.trim_start_matches('_').to_lowercase();
                header == "t"
                    // WinDarab.
                    || TIMES.iter().any(|start| header.starts_with(start))
                    // Time of the week of GNSS.
                    || ["tow", "itow", "gpstow"].contains(&name.as_str())
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
            Self::LongitudinalCommand => any(&[
                "lateral", "quer", "brake", "bremse", "pressed", "released", "switch", "override",
                "torque", "temp",
            ])
            .or_else(|| word_of(&words, &["rate", "force"]))
            .or_else(quantity),
            Self::Brake => any(&[
                "pressed", "released", "switch", "light", "lamp", "park", "hand", "temp", "torque",
                "force", "pressure", "druck", "override", "hold",
            ])
            .or_else(|| word_of(&words, &["rate"]))
            .or_else(quantity),
            Self::Speed
            | Self::LongitudinalAcceleration
            | Self::LateralVelocity
            | Self::Roll
            | Self::Grade
            | Self::Pitch
            | Self::Altitude
            | Self::Gear => command().or_else(quantity),
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

/// Whether a plain name is that of an acceleration that is commanded.
fn is_acceleration_command(name: &str) -> bool {
    let quantities = ["acceleration", "accel", "ax"];
    let words = ["command", "cmd", "request", "setpoint", "demand", "target", "desired", "soll"];
    let is_named = |quantity: &str, word: &str| {
        name.ends_with(&format!("{quantity}{word}")) || name.ends_with(&format!("{word}{quantity}"))
    };
    quantities.iter().any(|quantity| words.iter().any(|word| is_named(quantity, word)))
        || name.contains("sollbeschl")
}

/// Whether a plain name has a rate of yaw in it.
fn has_rate(name: &str) -> bool {
    let rates = ["yawrate", "yawvel", "gierrate", "giergeschw", "psip", "psidot", "yawangularvel"];
    // CarSim.
    name == "avz" || rates.iter().any(|part| name.contains(part))
}

/// How names of times begin, also in German, French, Spanish, Russian and Chinese.
const TIMES: &[&str] = &[
    "time",
    "xtime",
    "stamp",
    "t_",
    "t ",
    "t[",
    "zeit",
    "uhrzeit",
    "temps",
    "tiempo",
    "время",
    "时间",
    "時間",
];

/// How names of speeds begin, of which some are those of other speeds further within a name.
const SPEEDS: &[&str] = &["speed", "vx", "velocity", "geschwindigkeit", "longitudinalvelocity"];

/// The plain name of a field of the vehicle, or of the message that a row of rostopic or Foxglove has.
fn field_of(header: &str) -> Option<String> {
    const WHOLES: [&str; 8] =
        ["field", "value", "msg", "data", "car", "vehicle", "ego", "carstate"];
    let (whole, field) = header.split_once('.')?;
    let is_whole = WHOLES.iter().any(|name| whole.eq_ignore_ascii_case(name));
    if is_whole && !field.contains('.') { Some(plain_name(field)) } else { None }
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
        for name in ["AVz [deg/s]", "yaw_rate_prefiltered", "YawRatePrefiltered", "Gierrate [°/s]"]
        {
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
        for name in [
            "motor.speed",
            "car.wheel.speed",
            "field.speed_limit",
            "GPS Speed Accuracy",
            "speed_limit_kmh",
            "speed_target",
            "SpeedGain",
            "velocity_ref",
        ] {
            assert!(!Role::Speed.is_named_like(name), "{name}");
        }
        for name in [
            "field.speed",
            "GPS Speed [km/h]",
            "car.speed_kmh",
            "Vehicle.velocity [m/s]",
            "speed_filtered_mps",
            "vehicle_speed_offset_corrected_mps",
            "speed_validated",
        ] {
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
