"""Logs: files of any format, and tables in memory."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, NamedTuple, Union

from . import _native, _progress
from ._errors import Error, warn
from ._libraries import library
from ._native import Log
from ._options import documented
from ._tables import Columns, columns, listed

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import ReadOptions

Table = Mapping[str, Any]
"""Columns by name: a dict of arrays, or a data frame of pandas, polars or Arrow."""
Source = Union[str, "os.PathLike[str]", Table, Any]
"""A file, or a table."""
Tables = list[tuple[str, dict[str, Any]]]


class Sources(NamedTuple):
    files: list[str] | None
    tables: Tables | None
    names: dict[str, str]
    """The names of the caller's files by those of converted ones."""
    unread: list[str]
    """What is left out of tables and of files that other libraries read, with the reason."""

    def named(self, text: str) -> str:
        """A message with the names of the caller's files."""
        for file, name in self.names.items():
            text = text.replace(file, name)
        return text


@contextlib.contextmanager
def files_and_tables(source: Source | Sequence[Source], options: Mapping[str, Any]) -> Iterator[Sources]:
    """The files, or the tables of a source; files that other libraries read are read here."""
    from . import _readers

    is_clock_stated = options.get("time_channel") is not None or options.get("row_period") is not None
    sources = list(source) if isinstance(source, (list, tuple)) else [source]
    files: list[str] = []
    tables: Tables = []
    names: dict[str, str] = {}
    unread: list[str] = []
    with _native.Scratch() as folder:
        for index, one in enumerate(sources):
            items: list[str] = []
            if isinstance(one, (str, os.PathLike)):
                name = os.fspath(one)
                read = _readers.tables(FilePath(one), items)
                if read is None:
                    # Files of several folders may have one name.
                    own = folder / str(index)
                    own.mkdir()
                    files.append(os.fspath(_readers.converted(FilePath(one), own)))
                    names[files[-1]] = name
                else:
                    tables += read
            else:
                name = "table" if len(sources) == 1 else f"table {index + 1}"
                table = columns(one, name, is_clock_stated=is_clock_stated)
                items = table.unread
                tables.append((name, table))
            if items:
                warn(f"{name}: not read: {listed(items)}")
                unread += (f"{name}: not read: {item}" for item in items)
        if files and tables:
            raise Error(
                "files and tables are mixed",
                "read the files into tables, or write the tables as files: Parquet, CSV",
            )
        found = Sources(None if tables else files, tables or None, names, unread)
        try:
            yield found
        except Error as error:
            error.message = found.named(error.message)
            raise


@contextlib.contextmanager
def one_file(source: Source, options: Mapping[str, Any]) -> Iterator[tuple[str, FilePath, list[str]]]:
    """The name of a source, a file that the command line reads, and what is not in it."""
    from . import _readers

    with files_and_tables(source, options) as found, _native.Scratch() as folder:
        name = os.fspath(source) if isinstance(source, (str, os.PathLike)) else "table"
        if found.tables is not None:
            yield name, _readers.as_file(name, found.tables, folder), found.unread
        elif found.files is not None and len(found.files) == 1:
            yield name, FilePath(found.files[0]), found.unread
        else:
            raise Error("more than one log", "pass one file or table at a time")


@documented("read")
def read(source: Source | Sequence[Source], **options: Unpack[ReadOptions]) -> Log:
    """Reads a log: steering angle, yaw rate and, where the log has it, speed, on one grid.

    ``source`` is a file of any format that the command line reads (CSV, MDF, MCAP, Parquet, CAN with ``dbc``), a
    ROS 2 bag in SQLite, a log of PX4 or ArduPilot, a file of those that other libraries read (TDMS, MAT, ROS 1 bags, BLF:
    ``pip install './python[logs]'``), a dict of arrays, a data frame of pandas or polars, an Arrow table; or a
    list of these. Each with steering and yaw rate is a drive, others are channels of one drive. Columns of a
    table are copied.

    Returns a :class:`Log`, whose arrays are read-only views of its memory.

    Raises :class:`Error` with the file, line and column of the fault and a hint.
    """
    with files_and_tables(source, options) as found, _progress.shown() as progress:
        log = _native.read(found.files, found.tables, dict(options), progress)
    refuse_booleans(log.channels, found.tables)
    for warning in log.warnings:
        warn(found.named(warning))
    return log


def accumulate(
    drives: _native.Drives,
    source: Source | Sequence[Source],
    options: Mapping[str, Any],
    progress: _progress.Progress | None,
) -> None:
    """Adds a source to the drives that are accumulated."""
    with files_and_tables(source, options) as found:
        added = _native.Drives()
        added.add(found.files, found.tables, dict(options), progress)
    channels = json.loads(added.json())["channels"]
    refuse_booleans([(c["role"], c["column"]) for c in channels], found.tables)
    drives.merge(added)


def refuse_booleans(channels: Iterable[Sequence[Any]], tables: Tables | None) -> None:
    """Raises for a signal that is True or False."""
    booleans = {name for _, table in tables or () if isinstance(table, Columns) for name in table.booleans}
    for role, column, *_ in channels:
        if column in booleans and role not in SWITCHES:
            raise Error(
                f"{column}: the {role.replace('_', ' ')} is True or False in every row, and numbers are expected",
                "name the column of the signal, such as output_channel=NAME",
            )


SWITCHES = {"engaged", "override"}
"""Roles of channels that are on or off."""


def frame(log: Log) -> Any:
    """A log as a data frame of pandas, with names that :func:`read` knows."""
    pandas = library("pandas", "to_pandas() uses")
    signals = {"steering_angle_rad": log.steering, "yaw_rate_radps": log.yaw_rate}
    if log.speed is not None:
        signals["speed_mps"] = log.speed
    return pandas.DataFrame(signals, index=pandas.Index(log.time, name="time_s"))
