"""Closed loops of FMUs of any tool."""

from __future__ import annotations

import contextlib
import csv
import io
import os
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from . import _command
from ._errors import ArgumentError, Missing, path_of, warn
from ._libraries import library
from ._options import documented
from ._record import Array

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .commands import File
    from .options import SimulateOptions


class Simulation(Mapping[str, Array]):
    """The trajectories of a simulation: arrays by ``FMU.variable``, shape (n,).

    A bare variable name works where only one FMU has it.
    """

    def __init__(self, time: Array, values: dict[str, Array], connections: list[str]) -> None:
        self.time = time
        """Time, s, shape (n,)."""
        self.connections = connections
        """What was connected with what."""
        self._values = values

    def __getitem__(self, name: str) -> Array:
        if name in self._values:
            return self._values[name]
        matches = [full for full in self._values if full.split(".", 1)[-1] == name]
        if len(matches) == 1:
            return self._values[matches[0]]
        known = ", ".join(matches or self._values)
        problem = "is ambiguous" if matches else "is no trajectory of the simulation"
        raise Missing(f"{name!r} {problem}", f"the names are {known}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def to_structured(self) -> Any:
        """A structured array with a field ``time``, as FMPy's ``simulate_fmu`` returns it."""
        fields = [("time", np.float64), *((name, np.float64) for name in self._values)]
        result = np.empty(len(self.time), dtype=fields)
        result["time"] = self.time
        for name, values in self._values.items():
            result[name] = values
        return result

    def to_pandas(self) -> Any:
        """A pandas data frame over time."""
        pandas = library("pandas", "to_pandas() uses")
        return pandas.DataFrame(self._values, index=pandas.Index(self.time, name="time"))

    def __repr__(self) -> str:
        end = self.time[-1] if len(self.time) else 0.0
        return f"<Simulation of {end:g} s: {', '.join(self._values)}>"


@documented("simulate")
def simulate(
    fmus: File | Sequence[File],
    *,
    input: Any = None,
    start_values: Mapping[str, Any] | None = None,
    **options: Unpack[SimulateOptions],
) -> Simulation:
    """Simulates FMUs of any tool together, in the order given; or one ``.ssp`` with its connections.

    ``"NAME=FILE.fmu"`` names a unit.

    Outputs and inputs of equal name are connected. ``input`` is a CSV file or a table (a dict of arrays, a data
    frame) with ``time`` and the free inputs, held between rows, of a package also its ``speed``; ``start_values``
    sets parameters and free inputs by ``FMU.variable``, or by the variable's name where one FMU has it. The FMUs run in a process of their own: a crash is an
    :class:`Error`.
    """
    keywords: dict[str, Any] = dict(options)
    files = [fmus] if isinstance(fmus, (str, os.PathLike)) else list(fmus)
    stated = keywords.get("set") or []
    pairs = [stated] if isinstance(stated, str) else stated.items() if isinstance(stated, Mapping) else stated
    settings = [pair.partition("=")[::2] if isinstance(pair, str) else pair for pair in pairs]
    settings += (start_values or {}).items()
    if settings:
        units = _units(files, keywords.get("variant"))
        keywords["set"] = [f"{_full(name.strip(), units)}={_text(value)}" for name, value in settings]
    with _command.folder() as folder:
        if input is not None and not isinstance(input, (str, os.PathLike)):
            from ._tables import columns, listed

            table = columns(input, "input")
            if table.unread:
                warn(f"input: not read: {listed(table.unread)}")
            input = folder / "input.csv"
            with open(input, "w", newline="", encoding="utf-8") as file:
                rows = csv.writer(file)
                # Durations have their unit in the name of the column.
                rows.writerow(name.removesuffix(" [s]") for name in table)
                rows.writerows([repr(float(x)) for x in row] for row in zip(*table.values()))
        out = folder / "result.csv"
        done = _command.run("simulate", files, {**keywords, "input": input, "output": out}).value
        with open(out, encoding="utf-8") as file:
            names = file.readline().rstrip("\n").split(",")
            rows_read = np.loadtxt(file, delimiter=",", ndmin=2)
    values = {name: rows_read[:, k].copy() for k, name in enumerate(names) if k > 0}
    return Simulation(rows_read[:, 0].copy(), values, done["connections"])


def _units(files: Sequence[File], variant: str | None) -> dict[str, set[str]]:
    """The variables of each unit; none of a file that is no FMU, which the program reports."""
    units: dict[str, set[str]] = {}
    for item in files:
        file = path_of(item)
        name, _, rest = file.partition("=")
        if rest and not os.path.exists(file) and not {"/", "\\"} & set(name):
            stated, file = name, rest
        else:
            stated = ""
        with contextlib.suppress(OSError, KeyError, ElementTree.ParseError, zipfile.BadZipFile):
            with zipfile.ZipFile(file) as archive:
                if file.lower().endswith(".ssp"):
                    structure = ElementTree.fromstring(archive.read(f"{variant or 'SystemStructure'}.ssd"))
                    for component in structure.findall(".//{*}Component"):
                        with zipfile.ZipFile(io.BytesIO(archive.read(component.get("source", "")))) as fmu:
                            units[component.get("name", "")] = _variables(fmu)[1]
                else:
                    model, variables = _variables(archive)
                    if not model.strip() or "." in model:
                        model = FilePath(file).stem.replace(".", "_")
                    units[stated or model] = variables
    return units


def _variables(fmu: zipfile.ZipFile) -> tuple[str, set[str]]:
    """The name of a model, and the names of its variables."""
    description = ElementTree.fromstring(fmu.read("modelDescription.xml"))
    variables = description.find("ModelVariables")
    names = () if variables is None else (variable.get("name", "") for variable in variables)
    return description.get("modelName", ""), set(names)


def _full(name: str, units: Mapping[str, set[str]]) -> str:
    """The name with its unit; unchanged where it has one, or where no unit has it, which the program reports."""
    owners = [unit for unit, variables in units.items() if name in variables]
    if name.partition(".")[0] in units or not owners:
        return name
    if len(owners) > 1:
        full = ", ".join(f"{unit}.{name}" for unit in owners)
        raise ArgumentError(f"{name} is a variable of {len(owners)} FMUs", f"name one of {full}")
    return f"{owners[0]}.{name}"


def _text(value: Any) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    return repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)
