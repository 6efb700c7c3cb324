import os
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Drives",
    "Log",
    "Scratch",
    "Traces",
    "__version__",
    "describe",
    "design",
    "figures_of_controller",
    "figures_of_model",
    "identify",
    "in_python",
    "main",
    "notebook",
    "page_of_model",
    "read",
    "response",
    "save",
    "words",
    "yaw_step",
]
__version__: str

_Progress = Callable[[str, int, int], None] | None
_Signals = dict[str, NDArray[np.float64]]
_Channels = tuple[NDArray[np.float64], _Signals, _Signals, _Signals, NDArray[np.bool_]]
_Tables = list[tuple[str, dict[str, Any]]] | None

@final
class Log:
    """A log on one grid. SI units and radians, ISO 8855 signs; arrays are read-only views."""

    @property
    def name(self) -> str:
        """The first file's name without its ending."""
    @property
    def sample_time(self) -> float:
        """Sample time, s."""
    @property
    def steering_ratio(self) -> float:
        """Steering angle over road-wheel angle."""
    @property
    def time(self) -> NDArray[np.float64]:
        """The log's time at each sample, s, shape (n,)."""
    @property
    def steering(self) -> NDArray[np.float64]:
        """Steering angle in the log's coordinates, rad, shape (n,): held over each sample."""
    @property
    def yaw_rate(self) -> NDArray[np.float64]:
        """Yaw rate, rad/s, shape (n,)."""
    @property
    def speed(self) -> NDArray[np.float64] | None:
        """Speed, m/s, shape (n,); `None` where the log has none."""
    @property
    def segments(self) -> list[tuple[int, int]]:
        """First sample and one after the last of each segment without a gap."""
    @property
    def warnings(self) -> list[str]:
        """Warnings of the reader."""
    @property
    def channels(self) -> list[tuple[str, str, str, int]]:
        """Role, column, unit and number of rows of each channel."""
    def to_pandas(self) -> Any:
        """A data frame over time, with names that `read` knows."""
    def __len__(self) -> int: ...

@final
class Traces:
    """Measured and simulated signals of an identification, shape (n,); arrays are read-only views."""

    @property
    def time(self) -> NDArray[np.float64]:
        """The log's time, s."""
    @property
    def steering(self) -> NDArray[np.float64]:
        """Steering angle, rad."""
    @property
    def yaw_rate(self) -> NDArray[np.float64]:
        """Measured yaw rate, rad/s."""
    @property
    def simulated_yaw_rate(self) -> NDArray[np.float64]:
        """Simulated yaw rate, rad/s; the initial state is estimated at the start of each part."""
    @property
    def yaw(self) -> NDArray[np.float64]:
        """Integral of the measured yaw rate, rad."""
    @property
    def simulated_yaw(self) -> NDArray[np.float64]:
        """Integral of the simulated yaw rate, rad."""
    @property
    def is_validation(self) -> NDArray[np.bool_]:
        """Whether the sample is validation data."""

@final
class Drives:
    """Accumulated drives; none at the start."""

    def __new__(cls) -> Drives: ...
    @property
    def is_empty(self) -> bool:
        """Whether nothing is accumulated."""
    def add(
        self,
        files: list[str] | None,
        tables: _Tables,
        keywords: dict[str, Any],
        progress: _Progress,
    ) -> None:
        """Adds logs."""
    def load(self, document: str, file: str) -> None:
        """Adds the drives of a document."""
    def merge(self, other: Drives) -> None:
        """Adds what another has accumulated."""
    def json(self) -> str:
        """The document."""
    def identify(self, keywords: dict[str, Any], progress: _Progress) -> str:
        """Identifies the plant: its document."""

@final
class Scratch:
    """A temporary folder, removed at the end; one of a killed process with the next of a later one."""

    def __new__(cls) -> Scratch: ...
    def __enter__(self) -> FilePath: ...
    def __exit__(self, *raised: object) -> None: ...

def main(arguments: list[str], program: list[str]) -> int: ...
def describe(
    subcommand: str,
) -> list[tuple[str, str | None, list[str], bool, str | None, str]]: ...
def in_python(text: str) -> str: ...
def words(subcommand: str, keywords: dict[str, Any]) -> list[str]: ...
def save(path: str | os.PathLike[str], document: str, force: bool) -> None: ...
def response(keywords: dict[str, Any]) -> str: ...
def read(files: list[str] | None, tables: _Tables, keywords: dict[str, Any], progress: _Progress) -> Log: ...
def identify(
    log: Log, keywords: dict[str, Any], progress: _Progress
) -> tuple[str, Traces | None, _Channels | None]: ...
def design(document: str, file: str, keywords: dict[str, Any], progress: _Progress) -> str: ...
def yaw_step(document: str, controller: str, until_s: float) -> list[NDArray[np.float64]]: ...
def figures_of_model(document: str, traces: Traces) -> list[tuple[str, str]]: ...
def figures_of_controller(document: str, controller: str) -> list[tuple[str, str]]: ...
def page_of_model(document: str, traces: Traces) -> str: ...
def notebook(document: str, model: str | None = None, traces: Traces | None = None) -> str: ...
