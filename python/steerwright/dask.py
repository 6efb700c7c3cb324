"""Sweeps and fleets on a Dask cluster.

Tasks may run twice, in any order, on any worker: a piece of a sweep is named by its content, and drives are merged
in an order that depends on their list alone. So a worker that dies, or a task that is repeated, changes no byte.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _command, _native, commands, reading
from ._errors import Error
from ._libraries import library
from .accumulator import Accumulator

if TYPE_CHECKING:
    from .commands import File, Sweep

RUNS_PER_TASK = (1_000, 10_000)
"""Fewer runs cost more in tasks than in simulation, more are lost with a worker."""
FAN_IN = 8
"""R factors that one task merges."""
RETRIES = 3
"""Attempts of a task whose worker died or that failed."""


def sweep(
    study: File,
    client: Any,
    *,
    output: File = "results.csv",
    runs_per_task: int | None = None,
    retries: int = RETRIES,
    force: bool = False,
    **options: Any,
) -> Sweep:
    """Runs a study on the workers of a ``distributed.Client``; the results are the bytes of one run.

    The study and its FMUs are sent to the workers, so no shared file system is needed; the FMUs lie next to the
    study or below it. Options are those of ``steerwright sweep`` for a shard, such as ``isolate`` and ``timeout``.
    Ctrl-C cancels the tasks.
    """
    study = FilePath(study)
    whole = _command.run("sweep", [study], {"shard": "0/4000000000"}).value
    runs, bundle = whole["study_runs"], _bundle(study, whole["study_files"])
    if runs_per_task is None:
        low, high = RUNS_PER_TASK
        slots = max(sum(client.nthreads().values()), 1)
        runs_per_task = int(np.clip(runs // (4 * slots), low, high))
    shards = max(-(-runs // runs_per_task), 1)
    with warnings.catch_warnings():
        # A bundle of more than 10 MB is a large task, once.
        warnings.simplefilter("ignore", UserWarning)
        # Scattered data are lost with their workers, and a worker that dies meanwhile fails the call. The scheduler
        # has what a task needs, and makes it again elsewhere.
        sent = client.submit(_sent, bundle, retries=retries, pure=False)
    tasks = [
        client.submit(_shard, sent, study.name, f"{k}/{shards}", options, retries=retries, pure=False)
        for k in range(shards)
    ]
    with _command.folder() as folder:
        pieces = []

        def keep(result: tuple[str, bytes] | None) -> None:
            if result is not None:
                name, content = result
                (folder / name).write_bytes(content)
                pieces.append(folder / name)

        _gathered(client, tasks, "running the study", keep)
        return commands.merge_sweep(study, sorted(pieces), output=output, force=force)


def accumulate(
    logs: Sequence[Any],
    client: Any,
    *,
    retries: int = RETRIES,
    fan_in: int = FAN_IN,
    **options: Any,
) -> Accumulator:
    """Accumulates many logs on the workers of a ``distributed.Client``, for ``steerwright.identify``.

    ``logs`` are files that the workers can read, tables, or functions without arguments that return either, such as
    one that downloads a log. Options are those of :class:`steerwright.Accumulator`. A log that is listed twice
    counts once.
    """
    if not logs:
        raise Error("there are no logs", "pass at least one")
    if fan_in < 2:
        raise Error(f"fan_in={fan_in}: at least 2 are merged by a task", f"use {FAN_IN}")
    leaves = [client.submit(_accumulated, log, options, retries=retries, pure=False) for log in logs]
    keys = [client.submit(_key, leaf, retries=retries, pure=False) for leaf in leaves]
    every = [*leaves, *keys]
    known: list[str] = []
    _gathered(client, keys, "accumulating", lambda _: None, every)
    level = []
    for leaf, key in zip(leaves, client.gather(keys)):
        if key not in known:
            known.append(key)
            level.append(leaf)
    while len(level) > 1:
        parts = [level[k : k + fan_in] for k in range(0, len(level), fan_in)]
        level = [client.submit(_merged, part, retries=retries, pure=False) for part in parts]
        every += level
    found = Accumulator(**options)

    def keep(text: str) -> None:
        found._drives.load(text, "the merged drives")

    _gathered(client, level, "merging", keep, every)
    return found


def _gathered(
    client: Any,
    tasks: list[Any],
    what: str,
    keep: Callable[[Any], None],
    every: list[Any] | None = None,
) -> None:
    """Takes the results of tasks as they come; errors and Ctrl-C cancel all."""
    from . import _progress

    as_completed: Any = library("distributed", "steerwright.dask uses").as_completed

    try:
        with _progress.shown() as progress:
            for done, task in enumerate(as_completed(tasks), 1):
                keep(task.result())
                if progress is not None:
                    progress(what, done, len(tasks))
    except BaseException:
        client.cancel(every or tasks)
        raise


def _sent(bundle: dict[str, bytes]) -> dict[str, bytes]:
    """The study and its files, on a worker."""
    return bundle


def _bundle(study: FilePath, files: Sequence[str]) -> dict[str, bytes]:
    """The study and its files by their paths from the study's folder."""
    folder = study.resolve().parent
    bundle = {study.name: study.read_bytes()}
    for name in files:
        file = FilePath(name).resolve()
        if not file.is_relative_to(folder):
            raise Error(
                f"{study}: {name} is not in the folder of the study",
                "put the FMUs next to the study and name them from there: both are sent to the workers",
            )
        bundle[file.relative_to(folder).as_posix()] = file.read_bytes()
    return bundle


def _shard(
    bundle: dict[str, bytes], study: str, shard: str, options: dict[str, Any]
) -> tuple[str, bytes] | None:
    """A piece of a study on a worker: its name and content; `None` for one without runs."""
    with _command.folder() as folder:
        for path, content in bundle.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_bytes(content)
        keywords = {"threads": 1, **options, "shard": shard, "output": folder / "pieces"}
        made = _command.run("sweep", [folder / study], keywords, quiet=True).value
        if made["file"] is None:
            return None
        return FilePath(made["file"]).name, FilePath(made["file"]).read_bytes()


def _accumulated(log: Any, options: dict[str, Any]) -> str:
    """The R factor of one log, on a worker."""
    drives = _native.Drives()
    reading.accumulate(drives, log() if callable(log) else log, options, None)
    return drives.json()


def _key(document: str) -> str:
    """What is the same for one log, however often it is listed."""
    sources = json.loads(document)["provenance"]["sources"]
    return ",".join(sorted(source["sha256"] for source in sources))


def _merged(parts: list[str]) -> str:
    """The R factor of several, on a worker."""
    drives = _native.Drives()
    for part in parts:
        drives.load(part, "an R factor of a worker")
    return drives.json()
