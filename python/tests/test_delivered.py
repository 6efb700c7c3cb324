"""What is delivered is what was validated: the packed model in FMPy reproduces the fit that its file states."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
import steerwright
from test_vehicle import drive

PACKED = {"state-space": "IdentifiedPlant", "bicycle": "BicyclePlant", "single-track": "NonlinearVehicle"}
# From the start of the log, in which initial states die out.
LEFT_OUT_S = 3.0
SAMPLE_TIME_S = 0.02
STEP_S = 0.0025


def fit(measured: np.ndarray, simulated: np.ndarray) -> float:
    """Percent, without offsets."""
    measured = measured - measured.mean()
    errors = measured - (simulated - simulated.mean())
    return float(100.0 * (1.0 - np.linalg.norm(errors) / np.linalg.norm(measured)))


def scored(time: np.ndarray, validation: np.ndarray) -> np.ndarray:
    """The validation samples without the first seconds of the log, which is one segment."""
    return validation & (time >= time[0] + LEFT_OUT_S)


# A plant of samples follows steering without an actuator's lag between its samples only roughly: 0.2 points.
CASES = [(structure, lag_s) for structure in PACKED for lag_s in (0.0, 0.06) if (structure, lag_s) != ("state-space", 0.0)]


# The place of the validation data: a slow mode of a state-space model hides in initial states of blocks.
PLACED = [(*case, place) for case in CASES for place in (("auto", "end") if case[0] == "state-space" else ("auto",))]


@pytest.mark.parametrize(("structure", "lag_s", "place"), PLACED)
def test_the_packed_model_has_the_stated_fit(structure: str, lag_s: float, place: str, tmp_path: Path) -> None:
    columns = drive(120.0)
    # The command of a servo: ahead of the angle.
    steering = columns["roadwheel_angle_rad"]
    columns["roadwheel_angle_rad"] = steering + lag_s * np.gradient(steering, columns["time_s"])
    found = steerwright.identify(columns, structure=structure, sample_time=SAMPLE_TIME_S, validation_place=place)
    traces = found.traces
    assert traces is not None and found.fit is not None
    # FMPy holds an input over a step: that of its middle.
    inputs = np.rec.fromarrays(
        [columns["time_s"] - STEP_S / 2.0, columns["roadwheel_angle_rad"], columns["speed_mps"]],
        names=["time", "steering_angle", "speed"],
    )
    fmu = steerwright.package([found], out=tmp_path / "fmu")[PACKED[structure]]
    result = fmpy.simulate_fmu(
        str(fmu),
        input=inputs,
        output=["yaw_rate"],
        output_interval=STEP_S,
        stop_time=float(columns["time_s"][-1]),
    )
    chosen = scored(traces.time, traces.is_validation)
    packed = np.interp(traces.time, result["time"], result["yaw_rate"])[chosen]
    measured = traces.yaw_rate[chosen]
    validated = fit(measured, traces.simulated_yaw_rate[chosen])
    delivered = fit(measured, packed)
    print(f"{structure}, lag {lag_s} s: stated {found.fit:.2f}, of these samples {validated:.2f}, packed {delivered:.2f} %")
    assert abs(validated - found.fit) < 0.1
    assert abs(delivered - validated) < 0.1
