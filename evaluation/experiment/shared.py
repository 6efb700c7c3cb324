"""Finds the test drive's modules, which examples/drives/multibody shares with the experiment."""

import sys
from pathlib import Path

MULTIBODY = Path(__file__).resolve().parents[2] / "examples" / "drives" / "multibody"
sys.path.insert(0, str(MULTIBODY))
