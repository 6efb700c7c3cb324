"""The response of the speed: the package compared with the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import steerwright
from conftest import command_line

GAIN, LAG, DELAY, RESISTANCE = 0.95, 0.3, 0.14, 0.15


def drive(seconds: float) -> dict[str, np.ndarray]:
    """A cruise control sends acceleration commands at 50 Hz to follow a changing speed."""
    rng = np.random.default_rng(5)
    step = 0.02
    speed, drive_mps2, reference, wanted, command = 12.0, 0.0, 12.0, 12.0, 0.0
    delayed = [0.0] * round(DELAY / step)
    commands, speeds = [], []
    for k in range(round(seconds / step)):
        if k % 300 == 0:
            wanted = rng.uniform(8.0, 26.0)
        reference += np.clip(wanted - reference, -0.04, 0.03)
        command = float(np.clip(0.8 * (reference - speed) + 0.2 + 0.1 * rng.standard_normal(), -4.0, 3.0))
        commands.append(command)
        speeds.append(speed + 0.02 * rng.standard_normal())
        delayed.append(command)
        late = GAIN * delayed.pop(0)
        # The lag has a closed form where the command is held.
        decay = np.exp(-step / LAG)
        area = late * step + (drive_mps2 - late) * LAG * (1.0 - decay)
        drive_mps2 = late + (drive_mps2 - late) * decay
        speed += area - step * (RESISTANCE + 4e-4 * speed**2)
    time = step * np.arange(len(speeds))
    return {"time_s": time, "acceleration_command_mps2": np.array(commands), "speed_mps": np.array(speeds)}


def test_it_returns_the_simulated_car_as_the_command_line_does(tmp_path: Path) -> None:
    columns = drive(300.0)
    found = steerwright.identify(columns, structure="longitudinal")
    assert isinstance(found, steerwright.Longitudinal)
    assert found.quality.grade == "pass"
    for estimate, truth in [
        (found.gains[0].gain, GAIN),
        (found.time_constant_s, LAG),
        (found.delay_s, DELAY),
        (found.resistance_mps2, RESISTANCE),
    ]:
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_error + 0.01 * truth, (estimate, truth)
    assert found.fit > 90.0
    signals = found.signals
    assert signals is not None and list(signals.inputs) == ["acceleration_command_mps2"]
    error = (signals.simulated["speed_mps"] - signals.outputs["speed_mps"])[signals.is_validation]
    assert np.isfinite(error).mean() > 0.9 and np.sqrt(np.nanmean(error**2)) < 0.1

    header = ",".join(columns)
    np.savetxt(tmp_path / "drive.csv", np.stack(list(columns.values()), axis=1), "%.17g", ",", header=header, comments="")
    done = command_line("identify", "drive.csv", "--structure", "longitudinal", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    of_file = steerwright.load(tmp_path / "longitudinal.json")
    assert isinstance(of_file, steerwright.Longitudinal)
    assert of_file.signals is None and of_file.gains == found.gains and of_file.time_constant_s == found.time_constant_s
    assert "Longitudinal" in repr(found)


def test_its_controller_is_designed_packed_and_read_again(tmp_path: Path) -> None:
    model = steerwright.identify(drive(300.0), structure="longitudinal")
    controller = steerwright.design(model, speeds=(10, 22), grade=0.05)
    assert isinstance(controller, steerwright.SpeedController) and controller.met
    assert controller.specification.grade_percent == 5.0
    of_model, of_fmus = controller.evidence.speeds, controller.evidence.fmu_loop
    assert len(of_fmus) == len(of_model) == 5
    for row, in_loop in zip(of_model, of_fmus):
        assert abs(row.up.settling_time_s - in_loop.up.settling_time_s) < 1e-3
        assert abs(row.up.overshoot_percent - in_loop.up.overshoot_percent) < 0.01

    road = steerwright.path(profile=True, speed_controller=controller)
    assert isinstance(road, steerwright.Path)

    model.save(tmp_path / "longitudinal.json")
    controller.save(tmp_path / "speed_controller.json")
    again = steerwright.load(tmp_path / "speed_controller.json")
    assert isinstance(again, steerwright.SpeedController) and again == controller
    of_file = steerwright.design(tmp_path / "longitudinal.json", speeds=(10, 22), grade=0.05)
    assert isinstance(of_file, steerwright.SpeedController) and of_file.gains == controller.gains
    files = steerwright.package([model, again], out=tmp_path / "fmu")
    assert set(files) == {"LongitudinalPlant", "SpeedController"}
    with pytest.raises(steerwright.Error, match="modulus_margin"):
        steerwright.design(model, modulus_margin=0.4)
    assert "met" in repr(again) and "kp" in again._repr_html_()


def test_a_log_of_another_response_is_rejected() -> None:
    time = 0.02 * np.arange(2000.0)
    steering = 0.05 * np.sin(time)
    columns = {"time_s": time, "steering_angle_rad": steering, "yaw_rate_radps": steering, "speed_mps": 0 * time + 15.0}
    log = steerwright.read(columns, steering_ratio=1.0)
    with pytest.raises(steerwright.Error, match="response"):
        steerwright.identify(log, structure="longitudinal")
