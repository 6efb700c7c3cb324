"""What works on files: packing, checking, comparing, sweeping."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, NamedTuple, Union

from . import _command, documents
from ._errors import ArgumentError, Error
from ._libraries import library
from ._options import documented, lines
from .controller import Controller, SpeedController
from .plant import (
    MODELS,
    Document,
    LateralModel,
    Longitudinal,
    MultivariablePlant,
    Torque,
    load_document,
)
from .reading import Source, one_file

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import (
        BuildOptions,
        CheckOptions,
        CompareOptions,
        ExciteOptions,
        ExportOptions,
        InspectOptions,
        MergeSweepOptions,
        PackageOptions,
        PathOptions,
        Stack,
        SweepOptions,
    )

File = Union[str, "os.PathLike[str]"]


def options(command: str) -> None:
    """Prints the options of a function with their units and defaults."""
    try:
        found = lines(command)
    except ValueError as error:
        raise ArgumentError(str(error), "pass the name of a function, such as design or sweep merge") from error
    print("\n".join(found))


class Path(Document, documents.Path):
    """A reference path. The attributes are the keys of path.json."""

    FILE = "path.json"

    def __repr__(self) -> str:
        return f"<Path {self.name}: {self.points[-1].distance_m:.0f} m at {self.speed_mps} m/s>"


@documented("path")
def path(track: File | None = None, **options: Unpack[PathOptions]) -> Path:
    """Makes a reference path: from recorded points (CSV, GPX, NMEA), from segments (TOML), or the standard road.

    ``pid``, ``plant`` and ``speed_controller`` may be objects of this package.
    """
    keywords: dict[str, Any] = dict(options)
    with _command.folder() as folder:
        for name in ("pid", "plant", "speed_controller"):
            if keywords.get(name) is not None:
                keywords[name] = _command.as_files([keywords[name]], folder)[0]
        out = folder / "out" / "path.json"
        out.parent.mkdir()
        positional = [] if track is None else [track]
        _command.run("path", positional, {**keywords, "output": out})
        return Path(out.read_text("utf-8"))


class Manoeuvre(Document, documents.Manoeuvre):
    """A manoeuvre to record. The attributes are the keys of excitation.json."""

    FILE = "excitation.json"

    def to_numpy(self) -> Any:
        """What is steered: a structured array with the fields ``time_s``, ``steering_rad`` and ``speed_mps``."""
        import numpy

        count = round(self.block_s / self.sample_time_s)
        table = numpy.zeros(
            count * len(self.schedule), [("time_s", float), ("steering_rad", float), ("speed_mps", float)]
        )
        table["time_s"] = self.sample_time_s * numpy.arange(len(table))
        for k, block in enumerate(self.schedule):
            signal = self.signals[block.signal]
            rows = table[k * count : (k + 1) * count]
            side = -1.0 if block.mirrored else 1.0
            rows["steering_rad"][: len(signal.steering_rad)] = side * numpy.asarray(signal.steering_rad)
            rows["speed_mps"] = signal.speed_mps
        return table

    @property
    def goal(self) -> str:
        """What is determined: ``response``, ``understeer`` or ``tyre-limit``."""
        return str(self.purpose.to_dict().get("goal", "response"))

    def __repr__(self) -> str:
        time, error = self.block_s * len(self.schedule), 200.0 * self.expected.largest_error
        known = {
            "understeer": f"understeer gradient to ±{error / 100.0:.2g} rad.s2/m",
            "tyre-limit": f"friction to ±{error:.1f} %",
        }.get(self.goal, f"response to ±{error:.1f} %")
        return f"<Manoeuvre {self.name}: {self.kind} of {time:.0f} s, {known}>"


@documented("excite")
def excite(model: LateralModel | File, **options: Unpack[ExciteOptions]) -> Manoeuvre:
    """Designs the manoeuvre to record: the steering that identifies a vehicle best, within limits.

    ``model`` is a bicycle or a vehicle, also of a weak log, or the file of one or of vehicle data (TOML).
    """
    with _command.folder() as folder:
        files = _command.as_files([model], folder)
        out = folder / "out" / "excitation.json"
        out.parent.mkdir()
        _command.run("excite", files, {**options, "output": out})
        return Manoeuvre(out.read_text("utf-8"))


Packed = Union[LateralModel, Longitudinal, MultivariablePlant, Controller, SpeedController, Path, Manoeuvre, File]
"""What is packed as an FMU."""


@documented("package", {"json"})
def package(
    models: Packed | Sequence[Packed],
    **options: Unpack[PackageOptions],
) -> dict[str, FilePath]:
    """Packs documents as FMI 2.0 Co-Simulation units into the folder ``out``, and with ``ssp`` their loop.

    Returns the files by the names of their models, such as ``IdentifiedPlant``, of named channels ``MultivariablePlant``; a
    package by that of its file.
    """
    with _command.folder() as folder:
        files = _command.as_files(models, folder)
        written = _command.run("package", files, dict(options)).value
    return {w.get("fmu") or FilePath(w["file"]).stem: FilePath(w["file"]) for w in written}


class Finding(NamedTuple):
    """A finding of the checker."""

    severity: str
    """``error``, ``warning`` or ``note``."""
    message: str
    """What is found, where, and by which rule."""
    details: dict[str, Any]
    """The finding as ``steerwright check --json`` prints it."""


class Checked(NamedTuple):
    """The findings of an archive."""

    archive: str
    errors: int
    warnings: int
    findings: list[Finding]

    @property
    def is_clean(self) -> bool:
        """Whether there are no errors."""
        return self.errors == 0


@documented("check", {"force", "json"})
def check(fmu: File, **options: Unpack[CheckOptions]) -> Checked:
    """Checks an FMU of any tool against FMI 2.0; with ``run=True`` also its binary, in another process."""
    (report,) = _command.run("check", [fmu], dict(options)).value
    findings = [Finding(f["severity"], f.get("message", ""), f) for f in report["findings"]]
    return Checked(report["archive"], report["errors"], report["warnings"], findings)


@documented("inspect")
def inspect(log: Source, **options: Unpack[InspectOptions]) -> dict[str, Any]:
    """The channels of a log: units, rates, ranges, gaps, and which look like steering, yaw rate or speed.

    ``log`` is a file or a table that :func:`read` takes. Returns what ``steerwright inspect --json`` prints. Times
    count from the first sample, which is at ``log_start_s``.
    """
    with one_file(log, options) as (name, file, unread):
        found: dict[str, Any] = _command.run("inspect", [file], dict(options), names={str(file): name}).value
    losses = [loss.replace(str(file), name) for loss in found["losses"]]
    return {**found, "file": name, "losses": losses + unread}


@documented("export", {"json", "for"})
def export(
    model: LateralModel | Torque | File, stack: Stack, **options: Unpack[ExportOptions]
) -> dict[str, Any]:
    """The parameters of a driving stack, such as ``autoware``, from a model, with standard errors, units and conventions;
    with ``output`` also as the stack's file.

    Returns what ``steerwright export --json`` prints: ``parameters``, ``missing`` and ``convention``.
    """
    with _command.folder() as folder:
        files = _command.as_files([model], folder)
        found: dict[str, Any] = _command.run("export", files, {**options, "for": stack}).value
    return found


Compared = Union[LateralModel, MultivariablePlant, File]


@documented("compare", {"json"})
def compare(models: Compared | Sequence[Compared], **options: Unpack[CompareOptions]) -> dict[str, Any]:
    """Compares models with a drive, on each other's plants, and on a vehicle that represents the truth.

    Plants of named channels each simulate the ``log``, and the fits of their outputs are returned.
    ``pid`` may be a list of controllers of this package. Returns what ``steerwright compare --json`` prints.
    """
    keywords: dict[str, Any] = dict(options)
    with _command.folder() as folder:
        files = _command.as_files(models, folder)
        controllers = keywords.get("pid")
        if controllers is not None and not isinstance(controllers, (str, os.PathLike)):
            controllers = [controllers] if isinstance(controllers, Controller) else controllers
            keywords["pid"] = [
                str(item if isinstance(item, str) else _command.as_files([item], folder)[0])
                for item in controllers
            ]
        found: dict[str, Any] = _command.run("compare", files, keywords).value
    return found


@documented("build", {"json"})
def build(log: File | Sequence[File], **options: Unpack[BuildOptions]) -> dict[str, Any]:
    """Identifies, designs, packs, tracks and reports for one drive, into the folder ``out``.

    Returns what ``steerwright build --json`` prints.
    """
    logs = list(log) if isinstance(log, (list, tuple)) else [log]
    found: dict[str, Any] = _command.run("build", logs, dict(options)).value
    return found


class Sweep:
    """The results of a study."""

    def __init__(self, file: FilePath | None, summary: dict[str, Any], met: bool) -> None:
        self.file = file
        """The results, a row a run."""
        self.summary = summary
        """What ``steerwright sweep --json`` prints."""
        self.met = met
        """Whether all requirements are met."""

    def _written(self) -> FilePath:
        if self.file is None:
            raise Error("the shard has no runs", "there are more shards than runs")
        return self.file

    def to_pandas(self) -> Any:
        """The results as a pandas data frame."""
        return library("pandas", "to_pandas() uses").read_csv(self._written())

    def to_numpy(self) -> Any:
        """The results as a structured array, a field a column."""
        import numpy

        return numpy.genfromtxt(
            self._written(), delimiter=",", names=True, dtype=None, encoding="utf-8", deletechars=""
        )

    def __repr__(self) -> str:
        if "outcomes" not in self.summary:
            return f"<Piece of a sweep: {self.summary['runs']} runs>"
        text = ", ".join(f"{o['runs']} {o['outcome']}" for o in self.summary["outcomes"])
        return f"<Sweep of {self.summary['rows']} runs: {text}>"


@documented("sweep", {"json", "serve"})
def sweep(study: File, **options: Unpack[SweepOptions]) -> Sweep:
    """Runs a Monte Carlo study (TOML) over closed loops of FMUs; the results go to ``output`` (results.csv).

    Ctrl-C keeps the finished runs: ``resume=True`` continues. With ``shard="I/N"`` only that piece is made, for
    :func:`merge_sweep`; ``file`` is `None` if it has no runs.
    """
    met, summary = _command.run("sweep", [study], dict(options))
    file = summary["file"]
    return Sweep(None if file is None else FilePath(file), summary, met)


@documented("sweep merge", {"json"})
def merge_sweep(study: File, pieces: Sequence[File], **options: Unpack[MergeSweepOptions]) -> Sweep:
    """Merges the pieces of a study, which ``sweep`` made with ``shard="I/N"``, to the bytes of one run."""
    met, summary = _command.run("sweep merge", [study, *pieces], dict(options))
    return Sweep(FilePath(summary["file"]), summary, met)


def load(file: File) -> Any:
    """The object of any document of this package: model, controller of the steering or of the speed, path,
    manoeuvre."""
    return load_document(file, (*MODELS, Controller, SpeedController, Path, Manoeuvre))
