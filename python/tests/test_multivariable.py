"""Plants of several named channels."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import steerwright

control = pytest.importorskip("control")

INPUTS, OUTPUTS = ["heater", "valve"], ["T1", "T2"]


def tanks(count: int = 800, noise: float = 0.3) -> dict[str, np.ndarray]:
    """Two tanks, sampled every 0.5 s: the valve acts three samples late."""
    rng = np.random.default_rng(3)
    heater = np.repeat(100 * rng.standard_normal(count // 4 + 1), 4)[:count]
    valve = np.repeat(1.5 * rng.standard_normal(count // 4 + 1), 4)[:count]
    a, b, outputs = 0.0, 0.0, np.empty((count, 2))
    for k in range(count):
        outputs[k] = a, b
        late = valve[k - 3] if k >= 3 else 0.0
        a, b = 0.9 * a + 0.02 * heater[k] - 0.3 * late, 0.8 * b + 0.15 * a + 0.6 * late
    outputs += [60, 45] + noise * rng.standard_normal((count, 2))
    time = 0.5 * np.arange(count)
    return {"time_s": time, "heater": 1500 + heater, "valve": 4 + valve, "T1": outputs[:, 0], "T2": outputs[:, 1]}


@pytest.fixture(scope="module")
def table() -> dict[str, np.ndarray]:
    return tanks()


@pytest.fixture(scope="module")
def plant(table: dict[str, np.ndarray]) -> steerwright.MultivariablePlant:
    units = {"heater": "W", "T1": "degC", "T2": "degC"}
    found: object = steerwright.identify(table, input_channel=INPUTS, output_channel=OUTPUTS, unit=units)
    assert isinstance(found, steerwright.MultivariablePlant)
    return found


def test_what_is_no_number_is_refused_with_its_place(plant: steerwright.MultivariablePlant, table: dict[str, np.ndarray]) -> None:
    gap = {name: values.copy() for name, values in table.items()}
    gap["valve"][7:9] = np.nan
    with pytest.raises(steerwright.Error, match="valve is nan at sample 7, and at 1 more places"):
        plant.simulate(gap)
    with pytest.raises(steerwright.Error, match="T1 is inf at sample 3"):
        plant.simulate(table, outputs=np.where(np.arange(1600).reshape(800, 2) == 6, np.inf, 1.0))
    with pytest.raises(steerwright.Error, match="angular frequency"):
        plant.frequency_response([1.0, np.nan])


def test_names_units_and_evidence_are_those_of_the_channels(plant: steerwright.MultivariablePlant, tmp_path: Path) -> None:
    assert isinstance(plant, steerwright.MultivariablePlant)
    assert (plant.input_names, plant.output_names) == (INPUTS, OUTPUTS)
    assert [channel.unit for channel in plant.inputs] == ["W", "1"]
    assert [channel.unit for channel in plant.outputs] == ["degC", "degC"]
    assert plant.delays.tolist() == [0.0, 1.5]
    assert set(plant.fits) == {"T1", "T2"} and min(plant.fits.values()) > 85
    plant.save(tmp_path / "plant.json")
    loaded = steerwright.load(tmp_path / "plant.json")
    assert type(loaded) is type(plant) and loaded.to_json() == plant.to_json()
    assert "T1" in repr(plant) and "degC" not in repr(plant)
    with pytest.raises(steerwright.Error, match="plant/2"):
        steerwright.Plant(plant.to_json())


def test_the_simulation_reproduces_the_stated_fits(
    plant: steerwright.MultivariablePlant, table: dict[str, np.ndarray]
) -> None:
    half = len(table["T1"]) // 2
    part = {name: values[half:] for name, values in table.items()}
    simulated = plant.simulate(part, outputs=part)
    for k, name in enumerate(OUTPUTS):
        y = part[name]
        fit = 100 * (1 - np.linalg.norm(y - simulated[:, k]) / np.linalg.norm(y - y.mean()))
        assert fit == pytest.approx(plant.fits[name], abs=1e-6)
        own = plant.signals.simulated[name][half:]
        assert np.allclose(own, simulated[:, k], atol=1e-6 * y.std())
    assert plant.signals.is_validation[half:].all()


def test_python_control_has_the_names_and_the_response(plant: steerwright.MultivariablePlant) -> None:
    system = plant.to_control()
    assert system.input_labels == INPUTS and system.output_labels == OUTPUTS
    assert system.dt == 0.5
    omega, response = plant.frequency_response([0.05, 0.5, 3.0])
    assert response.shape == (3, 2, 2)
    for w, own in zip(omega, response):
        assert np.allclose(system(np.exp(1j * w * 0.5)), own, rtol=1e-9)
    # The truth at rest.
    _, rest = plant.frequency_response([1e-9])
    truth = np.array([[0.2, -3.0], [0.15, 0.75]])
    errors = np.array([pair.steady_state_gain.standard_error for pair in plant.evidence.pairs]).reshape(2, 2)
    assert (np.abs(rest[0].real - truth) < 3.5 * errors).all()
    with pytest.raises(steerwright.Error, match="delays"):
        plant.to_control(continuous=True)
    continuous = plant.to_control(continuous=True, delay=False)
    assert np.allclose(control.dcgain(continuous), rest[0].real, rtol=1e-6)


def test_tables_and_samples(
    plant: steerwright.MultivariablePlant, table: dict[str, np.ndarray]
) -> None:
    with pytest.raises(steerwright.Error, match="no column 'valve'"):
        plant.simulate({"heater": table["heater"]})
    inputs = np.column_stack([table[name] for name in INPUTS])
    assert np.array_equal(plant.simulate(inputs), plant.simulate(table))
    models = plant.sample(20, seed=1)
    gains = np.array([m.C @ np.linalg.solve(np.eye(plant.order) - m.A, m.B) + m.D for m in models])
    assert (gains.std(axis=0) > 0).all()


def test_its_fmu_has_the_names_and_units_of_the_channels(plant: steerwright.MultivariablePlant, tmp_path: Path) -> None:
    files = steerwright.package(plant, out=tmp_path / "fmu")
    with zipfile.ZipFile(files["MultivariablePlant"]) as archive:
        variables = ElementTree.fromstring(archive.read("modelDescription.xml")).iter("ScalarVariable")
        units = {variable.get("name"): variable[0].get("unit") for variable in variables}
    channels = [(channel.name, channel.unit) for channel in (*plant.inputs, *plant.outputs)]
    assert {name: units[name] for name, _ in channels} == dict(channels)
    assert steerwright.check(files["MultivariablePlant"], run=True).errors == 0


def test_no_controller_is_designed_for_it(plant: steerwright.MultivariablePlant) -> None:
    with pytest.raises(steerwright.Error, match="no steering controller is designed") as caught:
        steerwright.design(plant)
    assert "to_control" in caught.value.hint


def test_plants_are_compared_on_another_log(plant: steerwright.MultivariablePlant, tmp_path: Path) -> None:
    other = tanks(400, 0.1)
    log = tmp_path / "other.csv"
    rows = np.column_stack(list(other.values()))
    header = "time_s,heater[W],valve,T1[degC],T2[degC]"
    np.savetxt(log, rows, delimiter=",", header=header, comments="")
    compared = steerwright.compare(plant, log=str(log))
    (model,) = compared["models"]
    simulated = {output["name"]: output["fit_percent"] for output in model["outputs"]}
    assert set(simulated) == {"T1", "T2"} and min(simulated.values()) > 90, simulated
    with pytest.raises(steerwright.Error, match="has no effect"):
        steerwright.compare(plant, log=str(log), road_speed=10.0)
