"""Documentation of options, from the command line's own."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import TypeVar

from . import _native
from ._errors import ArgumentError

F = TypeVar("F", bound=Callable[..., object])

OUTPUTS = {
    "force",
    "json",
    "output",
    "out",
    "traces",
    "plots",
    "report",
    "plot",
    "trajectories",
}
"""Options for files that the command line writes, where a function returns an object instead."""


def refuse_outputs(command: str, options: Mapping[str, object]) -> None:
    """Raises for an option of a file, which a function that returns an object does not write."""
    wrong = sorted(name for name in OUTPUTS & options.keys() if options[name] is not None)
    if wrong:
        raise ArgumentError(
            f"no option `{wrong[0]}` of {command}, which returns an object and writes no file",
            "use the methods of the object, such as save() and figures()",
        )


def in_python(text: str) -> str:
    """A text of the command line with the names of keywords, on one line."""
    text = re.sub(r"--([a-z][a-z-]*)", lambda m: m[1].replace("-", "_"), text)
    return " ".join(text.split())


def lines(command: str, without: set[str] = OUTPUTS) -> list[str]:
    """The options of a subcommand as text, one paragraph each."""
    found = []
    for name, value, values, repeated, default, text in _native.describe(command):
        if name in without:
            continue
        kind = "|".join(values) or value or "True"
        kind += ", repeated in a list" if repeated else ""
        kind += f"; default {default}" if default else ""
        found.append(f"{name.replace('-', '_')}: {kind}\n    {in_python(text)}")
    return found


def documented(command: str, without: set[str] = OUTPUTS) -> Callable[[F], F]:
    """Adds the options of a subcommand to the documentation of a function."""

    def add(function: F) -> F:
        options = "\n".join(lines(command, without))
        function.__doc__ = f"{(function.__doc__ or '').rstrip()}\n\nOptions\n-------\n{options}\n"
        return function

    return add
