"""The package as it is installed: types, options, the command line."""

from __future__ import annotations

import builtins
import json
import re
import subprocess
import sys
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
import steerwright
from conftest import command_line
from steerwright import _generate


def test_options_are_those_of_the_command_line() -> None:
    written = resources.files(steerwright).joinpath("options.py").read_text("utf-8")
    assert written == _generate.module(), "run `cargo xtask wheel --update`"


def test_types_are_those_of_the_native_module() -> None:
    check = [sys.executable, "-m", "mypy.stubtest", "steerwright._native"]
    done = subprocess.run(check, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_the_package_and_these_tests_pass_strict_typing() -> None:
    folder = Path(__file__).parents[1]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", folder / "pyproject.toml", "-p", "steerwright"],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(sys.prefix),
    )
    assert done.returncode == 0, done.stdout


TYPED = """
from pathlib import Path
import steerwright
from steerwright.documents import Grade
from typing_extensions import assert_type
log = steerwright.read("drive.csv", steering_ratio=1)
assert_type(steerwright.identify(log, structure="state-space"), steerwright.Plant)
assert_type(steerwright.identify(log, structure="bicycle", order=2), steerwright.Bicycle)
assert_type(steerwright.identify(log, structure="single-track"), steerwright.Vehicle)
assert_type(steerwright.identify(log, structure="torque"), steerwright.Torque)
plant = steerwright.identify("drive.csv", structure="state-space")
print(plant.A, plant.quality, plant.to_control(), plant.sample(100))
steerwright.design(steerwright.identify(log), max_rate=0.4)
assert_type(steerwright.identify(log, structure="bicycle").quality.grade, Grade)
print(steerwright.identify(log).quality.summary)
assert_type(steerwright.identify(log.steering, log.yaw_rate, 0.01, speed=15.0, structure="bicycle"), steerwright.Bicycle)
log.to_pandas().plot()
steerwright.design(plant, speeds=(5, 30), overshoot=0.05).to_control()
steerwright.export(steerwright.load("plant.json"), "px4")
steerwright.compare([plant], log=Path("drive.csv"))
steerwright.export(plant, "none")  # type: ignore[arg-type]
"""


def test_users_code_passes_strict_typing(tmp_path: Path) -> None:
    root = Path(__file__).parents[2]
    codes = {"typed": TYPED}
    for name in ("README.md", "docs/python.md", "python/README.md"):
        for number, block in enumerate((root / name).read_text("utf-8").split("```python\n")[1:]):
            codes[f"page_{Path(name).parent.name}_{number}"] = block.split("```")[0]
    for file in (root / "python/notebooks").glob("*.ipynb"):
        cells = [cell for cell in json.loads(file.read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]
        codes[file.stem] = "\n".join("".join(cell["source"]) for cell in cells)
    assert len(codes) == 6
    for name, code in codes.items():
        (tmp_path / f"{name}.py").write_text(code, "utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", *(f"{name}.py" for name in codes)],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stdout


def test_the_types_of_options_leave_the_function_of_their_name(tmp_path: Path) -> None:
    code = """
import steerwright
from steerwright.options import ReadOptions
common: ReadOptions = {"input_channel": "steering_command_rad", "steering_ratio": 1.0}
steerwright.options("path")
def log() -> steerwright.Log:
    return steerwright.read("drive.csv", **common)
"""
    (tmp_path / "code.py").write_text(code)
    for arguments in (["code.py"], ["-m", "mypy", "--strict", "code.py"]):
        done = subprocess.run([sys.executable, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


def test_the_command_line_is_there(tmp_path: Path) -> None:
    done = command_line("--version", cwd=tmp_path)
    assert done.stdout.split() == ["steerwright", steerwright.__version__]
    done = command_line("identify", "none.csv", cwd=tmp_path)
    assert done.returncode == 2
    assert "--input-channel" not in done.stderr and "none.csv" in done.stderr


def test_functions_document_their_options() -> None:
    assert "steering_ratio: R\n" in (steerwright.read.__doc__ or "")
    _, options = (steerwright.identify.__doc__ or "").split("-------\n")
    assert "max_order: N; default 8\n" in options
    assert "--" not in options


def test_the_package_was_installed_from_a_wheel() -> None:
    assert Path(steerwright.__file__).is_relative_to(sys.prefix)


def test_the_example_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = Path(__file__).parents[2]
    (tmp_path / "examples").symlink_to(root / "examples")
    (tmp_path / "loop").mkdir()
    monkeypatch.chdir(tmp_path / "loop")
    blocks = (root / "README.md").read_text("utf-8").split("```python\n")[1:]
    (example,) = (block.split("```")[0] for block in blocks)
    names: dict[str, Any] = {}
    exec(example, names)  # noqa: S102
    assert names["controller"].met
    assert abs(names["run"]["cross_track_error"]).max() < 0.05


def test_the_page_on_python_names_what_there_is() -> None:
    page = (Path(__file__).parents[2] / "docs/python.md").read_text("utf-8")
    named = set(re.findall(r"[`.](\w+)\(", page))
    known = {*dir(steerwright), *dir(steerwright.Plant), *dir(steerwright.Accumulator)}
    known |= {*dir(steerwright.Simulation), *dir(steerwright.Sweep), *dir(builtins)}
    assert named and named <= known, named - known
