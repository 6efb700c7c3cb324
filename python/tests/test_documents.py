"""The documents of the package and those of its command line are the same bytes."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
import steerwright
from conftest import COLUMNS, DRIVE, command_line

OPTIONS = ["--input-channel", "steering_command_rad", "--steering-ratio", "1"]


def ok(*arguments: object, cwd: Path) -> None:
    done = command_line(*arguments, cwd=cwd)
    assert done.returncode == 0, done.stderr


@pytest.mark.filterwarnings("ignore::steerwright.Warning")
def test_documents_are_those_of_the_command_line(tmp_path: Path) -> None:
    for options in (["--order", "2"], ["--delay", "20ms", "--validation-fraction", "30%"]):
        ok("identify", DRIVE, *OPTIONS, *options, "-o", "plant.json", cwd=tmp_path)
        keywords = {"order": 2} if "--order" in options else {"delay": 0.02, "validation_fraction": 0.3}
        plant = steerwright.identify(DRIVE, **COLUMNS, **keywords)
        assert plant.to_json() == (tmp_path / "plant.json").read_text("utf-8")
    ok("design", "plant.json", "--overshoot", "2%", "--max-angle", "20deg", cwd=tmp_path)
    controller = steerwright.design(plant, overshoot=0.02, max_angle=np.deg2rad(20.0))
    assert controller.to_json() == (tmp_path / "pid.json").read_text("utf-8")
    ok("path", "--pid", "pid.json", "--plant", "plant.json", "--speed", "12m/s", cwd=tmp_path)
    path = steerwright.path(pid=controller, plant=plant, speed=12.0)
    assert path.to_json() == (tmp_path / "path.json").read_text("utf-8")


def test_a_bicycle_is_that_of_the_command_line(tmp_path: Path) -> None:
    options = ["--structure", "bicycle", "--wheelbase", "2.58"]
    ok("identify", DRIVE, *OPTIONS[:2], *options, "-o", "bicycle.json", cwd=tmp_path)
    bicycle = steerwright.identify_bicycle(DRIVE, input_channel="steering_command_rad", wheelbase=2.58)
    assert bicycle.to_json() == (tmp_path / "bicycle.json").read_text("utf-8")
    assert isinstance(bicycle, steerwright.Bicycle)


def test_a_manoeuvre_is_that_of_the_command_line(tmp_path: Path) -> None:
    sheet = DRIVE.parent / "vehicle.toml"
    limits = ["--time", "40s", "--band", "0.3..1.5Hz", "--max-angle", "4deg", "--by", "driver"]
    ok("excite", sheet, *limits, cwd=tmp_path)
    manoeuvre = steerwright.excite(sheet, time=40.0, band=(0.3, 1.5), max_angle=np.deg2rad(4.0), by="driver")
    folder = tmp_path / "excitation"
    assert manoeuvre.to_json() == (folder / "excitation.json").read_text("utf-8")
    rows = np.genfromtxt(folder / "excitation.csv", delimiter=",", names=True)
    steered = manoeuvre.to_numpy()
    assert steered.dtype.names == rows.dtype.names
    for name, digits in (("time_s", 1e-4), ("steering_rad", 1e-7), ("speed_mps", 1e-3)):
        assert np.abs(rows[name] - steered[name]).max() <= digits
    assert isinstance(steerwright.load(folder / "excitation.json"), steerwright.Manoeuvre)
    assert "of 40 s" in repr(manoeuvre) and manoeuvre.goal == "response"


def test_the_goals_of_a_manoeuvre_are_those_of_the_command_line(tmp_path: Path) -> None:
    sheet = DRIVE.parent / "vehicle.toml"
    options = ["--goal", "understeer", "--time", "80s", "--understeer-error", "0.002rad.s2/m"]
    ok("excite", sheet, *options, cwd=tmp_path)
    manoeuvre = steerwright.excite(sheet, goal="understeer", time=80.0, understeer_error=0.002)
    assert manoeuvre.to_json() == (tmp_path / "excitation" / "excitation.json").read_text("utf-8")
    assert manoeuvre.goal == "understeer" and "understeer gradient to" in repr(manoeuvre)


def test_an_accumulator_is_that_of_the_command_line(tmp_path: Path) -> None:
    head, *rows = DRIVE.read_text("utf-8").splitlines(keepends=True)
    files = [tmp_path / f"{number}.csv" for number in range(2)]
    for file, part in zip(files, (rows[:5000], rows[5000:])):
        file.write_text(head + "".join(part))
    accumulator = steerwright.Accumulator(horizon=20, **COLUMNS)
    for number, file in enumerate(files):
        options = [*OPTIONS, "--horizon", "20", "-o", f"{number}.rfactor"]
        ok("accumulate", file, *options, cwd=tmp_path)
        one = steerwright.Accumulator(horizon=20, **COLUMNS).add(file)
        assert one.to_json() == (tmp_path / f"{number}.rfactor").read_text("utf-8")
        accumulator.merge(one)
    done = command_line("identify", "0.rfactor", "1.rfactor", "-o", "plant.json", cwd=tmp_path)
    assert done.returncode in (0, 1), done.stderr
    plant = steerwright.identify(accumulator)
    assert plant.to_json() == (tmp_path / "plant.json").read_text("utf-8")
    accumulator.save(tmp_path / "both.rfactor")
    again = steerwright.Accumulator.load(tmp_path / "both.rfactor")
    assert again.to_json() == accumulator.to_json()
    assert again.samples == accumulator.samples > 4000
    assert pickle.loads(pickle.dumps(accumulator)).to_json() == accumulator.to_json()
    assert "empty" in repr(pickle.loads(pickle.dumps(steerwright.Accumulator(horizon=20))))


def test_documents_survive_saving_and_loading(plant: steerwright.Plant, tmp_path: Path) -> None:
    plant.save(tmp_path / "plant.json")
    again = steerwright.Plant.load(tmp_path / "plant.json")
    assert again.to_json() == plant.to_json()
    assert again == plant
    assert again.traces is None
    copied = pickle.loads(pickle.dumps(plant))
    assert copied == plant and copied.traces is None
    np.testing.assert_array_equal(copy.deepcopy(plant).A, plant.A)
    with pytest.raises(steerwright.Error, match="not that of a bicycle"):
        steerwright.Bicycle.load(tmp_path / "plant.json")


def test_a_table_gives_the_same_model_as_its_file(plant: steerwright.Plant) -> None:
    rows = np.genfromtxt(DRIVE, delimiter=",", names=True, comments="#")
    table = {name: rows[name].copy() for name in rows.dtype.names}
    before = {name: values.copy() for name, values in table.items()}
    again = steerwright.identify(table, **COLUMNS)
    np.testing.assert_array_equal(again.A, plant.A)
    assert again.fit == plant.fit
    for name, values in table.items():
        np.testing.assert_array_equal(values, before[name])
    # The source states what was read, and that it was no file.
    (source,) = again.provenance.sources
    assert source.of_samples is not None
