"""The closed loop of plant, path and controller, or of any tool's FMUs with such variables.

python closed_loop.py FOLDER_OF_FMUS
"""

import sys

import steerwright

folder = sys.argv[1]
names = ["IdentifiedPlant", "ReferencePath", "LateralPid"]
run = steerwright.simulate([f"{folder}/{name}.fmu" for name in names], stop=18.0)
time, yaw = run.time, run["IdentifiedPlant.yaw"]
print(f"largest cross-track error {abs(run['cross_track_error']).max():.4f} m")
