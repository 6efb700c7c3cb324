"""The response to a steering torque: the package compared with the command line and with SciPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import steerwright
from conftest import command_line
from scipy.optimize import least_squares

FACTOR, FRICTION, OFFSET, DELAY = 2.5, 0.12, 0.05, 0.3


def drive(seconds: float) -> dict[str, np.ndarray]:
    """A car whose lateral acceleration follows the delayed command with friction, sampled at 20 Hz."""
    rng = np.random.default_rng(3)
    time = np.arange(0.0, seconds, 0.05)
    slow = np.convolve(rng.standard_normal(len(time)), np.hanning(41) / 20.0, mode="same")
    command = 0.15 * np.convolve(slow, np.hanning(11) / 5.0, mode="same")
    delayed = np.interp(time - DELAY, time, command)
    angle = 0.3 * delayed
    rate = np.gradient(angle, time)
    roll = 0.03 * np.sin(0.3 * time)
    acceleration = FACTOR * (delayed - FRICTION * np.tanh(rate / 0.05)) + 9.80665 * np.sin(roll) + OFFSET
    acceleration += 0.02 * rng.standard_normal(len(time))
    return {
        "time_s": time,
        "steering_torque [1]": command,
        "lateral_acceleration_mps2": acceleration,
        "speed_mps": np.full(len(time), 22.0),
        "steering_angle_deg": np.degrees(angle),
        "roll_rad": roll,
    }


def test_it_returns_the_simulated_car_as_the_command_line_does(tmp_path: Path) -> None:
    columns = drive(600.0)
    found = steerwright.identify(columns, structure="torque")
    assert isinstance(found, steerwright.Torque)
    assert found.roll_coefficient is not None
    for estimate, truth in [
        (found.acceleration_per_command, FACTOR),
        (found.friction, FRICTION),
        (found.offset_mps2, OFFSET),
        (found.delay_s, DELAY),
        (found.roll_coefficient, 1.0),
    ]:
        assert abs(estimate.value - truth) < 3.0 * estimate.standard_error + 0.01 * truth
    assert found.fit > 90.0
    signals = found.signals
    assert signals is not None and list(signals.inputs) == ["steering_torque", "steering_rad"]
    measured, modelled = (of["lateral_acceleration_mps2"][signals.is_validation] for of in (signals.outputs, signals.simulated))
    own = 100.0 * (1.0 - np.linalg.norm(measured - modelled) / np.linalg.norm(measured - measured.mean()))
    assert abs(own - found.fit) < 1e-9

    header = ",".join(columns)
    np.savetxt(tmp_path / "drive.csv", np.stack(list(columns.values()), axis=1), "%.17g", ",", header=header, comments="")
    done = command_line("identify", "drive.csv", "--structure", "torque", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    of_file = steerwright.load(tmp_path / "torque.json")
    assert isinstance(of_file, steerwright.Torque)
    assert of_file.acceleration_per_command == found.acceleration_per_command

    exported = steerwright.export(found, "openpilot")
    values = {parameter["key"]: parameter["value"] for parameter in exported["parameters"]}
    assert values["latAccelFactor"] == found.acceleration_per_command.value
    assert "Torque" in repr(found) and "friction" in found._repr_html_()


def test_scipy_finds_the_same_optimum() -> None:
    columns = drive(600.0)
    found = steerwright.identify(columns, structure="torque", validation_fraction="0%")
    time = columns["time_s"]
    rate = np.gradient(np.radians(columns["steering_angle_deg"]), time)
    friction = np.tanh(rate / 0.05)
    used = slice(60, -60)

    def errors(p: np.ndarray) -> np.ndarray:
        delayed = np.interp(time - p[4], time, columns["steering_torque [1]"])
        predicted = p[0] * delayed - p[1] * friction + 9.80665 * p[2] * np.sin(columns["roll_rad"]) + p[3]
        return (columns["lateral_acceleration_mps2"] - predicted)[used]

    theirs = least_squares(errors, [2.0, 0.1, 0.9, 0.0, 0.25], diff_step=1e-3).x
    np.testing.assert_allclose(found.acceleration_per_command.value, theirs[0], rtol=5e-3)
    np.testing.assert_allclose(found.friction.value, theirs[1] / theirs[0], rtol=2e-2)
    np.testing.assert_allclose(found.delay_s.value, theirs[4], atol=5e-3)
    # A steady turn with the command that the model states for it.
    assert abs(FACTOR * found.command(1.0) + OFFSET - 1.0) < 0.01
