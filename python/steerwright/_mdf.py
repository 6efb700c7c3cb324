"""Tables as an MDF file, for the commands that read files."""

from __future__ import annotations

import struct
from pathlib import Path as FilePath
from typing import Any

import numpy as np


def write(tables: list[tuple[str, dict[str, Any]]], file: FilePath) -> None:
    """A group for each table. The clock is found by its name, as in a table."""
    with open(file, "wb") as opened:
        at = 64 + HEADER

        def block(kind: bytes, links: list[int], data: bytes) -> int:
            nonlocal at
            own, length = at, 24 + 8 * len(links) + len(data)
            opened.write(struct.pack("<4s4xQQ", kind, length, len(links)))
            opened.write(struct.pack(f"<{len(links)}Q", *links) + data + bytes(-length % 8))
            at += length + -length % 8
            return own

        def text(value: str) -> int:
            return block(b"##TX", [], value.encode() + b"\0")

        opened.write(bytes(at))
        group = 0
        for name, columns in reversed(tables):
            channel = 0
            for index, column in reversed(list(enumerate(columns))):
                # A number of 64 bits, little-endian.
                number = struct.pack("<BBBBII", 0, 0, 4, 0, 8 * index, 64) + bytes(60)
                channel = block(b"##CN", [channel, 0, text(column), 0, 0, 0, 0, 0], number)
            rows = len(next(iter(columns.values())))
            size = struct.pack("<QQHH4xII", 0, rows, 0, 0, 8 * len(columns), 0)
            records = block(b"##CG", [0, channel, text(name), 0, 0, 0], size)
            values = np.column_stack([np.asarray(column, dtype="<f8") for column in columns.values()])
            data = block(b"##DT", [], values.tobytes())
            group = block(b"##DG", [group, records, data, 0], bytes(8))
        opened.seek(0)
        opened.write(struct.pack("<8s8s8s4xH34x", b"MDF     ", b"4.10    ", b"steerwr ", 410))
        links = struct.pack("<6Q", group, 0, 0, 0, 0, 0)
        opened.write(struct.pack("<4s4xQQ", b"##HD", HEADER, 6) + links + bytes(32))


HEADER = 24 + 6 * 8 + 32
"""Bytes of the block after the identification."""
