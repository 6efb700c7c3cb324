"""FMUs in closed loop: in our host, and in FMPy."""

from __future__ import annotations

import runpy
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
import steerwright
from conftest import command_line

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_a_package_and_its_fmus_give_one_loop(fmus: dict[str, Path], tmp_path: Path) -> None:
    names = ["IdentifiedPlant", "ReferencePath", "LateralPid"]
    run = steerwright.simulate([fmus[name] for name in names], stop=10.0)
    loop = steerwright.simulate(fmus["LateralLoop"], stop=10.0)
    assert run.time[-1] == 10.0
    assert np.abs(run["cross_track_error"]).max() < 0.05
    for name in ("IdentifiedPlant.yaw", "LateralPid.steering_angle"):
        np.testing.assert_array_equal(run[name], loop[name])
    done = command_line("simulate", *(fmus[n] for n in names), "--stop", "10s", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = np.genfromtxt(tmp_path / "result.csv", delimiter=",", names=True, deletechars="")
    np.testing.assert_array_equal(rows["IdentifiedPlant.yaw"], run["yaw"])
    structured = run.to_structured()
    np.testing.assert_array_equal(structured["IdentifiedPlant.x"], run["x"])
    assert run.to_pandas().shape == (len(run.time), len(run))
    with pytest.raises(KeyError, match="ambiguous"):
        run["speed"]


def test_inputs_and_start_values_are_used(fmus: dict[str, Path], plant: steerwright.Plant) -> None:
    time = np.arange(0.0, 3.0, 0.02)
    steering = 0.02 * np.sin(time)
    run = steerwright.simulate(
        fmus["IdentifiedPlant"],
        input={"time": time, "IdentifiedPlant.steering_angle": steering},
        start_values={"IdentifiedPlant.initial_yaw": 0.5},
        stop=2.0,
        step=plant.sample_time,
    )
    assert run["yaw"][0] == 0.5
    from scipy import signal

    # The plant's input is the steering angle without its offset.
    u = steering[: len(run.time)] - plant.operating_point.steering_offset_rad
    _, expected, _ = signal.dlsim(plant.to_scipy(), u)
    expected = expected[:, 0] + plant.operating_point.yaw_rate_offset_radps
    # Both start at rest but for the offset, which the FMU has at its input from the start.
    np.testing.assert_allclose(run["yaw_rate"][60:], expected[60 : len(run.time)], atol=2e-3)


def test_variables_have_short_names_where_they_are_unique(fmus: dict[str, Path], tmp_path: Path) -> None:
    names = ["IdentifiedPlant", "ReferencePath", "LateralPid"]
    files = [fmus[name] for name in names]
    expected = steerwright.simulate(files, start_values={"IdentifiedPlant.initial_y": 0.5}, stop=1.0)
    other = steerwright.simulate(files, stop=1.0)
    assert not np.array_equal(expected["y"], other["y"])
    for fmu, options in (
        (files, {"start_values": {"initial_y": 0.5}}),
        (files, {"set": "initial_y=0.5"}),
        (files, {"set": ["initial_y = 0.5"]}),
        (files, {"set": {"initial_y": 0.5}}),
        (fmus["LateralLoop"], {"start_values": {"initial_y": 0.5}}),
    ):
        found = steerwright.simulate(fmu, **options, stop=1.0)
        np.testing.assert_array_equal(found["IdentifiedPlant.y"], expected["IdentifiedPlant.y"])
    named = steerwright.simulate(f"car={files[0]}", start_values={"initial_yaw": 0.5}, stop=0.1)
    assert named["car.yaw"][0] == 0.5
    with pytest.raises(steerwright.Error, match="speed is a variable of 3 FMUs") as caught:
        steerwright.simulate(files, start_values={"speed": 3.0})
    assert "IdentifiedPlant.speed, ReferencePath.speed, LateralPid.speed" in caught.value.hint
    with pytest.raises(steerwright.Error, match="initial_z"):
        steerwright.simulate(files, start_values={"initial_z": 3.0})
    (tmp_path / "none.fmu").write_bytes(b"")
    with pytest.raises(steerwright.Error, match="none.fmu"):
        steerwright.simulate(tmp_path / "none.fmu", start_values={"initial_z": 3.0})


def test_a_crash_of_an_fmu_is_an_error(fmus: dict[str, Path], tmp_path: Path) -> None:
    # The library of an FMU that aborts where it is instantiated.
    source, library = tmp_path / "abort.c", tmp_path / "abort.so"
    source.write_text(
        "#include <stdlib.h>\n" + "".join(f"void *{name}() {{ abort(); }}\n" for name in FUNCTIONS)
    )
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source], check=True)
    broken = tmp_path / "LateralPid.fmu"
    with zipfile.ZipFile(fmus["LateralPid"]) as whole, zipfile.ZipFile(broken, "w") as archive:
        for name in whole.namelist():
            is_library = name == "binaries/linux64/LateralPid.so"
            archive.writestr(name, library.read_bytes() if is_library else whole.read(name))
    with pytest.raises(steerwright.Error, match="ended with signal SIGABRT"):
        steerwright.simulate(broken)


def test_the_checker_finds_nothing_in_our_archives(fmus: dict[str, Path]) -> None:
    for name in ("IdentifiedPlant", "LateralPid", "ReferencePath"):
        checked = steerwright.check(fmus[name], run=True)
        assert checked.is_clean and checked.warnings == 0, checked


def test_the_examples_agree(fmus: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    folder = str(fmus["LateralPid"].parent)
    results = {}
    for name in ("closed_loop.py", "closed_loop_fmpy.py"):
        monkeypatch.setattr(sys, "argv", [name, folder])
        results[name] = runpy.run_path(str(EXAMPLES / name), run_name="__main__")["yaw"]
    ours, theirs = results.values()
    assert len(ours) == len(theirs) > 500
    np.testing.assert_allclose(ours, theirs, atol=1e-12)


def test_parameters_of_stacks_are_exported(plant: steerwright.Plant, tmp_path: Path) -> None:
    file = tmp_path / "steering.param.yaml"
    found = steerwright.export(plant, "autoware", max_angle=0.5, wheelbase=2.58, output=file)
    values = {parameter["key"]: parameter for parameter in found["parameters"]}
    assert values["steer_lim"]["value"] == 0.5
    delay, lag = values["steer_time_delay"], values["steer_time_constant"]
    # Delay and lag are those of the model at low frequencies, without the half sample for which its input is held.
    omega = np.array([0.05])
    late = -np.angle(plant.frequency_response(omega).response / np.sign(plant.gain))[0] / omega[0]
    late -= plant.sample_time / 2.0
    assert delay["value"] + lag["value"] == pytest.approx(late, rel=0.02)
    assert f"{delay['value']:.4f}"[:5] in file.read_text("utf-8")
    with pytest.raises(steerwright.Error, match="autoware"):
        steerwright.export(plant, "none")


def test_a_sweep_is_summarised_and_resumed(fmus: dict[str, Path], tmp_path: Path) -> None:
    study, results = tmp_path / "study.toml", tmp_path / "results.csv"
    study.write_text(STUDY.format(ssp=fmus["LateralLoop"].as_posix()))
    sweep = steerwright.sweep(study, output=results, threads=2)
    assert sweep.summary["rows"] == 20
    assert len(sweep.to_pandas()) == 20
    assert sweep.to_pandas()["speed"].between(14.0, 16.0).all()
    # The finished rows of an interrupted sweep stay.
    whole = results.read_bytes()
    lines = whole.splitlines(keepends=True)
    results.write_bytes(b"".join(lines[: len(lines) - 7]))
    again = steerwright.sweep(study, output=results, resume=True)
    assert results.read_bytes() == whole
    assert again.summary["resumed"] > 0


STUDY = """\
seed = 1
runs = 20
step_s = 0.01
stop_s = 4.0
ssp = "{ssp}"

[[vary]]
name = "speed"
variables = ["IdentifiedPlant.speed", "ReferencePath.speed"]
distribution = "uniform"
minimum = 14.0
maximum = 16.0

[[metric]]
name = "largest"
variable = "ReferencePath.cross_track_error"
kind = "maximum"
absolute = true
"""

FUNCTIONS = [
    f"fmi2{name}"
    for name in (
        "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment "
        "EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger "
        "GetBoolean GetString SetReal SetInteger SetBoolean SetString GetFMUstate SetFMUstate "
        "FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate "
        "GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives DoStep "
        "CancelStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus"
    ).split()
]
