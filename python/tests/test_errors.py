"""Errors, interruptions and threads."""

from __future__ import annotations

import _thread
import io
import signal
import sys
import threading
import time
import warnings
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest
import steerwright
from steerwright import _native, _progress
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
    with pytest.raises(steerwright.Error, match="`paht` is no subcommand"):
        steerwright.options("paht")


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


def test_arrays_are_identified(log: steerwright.Log) -> None:
    u, y, dt = log.steering, log.yaw_rate, log.sample_time
    table = {"time_s": log.time, "steering_angle_rad": u, "yaw_rate_radps": y, "speed_mps": log.speed}
    options = {"steering_ratio": 1.0, "structure": "state-space", "order": 2, "intersample": "zoh"}
    expected = steerwright.identify({**table, "time_s": dt * np.arange(len(u))}, **options)
    found = steerwright.identify(u, y, dt, speed=log.speed, **options)
    assert isinstance(found, steerwright.Plant)
    np.testing.assert_array_equal(found.A, expected.A)
    assert steerwright.identify(list(u), list(y), dt, speed=15, **options).order == 2
    for wrong in ((u, y), (u, y, 0.0), (u, y, True), (u, None, dt), (u, y[:-1], dt), (u[:, None], y, dt)):
        with pytest.raises(steerwright.Error) as caught:
            steerwright.identify(*wrong, **options)
        assert caught.value.hint


def test_errors_of_commands_name_keywords(tmp_path: Path) -> None:
    steerwright.path(speed=12.0).save(tmp_path / "path.json")
    with pytest.raises(steerwright.Error) as caught:
        steerwright.path(tmp_path / "none.csv", profile=True, max_jerk="fast")
    assert "--" not in str(caught.value), str(caught.value)
    with pytest.raises(steerwright.Error) as caught:
        steerwright.excite(tmp_path / "path.json")
    assert "--" not in str(caught.value), str(caught.value)


def test_one_document_is_a_list_of_one_and_other_objects_are_refused(
    plant: steerwright.Plant, log: steerwright.Log, tmp_path: Path
) -> None:
    plant.save(tmp_path / "plant.json")
    for one in (plant, tmp_path / "plant.json", str(tmp_path / "plant.json")):
        assert list(steerwright.package(one, out=tmp_path / "fmu")) == ["IdentifiedPlant"]
    of_one = [steerwright.design, steerwright.load, steerwright.build, steerwright.check, steerwright.sweep]
    of_several = [steerwright.package, steerwright.compare, steerwright.simulate]
    calls = [(call, wrong) for call in of_one for wrong in (log, 3.0, None)]
    for call, wrong in [*calls, *((call, [log]) for call in of_several)]:
        with pytest.raises(steerwright.Error, match="a file is expected, not an object of type") as caught:
            call(wrong)
        assert caught.value.hint


def test_ranges_are_pairs() -> None:
    for value in ((5, 30), [5.0, 30], np.array([5, 30]), ("5m/s", "30 m/s"), "5m/s..30m/s"):
        assert _native.words("design", {"speeds": value}) == ["--speeds=5m/s..30m/s"]
        assert _native.words("read", {"speed_window": value}) == ["--speed-window=5m/s..30m/s"]
    windows = ["--window=10s..60s", "--window=70s..90s"]
    assert _native.words("read", {"window": (10, 60)}) == windows[:1]
    for value in ([(10, 60), (70, 90)], [("10s", "60s"), [70, 90]], ["10s..60s", "70s..90s"], np.array([[10, 60], [70, 90]])):
        assert _native.words("read", {"window": value}) == windows
    assert _native.words("identify", {"prior": {"mass": (1500, 50.5)}}) == ["--prior=mass=1500,50.5"]
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


@pytest.mark.parametrize("where", ["file", "terminal", "notebook"])
def test_progress_is_shown_where_someone_looks(where: str, monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(stream, "isatty", lambda: where == "terminal", raising=False)
    monkeypatch.setattr(_progress, "_in_notebook", lambda: where == "notebook")
    clock = [0.0]
    monkeypatch.setattr(_progress, "now", lambda: clock[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with _progress.shown() as progress:
            assert (progress is None) == (where == "file")
            if progress is None:
                return
            progress("identifying", 1, 4)
            clock[0] = 1.9
            progress("identifying", 2, 4)
            assert not stream.getvalue()
            clock[0] = 2.1
            progress("identifying", 3, 4)
            assert "identifying:  75 %" in stream.getvalue()
            assert "?" not in stream.getvalue()


def test_warnings_point_to_the_line_of_the_caller(log: steerwright.Log, plant: steerwright.Plant, tmp_path: Path) -> None:
    calls = [
        lambda: steerwright.read(DRIVE, **COLUMNS, speed_window=(14, 16)),
        lambda: steerwright.identify(DRIVE, **COLUMNS, speed_window=(14, 16)),
        lambda: steerwright.identify_bicycle(log),
    ]
    for call in calls:
        with pytest.warns(steerwright.Warning) as caught:
            call()
        assert {warning.filename for warning in caught} == {__file__}


def test_a_missing_package_is_named_with_its_extra(
    plant: steerwright.Plant, log: steerwright.Log, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module, call, extra in (
        ("control", plant.to_control, "control"),
        ("scipy", plant.to_scipy, "logs"),
        ("pandas", log.to_pandas, "notebook"),
    ):
        with monkeypatch.context() as patched:
            for name in [key for key in sys.modules if key.partition(".")[0] == module]:
                patched.delitem(sys.modules, name)
            patched.setitem(sys.modules, module, None)
            with pytest.raises(steerwright.Error, match=f"uses {module}, which is not installed") as caught:
                call()
        assert f"pip install {module}" in caught.value.hint and f"./python[{extra}]" in caught.value.hint


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
