"""Progress bars of long work, by tqdm where it is installed."""

from __future__ import annotations

import contextlib
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from typing import Any

DELAY_S = 2.0
"""Shorter work shows nothing."""

FORMAT = "{desc}: {percentage:3.0f} % |{bar}| {elapsed}, {remaining} left"
UNKNOWN = "{desc}, {elapsed}"

now = time.monotonic

Progress = Callable[[str, int, int], None]


@contextlib.contextmanager
def shown() -> Iterator[Progress | None]:
    """A function that shows the present work, and how much of how much is done; `None` without tqdm and where nobody
    looks: elsewhere than on a terminal or in a notebook."""
    try:
        from tqdm import TqdmExperimentalWarning, TqdmWarning
    except ImportError:
        yield None
        return
    if not (_in_notebook() or (sys.stderr is not None and sys.stderr.isatty())):
        yield None
        return
    with warnings.catch_warnings():
        # In notebooks without widgets the bar is text.
        warnings.simplefilter("ignore", (TqdmExperimentalWarning, TqdmWarning))
        from tqdm.auto import tqdm
    bars: list[Any] = []
    start = now()

    def show(what: str, done: int, of: int) -> None:
        if not bars:
            if now() - start < DELAY_S:
                return
            # Without the share, which is not known yet.
            bars.append(tqdm(total=100.0, leave=False, bar_format=UNKNOWN, desc=what))
        bar = bars[0]
        bar.set_description_str(what, refresh=False)
        bar.n = round(100.0 * min(done / of, 1.0), 1) if of > 0 else 0.0
        bar.bar_format = FORMAT if of > 0 else UNKNOWN
        bar.refresh()

    try:
        yield show
    finally:
        for bar in bars:
            bar.close()


def _in_notebook() -> bool:
    """Whether cells of a notebook run here."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None
