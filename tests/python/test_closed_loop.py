"""The closed loop under a Python master against the trajectory that the Rust host wrote."""

import csv
from pathlib import Path

import numpy as np
from gauss_seidel import Unit, Wire, run

LARGEST_DIFFERENCE = 1e-9


def test_python_master_and_rust_host_agree(out: Path) -> None:
    plant, path, pid = (
        Unit(out / "fmu" / f"{name}.fmu")
        for name in ("IdentifiedPlant", "ReferencePath", "LateralPid")
    )
    wires = [
        Wire(pid, "steering_angle", plant, "steering_angle"),
        Wire(plant, "x", path, "x"),
        Wire(plant, "y", path, "y"),
        Wire(plant, "yaw", path, "yaw"),
        Wire(path, "yaw_reference", pid, "yaw_reference"),
        Wire(path, "steering_feedforward", pid, "steering_feedforward"),
        Wire(plant, "yaw", pid, "yaw"),
    ]
    with open(out / "result.csv", newline="") as file:
        rows = list(csv.reader(file))
    header = rows[0]
    expected = np.array([[float(cell) for cell in row] for row in rows[1:]])
    outputs = [tuple(column.split(".")) for column in header[1:]]
    step = expected[1, 0] - expected[0, 0]
    got = run(
        [plant, path, pid],
        wires,
        starts={},
        stop=expected[-1, 0],
        step=round(step, 9),
        record=outputs,
    )
    for unit in (plant, path, pid):
        unit.close()
    assert got.shape == expected.shape
    difference = np.abs(got - expected).max(axis=0)
    for name, value in zip(header, difference):
        print(f"{name}: {value:.3e}")
    assert difference.max() <= LARGEST_DIFFERENCE
    # The loop did something: it steered, and it stayed on the road.
    column = header.index("ReferencePath.cross_track_error")
    assert np.ptp(expected[:, header.index("LateralPid.steering_angle")]) > 0.01
    assert np.abs(expected[:, column]).max() < 0.3
