"""PID steering controllers."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

from . import _native, _progress, documents
from ._errors import Error
from ._options import documented, refuse_outputs
from ._record import Array
from .plant import Bicycle, Document, LateralModel, Plant, Vehicle, html, load_document

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

    def figures(self) -> dict[str, str]:
        """The figures of the report as SVG, by name."""
        return dict(_native.figures_of_controller(self._on(None).to_json(), self._text))

    def _on(self, model: LateralModel | None) -> LateralModel:
        model = model or self._model
        if model is None:
            raise Error("the model of the design is not in pid.json", "pass it as model=")
        return model

    def _repr_html_(self) -> str:
        step = self.evidence.step
        rows = [
            ("gains", f"kp {self.gains.kp:.4g}, ki {self.gains.ki:.4g} 1/s, kd {self.gains.kd:.4g} s"),
            ("sample time", f"{self.sample_time_s} s"),
            ("overshoot", f"{step.overshoot_percent:.2f} %"),
            ("settling time", f"{step.settling_time_s} s"),
            ("specification", "met" if self.met else "not met"),
        ]
        drawn = () if self._model is None else self.figures().values()
        return html(f"Controller of {self.name}", rows, drawn)

    def __repr__(self) -> str:
        met = "met" if self.met else "not met"
        return f"<Controller of {self.name}: specification {met}>"


@documented("design")
def design(model: LateralModel | str | os.PathLike[str], **options: Unpack[DesignOptions]) -> Controller:
    """Designs a PID steering controller (eq 14) to a specification, and verifies it in the loop of FMUs.

    ``model`` is a :class:`Plant`, a :class:`Bicycle`, a :class:`Vehicle`, or the file of one. A specification that is not met is no
    error: see ``met`` and ``evidence``.

    Raises :class:`Error` with a hint, for example where the model failed its validation.
    """
    refuse_outputs("design", options)
    of = model if isinstance(model, (Plant, Bicycle, Vehicle)) else load_document(model)
    with _progress.shown() as progress:
        text = _native.design(of.to_json(), of._file, dict(options), progress)
    return Controller(text, model=of)
