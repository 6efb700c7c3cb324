"""Tables in memory as columns of numbers: dicts of arrays, data frames of pandas and polars, tables of Arrow."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime, time, timedelta, timezone
from typing import Any

import numpy as np

from ._errors import ArgumentError, Error, warn
from ._libraries import library


def columns(table: Any, title: str = "table", *, is_clock_stated: bool = False) -> Columns:
    """The columns of a table. An index of times is the clock, and so is the only column of times if no name is that
    of a clock, unless the options state the clock."""
    if hasattr(table, "collect_schema") and hasattr(table, "collect"):
        # A query of polars that has not run.
        table = table.collect()
    elif hasattr(table, "__arrow_c_stream__") and not (hasattr(table, "columns") or hasattr(table, "column_names")):
        if hasattr(table, "to_frame"):
            raise ArgumentError(
                f"{title}: a series is one column", "pass a data frame with time, steering and yaw rate"
            )
        table = library("pyarrow", "a stream of Arrow is read by").table(table)
    found = Columns(title)
    for name, values in _index(table):
        found.add(name, values)
    if not is_clock_stated and found.times and not TIME.match(found.times[0]):
        found.rename(found.times[0], f"time {found.times[0]}")
    named = list(_named(table))
    lasts = [_last_level(name) for name, _ in named]
    for (name, values), last in zip(named, lasts):
        found.add(last if lasts.count(last) == 1 else _of_levels(name), values)
    if not is_clock_stated and len(found.times) == 1 and not any(TIME.match(name) for name in found):
        found.rename(found.times[0], f"time {found.times[0]}")
    clocks = [item for item in found.unread if TIME.match(item)]
    if found and clocks and not is_clock_stated and not any(TIME.match(name) for name in found):
        raise Error(
            f"{title}: the clock is not read: {listed(clocks)}",
            "pass seconds, or times as with pandas.to_datetime(column, format='%d.%m.%Y %H:%M:%S.%f')",
        )
    if not found:
        unread = f"; not read: {listed(found.unread)}" if found.unread else ""
        raise Error(f"{title}: there is no column of numbers{unread}", "pass named columns of numbers")
    first = next(iter(found))
    for name, values in found.items():
        if len(values) != len(found[first]):
            raise Error(
                f"{title}: `{name}` has {len(values)} values, `{first}` has {len(found[first])}",
                "pass columns of equal length, or a table for each clock in a list",
            )
    return found


class Columns(dict[str, Any]):
    """Columns of numbers by name, float64; missing values are NaN, times are seconds since 1970."""

    def __init__(self, title: str) -> None:
        super().__init__()
        self.title = title
        self.booleans: set[str] = set()
        """Columns of True and False."""
        self.times: list[str] = []
        """Columns of times, whose names have their unit."""
        self.unread: list[str] = []
        """What is left out, with the reason."""

    def add(self, name: str, values: Any) -> None:
        """Adds a column of numbers or times, otherwise the reason why it is none."""
        array = _array(values)
        if array.dtype.kind in "OSUT" and array.ndim == 1:
            array = self._of_objects(name, array)
        elif array.dtype.kind == "b":
            self.booleans.add(name)
        if array.dtype.kind in "Mm":
            missing = np.isnat(array)
            kind = "datetime64[ns]" if array.dtype.kind == "M" else "timedelta64[ns]"
            seconds = array.astype(kind).astype(np.int64) * 1e-9
            seconds[missing] = np.nan
            unit = UNIT.search(name)
            array = seconds * (PER_SECOND[unit[1].lower()] if unit else 1.0)
            name = name if unit else f"{name} [s]"
            self.times.append(name)
        if name in self:
            self.unread.append(f"{name} (there is another column of this name)")
        elif array.dtype.kind in "fiub" and array.ndim == 1:
            self[name] = np.ascontiguousarray(array, dtype=np.float64)
        elif array.dtype.kind != "V":
            self.unread.append(f"{name} ({' × '.join(map(str, array.shape))} values of type {array.dtype})")

    def rename(self, name: str, other: str) -> None:
        """Renames a column of times, and keeps the order."""
        self.times = [other if time == name else time for time in self.times]
        renamed = {other if column == name else column: values for column, values in self.items()}
        self.clear()
        self.update(renamed)

    def _of_objects(self, name: str, array: Any) -> Any:
        """Numbers, times or durations of objects and texts; a column without them is unread."""
        items = [item.decode("utf-8", "replace") if isinstance(item, bytes) else item for item in array.tolist()]
        present = [item for item in items if not _is_missing(item)]
        if not present:
            self.unread.append(f"{name} (no values)")
            return NOTHING
        parse: Callable[[Any], Any] = np.float64
        missing: Any = np.float64(np.nan)
        kind, most = "numbers", MOST_BAD * len(items)
        if any(isinstance(item, datetime) or _is_text_of_time(item) for item in present):
            kind, parse, missing, most = "times", _moment, np.datetime64("NaT", "ns"), 0.0
        elif all(isinstance(item, time) or _is_text_of_day(item) for item in present):
            kind, parse, missing, most = "times of day", _TimesOfDay(), np.timedelta64("NaT", "ns"), 0.0
        elif all(isinstance(item, timedelta) for item in present):
            kind, parse, missing, most = "durations", np.timedelta64, np.timedelta64("NaT", "ns"), 0.0
        elif all(isinstance(item, bool) for item in present):
            self.booleans.add(name)
        values, bad = [], []
        for row, item in enumerate(items):
            try:
                values.append(missing if _is_missing(item) else parse(item))
            except (TypeError, ValueError, OverflowError):
                values.append(missing)
                bad.append(row)
        if bad:
            cell = repr(items[bad[0]])[:MOST_QUOTED]
            problem = f"{len(bad)} of {len(items)} cells are no {kind}, such as {cell} in row {bad[0]}"
            if len(bad) > most:
                self.unread.append(f"{name} ({problem})")
                return NOTHING
            warn(f"{self.title}: {name}: {problem}; they are missing values")
        return np.array(values, dtype=missing.dtype)


NOTHING = np.empty(0, dtype="V1")
"""In place of a column that is unread."""
MOST_BAD = 0.01
"""Most cells of a column of numbers that are none, as a share."""
MOST_QUOTED = 80
"""Most characters of a cell in a message."""
MOST_NAMES = 20
"""Most names in a warning."""


def listed(items: Sequence[str]) -> str:
    """The first of some, and how many more there are."""
    more = f" and {len(items) - MOST_NAMES} more" if len(items) > MOST_NAMES else ""
    return f"{', '.join(items[:MOST_NAMES])}{more}"


TIME = re.compile(r"(?i)_*(t$|time|stamp|t_|t |t\[|zeit|uhrzeit)")
"""Names of clocks, as the reader of logs knows them."""
UNIT = re.compile(r"(?i)[_ (\[](s|sec|ms|us|µs|ns)[)\]]?$")
"""The unit of time in a name."""
PER_SECOND = {"s": 1.0, "sec": 1.0, "ms": 1e3, "us": 1e6, "µs": 1e6, "ns": 1e9}
MOMENT = re.compile(
    r"(\d{4})-?(\d\d)-?(\d\d)[Tt ](\d\d):?(\d\d)(?::?(\d\d)(?:[.,](\d+))?)?\s*(Z|z|UTC|([+-]\d\d):?(\d\d)?)?"
)
"""A time of ISO 8601."""


def _index(table: Any) -> Iterable[tuple[str, Any]]:
    """The levels of the index of a frame of pandas that have a name or are times."""
    index = getattr(table, "index", None)
    if index is None or callable(index):
        return
    for level in range(getattr(index, "nlevels", 1)):
        values = index.get_level_values(level)
        if values.name is not None:
            if values.name not in table.columns:
                yield str(values.name), values
        elif _array(values).dtype.kind in "Mm" or (len(values) > 0 and _is_text_of_time(values[0])):
            yield "time", values


def _last_level(name: Any) -> str:
    """The name of a column, of several levels the last one."""
    levels = [str(level) for level in name if str(level)] if isinstance(name, tuple) else []
    return levels[-1] if levels else str(name)


def _of_levels(name: Any) -> str:
    """All levels of the name of a column."""
    return ".".join(str(level) for level in name if str(level)) if isinstance(name, tuple) else str(name)


def _is_text_of_day(item: Any) -> bool:
    return isinstance(item, str) and OF_DAY.fullmatch(item.strip()) is not None


OF_DAY = re.compile(r"(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)")
"""A time of day."""
DAY_NS = 86_400_000_000_000


class _TimesOfDay:
    """Times of day as durations; half a day or more before the last one is a time of the next day."""

    def __init__(self) -> None:
        self.last = 0

    def __call__(self, item: Any) -> Any:
        if isinstance(item, time):
            seconds = 3600 * item.hour + 60 * item.minute + item.second
            own = seconds * 1_000_000_000 + item.microsecond * 1_000
        else:
            parts = OF_DAY.fullmatch(str(item).strip())
            if parts is None or int(parts[1]) > 23 or int(parts[2]) > 59:
                raise ValueError(item)
            seconds = 3600 * int(parts[1]) + 60 * int(parts[2])
            own = seconds * 1_000_000_000 + round(float(parts[3].replace(",", ".")) * 1e9)
        own += max(0, round((self.last - own) / DAY_NS)) * DAY_NS
        self.last = max(self.last, own)
        return np.timedelta64(own, "ns")


def _is_text_of_time(item: Any) -> bool:
    return isinstance(item, str) and MOMENT.fullmatch(item.strip()) is not None


def _named(table: Any) -> Iterable[tuple[Any, Any]]:
    if isinstance(table, Mapping):
        return table.items()
    if hasattr(table, "column_names") and hasattr(table, "column"):
        return ((name, table.column(k)) for k, name in enumerate(table.column_names))
    if hasattr(table, "iloc") and hasattr(table, "columns"):
        return ((name, table.iloc[:, k]) for k, name in enumerate(table.columns))
    if hasattr(table, "columns"):
        return ((name, table[name]) for name in table.columns)
    if isinstance(table, np.ndarray) and table.dtype.names:
        return ((name, table[name]) for name in table.dtype.names)
    raise ArgumentError(
        f"a file name, a dict of arrays or a data frame is expected, not {type(table).__name__}",
        'name the columns, such as {"time_s": t, "steering_angle_rad": u, "yaw_rate_radps": y}',
    )


def _array(values: Any) -> Any:
    """An array; what is masked is missing."""
    if isinstance(values, np.ma.MaskedArray):
        # None is missing; numbers and dates have a filler, which is replaced.
        array = np.asarray(values.filled(None) if values.dtype.kind == "O" else values.filled())
        masked = np.ma.getmaskarray(values)
        if array.dtype.kind in "Mm":
            array[masked] = "NaT"
        elif array.dtype.kind in "fiub":
            array = np.where(masked, np.nan, array)
        return array
    if type(getattr(values, "dtype", None)).__name__ == "PeriodDtype":
        # The instants at which the periods begin.
        values = (values.dt if hasattr(values, "dt") else values).to_timestamp()
    if getattr(getattr(values, "dtype", None), "tz", None) is not None:
        # Of pandas, which otherwise makes objects of times with a zone.
        return values.to_numpy(dtype="datetime64[ns]")
    return np.asarray(values.to_numpy() if hasattr(values, "to_numpy") else values)


def _is_missing(item: Any) -> bool:
    if isinstance(item, str):
        return MISSING.fullmatch(item.strip()) is not None
    return item is None or type(item).__name__ in ("NAType", "NaTType") or (isinstance(item, float) and item != item)


MISSING = re.compile(
    r"(?i)|-{1,3}|\?|%|n/?a|n\.a\.|null|nil|none|missing|<na>|#\S+|[+-]?(nan(\(.*\))?|inf(inity)?|1[.,]#.*)"
)
"""Missing values as tools write them."""


def _moment(item: Any) -> Any:
    """A time, UTC."""
    if isinstance(item, str):
        parts = MOMENT.fullmatch(item.strip())
        if parts is None:
            raise ValueError(item)
        year, month, day, hour, minute, second, fraction, _, hours, minutes = parts.groups()
        text = f"{year}-{month}-{day}T{hour}:{minute}:{second or '00'}.{(fraction or '0')[:9]}"
        late = 60 * int(hours or 0) + int((hours or "+")[0] + (minutes or "0"))
        return np.datetime64(text, "ns") - np.timedelta64(late, "m")
    if item.tzinfo is not None:
        item = item.astimezone(timezone.utc).replace(tzinfo=None)
    return np.datetime64(item, "ns")
