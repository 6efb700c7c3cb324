"""A sweep and a fleet on a local cluster, of which a worker is killed in the middle: the same bytes."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steerwright
import steerwright.dask
from conftest import COLUMNS, DRIVE

distributed = pytest.importorskip("distributed")

STUDY = """\
seed = 1
runs = 400
step_s = 0.01
stop_s = 10.0
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
kind = "maximum"
absolute = true
"""


@pytest.fixture
def client() -> Any:
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        yield client


def when_sent(client: Any, monkeypatch: pytest.MonkeyPatch, kill: Callable[[str | None], None]) -> None:
    """Kills a worker as the study is sent."""
    submit = client.submit

    def killing(*arguments: Any, **keywords: Any) -> Any:
        future = submit(*arguments, **keywords)
        kill(None)
        return future

    monkeypatch.setattr(client, "submit", killing)


def in_a_run(client: Any, monkeypatch: pytest.MonkeyPatch, kill: Callable[[str | None], None]) -> None:
    """Kills a worker when the first task has ended and the others are at work."""

    @contextlib.contextmanager
    def shown() -> Iterator[Any]:
        yield lambda _what, _done, _of: kill(None)

    monkeypatch.setattr("steerwright._progress.shown", shown)


def at_the_gather(client: Any, monkeypatch: pytest.MonkeyPatch, kill: Callable[[str | None], None]) -> None:
    """Kills the worker that has a result as it is fetched."""
    result = distributed.Future.result

    def killing(future: Any, *arguments: Any, **keywords: Any) -> Any:
        holders = [worker for workers in client.who_has([future]).values() for worker in workers]
        if len(holders) == 1:
            kill(holders[0])
        return result(future, *arguments, **keywords)

    monkeypatch.setattr(distributed.Future, "result", killing)


DEATHS = [when_sent, in_a_run, at_the_gather]


def killer(client: Any) -> tuple[Callable[[str | None], None], list[int]]:
    """A function that kills the named worker, or any, the first time that it is called; whom it killed."""
    workers = client.run(os.getpid)
    killed: list[int] = []

    def kill(worker: str | None) -> None:
        if not killed:
            killed.append(workers[worker] if worker else next(iter(workers.values())))
            os.kill(killed[0], signal.SIGKILL)

    return kill, killed


@pytest.mark.parametrize("death", DEATHS)
def test_a_sweep_survives_a_worker(
    death: Callable[..., None],
    fmus: dict[str, Path],
    tmp_path: Path,
    client: Any,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / "LateralLoop.ssp").write_bytes(fmus["LateralLoop"].read_bytes())
    study = tmp_path / "study.toml"
    study.write_text(STUDY)
    whole = steerwright.sweep(study, output=tmp_path / "whole.csv")
    kill, killed = killer(client)
    death(client, monkeypatch, kill)
    on_cluster = steerwright.dask.sweep(study, client, output=tmp_path / "cluster.csv", runs_per_task=20)
    assert len(killed) == 1
    assert (tmp_path / "cluster.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    assert on_cluster.summary["outcomes"] == whole.summary["outcomes"]


def drives() -> list[dict[str, np.ndarray]]:
    """Parts of the recorded drive, each with a clock of its own."""
    rows = np.genfromtxt(DRIVE, delimiter=",", names=True, comments="#")
    parts = np.array_split(np.arange(len(rows)), 12)
    return [{name: rows[name][part].copy() for name in rows.dtype.names} for part in parts]


@pytest.mark.parametrize("death", DEATHS)
def test_a_fleet_survives_a_worker(
    death: Callable[..., None], client: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    logs = drives()
    kill, killed = killer(client)
    death(client, monkeypatch, kill)
    fleet = steerwright.dask.accumulate([*logs, logs[3]], client, fan_in=3, horizon=15, **COLUMNS)
    assert len(killed) == 1
    monkeypatch.undo()
    again = steerwright.dask.accumulate(logs, client, fan_in=3, horizon=15, **COLUMNS)
    assert fleet.to_json() == again.to_json()
    one_pass = steerwright.Accumulator(horizon=15, **COLUMNS)
    for log in logs:
        one_pass.add(log)
    assert fleet.samples == one_pass.samples
    ours = steerwright.identify(fleet, order=2)
    theirs = steerwright.identify(one_pass, order=2)
    omega = np.geomspace(0.1, 50.0, 20)
    np.testing.assert_allclose(
        ours.frequency_response(omega).response,
        theirs.frequency_response(omega).response,
        rtol=1e-9,
    )


def test_the_jobs_for_kubernetes_make_the_bytes_of_one_run(fmus: dict[str, Path], tmp_path: Path) -> None:
    yaml = pytest.importorskip("yaml")
    page = (Path(__file__).parents[2] / "docs/cluster.md").read_text("utf-8")
    blocks = [yaml.safe_load(block.split("```")[0]) for block in page.split("```yaml\n")[1:]]
    claim, sweep, merge = blocks
    assert claim["spec"]["accessModes"] == ["ReadWriteMany"]
    (tmp_path / "LateralLoop.ssp").write_bytes(fmus["LateralLoop"].read_bytes())
    (tmp_path / "study.toml").write_text(STUDY)
    steerwright.sweep(tmp_path / "study.toml", output=tmp_path / "whole.csv")
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}

    def run(job: dict[str, Any], index: int = 0) -> None:
        spec = job["spec"]["template"]["spec"]
        (container,) = spec["containers"]
        assert container["volumeMounts"][0]["mountPath"] == container["workingDir"]
        assert spec["volumes"][0]["persistentVolumeClaim"]["claimName"] == claim["metadata"]["name"]
        words = [*container["command"], *container.get("args", [])]
        words = [word.replace("$(JOB_COMPLETION_INDEX)", str(index)) for word in words]
        subprocess.run(words, cwd=tmp_path, env=environment, check=True, capture_output=True)

    # As many as the page has take a minute.
    sweep["spec"]["template"]["spec"]["containers"][0]["args"][1] = "$(JOB_COMPLETION_INDEX)/4"
    for index in range(4):
        run(sweep, index)
    run(merge)
    assert (tmp_path / "results.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_the_functions_of_the_spark_example_make_one_fleet() -> None:
    # Spark itself needs Java; what it calls is run here as it calls it.
    pandas = pytest.importorskip("pandas")
    page = (Path(__file__).parents[2] / "docs/cluster.md").read_text("utf-8")
    example = page.split("## Spark")[1].split("```python\n")[1].split("\nfactors = ")[0]
    names: dict[str, Any] = {}
    exec(example, names)  # noqa: S102
    names["OPTIONS"] = {**names["OPTIONS"], "horizon": 15, **COLUMNS}
    frames = [pandas.DataFrame({**log, "drive_id": f"drive {k}"}) for k, log in enumerate(drives())]
    groups = pandas.concat(frames).sample(frac=1.0, random_state=1).groupby("drive_id")
    documents = [names["accumulated"](group)["factor"][0] for _, group in groups]
    assert len(documents) == len(frames)
    tree = [names["merged"](*documents[k : k + 2]) for k in range(0, len(documents), 2)]
    while len(tree) > 1:
        tree = [names["merged"](tree[0], tree[1]), *tree[2:]]
    one_pass = steerwright.Accumulator(**names["OPTIONS"])
    for log in drives():
        one_pass.add(log)
    assert steerwright.Accumulator.from_json(tree[0]).samples == one_pass.samples


def test_errors_of_tasks_are_errors(client: Any, tmp_path: Path) -> None:
    with pytest.raises(steerwright.Error, match="missing.csv") as caught:
        steerwright.dask.accumulate([DRIVE, tmp_path / "missing.csv"], client, retries=0, **COLUMNS)
    assert caught.value.hint
    (tmp_path / "study.toml").write_text(STUDY.replace("LateralLoop", "/nothing"))
    with pytest.raises(steerwright.Error, match="nothing.ssp"):
        steerwright.dask.sweep(tmp_path / "study.toml", client)
