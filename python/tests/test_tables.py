"""Logs in other libraries' objects and formats: the same samples as the file of the drive."""

from __future__ import annotations

import sqlite3
import struct
import sys
import types
import warnings
from datetime import date, datetime, timedelta
from datetime import time as dtime
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steerwright
from steerwright import _ros
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


def test_a_log_is_a_data_frame_again(table: dict[str, Any], log: steerwright.Log) -> None:
    frame = log.to_pandas()
    assert list(frame.columns) == ["steering_angle_rad", "yaw_rate_radps", "speed_mps"]
    np.testing.assert_array_equal(frame["yaw_rate_radps"], log.yaw_rate)
    np.testing.assert_array_equal(frame.index, log.time)
    found = steerwright.read(frame, steering_ratio=1.0, intersample="zoh", sample_time=log.sample_time)
    assert abs(len(found) - len(log)) <= 1


def test_missing_values_and_other_types(table: dict[str, Any], log: steerwright.Log) -> None:
    import pandas

    frame = pandas.DataFrame(table)
    frame["note"] = "text"
    frame["time_s"] = pandas.to_datetime(frame["time_s"] + 1.7e9, unit="s")
    frame.loc[50, "yaw_rate_radps"] = None
    frame["speed_mps"] = frame["speed_mps"].convert_dtypes()
    frame["gear"] = pandas.array([None, *range(len(frame) - 1)], dtype="Int64")
    frame["is_engaged"] = pandas.array([None, *[True] * (len(frame) - 1)], dtype="boolean")
    frame["state"] = pandas.Series(["on"] * len(frame), dtype="category")
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


def test_times_are_clocks_whatever_their_column_and_type(table: dict[str, Any], log: steerwright.Log) -> None:
    import pandas
    import polars
    import pyarrow

    frame = pandas.DataFrame(table)
    time = pandas.to_datetime(frame["time_s"] + 1.7e9, unit="s").dt.round("us").astype("datetime64[us]")
    zoned = time.dt.tz_localize("UTC").dt.tz_convert("Europe/Berlin")
    base = frame.drop(columns="time_s")
    text = time.dt.strftime("%Y-%m-%dT%H:%M:%S.%f")
    lazy = polars.from_pandas(base.assign(moment=time)).lazy()
    arrow = pyarrow.Table.from_pandas(base, preserve_index=False)
    numbers = pandas.Index(np.arange(len(base)), name="row")
    # Times of day that go on after midnight.
    late = time + pandas.Timedelta(seconds=6380)
    assert late[0].date() != late.iloc[-1].date()
    levels = frame.set_axis(pandas.MultiIndex.from_product([["car"], frame.columns]), axis=1)
    forms = [
        base.assign(time=late.dt.strftime("%H:%M:%S.%f")),
        base.assign(time=late.dt.time),
        base.set_index(pandas.PeriodIndex(time, freq="ms")),
        base.assign(recorded=time.dt.to_period("ms")),
        levels,
        base.assign(recorded=time),
        base.assign(recorded=zoned),
        base.set_index(pandas.DatetimeIndex(zoned, name="recorded")),
        base.set_index([numbers, pandas.DatetimeIndex(time, name="recorded")]),
        frame.assign(time_to_go_s=0.0).drop(columns="time_s").set_index(pandas.DatetimeIndex(time)),
        base.assign(time=text),
        base.assign(recorded=text + "Z"),
        base.assign(time=zoned.map(lambda moment: moment.isoformat())),
        base.set_index(pandas.Index(text.str.replace("T", " ").str.replace(".", ",", regex=False))),
        base.set_index(pandas.Index(time.dt.strftime("%Y%m%dT%H%M%S.%f"), name="recorded")),
        {**base, "recorded": list(text)},
        {**base, "recorded": list(zoned)},
        {**base, "recorded": [moment - time[0] for moment in time]},
        lazy,
        lazy.with_columns(moment=polars.col("moment").dt.replace_time_zone("Asia/Tokyo")),
        arrow.append_column("recorded", pyarrow.array(time)),
        arrow.append_column("recorded", pyarrow.array(zoned)),
        arrow.append_column("recorded", pyarrow.array(text)),
        pyarrow.record_batch(arrow.append_column("recorded", pyarrow.array(time)).to_pydict()),
    ]
    # A stream is read once.
    stream = arrow.append_column("recorded", pyarrow.array(zoned)).to_reader()
    same(steerwright.read(stream, **COLUMNS), log, 1e-5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for number, form in enumerate(forms):
            found = steerwright.read(form, **COLUMNS)
            for name in ("steering", "yaw_rate", "speed"):
                np.testing.assert_allclose(getattr(found, name), getattr(log, name), atol=1e-5, err_msg=str(number))
            np.testing.assert_allclose(found.time, log.time, atol=1e-5, err_msg=str(number))
            (group,) = steerwright.inspect(form)["groups"]
            assert group["clock"].startswith("time")
    two = base.assign(recorded=time, created=time[0])
    same(steerwright.read(two, time_channel="recorded", **COLUMNS), log, 1e-5)
    one = base.assign(recorded=time)
    assert steerwright.inspect(one, time_channel="recorded")["groups"][0]["clock"] == "recorded [s]"
    assert steerwright.read(one, row_period=0.01, **COLUMNS).time[0] < 1.0
    with pytest.raises(steerwright.Error, match="no column is the time") as caught:
        steerwright.read(two, **COLUMNS)
    assert "time_channel=NAME" in caught.value.hint


def test_what_is_no_number_is_reported(table: dict[str, Any], log: steerwright.Log) -> None:
    import pandas

    frame = pandas.DataFrame(table).assign(note="dry road", empty=None)
    frame["speed_mps"] = [f"{value:.17g}" for value in table["speed_mps"]]
    frame.loc[[70, 71, 72], "speed_mps"] = ["#N/A", "-", "over 60"]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = steerwright.read(frame, **COLUMNS)
    np.testing.assert_allclose(found.speed, log.speed, atol=0.05)
    texts = [str(warning.message) for warning in caught]
    assert any("speed_mps: 1 of 10300 cells are no numbers, such as 'over 60' in row 72" in text for text in texts)
    assert any("not read: note (10300 of 10300 cells are no numbers, such as 'dry road' in row 0)" in t for t in texts)
    assert any("empty (no values)" in text for text in texts)
    with pytest.warns(steerwright.Warning):
        losses = steerwright.inspect(frame)["losses"]
    assert losses[-1] == "table: not read: empty (no values)" and "table: not read: note (10300" in losses[-2]
    with pytest.raises(steerwright.Error, match="no column of numbers; not read: note .*dry road"):
        steerwright.read(frame[["note"]])
    assert all(warning.filename == __file__ for warning in caught)
    time = pandas.to_datetime(frame["time_s"], unit="s").dt.strftime("%Y-%m-%dT%H:%M:%S.%f").tolist()
    time[3] = "later"
    unread = "the clock is not read: .*time .1 of 10300 cells are no times, such as 'later' in row 3"
    with pytest.raises(steerwright.Error, match=unread) as refused:
        steerwright.read({**table, "time": time, "time_s": time}, **COLUMNS)
    assert "pandas.to_datetime" in refused.value.hint
    with pytest.raises(steerwright.Error, match="a series is one column"):
        steerwright.read(frame["speed_mps"], **COLUMNS)


def test_columns_of_other_lengths_and_objects_are_named(table: dict[str, Any], fmus: dict[str, Path]) -> None:
    short = {**table, "speed_mps": table["speed_mps"][:-1]}
    for function in (steerwright.read, steerwright.inspect, lambda it: steerwright.simulate(fmus["LateralPid"], input=it)):
        with pytest.raises(steerwright.Error, match="`speed_mps` has 10299 values, `time_s` has 10300"):
            function(short)
    points = [np.zeros(3) for _ in table["time_s"]]
    with pytest.warns(steerwright.Warning, match=r"points \(10300 × 3 values of type float64\), state \(.* no numbers"):
        steerwright.inspect({**table, "points": points, "state": [{}] * len(points)})


@pytest.mark.filterwarnings("ignore::steerwright.Warning")
def test_columns_of_any_kind_are_read_or_errors_with_a_hint(table: dict[str, Any]) -> None:
    import pandas
    import polars
    import pyarrow

    n = 200
    short = {name: values[:n] for name, values in table.items()}
    moments = np.datetime64("2024-01-01", "s") + np.arange(n)
    odd: list[Any] = [
        *(np.arange(n).astype(kind) for kind in ("f2", "u8", "i1", "?", "c8", "M8[D]", "m8[ms]", "S3", "U3")),
        *([one] * n for one in (None, 10**400, Decimal("1.5"), 1j, "2024-13-45T99:00", [1, 2], {}, object(), float("nan"))),
        *([one] * n for one in (date(2024, 1, 1), dtime(1, 2), timedelta(seconds=1), datetime(9999, 1, 1), b"\xff", pandas.NA)),
        *(np.zeros(shape) for shape in ((n, 3), (n, 1), (0,), ())),
        *(3.0, "text", None, {1, 2}, list(moments), moments.astype("M8[us]").tolist()),
        *(pandas.Series(moments).dt.tz_localize("Asia/Kolkata"), pandas.period_range("2024", periods=n, freq="s")),
        *(pandas.array([None, *range(n - 1)], dtype="Int64"), pandas.Categorical(["a"] * n)),
        *(polars.Series(moments.astype("M8[us]")), pyarrow.array(moments), np.ma.masked_greater(np.arange(n), 5)),
    ]
    for number, column in enumerate(odd):
        for name in ("time_s", "recorded", "yaw_rate_radps", "note"):
            for function in (steerwright.read, steerwright.Accumulator(**COLUMNS).add):
                options = {} if function.__name__ == "add" else COLUMNS
                try:
                    function({**short, name: column}, **options)
                except steerwright.Error as error:
                    assert error.hint, (number, name)


@pytest.mark.parametrize("as_objects", [False, True])
def test_a_yaw_rate_of_true_and_false_is_refused(as_objects: bool, table: dict[str, Any]) -> None:
    turning = np.array(table["yaw_rate_radps"] > 0.0, dtype=object if as_objects else bool)
    wrong = {**table, "yaw_rate_radps": turning}
    for function in (steerwright.read, steerwright.identify, steerwright.Accumulator(**COLUMNS).add):
        options = {} if function.__name__ == "add" else COLUMNS
        with pytest.raises(steerwright.Error, match="yaw_rate_radps: the yaw rate is True or False") as caught:
            function(wrong, **options)
        assert caught.value.hint
    steerwright.read({**table, "is_engaged": turning}, **COLUMNS)


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


def test_time_stamps_of_tdms(table: dict[str, Any], log: steerwright.Log, tmp_path: Path) -> None:
    from nptdms import ChannelObject, TdmsWriter

    stamps = np.datetime64("2024-02-29T09:00:00", "us") + np.round(1e6 * table["time_s"]).astype("timedelta64[us]")
    channels = {name.rpartition("_")[0]: table[name] for name in NAMES[1:]}
    units = ["rad", "rad/s", "m/s"]
    with TdmsWriter(tmp_path / "drive.tdms") as writer:
        columns = [
            ChannelObject("Drive", name, values, {"NI_UnitDescription": unit})
            for (name, values), unit in zip(channels.items(), units)
        ]
        note = ChannelObject("Drive", "Note", ["dry"] * len(stamps), {})
        writer.write_segment([ChannelObject("Drive", "Recorded", stamps, {}), *columns, note])
    options = {"input_channel": "steering_command", "steering_ratio": 1.0, "time_channel": "Recorded"}
    with pytest.warns(steerwright.Warning, match="not read: Note") as caught:
        same(steerwright.read(tmp_path / "drive.tdms", **options), log, 1e-5)
    assert caught[0].filename == __file__


def test_a_cut_tdms_is_read_as_far_as_it_goes(
    table: dict[str, Any], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    from nptdms import ChannelObject, TdmsWriter

    file = tmp_path / "drive.tdms"
    with TdmsWriter(file) as writer:
        for rows in (slice(0, 5000), slice(5000, None)):
            writer.write_segment([ChannelObject("Drive", name, values[rows], {}) for name, values in table.items()])
    file.write_bytes(file.read_bytes()[:-20_000])
    with pytest.warns(steerwright.Warning, match="drive.tdms: .*less data than expected") as caught:
        groups = steerwright.inspect(file)["groups"]
    assert caught[0].filename == __file__
    assert 5000 <= min(group["rows"] for group in groups) < len(table["time_s"])
    assert "nptdms" not in capfd.readouterr().err


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
        unit={"twist.linear.z": "rad"},
        steering_ratio=1.0,
    )
    clock = 1_700_000_000 + 0.01 * np.arange(count)
    expected = steerwright.read(
        {"time_s": clock, **{name: table[name][:count] for name in NAMES[1:]}},
        **COLUMNS,
        intersample="zoh",
    )
    same(found, expected, 1e-5)


def test_bags_without_definitions(table: dict[str, Any], tmp_path: Path) -> None:
    # As ROS 2 Humble writes them.
    count = 1000
    file = tmp_path / "drive.db3"
    with sqlite3.connect(file) as database:
        database.execute("CREATE TABLE topics (id, name, type, serialization_format, offered_qos_profiles)")
        database.execute("CREATE TABLE messages (id, topic_id, timestamp, data)")
        kinds = ["autoware_vehicle_msgs/msg/SteeringReport", "autoware_vehicle_msgs/msg/VelocityReport"]
        for index, kind in enumerate([*kinds, "maker_msgs/msg/Wheel"]):
            database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (index, f"/{index}", kind))
        for k in range(count):
            steering, yaw_rate, speed = (float(table[name][k]) for name in NAMES[1:])
            stamp = struct.pack("<4BII", 0, 1, 0, 0, k // 100, 10_000_000 * (k % 100))
            header = stamp + struct.pack("<I4s", 2, b"b")
            report = header + struct.pack("<3f", speed, 0.0, yaw_rate)
            for topic, data in enumerate((stamp + struct.pack("<f", steering), report, stamp)):
                database.execute("INSERT INTO messages VALUES (?, ?, ?, ?)", (k, topic, 10**7 * k, data))
    database.close()
    for source in (file, tmp_path):
        with pytest.warns(steerwright.Warning, match="/2: no definition of maker_msgs/msg/Wheel"):
            found = steerwright.inspect(source)
        assert [group["rows"] for group in found["groups"]] == [count, count, count]
    # Neither names nor units are stated.
    read = steerwright.read(file, steering_ratio=1.0)
    speed = np.interp(read.time, 0.01 * np.arange(count), table["speed_mps"][:count])
    np.testing.assert_allclose(read.speed, speed, atol=0.1)


@pytest.mark.parametrize("kind", ["structure of ControlDesk", "t and y", "structure with time", "matrix"])
def test_structures_of_mat(kind: str, table: dict[str, Any], tmp_path: Path) -> None:
    from scipy.io import savemat

    time, steering, yaw_rate, speed = (table[name] for name in NAMES)
    named = {"steering_rad": steering, "yaw_rate_radps": yaw_rate, "speed_mps": speed}
    matrix = np.column_stack([steering, yaw_rate, speed])
    signals = [
        {"Name": name.rpartition("_")[0], "Data": values, "Unit": unit, "XIndex": 1}
        for (name, values), unit in zip(named.items(), ("rad", "rad/s", "m/s"))
    ]
    names = ["steering", "yaw_rate", "speed"]
    variables, expected = {
        "structure of ControlDesk": (
            {"exp": {"X": {"Name": "Time", "Data": time, "Unit": "s"}, "Y": signals}},
            ["steering [rad]", "yaw_rate [rad/s]", "speed [m/s]"],
        ),
        "t and y": ({name: {"t": time, "y": values} for name, values in named.items()}, list(named)),
        "structure with time": (
            {"log": {"time": time, "signals": [{"label": n, "values": v} for n, v in zip(names, matrix.T)]}},
            names,
        ),
        "matrix": ({"time_s": time, "log": matrix, "note": "text"}, ["log_1", "log_2", "log_3"]),
    }[kind]
    savemat(tmp_path / "drive.mat", variables)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        (group,) = steerwright.inspect(tmp_path / "drive.mat")["groups"]
    assert [channel["name"] for channel in group["channels"]] == ["time_s", *expected]
    assert group["clock"] == "time_s"
    for channel, values in zip(group["channels"][1:], matrix.T):
        assert (channel["values"], channel["min"], channel["max"]) == (len(time), min(values), max(values))
    assert any("note (text)" in str(warning.message) for warning in caught) == (kind == "matrix")
    losses = steerwright.inspect(tmp_path / "drive.mat")["losses"]
    assert any("drive.mat: not read: note (text)" in loss for loss in losses) == (kind == "matrix")


def test_a_cut_file_is_an_error_of_the_package(table: dict[str, Any], tmp_path: Path) -> None:
    from scipy.io import savemat

    file = tmp_path / "cut.mat"
    savemat(file, table)
    file.write_bytes(file.read_bytes()[:20_000])
    for function in (steerwright.read, steerwright.inspect):
        with pytest.raises(steerwright.Error, match=r"cut\.mat: the file is cut, damaged or of another kind"):
            function(file)


def test_inspect_takes_tables_and_one_at_a_time(table: dict[str, Any]) -> None:
    import pandas

    for one in (table, pandas.DataFrame(table)):
        found = steerwright.inspect(one)
        assert found["file"] == "table"
        assert [channel["name"] for channel in found["groups"][0]["channels"]] == NAMES
        assert found["groups"][0]["rows"] == len(table["time_s"])
    found = steerwright.inspect([table, {"time_s": table["time_s"][::2], "x_m": table["time_s"][::2]}])
    assert [group["name"] for group in found["groups"]] == ["table 1", "table 2"]
    with pytest.raises(steerwright.Error, match="more than one log"):
        steerwright.inspect([DRIVE, DRIVE])


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
    with pytest.warns(steerwright.Warning) as caught:
        found = steerwright.read(tmp_path / "drive.blf", **options)
    assert all(str(tmp_path / "drive.blf") in str(warning.message) for warning in caught)
    expected = steerwright.read(frames, **options)
    # BLF has no times before 1970, to which this log belongs.
    np.testing.assert_allclose(found.time - found.time[0], expected.time - expected.time[0], atol=1e-5)
    for name in ("steering", "yaw_rate", "speed"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-4)
    groups = [steerwright.inspect(file, dbc=dbc)["groups"] for file in (tmp_path / "drive.blf", frames)]
    assert [group["name"] for group in groups[0]] == [group["name"] for group in groups[1]]
    assert [group["rows"] for group in groups[0]] == [group["rows"] for group in groups[1]]


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
    with pytest.raises(steerwright.Error, match="nptdms, which is not installed") as caught:
        steerwright.read(tmp_path / "drive.tdms")
    assert "./python[logs]" in caught.value.hint
    with pytest.raises(TypeError, match="a file name, a dict of arrays or a data frame"):
        steerwright.read(3.0)


def test_bags_of_a_recorder_that_crashed(table: dict[str, Any], tmp_path: Path) -> None:
    count = 2000
    file = tmp_path / "drive.db3"
    with sqlite3.connect(file) as database:
        database.execute("CREATE TABLE topics (id, name, type, serialization_format, offered_qos_profiles)")
        database.execute("CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id, timestamp, data)")
        kind = "autoware_vehicle_msgs/msg/SteeringReport"
        database.execute("INSERT INTO topics VALUES (0, '/steering', ?, 'cdr', '')", (kind,))
        for k in range(count):
            stamp = struct.pack("<4BII", 0, 1, 0, 0, k // 100, 10_000_000 * (k % 100))
            data = stamp + struct.pack("<f", float(table[NAMES[1]][k]))
            database.execute("INSERT INTO messages VALUES (?, 0, ?, ?)", (k + 1, 10**7 * k, data))
    database.close()
    whole = file.read_bytes()

    def rows(name: str, data: bytes) -> int:
        damaged = tmp_path / name
        damaged.write_bytes(data)
        with pytest.warns(steerwright.Warning, match="the database is cut or damaged behind message"):
            return int(steerwright.inspect(damaged)["groups"][0]["rows"])

    assert 700 < rows("cut.db3", whole[: len(whole) // 2]) < 1000
    # SQLite would read zeros behind the end of a file that is cut within a page.
    within, scratch = tmp_path / "within.db3", tmp_path / "scratch"
    within.write_bytes(whole[:-5000])
    scratch.mkdir()
    _ros.of_sqlite([within], scratch / "within.mcap")
    assert (scratch / "within.db3").read_bytes() == whole[:-8192]
    # A page in the middle was not written.
    hole = bytearray(whole)
    middle = len(whole) // 2 // 4096 * 4096
    hole[middle : middle + 4096] = bytes(4096)
    assert 1700 < rows("hole.db3", bytes(hole)) < count
    # What was written last is in a file beside the database.
    folder = tmp_path / "written"
    folder.mkdir()
    with sqlite3.connect(folder / "drive.db3") as database:
        database.execute("PRAGMA journal_mode=WAL")
        database.execute("ATTACH ? AS source", (str(file),))
        for name in ("topics", "messages"):
            database.execute(f"CREATE TABLE {name} AS SELECT * FROM source.{name}")
        database.commit()
        killed = tmp_path / "killed"
        killed.mkdir()
        for written in folder.iterdir():
            if not written.name.endswith("-shm"):
                (killed / written.name).write_bytes(written.read_bytes())
    database.close()
    assert (killed / "drive.db3-wal").stat().st_size > 0
    assert steerwright.inspect(killed / "drive.db3")["groups"][0]["rows"] == count
    # Compressed as a whole, by a package that need not be there.
    compressed = tmp_path / "drive.db3.zstd"
    compressed.write_bytes(b"\x28\xb5\x2f\xfd")
    with pytest.raises(steerwright.Error, match="zstandard|Zstandard|zstd"):
        steerwright.inspect(compressed)


def test_definitions_of_messages_are_taken_from_packages(table: dict[str, Any], tmp_path: Path) -> None:
    count = 1000
    file = tmp_path / "drive.db3"
    with sqlite3.connect(file) as database:
        database.execute("CREATE TABLE topics (id, name, type, serialization_format, offered_qos_profiles)")
        database.execute("CREATE TABLE messages (id, topic_id, timestamp, data)")
        database.execute("INSERT INTO topics VALUES (0, '/drive', 'maker_msgs/msg/Drive', 'cdr', '')")
        for k in range(count):
            stamp = struct.pack("<4BII", 0, 1, 0, 0, k // 100, 10_000_000 * (k % 100))
            steering, yaw_rate, speed = (float(table[name][k]) for name in NAMES[1:])
            data = stamp + struct.pack("<I4s3f", 4, b"car", steering, yaw_rate, speed)
            database.execute("INSERT INTO messages VALUES (?, 0, ?, ?)", (k, 10**7 * k, data))
    database.close()
    package = tmp_path / "share/maker_msgs/msg"
    package.mkdir(parents=True)
    fields = "std_msgs/Header header\nWheel wheel # front\nfloat32 yaw_rate_radps\nfloat32 speed_mps\n"
    (package / "Drive.msg").write_text(fields)
    (package / "Wheel.msg").write_text("float32 LIMIT=1.0\nfloat32 steering_angle_rad\n")
    with pytest.warns(steerwright.Warning, match=r"no definition of maker_msgs/msg/Drive.*ros_definitions"):
        steerwright.inspect(file)
    found = steerwright.inspect(file, ros_definitions=tmp_path / "share")
    names = [channel["name"] for channel in found["groups"][0]["channels"]]
    assert names[2:] == ["header.stamp", "wheel.steering_angle_rad", "yaw_rate_radps", "speed_mps"]
    read = steerwright.read(file, ros_definitions=[tmp_path / "share"], steering_ratio=1.0)
    speed = np.interp(read.time, 0.01 * np.arange(count), table["speed_mps"][:count])
    np.testing.assert_allclose(read.speed, speed, atol=0.1)
    (tmp_path / "none").mkdir()
    with pytest.raises(steerwright.Error, match="no definition of a message"):
        steerwright.inspect(file, ros_definitions=tmp_path / "none")
