"""Models of the lateral dynamics in a log."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from . import _native, _progress
from ._errors import Error, Warning
from ._native import Log
from ._options import documented
from .accumulator import Accumulator
from .plant import Bicycle, Plant, Torque
from .reading import Source, read

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import IdentifyOptions


@documented("identify")
def identify(
    log: Log | Accumulator | Source | Sequence[Source], **options: Unpack[IdentifyOptions]
) -> Plant | Bicycle | Torque:
    """Identifies the lateral dynamics in a log: steering angle in, yaw rate out.

    ``log`` is a :class:`Log`, an :class:`Accumulator`, or whatever :func:`read` takes, with its options.
    Returns a :class:`Plant`, a :class:`Bicycle` with ``structure="bicycle"``, or with ``structure="torque"`` a
    :class:`Torque`, for which a :class:`Log` is read with ``response="lateral-acceleration"``. Its document is that
    which ``steerwright identify`` writes, byte for byte. Whether it can be trusted is in ``quality``.

    Raises :class:`Error` with a hint.
    """
    keywords: dict[str, Any] = dict(options)
    if isinstance(log, Accumulator):
        with _progress.shown() as progress:
            text = log._filled().identify(keywords, progress)
        return _warned(Plant(text), ())
    if not isinstance(log, Log):
        of_read = {name.replace("-", "_") for name, *_ in _native.describe("read")}
        of_log = {name: keywords.pop(name) for name in of_read & keywords.keys()}
        if keywords.get("structure") == "torque":
            of_log["response"] = "lateral-acceleration"
        log = read(log, **of_log)
    else:
        misplaced = {name.replace("-", "_") for name, *_ in _native.describe("read")}
        wrong = sorted(misplaced & {name for name, value in keywords.items() if value is not None})
        if wrong:
            raise Error(f"{wrong[0]}: the log is read already", "pass it to steerwright.read")
    with _progress.shown() as progress:
        text, traces = _native.identify(log, keywords, progress)
    if traces is None:
        return _warned(Torque(text), log.warnings)
    kind: type[Plant | Bicycle] = Bicycle if '"steerwright/bicycle/' in text[:200] else Plant
    return _warned(kind(text, traces=traces), log.warnings)


def identify_bicycle(log: Log | Source | Sequence[Source], **options: Unpack[IdentifyOptions]) -> Bicycle:
    """Identifies the two-wheel bicycle model (eq 13), scheduled by the speed, for drives of varying speed.

    The options are those of :func:`identify`, of which ``mass``, ``wheelbase`` and ``front_share`` are the
    bicycle's own.
    """
    options["structure"] = "bicycle"
    found = identify(log, **options)
    assert isinstance(found, Bicycle)
    return found


M = TypeVar("M", Plant, Bicycle, Torque, "Plant | Bicycle")


def _warned(model: M, known: Sequence[str]) -> M:
    """The model, with its warnings but for those that the reader has given."""
    evidence = model.evidence
    for warning in evidence.warnings if evidence is not None else ():
        if warning not in known:
            warnings.warn(warning, Warning, stacklevel=3)
    return model
