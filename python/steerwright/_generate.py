"""Writes `options.py`: the options of each function, typed. Run by `cargo xtask wheel --update`."""

from __future__ import annotations

import sys
from typing import Any

from . import _native
from ._options import OUTPUTS, in_python

COMMANDS = {
    "read": OUTPUTS,
    "identify": OUTPUTS,
    "accumulate": OUTPUTS,
    "design": OUTPUTS,
    "path": OUTPUTS,
    "excite": OUTPUTS,
    "inspect": OUTPUTS,
    "package": {"json"},
    "check": {"force", "json"},
    "compare": {"json"},
    "export": {"json", "for"},
    "build": {"json"},
    "sweep": {"json", "serve"},
    "sweep merge": {"json"},
    "simulate": OUTPUTS | {"input"},
}
"""Each function, and the options of the command line that it has not."""

CHOICES = {"identify": "structure"}
"""An option that decides on the type of what a function returns: the others are a class of their own."""

BASES = {"read", "identify", "design"}
"""Those whose options others include."""

HEAD = '''"""The options of each function. Generated from those of the command line by `cargo xtask wheel --update`.

Numbers are in SI units and radians, shares are fractions; texts are as on the command line, such as `"22deg"`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import Any, Literal, TypedDict, Union


class _Callable(ModuleType):
    """This module, which stands in the package where its function `options` was."""

    def __call__(self, command: str) -> None:
        from .commands import options

        options(command)


sys.modules[__name__].__class__ = _Callable

Stack = Literal[STACKS]
"""A driving stack that `export` writes the parameters of."""
Quantity = Union[float, str]
"""A number in SI units, or a text with its unit."""
File = Union[str, "os.PathLike[str]"]
'''

NUMBERS = {
    "TIME",
    "ANGLE",
    "RATE",
    "LENGTH",
    "SPEED",
    "ACCELERATION",
    "JERK",
    "GRADIENT",
    "PER_SECOND",
    "SHARE",
    "GAIN",
    "MARGIN",
}
WHOLE = {"N", "RUNS"}
PLAIN = {"R", "KG", "M", "MU"}
RANGES = {"FROM..TO", "RANGE"}
OBJECTS = {("compare", "pid"), ("path", "pid"), ("path", "plant"), ("path", "speed_controller")}


def kind_of(command: str, name: str, value: str | None, values: list[str], repeated: bool) -> str:
    if value is None:
        return "bool"
    first, *others = value.split("|")
    if (command, name) in OBJECTS:
        kind = "Any"
    elif values:
        kind = f"Literal[{', '.join(repr(item).replace(chr(39), chr(34)) for item in values)}]"
    elif first in NUMBERS:
        kind = "Quantity"
    elif first in WHOLE:
        kind = "Union[int, str]" if others else "int"
    elif first in PLAIN:
        kind = "float"
    elif first in RANGES:
        kind = "Union[tuple[Quantity, Quantity], str]"
    elif "=" in value and repeated:
        return "Union[Mapping[str, Any], Sequence[str], str]"
    elif others and first.islower():
        literals = ", ".join(f'"{item}"' for item in (first, *others))
        kind = f"Union[Literal[{literals}], bool]" if "on" in others else f"Literal[{literals}]"
    elif any(part in value for part in ("FILE", "LOG", "TRACK", "CSV", "TOML", "DIR", "FMU", "SSP", "json", "HTML", "toml", "csv")):
        kind = "File"
    else:
        kind = "str"
    if repeated or first == "RUNS":
        return f"Union[{kind}, Sequence[{kind}]]"
    return kind


def class_of(command: str) -> str:
    return "".join(word.title() for word in reversed(command.split())) + "Options"


def module() -> str:
    stacks = next(value for name, value, *_ in _native.describe("export") if name == "for")
    text = HEAD.replace("STACKS", ", ".join(f'"{stack}"' for stack in (stacks or "").split("|")))
    written: dict[str, set[str]] = {}
    for command, without in COMMANDS.items():
        described = [option for option in _native.describe(command) if option[0] not in without]
        names = {option[0] for option in described}
        bases: list[str] = []
        inherited: set[str] = set()
        for other, known in sorted(written.items(), key=lambda item: -len(item[1])):
            if other not in BASES:
                continue
            if known <= names and not known <= inherited and not known & inherited:
                bases.append(class_of(other))
                inherited |= known
        written[command] = names
        bases = bases or ["TypedDict"]
        choice = CHOICES.get(command)
        if choice:
            text += f"\n\nclass ModelOptions({', '.join(bases)}, total=False):\n"
            text += f'    """The options of `{command}` but for `{choice}`."""\n\n'
            text += fields(command, [o for o in described if o[0] not in {*inherited, choice}])
            bases, inherited = ["ModelOptions"], names - {choice}
        text += f"\n\nclass {class_of(command)}({', '.join(bases)}, total=False):\n"
        text += f'    """The options of `{command}`."""\n\n'
        text += fields(command, [o for o in described if o[0] not in inherited])
    return text


def fields(command: str, described: list[Any]) -> str:
    text = ""
    for name, value, values, repeated, default, help_text in described:
        text += f"    {name.replace('-', '_')}: {kind_of(command, name, value, values, repeated)}\n"
        explained = in_python(help_text).replace("\\", "\\\\")
        explained += f" (default {default})" if default else ""
        text += wrapped(explained.rstrip("."))
    return text


def wrapped(text: str) -> str:
    lines = ['    """']
    for word in text.split(" "):
        if len(lines[-1]) + len(word) > 104:
            lines.append("    ")
        lines[-1] += word if lines[-1].endswith(('"""', "    ")) else f" {word}"
    return "\n".join(lines) + '."""\n'


if __name__ == "__main__":
    sys.stdout.write(module())
