"""The closed loop of `loops.rs` in fmpy: one call to set, to step and to read each FMU and step.

Prints the processor's time a loop in ms, instances and all but the extraction of the archives
included. The calls go through fmpy's own functions with arrays made beforehand, which is the
fastest that fmpy offers an importer written in Python.
"""

import ctypes
import sys
import time
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

STEPS, STEP = 2000, 0.01


class Unit:
    """An FMU with its inputs and outputs as C arrays."""

    def __init__(self, archive: Path, inputs: list[str], outputs: list[str]) -> None:
        description = read_model_description(str(archive))
        reference = {v.name: v.valueReference for v in description.modelVariables}
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=extract(str(archive)),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=description.modelName,
        )
        self.reference = reference
        self.takes = (ctypes.c_uint32 * len(inputs))(*(reference[n] for n in inputs))
        self.gives = (ctypes.c_uint32 * len(outputs))(*(reference[n] for n in outputs))
        self.taken = (ctypes.c_double * len(inputs))()
        self.given = (ctypes.c_double * len(outputs))()

    def set(self) -> None:
        self.fmu.fmi2SetReal(self.fmu.component, self.takes, len(self.takes), self.taken)

    def get(self) -> None:
        self.fmu.fmi2GetReal(self.fmu.component, self.gives, len(self.gives), self.given)

    def step(self, now: float) -> None:
        self.fmu.fmi2DoStep(self.fmu.component, now, STEP, 1)


def loop(plant: Unit, path: Unit, pid: Unit, speed: float) -> float:
    """One run; the largest cross-track error in m."""
    for unit in (plant, path, pid):
        unit.fmu.instantiate()
        unit.fmu.setupExperiment(startTime=0.0, stopTime=STEPS * STEP)
        unit.fmu.enterInitializationMode()
    for unit in (plant, path):
        unit.fmu.setReal([unit.reference["speed"]], [speed])

    def pass_on(unit: Unit) -> None:
        if unit is plant:
            plant.taken[0] = pid.given[0]
        elif unit is path:
            path.taken[:] = plant.given[:]
        else:
            pid.taken[0], pid.taken[1], pid.taken[2] = path.given[0], path.given[1], plant.given[2]

    for _ in range(4):
        for unit in (plant, path, pid):
            pass_on(unit)
            unit.set()
            unit.get()
    for unit in (plant, path, pid):
        unit.fmu.exitInitializationMode()
    largest = 0.0
    for k in range(STEPS):
        now = k * STEP
        for unit in (plant, path, pid):
            pass_on(unit)
            unit.set()
            unit.step(now)
            unit.get()
        largest = max(largest, abs(path.given[2]))
    for unit in (plant, path, pid):
        unit.fmu.terminate()
        # Not freeInstance, which unloads the library as well.
        unit.fmu.fmi2FreeInstance(unit.fmu.component)
    return largest


def main() -> None:
    folder, runs = Path(sys.argv[1]), int(sys.argv[2])
    for name in ("IdentifiedPlant", "NonlinearVehicle"):
        plant = Unit(folder / f"{name}.fmu", ["steering_angle"], ["x", "y", "yaw"])
        path = Unit(
            folder / "ReferencePath.fmu",
            ["x", "y", "yaw"],
            ["yaw_reference", "steering_feedforward", "cross_track_error"],
        )
        pid = Unit(
            folder / "LateralPid.fmu",
            ["yaw_reference", "steering_feedforward", "yaw"],
            ["steering_angle"],
        )
        begun = time.process_time()
        largest = max(loop(plant, path, pid, 14.0 + 2.0 * k / runs) for k in range(runs))
        taken = (time.process_time() - begun) / runs * 1e3
        print(f"fmpy, {name}: {taken:.4f} ms of the processor a loop ({runs} loops, at most {largest:.2f} m off)")


main()
