"""Controllers of the steering and of the speed."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from . import _native, _progress, documents
from ._errors import Error
from ._libraries import library
from ._options import documented, refuse_outputs
from ._record import Array
from .plant import Bicycle, Document, LateralModel, Longitudinal, Plant, Vehicle, load_document

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import DesignOptions


class YawStep(NamedTuple):
    """A yaw step of the closed loop."""

    time: Array
    """s."""
    yaw: Array
    """rad."""
    steering: Array
    """rad, in steering coordinates."""


class Controller(Document, documents.Pid):
    """A PID steering controller (eq 14). The attributes are the keys of pid.json."""

    FILE = "pid.json"

    def __init__(self, text: str, *, file: str | None = None, model: LateralModel | None = None) -> None:
        super().__init__(text, file=file)
        self._model = model

    @property
    def met(self) -> bool:
        """Whether the specification is met on the model that the controller was designed for."""
        return bool(self.evidence.met)

    def step(self, duration: float = 3.0, model: LateralModel | None = None) -> YawStep:
        """A yaw step of 5° on the model of the design, or on another one, over a duration (s)."""
        document = self._on(model).to_json()
        return YawStep(*_native.yaw_step(document, self._text, duration))

    def to_control(self, *, speed: float | None = None) -> Any:
        """A python-control ``StateSpace`` with ``dt`` (eq 14 as the FMU samples it), from the yaw reference, the yaw and
        the feedforward of the steering to the steering angle; without limits and anti-windup, which are not linear.
        ``speed`` (m/s) is that of the gains of a schedule."""
        control = library("control", "to_control() uses")
        g, ts = self._gains(speed), self.sample_time_s
        filtered = g["derivative_filter_time_s"] / (g["derivative_filter_time_s"] + ts)
        kp, ki, kd = g["kp"], g["ki"] * ts, g["kd"] / (g["derivative_filter_time_s"] + ts)
        b, c = g["setpoint_weight_proportional"], g["setpoint_weight_derivative"]
        # States: the sum of the errors, and the memory of the derivative.
        return control.ss(
            [[1.0, 0.0], [0.0, filtered]],
            [[1.0, -1.0, 0.0], [c, -1.0, 0.0]],
            [[ki, kd * (filtered - 1.0)]],
            [[kp * b + ki + kd * c, -(kp + ki + kd), 1.0]],
            ts,
            inputs=["yaw_reference", "yaw", "steering_feedforward"],
            outputs="steering",
            name=self.name.replace(".", "_"),
        )

    def _gains(self, speed: float | None) -> dict[str, float]:
        """The gains, of a schedule at a speed: linear between its speeds and constant beyond them."""
        entries = self.schedule or ()
        if speed is None or not entries:
            if entries:
                low, high = entries[0].speed_mps, entries[-1].speed_mps
                raise Error(
                    f"{self.name}: the gains depend on the speed, from {low:g} to {high:g} m/s",
                    f"state one, such as speed={low:g}",
                )
            return self.gains.to_dict()
        gains = [entry.gains.to_dict() for entry in entries]
        speeds = [entry.speed_mps for entry in entries]
        return {name: float(np.interp(speed, speeds, [one[name] for one in gains])) for name in gains[0]}

    def figures(self) -> dict[str, str]:
        """The figures of the report as SVG, by name."""
        return dict(_native.figures_of_controller(self._on(None).to_json(), self._text))

    def _on(self, model: LateralModel | None) -> LateralModel:
        model = model or self._model
        if model is None:
            raise Error("the model of the design is not in pid.json", "pass it as model=")
        return model

    def _repr_html_(self) -> str:
        return _native.notebook(self._text, None if self._model is None else self._model.to_json())

    def __repr__(self) -> str:
        met = "met" if self.met else "not met"
        return f"<Controller of {self.name}: specification {met}>"


class SpeedController(Document, documents.SpeedController):
    """A controller of the speed. The attributes are the keys of speed_controller.json."""

    FILE = "speed_controller.json"

    @property
    def met(self) -> bool:
        """Whether the specification is met on the model that the controller was designed for."""
        return bool(self.evidence.met)

    def __repr__(self) -> str:
        met = "met" if self.met else "not met"
        return f"<SpeedController of {self.name}: specification {met}>"


@overload
def design(model: LateralModel, **options: Unpack[DesignOptions]) -> Controller: ...
@overload
def design(model: Longitudinal, **options: Unpack[DesignOptions]) -> SpeedController: ...
@overload
def design(
    model: str | os.PathLike[str], **options: Unpack[DesignOptions]
) -> Controller | SpeedController: ...
@documented("design")
def design(
    model: LateralModel | Longitudinal | str | os.PathLike[str], **options: Unpack[DesignOptions]
) -> Controller | SpeedController:
    """Designs a controller to a specification, and verifies it in the loop of FMUs: a PID steering controller (eq 14), or
    of a :class:`Longitudinal` a controller of the speed.

    ``model`` is a :class:`Plant`, a :class:`Bicycle`, a :class:`Vehicle`, a :class:`Longitudinal`, or the file of one. A
    specification that is not met is no error: see ``met`` and ``evidence``.

    Raises :class:`Error` with a hint, for example where the model failed its validation.
    """
    refuse_outputs("design", options)
    kinds = (Plant, Bicycle, Vehicle, Longitudinal)
    of: Any = model if isinstance(model, Document) else load_document(model, kinds)
    with _progress.shown() as progress:
        text = _native.design(of.to_json(), of._file, dict(options), progress)
    return SpeedController(text) if isinstance(of, Longitudinal) else Controller(text, model=of)
