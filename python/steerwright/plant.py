"""Identified models: their documents, and what follows from them."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Union, get_args

import numpy as np
from numpy.typing import ArrayLike

from . import _native, documents
from ._errors import Error, path_of, text_of
from ._libraries import library
from ._record import Array

if TYPE_CHECKING:
    from ._native import Traces


TRIES = 20
"""Draws for each model of a sample: some of an uncertain plant are unstable."""


class Document:
    """A JSON document, kept as it was written."""

    FILE: ClassVar[str]
    VERSION: ClassVar[str] = ""
    """Of the schema, where several are read by different classes."""
    _text: str
    _file: str
    _values: dict[str, Any]
    _read: dict[str, Any]

    def __init__(self, text: str, *, file: str | None = None) -> None:
        try:
            values = json.loads(text)
        except ValueError as error:
            raise Error(
                f"{file or 'the text'}: no JSON document: {error}", f"pass a document such as {self.FILE}"
            ) from error
        schema = values.get("schema") if isinstance(values, dict) else None
        if not isinstance(schema, str) or not schema.startswith(self._schema()):
            kind = self.FILE.removesuffix(".json")
            raise Error(
                f"{file or 'the text'}: the schema is {schema!r}, not that of a {kind}",
                f"pass a document such as {self.FILE}, or read it with steerwright.load",
            )
        self._values = values
        self._read = {}
        self._text = text
        self._file = file or self.FILE

    @classmethod
    def _schema(cls) -> str:
        """The start of the schema."""
        return f"steerwright/{cls.FILE.removesuffix('.json').replace('_', '-')}/{cls.VERSION}"

    def to_json(self) -> str:
        """The document, byte for byte as the command line writes it."""
        return self._text

    @classmethod
    def from_json(cls, text: str) -> Any:
        """The object of a document."""
        return cls(text)

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes the document, whole or not at all. Of files that are there only one of its kind is replaced, others
        with ``force``; never what the document was computed from."""
        _native.save(os.fspath(path), self._text, force)

    def _repr_html_(self) -> str:
        return _native.notebook(self._text)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Any:
        """Reads a document."""
        return cls(text_of(path), file=os.fspath(path))

    def __reduce__(self) -> Any:
        # Signals of a log stay in their process.
        return _restored, (type(self), self._text, self._file)


def _restored(kind: type[Document], text: str, file: str) -> Document:
    return kind(text, file=file)


class SimulatedModel(Document):
    """A model with the signals of its log, where it was identified here."""

    def __init__(self, text: str, *, file: str | None = None, traces: Traces | None = None) -> None:
        super().__init__(text, file=file)
        self._traces = traces

    @property
    def traces(self) -> Traces | None:
        """Measured and simulated signals, where the model was identified here from a log."""
        return self._traces

    def figures(self) -> dict[str, str]:
        """The figures of the report as SVG, by name; without the traces none.

        Raises :class:`Error` where the model was not identified here, so that its signals are unknown.
        """
        return dict(_native.figures_of_model(self._text, self._signals()))

    def report(self) -> str:
        """The page that ``steerwright identify --report`` writes, HTML."""
        return _native.page_of_model(self._text, self._signals())

    def _repr_html_(self) -> str:
        return _native.notebook(self._text, None, self._traces)

    def _signals(self) -> Traces:
        if self._traces is None:
            raise Error(
                f"{self._file}: the signals of the log are not in it",
                "identify the model from its log",
            )
        return self._traces


class FrequencyResponse(NamedTuple):
    """A frequency response."""

    omega: Array
    """Angular frequency, rad/s."""
    response: np.ndarray[Any, np.dtype[np.complex128]]
    """Complex gain."""


class Response(NamedTuple):
    """A response over time."""

    time: Array
    """s."""
    yaw_rate: Array
    """rad/s."""


class Model(NamedTuple):
    """Matrices of a state-space model: x⁺ = A x + B u + K e, y = C x + D u + e."""

    A: Array
    B: Array
    C: Array
    D: Array
    K: Array


class Plant(SimulatedModel, documents.Plant):
    """An identified plant: steering angle (rad, minus the steering offset) in, yaw rate (rad/s) out.

    The attributes are the keys of plant.json; matrices are also here: ``A``, ``B``, ``C``, ``D``, ``K``, ``x0``.
    """

    FILE = "plant.json"
    VERSION = "1"
    quality: documents.Quality

    @property
    def A(self) -> Array:
        """State matrix, shape (n, n)."""
        return self.discrete.A

    @property
    def B(self) -> Array:
        """Input matrix, shape (n, 1)."""
        return self.discrete.B

    @property
    def C(self) -> Array:
        """Output matrix, shape (1, n)."""
        return self.discrete.C

    @property
    def D(self) -> Array:
        """Feedthrough, shape (1, 1)."""
        return self.discrete.D

    @property
    def K(self) -> Array:
        """Kalman gain, shape (n, 1)."""
        return self.discrete.K

    @property
    def x0(self) -> Array:
        """State at the log's first sample, shape (n,)."""
        return self.discrete.x0

    @property
    def sample_time(self) -> float:
        """Sample time, s."""
        return self.discrete.sample_time_s

    @property
    def delay(self) -> float:
        """Pure delay of the input, s; it is not in the matrices."""
        return self.input_delay_s

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.A)

    @property
    def fit(self) -> float:
        """Fit of the simulation on validation data, %."""
        return self.evidence.fit.validation

    @property
    def gain(self) -> float:
        """Yaw rate over input at rest, rad/s over rad; infinite for an integrator."""
        eye = np.eye(self.order)
        try:
            return float((self.C @ np.linalg.solve(eye - self.A, self.B) + self.D)[0, 0])
        except np.linalg.LinAlgError:
            return float("inf")

    def with_delay(self) -> Model:
        """The matrices with the delay as states: whole samples, and the rest between two samples by a
        combination of both, as for an input that is held."""
        samples = self.delay / self.sample_time
        whole = int(np.floor(samples + 1e-9))
        part = max(samples - whole, 0.0)
        model = Model(self.A, self.B, self.C, self.D, self.K)
        # The model's input is (1 - part) u[k - whole] + part u[k - whole - 1].
        taps = np.zeros(whole + 2)
        taps[whole], taps[whole + 1] = 1.0 - part, part
        length = whole + (1 if part > 1e-12 else 0)
        if length == 0:
            return model
        n = self.order
        a = np.zeros((n + length, n + length))
        b = np.zeros((n + length, 1))
        c = np.zeros((1, n + length))
        a[:n, :n], c[:, :n] = model.A, model.C
        for k in range(length):
            a[:n, n + k : n + k + 1] = model.B * taps[k + 1]
            c[:, n + k : n + k + 1] = model.D * taps[k + 1]
            if k > 0:
                a[n + k, n + k - 1] = 1.0
        b[:n] = model.B * taps[0]
        b[n] = 1.0
        gain = np.vstack([model.K, np.zeros((length, 1))])
        return Model(a, b, c, model.D * taps[0], gain)

    def to_control(self, *, delay: bool = True, continuous: bool = False) -> Any:
        """A python-control ``StateSpace`` with ``dt``, or the continuous one (eq 6–8); ``delay=False`` leaves the delay
        out, which is a Padé approximation in the continuous model."""
        control = library("control", "to_control() uses")
        matrices, dt = self._system(delay, continuous), 0 if continuous else self.sample_time
        # A name has no dots there.
        name = self.name.replace(".", "_")
        return control.ss(*matrices, dt, inputs="steering", outputs="yaw_rate", name=name)

    def to_scipy(self, *, delay: bool = True, continuous: bool = False) -> Any:
        """A ``scipy.signal.dlti`` in state space, or an ``lti`` of the continuous model; see :meth:`to_control`."""
        signal = library("scipy.signal", "to_scipy() uses")
        matrices = self._system(delay, continuous)
        return signal.lti(*matrices) if continuous else signal.dlti(*matrices, dt=self.sample_time)

    def _system(self, delay: bool, continuous: bool) -> tuple[Array, Array, Array, Array]:
        """State, input and output matrix and feedthrough."""
        if not continuous:
            return self.with_delay()[:4] if delay else (self.A, self.B, self.C, self.D)
        if self.continuous is None:
            raise Error(
                f"{self.name}: there is no continuous model, since A has no real logarithm",
                "use the discrete one: continuous=False",
            )
        f, g, h, d = self.continuous.F, self.continuous.G, self.continuous.H, self.D
        if not delay or self.delay == 0.0:
            return f, g, h, d
        # In series after the approximation of the delay.
        fp, gp, hp, dp = _pade(self.delay)
        zeros = np.zeros((len(fp), len(f)))
        a = np.block([[f, g @ hp], [zeros, fp]])
        return a, np.vstack([g @ dp, gp]), np.hstack([h, d @ hp]), d @ dp

    def frequency_response(self, omega: ArrayLike | None = None) -> FrequencyResponse:
        """Response from input to yaw rate with the delay, at angular frequencies (rad/s), shape (m,).

        By default 200 frequencies from a hundredth of the Nyquist frequency to just below it.
        """
        w = _frequencies(omega, self.sample_time)
        response = _response(self.A, self.B, self.C, self.D, w * self.sample_time)
        return FrequencyResponse(w, response * np.exp(-1j * w * self.delay))

    def step(self, duration: float = 3.0) -> Response:
        """Yaw rate after a unit step of the input (rad/s per rad), without the delay, over a duration (s)."""
        count = int(np.floor(duration / self.sample_time + 1e-9)) + 1
        states = np.zeros((self.order, 1))
        yaw_rate = np.empty(count)
        for k in range(count):
            yaw_rate[k] = (self.C @ states + self.D)[0, 0]
            states = self.A @ states + self.B
        return Response(np.arange(count, dtype=np.float64) * self.sample_time, yaw_rate)

    def sample(self, n: int, seed: int = 0) -> list[Model]:
        """``n`` models drawn from the uncertainty of the estimate, in the basis of this one's states.

        As in the design, unstable ones are drawn again, so they are of the distribution of stable models.

        Raises :class:`Error` where the uncertainty was not estimated.
        """
        if self.uncertainty is None or self.uncertainty.directions.size == 0:
            raise Error(
                f"{self.name}: the uncertainty was not estimated",
                "identify from a log with more excitation, or accept the nominal model",
            )
        directions = self.uncertainty.directions
        rng = np.random.default_rng(seed)
        models: list[Model] = []
        for _ in range(TRIES * n):
            if len(models) == n:
                return models
            model = self._moved(rng.standard_normal(len(directions)) @ directions)
            if np.abs(np.linalg.eigvals(model.A)).max() < 1.0:
                models.append(model)
        raise Error(
            f"{self.name}: of {TRIES * n} models drawn, {len(models)} are stable, not {n}",
            "identify from a log with more excitation, which determines the poles",
        )

    def _moved(self, change: Array) -> Model:
        """The model with a change of the entries of A, B, C, D, K, each row by row."""
        matrices, start = [], 0
        for matrix in (self.A, self.B, self.C, self.D, self.K):
            end = start + matrix.size
            matrices.append(matrix + change[start:end].reshape(matrix.shape))
            start = end
        return Model(*matrices)

    def __repr__(self) -> str:
        quality = getattr(self, "quality", None)
        grade = "" if quality is None else f", quality {quality.grade}"
        return f"<Plant {self.name}: order {self.order}, fit {self.fit:.2f} % on validation data{grade}>"


class Bicycle(SimulatedModel, documents.Bicycle):
    """The two-wheel bicycle model (eq 13). The attributes are the keys of bicycle.json."""

    FILE = "bicycle.json"
    quality: documents.Quality

    @property
    def fit(self) -> float | None:
        """Fit of the simulation on validation data, %; `None` for stated vehicle data."""
        return None if self.evidence is None else self.evidence.validation_fit

    def at_speed(self, speed: float) -> tuple[Array, Array, Array, Array]:
        """Continuous A, B, C, D at a speed (m/s): states lateral velocity (m/s), yaw rate (rad/s), road-wheel
        angle (rad); input steering angle (rad), outputs yaw rate and lateral velocity. The delay of the steering
        is `vehicle.actuator_delay_s`."""
        k = self.coefficients
        a = np.array(
            [
                [k.A1 / speed, k.A2 / speed - speed, k.B1],
                [k.A3 / speed, k.A4 / speed, k.B2],
                [0.0, 0.0, -1.0 / k.Tn],
            ]
        )
        b = np.array([[0.0], [0.0], [k.n / k.Tn]])
        c = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
        return a, b, c, np.zeros((2, 1))

    def to_control(self, speed: float) -> Any:
        """A continuous python-control ``StateSpace`` at a speed (m/s), without the delay of the steering."""
        control = library("control", "to_control() uses")
        outputs = ["yaw_rate", "lateral_velocity"]
        return control.ss(*self.at_speed(speed), inputs="steering", outputs=outputs)

    def __repr__(self) -> str:
        v = self.vehicle
        length = v.distance_front_m + v.distance_rear_m
        fit = "" if self.fit is None else f", fit {self.fit:.2f} % on validation data"
        return f"<Bicycle: wheelbase {length:.3f} m, steering ratio {v.steering_ratio:.2f}{fit}>"


class Vehicle(SimulatedModel, documents.Vehicle):
    """A vehicle up to the limit of its grip. The attributes are the keys of vehicle.json."""

    FILE = "vehicle.json"
    quality: documents.Quality

    @property
    def fit(self) -> float | None:
        """Fit of the yaw rate, freely simulated on validation data, %; `None` where it was not validated."""
        validation = None if self.evidence is None else self.evidence.validation
        return None if validation is None else validation.yaw_rate

    def parameter(self, name: str) -> documents.VehicleParameter:
        """A parameter of the identified single-track model with its uncertainty, such as
        ``friction_coefficient_front``."""
        parameters = () if self.evidence is None else self.evidence.parameters
        for parameter in parameters:
            if parameter.name == name:
                return parameter
        names = ", ".join(parameter.name for parameter in parameters)
        raise Error(f"{name}: the vehicle has no such parameter", f"it has: {names or 'none, since it was stated'}")

    def __repr__(self) -> str:
        length = self.body.distance_front_m + self.body.distance_rear_m
        fit = "" if self.fit is None else f", fit {self.fit:.2f} % on validation data"
        return f"<Vehicle: wheelbase {length:.3f} m, friction {self.tyres.friction_coefficient:.2f}{fit}>"


class Signals(NamedTuple):
    """Signals of a log, in the units of the channels, by name."""

    time: Array
    """s."""
    inputs: dict[str, Array]
    outputs: dict[str, Array]
    simulated: dict[str, Array]
    """Outputs by simulation, from an initial state at the start of each part; NaN where nothing is simulated."""
    is_validation: np.ndarray[Any, np.dtype[np.bool_]]


class WithSignals(Document):
    """A model whose inputs and outputs have names."""

    def __init__(self, text: str, *, file: str | None = None, signals: Signals | None = None) -> None:
        super().__init__(text, file=file)
        self._signals = signals

    @property
    def signals(self) -> Signals | None:
        """Measured and simulated signals, where the model was identified here from a log."""
        return self._signals


class Torque(WithSignals, documents.Torque):
    """The response of the lateral acceleration to a steering torque. The attributes are the keys of torque.json."""

    FILE = "torque.json"

    @property
    def fit(self) -> float:
        """Fit on validation data, %."""
        return self.evidence.validation_fit

    def command(self, acceleration: ArrayLike, roll: ArrayLike = 0.0, steering_rate: ArrayLike = 0.0) -> Array:
        """The command (in `command_unit`) of a steady lateral acceleration (m/s²), on a road with a roll (rad), while
        the steering angle has a rate (rad/s): arrays of one shape, or scalars."""
        rho = 0.0 if self.roll_coefficient is None else self.roll_coefficient.value
        gravity = 9.80665 * rho * np.sin(np.asarray(roll, dtype=float))
        needed = np.asarray(acceleration, dtype=float) - gravity - self.offset_mps2.value
        friction = np.tanh(np.asarray(steering_rate, dtype=float) / self.friction_rate_radps)
        command: Array = needed / self.acceleration_per_command.value + self.friction.value * friction
        return command

    def __repr__(self) -> str:
        factor = self.acceleration_per_command.value
        return f"<Torque: {factor:.3f} m/s² per {self.command_unit}, fit {self.fit:.2f} % on validation data>"


class Longitudinal(WithSignals, documents.Longitudinal):
    """The response of the speed to accelerator and brake, or to an acceleration command. The attributes are the keys of
    longitudinal.json."""

    FILE = "longitudinal.json"

    @property
    def fit(self) -> float:
        """Fit to the change of the speed in the validation data, %."""
        return self.evidence.validation_fit

    def gain(self, speed: ArrayLike) -> Array:
        """Acceleration per command (m/s² per `command_unit`) at speeds (m/s)."""
        speeds = [row.speed_mps for row in self.gains]
        gains = [row.gain.value for row in self.gains]
        return np.asarray(np.interp(np.asarray(speed, dtype=float), speeds, gains), dtype=float)

    def __repr__(self) -> str:
        return f"<Longitudinal {self.name!r}: fit {self.fit:.2f} % on validation data>"


class MultivariablePlant(WithSignals, documents.MultivariablePlant):
    """An identified plant of any system, from its named inputs to its named outputs, in the units of the channels.

    The attributes are the keys of plant.json, version 2; matrices are also here: ``A``, ``B``, ``C``, ``D``, ``K``, ``x0``.
    They are about the ``offset`` of each channel, and without the delays of the inputs.
    """

    FILE = "plant.json"
    VERSION = "2"
    quality: documents.Quality

    @property
    def A(self) -> Array:
        """State matrix, shape (n, n)."""
        return self.discrete.A

    @property
    def B(self) -> Array:
        """Input matrix, shape (n, inputs)."""
        return self.discrete.B

    @property
    def C(self) -> Array:
        """Output matrix, shape (outputs, n)."""
        return self.discrete.C

    @property
    def D(self) -> Array:
        """Feedthrough, shape (outputs, inputs)."""
        return self.discrete.D

    @property
    def K(self) -> Array:
        """Kalman gain, shape (n, outputs)."""
        return self.discrete.K

    @property
    def x0(self) -> Array:
        """State at the log's first sample, shape (n,)."""
        return self.discrete.x0

    @property
    def sample_time(self) -> float:
        """Sample time, s."""
        return self.discrete.sample_time_s

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.A)

    @property
    def input_names(self) -> list[str]:
        """Names of the inputs, in the order of the columns of ``B``."""
        return [channel.name for channel in self.inputs]

    @property
    def output_names(self) -> list[str]:
        """Names of the outputs, in the order of the rows of ``C``."""
        return [channel.name for channel in self.outputs]

    @property
    def delays(self) -> Array:
        """Pure delay of each input, s, shape (inputs,)."""
        return np.array([channel.delay_s for channel in self.inputs])

    @property
    def fits(self) -> dict[str, float]:
        """Fit of the simulation of each output on validation data, %."""
        return {output.output: output.fit.validation for output in self.evidence.outputs}

    @property
    def fit(self) -> float:
        """The same of all outputs together, each in units of its standard deviation, %."""
        return self.evidence.fit.validation

    def with_delay(self) -> Model:
        """The matrices with the delays of the inputs, whole samples, as states."""
        samples = np.rint(self.delays / self.sample_time).astype(int)
        n, extra = self.order, int(samples.sum())
        a, b = np.zeros((n + extra, n + extra)), np.zeros((n + extra, len(samples)))
        c, d = np.zeros((len(self.C), n + extra)), np.array(self.D)
        a[:n, :n], b[:n], c[:, :n] = self.A, self.B, self.C
        at = n
        for j, count in enumerate(samples):
            if count == 0:
                continue
            # A chain of states, the last of which is the delayed input.
            for k in range(count - 1):
                a[at + k + 1, at + k] = 1.0
            last = at + count - 1
            a[:n, last], c[:, last] = self.B[:, j], self.D[:, j]
            b[:, j], d[:, j] = 0.0, 0.0
            b[at, j] = 1.0
            at += count
        gain = np.vstack([self.K, np.zeros((extra, len(self.C)))])
        return Model(a, b, c, d, gain)

    def to_control(self, *, delay: bool = True, continuous: bool = False) -> Any:
        """A python-control ``StateSpace`` with the names of the channels and ``dt``, or the continuous one, which is
        without delays; ``delay=False`` leaves the delays out."""
        control = library("control", "to_control() uses")
        matrices, dt = self._system(delay, continuous), 0 if continuous else self.sample_time
        name = self.name.replace(".", "_")
        return control.ss(*matrices, dt, inputs=self.input_names, outputs=self.output_names, name=name)

    def to_scipy(self, *, delay: bool = True, continuous: bool = False) -> Any:
        """A ``scipy.signal.dlti`` in state space, or an ``lti`` of the continuous model; see :meth:`to_control`."""
        signal = library("scipy.signal", "to_scipy() uses")
        matrices = self._system(delay, continuous)
        return signal.lti(*matrices) if continuous else signal.dlti(*matrices, dt=self.sample_time)

    def _system(self, delay: bool, continuous: bool) -> tuple[Array, Array, Array, Array]:
        if not continuous:
            return self.with_delay()[:4] if delay else (self.A, self.B, self.C, self.D)
        if self.continuous is None:
            raise Error(
                f"{self.name}: there is no continuous model, since A has no real logarithm",
                "use the discrete one: continuous=False",
            )
        if delay and self.delays.any():
            raise Error(
                f"{self.name}: the continuous model has no states for the delays of its inputs",
                "leave them out with delay=False, or use the discrete model",
            )
        return self.continuous.F, self.continuous.G, self.continuous.H, self.D

    def frequency_response(self, omega: ArrayLike | None = None) -> FrequencyResponse:
        """Responses of all pairs with the delays, at angular frequencies (rad/s), shape (m, outputs, inputs).

        By default 200 frequencies from a hundredth of the Nyquist frequency to just below it.
        """
        w = _frequencies(omega, self.sample_time)
        response = _responses(self.A, self.B, self.C, self.D, w * self.sample_time)
        return FrequencyResponse(w, response * np.exp(-1j * w[:, None, None] * self.delays))

    def simulate(self, inputs: Any, *, outputs: Any = None, x0: ArrayLike | None = None) -> Array:
        """Outputs at the samples of the inputs, shape (samples, outputs), in the units of the channels.

        ``inputs`` is an array of shape (samples, inputs) or a table with a column of each name. The initial state is
        ``x0``, by default the one that makes the simulation fit the measured ``outputs`` best, and without these rest at
        the offsets.
        """
        u = self._table(inputs, self.inputs) - [channel.offset for channel in self.inputs]
        about = np.array([channel.offset for channel in self.outputs])
        for j, count in enumerate(np.rint(self.delays / self.sample_time).astype(int)):
            u[:, j] = u[np.maximum(np.arange(len(u)) - count, 0), j]
        if x0 is None and outputs is not None:
            y = self._table(outputs, self.outputs) - about
            if len(y) != len(u):
                raise Error(f"{len(u)} samples of inputs and {len(y)} of outputs", "pass equally many of both")
            free, row = np.empty((len(u), len(self.C), self.order)), np.array(self.C)
            for k in range(len(u)):
                free[k] = row
                row = row @ self.A
            left = y - self._run(u, np.zeros(self.order))
            # Each output counts in units of its standard deviation, as in the identification.
            scale = np.array([channel.standard_deviation for channel in self.outputs])
            free /= scale[:, None]
            x0 = np.linalg.lstsq(free.reshape(-1, self.order), (left / scale).ravel(), rcond=None)[0]
        simulated: Array = self._run(u, np.zeros(self.order) if x0 is None else np.asarray(x0, dtype=float)) + about
        return simulated

    def _run(self, u: Array, x: Array) -> Array:
        y = np.empty((len(u), len(self.C)))
        for k, now in enumerate(u):
            y[k] = self.C @ x + self.D @ now
            x = self.A @ x + self.B @ now
        return y

    def _table(self, values: Any, channels: Any) -> Array:
        """An array of shape (samples, channels) of an array, or of columns by the names of variables or of the log."""
        if not hasattr(values, "keys"):
            table = np.array(values, dtype=float)
            if table.ndim == 1:
                table = table[:, None]
            if table.ndim == 2 and table.shape[1] == len(channels):
                return _finite(table, channels)
            names = ", ".join(channel.name for channel in channels)
            raise Error(f"an array of the shape {table.shape}", f"pass columns in this order: {names}")
        columns = []
        for channel in channels:
            name = channel.name if channel.name in values else channel.column
            if name not in values:
                raise Error(f"there is no column {channel.name!r}", f"the table has: {', '.join(map(str, values))}")
            columns.append(np.asarray(values[name], dtype=float))
        return _finite(np.column_stack(columns), channels)

    def sample(self, n: int, seed: int = 0) -> list[Model]:
        """``n`` models drawn from the uncertainty of the estimate, in the basis of this one's states; unstable ones are
        drawn again.

        Raises :class:`Error` where the uncertainty was not estimated.
        """
        if self.uncertainty is None or self.uncertainty.directions.size == 0:
            raise Error(f"{self.name}: the uncertainty was not estimated", "identify from a log with more excitation")
        directions = self.uncertainty.directions
        rng = np.random.default_rng(seed)
        models: list[Model] = []
        for _ in range(TRIES * n):
            if len(models) == n:
                return models
            change = rng.standard_normal(len(directions)) @ directions
            matrices, start = [], 0
            for matrix in (self.A, self.B, self.C, self.D, self.K):
                end = start + matrix.size
                matrices.append(matrix + change[start:end].reshape(matrix.shape))
                start = end
            if np.abs(np.linalg.eigvals(matrices[0])).max() < 1.0:
                models.append(Model(*matrices))
        raise Error(
            f"{self.name}: of {TRIES * n} models drawn, {len(models)} are stable, not {n}",
            "identify from a log with more excitation, which determines the poles",
        )

    def __repr__(self) -> str:
        fits = ", ".join(f"{name} {fit:.2f} %" for name, fit in self.fits.items())
        shape = f"{len(self.inputs)} inputs, {len(self.outputs)} outputs"
        return f"<MultivariablePlant {self.name}: {shape}, order {self.order}, fit {fits} on validation data>"


LateralModel = Union[Plant, Bicycle, Vehicle]
"""A model that a controller is designed on."""

AnyModel = Union[LateralModel, MultivariablePlant, Torque, Longitudinal]
"""What is identified."""

MODELS: tuple[type[Document], ...] = get_args(AnyModel)


def kind_of(text: str, kinds: Sequence[type[Document]] = (Plant, Bicycle, Vehicle)) -> Any:
    """The class of a document, of some; the first where it is of none."""
    found = (kind for kind in kinds if f'"{kind._schema()}' in text[:200])
    return next(found, kinds[0])


def load_document(file: str | os.PathLike[str], kinds: Sequence[type[Document]] = (Plant, Bicycle, Vehicle)) -> Any:
    """The object of a document in a file."""
    text = text_of(file)
    return kind_of(text, kinds)(text, file=path_of(file))


PADE_ORDER = 4
"""Its phase differs from that of the delay T by less than 1° below 4/T rad/s."""


def _pade(delay: float) -> tuple[Array, Array, Array, Array]:
    """The Padé approximation of a delay (s), in controllable canonical form."""
    n = PADE_ORDER
    terms = [math.comb(n, k) * math.factorial(2 * n - k) / math.factorial(2 * n) * delay**k for k in range(n + 1)]
    # Both from the constant term on, with a leading coefficient of 1 in the denominator.
    below = np.array(terms) / terms[n]
    above = below * (-1.0) ** np.arange(n + 1)
    a = np.eye(n, k=1)
    a[-1] = -below[:n]
    feedthrough = above[n]
    c = (above[:n] - feedthrough * below[:n])[None, :]
    return a, np.eye(n)[:, -1:], c, np.array([[feedthrough]])


def _responses(a: Array, b: Array, c: Array, d: Array, angle: Array) -> Any:
    """C (z − A)⁻¹ B + D at z = exp(j·angle), shape (m, outputs, inputs)."""
    z = np.exp(1j * angle)[:, None, None]
    solved = np.linalg.solve(z * np.eye(len(a)) - a, np.broadcast_to(b, (len(angle), *b.shape)))
    return c @ solved + d


def _finite(table: Array, channels: Any) -> Array:
    """The table of the channels, without a number that would be that of every later sample."""
    rows, columns = np.nonzero(~np.isfinite(table))
    if len(rows):
        name = channels[columns[0]].name
        raise Error(
            f"{name} is {table[rows[0], columns[0]]} at sample {rows[0]}, and at {len(rows) - 1} more places",
            "interpolate or cut what is missing before simulating",
        )
    return table


def _frequencies(omega: ArrayLike | None, sample_time: float) -> Array:
    """Those that are stated, rad/s, or 200 from a hundredth of the Nyquist frequency to just below it."""
    points = np.geomspace(0.01, 0.99, 200) * np.pi / sample_time if omega is None else omega
    w: Array = np.atleast_1d(np.asarray(points, dtype=float))
    if not np.isfinite(w).all():
        raise Error("an angular frequency is not a finite number", "pass finite numbers, in rad/s")
    return w


def _response(a: Array, b: Array, c: Array, d: Array, angle: Array) -> Any:
    """The same of one input and one output."""
    return _responses(a, b, c, d, angle)[:, 0, 0]
