"""Co-simulation over fmpy's FMU2Slave, Gauss–Seidel or Jacobi.

Written against the FMI 2.0 text and interfaces of the FMUs alone, so that it can disagree with
the Rust host.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave


class Unit:
    """One FMU, with its variables by name."""

    def __init__(self, archive: Path) -> None:
        self.description = read_model_description(str(archive))
        self.name = self.description.modelName
        self.folder = extract(str(archive))
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.kind = {v.name: v.type for v in self.description.modelVariables}
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=self.name,
        )
        self.fmu.instantiate()

    def set(self, name: str, value: float) -> None:
        setter = {
            "Real": self.fmu.setReal,
            "Boolean": self.fmu.setBoolean,
            "Integer": self.fmu.setInteger,
        }
        setter[self.kind[name]]([self.reference[name]], [value])

    def get(self, name: str) -> float:
        getter = {
            "Real": self.fmu.getReal,
            "Boolean": self.fmu.getBoolean,
            "Integer": self.fmu.getInteger,
        }
        return getter[self.kind[name]]([self.reference[name]])[0]

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


@dataclass
class Wire:
    """An output of one unit that feeds an input of another."""

    source: Unit
    output: str
    sink: Unit
    input: str


def run(
    units: list[Unit],
    wires: list[Wire],
    coupling: str,
    steps: int,
    step: float,
    record: list[str],
) -> np.ndarray:
    """Steps `units` in their order; returns time and the recorded variables, a row each point."""
    by_name = {unit.name: unit for unit in units}
    for unit in units:
        unit.fmu.setupExperiment(startTime=0.0)
        unit.fmu.enterInitializationMode()

    def read() -> list[float]:
        return [wire.source.get(wire.output) for wire in wires]

    def feed(sink: Unit, values: list[float]) -> None:
        for wire, value in zip(wires, values):
            if wire.sink is sink:
                sink.set(wire.input, value)

    # No chain of wires is longer than the units are many.
    for _ in range(len(units) + 1):
        for unit in units:
            feed(unit, read())
    for unit in units:
        unit.fmu.exitInitializationMode()

    ports = [column.split(".", 1) for column in record]

    def row(time: float) -> list[float]:
        return [time, *(by_name[unit].get(variable) for unit, variable in ports)]

    rows = [row(0.0)]
    for k in range(steps):
        values = read()
        for unit in units:
            feed(unit, values)
            unit.fmu.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
            if coupling == "gauss_seidel":
                values = read()
        rows.append(row((k + 1) * step))
    return np.array(rows)
