from __future__ import annotations


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


class Warning(UserWarning):
    """Something that may be wrong with a log, a model or a study."""
