"""A sweep on two local workers of Dask compared with one process of two threads; a fleet compared with one pass.

python cluster.py DRIVE.csv [RUNS] [LOGS]
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import steerwright
import steerwright.dask
from distributed import Client, LocalCluster

STUDY = """\
seed = 1
runs = {runs}
step_s = 0.01
stop_s = 20.0
ssp = "LateralLoop.ssp"

[[vary]]
name = "speed"
variables = ["IdentifiedPlant.speed", "ReferencePath.speed"]
distribution = "uniform"
minimum = 14.0
maximum = 16.0

[[metric]]
name = "largest"
variable = "ReferencePath.cross_track_error"
kind = "max-abs"
"""

COLUMNS = {"input_channel": "steering_command_rad", "steering_ratio": 1.0}


def timed(work):
    start = time.perf_counter()
    return work(), time.perf_counter() - start


def sweep(drive, runs, client, folder):
    plant = steerwright.identify(drive, **COLUMNS)
    controller = steerwright.design(plant)
    path = steerwright.path(plant=plant, pid=controller, speed=15.0)
    steerwright.package([plant, path, controller], out=folder, ssp="LateralLoop.ssp")
    study = folder / "study.toml"
    study.write_text(STUDY.format(runs=runs))
    _, alone = timed(lambda: steerwright.sweep(study, output=folder / "alone.csv", threads=2))
    _, cluster = timed(lambda: steerwright.dask.sweep(study, client, output=folder / "dask.csv"))
    same = (folder / "alone.csv").read_bytes() == (folder / "dask.csv").read_bytes()
    per_task = min(max(runs // 8, 1_000), 10_000)
    _, empty = timed(lambda: client.gather([client.submit(abs, k, pure=False) for k in range(500)]))
    print(f"{runs} closed loops of 20 s: one process, two threads {alone:.1f} s; two workers {cluster:.1f} s")
    print(f"  {100 * alone / cluster:.1f} % of the speed, same bytes: {same}")
    print(f"  {1000 * empty / 500:.1f} ms a task of Dask; {-(-runs // per_task)} tasks")
    # A core makes the runs of one worker; a task costs what two workers lose.
    core = 2 * alone / runs
    lost = max(2 * (cluster - alone) / -(-runs // per_task), 0.0)
    hundred = max(-(-runs // (100 * per_task)), 1) * (per_task * core + lost)
    print(
        f"  {1e6 * core:.0f} µs a run on a core, {lost:.2f} s lost a task; projected on 100 cores {hundred:.1f} s"
    )


def fleet(drive, count, client):
    rows = np.genfromtxt(drive, delimiter=",", names=True, comments="#")
    period = float(np.median(np.diff(rows["time_s"])))
    length = int(60.0 / period)
    rng = np.random.default_rng(1)
    logs = []
    for _ in range(count):
        start = rng.integers(len(rows) - length)
        part = {name: rows[name][start : start + length].copy() for name in rows.dtype.names}
        # Each log has noise of its own, so that none is there twice.
        part["yaw_rate_radps"] += 1e-3 * rng.standard_normal(length)
        logs.append(part)
    distributed, cluster = timed(lambda: steerwright.dask.accumulate(logs, client, horizon=20, **COLUMNS))

    def one_pass():
        drives = steerwright.Accumulator(horizon=20, **COLUMNS)
        for log in logs:
            drives.add(log)
        return drives

    passed, alone = timed(one_pass)
    omega = np.geomspace(0.1, 30.0, 50)
    models = [
        steerwright.identify(d, order=2).frequency_response(omega).response for d in (distributed, passed)
    ]
    difference = np.abs(models[0] / models[1] - 1.0).max()
    print(
        f"{count} logs of 60 s: two workers {cluster:.1f} s, {1000 * cluster / count:.1f} ms a log; one pass {alone:.1f} s"
    )
    print(f"  largest relative difference of the models {difference:.1e}")


def main():
    drive, *counts = sys.argv[1:]
    runs, logs = (int(count) for count in counts) if counts else (20_000, 100)
    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        sweep(Path(drive), runs, client, Path(folder))
        fleet(Path(drive), logs, client)


if __name__ == "__main__":
    main()
