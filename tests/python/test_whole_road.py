"""All units along a road with its speed profile, from standstill to standstill, against this project's host."""

from __future__ import annotations

import csv
import json
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


def drives_the_road(columns: dict[str, np.ndarray], folder: Path) -> None:
    """From standstill to standstill, near the profile and the road."""
    speed, distance = columns["LongitudinalPlant.speed"], columns["ReferencePath.distance"]
    assert speed[1] < 0.1 and speed[-1] == 0.0 and speed.max() > 15.0
    assert np.abs(columns["ReferencePath.cross_track_error"]).max() < 0.1
    points = np.array(json.loads((folder / "path.json").read_text())["profile"]["points"]).T
    assert abs(distance[-1] - points[0, -1]) < 0.5
    # The units' reference is that of a place ahead.
    due = np.sqrt(np.interp(distance, points[0], points[1] ** 2))
    assert np.sqrt(np.mean((speed - due) ** 2)) < 0.3
    assert columns["SpeedController.brake"][-1] > 0.1


def test_the_host_drives_it(folder: Path, expected: dict[str, np.ndarray]) -> None:
    drives_the_road(expected, folder)


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
    drives_the_road({name: result[name][2:] for name in COLUMNS}, folder)
