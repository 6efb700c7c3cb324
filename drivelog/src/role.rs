//! The quantity that a column represents, with its units and values.

use crate::units::Quantity;

/// The quantity that a column represents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Angle of the steering wheel or of the road wheels.
    Steering,
    /// Command beside the measured angle of the steering.
    SteeringCommand,
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
    /// Accelerator pedal, or an acceleration command, which is negative to brake.
    LongitudinalCommand,
    /// Brake pedal.
    Brake,
    /// Grade of the road, positive uphill: an angle, or its tangent.
    Grade,
    /// Pitch of the vehicle by ISO 8855, positive with the nose down.
    Pitch,
    /// Altitude.
    Altitude,
    /// Number of the gear.
    Gear,
    /// Whether the controller steers.
    Engaged,
    /// Whether the driver steers against the controller.
    Override,
    /// Input of any system, by its place among those that are named.
    Input(u8),
    /// Output of any system, by its place among those that are named.
    Output(u8),
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

/// A unit for the hint about a column without one, by its name.
pub(crate) fn unit_in_place_of(column: &str) -> (&'static str, &'static str) {
    let roles = [
        Role::YawRate,
        Role::Speed,
        Role::Time,
        Role::Steering,
        Role::LongitudinalCommand,
        Role::Brake,
    ];
    let role = roles.into_iter().find(|r| r.is_named_like(column)).unwrap_or(Role::Steering);
    if role.is_pedal(column) {
        // No end of a name is the unit of a pedal.
        return ("", "%");
    }
    let [_, suffix, unit, _] = role.words();
    (suffix, unit)
}

impl Role {
    /// The word in messages; a unit that it often has, as the end of a name and as it is stated; all units
    /// that it may have.
    fn words(self) -> [&'static str; 4] {
        match self {
            Self::Steering => ["steering", "deg", "deg", "deg or rad"],
            Self::SteeringCommand => ["steering command", "deg", "deg", "deg or rad"],
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
            Self::LongitudinalCommand => [
                "accelerator or acceleration command",
                "mps2",
                "m/s2",
                "1 or % of an accelerator, or m/s2 or g of an acceleration command",
            ],
            Self::Brake => ["brake", "1", "1", "1 or %"],
            Self::Grade => ["grade", "deg", "deg", "deg or rad, or % or 1 of its tangent"],
            Self::Pitch => ["pitch", "deg", "deg", "deg or rad"],
            Self::Altitude => ["altitude", "m", "m", "m"],
            Self::Gear => ["gear", "1", "1", "1"],
            Self::Engaged => ["engagement", "1", "1", "1"],
            Self::Override => ["driver override", "1", "1", "1"],
            Self::Input(_) => ["input", "", "V", "any unit"],
            Self::Output(_) => ["output", "", "V", "any unit"],
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
            Self::SteeringCommand => "steering_command",
            Self::SteeringTorque => "steering_torque",
            Self::LateralAcceleration => "lateral_acceleration",
            Self::LongitudinalAcceleration => "longitudinal_acceleration",
            Self::LateralVelocity => "lateral_velocity",
            Self::LongitudinalCommand => "longitudinal_command",
            Self::Engaged => "engaged",
            Self::Override => "override",
            other => other.name(),
        }
    }

    /// The roles of a receiver's fixes.
    pub(crate) const PLACES: [Self; 4] = [Self::East, Self::North, Self::Latitude, Self::Longitude];

    /// The roles of channels.
    pub(crate) const OF_CHANNELS: [Self; 22] = [
        Self::Steering,
        Self::SteeringCommand,
        Self::SteeringTorque,
        Self::YawRate,
        Self::Speed,
        Self::LateralAcceleration,
        Self::LongitudinalAcceleration,
        Self::LateralVelocity,
        Self::Sideslip,
        Self::Roll,
        Self::LongitudinalCommand,
        Self::Brake,
        Self::Grade,
        Self::Pitch,
        Self::Altitude,
        Self::Gear,
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

    /// Whether its values are numbers of states, which are read on their rows and have no unit.
    pub(crate) fn is_state(self) -> bool {
        self.is_switch() || self == Self::Gear
    }

    /// Whether a column of that name is that of an accelerator or of a brake.
    pub(crate) fn is_pedal(self, column: &str) -> bool {
        match self {
            Self::Brake => true,
            Self::LongitudinalCommand => !Self::is_named_like_acceleration(column),
            _ => false,
        }
    }

    /// Whether it is an input that is held over each sample of the merged log.
    pub(crate) fn is_held(self) -> bool {
        matches!(
            self,
            Self::Steering
                | Self::SteeringCommand
                | Self::LongitudinalCommand
                | Self::Brake
                | Self::Input(_)
        )
    }

    /// Whether it is a channel of any system, which keeps the unit of the log.
    pub(crate) fn is_named_channel(self) -> bool {
        matches!(self, Self::Input(_) | Self::Output(_))
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
            Self::LongitudinalCommand => {
                matches!(quantity, Quantity::Acceleration | Quantity::Dimensionless)
            }
            Self::Grade => matches!(quantity, Quantity::Angle | Quantity::Dimensionless),
            Self::Brake | Self::Gear | Self::Engaged | Self::Override => {
                quantity == Quantity::Dimensionless
            }
            Self::Speed | Self::LateralVelocity => quantity == Quantity::Speed,
            Self::LateralAcceleration | Self::LongitudinalAcceleration => {
                quantity == Quantity::Acceleration
            }
            Self::Input(_) | Self::Output(_) => true,
            Self::Time => quantity == Quantity::Time,
            Self::East | Self::North | Self::Altitude => quantity == Quantity::Length,
            Self::SteeringCommand
            | Self::Roll
            | Self::Pitch
            | Self::Sideslip
            | Self::Latitude
            | Self::Longitude => quantity == Quantity::Angle,
        }
    }

    pub(crate) fn expected_units(self) -> &'static str {
        self.words()[3]
    }

    /// Least and largest value that a road vehicle can have, SI.
    pub(crate) fn limits(self, quantity: Quantity) -> Option<(f64, f64, &'static str)> {
        match (self, quantity) {
            // More than six turns of a steering wheel.
            (Self::Steering | Self::SteeringCommand, Quantity::Angle) => Some((-40.0, 40.0, "rad")),
            (Self::YawRate, Quantity::AngularRate) => Some((-10.0, 10.0, "rad/s")),
            (Self::Roll | Self::Pitch | Self::Sideslip, Quantity::Angle) => {
                Some((-1.6, 1.6, "rad"))
            }
            // Steeper than any road.
            (Self::Grade, _) => Some((-0.7, 0.7, "rad")),
            // Of a pedal, with a tenth for its calibration.
            (Self::LongitudinalCommand | Self::Brake, Quantity::Dimensionless) => {
                Some((-1.1, 1.1, "1"))
            }
            (Self::LongitudinalCommand, Quantity::Acceleration) => Some((-40.0, 40.0, "m/s2")),
            // What is backwards is left out of the drive.
            (Self::Speed, _) => Some((-150.0, 150.0, "m/s")),
            _ => None,
        }
    }

    /// Units of the same kind that could have been meant, with the value in each of them.
    pub(crate) fn alternatives(self, raw: f64, unit: &str) -> String {
        let deg = std::f64::consts::PI / 180.0;
        let others: &[(&str, f64)] = match self {
            Self::Steering | Self::SteeringCommand | Self::Roll | Self::Pitch | Self::Sideslip => {
                &[("deg", deg), ("rad", 1.0)]
            }
            Self::YawRate => &[("deg/s", deg), ("rad/s", 1.0)],
            Self::LongitudinalCommand | Self::Brake => &[("%", 0.01), ("1", 1.0)],
            Self::Speed => &[("m/s", 1.0), ("km/h", 1.0 / 3.6), ("mph", 0.447_04)],
            _ => &[],
        };
        let si = self.limits(match self {
            Self::YawRate => Quantity::AngularRate,
            Self::LongitudinalCommand | Self::Brake => Quantity::Dimensionless,
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
