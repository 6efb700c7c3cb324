"""The loop nested as one FMU by the FMU Manipulation Toolbox, and run by fmpy.

The container initializes its FMUs in their order, each with the outputs of those before it. What
the plant gets from the controller comes too late for that, and no output waits for it.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from loop import UNITS, WIRES


def made(folder: Path, description: str) -> str:
    """Nests FMUs as a description in a folder states."""
    tool = Path(sys.executable).with_name("fmucontainer")
    what = ["-fmu-directory", folder, "-container", description, "-fmi", "2"]
    done = subprocess.run([tool, *what], capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    container = str(folder / "LateralLoop.fmu")
    assert validate_fmu(container) == []
    return container


def columns(container: str, expected) -> dict[str, np.ndarray]:
    """The columns of a reference that a container shows: local variables in lower case."""
    shown = {v.name for v in read_model_description(container).modelVariables}
    names = [name for name in expected.names if name.lower() in shown]
    assert len(names) >= 6, shown
    result = simulate_fmu(
        container,
        stop_time=expected.steps * expected.step,
        step_size=expected.step,
        output_interval=expected.step,
        output=[name.lower() for name in names],
    )
    return {name: result[name.lower()] for name in names}


def test_a_container_of_the_package(package: Path, road: str, reference, tmp_path: Path) -> None:
    """Steps as Jacobi: the tool has a sequential mode and leaves it out for packages."""
    expected = reference(road, "jacobi", "settled")
    # The tool looks for the package in its folder of FMUs.
    shutil.copy(package, tmp_path)
    container = made(tmp_path, f"{package.name}:{expected.step}")
    got = columns(container, expected)
    expected.agrees(f"FMU container of the SSP in fmpy, {road}, jacobi", got, names=list(got))


def test_a_sequential_container(package: Path, road: str, reference, tmp_path: Path) -> None:
    """Steps as Gauss–Seidel, from the package's FMUs and a description of the tool's own."""
    expected = reference(road, "gauss_seidel", "settled")
    with zipfile.ZipFile(package) as archive:
        for unit in UNITS:
            (tmp_path / f"{unit}.fmu").write_bytes(archive.read(f"resources/{unit}.fmu"))
    description = {
        "name": "LateralLoop.fmu",
        "sequential": True,
        "auto_link": False,
        "auto_input": False,
        "auto_output": False,
        "auto_parameter": False,
        "step_size": expected.step,
        "fmu": [f"{unit}.fmu" for unit in UNITS],
        "link": [[f"{a}.fmu", output, f"{b}.fmu", input] for a, output, b, input in WIRES],
    }
    (tmp_path / "loop.json").write_text(json.dumps(description))
    got = columns(made(tmp_path, "loop.json"), expected)
    expected.agrees(f"FMU container in fmpy, {road}, gauss_seidel", got, names=list(got))
