"""The closed loop under fmpy: its FMU2Slave coupled in Python, and its own `simulate_ssp`."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from loop import UNITS, WIRES
from coupling import Unit, Wire, run


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
def test_fmpy_steps_the_loop_of_the_pure_functions(out: Path, reference, coupling: str) -> None:
    expected = reference("road", coupling, "settled")
    units = {name: Unit(out / "fmu" / f"{name}.fmu") for name in UNITS}
    wires = [Wire(units[a], output, units[b], input) for a, output, b, input in WIRES]
    got = run(
        list(units.values()), wires, coupling, expected.steps, expected.step, expected.names
    )
    for unit in units.values():
        unit.close()
    expected.agrees(f"fmpy, FMUs, {coupling}", dict(zip(expected.names, got.T[1:])))


def test_fmpy_runs_the_package(package: Path, road: str, reference) -> None:
    """Reads it against the SSP schema and steps it as Jacobi, with 0 on every connection at first."""
    expected = reference(road, "jacobi", "zeros")
    stop = (expected.steps - 0.5) * expected.step
    result = simulate_ssp(str(package), stop_time=stop, step_size=expected.step)
    columns = {name: result[name] for name in result.dtype.names}
    # Its rows are of the ends of the steps.
    expected.agrees(f"fmpy, SSP, {road}", columns, first=1)


def test_fmpy_drives_the_variant_over_speed(package: Path, road: str, tmp_path: Path) -> None:
    """The variant with the system's connector `speed`, read against the SSP schema as the default."""
    variant = tmp_path / "variant.ssp"
    with zipfile.ZipFile(package) as read, zipfile.ZipFile(variant, "w") as write:
        for name in read.namelist():
            if name != "SystemStructure.ssd":
                target = "SystemStructure.ssd" if name == "SpeedInput.ssd" else name
                write.writestr(target, read.read(name))

    def speed(time: float) -> float:
        return 14.0 + 0.2 * time

    step, stop = 0.01, 5.0
    result = simulate_ssp(
        str(variant), stop_time=stop - step / 2, step_size=step, input={"speed": speed}
    )
    assert len(result) == 500
    expected = [speed(time) for time in result["time"]]
    for name in ("speed", *(f"{unit}.speed" for unit in UNITS)):
        assert np.abs(result[name] - expected).max() < 1e-12, name
    # In the first step its connectors are 0, the position too: the vehicle is on the road from the second on.
    assert np.abs(result["ReferencePath.cross_track_error"][1:]).max() < 0.5, road
    distance = result["ReferencePath.distance"]
    driven = sum(speed(k * step) for k in range(1, 499)) * step
    assert abs(distance[-1] - distance[1] - driven) < 0.5
