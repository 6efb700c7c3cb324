"""The loop with the estimated pose, from its package, against this project's host."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.ssp.simulation import simulate_ssp
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

# The signals that the tests evaluate: the vehicle, its estimate, and its steering.
COLUMNS = [
    "IdentifiedPlant.x",
    "IdentifiedPlant.y",
    "IdentifiedPlant.yaw",
    "PoseEstimator.x",
    "PoseEstimator.y",
    "PoseEstimator.yaw",
    "ReferencePath.yaw_reference",
    "ReferencePath.cross_track_error",
    "LateralPid.steering_angle",
]


@pytest.fixture
def packed(out: Path) -> Path:
    return out / "fmu-estimator" / "PoseLoop.ssp"


@pytest.fixture
def expected(out: Path) -> dict[str, np.ndarray]:
    """What `steerwright simulate --coupling jacobi` gives for the package."""
    with open(out / "reference/estimator-jacobi.csv", newline="") as opened:
        header, *rows = csv.reader(opened)
    values = np.array([[float(cell) for cell in row] for row in rows])
    return dict(zip(header, values.T))


def test_libcosim_runs_it(packed: Path, expected: dict[str, np.ndarray]) -> None:
    execution = CosimExecution.from_ssp_file(str(packed))
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    places = []
    for column in COLUMNS:
        unit, name = column.split(".", 1)
        variables = read_model_description(str(packed.parent / f"{unit}.fmu")).modelVariables
        reference = next(v.valueReference for v in variables if v.name == name)
        places.append((execution.slave_index_from_instance_name(unit), reference))
    rows = []
    for _ in range(len(expected["time"]) - 1):
        assert execution.step()
        rows.append([observer.last_real_values(index, [at])[0] for index, at in places])
    for column, got in zip(COLUMNS, np.array(rows).T):
        assert np.abs(got - expected[column][1:]).max() <= 1e-9, column
    assert np.ptp(expected["LateralPid.steering_angle"]) > 0.01


def test_fmpy_runs_it(packed: Path, expected: dict[str, np.ndarray]) -> None:
    """From zeros on every connection at first, which passes."""
    step = expected["time"][1]
    result = simulate_ssp(str(packed), stop_time=expected["time"][-1] - 0.5 * step, step_size=step)
    away = np.hypot(
        result["IdentifiedPlant.x"] - result["PoseEstimator.x"],
        result["IdentifiedPlant.y"] - result["PoseEstimator.y"],
    )
    # A Jacobi coupling's estimate is a step old.
    speed = np.hypot(
        np.diff(result["IdentifiedPlant.x"]), np.diff(result["IdentifiedPlant.y"])
    ).max() / step
    assert away[100:].max() < speed * step + 0.02
    error = result["ReferencePath.cross_track_error"]
    assert np.abs(error[-100:] - expected["ReferencePath.cross_track_error"][-100:]).max() < 0.01
