"""The same loop in FMPy alone: plant, path and controller stepped one after the other.

python closed_loop_fmpy.py FOLDER_OF_FMUS
"""

import sys

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description

folder, step, stop = sys.argv[1], 0.01, 18.0


class Unit:
    def __init__(self, name):
        archive = f"{folder}/{name}.fmu"
        description = read_model_description(archive)
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.fmu = instantiate_fmu(extract(archive), description, "CoSimulation")
        self.fmu.setupExperiment(startTime=0.0, stopTime=stop)
        self.fmu.enterInitializationMode()

    def get(self, name):
        return self.fmu.getReal([self.references[name]])[0]

    def set(self, name, value):
        self.fmu.setReal([self.references[name]], [value])


plant, path, pid = units = [Unit(name) for name in ("IdentifiedPlant", "ReferencePath", "LateralPid")]
WIRES = [
    (pid, "steering_angle", plant, "steering_angle"),
    (plant, "x", path, "x"),
    (plant, "y", path, "y"),
    (plant, "yaw", path, "yaw"),
    (plant, "yaw", pid, "yaw"),
    (path, "yaw_reference", pid, "yaw_reference"),
    (path, "steering_feedforward", pid, "steering_feedforward"),
]


def connect(receiver):
    for source, output, to, name in WIRES:
        if to is receiver:
            to.set(name, source.get(output))


# During initialization the values travel until they settle.
for _ in range(4):
    for unit in units:
        connect(unit)
for unit in units:
    unit.fmu.exitInitializationMode()

time, yaw = [0.0], [plant.get("yaw")]
for k in range(round(stop / step)):
    for unit in units:
        connect(unit)
        unit.fmu.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
    time.append((k + 1) * step)
    yaw.append(plant.get("yaw"))
for unit in units:
    unit.fmu.terminate()
    unit.fmu.freeInstance()
time, yaw = np.array(time), np.array(yaw)
print(f"largest yaw {np.degrees(abs(yaw).max()):.2f}°")
