//! Definitions of messages whose log has none, as bags of ROS 2 Humble in SQLite: those that are stated, and those of
//! the usual messages of vehicles.

use super::schema::{FieldKind, Schema, plain};
use std::collections::BTreeMap;

/// Types by package and name, whose constants are left out; `;` stands between the lines.
const USUAL: &[(&str, &str)] = &[
    (
        "ackermann_msgs/AckermannDrive",
        "float32 steering_angle; float32 steering_angle_velocity; float32 speed; float32 acceleration; float32 jerk",
    ),
    (
        "ackermann_msgs/AckermannDriveStamped",
        "std_msgs/Header header; ackermann_msgs/AckermannDrive drive",
    ),
    (
        "autoware_auto_vehicle_msgs/SteeringReport",
        "builtin_interfaces/Time stamp; float32 steering_tire_angle",
    ),
    (
        "autoware_auto_vehicle_msgs/VelocityReport",
        "std_msgs/Header header; float32 longitudinal_velocity; float32 lateral_velocity; float32 heading_rate",
    ),
    (
        "autoware_control_msgs/Lateral",
        "builtin_interfaces/Time stamp; builtin_interfaces/Time control_time; float32 steering_tire_angle; float32 steering_tire_rotation_rate; bool is_defined_steering_tire_rotation_rate",
    ),
    (
        "autoware_vehicle_msgs/SteeringReport",
        "builtin_interfaces/Time stamp; float32 steering_tire_angle",
    ),
    (
        "autoware_vehicle_msgs/VelocityReport",
        "std_msgs/Header header; float32 longitudinal_velocity; float32 lateral_velocity; float32 heading_rate",
    ),
    ("builtin_interfaces/Time", "int32 sec; uint32 nanosec"),
    ("geometry_msgs/Accel", "geometry_msgs/Vector3 linear; geometry_msgs/Vector3 angular"),
    ("geometry_msgs/AccelStamped", "std_msgs/Header header; geometry_msgs/Accel accel"),
    ("geometry_msgs/AccelWithCovariance", "geometry_msgs/Accel accel; float64[36] covariance"),
    (
        "geometry_msgs/AccelWithCovarianceStamped",
        "std_msgs/Header header; geometry_msgs/AccelWithCovariance accel",
    ),
    ("geometry_msgs/Point", "float64 x; float64 y; float64 z"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position; geometry_msgs/Quaternion orientation"),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header; geometry_msgs/Pose pose"),
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose; float64[36] covariance"),
    (
        "geometry_msgs/PoseWithCovarianceStamped",
        "std_msgs/Header header; geometry_msgs/PoseWithCovariance pose",
    ),
    ("geometry_msgs/Quaternion", "float64 x; float64 y; float64 z; float64 w"),
    ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear; geometry_msgs/Vector3 angular"),
    ("geometry_msgs/TwistStamped", "std_msgs/Header header; geometry_msgs/Twist twist"),
    ("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist; float64[36] covariance"),
    (
        "geometry_msgs/TwistWithCovarianceStamped",
        "std_msgs/Header header; geometry_msgs/TwistWithCovariance twist",
    ),
    ("geometry_msgs/Vector3", "float64 x; float64 y; float64 z"),
    ("geometry_msgs/Vector3Stamped", "std_msgs/Header header; geometry_msgs/Vector3 vector"),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header; string child_frame_id; geometry_msgs/PoseWithCovariance pose; geometry_msgs/TwistWithCovariance twist",
    ),
    (
        "sensor_msgs/Imu",
        "std_msgs/Header header; geometry_msgs/Quaternion orientation; float64[9] orientation_covariance; geometry_msgs/Vector3 angular_velocity; float64[9] angular_velocity_covariance; geometry_msgs/Vector3 linear_acceleration; float64[9] linear_acceleration_covariance",
    ),
    (
        "sensor_msgs/NavSatFix",
        "std_msgs/Header header; sensor_msgs/NavSatStatus status; float64 latitude; float64 longitude; float64 altitude; float64[9] position_covariance; uint8 position_covariance_type",
    ),
    ("sensor_msgs/NavSatStatus", "int8 status; uint16 service"),
    ("std_msgs/Bool", "bool data"),
    ("std_msgs/Float32", "float32 data"),
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp; string frame_id"),
    ("std_msgs/Int32", "int32 data"),
];

/// Definitions by package and name of their types.
#[derive(Debug, Clone, Copy)]
pub(in crate::recording) struct Definitions<'a>(
    pub(in crate::recording) &'a BTreeMap<String, String>,
);

impl Definitions<'_> {
    /// The fields of a type with those of the types within it; `None` where it is not defined.
    pub(in crate::recording) fn schema(&self, kind: &str) -> Option<Result<Schema, String>> {
        let mut text = self.text(&plain(kind))?;
        let mut kinds = vec![plain(kind)];
        let mut at = 0;
        // The list grows as it is read.
        while let Some(own) = kinds.get(at).cloned() {
            at += 1;
            let schema = match Schema::parse(kind, &text) {
                Ok(schema) => schema,
                Err(why) => return Some(Err(why)),
            };
            for field in schema.fields(&own).unwrap_or_default() {
                let FieldKind::Message(inner) = &field.kind else { continue };
                if !kinds.contains(inner)
                    && let Some(own) = self.text(inner)
                {
                    kinds.push(inner.clone());
                    text += &format!("\n===\nMSG: {inner}\n{own}");
                }
            }
        }
        Some(Schema::parse(kind, &text))
    }

    /// The text of one type.
    fn text(&self, kind: &str) -> Option<String> {
        let usual = || USUAL.iter().find(|(own, _)| *own == kind);
        let stated = self.0.get(kind).cloned();
        stated.or_else(|| usual().map(|(_, text)| text.replace("; ", "\n")))
    }
}

#[cfg(test)]
mod tests {
    use super::super::cdr::Layout;
    use super::*;

    fn leaves(stated: &[(&str, &str)], kind: &str) -> Vec<String> {
        let stated = stated.iter().map(|(kind, text)| ((*kind).to_owned(), (*text).to_owned()));
        let stated = stated.collect();
        let schema = Definitions(&stated).schema(kind).unwrap().unwrap();
        let layout = Layout::from_schema(&schema).unwrap();
        layout.leaves.into_iter().map(|(path, _)| path).collect()
    }

    #[test]
    fn each_usual_type_has_all_types_within_it() {
        for (kind, _) in USUAL {
            assert!(!leaves(&[], kind).is_empty(), "{kind}");
        }
        let twist = leaves(&[], "geometry_msgs/msg/TwistStamped");
        assert_eq!(twist[..2], ["header.stamp", "twist.linear.x"]);
    }

    #[test]
    fn stated_types_come_before_the_usual_ones_and_refer_to_both() {
        let wheel = (
            "own_msgs/Wheel",
            "# one wheel\nstd_msgs/Header header\nfloat64 LIMIT=1.0\nAxle axle # its axle\n",
        );
        let axle = ("own_msgs/Axle", "float32[2] angles\n");
        let expected = ["header.stamp", "axle.angles[0]", "axle.angles[1]"];
        assert_eq!(leaves(&[wheel, axle], "own_msgs/msg/Wheel"), expected);
        let own = leaves(&[("std_msgs/Float64", "float64 value\n")], "std_msgs/msg/Float64");
        assert_eq!(own, ["value"]);
        let none = BTreeMap::new();
        assert!(Definitions(&none).schema("own_msgs/msg/Wheel").is_none());
    }
}
