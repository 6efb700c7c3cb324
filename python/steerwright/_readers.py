"""Formats that other libraries read, as tables: a format is a function in `READERS`.

The libraries come with ``pip install './python[logs]'`` from a clone.
"""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Callable, Iterator
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from . import _autopilots, _mat, _mdf, _ros
from ._errors import Error, warn
from ._libraries import library
from ._tables import MOST_QUOTED, Columns, listed

Tables = list[tuple[str, dict[str, Any]]]


def converted(file: FilePath, folder: FilePath) -> FilePath:
    """The file, or one in the folder that the package reads itself."""
    if file.is_dir():
        files = sorted(own for own in file.iterdir() if own.name.endswith((".db3", *ZSTANDARD)))
        return _read(sqlite, file, files, folder) if files and not any(file.glob("*.mcap*")) else file
    if file.name.endswith(ZSTANDARD) and file.is_file():
        of_database: FilePath = _read(sqlite, file, [file], folder)
        return of_database
    for (ending, start), converter in CONVERTERS.items():
        if _is_of(file, ending, start):
            converted: FilePath = _read(converter, file, [file], folder)
            return converted
    return file


def tables(file: FilePath, unread: list[str]) -> Tables | None:
    """The tables of a file, and what is left out of it with the reason; `None` where the package reads it without
    another library."""
    for (ending, start), reader in READERS.items():
        if _is_of(file, ending, start):
            found: Tables = _read(reader, file, file, unread)
            if not found:
                items = f"; not read: {listed(unread)}" if unread else ""
                raise Error(f"{file}: no channel of numbers{items}", "check that the file is complete")
            return found
    return None


def as_file(name: str, found: Tables, folder: FilePath) -> FilePath:
    """Tables as a file that the command line reads; the groups have the names of the tables in the file."""
    written = folder / "tables.mf4"
    _mdf.write([(own.removeprefix(f"{name}: "), columns) for own, columns in found], written)
    return written


def _read(function: Callable[..., Any], file: FilePath, *arguments: Any) -> Any:
    """What the function returns; faults that a library finds in the file are errors of the package."""
    try:
        return function(*arguments)
    except Error:
        raise
    except Exception as error:
        what = str(error) or type(error).__name__
        raise Error(
            f"{file}: the file is cut, damaged or of another kind: {what[:80]}",
            "open it in the tool that wrote it, and copy or export it again",
        ) from error


def _is_of(file: FilePath, ending: str, start: bytes) -> bool:
    """Whether a file begins with these bytes, or, of formats that have none, ends like this."""
    # Read from a pipe, the first bytes would be gone.
    if not file.is_file():
        return False
    if not start:
        return file.name.lower().endswith(ending)
    try:
        with open(file, "rb") as opened:
            return opened.read(len(start)) == start
    except OSError:
        # The reader of the package names the fault.
        return False


def tdms(file: FilePath, unread: list[str]) -> Tables:
    """LabVIEW's TDMS: a table for each group and clock of waveforms."""
    nptdms = library("nptdms", f"{file}: such files are read by")
    found: dict[Any, Columns] = {}
    with _remarks_of_nptdms(file), nptdms.TdmsFile.open(file) as opened:
        for group in opened.groups():
            for channel in group.channels():
                clock: tuple[Any, ...] = (group.name, len(channel))
                time = None
                step = channel.properties.get("wf_increment")
                if step:
                    offset = float(channel.properties.get("wf_start_offset", 0.0))
                    begin = channel.properties.get("wf_start_time")
                    if begin is not None:
                        moment = np.datetime64(begin, "ns").astype(np.int64) * 1e-9
                        offset += float(moment)
                    clock = (*clock, step, offset)
                    time = offset + float(step) * np.arange(len(channel))
                columns = found.setdefault(clock, Columns(f"{file}: {group.name}"))
                if time is not None:
                    columns.setdefault("time_s", time)
                units = (channel.properties.get(key) for key in UNITS_OF_TDMS)
                try:
                    values = channel[:]
                except Exception as error:
                    # Such as raw values of DAQmx whose scale is not known; the other channels are read.
                    columns.unread.append(f"{channel.name} ({str(error)[:MOST_QUOTED]})")
                    continue
                columns.add(_named(channel.name, next(filter(None, units), None)), values)
    unread += (item for columns in found.values() for item in columns.unread)
    return _complete([(columns.title, columns) for columns in found.values()])


@contextlib.contextmanager
def _remarks_of_nptdms(file: FilePath) -> Iterator[None]:
    """What nptdms prints of a file that is cut, as warnings, each once."""
    handler = library("nptdms.log", f"{file}: such files are read by").log_manager.console_handler
    remarks: list[str] = []

    def keep(record: logging.LogRecord) -> bool:
        remark = record.getMessage()[:MOST_QUOTED]
        if remark not in remarks and len(remarks) < MOST_REMARKS:
            remarks.append(remark)
        return False

    handler.addFilter(keep)
    try:
        yield
    finally:
        handler.removeFilter(keep)
    for remark in remarks:
        warn(f"{file}: {remark}")


MOST_REMARKS = 5
UNITS_OF_TDMS = ("unit_string", "NI_UnitDescription", "Unit", "Units", "unit", "units")
"""Properties with the unit of a channel, as LabVIEW, DAQmx and others name them."""


def bus(files: list[FilePath], folder: FilePath) -> FilePath:
    """Frames of Vector's BLF as the text that candump writes, by python-can; decoded with the option `dbc`."""
    (file,) = files
    can = library("can", f"{file}: such files are read by")
    converted = folder / f"{file.stem}.log"
    with can.LogReader(file) as frames, can.CanutilsLogWriter(converted) as writer:
        for frame in frames:
            writer.on_message_received(frame)
    return converted


def sqlite(files: list[FilePath], folder: FilePath) -> FilePath:
    """ROS 2's SQLite bags as MCAP."""
    converted = folder / f"{files[0].stem}.mcap"
    _ros.of_sqlite([_decompressed(file, folder) for file in files], converted)
    return converted


def _decompressed(file: FilePath, folder: FilePath) -> FilePath:
    """The file, or of one that rosbag2 compressed as a whole its content."""
    if not file.name.endswith(ZSTANDARD):
        return file
    zstandard = library("zstandard", f"{file}: such files are decompressed by")
    plain = folder / file.name.rpartition(".")[0]
    with open(file, "rb") as source, open(plain, "wb") as target:
        zstandard.ZstdDecompressor().copy_stream(source, target)
    return plain


ZSTANDARD = (".db3.zstd", ".db3.zst")
"""Endings of databases that are compressed as a whole."""


def bag(files: list[FilePath], folder: FilePath) -> FilePath:
    """ROS 1 bags as MCAP, by rosbags."""
    (file,) = files
    converted = folder / f"{file.stem}.mcap"
    _ros.of_bag(file, converted, library("rosbags.highlevel", f"{file}: such files are read by"))
    return converted


def mat(file: FilePath, unread: list[str]) -> Tables:
    """MATLAB's MAT, version 5 by SciPy and 7.3 by h5py."""
    with open(file, "rb") as opened:
        is_hdf = b"MATLAB 7.3" in opened.read(128)
    variables: dict[str, Any] = {}
    if is_hdf:
        h5py = library("h5py", f"{file}: such files are read by")
        with h5py.File(file, "r") as opened:
            opened.visititems(
                lambda name, item: (
                    variables.__setitem__(name.replace("/", "."), np.asarray(item))
                    if isinstance(item, h5py.Dataset) and not name.startswith("#")
                    else None
                )
            )
    else:
        scipy_io = library("scipy.io", f"{file}: such files are read by")
        for name, value in scipy_io.loadmat(file, simplify_cells=True).items():
            if not name.startswith("__"):
                variables[name] = value
    return _mat.tables(file, variables, unread)


def rlog(file: FilePath, _: list[str]) -> Tables:
    """openpilot's rlog and qlog, by openpilot's own reader where it is installed: a table for each service."""
    logreader = library("openpilot.tools.lib.logreader", f"{file}: such files are read by")
    services: dict[str, tuple[list[float], dict[str, list[float]]]] = {}
    for event in logreader.LogReader(str(file)):
        service = event.which()
        if service not in SERVICES:
            continue
        values: dict[str, float] = {}
        _entries("", getattr(event, service).to_dict(), values)
        time, columns = services.setdefault(service, ([], {}))
        _append(time, columns, event.logMonoTime * 1e-9, values)
    return [
        (f"{file}: {service}", {"time_s": np.array(time), **_arrays(columns)})
        for service, (time, columns) in services.items()
    ]


SERVICES = {
    "accelerometer",
    "carControl",
    "carOutput",
    "carState",
    "controlsState",
    "gpsLocation",
    "gpsLocationExternal",
    "gyroscope",
    "liveLocationKalman",
    "liveParameters",
    "livePose",
}
"""What concerns the motion of the vehicle; an rlog has a hundred others."""


def _entries(name: str, value: Any, into: dict[str, float]) -> None:
    """Numbers of nested dicts and short lists, such as the axes of a sensor."""
    if isinstance(value, (bool, int, float)):
        into[name] = float(value)
    elif isinstance(value, dict):
        for key, item in value.items():
            _entries(f"{name}.{key}" if name else key, item, into)
    elif isinstance(value, list) and len(value) <= AXES:
        for index, item in enumerate(value):
            _entries(f"{name}.{index}", item, into)


AXES = 4
"""Longest list that is a vector."""


def _append(
    time: list[float], columns: dict[str, list[float]], stamp: float, values: dict[str, float]
) -> None:
    """A row; what it lacks is missing."""
    count = len(time)
    time.append(stamp)
    for name, value in values.items():
        columns.setdefault(name, [float("nan")] * count).append(value)
    for column in columns.values():
        if len(column) == count:
            column.append(float("nan"))


def _arrays(columns: dict[str, list[float]]) -> dict[str, Any]:
    return {name: np.array(values) for name, values in columns.items()}


def _named(name: str, unit: Any) -> str:
    unit = str(unit).strip() if unit else ""
    return f"{name} [{unit}]" if unit and "[" not in name else name


def _complete(found: Tables) -> Tables:
    """Tables with more than a clock."""
    return [(name, columns) for name, columns in found if set(columns) - {"time_s"}]


READERS: dict[tuple[str, bytes], Callable[[FilePath, list[str]], Tables]] = {
    (".tdms", b"TDSm"): tdms,
    (".ulg", _autopilots.ULOG): _autopilots.ulog,
    (".bin", _autopilots.DATAFLASH + b"\x80"): _autopilots.dataflash,
    (".mat", b""): mat,
    **{(f"{kind}log{end}", b""): rlog for kind in "rq" for end in ("", ".bz2", ".zst")},
}
"""Ending, which decides where a format has no first bytes, those bytes, and the function that reads such a file."""

CONVERTERS: dict[tuple[str, bytes], Callable[[list[FilePath], FilePath], FilePath]] = {
    (".bag", b"#ROSBAG V2.0"): bag,
    (".blf", b"LOGG"): bus,
    (".db3", b"SQLite format 3"): sqlite,
}
"""Ending and first bytes, and the function that converts such a file."""
