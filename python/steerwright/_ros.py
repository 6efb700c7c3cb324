"""ROS 1 bags and ROS 2 bags in SQLite as MCAP, which the package reads itself."""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Iterable
from pathlib import Path as FilePath
from typing import Any, BinaryIO

_STEERING = "builtin_interfaces/Time stamp; float32 steering_tire_angle"
_VELOCITY = (
    "std_msgs/Header header; float32 longitudinal_velocity; float32 lateral_velocity; "
    "float32 heading_rate"
)
DEFINITIONS = {
    "ackermann_msgs/AckermannDrive": (
        "float32 steering_angle; float32 steering_angle_velocity; float32 speed; float32 acceleration; "
        "float32 jerk"
    ),
    "ackermann_msgs/AckermannDriveStamped": "std_msgs/Header header; ackermann_msgs/AckermannDrive drive",
    "autoware_auto_vehicle_msgs/SteeringReport": _STEERING,
    "autoware_auto_vehicle_msgs/VelocityReport": _VELOCITY,
    "autoware_vehicle_msgs/SteeringReport": _STEERING,
    "autoware_vehicle_msgs/VelocityReport": _VELOCITY,
    "builtin_interfaces/Time": "int32 sec; uint32 nanosec",
    "geometry_msgs/Point": "float64 x; float64 y; float64 z",
    "geometry_msgs/Pose": "geometry_msgs/Point position; geometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header; geometry_msgs/Pose pose",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose; float64[36] covariance",
    "geometry_msgs/PoseWithCovarianceStamped": (
        "std_msgs/Header header; geometry_msgs/PoseWithCovariance pose"
    ),
    "geometry_msgs/Quaternion": "float64 x; float64 y; float64 z; float64 w",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear; geometry_msgs/Vector3 angular",
    "geometry_msgs/TwistStamped": "std_msgs/Header header; geometry_msgs/Twist twist",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist; float64[36] covariance",
    "geometry_msgs/TwistWithCovarianceStamped": (
        "std_msgs/Header header; geometry_msgs/TwistWithCovariance twist"
    ),
    "geometry_msgs/Vector3": "float64 x; float64 y; float64 z",
    "nav_msgs/Odometry": (
        "std_msgs/Header header; string child_frame_id; geometry_msgs/PoseWithCovariance pose; "
        "geometry_msgs/TwistWithCovariance twist"
    ),
    "sensor_msgs/Imu": (
        "std_msgs/Header header; geometry_msgs/Quaternion orientation; "
        "float64[9] orientation_covariance; geometry_msgs/Vector3 angular_velocity; "
        "float64[9] angular_velocity_covariance; geometry_msgs/Vector3 linear_acceleration; "
        "float64[9] linear_acceleration_covariance"
    ),
    "sensor_msgs/NavSatFix": (
        "std_msgs/Header header; sensor_msgs/NavSatStatus status; float64 latitude; float64 longitude; "
        "float64 altitude; float64[9] position_covariance; uint8 position_covariance_type"
    ),
    "sensor_msgs/NavSatStatus": "int8 status; uint16 service",
    "std_msgs/Header": "builtin_interfaces/Time stamp; string frame_id",
}
"""Usual messages of vehicles, of which the constants are left out, for bags without definitions (ROS 2 Humble)."""


def definition(kind: str) -> str | None:
    """The definition of a type with those it refers to; `None` where it is not known."""
    kind = kind.replace("/msg/", "/")
    if kind not in DEFINITIONS:
        return _of_rosbags(kind)
    kinds = [kind]
    # The list grows as it is read.
    for one in kinds:
        for field in DEFINITIONS[one].split("; "):
            own = field.split()[0]
            if "/" in own and own not in kinds:
                kinds.append(own)
    texts = [DEFINITIONS[one].replace("; ", "\n") for one in kinds]
    parts = [f"MSG: {one}\n{text}" for one, text in zip(kinds[1:], texts[1:])]
    return f"\n{'=' * 80}\n".join([texts[0], *parts])


def _of_rosbags(kind: str) -> str | None:
    """A type of a ROS 2 distribution, where rosbags is installed."""
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        return None
    store = get_typestore(Stores.LATEST)
    name = kind.replace("/", "/msg/")
    return str(store.generate_msgdef(name, ros_version=2)[0]) if name in store.fielddefs else None


class Mcap:
    """Writes an MCAP file without chunks and summary."""

    MAGIC = b"\x89MCAP0\r\n"

    def __init__(self, file: BinaryIO) -> None:
        self.file = file
        file.write(self.MAGIC)
        self._record(0x01, _text("ros2") + _text(""))

    def _record(self, code: int, content: bytes) -> None:
        self.file.write(struct.pack("<BQ", code, len(content)) + content)

    def topic(self, number: int, name: str, kind: str, form: str, definition: tuple[str, str]) -> None:
        """Declares a topic; its definition has an encoding and a text."""
        encoding, text = definition
        schema = _text(kind) + _text(encoding) + _text(text)
        self._record(0x03, struct.pack("<H", number) + schema)
        self._record(0x04, struct.pack("<HH", number, number) + _text(name) + _text(form) + _text(""))

    def message(self, number: int, stamp_ns: int, data: bytes) -> None:
        self._record(0x05, struct.pack("<HIQQ", number, 0, stamp_ns, stamp_ns) + data)

    def end(self) -> None:
        self._record(0x0F, struct.pack("<I", 0))
        self._record(0x02, struct.pack("<QQI", 0, 0, 0))
        self.file.write(self.MAGIC)


def _text(text: str) -> bytes:
    encoded = text.encode()
    return struct.pack("<I", len(encoded)) + encoded


def of_sqlite(files: Iterable[FilePath], converted: FilePath) -> None:
    """Messages of SQLite files of one ROS 2 bag; topics without a definition are reported by the reader."""
    numbers: dict[str, int] = {}
    with open(converted, "wb") as opened:
        mcap = Mcap(opened)
        for file in files:
            # Read as it is: the folder may be read-only, and the recorder may have crashed.
            database = sqlite3.connect(f"{file.resolve().as_uri()}?immutable=1", uri=True)
            try:
                own: dict[int, int] = {}
                stated = _stated(database)
                query = "SELECT id, name, type, serialization_format FROM topics ORDER BY id"
                for topic, name, kind, form in database.execute(query):
                    if name not in numbers:
                        numbers[name] = len(numbers) + 1
                        known = stated.get(kind) or ("ros2msg", definition(kind) or "")
                        mcap.topic(numbers[name], name, kind, form, known)
                    own[topic] = numbers[name]
                for topic, stamp_ns, data in database.execute(
                    "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp"
                ):
                    mcap.message(own[topic], stamp_ns, data)
            finally:
                database.close()
        mcap.end()


def _stated(database: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Encoding and text of the definitions in the file, which bags have since ROS 2 Iron."""
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master")}
    if "message_definitions" not in tables:
        return {}
    query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
    return {kind: (encoding, text) for kind, encoding, text in database.execute(query) if text}


def of_bag(file: FilePath, converted: FilePath, highlevel: Any) -> None:
    """Messages of a ROS 1 bag, by rosbags."""
    with highlevel.AnyReader([file]) as reader, open(converted, "wb") as opened:
        store, mcap = _without_numbers(reader.typestore), Mcap(opened)
        numbers: dict[str, int] = {}
        for connection in reader.connections:
            if connection.topic not in numbers:
                numbers[connection.topic] = len(numbers) + 1
                text, _ = store.generate_msgdef(connection.msgtype, ros_version=2)
                number, kind = numbers[connection.topic], connection.msgtype
                mcap.topic(number, connection.topic, kind, "cdr", ("ros2msg", text))
        for connection, stamp_ns, raw in reader.messages():
            data = store.ros1_to_cdr(raw, connection.msgtype)
            mcap.message(numbers[connection.topic], stamp_ns, bytes(data))
        mcap.end()


def _without_numbers(store: Any) -> Any:
    """The types of a ROS 1 bag with the header of ROS 2, which has no number."""
    from rosbags.typesys import Stores, get_typestore

    types = dict(store.fielddefs)
    header = "std_msgs/msg/Header"
    if header in types:
        constants, fields = types[header]
        types[header] = (constants, [field for field in fields if field[0] != "seq"])
    own = get_typestore(Stores.EMPTY)
    own.register(types)
    return own
