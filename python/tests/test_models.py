"""What follows from a model, compared with python-control and SciPy."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import control
import numpy as np
import pytest
import steerwright
from scipy import signal


def with_delay(plant: steerwright.Plant, delay: float) -> steerwright.Plant:
    document = json.loads(plant.to_json())
    document["input_delay_s"] = delay
    return steerwright.Plant(json.dumps(document))


OMEGA = np.geomspace(0.1, 100.0, 40)


def test_the_frequency_response_is_that_of_python_control(plant: steerwright.Plant) -> None:
    response = plant.frequency_response(OMEGA).response
    theirs = plant.to_control(delay=False)(np.exp(1j * OMEGA * plant.sample_time))
    np.testing.assert_allclose(response * np.exp(1j * OMEGA * plant.delay), theirs, rtol=1e-10)


@pytest.mark.parametrize("samples", [0.0, 1.0, 3.0, 2.25, 0.5])
def test_delays_become_states(plant: steerwright.Plant, samples: float) -> None:
    delayed = with_delay(plant, samples * plant.sample_time)
    system = delayed.to_control()
    assert system.dt == plant.sample_time
    assert system.nstates == plant.order + int(np.ceil(samples))
    # A held input, late by a part of a sample, is the mean of two of its values.
    u = np.random.default_rng(1).standard_normal(400)
    whole, part = int(samples), samples - int(samples)
    shifted = np.concatenate([np.zeros(whole + 1), u])
    late = (1.0 - part) * shifted[1 : len(u) + 1] + part * shifted[: len(u)]
    _, expected, _ = signal.dlsim(plant.to_scipy(delay=False), late)
    theirs = control.forced_response(system, inputs=u).outputs
    np.testing.assert_allclose(theirs, expected[:, 0], atol=1e-12)
    _, ours, _ = signal.dlsim(delayed.to_scipy(), u)
    np.testing.assert_allclose(ours[:, 0], expected[:, 0], atol=1e-12)


def test_the_continuous_model_is_that_of_the_document(plant: steerwright.Plant) -> None:
    assert plant.continuous is not None
    system = plant.to_control(continuous=True, delay=False)
    assert system.dt == 0
    np.testing.assert_array_equal(system.A, plant.continuous.F)
    # Held and sampled it is the discrete model again.
    sampled = control.c2d(system, plant.sample_time)
    np.testing.assert_allclose(sampled(np.exp(1j * OMEGA * plant.sample_time)), plant.frequency_response(OMEGA).response * np.exp(1j * OMEGA * plant.delay), rtol=1e-8)
    delayed = with_delay(plant, 0.1)
    omega = np.geomspace(0.1, 4.0 / 0.1, 40)
    expected = system(1j * omega) * np.exp(-0.1j * omega)
    late = delayed.to_control(continuous=True)(1j * omega)
    assert np.abs(np.angle(late / expected)).max() < np.deg2rad(1.0)
    np.testing.assert_allclose(np.abs(late), np.abs(expected), rtol=1e-9)
    _, theirs = signal.freqresp(delayed.to_scipy(continuous=True), omega)
    np.testing.assert_allclose(theirs, late, rtol=1e-9)
    document = json.loads(plant.to_json())
    del document["continuous"]
    with pytest.raises(steerwright.Error, match="no continuous model"):
        steerwright.Plant(json.dumps(document)).to_control(continuous=True)


def test_names_with_dots_are_names_of_systems(plant: steerwright.Plant, controller: steerwright.Controller) -> None:
    for model in (plant, controller):
        named = type(model)(json.dumps({**json.loads(model.to_json()), "name": "drive.2024.02"}))
        assert named.to_control().name == "drive_2024_02"


def test_the_controller_is_that_of_the_fmu(controller: steerwright.Controller, fmus: dict[str, Path]) -> None:
    system = controller.to_control()
    assert system.dt == controller.sample_time_s
    time = system.dt * np.arange(300)
    # Small enough for the limits, and from rest.
    inputs = 1e-4 * np.vstack([1.0 - np.cos(2.0 * time), np.sin(3.0 * time) * time, np.sin(time)])
    names = ["yaw_reference", "yaw", "steering_feedforward"]
    columns = {"time": time, **dict(zip(names, inputs))}
    run = steerwright.simulate(fmus["LateralPid"], input=columns, step=system.dt, stop=time[-2])
    theirs = control.forced_response(system, inputs=inputs).outputs[0]
    assert np.abs(run["steering_angle"]).max() > 1e-5
    # The output at a time is that of the tick before, with the inputs of then.
    np.testing.assert_allclose(run["steering_angle"][1:], theirs[: len(run.time) - 1], atol=1e-12)


def test_a_schedule_has_gains_at_a_speed(controller: steerwright.Controller) -> None:
    document = json.loads(controller.to_json())
    entries = [{"speed_mps": speed, "gains": {**document["gains"], "kp": kp}, "guidance": {}} for speed, kp in ((5.0, 1.0), (15.0, 3.0))]
    scheduled = steerwright.Controller(json.dumps({**document, "schedule": entries}))
    with pytest.raises(steerwright.Error, match="the gains depend on the speed, from 5 to 15 m/s"):
        scheduled.to_control()
    difference = [scheduled.to_control(speed=speed).D - scheduled.to_control(speed=5.0).D for speed in (10.0, 15.0, 40.0)]
    np.testing.assert_allclose([d[0, 1] for d in difference], [-1.0, -2.0, -2.0], atol=1e-12)


@pytest.mark.parametrize("shadow", ["control/__init__.py", "control.py", "control/Cargo.toml"])
def test_python_control_is_found_beside_a_folder_of_its_name(shadow: str, plant: steerwright.Plant, tmp_path: Path) -> None:
    (tmp_path / shadow).parent.mkdir(exist_ok=True)
    (tmp_path / shadow).write_text("OWN = 1\n" if shadow.endswith(".py") else "")
    plant.save(tmp_path / "plant.json")
    code = """
import steerwright
system = steerwright.load("plant.json").to_control()
system = steerwright.load("plant.json").to_control() * system
print(system.nstates, float(abs(system(1.0).real)) > 0.0)
import control
print(getattr(control, "OWN", None))
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    own = "1" if shadow.endswith(".py") else "None"
    states = plant.to_control().nstates
    assert done.stdout.split() == [str(2 * states), "True", own], done.stderr


def test_the_step_response_is_that_of_scipy(plant: steerwright.Plant) -> None:
    step = plant.step(2.0)
    _, (theirs,) = signal.dstep(plant.to_scipy(delay=False), n=len(step.time))
    np.testing.assert_allclose(step.yaw_rate, theirs[:, 0], atol=1e-12)
    np.testing.assert_allclose(plant.gain, plant.step(30.0).yaw_rate[-1], rtol=1e-6)


def test_samples_spread_as_the_document_states(log: steerwright.Log) -> None:
    # The standard errors of the document are those of the sampled models, to first order: of an order that the
    # drive determines well.
    plant = steerwright.identify(log, order=2)
    assert plant.uncertainty is not None
    models = plant.sample(4000, seed=7)
    for band in plant.uncertainty.step_response[5::10]:
        count = round(band.time_s / plant.sample_time)
        values = []
        for model in models:
            x, y = np.zeros((plant.order, 1)), 0.0
            for _ in range(count + 1):
                y = (model.C @ x + model.D)[0, 0]
                x = model.A @ x + model.B
            values.append(y)
        assert np.std(values) == pytest.approx(band.standard_error, rel=0.1)
        assert np.mean(values) == pytest.approx(band.value, abs=3 * band.standard_error)
    assert all(np.abs(np.linalg.eigvals(model.A)).max() < 1.0 for model in models)
    again = plant.sample(3, seed=7)
    np.testing.assert_array_equal(again[2].A, models[2].A)


def test_the_bicycle_has_the_gain_of_the_textbook(log: steerwright.Log) -> None:
    bicycle = steerwright.identify_bicycle(log)
    v, speed = bicycle.vehicle, 15.0
    length = v.distance_front_m + v.distance_rear_m
    gradient = (v.mass_kg / length) * (
        v.distance_rear_m / v.cornering_stiffness_front_npr
        - v.distance_front_m / v.cornering_stiffness_rear_npr
    )
    expected = speed / (length + gradient * speed**2) / v.steering_ratio
    gain = control.dcgain(bicycle.to_control(speed))[0, 0]
    assert gain == pytest.approx(expected, rel=1e-9)


def test_the_yaw_step_is_that_of_the_evidence(controller: steerwright.Controller) -> None:
    step = controller.step(3.0)
    height = np.deg2rad(5.0)
    overshoot = 100.0 * max(step.yaw.max() / height - 1.0, 0.0)
    assert overshoot == pytest.approx(controller.evidence.step.overshoot_percent, abs=0.05)
    outside = np.abs(step.yaw - height) > 0.02 * height
    assert step.time[np.flatnonzero(outside)[-1] + 1] == pytest.approx(
        controller.evidence.step.settling_time_s, abs=0.02
    )


def test_notebooks_show_figures(plant: steerwright.Plant, controller: steerwright.Controller) -> None:
    for shown, figures in ((plant._repr_html_(), plant.figures()), (controller._repr_html_(), {})):
        assert shown.count("<svg") >= max(len(figures), 4)
    assert {"drive", "comparison", "frequency_response"} <= {
        name.replace("-", "_") for name in plant.figures()
    } or len(plant.figures()) >= 6
    assert plant.report().startswith("<!DOCTYPE html>")
