"""Optional packages: a hint where one is missing, and never a folder of the caller that has its name."""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
import sys
from importlib.machinery import PathFinder
from typing import Any

from ._errors import Error

PACKAGES = {"can": "python-can"}
"""Packages by their modules, where the names differ."""
EXTRAS = {
    "logs": ("nptdms", "h5py", "rosbags", "can", "scipy"),
    "control": ("control",),
    "dask": ("distributed",),
    "notebook": ("pandas", "tqdm"),
}
"""What the package has extras for."""

_ISOLATED: dict[str, Any] = {}


def library(name: str, purpose: str) -> Any:
    """A module of another package; ``purpose`` stands before its name in the message if it is missing."""
    top = name.partition(".")[0]
    package = PACKAGES.get(top, top)
    try:
        if top == "openpilot":
            # In no package index.
            return importlib.import_module(name)
        installed = str(importlib.metadata.distribution(package).locate_file(""))
        own, other = PathFinder.find_spec(top, [installed]), importlib.util.find_spec(top)
        if own is None or other is None or own.origin == other.origin:
            return importlib.import_module(name)
        if name not in _ISOLATED:
            _ISOLATED[name] = _isolated(name, installed)
        return _ISOLATED[name]
    except (ImportError, ValueError) as error:
        if top == "openpilot":
            hint = "run this where openpilot is on the path of Python"
        else:
            extra = next((extra for extra, modules in EXTRAS.items() if top in modules), None)
            hint = f"pip install {package}" + (f", or pip install './python[{extra}]' from a clone" if extra else "")
        raise Error(f"{purpose} {package}, which is not installed", hint) from error


def _isolated(name: str, installed: str) -> Any:
    """A module of the installed package, while another one of its name comes first on the path: the name stays
    that of the other, the modules of the package are found by it."""
    top = name.partition(".")[0]
    others = {key: module for key, module in sys.modules.items() if key.partition(".")[0] == top}
    for key in others:
        del sys.modules[key]
    sys.path.insert(0, installed)
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(installed)
        sys.modules.pop(top, None)
        sys.modules.update(others)
