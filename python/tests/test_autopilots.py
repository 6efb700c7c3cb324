"""Logs of PX4 and ArduPilot, written here as their documentation describes them."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steerwright

COUNT = 1000
TIME = 0.01 * np.arange(COUNT)
STEERING = 0.05 * np.sin(np.pi * TIME)
YAW_RATE = 0.2 * np.sin(np.pi * TIME - 0.3)


def ulog() -> bytes:
    def message(kind: str, content: bytes) -> bytes:
        return struct.pack("<HB", len(content), ord(kind)) + content

    # A message within another with padding, and padding at the end that is not written.
    text = (
        "F vehicle_angular_velocity:uint64_t timestamp;float[3] xyz;",
        "F part:uint8_t on;uint8_t[3] _padding0;",
        "F rover:uint64_t timestamp;part[2] parts;float steer_rad;float speed_mps;uint8_t[4] _padding0;",
        "I \x0bchar[4] sysPX4_",
    )
    log = b"ULog\x01\x12\x35\x01" + bytes(8) + message("B", bytes(40))
    log += b"".join(message(line[0], line[2:].encode()) for line in text)
    for number, (instance, name) in enumerate([(0, b"vehicle_angular_velocity"), (1, b"rover")]):
        log += message("A", struct.pack("<BH", instance, number) + name)
    for k in range(COUNT):
        stamp = 5_000_000 + 10_000 * k
        # Positive to the right.
        log += message("D", struct.pack("<HQ3f", 0, stamp, 0.0, 0.0, -YAW_RATE[k]))
        log += message("D", struct.pack("<HQB3xB3xff", 1, stamp, 1, 2, STEERING[k], 15.0))
    return log


def dataflash() -> bytes:
    def form(number: int, size: int, *texts: str) -> bytes:
        return b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", number, 3 + size, *(text.encode() for text in texts))

    log = form(128, 86, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    log += form(1, 73, "UNIT", "QbZ", "TimeUS,Id,Label") + form(2, 17, "MULT", "Qbd", "TimeUS,Id,Mult")
    log += form(3, 41, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds")
    log += form(10, 14, "STER", "Qcf", "TimeUS,SteerAngle,Speed")
    log += form(11, 13, "IMU", "QBf", "TimeUS,I,GyrZ") + form(12, 4, "OLD", "f", "X")
    for letter, unit in (("s", "s"), ("d", "deg"), ("n", "m/s"), ("#", "instance"), ("E", "rad/s")):
        log += b"\xa3\x95\x01" + struct.pack("<Qb64s", 0, ord(letter), unit.encode())
    for letter, factor in (("F", 1e-6), ("0", 1.0), ("B", 0.01), ("-", 0.0)):
        log += b"\xa3\x95\x02" + struct.pack("<Qbd", 0, ord(letter), factor)
    for number, units, factors in ((10, b"sdn", b"FB0"), (11, b"s#E", b"F-0")):
        log += b"\xa3\x95\x03" + struct.pack("<QB16s16s", 0, number, units, factors)
    for k in range(COUNT):
        stamp = 5_000_000 + 10_000 * k
        angle = round(100 * np.degrees(STEERING[k]))
        log += b"\xa3\x95\x0a" + struct.pack("<Qhf", stamp, angle, 15.0)
        for instance in (0, 1):
            rate = -YAW_RATE[k] * (1 + instance)
            log += b"\xa3\x95\x0b" + struct.pack("<QBf", stamp, instance, rate)
        if k == 500:
            log += b"junk\xa3\x95\xff" + b"\xa3\x95\x0c" + bytes(4)
    return log


OPTIONS: dict[str, dict[str, Any]] = {
    "drive.ulg": {"output_channel": "-xyz[2]", "steering_ratio": 1.0},
    "drive.bin": {"output_channel": "-IMU[0].GyrZ [rad/s]", "steering_ratio": 1.0},
}


@pytest.mark.parametrize(("name", "log"), [("drive.ulg", ulog()), ("drive.bin", dataflash())])
def test_logs_of_autopilots(name: str, log: bytes, tmp_path: Path) -> None:
    file = tmp_path / name
    file.write_bytes(log)
    read = steerwright.read(file, **OPTIONS[name])
    for values, largest in ((read.steering, 0.05), (read.yaw_rate, 0.2)):
        np.testing.assert_allclose([values.min(), values.max()], [-largest, largest], atol=2e-3)
    # Both turn to the same side, the yaw rate later by 0.3 rad.
    assert np.corrcoef(read.steering, read.yaw_rate)[0, 1] == pytest.approx(np.cos(0.3), abs=0.02)
    assert read.speed is not None
    np.testing.assert_allclose(read.speed, 15.0)
    # By its first bytes, also under another name.
    other = tmp_path / "renamed.log"
    other.write_bytes(log)
    assert steerwright.inspect(other)["groups"] == steerwright.inspect(file)["groups"]


def test_what_is_left_out_of_logs_of_autopilots_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "drive.bin"
    file.write_bytes(dataflash())
    with pytest.warns(steerwright.Warning, match=r"7 bytes that are no messages, OLD \(no time\)"):
        found = steerwright.inspect(file)
    names = [group["name"] for group in found["groups"]]
    assert names == ["STER", "IMU[0]", "IMU[1]"]
    cut = tmp_path / "cut.ulg"
    cut.write_bytes(ulog()[:-20])
    with pytest.warns(steerwright.Warning, match="where the file is cut"):
        rows = [group["rows"] for group in steerwright.inspect(cut)["groups"]]
    assert rows == [COUNT, COUNT - 1]


@pytest.mark.parametrize("log", [ulog(), dataflash()])
def test_damaged_logs_of_autopilots_are_errors_or_read(log: bytes, tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    for trial in range(60):
        data = np.frombuffer(log[:6000], dtype=np.uint8).copy()
        # The first bytes name the format.
        places = random.integers(7, len(data), 1 + trial // 4)
        data[places] = random.integers(0, 256, len(places))
        file = tmp_path / f"{trial}.bin"
        file.write_bytes(data.tobytes())
        try:
            steerwright.inspect(file)
        except steerwright.Error as error:
            assert error.hint
