"""Fixtures: the folder in which `steerwright demo` left its files, named by STEERWRIGHT_OUT."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def out() -> Path:
    """The demo's folder of the multi-body drive."""
    folder = Path(os.environ["STEERWRIGHT_OUT"]) / "multibody"
    assert folder.is_dir(), f"{folder} is missing"
    return folder
