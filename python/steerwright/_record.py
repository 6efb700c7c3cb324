"""Objects of JSON documents with typed attributes."""

from __future__ import annotations

import types
import typing
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import Missing

Array = NDArray[np.float64]

_KINDS: dict[type, dict[str, Any]] = {}
"""The types of the attributes of each class."""


class Record:
    """A JSON object whose keys are attributes. Arrays of numbers are NumPy arrays, which are read-only."""

    __slots__ = ("_read", "_values")

    def __init__(self, values: dict[str, Any]) -> None:
        self._values = values
        self._read: dict[str, Any] = {}

    @classmethod
    def _kinds(cls) -> dict[str, Any]:
        if cls not in _KINDS:
            hints = typing.get_type_hints(cls)
            _KINDS[cls] = {name: kind for name, kind in hints.items() if not name.startswith("_")}
        return _KINDS[cls]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._kinds():
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
        if name not in self._read:
            kind, value = self._kinds()[name], self._values.get(name.rstrip("_"))
            if value is None and type(None) not in typing.get_args(kind) and kind is not Any:
                raise Missing(f"the {type(self).__name__.lower()} has no `{name}`", "identify it from a log")
            self._read[name] = _typed(kind, value)
        return self._read[name]

    def to_dict(self) -> dict[str, Any]:
        """A copy as dicts and lists, as `json` reads it."""
        copied: dict[str, Any] = _copied(self._values)
        return copied

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._kinds()})

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Record):
            return NotImplemented
        return bool(self._values == other._values)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        shown = (f"{name}={_short(getattr(self, name, None))}" for name in self._kinds())
        return f"{type(self).__name__}({', '.join(shown)})"


def _copied(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _copied(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_copied(item) for item in value]
    return value


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"array{value.shape}"
    if isinstance(value, tuple) and len(value) > 3:
        return f"({len(value)} of {type(value[0]).__name__})"
    if isinstance(value, Record):
        return f"{type(value).__name__}(…)"
    return repr(value)


def _typed(kind: Any, value: Any) -> Any:
    if value is None:
        return None
    origin = typing.get_origin(kind)
    if origin in (typing.Union, types.UnionType):
        kind = next(part for part in typing.get_args(kind) if part is not type(None))
        return _typed(kind, value)
    if origin is np.ndarray:
        array = np.array(value, dtype=float)
        array.flags.writeable = False
        return array
    if origin is tuple:
        return tuple(_typed(typing.get_args(kind)[0], item) for item in value)
    if isinstance(kind, type) and issubclass(kind, Record):
        # Points of a path are written as lists in the order of their keys.
        return kind(dict(zip(kind._kinds(), value)) if isinstance(value, list) else value)
    if kind is float:
        return float(value)
    return value
