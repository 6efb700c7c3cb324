"""The vehicle up to the limit of its grip: the package compared with the command line, and with SciPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import steerwright
from conftest import command_line
from scipy.integrate import solve_ivp

MASS, INERTIA, FRONT, REAR = 1400.0, 2300.0, 1.2, 1.5
STIFFNESS_FRONT, STIFFNESS_REAR, FRICTION, SHAPE = 95_000.0, 120_000.0, 0.9, 1.3


def force(stiffness: float, load: float, slip: float) -> float:
    peak = FRICTION * load
    return peak * float(np.sin(SHAPE * np.arctan(stiffness / (SHAPE * peak) * slip)))


def drive(seconds: float) -> dict[str, np.ndarray]:
    """A car of two axles with the magic formula, between 12 and 24 m/s and up to 7 m/s²."""
    time = np.arange(0.0, seconds, 0.02)
    speed = 18.0 + 6.0 * np.sin(0.13 * time)
    swings = sum(np.sin(2.0 * np.pi * f * time + p) for f, p in ((0.12, 0.0), (0.31, 1.0), (0.7, 2.0)))
    wheelbase = FRONT + REAR
    steering = (1.5 + 0.8 * np.sin(0.09 * time)) * swings * (wheelbase / speed**2 + 0.0005)
    loads = [MASS * 9.81 * REAR / wheelbase, MASS * 9.81 * FRONT / wheelbase]

    def forces(t: float, state: np.ndarray) -> tuple[float, float, float, float]:
        v, delta = np.interp(t, time, speed), np.interp(t, time, steering)
        vy, r = state
        front = force(STIFFNESS_FRONT, loads[0], delta - np.arctan((vy + FRONT * r) / v))
        rear = force(STIFFNESS_REAR, loads[1], -np.arctan((vy - REAR * r) / v))
        return front * np.cos(delta), rear, v, r

    def rates(t: float, state: np.ndarray) -> list[float]:
        front, rear, v, r = forces(t, state)
        return [(front + rear) / MASS - v * r, (FRONT * front - REAR * rear) / INERTIA]

    states = solve_ivp(rates, (0.0, time[-1]), [0.0, 0.0], t_eval=time, max_step=0.01, rtol=1e-6).y
    acceleration = [sum(forces(t, state)[:2]) / MASS for t, state in zip(time, states.T)]
    rng = np.random.default_rng(2)
    return {
        "time_s": time,
        "roadwheel_angle_rad": steering,
        "yaw_rate_radps": states[1] + 0.001 * rng.standard_normal(len(time)),
        "speed_mps": speed,
        "lateral_acceleration_mps2": np.array(acceleration) + 0.05 * rng.standard_normal(len(time)),
    }


@pytest.fixture(scope="module")
def columns() -> dict[str, np.ndarray]:
    return drive(120.0)


def test_it_returns_the_simulated_car_as_the_command_line_does(columns: dict[str, np.ndarray], tmp_path: Path) -> None:
    found = steerwright.identify(columns, structure="single-track", mass=MASS)
    assert isinstance(found, steerwright.Vehicle)
    assert found.fit is not None and found.fit > 97.0
    wheelbase = FRONT + REAR
    for name, truth in [
        ("wheelbase", wheelbase),
        ("front_share", REAR / wheelbase),
        ("dynamic_index", INERTIA / (MASS * FRONT * REAR)),
        ("friction_coefficient_front", FRICTION),
        ("cornering_stiffness_front_per_load", STIFFNESS_FRONT / (MASS * 9.81 * REAR / wheelbase)),
        ("cornering_stiffness_rear_per_load", STIFFNESS_REAR / (MASS * 9.81 * FRONT / wheelbase)),
    ]:
        parameter = found.parameter(name)
        assert abs(parameter.value - truth) < 4.0 * parameter.standard_error + 0.02 * truth, (name, parameter.value)
    with pytest.raises(steerwright.Error, match="no such parameter"):
        found.parameter("colour")
    assert "wheelbase" in repr(found) and "friction" in found._repr_html_()

    header = ",".join(columns)
    np.savetxt(tmp_path / "drive.csv", np.stack(list(columns.values()), axis=1), "%.17g", ",", header=header, comments="")
    done = command_line("identify", "drive.csv", "--structure", "single-track", "--mass", str(MASS), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    of_file = steerwright.load(tmp_path / "vehicle.json")
    assert isinstance(of_file, steerwright.Vehicle)
    assert of_file.body == found.body and of_file.tyres == found.tyres

    packed = steerwright.package([found], out=tmp_path / "fmu")
    assert packed["NonlinearVehicle"].exists()


def test_the_structure_is_chosen_by_the_data(columns: dict[str, np.ndarray]) -> None:
    yaw_rate_alone = {k: v for k, v in columns.items() if "lateral" not in k}
    found = steerwright.identify(yaw_rate_alone)
    assert isinstance(found, steerwright.Vehicle)
    assert found.quality.grade == "pass", found.quality
    assert set(found.figures()) == {"drive", "comparison"}
    assert "cornering stiffness front" in found.report()
    controller = steerwright.design(found)
    assert controller.designed_for.model == "bicycle"


def test_a_structure_that_is_not_stated_reads_what_the_command_line_reads(
    columns: dict[str, np.ndarray], tmp_path: Path
) -> None:
    found = steerwright.identify(columns, mass=MASS)
    header = ",".join(columns)
    np.savetxt(tmp_path / "drive.csv", np.stack(list(columns.values()), axis=1), "%.17g", ",", header=header, comments="")
    done = command_line("identify", "drive.csv", "--mass", str(MASS), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    of_file = steerwright.load(tmp_path / "vehicle.json")
    assert isinstance(found, steerwright.Vehicle) and isinstance(of_file, steerwright.Vehicle)
    assert of_file.body == found.body and of_file.tyres == found.tyres
    assert "lateral_acceleration" in {channel.role for channel in found.evidence.channels}
