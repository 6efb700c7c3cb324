"""FMUs under fmpy, with their variables by name."""

import shutil

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave


class Archive:
    """An archive, unpacked once for many instances."""

    def __init__(self, file):
        self.description = read_model_description(str(file))
        self.folder = extract(str(file))
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.kind = {v.name: v.type for v in self.description.modelVariables}

    def remove(self):
        shutil.rmtree(self.folder, ignore_errors=True)


class Unit:
    """An instance of an FMU."""

    def __init__(self, archive, name):
        self.archive = archive
        self.fmu = FMU2Slave(
            guid=archive.description.guid,
            unzipDirectory=archive.folder,
            modelIdentifier=archive.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)

    def set(self, **values):
        """Variables by name; those of Real in one call."""
        reals = {}
        for name, value in values.items():
            kind, reference = self.archive.kind[name], self.archive.reference[name]
            if kind == "Real":
                reals[reference] = value
            elif kind == "Integer":
                self.fmu.setInteger([reference], [value])
            else:
                self.fmu.setBoolean([reference], [value])
        if reals:
            self.fmu.setReal(list(reals), list(reals.values()))

    def get(self, *names):
        """Real outputs."""
        return self.fmu.getReal([self.archive.reference[name] for name in names])

    def initialize(self):
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, time, size):
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
