//! Tables of known programs that state their units in documentation only.

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

/// The unit of a column of a table whose header is that of a known program.
pub(super) fn unit(header: &[String], column: &str) -> Option<&'static str> {
    let has = |name: &str| header.iter().any(|own| own == name);
    let is_known = STEERING_CONTROL.iter().all(|(name, _)| has(name));
    let unit = STEERING_CONTROL.iter().find(|(name, _)| is_known && *name == column);
    unit.map(|(_, unit)| *unit)
}
