"""Logs of any length as a small R factor."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import _native, _progress
from ._errors import Error, text_of
from .documents import AccumulatedDrives
from .reading import Source, accumulate

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
        self._drives = _native.Drives()

    def add(self, log: Source | Sequence[Source]) -> Accumulator:
        """Adds logs: files or tables, each a drive; read in pieces, in memory that does not grow with them."""
        with _progress.shown() as progress:
            accumulate(self._drives, log, self._options, progress)
        return self

    def merge(self, other: Accumulator) -> Accumulator:
        """Adds what another has accumulated."""
        self._drives.merge(other._filled())
        return self

    @property
    def summary(self) -> AccumulatedDrives:
        """The document: samples, channels, sources, options."""
        return AccumulatedDrives(json.loads(self.to_json()))

    @property
    def samples(self) -> int:
        """Samples of all logs, estimation and validation data together."""
        summary = self.summary
        return summary.estimation_samples + summary.validation_samples

    def to_json(self) -> str:
        """The document that ``steerwright accumulate`` writes."""
        return self._filled().json()

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes the R factor, for ``identify`` or another process."""
        _native.save(os.fspath(path), self.to_json(), force)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Accumulator:
        """Reads an R factor."""
        found = cls()
        found._drives.load(text_of(path), os.fspath(path))
        return found

    @classmethod
    def from_json(cls, text: str) -> Accumulator:
        """The accumulator of a document."""
        found = cls()
        found._drives.load(text, "the document")
        return found

    def __reduce__(self) -> Any:
        return _restored, (dict(self._options), None if self._drives.is_empty else self.to_json())

    def _filled(self) -> _native.Drives:
        if self._drives.is_empty:
            raise Error("nothing is accumulated", "add a log first")
        return self._drives

    def __repr__(self) -> str:
        return "<Accumulator: empty>" if self._drives.is_empty else f"<Accumulator: {self.samples} samples>"


def _restored(options: dict[str, Any], text: str | None) -> Accumulator:
    found = Accumulator(**options)
    if text is not None:
        found._drives.load(text, "the document")
    return found
