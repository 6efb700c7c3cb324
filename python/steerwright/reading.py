"""Logs: files of any format, and tables in memory."""

from __future__ import annotations

import contextlib
import os
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import datetime, timezone
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from . import _native, _progress
from ._errors import Error, Warning
from ._native import Log
from ._options import documented

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import ReadOptions

Table = Mapping[str, Any]
"""Columns by name: a dict of arrays, or a data frame of pandas, polars or Arrow."""
Source = Union[str, "os.PathLike[str]", Table, Any]
"""A file, or a table."""


@contextlib.contextmanager
def files_and_tables(
    source: Source | Sequence[Source],
) -> Iterator[tuple[list[str] | None, list[tuple[str, dict[str, Any]]] | None]]:
    """The files, or the tables of a source; files that other libraries read are read here."""
    from . import _readers

    sources = list(source) if isinstance(source, (list, tuple)) else [source]
    files: list[str] = []
    tables: list[tuple[str, dict[str, Any]]] = []
    with _native.Scratch() as folder:
        for index, one in enumerate(sources):
            if isinstance(one, (str, os.PathLike)):
                read = _readers.tables(FilePath(one))
                if read is None:
                    # Files of several folders may have one name.
                    own = folder / str(index)
                    own.mkdir()
                    files.append(os.fspath(_readers.converted(FilePath(one), own)))
                else:
                    tables += read
            else:
                name = "table" if len(sources) == 1 else f"table {index + 1}"
                tables.append((name, columns(one)))
        if files and tables:
            raise Error(
                "files and tables are mixed",
                "read the files into tables, or write the tables as files: Parquet, CSV",
            )
        yield (None, tables) if tables else (files, None)


@contextlib.contextmanager
def one_file(source: Source) -> Iterator[tuple[str, FilePath]]:
    """The name of a source, and a file that the command line reads."""
    from . import _readers

    with files_and_tables(source) as (files, tables), _native.Scratch() as folder:
        name = os.fspath(source) if isinstance(source, (str, os.PathLike)) else "table"
        if tables is not None:
            yield name, _readers.as_file(name, tables, folder)
        elif files is not None and len(files) == 1:
            yield name, FilePath(files[0])
        else:
            raise Error("more than one log", "pass one file or table at a time")


def columns(table: Any) -> dict[str, Any]:
    """The numeric columns of a table, float64; missing values are NaN, times are seconds since 1970."""
    if isinstance(table, Mapping):
        named: Iterable[tuple[Any, Any]] = table.items()
    elif hasattr(table, "column_names") and hasattr(table, "column"):
        named = ((name, table.column(name)) for name in table.column_names)
    elif hasattr(table, "columns"):
        named = ((name, table[name]) for name in table.columns)
    elif isinstance(table, np.ndarray) and table.dtype.names:
        named = ((name, table[name]) for name in table.dtype.names)
    else:
        raise TypeError(
            f"a file name, a dict of arrays or a data frame is expected, not {type(table).__name__}"
        )
    found: dict[str, Any] = {}
    for name, values in named:
        _add(found, str(name), _array(values))
    if not found:
        raise Error("the table has no column of numbers", "pass named columns of numbers")
    index = getattr(table, "index", None)
    if index is None or callable(index):
        return found
    array = _array(index)
    name = str(index.name) if getattr(index, "name", None) else "time"
    # An index without a name is numbers of rows, unless it is of times; a column of times is preferred to it.
    is_clock = array.dtype.kind in "Mm" and not any(TIME.search(column) for column in found)
    if name not in found and (getattr(index, "name", None) or is_clock):
        clock: dict[str, Any] = {}
        _add(clock, name, array)
        found = {**clock, **found}
    return found


TIME = re.compile(r"(?i)time|stamp|^t(_|$)")
"""Names of clocks."""
UNIT = re.compile(r"(?i)[_ (\[](s|sec|ms|us|µs|ns)[)\]]?$")
"""The unit of time in a name."""
PER_SECOND = {"s": 1.0, "sec": 1.0, "ms": 1e3, "us": 1e6, "µs": 1e6, "ns": 1e9}


def _add(found: dict[str, Any], name: str, array: Any) -> None:
    """Adds a column of numbers, float64 and contiguous; times in the unit that the name states, by default seconds."""
    if array.dtype.kind in "Mm":
        missing = np.isnat(array)
        kind = "datetime64[ns]" if array.dtype.kind == "M" else "timedelta64[ns]"
        seconds = array.astype(kind).astype(np.int64) * 1e-9
        seconds[missing] = np.nan
        unit = UNIT.search(name)
        array = seconds * (PER_SECOND[unit[1].lower()] if unit else 1.0)
        name = name if unit else f"{name} [s]"
    if array.dtype.kind in "fiub" and array.ndim == 1:
        found[name] = np.ascontiguousarray(array, dtype=np.float64)


def _array(values: Any) -> Any:
    """Numbers, dates or durations; of objects their numbers or dates, if all are such; what is masked is missing."""
    if isinstance(values, np.ma.MaskedArray):
        # None is missing; numbers and dates have a filler, which is replaced.
        array = _array(values.filled(None) if values.dtype.kind == "O" else values.filled())
        masked = np.ma.getmaskarray(values)
        if array.dtype.kind in "Mm":
            array[masked] = "NaT"
        elif array.dtype.kind in "fiub":
            array = np.where(masked, np.nan, array)
        return array
    if getattr(getattr(values, "dtype", None), "tz", None) is not None:
        # Of pandas, which else makes objects of times with a zone.
        return values.to_numpy(dtype="datetime64[ns]")
    array = np.asarray(values.to_numpy() if hasattr(values, "to_numpy") else values)
    if array.dtype.kind == "O":
        with contextlib.suppress(TypeError, ValueError, OverflowError):
            if any(isinstance(item, datetime) for item in array):
                return np.array([_date(item) for item in array], dtype="datetime64[ns]")
            return np.array([_number(item) for item in array], dtype=float)
    return array


def _is_missing(item: Any) -> bool:
    return item is None or type(item).__name__ in ("NAType", "NaTType")


def _date(item: Any) -> Any:
    if _is_missing(item):
        return np.datetime64("NaT")
    if item.tzinfo is not None:
        item = item.astimezone(timezone.utc).replace(tzinfo=None)
    return np.datetime64(item)


def _number(item: Any) -> float:
    return np.nan if _is_missing(item) else float(item)


@documented("read")
def read(source: Source | Sequence[Source], **options: Unpack[ReadOptions]) -> Log:
    """Reads a log: steering angle, yaw rate and, where the log has it, speed, on one grid.

    ``source`` is a file of any format that the command line reads (CSV, MDF, MCAP, Parquet, CAN with ``dbc``), a
    ROS 2 bag in SQLite, a file of those that other libraries read (TDMS, MAT, ROS 1 bags, BLF:
    ``pip install './python[logs]'``), a dict of arrays, a data frame of pandas or polars, an Arrow table; or a
    list of these. Each with steering and yaw rate is a drive, others are channels of one drive. Columns of a
    table are copied.

    Returns a :class:`Log`, whose arrays are read-only views of its memory.

    Raises :class:`Error` with the file, line and column of the fault and a hint.
    """
    with files_and_tables(source) as (files, tables), _progress.shown() as progress:
        log = _native.read(files, tables, dict(options), progress)
    for warning in log.warnings:
        warnings.warn(warning, Warning, stacklevel=2)
    return log
