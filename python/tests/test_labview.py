"""TDMS files with raw values of DAQmx, written here as National Instruments describes them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import steerwright

COUNT = 1000
TIME = 0.01 * np.arange(COUNT)
STEERING = 3.4 * np.sin(np.pi * TIME)
YAW_RATE = 8.0 * np.sin(np.pi * TIME - 0.3)


def daqmx(unit: str, scale: str = "Linear") -> bytes:
    """Two channels of 16 bits in thousandths, whose units stand in the property; the second has this kind of scale."""

    def text(value: str) -> bytes:
        return struct.pack("<I", len(value)) + value.encode()

    def written(name: str, value: str | float | int) -> bytes:
        if isinstance(value, str):
            return text(name) + struct.pack("<I", 0x20) + text(value)
        kind, form = (10, "d") if isinstance(value, float) else (7, "I")
        return text(name) + struct.pack(f"<I{form}", kind, value)

    def channel(name: str, place: int, own_unit: str, own_scale: str) -> bytes:
        index = struct.pack("<IIIQI", 0x1269, 0xFFFFFFFF, 1, COUNT, 1)
        index += struct.pack("<5I2I", 3, 0, place, 0, 0, 1, 4)
        properties: list[tuple[str, str | float | int]] = [
            ("NI_Scaling_Status", "unscaled"),
            ("NI_Number_Of_Scales", 2),
            ("NI_Scale[1]_Scale_Type", own_scale),
            ("NI_Scale[1]_Linear_Slope", 1e-3),
            ("NI_Scale[1]_Linear_Y_Intercept", 0.0),
            ("NI_Scale[1]_Linear_Input_Source", 0),
            (unit, own_unit),
            ("wf_increment", 0.01),
            ("wf_start_offset", 0.0),
        ]
        content = b"".join(written(*own) for own in properties)
        return text(f"/'Drive'/'{name}'") + index + struct.pack("<I", len(properties)) + content

    none = b"\xff" * 4 + bytes(4)
    meta = struct.pack("<I", 4) + text("/") + none + text("/'Drive'") + none
    meta += channel("Road wheel angle", 0, "deg", "Linear") + channel("Yaw rate", 2, "deg/s", scale)
    raw = np.round(1000 * np.stack([STEERING, YAW_RATE], axis=1)).astype("<i2").tobytes()
    flags = 2 | 4 | 8 | 128
    return b"TDSm" + struct.pack("<IIQQ", flags, 4713, len(meta) + len(raw), len(meta)) + meta + raw


@pytest.mark.parametrize("unit", ["unit_string", "NI_UnitDescription", "Unit"])
def test_raw_values_of_daqmx_are_scaled(unit: str, tmp_path: Path) -> None:
    file = tmp_path / "drive.tdms"
    file.write_bytes(daqmx(unit))
    channels = steerwright.inspect(file)["groups"][0]["channels"]
    assert [channel["unit"] for channel in channels] == ["s", "deg", "deg/s"]
    for channel, expected in zip(channels[1:], (STEERING, YAW_RATE)):
        np.testing.assert_allclose([channel["min"], channel["max"]], [expected.min(), expected.max()], atol=5e-4)
    assert steerwright.read(file).sample_time > 0.0


def test_a_channel_without_a_scale_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "drive.tdms"
    file.write_bytes(daqmx("unit_string", scale="Another"))
    with pytest.warns(steerwright.Warning, match=r"Yaw rate \(Missing scaling information for DAQmx"):
        found = steerwright.inspect(file)
    names = [channel["name"] for channel in found["groups"][0]["channels"]]
    assert names == ["time_s", "Road wheel angle [deg]"]
