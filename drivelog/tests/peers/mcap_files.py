"""Drives as MCAP files, and their samples as mcap-ros2-support and rosbags decode them."""

import dataclasses
import json
import math
import sys
from pathlib import Path

from common import Expected
from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType, Writer
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_typestore, get_types_from_msg
from rosbags.typesys.store import Typestore

NS = 1_000_000_000
EPOCH = 1_700_000_000
AUTOWARE = {
    "autoware_vehicle_msgs/msg/SteeringReport": "builtin_interfaces/Time stamp\nfloat32 steering_tire_angle\n",
    "autoware_vehicle_msgs/msg/VelocityReport": "std_msgs/Header header\nfloat32 longitudinal_velocity\n"
    "float32 lateral_velocity\nfloat32 heading_rate\n",
    "ackermann_msgs/msg/AckermannDrive": "float32 steering_angle\nfloat32 steering_angle_velocity\nfloat32 speed\n"
    "float32 acceleration\nfloat32 jerk\n",
    "ackermann_msgs/msg/AckermannDriveStamped": "std_msgs/Header header\nackermann_msgs/AckermannDrive drive\n",
    # Everything that moves what follows it.
    "test_msgs/msg/Inner": "bool on\nint64 n\nstring text\nfloat32[3] few\n",
    "test_msgs/msg/All": "uint8 a\nuint64 b\nint8 c\nint16 d\nuint16 e\nint32 f\nuint32 g\nfloat32 h\nchar i\nbyte j\n"
    "string text\nfloat64 k\nstring<=8 short\nuint8[] bytes\nint16 l\nfloat64[] doubles\nbool m\nstring[] texts\n"
    "int64 n\ntest_msgs/Inner[2] both\ntest_msgs/Inner[] many\nfloat64[36] matrix\nfloat64[37] long\nuint8[5] five\n"
    "builtin_interfaces/Duration age\nstring[2] pair\nfloat64[<=3] bounded\nuint16 last\n",
}


def typestore() -> Typestore:
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in AUTOWARE.items():
        store.register(get_types_from_msg(text, name))
    return store


STORE = typestore()
DECODERS = DecoderFactory()


def make(name: str, **fields):
    return STORE.types[name](**fields)


def header(ns: int):
    stamp = make("builtin_interfaces/msg/Time", sec=ns // NS, nanosec=ns % NS)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id="base_link"[: 1 + ns // 1000 % 9])


def vector(x: float, y: float, z: float):
    return make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)


def twist(v: float, r: float):
    return make("geometry_msgs/msg/Twist", linear=vector(v, 0.1 * r, 0.0), angular=vector(0.0, 0.0, r))


def pose(x: float, y: float):
    point = make("geometry_msgs/msg/Point", x=x, y=y, z=0.5)
    return make("geometry_msgs/msg/Pose", position=point, orientation=make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0))


def messages(count: int):
    """Topic, type, log time in ns and message of a drive."""
    import numpy as np

    covariance = np.arange(36, dtype=np.float64) / 7
    for k in range(count):
        t = 0.01 * k
        ns = EPOCH * NS + k * 10_000_000
        steer, rate, speed = 0.05 * math.sin(t), 0.2 * math.sin(t - 0.3), 15 + math.cos(t)
        stamp = header(ns).stamp
        late = ns + 3_000_000 + (k * 7919 % 4_000_000)
        with_covariance = make("geometry_msgs/msg/PoseWithCovariance", pose=pose(speed * t, rate), covariance=covariance)
        twisted = make("geometry_msgs/msg/TwistWithCovariance", twist=twist(speed, rate), covariance=covariance)
        nine = covariance[:9]
        yield "/vehicle/steering", "autoware_vehicle_msgs/msg/SteeringReport", late, dict(stamp=stamp, steering_tire_angle=steer)
        yield "/vehicle/velocity", "autoware_vehicle_msgs/msg/VelocityReport", late, dict(
            header=header(ns), longitudinal_velocity=speed, lateral_velocity=0.01 * rate, heading_rate=rate)
        yield "/imu/data", "sensor_msgs/msg/Imu", late, dict(
            header=header(ns), orientation=make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
            orientation_covariance=nine, angular_velocity=vector(1e-3, -1e-3, rate), angular_velocity_covariance=nine,
            linear_acceleration=vector(0.1, speed * rate, 9.81), linear_acceleration_covariance=nine)
        drive = make("ackermann_msgs/msg/AckermannDrive", steering_angle=steer, steering_angle_velocity=0.0, speed=speed, acceleration=0.0, jerk=math.nan)
        yield "/ackermann_cmd", "ackermann_msgs/msg/AckermannDriveStamped", late, dict(header=header(ns), drive=drive)
        yield "/drive", "ackermann_msgs/msg/AckermannDrive", late, dict(
            steering_angle=steer, steering_angle_velocity=0.0, speed=speed, acceleration=0.0, jerk=0.0)
        if k % 10 == 0:
            yield "/odom", "nav_msgs/msg/Odometry", late, dict(
                header=header(ns), child_frame_id="car", pose=with_covariance, twist=twisted)
            yield "/twist", "geometry_msgs/msg/TwistStamped", late, dict(header=header(ns), twist=twist(speed, rate))
            yield "/twist_cov", "geometry_msgs/msg/TwistWithCovarianceStamped", late, dict(header=header(ns), twist=twisted)
            yield "/pose", "geometry_msgs/msg/PoseStamped", late, dict(header=header(ns), pose=pose(t, -t))
            yield "/pose_cov", "geometry_msgs/msg/PoseWithCovarianceStamped", late, dict(header=header(ns), pose=with_covariance)
            status = make("sensor_msgs/msg/NavSatStatus", status=-1, service=1)
            yield "/fix", "sensor_msgs/msg/NavSatFix", late, dict(
                header=header(ns), status=status, latitude=52.0 + 1e-6 * k, longitude=13.0, altitude=math.pi,
                position_covariance=nine, position_covariance_type=2)
            inner = [make("test_msgs/msg/Inner", on=bool(i % 2), n=-(k << 40) - i, text="x" * (k % 5 + i), few=np.arange(3, dtype=np.float32) + t)
                     for i in range(3)]
            yield "/all", "test_msgs/msg/All", late, dict(
                a=200, b=2**64 - 1 - k, c=-5, d=-300, e=65535, f=-(2**31), g=2**32 - 1, h=0.1, i=25, j=7, text="é" * (k % 7), k=t,
                short="ab", bytes=np.zeros(k % 6, np.uint8), l=-2, doubles=np.arange(k % 4, dtype=np.float64), m=bool(k % 20),
                texts=["a", "bcd"][: k % 3], n=-(2**62) - k, both=inner[:2], many=inner[: k // 10 % 4], matrix=covariance,
                long=np.arange(37, dtype=np.float64), five=np.arange(5, dtype=np.uint8),
                age=make("builtin_interfaces/msg/Duration", sec=-1, nanosec=250_000_000), pair=["", "pair"],
                bounded=np.arange(k % 4, dtype=np.float64), last=k)


def write(path: Path, count: int, big_endian: bool = False, **options) -> None:
    with open(path, "wb") as file:
        writer = Writer(file, **options)
        writer.start(profile="ros2", library="peers")
        channels = {}
        for number, (topic, kind, log_time, fields) in enumerate(messages(count)):
            if topic not in channels:
                text = STORE.generate_msgdef(kind, ros_version=2)[0]
                schema = writer.register_schema(name=kind, encoding="ros2msg", data=text.encode())
                channels[topic] = writer.register_channel(topic=topic, message_encoding="cdr", schema_id=schema)
            data = bytes(STORE.serialize_cdr(make(kind, **fields), kind, little_endian=not big_endian))
            writer.add_message(channels[topic], log_time=log_time, publish_time=log_time - 1000, data=data, sequence=number)
            if topic == "/imu/data" and number < 2000:
                schema = channels.setdefault("schema of json", 0) or writer.register_schema(name="State", encoding="jsonschema", data=b"{}")
                channels["schema of json"] = schema
                channel = channels.setdefault("/json", 0) or writer.register_channel(topic="/json", message_encoding="json", schema_id=schema)
                channels["/json"] = channel
                state = {"speed": 0.1 * number, "on": number % 2 == 0, "name": "x", "inner": {"n": number, "missing": None}}
                if number % 3 == 0:
                    del state["speed"]
                if number == 2:
                    state["speed"] = 1
                writer.add_message(channel, log_time=log_time, publish_time=log_time, data=json.dumps(state).encode())
        writer.finish()


def leaves(value, path: str, out: dict) -> None:
    """The numbers of a message by path, as the reader under test names them."""
    if isinstance(value, (bool, int, float)):
        out[path] = float(value)
    elif hasattr(value, "sec") and hasattr(value, "nanosec"):
        out[path] = (value.sec * NS + value.nanosec) / 1e9
    elif isinstance(value, str) or value is None:
        pass
    elif isinstance(value, dict):
        for key, item in value.items():
            leaves(item, f"{path}.{key}" if path else key, out)
    elif dataclasses.is_dataclass(value):
        for key in (field.name for field in dataclasses.fields(value)):
            # Constants are upper case.
            if not key.isupper():
                leaves(getattr(value, key), f"{path}.{key}" if path else key, out)
    elif hasattr(value, "__slots__") and not isinstance(value, (bytes, list, tuple)):
        for key in value.__slots__:
            leaves(getattr(value, key), f"{path}.{key.lstrip('_')}" if path else key.lstrip("_"), out)
    else:
        for i, item in enumerate(value):
            leaves(item.item() if hasattr(item, "item") else item, f"{path}[{i}]", out)


# Sequences, and arrays that are too long to be channels.
NOT_LISTED = ("bytes[", "doubles[", "many[", "long[", "bounded[")


def dump(path: Path, expected: Expected) -> None:
    topics = {}
    with open(path, "rb") as file:
        reader = make_reader(file)
        for schema, channel, message in reader.iter_messages():
            row = {"log_time": message.log_time / 1e9, "publish_time": message.publish_time / 1e9}
            if channel.message_encoding == "json":
                leaves(json.loads(message.data), "", row)
            else:
                ours = {}
                leaves(STORE.deserialize_cdr(message.data, schema.name), "", ours)
                # mcap-ros2-support reads little-endian messages only.
                if message.data[1] == 1:
                    decoded = {}
                    leaves(DECODERS.decoder_for("cdr", schema)(message.data), "", decoded)
                    # It lists constants, too.
                    other = {k: decoded[k].hex() for k in ours}
                    differ = [k for k, x in ours.items() if x.hex() != other[k]]
                    assert not differ, f"the peers differ: {channel.topic} {differ}"
                row |= ours
            topics.setdefault(channel.topic, []).append(row)
    for topic, rows in topics.items():
        columns = {key: [] for row in rows for key in row if not key.startswith(NOT_LISTED)}
        clock = next(key for key in ("header.stamp", "stamp", "log_time") if key in columns)
        rows.sort(key=lambda row: row[clock])
        for key, column in columns.items():
            column.extend(row.get(key, math.nan) for row in rows)
        # Of JSON the fields of the first message are channels.
        for key in columns:
            if key in rows[0] or topic != "/json":
                expected.add(path.name, f"{topic}.{key}", columns[clock], columns[key])


NO_SUMMARY = dict(
    use_statistics=False, use_summary_offsets=False, repeat_channels=False, repeat_schemas=False,
    index_types=IndexType.NONE)
WAYS = {
    "none": dict(compression=CompressionType.NONE, chunk_size=20_000),
    "lz4": dict(compression=CompressionType.LZ4, chunk_size=20_000),
    "zstd": dict(compression=CompressionType.ZSTD, chunk_size=20_000),
    "unchunked": dict(use_chunking=False),
    "no_summary": dict(compression=CompressionType.ZSTD, chunk_size=20_000, **NO_SUMMARY),
    "unchunked_no_summary": dict(use_chunking=False, **NO_SUMMARY),
    "no_index": dict(compression=CompressionType.LZ4, chunk_size=20_000, index_types=IndexType.NONE),
}


def main() -> None:
    folder = Path(sys.argv[1])
    expected = Expected(folder)
    for name, options in WAYS.items():
        path = folder / f"{name}.mcap"
        write(path, 400, **options)
        dump(path, expected)
    path = folder / "big_endian.mcap"
    write(path, 100, big_endian=True, compression=CompressionType.ZSTD)
    dump(path, expected)
    expected.write()


if __name__ == "__main__":
    main()
