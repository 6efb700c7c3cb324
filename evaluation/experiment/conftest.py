"""The tests find the test drive's modules as the experiment does."""

import shared  # noqa: F401
