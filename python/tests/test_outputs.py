"""What the package writes and leaves: by the rules of the command line."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import steerwright
from conftest import COLUMNS, DRIVE


def test_save_replaces_its_own_kind_and_never_what_was_read(log: steerwright.Log, tmp_path: Path) -> None:
    recording = tmp_path / "drive.csv"
    recording.write_bytes(Path(DRIVE).read_bytes())
    plant = steerwright.identify(steerwright.read(recording, **COLUMNS), structure="state-space")
    for force in (False, True):
        with pytest.raises(steerwright.Error, match="this output is also an input, and is never written"):
            plant.save(recording, force=force)
    assert recording.read_bytes() == Path(DRIVE).read_bytes()
    notes = tmp_path / "notes.txt"
    notes.write_text("mine")
    with pytest.raises(steerwright.Error, match="this file is there"):
        plant.save(notes)
    plant.save(notes, force=True)
    file = tmp_path / "plant.json"
    for _ in range(2):
        plant.save(file)
    assert file.read_text("utf-8") == plant.to_json()
    accumulated = steerwright.Accumulator(horizon=20, **COLUMNS).add(recording)
    with pytest.raises(steerwright.Error, match="this file is there"):
        accumulated.save(file)
    accumulated.save(tmp_path / "one.rfactor")


@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
def test_a_full_disk_leaves_the_old_document(log: steerwright.Log, tmp_path: Path) -> None:
    plant = steerwright.identify(log, structure="state-space")
    file = tmp_path / "plant.json"
    plant.save(file)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        with pytest.raises(steerwright.Error, match="File too large"):
            plant.save(file)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)
    assert file.read_text("utf-8") == plant.to_json()
    assert [entry.name for entry in tmp_path.iterdir()] == ["plant.json"]


def test_masked_values_are_missing(log: steerwright.Log) -> None:
    table = {
        "time_s": np.asarray(log.time),
        "steering_angle_rad": np.asarray(log.steering),
        "yaw_rate_radps": np.array(log.yaw_rate),
        "speed_mps": np.asarray(log.speed),
    }
    gaps = np.arange(len(log)) % 7 == 3
    nan = {**table, "yaw_rate_radps": np.where(gaps, np.nan, table["yaw_rate_radps"])}
    # What a mask covers is any number, often a large one.
    masked = np.ma.masked_array(np.where(gaps, 1e20, table["yaw_rate_radps"]), gaps)
    same = steerwright.read({**table, "yaw_rate_radps": masked}, steering_ratio=1.0)
    expected = steerwright.read(nan, steering_ratio=1.0)
    assert np.array_equal(same.yaw_rate, expected.yaw_rate)
    mask = [(False, False), (False, True), (False, False), (True, False)]
    records = np.ma.array([(0.0, 1)] * 4, dtype=[("time_s", float), ("counts", int)], mask=mask)
    from steerwright.reading import columns

    found = columns(records)
    assert [np.isnan(found[name]).tolist() for name in ("time_s", "counts")] == [
        [False, False, False, True],
        [False, True, False, False],
    ]


@pytest.mark.skipif(os.name != "posix", reason="FIFOs of POSIX")
def test_a_fifo_is_read_once(tmp_path: Path) -> None:
    for name in ("drive.csv", "drive.bag"):
        fifo = tmp_path / name
        os.mkfifo(fifo)
        content = Path(DRIVE).read_bytes()
        feeding = threading.Thread(target=lambda: fifo.write_bytes(content))
        feeding.start()
        assert len(steerwright.read(fifo, **COLUMNS)) > 1000
        feeding.join()
    feeding = threading.Thread(target=lambda: fifo.write_bytes(content))
    feeding.start()
    assert steerwright.Accumulator(horizon=20, **COLUMNS).add(fifo).samples > 1000
    feeding.join()


INTERRUPTED = """
import _thread, threading, time
import numpy as np, steerwright
n = 300_000
rng = np.random.default_rng(2)
table = {
    "time_s": np.arange(n) * 0.02,
    "steering_angle_rad": np.cumsum(rng.standard_normal(n)) * 1e-3,
    "yaw_rate_radps": rng.standard_normal(n) * 0.1,
    "speed_mps": np.full(n, 15.0),
}
large = steerwright.read(table, steering_ratio=1.0)

def identify():
    steerwright.identify(large, max_samples="all", max_order=20, horizon=60)

began = time.process_time()
identify()
alone = time.process_time() - began
began = time.process_time()
threading.Thread(
    target=lambda: (
        [time.sleep(0.01) for _ in iter(lambda: time.process_time() - began > 0.2 * alone, True)],
        _thread.interrupt_main(),
    )
).start()
try:
    identify()
except KeyboardInterrupt:
    # Until the work is over.
    before = time.process_time()
    while True:
        time.sleep(1.0)
        now = time.process_time()
        if now - before < 0.05:
            break
        before = now
print((time.process_time() - began) / alone)
"""


def test_work_ends_after_an_interruption() -> None:
    # In a process of its own, whose processor time is that of this work alone.
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", INTERRUPTED], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    # Interrupted after a fifth of the work, it ends before most of the rest.
    assert float(done.stdout) < 0.6, done.stdout


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_what_a_killed_interpreter_started_ends_with_it(tmp_path: Path) -> None:
    # A pipe as the log, which the command waits for.
    fifo = tmp_path / "log.csv"
    os.mkfifo(fifo)
    code = f"import steerwright; steerwright.inspect({str(fifo)!r})"
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    process = subprocess.Popen([sys.executable, "-c", code], env=environment)
    # Opened as soon as the command reads it.
    with open(fifo, "wb") as log:
        process.kill()
        process.wait()
        with pytest.raises(BrokenPipeError):
            for _ in range(600):
                log.write(b"1,2,3\n" * 10_000)
                log.flush()
                time.sleep(0.1)
