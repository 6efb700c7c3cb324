"""The closed loop under fmpy: its FMU2Slave by a master in Python, and its own `simulate_ssp`."""

from pathlib import Path

import pytest
from fmpy.ssp.simulation import simulate_ssp
from loop import UNITS, WIRES
from master import Unit, Wire, run


@pytest.mark.parametrize("master", ["gauss_seidel", "jacobi"])
def test_fmpy_steps_the_loop_of_the_pure_functions(out: Path, reference, master: str) -> None:
    expected = reference("road", master, "settled")
    units = {name: Unit(out / "fmu" / f"{name}.fmu") for name in UNITS}
    wires = [Wire(units[a], output, units[b], input) for a, output, b, input in WIRES]
    got = run(
        list(units.values()), wires, master, expected.steps, expected.step, expected.names
    )
    for unit in units.values():
        unit.close()
    expected.agrees(f"fmpy, FMUs, {master}", dict(zip(expected.names, got.T[1:])))


def test_fmpy_runs_the_package(package: Path, road: str, reference) -> None:
    """Reads it against the SSP schema and steps it as Jacobi, with 0 on every connection at first."""
    expected = reference(road, "jacobi", "zeros")
    stop = (expected.steps - 0.5) * expected.step
    result = simulate_ssp(str(package), stop_time=stop, step_size=expected.step)
    columns = {name: result[name] for name in result.dtype.names}
    # Its rows are of the ends of the steps.
    expected.agrees(f"fmpy, SSP, {road}", columns, first=1)
