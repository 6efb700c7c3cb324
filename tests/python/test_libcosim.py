"""The closed loop under libcosim, from the archives and from the package."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from fmpy import read_model_description
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
from loop import UNITS, WIRES

log_output_level(CosimLogLevel.WARNING)


class Variables:
    """Value references and types by `instance.variable`, from the archives of the demo."""

    def __init__(self, out: Path) -> None:
        self.reference: dict[str, int] = {}
        self.boolean: set[str] = set()
        for unit in UNITS:
            for v in read_model_description(str(out / "fmu" / f"{unit}.fmu")).modelVariables:
                self.reference[f"{unit}.{v.name}"] = v.valueReference
                if v.type == "Boolean":
                    self.boolean.add(f"{unit}.{v.name}")


def run(execution: CosimExecution, variables: Variables, expected) -> dict[str, np.ndarray]:
    """Steps an execution and reads the columns of a reference from its last-value observer."""
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    index = {unit: execution.slave_index_from_instance_name(unit) for unit in UNITS}
    real = [name for name in expected.names if name not in variables.boolean]
    boolean = [name for name in expected.names if name in variables.boolean]

    def row() -> list[float]:
        values = {}
        for names, read in (
            (real, observer.last_real_values),
            (boolean, observer.last_boolean_values),
        ):
            for unit in UNITS:
                own = [name for name in names if name.startswith(f"{unit}.")]
                if own:
                    got = read(index[unit], [variables.reference[name] for name in own])
                    values.update(zip(own, got))
        return [float(values[name]) for name in expected.names]

    rows = []
    for _ in range(expected.steps):
        assert execution.step()
        rows.append(row())
    return dict(zip(expected.names, np.array(rows).T))


def test_libcosim_runs_the_archives(out: Path, reference) -> None:
    expected = reference("road", "jacobi", "settled")
    variables = Variables(out)
    nanoseconds = round(expected.step * 1e9)
    execution = CosimExecution.from_step_size(nanoseconds)
    # The slaves have to outlive the execution.
    slaves = [CosimLocalSlave(str(out / "fmu" / f"{unit}.fmu"), unit) for unit in UNITS]
    index = {unit: execution.add_local_slave(slave) for unit, slave in zip(UNITS, slaves)}
    for source, output, sink, input in WIRES:
        from_, to = variables.reference[f"{source}.{output}"], variables.reference[f"{sink}.{input}"]
        assert execution.connect_real_variables(index[source], from_, index[sink], to) == 0
    columns = run(execution, variables, expected)
    expected.agrees("libcosim, FMUs", columns, first=1)


def test_libcosim_runs_the_package(out: Path, package: Path, road: str, reference) -> None:
    expected = reference(road, "jacobi", "settled")
    execution = CosimExecution.from_ssp_file(str(package))
    columns = run(execution, Variables(out), expected)
    expected.agrees(f"libcosim, SSP, {road}", columns, first=1)
