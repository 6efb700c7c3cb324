"""Logs: files of any format, and tables in memory."""

from __future__ import annotations

import contextlib
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
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
                    files.append(os.fspath(_readers.converted(FilePath(one), folder)))
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
    found = {}
    for name, values in named:
        array = _numbers(values)
        if array is not None:
            found[str(name)] = array
    if not found:
        raise Error("the table has no column of numbers", "pass named columns of numbers")
    index = getattr(table, "index", None)
    if index is not None and getattr(index, "name", None) and not callable(index):
        array = _numbers(index)
        if array is not None and str(index.name) not in found:
            found = {str(index.name): array, **found}
    return found


def _numbers(values: Any) -> Any:
    """One-dimensional float64, contiguous; `None` for what is no number or time."""
    array = np.asarray(values.to_numpy() if hasattr(values, "to_numpy") else values)
    masked = np.ma.getmaskarray(values) if isinstance(values, np.ma.MaskedArray) else None
    if array.dtype.kind == "M":
        missing = np.isnat(array)
        array = array.astype("datetime64[ns]").astype(np.int64) * 1e-9
        array[missing] = np.nan
    elif array.dtype.kind == "m":
        array = array / np.timedelta64(1, "s")
    if array.dtype.kind == "O":
        try:
            array = np.array([_number(item) for item in array], dtype=float)
        except (TypeError, ValueError):
            return None
    if array.dtype.kind not in "fiub" or array.ndim != 1:
        return None
    array = np.ascontiguousarray(array, dtype=np.float64)
    return array if masked is None else np.where(masked, np.nan, array)


def _number(item: Any) -> float:
    return np.nan if item is None or type(item).__name__ in ("NAType", "NaTType") else float(item)


@documented("read")
def read(source: Source | Sequence[Source], **options: Unpack[ReadOptions]) -> Log:
    """Reads a log: steering angle, yaw rate and, where the log has it, speed, on one grid.

    ``source`` is a file of any format that the command line reads (CSV, MDF, MCAP, Parquet, CAN with ``dbc``), of
    those that other libraries read (TDMS, MAT, ROS 1 bags, ``.db3``, BLF: ``pip install steerwright[logs]``), a
    dict of arrays, a data frame of pandas or polars, an Arrow table; or a list of these. Each with steering
    and yaw rate is a drive, others are channels of one drive. Columns of a table are copied.

    Returns a :class:`Log`, whose arrays are read-only views of its memory.

    Raises :class:`Error` with the file, line and column of the fault and a hint.
    """
    with files_and_tables(source) as (files, tables), _progress.shown() as progress:
        log = _native.read(files, tables, dict(options), progress)
    for warning in log.warnings:
        warnings.warn(warning, Warning, stacklevel=2)
    return log
