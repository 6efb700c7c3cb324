"""From a recorded drive to steering FMUs that can be trusted.

>>> import steerwright
>>> log = steerwright.read("drive.csv")
>>> plant = steerwright.identify(log)
>>> controller = steerwright.design(plant)
>>> steerwright.package([plant, controller, steerwright.path(speed=15.0)], out="fmu")

Each function has the options of the subcommand of its name, with underscores; :func:`options` lists them with
defaults and units. Numbers are in SI units and radians, shares are fractions (0.02 is 2 %); texts are as on
the command line (``"22deg"``, ``"2%"``). Signs follow ISO 8855: yaw rate and steering are positive to the left.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from ._native import __version__

if TYPE_CHECKING:
    from ._errors import Error, Warning
    from ._native import Log, Traces
    from .accumulator import Accumulator
    from .commands import (
        Manoeuvre,
        Path,
        Sweep,
        build,
        check,
        compare,
        excite,
        export,
        inspect,
        load,
        merge_sweep,
        options,
        package,
        path,
        sweep,
    )
    from .controller import Controller, SpeedController, design

    from .identification import identify, identify_bicycle
    from .plant import Bicycle, Longitudinal, MultivariablePlant, Plant, Torque, Vehicle
    from .reading import read
    from .simulation import Simulation, simulate

# Loaded when they are used: the command line, which starts this package too, needs none of them.
_MODULES = {
    "Error": "_errors",
    "Warning": "_errors",
    "Log": "_native",
    "Traces": "_native",
    "Accumulator": "accumulator",
    "Sweep": "commands",
    "build": "commands",
    "check": "commands",
    "compare": "commands",
    "excite": "commands",
    "export": "commands",
    "inspect": "commands",
    "load": "commands",
    "merge_sweep": "commands",
    "options": "commands",
    "package": "commands",
    "path": "commands",
    "sweep": "commands",
    "Controller": "controller",
    "SpeedController": "controller",
    "design": "controller",
    "Manoeuvre": "commands",
    "Path": "commands",
    "identify": "identification",
    "identify_bicycle": "identification",
    "Bicycle": "plant",
    "Longitudinal": "plant",
    "MultivariablePlant": "plant",
    "Torque": "plant",
    "Vehicle": "plant",
    "Plant": "plant",
    "read": "reading",
    "Simulation": "simulation",
    "simulate": "simulation",
}

__all__ = [
    "Accumulator",
    "Bicycle",
    "Controller",
    "Error",
    "Log",
    "Path",
    "Plant",
    "Longitudinal",
    "Manoeuvre",
    "MultivariablePlant",
    "Simulation",
    "SpeedController",
    "Sweep",
    "Torque",
    "Traces",
    "Vehicle",
    "Warning",
    "__version__",
    "build",
    "check",
    "compare",
    "design",
    "excite",
    "export",
    "identify",
    "identify_bicycle",
    "inspect",
    "load",
    "merge_sweep",
    "options",
    "package",
    "path",
    "read",
    "simulate",
    "sweep",
]


if not TYPE_CHECKING:

    def __getattr__(name):
        if name not in _MODULES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        module = importlib.import_module(f".{_MODULES[name]}", __name__)
        value = getattr(module, name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted(__all__)
