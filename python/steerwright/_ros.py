"""ROS 1 bags and ROS 2 bags in SQLite as MCAP, which the package reads itself."""

from __future__ import annotations

import shutil
import sqlite3
import struct
from collections.abc import Iterable, Iterator
from pathlib import Path as FilePath
from typing import Any, BinaryIO

from ._errors import warn


def _of_rosbags(kind: str) -> str | None:
    """The definition of a type of a ROS 2 distribution, where rosbags is installed; others are known to the reader."""
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        return None
    store = get_typestore(Stores.LATEST)
    name = kind.replace("/", "/msg/")
    return str(store.generate_msgdef(name, ros_version=2)[0]) if name in store.fielddefs else None


class Mcap:
    """Writes an MCAP file without chunks and summary."""

    MAGIC = b"\x89MCAP0\r\n"

    def __init__(self, file: BinaryIO) -> None:
        self.file = file
        file.write(self.MAGIC)
        self._record(0x01, _text("ros2") + _text(""))

    def _record(self, code: int, content: bytes) -> None:
        self.file.write(struct.pack("<BQ", code, len(content)) + content)

    def topic(self, number: int, name: str, kind: str, form: str, definition: tuple[str, str]) -> None:
        """Declares a topic; its definition has an encoding and a text."""
        encoding, text = definition
        schema = _text(kind) + _text(encoding) + _text(text)
        self._record(0x03, struct.pack("<H", number) + schema)
        self._record(0x04, struct.pack("<HH", number, number) + _text(name) + _text(form) + _text(""))

    def message(self, number: int, stamp_ns: int, data: bytes) -> None:
        self._record(0x05, struct.pack("<HIQQ", number, 0, stamp_ns, stamp_ns) + data)

    def end(self) -> None:
        self._record(0x0F, struct.pack("<I", 0))
        self._record(0x02, struct.pack("<QQI", 0, 0, 0))
        self.file.write(self.MAGIC)


def _text(text: str) -> bytes:
    encoded = text.encode()
    return struct.pack("<I", len(encoded)) + encoded


def of_sqlite(files: Iterable[FilePath], converted: FilePath) -> None:
    """Messages of SQLite files of one ROS 2 bag; topics without a definition are reported by the reader."""
    numbers: dict[str, int] = {}
    with open(converted, "wb") as opened:
        mcap = Mcap(opened)
        for file in files:
            database = _opened(file, converted.parent)
            try:
                own: dict[int, int] = {}
                stated = _stated(database)
                query = "SELECT id, name, type, serialization_format FROM topics ORDER BY id"
                for topic, name, kind, form in database.execute(query):
                    if name not in numbers:
                        numbers[name] = len(numbers) + 1
                        known = stated.get(kind) or ("ros2msg", _of_rosbags(kind.replace("/msg/", "/")) or "")
                        mcap.topic(numbers[name], name, kind, form, known)
                    own[topic] = numbers[name]
                for topic, stamp_ns, data in _messages(file, database):
                    if topic in own and data is not None:
                        mcap.message(own[topic], stamp_ns, data)
            finally:
                database.close()
        mcap.end()


def _opened(file: FilePath, scratch: FilePath) -> sqlite3.Connection:
    """The database as it is: the folder may be read-only, and the recorder may have crashed."""
    log = file.with_name(f"{file.name}-wal")
    if log.is_file() and log.stat().st_size > 0:
        # What was written last, which only a database that may be changed takes in.
        own = scratch / file.name
        shutil.copy(file, own)
        shutil.copy(log, own.with_name(log.name))
        database = sqlite3.connect(own)
    else:
        whole = _whole_pages(file, scratch)
        database = sqlite3.connect(f"{whole.resolve().as_uri()}?immutable=1", uri=True)
    # Without it SQLite refuses a file that is shorter than its first page states.
    database.execute("PRAGMA writable_schema=ON")
    return database


def _whole_pages(file: FilePath, scratch: FilePath) -> FilePath:
    """The file, or of one that is cut within a page a copy without it: SQLite would read zeros behind its end."""
    with open(file, "rb") as opened:
        head = opened.read(18)
    size = int.from_bytes(head[16:18], "big")
    # 65536 has no place in two bytes.
    size = 65536 if size == 1 else size
    if size < 512 or file.stat().st_size % size == 0 or file.stat().st_size < size:
        return file
    own = scratch / file.name
    with open(file, "rb") as source, open(own, "wb") as target:
        for _ in range(file.stat().st_size // size):
            target.write(source.read(size))
    return own


def _messages(file: FilePath, database: sqlite3.Connection) -> Iterator[tuple[int, int, bytes]]:
    """Topic, time and bytes of the messages as they were recorded, beyond damaged pages, too."""
    query = "SELECT rowid, topic_id, timestamp, data FROM messages WHERE rowid > ? ORDER BY rowid"
    last, step = -1, 0
    first: tuple[int, Exception] | None = None
    while step < FARTHEST:
        try:
            for row, topic, stamp_ns, data in database.execute(query, (last + step,)):
                last, step = row, 0
                yield topic, stamp_ns, data
            break
        except sqlite3.DatabaseError as error:
            first = first or (last, error)
            step = max(1, 2 * step)
    if first:
        row, fault = first
        warn(f"{file}: the database is cut or damaged behind message {max(row, 0)} ({fault}): what is there is read")


FARTHEST = 1 << 40
"""No recording has as many messages."""


def _stated(database: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Encoding and text of the definitions in the file, which bags have since ROS 2 Iron."""
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master")}
    if "message_definitions" not in tables:
        return {}
    query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
    return {kind: (encoding, text) for kind, encoding, text in database.execute(query) if text}


def of_bag(file: FilePath, converted: FilePath, highlevel: Any) -> None:
    """Messages of a ROS 1 bag, by rosbags."""
    with highlevel.AnyReader([file]) as reader, open(converted, "wb") as opened:
        store, mcap = _without_numbers(reader.typestore), Mcap(opened)
        numbers: dict[str, int] = {}
        for connection in reader.connections:
            if connection.topic not in numbers:
                numbers[connection.topic] = len(numbers) + 1
                text, _ = store.generate_msgdef(connection.msgtype, ros_version=2)
                number, kind = numbers[connection.topic], connection.msgtype
                mcap.topic(number, connection.topic, kind, "cdr", ("ros2msg", text))
        for connection, stamp_ns, raw in reader.messages():
            data = store.ros1_to_cdr(raw, connection.msgtype)
            mcap.message(numbers[connection.topic], stamp_ns, bytes(data))
        mcap.end()


def _without_numbers(store: Any) -> Any:
    """The types of a ROS 1 bag with the header of ROS 2, which has no number."""
    from rosbags.typesys import Stores, get_typestore

    types = dict(store.fielddefs)
    header = "std_msgs/msg/Header"
    if header in types:
        constants, fields = types[header]
        types[header] = (constants, [field for field in fields if field[0] != "seq"])
    own = get_typestore(Stores.EMPTY)
    own.register(types)
    return own
