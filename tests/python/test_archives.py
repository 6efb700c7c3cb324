"""fmpy's own checks of every archive that the demo writes."""

from pathlib import Path

import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

ARCHIVES = ["IdentifiedPlant", "BicyclePlant", "LateralPid", "ReferencePath"]


@pytest.mark.parametrize("name", ARCHIVES)
def test_fmpy_finds_no_problem(out: Path, name: str) -> None:
    assert validate_fmu(str(out / "fmu" / f"{name}.fmu")) == []


@pytest.mark.parametrize("name", ARCHIVES)
def test_fmpy_simulates_it_with_its_defaults(out: Path, name: str) -> None:
    result = simulate_fmu(str(out / "fmu" / f"{name}.fmu"), stop_time=1.0)
    assert abs(result["time"][-1] - 1.0) < 1e-9
