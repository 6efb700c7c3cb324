"""Arrays of logs are views that outlive their log and cannot be written."""

from __future__ import annotations

import gc

import numpy as np
import pytest
import steerwright
from conftest import COLUMNS, DRIVE


def test_arrays_are_read_only_views_of_the_log(log: steerwright.Log) -> None:
    for name in ("time", "steering", "yaw_rate", "speed"):
        first, second = getattr(log, name), getattr(log, name)
        assert first.shape == (len(log),)
        assert first.ctypes.data == second.ctypes.data, "a copy"
        assert first.base is log
        with pytest.raises(ValueError, match="read-only"):
            first[0] = 1.0
        with pytest.raises(ValueError, match="WRITEABLE"):
            first.flags.writeable = True


def test_an_array_keeps_its_log(log: steerwright.Log) -> None:
    other = steerwright.read(DRIVE, **COLUMNS)
    steering = other.steering
    del other
    gc.collect()
    np.testing.assert_array_equal(steering, log.steering)


def test_traces_are_those_of_the_report(plant: steerwright.Plant) -> None:
    traces = plant.traces
    assert traces is not None
    held = traces.is_validation
    error = (traces.yaw_rate - traces.simulated_yaw_rate)[held]
    measured = traces.yaw_rate[held]
    fit = 100.0 * (1.0 - np.linalg.norm(error) / np.linalg.norm(measured - measured.mean()))
    assert fit == pytest.approx(plant.fit, abs=0.5)
