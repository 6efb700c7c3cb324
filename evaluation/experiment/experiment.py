#!/usr/bin/env python3
"""Controllers designed from a drive, on cars that no one of this project wrote.

For each of CommonRoad's three multi-body cars at 8, 15 and 22 m/s and each seed: record the drive,
identify, design, pack, step the yaw by 5° on the car, and track the road. Outcomes go to the output
folder; what is there already, from the same program and the same scripts, is not done again.

    cargo xtask experiment               20 seeds
    cargo xtask experiment --quick       2 seeds
"""

import argparse
import hashlib
import json
import multiprocessing
import os
import sys
import time
from pathlib import Path

import shared  # finds the test drive's modules
import case
import contenders
import figures
import page
import pid_law
import road
import scores
import sensors
import study
import tables
import vehicle
from program import Program

ESTIMATOR = {
    "schema": "steerwright/estimator/1",
    "name": "GNSS, gyro and wheel speeds of the experiment",
    "gnss": {
        "latency_s": sensors.LATENCY_S,
        "antenna_x_m": sensors.ANTENNA_M[0],
        "antenna_y_m": sensors.ANTENNA_M[1],
    },
    "sideslip_per_yaw_rate_s": 0.0,
    "noise": {
        "yaw_rate_density": sensors.GYRO_NOISE_RADPS * vehicle.SAMPLE_TIME_S**0.5,
        "yaw_rate_bias_density": 1e-5,
        "speed_density": sensors.SPEED_NOISE_MPS * vehicle.SAMPLE_TIME_S**0.5,
        "lateral_velocity_density": 0.02,
        "sideslip_per_yaw_rate_density": 1e-3,
    },
    "initial": {
        "position_std_m": 0.1,
        "yaw_std_rad": sensors.INITIAL_YAW_STD_RAD,
        "yaw_rate_bias_std_radps": sensors.GYRO_BIAS_RADPS,
        "sideslip_per_yaw_rate_std_s": 0.02,
    },
    "speed_mps": 15.0,
}


def arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", required=True, help="the command line under test")
    parser.add_argument("--out", type=Path, required=True, help="folder of the outcomes")
    parser.add_argument("--record", type=Path, metavar="FILE", help="write the tables there, too")
    parser.add_argument("--seeds", type=int, default=20, help="of each case (default: 20)")
    parser.add_argument("--quick", action="store_true", help="2 seeds")
    parser.add_argument("--cases", nargs="+", metavar="CASE", help="such as car2_15mps; all if none")
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    parser.add_argument(
        "--pose",
        default="estimator",
        help="estimator (default), truth, or the archive of another PoseEstimator",
    )
    parser.add_argument(
        "--design",
        default=" ".join(contenders.DESIGN),
        help="options of every design (default: %(default)s)",
    )
    return parser.parse_args()


def key_of(options):
    """Of all that an outcome depends on, the seed apart."""
    digest = hashlib.sha256(Path(options.program).read_bytes())
    here = Path(__file__).parent
    for file in sorted([*here.glob("*.py"), *Path(shared.MULTIBODY).glob("*.py")]):
        if file.name not in ("figures.py", "page.py", "tables.py", "scores.py", "experiment.py"):
            digest.update(file.read_bytes())
    digest.update((here / "requirements.txt").read_bytes())
    digest.update(f"{options.design}\0{options.pose}\0{json.dumps(ESTIMATOR)}".encode())
    if Path(options.pose).is_file():
        digest.update(Path(options.pose).read_bytes())
    return digest.hexdigest()


def estimator(options, program):
    """The archive of the pose estimator; `None` for the true pose."""
    if options.pose == "truth":
        return None
    if options.pose != "estimator":
        return Path(options.pose)
    folder = options.out / "work"
    folder.mkdir(parents=True, exist_ok=True)
    return estimator_archive(program, folder)


def estimator_archive(program, folder):
    """The packed estimator of the experiment's sensors."""
    file = folder / "estimator.json"
    file.write_text(json.dumps(ESTIMATOR, indent=1) + "\n")
    program.package(folder, file)
    return folder / "PoseEstimator.fmu"


def perform(task):
    """A seed of a case, or what all its seeds share. A seed that fails is an outcome, too: what was
    found for the others stands."""
    the_study, of, seed = task
    what = f"{of.name} seed {seed}" if seed else f"{of.name} datasheet and tuned"
    began = time.monotonic()
    try:
        found = the_study.run(of, seed) if seed else the_study.prepare(of)
    except Exception as problem:
        if seed:
            print(f"{what}: {problem}", file=sys.stderr, flush=True)
            return {"case": of.name, "seed": seed, "failed": str(problem).strip()}
        # Not every exception survives the way to another process: fmpy's do not.
        raise RuntimeError(f"{what}: {problem}") from None
    print(f"{what}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    return found


def perform_all(the_study, cases, seeds, processes):
    """Outcomes of every seed of every case, in this order."""
    # The slow cars take the longest to the road's end: first, so that no process waits for them.
    cases = sorted(cases, key=lambda c: c.speed)
    first = [(the_study, c, None) for c in cases]
    then = [(the_study, c, seed) for c in cases for seed in range(1, seeds + 1)]
    if processes < 2:
        return [perform(task) for task in first + then][len(first) :]
    # A fork has the compiled vehicle already.
    forks = "fork" in multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("fork" if forks else "spawn")
    with context.Pool(processes) as pool:
        pool.map(perform, first, chunksize=1)
        return pool.map(perform, then, chunksize=1)


def conditions(options):
    pose = {"truth": "the true pose", "estimator": "the packed PoseEstimator"}
    g = sensors
    return (
        f"Road: double lane change and S-curve at {study.ROAD_ACCELERATION_MPS2} m/s² at most. "
        f"Design options: `{options.design}`. Pose: {pose.get(options.pose, 'a given estimator')}. "
        f"GNSS: 10 Hz, {g.CORRECTED.deviation_m} m corrected, {g.UNCORRECTED.deviation_m} m "
        f"uncorrected, {g.LATENCY_S} s late, drop-outs of {g.DROP_OUT.drop_out_s} s. Gyro: bias "
        f"{g.GYRO_BIAS_RADPS} rad/s (1σ), noise {g.GYRO_NOISE_RADPS} rad/s. Limits: ±22°, 15° a "
        f"sample. Before the road {road.LEAD_IN_S:.0f} s straight."
    )


def main():
    options = arguments()
    seeds = 2 if options.quick else options.seeds
    known = {c.name: c for c in case.every()}
    chosen = [known[name] for name in options.cases or known]
    program = Program(options.program)
    options.out.mkdir(parents=True, exist_ok=True)
    workshop = contenders.Workshop(program, tuple(options.design.split()))
    the_study = study.Study(workshop, estimator(options, program), options.out, key_of(options))

    pid_law.compile_all(chosen[0].car)  # for all forks
    runs = perform_all(the_study, chosen, seeds, options.processes)
    runs.sort(key=lambda run: (run["case"], run["seed"]))
    failed = [run for run in runs if "failed" in run]
    runs = [run for run in runs if "failed" not in run]
    if not runs:
        sys.exit("every drive failed")

    (options.out / "results.json").write_text(json.dumps(runs, indent=1) + "\n")
    scores.write_csv(runs, options.out / "results.csv")
    figures.draw(runs, options.out)
    text = tables.everything(runs, conditions(options)) + tables.failures(failed, len(runs))
    (options.out / "results.md").write_text(text)
    (options.out / "results.html").write_text(page.page(text, options.out))
    if options.record:
        options.record.write_text(text)
    print(text)
    if failed:
        sys.exit(1)


if __name__ == "__main__":
    main()
