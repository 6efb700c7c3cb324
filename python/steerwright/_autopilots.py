"""Logs of PX4 (ULog) and ArduPilot (DataFlash), both of which describe their messages themselves.

Source: `ULog <https://docs.px4.io/main/en/dev_log/ulog_file_format>`_ and the logger of ArduPilot. Axes and signs are
those of the log: x forward, y to the right, z down, so that a yaw rate is positive to the right.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np

from ._errors import Error

Tables = list[tuple[str, dict[str, Any]]]

ULOG = b"ULog\x01\x12\x35"
DATAFLASH = b"\xa3\x95"

_NUMBERS = {
    "int8_t": "i1",
    "uint8_t": "u1",
    "bool": "u1",
    "char": "S1",
    "int16_t": "<i2",
    "uint16_t": "<u2",
    "int32_t": "<i4",
    "uint32_t": "<u4",
    "int64_t": "<i8",
    "uint64_t": "<u8",
    "float": "<f4",
    "double": "<f8",
}
_UNITS = {
    "vehicle_angular_velocity": {"xyz": "rad/s"},
    "vehicle_acceleration": {"xyz": "m/s2"},
    "vehicle_local_position": {
        **dict.fromkeys(("vx", "vy", "vz"), "m/s"),
        **dict.fromkeys(("ax", "ay", "az"), "m/s2"),
        **dict.fromkeys(("x", "y", "z"), "m"),
        "heading": "rad",
    },
    "sensor_combined": {"gyro_rad": "rad/s", "accelerometer_m_s2": "m/s2"},
}
"""Units of PX4's messages about the motion, which the log does not state."""


class _Message(NamedTuple):
    """A kind of messages, their layout, and what is read of them."""

    name: str
    kind: str
    rows: list[bytes]


def ulog(file: FilePath, unread: list[str]) -> Tables:
    """PX4's ULog: a table for each topic and its instance, with the time since the start of the autopilot."""
    data = file.read_bytes()
    formats: dict[str, list[tuple[str, str]]] = {}
    topics: dict[int, _Message] = {}
    at = 16
    while at + 3 <= len(data):
        size, letter = struct.unpack_from("<HB", data, at)
        content = data[at + 3 : at + 3 + size]
        if len(content) < size:
            unread.append(f"the message at byte {at} and what follows, where the file is cut")
            break
        at += 3 + size
        if letter == ord("F"):
            name, _, fields = content.decode("ascii", "replace").partition(":")
            words = [field.split(" ", 1) for field in fields.split(";") if " " in field]
            formats[name] = [(own, kind) for kind, own in words]
        elif letter == ord("A") and size > 3:
            instance, number = struct.unpack_from("<BH", content)
            kind = content[3:].decode("ascii", "replace")
            name = f"{kind}[{instance}]" if instance else kind
            topics.setdefault(number, _Message(name, kind, []))
        elif letter == ord("D") and size > 2:
            (number,) = struct.unpack_from("<H", content)
            if number in topics:
                topics[number].rows.append(content[2:])
    found: Tables = []
    for name, kind, rows in topics.values():
        layout = list(_flattened(kind, formats, "", 0))
        table = _table(layout, rows)
        time = table.pop("timestamp", None)
        if time is None:
            if rows:
                unread.append(f"{name} (no time)")
            continue
        units = _UNITS.get(kind, {})
        columns = {_with_unit(own, units.get(own.partition("[")[0])): values for own, values in table.items()}
        found.append((f"{file}: {name}", {"time_s": 1e-6 * time, **columns}))
    return found


def _flattened(
    kind: str, formats: dict[str, list[tuple[str, str]]], before: str, depth: int
) -> Iterator[tuple[str, str]]:
    """Names and types of numbers, those within messages and arrays one by one; padding has an empty name."""
    if depth > DEEPEST:
        raise Error(f"the format of {kind} refers to itself", "log the drive again")
    for name, own in formats.get(kind, []):
        item, _, rest = own.partition("[")
        count = int(rest.rstrip("]")) if rest else 1
        for index in range(min(count, LARGEST)):
            full = f"{before}{name}[{index}]" if rest else f"{before}{name}"
            if item in _NUMBERS:
                yield ("" if name.startswith("_padding") else full), _NUMBERS[item]
            else:
                yield from _flattened(item, formats, f"{full}.", depth + 1)


DEEPEST = 8
LARGEST = 4096
"""Longest array in a message."""


def _table(layout: list[tuple[str, str]], rows: list[bytes]) -> dict[str, Any]:
    """The columns of messages; the padding at their end may not be written."""
    if not rows or not layout:
        return {}
    size = max(map(len, rows))
    places, end = [], 0
    for name, kind in layout:
        width = np.dtype(kind).itemsize
        if end + width > size:
            break
        places.append((name, kind, end))
        end += width
    whole = [row for row in rows if len(row) == size]
    numbers = [(name, kind, place) for name, kind, place in places if name and not kind.startswith("S")]
    dtype = np.dtype(
        {
            "names": [name for name, _, _ in numbers],
            "formats": [kind for _, kind, _ in numbers],
            "offsets": [place for _, _, place in numbers],
            "itemsize": size,
        }
    )
    read = np.frombuffer(b"".join(whole), dtype=dtype)
    return {name: np.ascontiguousarray(read[name], dtype=np.float64) for name, _, _ in numbers}


_LETTERS = {
    "b": ("i1", 1.0),
    "B": ("u1", 1.0),
    "M": ("u1", 1.0),
    "h": ("<i2", 1.0),
    "H": ("<u2", 1.0),
    "i": ("<i4", 1.0),
    "I": ("<u4", 1.0),
    "q": ("<i8", 1.0),
    "Q": ("<u8", 1.0),
    "f": ("<f4", 1.0),
    "d": ("<f8", 1.0),
    "g": ("<f2", 1.0),
    "c": ("<i2", 0.01),
    "C": ("<u2", 0.01),
    "e": ("<i4", 0.01),
    "E": ("<u4", 0.01),
    "L": ("<i4", 1e-7),
    "n": ("S4", 1.0),
    "N": ("S16", 1.0),
    "Z": ("S64", 1.0),
    "a": ("S64", 1.0),
}
"""Types of DataFlash by their letters, and what their numbers are times."""
_FORMAT = 128
DESCRIPTIONS = {"UNIT", "MULT", "FMTU"}
"""Messages that describe others."""


class _Format(NamedTuple):
    length: int
    name: str
    letters: str
    labels: list[str]


def dataflash(file: FilePath, unread: list[str]) -> Tables:
    """ArduPilot's binary log: a table for each message and instance, with the units that the log states."""
    data = file.read_bytes()
    formats = {_FORMAT: _Format(89, "FMT", "BBnNZ", ["Type", "Length", "Name", "Format", "Columns"])}
    rows: dict[int, list[bytes]] = {}
    at, lost = 0, 0
    while at + 3 <= len(data):
        own = formats.get(data[at + 2]) if data.startswith(DATAFLASH, at) else None
        if own is None or at + own.length > len(data):
            following = data.find(DATAFLASH, at + 1)
            following = following if following >= 0 else len(data)
            lost += following - at
            at = following
            continue
        content = data[at + 3 : at + own.length]
        if own.name == "FMT":
            number, length, name, letters, labels = struct.unpack("<BB4s16s64s", content[:86])
            if length >= 3 and number != _FORMAT:
                formats[number] = _Format(length, _text(name), _text(letters), _text(labels).split(","))
        else:
            rows.setdefault(data[at + 2], []).append(content)
        at += own.length
    if lost:
        unread.append(f"{lost} bytes that are no messages")
    tables = {number: _columns(formats[number], own) for number, own in rows.items()}
    units, factors = _scales(formats, rows)
    found: Tables = []
    for number, table in tables.items():
        if formats[number].name in DESCRIPTIONS:
            continue
        form = formats[number]
        columns: dict[str, Any] = {}
        instances = None
        for place, label in enumerate(form.labels):
            if label not in table:
                continue
            letter = form.letters[place : place + 1]
            unit, factor = units.get((number, place), ""), factors.get((number, place))
            values = table[label] * (_LETTERS[letter][1] if factor is None else factor)
            if label == "TimeUS":
                columns["time_s"] = table[label] * 1e-6
            elif unit == "instance":
                instances = table[label]
            else:
                columns[_with_unit(label, unit)] = values
        if "time_s" not in columns:
            unread.append(f"{form.name} (no time)")
            continue
        if instances is None:
            found.append((f"{file}: {form.name}", columns))
            continue
        for instance in np.unique(instances):
            own_rows = instances == instance
            name = f"{form.name}[{int(instance)}]"
            found.append((f"{file}: {name}", {key: column[own_rows] for key, column in columns.items()}))
    return [(name, columns) for name, columns in found if len(columns) > 1]


def _columns(form: _Format, rows: list[bytes]) -> dict[str, Any]:
    """The numbers of messages as they are in the log, and its texts."""
    kinds = [_LETTERS.get(letter) for letter in form.letters]
    known = kinds[: kinds.index(None)] if None in kinds else kinds
    fields, end = [], 0
    for label, kind in zip(form.labels, known):
        assert kind is not None
        width = np.dtype(kind[0]).itemsize
        if end + width > form.length - 3:
            break
        fields.append((label, kind[0], end))
        end += width
    dtype = np.dtype(
        {
            "names": [label for label, _, _ in fields],
            "formats": [kind for _, kind, _ in fields],
            "offsets": [place for _, _, place in fields],
            "itemsize": form.length - 3,
        }
    )
    read = np.frombuffer(b"".join(rows), dtype=dtype)
    return {label: read[label].astype(np.float64) for label, kind, _ in fields if not kind.startswith("S")}


def _scales(
    formats: dict[int, _Format], rows: dict[int, list[bytes]]
) -> tuple[dict[tuple[int, int], str], dict[tuple[int, int], float]]:
    """Unit and factor of the fields, by the number of the message and the place, as UNIT, MULT and FMTU state them."""
    named = {form.name: rows.get(number, []) for number, form in formats.items()}
    units = {row[8:9]: _text(row[9:73]) for row in named.get("UNIT", []) if len(row) >= 73}
    units[b"#"] = "instance"
    factors = {row[8:9]: struct.unpack_from("<d", row, 9)[0] for row in named.get("MULT", []) if len(row) >= 17}
    of_units: dict[tuple[int, int], str] = {}
    of_factors: dict[tuple[int, int], float] = {}
    for row in named.get("FMTU", []):
        if len(row) < 41:
            continue
        number = row[8]
        for place in range(16):
            letter, factor = row[9 + place : 10 + place], row[25 + place : 26 + place]
            of_units[number, place] = units.get(letter, "")
            # A dash and a question mark stand for none.
            if factors.get(factor, 0.0) != 0.0 and factor not in (b"-", b"?"):
                of_factors[number, place] = factors[factor]
    return of_units, of_factors


def _text(data: bytes) -> str:
    return data.split(b"\0")[0].decode("ascii", "replace")


def _with_unit(name: str, unit: str | None) -> str:
    return f"{name} [{unit}]" if unit and unit not in ("-", "UNKNOWN") else name
