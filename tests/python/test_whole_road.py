"""All units along a road with its speed profile, from standstill to standstill, against this project's host."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.ssp.simulation import simulate_ssp
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

COLUMNS = [
    "LongitudinalPlant.speed",
    "BicyclePlant.x",
    "BicyclePlant.y",
    "BicyclePlant.yaw",
    "PoseEstimator.x",
    "PoseEstimator.yaw",
    "ReferencePath.speed_reference",
    "ReferencePath.acceleration_reference",
    "ReferencePath.cross_track_error",
    "ReferencePath.distance",
    "SpeedController.accelerator",
    "SpeedController.brake",
    "LateralPid.steering_angle",
]


@pytest.fixture
def folder() -> Path:
    return Path(os.environ["STEERWRIGHT_OUT"]) / "whole-road"


@pytest.fixture
def expected(folder: Path) -> dict[str, np.ndarray]:
    """What `steerwright simulate --coupling jacobi` gives for the package."""
    with open(folder / "jacobi.csv", newline="") as opened:
        header, *rows = csv.reader(opened)
    values = np.array([[float(cell) for cell in row] for row in rows])
    return dict(zip(header, values.T))


def drives_the_road(columns: dict[str, np.ndarray]) -> None:
    """From standstill to standstill, near the profile and the road."""
    speed, reference = columns["LongitudinalPlant.speed"], columns["ReferencePath.speed_reference"]
    assert speed[1] < 0.1 and speed[-1] == 0.0 and speed.max() > 15.0
    assert np.abs(columns["ReferencePath.cross_track_error"]).max() < 0.1
    distance = columns["ReferencePath.distance"]
    assert distance[-1] > 424.0, distance[-1]
    # The reference is that of a place ahead; after the preview the speed is there.
    assert np.sqrt(np.mean((speed - reference) ** 2)) < 0.6
    assert columns["SpeedController.brake"][-1] > 0.1


def test_the_host_drives_it(expected: dict[str, np.ndarray]) -> None:
    drives_the_road(expected)


def test_libcosim_runs_it(folder: Path, expected: dict[str, np.ndarray]) -> None:
    execution = CosimExecution.from_ssp_file(str(folder / "fmu" / "WholeRoad.ssp"))
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    places = []
    for column in COLUMNS:
        unit, name = column.split(".", 1)
        variables = read_model_description(str(folder / "fmu" / f"{unit}.fmu")).modelVariables
        reference = next(v.valueReference for v in variables if v.name == name)
        places.append((execution.slave_index_from_instance_name(unit), reference))
    rows = []
    for _ in range(len(expected["time"]) - 1):
        assert execution.step()
        rows.append([observer.last_real_values(index, [at])[0] for index, at in places])
    for column, got in zip(COLUMNS, np.array(rows).T):
        assert np.abs(got - expected[column][1:]).max() <= 1e-9, column


def test_fmpy_runs_it(folder: Path, expected: dict[str, np.ndarray]) -> None:
    """From zeros on every connection at first, which passes."""
    step = expected["time"][1]
    result = simulate_ssp(
        str(folder / "fmu" / "WholeRoad.ssp"), stop_time=expected["time"][-1] - 0.5 * step, step_size=step
    )
    columns = {name: result[name] for name in COLUMNS}
    off_at_first = np.abs(columns["ReferencePath.cross_track_error"][:2]).max()
    print(f"fmpy, whole road: {off_at_first:.3f} m off at the zeros of its start")
    columns["ReferencePath.cross_track_error"] = columns["ReferencePath.cross_track_error"][2:]
    drives_the_road(columns)
