"""Fixtures: the recorded drive of examples/drives, its model and controller, and the command line of the wheel."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import steerwright

DATA = Path(__file__).parents[2] / "examples/drives"
DRIVE = DATA / "multibody/drive.csv"
COLUMNS = {"input_channel": "steering_command_rad", "steering_ratio": 1.0}


def command_line(*arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """The program that the wheel installs."""
    program = Path(sys.executable).with_name("steerwright")
    words = [str(program), *(str(argument) for argument in arguments)]
    return subprocess.run(words, cwd=cwd, capture_output=True, text=True, check=False)


@pytest.fixture(scope="session")
def log() -> steerwright.Log:
    return steerwright.read(DRIVE, **COLUMNS)


@pytest.fixture(scope="session")
def plant(log: steerwright.Log) -> steerwright.Plant:
    found = steerwright.identify(log)
    assert isinstance(found, steerwright.Plant)
    return found


@pytest.fixture(scope="session")
def controller(plant: steerwright.Plant) -> steerwright.Controller:
    return steerwright.design(plant)


@pytest.fixture(scope="session")
def fmus(
    plant: steerwright.Plant,
    controller: steerwright.Controller,
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[str, Path]:
    path = steerwright.path(plant=plant, pid=controller, speed=15.0)
    out = tmp_path_factory.mktemp("fmu")
    return steerwright.package([plant, path, controller], out=out, ssp="LateralLoop.ssp")
