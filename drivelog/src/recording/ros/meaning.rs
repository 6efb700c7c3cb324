//! Units and roles of the fields of common messages, as their definitions state them. Axes are those of REP 103,
//! which are those of ISO 8855.

use super::schema::plain;
use crate::recording::Channel;
use crate::role::Role;

/// A field of a type, by the end of its path, with its unit and role.
type Meaning = (&'static str, &'static str, Option<Role>);

const TWIST: &[Meaning] = &[
    ("linear.x", "m/s", Some(Role::Speed)),
    ("linear.y", "m/s", None),
    ("linear.z", "m/s", None),
    ("angular.x", "rad/s", None),
    ("angular.y", "rad/s", None),
    ("angular.z", "rad/s", Some(Role::YawRate)),
];

const POSITION: &[Meaning] = &[
    ("position.x", "m", Some(Role::East)),
    ("position.y", "m", Some(Role::North)),
    ("position.z", "m", None),
];

const ACKERMANN: &[Meaning] = &[
    ("steering_angle", "rad", Some(Role::Steering)),
    ("steering_angle_velocity", "rad/s", None),
    // Commands.
    ("speed", "m/s", None),
    ("acceleration", "m/s2", None),
];

/// Types by package and name, with the path to the fields and the fields.
const TYPES: &[(&str, &str, &[Meaning])] = &[
    (
        "sensor_msgs/Imu",
        "",
        &[
            ("angular_velocity.x", "rad/s", None),
            ("angular_velocity.y", "rad/s", None),
            ("angular_velocity.z", "rad/s", Some(Role::YawRate)),
            ("linear_acceleration.x", "m/s2", None),
            ("linear_acceleration.y", "m/s2", Some(Role::LateralAcceleration)),
            ("linear_acceleration.z", "m/s2", None),
        ],
    ),
    (
        "sensor_msgs/NavSatFix",
        "",
        &[
            ("latitude", "deg", Some(Role::Latitude)),
            ("longitude", "deg", Some(Role::Longitude)),
            ("altitude", "m", None),
        ],
    ),
    ("nav_msgs/Odometry", "twist.twist.", TWIST),
    ("nav_msgs/Odometry", "pose.pose.", POSITION),
    ("geometry_msgs/TwistStamped", "twist.", TWIST),
    ("geometry_msgs/TwistWithCovarianceStamped", "twist.twist.", TWIST),
    ("geometry_msgs/PoseStamped", "pose.", POSITION),
    ("geometry_msgs/PoseWithCovarianceStamped", "pose.pose.", POSITION),
    ("ackermann_msgs/AckermannDriveStamped", "drive.", ACKERMANN),
    ("ackermann_msgs/AckermannDrive", "", ACKERMANN),
    (
        "autoware_vehicle_msgs/SteeringReport",
        "",
        &[("steering_tire_angle", "rad", Some(Role::Steering))],
    ),
    (
        "autoware_vehicle_msgs/VelocityReport",
        "",
        &[
            ("longitudinal_velocity", "m/s", Some(Role::Speed)),
            ("lateral_velocity", "m/s", None),
            ("heading_rate", "rad/s", Some(Role::YawRate)),
        ],
    ),
];

/// States unit and role of a message's field where its type defines them. Names decide elsewhere.
pub(in crate::recording) fn describe(kind: &str, channel: &mut Channel) {
    let kind = plain(kind).replace("autoware_auto_vehicle_msgs/", "autoware_vehicle_msgs/");
    for (_, path, fields) in TYPES.iter().filter(|(own, ..)| *own == kind) {
        channel.has_role_by_name = false;
        let field = channel.name.strip_prefix(path);
        if let Some((_, unit, role)) = fields.iter().find(|(name, ..)| Some(*name) == field) {
            channel.unit = Some((*unit).into());
            channel.role = *role;
        }
    }
}
