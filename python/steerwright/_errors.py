"""Errors and warnings of the package."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from pathlib import Path as FilePath
from typing import Any

PACKAGE = os.path.dirname(__file__)


class Error(ValueError):
    """Why something could not be done, and what can be done about it."""

    message: str
    """What is wrong, and where."""
    hint: str
    """What to do about it."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message, hint)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.message}\nhint: {self.hint}" if self.hint else self.message


class ArgumentError(Error, TypeError):
    """An argument that a function does not take."""


class Missing(Error, AttributeError, KeyError):
    """A name that is not there."""


class Warning(UserWarning):
    """Something that may be wrong with a log, a model or a study."""


def warn(message: str) -> None:
    """Warns at the line of the caller outside this package."""
    inside = (PACKAGE + os.sep, contextlib.__file__)
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_code.co_filename.startswith(inside):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, Warning, stacklevel=level)


def path_of(file: Any) -> str:
    """The path of a file."""
    try:
        return os.fsdecode(file)
    except TypeError as error:
        raise ArgumentError(
            f"a file is expected, not an object of type {type(file).__name__}",
            "pass its path; tables are taken by read, identify, inspect and Accumulator.add",
        ) from error


def text_of(file: str | os.PathLike[str]) -> str:
    """The text of a document."""
    path = path_of(file)
    try:
        return FilePath(path).read_text("utf-8")
    except OSError as error:
        raise Error(f"{path}: {error.strerror}", "check that the path is right and that you may read there") from error
    except UnicodeDecodeError as error:
        raise Error(f"{path}: no JSON document", "pass a document such as plant.json") from error
