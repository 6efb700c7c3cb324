"""Errors, interruptions and threads."""

from __future__ import annotations

import _thread
import signal
import threading
import time
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest
import steerwright
from steerwright import _native
from conftest import COLUMNS, DRIVE


def test_errors_have_hints() -> None:
    with pytest.raises(steerwright.Error, match="which column is the steering") as caught:
        steerwright.read(DRIVE)
    assert "input_channel=NAME" in caught.value.hint
    assert "--" not in str(caught.value)
    with pytest.raises(steerwright.Error, match="no_such_file.csv"):
        steerwright.read("no_such_file.csv")
    with pytest.raises(steerwright.Error, match="invalid value '3x' for"):
        steerwright.read(DRIVE, steering_ratio="3x")
    with pytest.raises(TypeError, match="no option `steering_rato` of read; did you mean `steering_ratio`") as misspelt:
        steerwright.read(DRIVE, steering_rato=3)  # type: ignore[call-arg]
    assert len(str(misspelt.value)) < 150
    with pytest.raises(TypeError, match="no option `colour` of read; the options are"):
        steerwright.read(DRIVE, colour=3)  # type: ignore[call-arg]
    with pytest.raises(steerwright.Error, match="the log is read already"):
        steerwright.identify(steerwright.read(DRIVE, **COLUMNS), steering_ratio=3)
    log = steerwright.read(DRIVE, **COLUMNS)
    with pytest.raises(TypeError, match="no option `output` of identify, which returns an object and writes no file"):
        steerwright.identify(log, output="model.json")  # type: ignore[call-overload]
    plant = steerwright.identify(log, structure="state-space", order=2)
    with pytest.raises(TypeError, match="no option `plots` of design"):
        steerwright.design(plant, plots="figures")  # type: ignore[call-arg]
    assert issubclass(steerwright.Error, ValueError)
    with pytest.raises(steerwright.Error, match="`desing` is no subcommand"):
        steerwright.options("desing")


def test_a_share_above_1_is_refused_with_the_right_spelling(plant: steerwright.Plant) -> None:
    for name, value, right in (("overshoot", 5, "0.05"), ("steady_state_error", 2.5, "0.025"), ("overshoot", np.int64(7), "0.07")):
        with pytest.raises(steerwright.Error, match=f"{name}={value}: a share is a fraction, at most 1") as caught:
            steerwright.design(plant, **{name: value})
        assert caught.value.hint == f"write {name}={right}"
    for command in (steerwright.compare, steerwright.build):
        with pytest.raises(steerwright.Error, match="overshoot=5"):
            command(["plant.json"], overshoot=5)
    assert _native.words("design", {"overshoot": 0.05}) == _native.words("design", {"overshoot": "5%"})
    for value in (True, np.True_):
        with pytest.raises(steerwright.Error, match="max_order=.*True.*: N is expected"):
            steerwright.identify(DRIVE, **COLUMNS, max_order=value)


def test_ranges_are_pairs() -> None:
    for value in ((5, 30), [5.0, 30], np.array([5, 30]), ("5m/s", "30 m/s"), "5m/s..30m/s"):
        assert _native.words("design", {"speeds": value}) == ["--speeds=5m/s..30m/s"]
        assert _native.words("read", {"speed_window": value}) == ["--speed-window=5m/s..30m/s"]
    windows = ["--window=10s..60s", "--window=70s..90s"]
    assert _native.words("read", {"window": (10, 60)}) == windows[:1]
    for value in ([(10, 60), (70, 90)], [("10s", "60s"), [70, 90]], ["10s..60s", "70s..90s"], np.array([[10, 60], [70, 90]])):
        assert _native.words("read", {"window": value}) == windows
    for value in ((5, 10, 30), (5,), []):
        with pytest.raises(steerwright.Error, match="a range is a pair") as caught:
            _native.words("design", {"speeds": value})
        assert caught.value.hint == "write speeds=(5, 30)"


@pytest.mark.parametrize("function", ["load", "design", "Plant.load", "Accumulator.load"])
def test_files_that_are_no_documents_are_errors(function: str, tmp_path: Path) -> None:
    for name, content in (("list.json", b"[1]"), ("drive.csv", b"t,x\n1,2\n"), ("binary", b"\xff\xfe")):
        (tmp_path / name).write_bytes(content)
    for name in ("missing.json", "list.json", "drive.csv", "binary", "."):
        with pytest.raises(steerwright.Error) as caught:
            attrgetter(function)(steerwright)(tmp_path / name)
        assert caught.value.hint and str(tmp_path / name) in caught.value.message


@pytest.mark.parametrize("speed", [0.0, 1.5, -1.8], ids=["standing", "slow", "reversing"])
@pytest.mark.parametrize("count", [0, 1, 3000])
def test_a_drive_without_a_fast_part_is_a_model_or_an_error(count: int, speed: float) -> None:
    time_s = 0.02 * np.arange(count)
    steering = 0.1 * np.sin(1.3 * time_s) + 0.05 * np.sin(4.1 * time_s)
    columns = {
        "time_s": time_s,
        "steering_angle_rad": steering,
        "yaw_rate_radps": speed * steering / 0.5,
        "speed_mps": np.full(count, speed) + 0.5 * np.sin(0.3 * time_s) * np.sign(speed),
    }
    try:
        found = steerwright.identify(columns, steering_ratio=1.0)
    except steerwright.Error as error:
        assert error.hint
    else:
        assert found.quality.grade in ("pass", "warn", "fail")


def test_a_design_on_a_failed_model_is_refused(log: steerwright.Log) -> None:
    rng = np.random.default_rng(1)
    noise = {
        "time_s": np.arange(4000) * 0.02,
        "steering_angle_rad": 0.01 * rng.standard_normal(4000),
        "yaw_rate_radps": rng.standard_normal(4000),
        "speed_mps": np.full(4000, 15.0),
    }
    plant = steerwright.identify(noise, steering_ratio=1.0)
    assert plant.quality.grade == "fail"
    with pytest.raises(steerwright.Error, match="the quality of the model is fail") as caught:
        steerwright.design(plant)
    assert "accept_untrusted" in caught.value.hint


@pytest.mark.filterwarnings("ignore::steerwright.Warning")
def test_an_interruption_returns_at_once(log: steerwright.Log) -> None:
    # Where it was started in the background, this process ignores interruptions.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    rng = np.random.default_rng(2)
    n = 300_000
    table = {
        "time_s": np.arange(n) * 0.02,
        "steering_angle_rad": np.cumsum(rng.standard_normal(n)) * 1e-3,
        "yaw_rate_radps": rng.standard_normal(n) * 0.1,
        "speed_mps": np.full(n, 15.0),
    }
    large = steerwright.read(table, steering_ratio=1.0)
    start = time.monotonic()
    steerwright.identify(large, max_samples="all", max_order=20, horizon=60)
    alone = time.monotonic() - start
    interrupted: list[float] = []

    def interrupt() -> None:
        interrupted.append(time.monotonic())
        _thread.interrupt_main()

    threading.Timer(0.2 * alone, interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        steerwright.identify(large, max_samples="all", max_order=20, horizon=60)
    assert time.monotonic() - interrupted[0] < 0.4 * alone
    signal.signal(signal.SIGINT, before)


def test_other_threads_run_meanwhile(log: steerwright.Log) -> None:
    counted = 0
    stop = threading.Event()

    def count() -> None:
        nonlocal counted
        while not stop.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    before = counted
    steerwright.identify(log)
    during = counted - before
    stop.set()
    thread.join()
    assert during > 10
