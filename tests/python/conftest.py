"""Fixtures: the folder in which `steerwright demo` left its files, named by STEERWRIGHT_OUT, and
the trajectories of the pure functions, which stand in its folder `reference`."""

from __future__ import annotations

import csv
import os
from pathlib import Path
from typing import Callable

import numpy as np
import pytest

LARGEST_DIFFERENCE = 1e-9  # of any variable at any point; units are SI

_reported: list[str] = []


class Reference:
    """A trajectory of the pure functions: a column for each variable, and `time`."""

    def __init__(self, file: Path) -> None:
        with open(file, newline="") as opened:
            header, *rows = csv.reader(opened)
        values = np.array([[float(cell) for cell in row] for row in rows])
        self.columns = dict(zip(header, values.T))
        self.names = header[1:]
        self.step = round(self.columns["time"][1], 9)
        self.steps = len(rows) - 1

    def agrees(
        self,
        importer: str,
        got: dict[str, np.ndarray],
        first: int = 0,
        names: list[str] | None = None,
    ) -> None:
        """Holds an importer's columns against this; `first` is the point their first row is of,
        `names` are the columns to compare where an importer does not show all."""
        worst, where = 0.0, "all"
        for name in names or self.names:
            column = np.asarray(got[name], dtype=float)
            expected = self.columns[name][first:]
            assert len(column) == len(expected), f"{name}: {len(column)} points"
            difference = np.abs(column - expected).max()
            print(f"{importer}: {name}: largest difference {difference:.3e}")
            if not difference <= worst:
                worst, where = difference, name
        count = self.steps + 1 - first
        _reported.append(
            f"{importer}: largest difference to the pure functions, over {count} points: "
            f"{worst:.3e} ({where})"
        )
        assert worst <= LARGEST_DIFFERENCE, _reported[-1]
        # The loop did something.
        assert np.ptp(self.columns["LateralPid.steering_angle"]) > 0.01


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Prints every importer's largest difference, whether its test passed or not."""
    terminalreporter.section("importers")
    for line in _reported:
        terminalreporter.write_line(line)


@pytest.fixture(scope="session")
def out() -> Path:
    """The demo's folder of the multi-body drive."""
    folder = Path(os.environ["STEERWRIGHT_OUT"]) / "multibody"
    assert folder.is_dir(), f"{folder} is missing"
    return folder


@pytest.fixture(scope="session")
def reference(out: Path) -> Callable[[str, str, str], Reference]:
    """The trajectory along a road under a coupling, after an initialization."""

    def read(road: str, coupling: str, initialization: str) -> Reference:
        return Reference(out / "reference" / f"{road}-{coupling}-{initialization}.csv")

    return read


@pytest.fixture(params=["road", "moved"])
def road(request: pytest.FixtureRequest) -> str:
    """The demo's road, which starts at the origin, and the same elsewhere: there an importer that
    sets no start values has only those of the archives."""
    return request.param


@pytest.fixture
def package(out: Path, road: str) -> Path:
    """The loop along a road as SSP."""
    return out / ("fmu" if road == "road" else f"fmu-{road}") / "LateralLoop.ssp"
