"""Models of the lateral dynamics in a log."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, Union, overload

import numpy as np
from numpy.typing import ArrayLike

from . import _native, _progress
from ._errors import ArgumentError, Error, warn
from ._native import Log
from ._options import documented, refuse_outputs
from .accumulator import Accumulator
from .plant import (
    MODELS,
    AnyModel,
    Bicycle,
    LateralModel,
    Longitudinal,
    MultivariablePlant,
    Plant,
    Signals,
    Torque,
    Vehicle,
    kind_of,
)
from .reading import Source, read

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import IdentifyOptions, ModelOptions

AnyLog = Union[Log, Accumulator, Source, Sequence[Source]]
"""A log, what is accumulated of many, or what :func:`read` takes."""


@overload
def identify(log: Accumulator, **options: Unpack[ModelOptions]) -> Plant: ...
@overload
def identify(
    log: AnyLog,
    yaw_rate: ArrayLike | None = None,
    dt: float | None = None,
    *,
    speed: ArrayLike | None = None,
    structure: Literal["state-space"],
    **options: Unpack[ModelOptions],
) -> Plant: ...
@overload
def identify(
    log: AnyLog,
    yaw_rate: ArrayLike | None = None,
    dt: float | None = None,
    *,
    speed: ArrayLike | None = None,
    structure: Literal["bicycle"],
    **options: Unpack[ModelOptions],
) -> Bicycle: ...
@overload
def identify(
    log: AnyLog,
    yaw_rate: ArrayLike | None = None,
    dt: float | None = None,
    *,
    speed: ArrayLike | None = None,
    structure: Literal["single-track"],
    **options: Unpack[ModelOptions],
) -> Vehicle: ...
@overload
def identify(log: AnyLog, *, structure: Literal["torque"], **options: Unpack[ModelOptions]) -> Torque: ...
@overload
def identify(log: AnyLog, *, structure: Literal["longitudinal"], **options: Unpack[ModelOptions]) -> Longitudinal: ...
@overload
def identify(
    log: AnyLog,
    yaw_rate: ArrayLike | None = None,
    dt: float | None = None,
    *,
    speed: ArrayLike | None = None,
    structure: Literal["auto"] = "auto",
    **options: Unpack[ModelOptions],
) -> LateralModel: ...
@overload
def identify(
    log: AnyLog,
    yaw_rate: ArrayLike | None = None,
    dt: float | None = None,
    *,
    speed: ArrayLike | None = None,
    **options: Unpack[IdentifyOptions],
) -> AnyModel: ...
@documented("identify")
def identify(
    log: AnyLog,
    yaw_rate: ArrayLike | None = None,
    dt: float | None = None,
    *,
    speed: ArrayLike | None = None,
    **options: Unpack[IdentifyOptions],
) -> AnyModel:
    """Identifies the lateral dynamics in a log: steering angle in, yaw rate out.

    ``log`` is a :class:`Log`, an :class:`Accumulator`, or whatever :func:`read` takes, with its options; or three
    arguments are the steering angle (rad), the yaw rate (rad/s) and the time between their samples (s), with the ``speed``
    (m/s, a number or an array) if it is known.
    By default the model is a :class:`Plant`, a :class:`Bicycle` or a :class:`Vehicle`, whichever has
    the smallest error on the validation data; ``structure="state-space"``, ``"bicycle"`` and ``"single-track"`` name one
    of them, another ``structure`` the class of its document, such as :class:`Torque`. A :class:`Log` is read with the
    ``response`` that :func:`read` states for the structure. Several channels in ``input_channel`` and ``output_channel``, or
    channels that are no steering angle and no yaw rate, make a :class:`MultivariablePlant` of any system, also
    where type checkers expect the model of a vehicle. The document is that which ``steerwright identify`` writes, byte
    for byte. Whether it can be trusted is in ``quality``.

    Raises :class:`Error` with a hint.
    """
    keywords: dict[str, Any] = dict(options)
    refuse_outputs("identify", keywords)
    if yaw_rate is not None or dt is not None or speed is not None:
        log = _of_arrays(log, yaw_rate, dt, speed)
    if isinstance(log, Accumulator):
        with _progress.shown() as progress:
            plant = Plant(log._filled().identify(keywords, progress))
        _warn(plant, ())
        return plant
    if not isinstance(log, Log):
        of_read = {name.replace("-", "_") for name, *_ in _native.describe("read")}
        of_log = {name: keywords.pop(name) for name in of_read & keywords.keys()}
        of_log.setdefault("response", _native.response(keywords))
        log = read(log, **of_log)
    else:
        misplaced = {name.replace("-", "_") for name, *_ in _native.describe("read")}
        wrong = sorted(misplaced & {name for name, value in keywords.items() if value is not None})
        if wrong:
            raise Error(f"{wrong[0]}: the log is read already", "pass it to steerwright.read")
    with _progress.shown() as progress:
        text, traces, channels = _native.identify(log, keywords, progress)
    kind = kind_of(text, MODELS)
    model: AnyModel
    if channels is not None:
        model = kind(text, signals=Signals(*channels))
    else:
        model = kind(text) if traces is None else kind(text, traces=traces)
    _warn(model, log.warnings)
    return model


def _of_arrays(steering: Any, yaw_rate: Any, dt: Any, speed: Any) -> dict[str, Any]:
    """The table of sampled signals."""
    if yaw_rate is None or isinstance(dt, bool) or not isinstance(dt, (int, float, np.number)) or not dt > 0:
        raise ArgumentError(
            f"dt={dt!r}: the yaw rate and the time between samples are expected after the steering angle",
            "identify(steering, yaw_rate, dt), in rad, rad/s and s",
        )
    angle, rate = np.asarray(steering), np.asarray(yaw_rate)
    if angle.ndim != 1 or angle.shape != rate.shape:
        raise ArgumentError(
            f"the steering angle has the shape {angle.shape}, the yaw rate {rate.shape}",
            "pass two vectors of equal length",
        )
    table = {"time_s": dt * np.arange(len(angle)), "steering_angle_rad": angle, "yaw_rate_radps": rate}
    return table if speed is None else {**table, "speed_mps": np.broadcast_to(speed, angle.shape)}


def identify_bicycle(log: Log | Source | Sequence[Source], **options: Unpack[IdentifyOptions]) -> Bicycle:
    """Identifies the two-wheel bicycle model (eq 13), scheduled by the speed, for drives of varying speed.

    The options are those of :func:`identify`, of which ``mass``, ``wheelbase`` and ``front_share`` are the
    bicycle's own.
    """
    options["structure"] = "bicycle"
    found = identify(log, **options)
    assert isinstance(found, Bicycle)
    return found


def _warn(model: AnyModel, known: Sequence[str]) -> None:
    """Gives the warnings of a model but for those that the reader has given."""
    evidence = model.evidence
    for warning in evidence.warnings if evidence is not None else ():
        if warning not in known:
            warn(warning)
