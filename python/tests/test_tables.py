"""Logs in other libraries' objects and formats: the same samples as the file of the drive."""

from __future__ import annotations

import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steerwright
from conftest import COLUMNS, DATA, DRIVE

NAMES = ["time_s", "steering_command_rad", "yaw_rate_radps", "speed_mps"]


@pytest.fixture(scope="module")
def table() -> dict[str, Any]:
    rows = np.genfromtxt(DRIVE, delimiter=",", names=True, comments="#")
    return {name: np.ascontiguousarray(rows[name]) for name in NAMES}


def same(found: steerwright.Log, log: steerwright.Log, tolerance: float = 0.0) -> None:
    for name in ("time", "steering", "yaw_rate", "speed"):
        ours, theirs = getattr(found, name), getattr(log, name)
        assert ours.shape == theirs.shape
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=tolerance)


def test_data_frames_and_tables(table: dict[str, Any], log: steerwright.Log) -> None:
    import pandas
    import polars
    import pyarrow

    for one in (
        table,
        pandas.DataFrame(table),
        pandas.DataFrame(table).set_index("time_s"),
        polars.DataFrame(table),
        pyarrow.table(table),
    ):
        same(steerwright.read(one, **COLUMNS), log)


def test_missing_values_and_other_types(table: dict[str, Any], log: steerwright.Log) -> None:
    import pandas

    frame = pandas.DataFrame(table)
    frame["note"] = "text"
    frame["time_s"] = pandas.to_datetime(frame["time_s"] + 1.7e9, unit="s")
    frame.loc[50, "yaw_rate_radps"] = None
    frame["speed_mps"] = frame["speed_mps"].convert_dtypes()
    found = steerwright.read(frame, **COLUMNS)
    assert len(found) == len(log)
    np.testing.assert_allclose(found.time, log.time, atol=1e-6)
    assert np.isfinite(found.yaw_rate).all()


def test_times_of_pandas_of_any_form(table: dict[str, Any], log: steerwright.Log) -> None:
    import pandas

    frame = pandas.DataFrame(table)
    time = pandas.to_datetime(frame["time_s"] + 1.7e9, unit="s")
    base = frame.drop(columns="time_s")
    zoned = time.dt.tz_localize("UTC")
    forms = [
        base.assign(time=time),
        base.assign(timestamp=zoned),
        base.assign(timestamp=zoned.astype(object)),
        base.set_index(pandas.DatetimeIndex(time)),
        base.set_index(pandas.DatetimeIndex(time.to_numpy())),
        base.set_index(pandas.DatetimeIndex(time, name="time")),
        base.set_index(pandas.DatetimeIndex(zoned, name=None)),
        base.assign(time_ms=time),
        base.assign(stamp_ns=time),
        base.set_index(pandas.to_timedelta(frame["time_s"].to_numpy(), unit="s")),
    ]
    for form in forms:
        same(steerwright.read(form, **COLUMNS), log, 1e-5)
    found = steerwright.read(base.assign(time=time), unit={"time": "s"}, **COLUMNS)
    same(found, log, 1e-5)


def test_channels_on_several_clocks(table: dict[str, Any], log: steerwright.Log) -> None:
    steering = {name: table[name] for name in NAMES[:2]}
    rates = {"time_s": table["time_s"][1::2]}
    rates |= {name: table[name][1::2] for name in NAMES[2:]}
    found = steerwright.read([steering, rates], **COLUMNS)
    assert abs(len(found) - len(log)) < 5
    at = np.interp(found.time, log.time, log.yaw_rate)
    assert np.std(found.yaw_rate - at) < 0.1 * np.std(at)


def test_tdms(table: dict[str, Any], log: steerwright.Log, tmp_path: Path) -> None:
    from nptdms import ChannelObject, TdmsWriter

    step = 0.01
    uniform = {n: np.interp(np.arange(len(table[n])) * step, table["time_s"], table[n]) for n in NAMES[1:]}
    with TdmsWriter(tmp_path / "drive.tdms") as writer:
        writer.write_segment(
            [
                ChannelObject("Drive", n, v, {"wf_increment": step, "wf_start_offset": 2.0})
                for n, v in uniform.items()
            ]
        )
    found = steerwright.read(tmp_path / "drive.tdms", **COLUMNS)
    expected = steerwright.read(
        {"time_s": 2.0 + step * np.arange(len(uniform["speed_mps"])), **uniform}, **COLUMNS
    )
    same(found, expected)


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_mat(version: str, table: dict[str, Any], log: steerwright.Log, tmp_path: Path) -> None:
    file = tmp_path / "drive.mat"
    if version == "5":
        from scipy.io import savemat

        savemat(file, {"drive": table, "note": "text"})
    else:
        import h5py

        with h5py.File(file, "w", userblock_size=512) as opened:
            for name, values in table.items():
                opened[f"drive/{name}"] = values[None, :]
        head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
        with open(file, "r+b") as opened:
            opened.write(head)
    columns = {
        f"{key}_channel": f"drive.{name}" for key, name in zip(("time", "input", "output", "speed"), NAMES)
    }
    same(steerwright.read(file, **columns, steering_ratio=1.0), log)


@pytest.mark.parametrize("kind", ["bag", "db3"])
def test_bags(kind: str, table: dict[str, Any], tmp_path: Path) -> None:
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE)
    types = store.types
    time, twist = types["builtin_interfaces/msg/Time"], types["geometry_msgs/msg/TwistStamped"]
    header, vector = types["std_msgs/msg/Header"], types["geometry_msgs/msg/Vector3"]

    def message(k: int) -> Any:
        stamp = time(1_700_000_000 + k // 100, 10_000_000 * (k % 100))
        head = header(k, stamp, "base") if kind == "bag" else header(stamp, "base")
        linear = vector(table["speed_mps"][k], 0.0, table["steering_command_rad"][k])
        angular = vector(0.0, 0.0, table["yaw_rate_radps"][k])
        return twist(head, types["geometry_msgs/msg/Twist"](linear, angular))

    count = 3000
    if kind == "bag":
        file = tmp_path / "drive.bag"
        writer: Any = Writer1(file)
    else:
        folder = tmp_path / "drive"
        writer = Writer2(folder, version=8, storage_plugin=StoragePlugin.SQLITE3)
        file = folder / "drive.db3"
    with writer:
        connection = writer.add_connection("/vehicle", twist.__msgtype__, typestore=store)
        serialize = store.serialize_ros1 if kind == "bag" else store.serialize_cdr
        for k in range(count):
            raw = serialize(message(k), twist.__msgtype__)
            writer.write(connection, (1_700_000_000 + k) * 10**9, raw)
    found = steerwright.read(
        file,
        input_channel="twist.linear.z",
        output_channel="twist.angular.z",
        speed_channel="twist.linear.x",
        intersample="zoh",
        unit={"twist.linear.z": "rad", "twist.angular.z": "rad/s", "twist.linear.x": "m/s"},
        steering_ratio=1.0,
    )
    clock = 1_700_000_000 + 0.01 * np.arange(count)
    expected = steerwright.read(
        {"time_s": clock, **{name: table[name][:count] for name in NAMES[1:]}},
        **COLUMNS,
        intersample="zoh",
    )
    same(found, expected, 1e-5)


def test_blf(tmp_path: Path) -> None:
    import can

    dbc = DATA / "comma2k19/can/toyota_prius_2010_pt.dbc"
    options = {
        "dbc": dbc,
        "unit": {"YAW_RATE": "deg/s"},
        "input_channel": "STEER_ANGLE_SENSOR.STEER_ANGLE + STEER_ANGLE_SENSOR.STEER_FRACTION",
        "output_channel": "KINEMATICS.YAW_RATE",
        "speed_channel": "SPEED.SPEED",
        "steering_ratio": 15.3,
    }
    frames = DATA / "comma2k19/can/raw_can.log.gz"
    with can.LogReader(frames) as reader, can.BLFWriter(tmp_path / "drive.blf") as writer:
        for frame in reader:
            writer.on_message_received(frame)
    found = steerwright.read(tmp_path / "drive.blf", **options)
    expected = steerwright.read(frames, **options)
    # BLF has no times before 1970, to which this log belongs.
    np.testing.assert_allclose(found.time - found.time[0], expected.time - expected.time[0], atol=1e-5)
    for name in ("steering", "yaw_rate", "speed"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-4)


def test_rlog(table: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # openpilot is in no package index: its reader is represented by what its events are.
    class Event:
        def __init__(self, k: int, service: str, values: dict[str, Any]) -> None:
            self.logMonoTime, self.service = 10**9 + 10**7 * k, service
            setattr(self, service, type("Reader", (), {"to_dict": lambda _: values}))

        def which(self) -> str:
            return self.service

        def __getattribute__(self, name: str) -> Any:
            value = object.__getattribute__(self, name)
            return value() if isinstance(value, type) and value.__name__ == "Reader" else value

    def events(_: str) -> Any:
        for k in range(3000):
            yield Event(k, "can", {"data": b""})
            steering = np.rad2deg(table["steering_command_rad"][k])
            car = {"steeringAngleDeg": steering, "vEgo": table["speed_mps"][k], "gearShifter": "drive"}
            yield Event(k, "carState", car)
            rate = [0.0, 0.0, table["yaw_rate_radps"][k]]
            yield Event(k, "livePose", {"angularVelocityDevice": {"z": rate[2]}, "axes": rate})

    reader = types.ModuleType("openpilot.tools.lib.logreader")
    reader.LogReader = events  # type: ignore[attr-defined]
    for name in ("openpilot", "openpilot.tools", "openpilot.tools.lib"):
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    monkeypatch.setitem(sys.modules, reader.__name__, reader)
    (tmp_path / "rlog.zst").write_bytes(b"")
    found = steerwright.read(
        tmp_path / "rlog.zst",
        input_channel="steeringAngleDeg",
        output_channel="angularVelocityDevice.z",
        speed_channel="vEgo",
        unit={"angularVelocityDevice.z": "rad/s", "vEgo": "m/s"},
        steering_ratio=1.0,
        intersample="zoh",
    )
    expected = steerwright.read(
        {"time_s": 1.0 + 0.01 * np.arange(3000), **{name: table[name][:3000] for name in NAMES[1:]}},
        **COLUMNS,
        intersample="zoh",
    )
    same(found, expected, 1e-9)


def test_formats_without_their_library_and_without_signals(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "drive.tdms").write_bytes(b"TDSm" + bytes(200))
    monkeypatch.setitem(sys.modules, "nptdms", None)
    with pytest.raises(steerwright.Error, match="nptdms, which is not installed"):
        steerwright.read(tmp_path / "drive.tdms")
    with pytest.raises(TypeError, match="a file name, a dict of arrays or a data frame"):
        steerwright.read(3.0)
