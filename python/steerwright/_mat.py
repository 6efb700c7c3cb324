"""Variables of MATLAB's MAT as tables: vectors, matrices, and the structures that tools write."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Any

import numpy as np

Columns = dict[str, Any]


def tables(file: FilePath, variables: dict[str, Any], unread: list[str]) -> list[tuple[str, Columns]]:
    """Vectors of equal length are a table, and so are structures with a clock of their own; all others are unread."""
    found = _Found()
    for name, value in variables.items():
        found.add(name, value)
    unread += found.unread
    named = [(f"{file}: {size} rows", columns) for size, columns in found.by_length.items()]
    for clock, columns in found.with_clock:
        named.append((f"{file}: {', '.join(list(columns)[:3])}", {"time_s": clock, **columns}))
    return named


class _Found:
    def __init__(self) -> None:
        self.by_length: dict[int, Columns] = {}
        self.with_clock: list[tuple[Any, Columns]] = []
        self.unread: list[str] = []

    def add(self, name: str, value: Any) -> None:
        if isinstance(value, dict):
            if not (self._dspace(value) or self._with_time(name, value)):
                for key, item in value.items():
                    self.add(f"{name}.{key}", item)
        elif isinstance(value, list) and any(isinstance(item, dict) for item in value):
            for index, item in enumerate(value):
                self.add(f"{name}.{index + 1}", item)
        else:
            columns = _columns(name, value)
            if not columns:
                self.unread.append(f"{name} ({_kind(value)})")
            for column, values in columns.items():
                self.by_length.setdefault(len(values), {})[column] = values

    def _clocked(self, clock: Any, columns: Columns) -> None:
        for own, others in self.with_clock:
            if np.array_equal(own, clock) and not others.keys() & columns.keys():
                others.update(columns)
                return
        self.with_clock.append((clock, columns))

    def _dspace(self, value: Columns) -> bool:
        """ControlDesk: clocks `X` and signals `Y`, each with Name, Data, Unit; `XIndex` is the clock, from 1."""
        clocks, signals = _list(value.get("X")), _list(value.get("Y"))
        parts = [*clocks, *signals]
        if not clocks or not signals or not all(isinstance(p, dict) and "Data" in p for p in parts):
            return False
        for signal in signals:
            index = int(signal.get("XIndex", 1)) - 1
            clock = _vector(clocks[index]["Data"]) if 0 <= index < len(clocks) else None
            name, values = str(signal.get("Name", "")), _vector(signal["Data"])
            if clock is None or values is None or len(values) != len(clock):
                kind = _kind(signal["Data"])
                self.unread.append(f"{name} ({kind}, its clock has another length)")
            else:
                self._clocked(clock, {_with_unit(name, signal.get("Unit")): values})
        return True

    def _with_time(self, name: str, value: Columns) -> bool:
        """A structure with `t` and `y`, or Simulink's structure with `time` and `signals.values`."""
        clock = _vector(value.get("t", value.get("time")))
        if clock is None:
            return False
        columns: Columns = {}
        if "y" in value:
            columns = _columns(name, value["y"])
        for index, signal in enumerate(_list(value.get("signals"))):
            if isinstance(signal, dict) and "values" in signal:
                label = str(signal.get("label") or "") or f"{name}.{index + 1}"
                columns.update(_columns(label, signal["values"]))
        if not columns or any(len(values) != len(clock) for values in columns.values()):
            return False
        self._clocked(clock, columns)
        return True


def _list(value: Any) -> list[Any]:
    if isinstance(value, np.ndarray):
        return list(value) if value.dtype.kind == "O" else []
    return value if isinstance(value, list) else [] if value is None else [value]


def _vector(value: Any) -> Any:
    """Numbers of a vector, or `None`."""
    columns = _columns("", value)
    return columns.get("")


def _columns(name: str, value: Any) -> Columns:
    """A vector, or the columns of a matrix, `name_1` and so on, whose samples are its longer side."""
    if isinstance(value, (dict, list)) or value is None:
        return {}
    array = np.asarray(value)
    if array.dtype.kind not in "fiub" or array.size < 2:
        return {}
    array = np.squeeze(array)
    if array.ndim == 1:
        return {name: np.ascontiguousarray(array, dtype=np.float64)}
    if array.ndim != 2:
        return {}
    if array.shape[0] < array.shape[1]:
        array = array.T
    return {
        f"{name}_{index + 1}": np.ascontiguousarray(column, dtype=np.float64)
        for index, column in enumerate(array.T)
    }


def _kind(value: Any) -> str:
    array = np.asarray(value)
    if array.dtype.kind in "SU":
        return "text"
    if array.dtype.kind not in "fiub":
        return "no numbers"
    return "one value" if array.size == 1 else f"{' × '.join(map(str, array.shape))} values"


def _with_unit(name: str, unit: Any) -> str:
    unit = str(unit).strip() if isinstance(unit, str) else ""
    return f"{name} [{unit}]" if unit and "[" not in name else name
