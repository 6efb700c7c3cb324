"""Progress bars of long work, by tqdm where it is installed."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from typing import Any

DELAY_S = 2.0
"""Shorter work shows nothing."""

FORMAT = "{desc}: {percentage:3.0f} % |{bar}| {elapsed}, {remaining} left"
UNKNOWN = "{desc}, {elapsed}"

Progress = Callable[[str, int, int], None]


@contextlib.contextmanager
def shown() -> Iterator[Progress | None]:
    """A function that shows the present work, and how much of how much is done; `None` without tqdm."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        yield None
        return
    bars: list[Any] = []
    start = time.monotonic()

    def show(what: str, done: int, of: int) -> None:
        if not bars:
            if time.monotonic() - start < DELAY_S:
                return
            bars.append(tqdm(total=100.0, leave=False, bar_format=FORMAT))
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
