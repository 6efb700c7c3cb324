"""Subcommands in a process of their own: an FMU that crashes or hangs ends that process only."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import threading
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from . import _native, _progress
from .__main__ import PROGRAM
from ._errors import Error, path_of, warn

NO_NAMES: Mapping[str, str] = {}

END_S = 10.0
"""Time for a command to end after an interruption."""


class Outcome(NamedTuple):
    met: bool
    """Whether all requirements are met."""
    value: Any
    """What the command printed, as JSON."""


def run(
    command: str,
    positional: Iterable[Any],
    options: dict[str, Any],
    *,
    quiet: bool = False,
    names: Mapping[str, str] = NO_NAMES,
) -> Outcome:
    """Runs a subcommand, such as ``sweep merge``, with keyword arguments as options; ``quiet`` shows no bar.

    ``names`` are those of files in messages, where the caller's file was converted.
    """
    words = [*_native.words(command, options), "--json", "--progress-interval=0.5s", "--end-with-parent", "--"]
    arguments = [*PROGRAM, *command.split(), *words, *map(path_of, positional)]
    errors: list[dict[str, Any]] = []
    other: list[str] = []
    bar = contextlib.nullcontext() if quiet else _progress.shown()
    with bar as progress, _started(arguments) as process:

        def listen() -> None:
            assert process.stderr is not None
            for line in process.stderr:
                try:
                    for file, name in names.items():
                        line = line.replace(_quoted(file), _quoted(name))
                    (kind, value), *_ = json.loads(line).items()
                except (ValueError, AttributeError, TypeError):
                    other.append(line.rstrip())
                    continue
                if kind == "error":
                    errors.append(value)
                elif kind == "warning":
                    found.append(value["message"])
                elif kind == "progress" and progress is not None:
                    # The share is in the message too.
                    progress(value["message"].split(", ")[0], value["done"], value["of"])

        found: list[str] = []
        listener = threading.Thread(target=listen, daemon=True)
        listener.start()
        assert process.stdout is not None
        printed = process.stdout.read()
        status = process.wait()
        listener.join()
    for message in found:
        warn(_native.in_python(message))
    if errors:
        raise Error(*(_native.in_python(errors[0][key]) for key in ("message", "hint")))
    if status not in (0, 1):
        cause = f"signal {signal.Signals(-status).name}" if status < 0 else f"status {status}"
        said = "\n".join(other[-20:])
        raise Error(
            f"steerwright {command} ended with {cause}{': ' if said else ''}{said}",
            "a binary of an FMU may have crashed: steerwright.check(FMU, run=True) tries it",
        )
    return Outcome(status == 0, json.loads(printed))


def _quoted(text: str) -> str:
    """A text as it is within one of JSON."""
    return json.dumps(text, ensure_ascii=False)[1:-1]


@contextlib.contextmanager
def _started(arguments: list[str]) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        arguments,
        # Closed with this process, however it ends.
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
    )
    try:
        yield process
    except BaseException:
        # Not SIGINT, which is ignored in the background.
        process.terminate()
        try:
            process.wait(END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        raise
    finally:
        for stream in (process.stdin, process.stdout, process.stderr):
            if stream is not None:
                stream.close()


@contextlib.contextmanager
def folder() -> Iterator[FilePath]:
    """A folder that is removed at the end."""
    with _native.Scratch() as scratch:
        yield scratch


def as_files(items: Any, where: FilePath) -> list[FilePath]:
    """Files of documents, or of one: objects of this package are written into a folder, paths stay."""
    files = []
    if isinstance(items, (str, os.PathLike)) or hasattr(items, "to_json"):
        items = [items]
    for index, item in enumerate(items):
        if hasattr(item, "to_json") and hasattr(item, "FILE"):
            # Objects of one kind in a folder each, since their names say what they are.
            name = FilePath(item._file).name
            file = where / name if not (where / name).exists() else where / str(index) / name
            file.parent.mkdir(exist_ok=True)
            item.save(file)
            files.append(file)
        else:
            files.append(FilePath(path_of(item)))
    return files
