"""FMUs under fmpy, with their variables by name."""

import shutil
from ctypes import c_double, c_int, c_uint

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

    def writer(self, *names):
        """Sets these Reals, or these Integers, each sample: `write(values)`.

        fmpy would make new arrays with each call, which costs more than the FMU's own step.
        """
        integer = self.archive.kind[names[0]] == "Integer"
        call = self.fmu.fmi2SetInteger if integer else self.fmu.fmi2SetReal
        references, count, values = self._buffers(names, c_int if integer else c_double)
        component = self.fmu.component

        def write(*given):
            values[:] = given
            call(component, references, count, values)

        return write

    def reader(self, *names):
        """Reads these Reals each sample."""
        call, component = self.fmu.fmi2GetReal, self.fmu.component
        references, count, values = self._buffers(names, c_double)

        def read():
            call(component, references, count, values)
            return values[:]

        return read

    def _buffers(self, names, kind):
        references = [self.archive.reference[name] for name in names]
        return (c_uint * len(names))(*references), len(names), (kind * len(names))()

    def initialize(self):
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, time, size):
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
