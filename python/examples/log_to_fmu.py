"""From a log to packed FMUs.

python log_to_fmu.py DRIVE.csv FOLDER
"""

import sys

import steerwright

drive, folder = sys.argv[1:]
log = steerwright.read(drive, input_channel="steering_command_rad", steering_ratio=1.0)
plant = steerwright.identify(log)
controller = steerwright.design(plant)
path = steerwright.path(plant=plant, pid=controller, speed=15.0)
fmus = steerwright.package([plant, path, controller], out=folder, ssp="LateralLoop.ssp")
print(plant, controller, *fmus.values(), sep="\n")
