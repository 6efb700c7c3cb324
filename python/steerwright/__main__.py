"""The command line."""

from __future__ import annotations

import signal
import sys

from . import _native

PROGRAM = [sys.executable, "-m", "steerwright"]


def main() -> int:
    """Runs the command line on the arguments of this process; returns the exit status."""
    # Python's handler would wait for the end of the work. What is ignored, as in the background, stays so.
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(["steerwright", *sys.argv[1:]], PROGRAM)


if __name__ == "__main__":
    sys.exit(main())
