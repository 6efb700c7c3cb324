"""Logs of any length as a small R factor."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

from . import _native, _progress
from ._errors import Error
from .documents import AccumulatedDrives
from .reading import Source, files_and_tables

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import AccumulateOptions


class Accumulator:
    """Drives accumulated into an R factor of a few hundred kilobytes, however long and many they are.

    >>> accumulator = steerwright.Accumulator(horizon=30)
    >>> for drive in drives:
    ...     accumulator.add(drive)
    >>> plant = steerwright.identify(accumulator)

    The options are those of ``steerwright accumulate`` and hold for every log. Accumulators of several machines
    are merged; the model is that of all logs together.
    """

    def __init__(self, **options: Unpack[AccumulateOptions]) -> None:
        _native.words("accumulate", dict(options))
        self._options = options
        self._text: str | None = None
        self._name = "drives.rfactor"

    def add(self, log: Source | Sequence[Source]) -> Accumulator:
        """Adds logs: files or tables, each a drive; read in pieces, in memory that does not grow with them."""
        files, tables = files_and_tables(log)
        with _progress.shown() as progress:
            text = _native.accumulate(files, tables, dict(self._options), progress)
        self._include(text)
        return self

    def merge(self, other: Accumulator) -> Accumulator:
        """Adds what another has accumulated."""
        self._include(other._document()[1])
        return self

    def _include(self, text: str) -> None:
        own = [] if self._text is None else [(self._name, self._text)]
        self._text = _native.merge([*own, ("merged", text)])

    @property
    def summary(self) -> AccumulatedDrives:
        """The document: samples, channels, sources, options."""
        import json

        return AccumulatedDrives(json.loads(self._document()[1]))

    @property
    def samples(self) -> int:
        """Samples of all logs, estimation and validation data together."""
        summary = self.summary
        return summary.estimation_samples + summary.validation_samples

    def to_json(self) -> str:
        """The document that ``steerwright accumulate`` writes."""
        return self._document()[1]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the R factor, for ``identify`` or another process."""
        FilePath(path).write_bytes(self.to_json().encode())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Accumulator:
        """Reads an R factor."""
        found = cls()
        found._name = os.fspath(path)
        found._text = _native.merge([(found._name, FilePath(path).read_text("utf-8"))])
        return found

    def _document(self) -> tuple[str, str]:
        if self._text is None:
            raise Error("nothing is accumulated", "add a log first")
        return self._name, self._text

    def __repr__(self) -> str:
        return "<Accumulator: empty>" if self._text is None else f"<Accumulator: {self.samples} samples>"
