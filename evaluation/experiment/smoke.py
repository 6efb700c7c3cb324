#!/usr/bin/env python3
"""The experiment in a few minutes, at speeds, rates and starts on which nothing was tuned.

Ten speeds, the three multi-body cars in turn. Each car is identified from a drive as in the experiment, a
controller is designed for each steering rate, and the servo turns at the rate that was stated to the design.

* 30 drives along the standard road with corrected GNSS. It needs a share of the steering rate: the change of
  its curvature over that of the car in a steady turn. A car is off the path beyond 0.5 m.
* The standard road at 8 m/s by designs on drives at 15 m/s, of each car: within 0.2 m RMS.
* 12 yaw steps of 5 degrees.
* 24 engagements next to a straight road, at up to 25 m/s, with the servo as stated and with slower ones.

It fails on a car off a road that needs no more than the rate or beyond those 0.2 m, on a lost engagement, and on a step that misses
the specification, or what its design predicts where that is worse, by more than `MARGINS`.

    cargo xtask experiment --smoke               the points that CI drives
    cargo xtask experiment --smoke --seed 7      others
"""

import argparse
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import shared  # noqa: F401, finds the test drive's modules
import engagement
import numpy as np
import road
import sensors
import yaw_step
from case import CARS, Case
from contenders import Workshop
from engagement import BACK_M, SERVOS_RADPS
from experiment import estimator_archive
from program import Program
from study import ROAD_ACCELERATION_MPS2, needed_steering_rate, road_scores, sideslip
from units import Archive

SPEEDS_MPS = (5.7, 6.9, 9.3, 12.1, 14.2, 17.3, 19.6, 23.4, 26.2, 29.1)
RANGE_MPS = (5.0, 30.0)
RATES_RADPS = (0.40, 0.27, 0.18)
FASTEST_ENGAGED_MPS = 25.0
DRIVE_SEED = 1
STEPS = 12
# Of a design and of the road that it drives, m/s, and the largest RMS error there, m.
DESIGNED_MPS, DRIVEN_MPS, LARGEST_RMS_M = 15.0, 8.0, 0.2
# Overshoot, percent, settling time, s, and steady-state error, percent, of a car beyond the specification.
MARGINS = {"overshoot_percent": 1.0, "settling_time_s": 0.1, "steady_state_error_percent": 1.0}


@dataclass
class Point:
    """What is driven at a speed."""

    case: Case
    seed: int
    steps: list  # steering rates of the designs that step
    engagements: list  # servo and start


def points(seed):
    """The fixed ones, or those of a seed."""
    speeds, starts = SPEEDS_MPS, engagement.STARTS
    if seed is not None:
        rng = np.random.default_rng([seed, 30])
        bounds = np.geomspace(*RANGE_MPS, len(SPEEDS_MPS) + 1)
        speeds = [round(rng.uniform(*pair), 1) for pair in zip(bounds, bounds[1:])]
        starts = [tuple(np.round(rng.uniform((-10, -45), (10, 45)), 1)) for _ in starts]
    cases = [Case(CARS[i % len(CARS)], speed) for i, speed in enumerate(speeds)]
    found = [Point(case, DRIVE_SEED if seed is None else seed, [], []) for case in cases]
    for i in range(STEPS):
        found[i % len(found)].steps.append(RATES_RADPS[i % len(RATES_RADPS)])
    slow = [point for point in found if point.case.speed <= FASTEST_ENGAGED_MPS]
    for i, servo in enumerate(SERVOS_RADPS):
        for j, start in enumerate(starts):
            slow[(3 * i + j) % len(slow)].engagements.append((servo, start))
    return found


def drive(program, estimator, folder, point):
    """Lines of figures, and what failed."""
    case, folder = point.case, folder / point.case.name
    folder.mkdir()
    log, fixes = folder / "drive.csv", folder / "fixes.csv"
    states, _ = case.record(log, point.seed)
    case.record_fixes(fixes, point.seed, states)
    lines, failed = [], []
    for rate in RATES_RADPS:
        workshop = Workshop(program, ("--max-rate", f"{rate}rad/s"))
        out = folder / f"{rate}"
        if rate == RATES_RADPS[0]:
            out.mkdir()
            plant, pid = workshop.identified(log, fixes, out)
        else:
            pid = workshop.controller(folder / f"{RATES_RADPS[0]}" / "plant.json", out)
        way = workshop.path(case.speed, ROAD_ACCELERATION_MPS2, out)
        share = needed_steering_rate(case, way) / rate
        scores = on_the_road(case, point.seed, rate, estimator, out, sideslip(plant), way["length_m"])
        rms, largest = scores["cross_track_rms_m"], scores["cross_track_largest_m"]
        line = f"{case.name:11} {rate:.2f} rad/s  road {share:4.2f} of it: {rms:.3f}, largest {largest:.3f} m"
        if share <= 1.0 and not (scores["finished"] and largest <= BACK_M):
            failed.append(f"{line}: off the path")
        if rate in point.steps:
            metrics, missed = step(case, pid, rate, out)
            line += "  step " + ", ".join(f"{metrics[name]:.2f}" for name in MARGINS)
            failed += [f"{line}: {name}" for name in missed]
        lines.append(line)
    out = folder / f"{RATES_RADPS[0]}"
    workshop = Workshop(program, ())
    straight, pid = engagement.straight_road(workshop, case, out), Archive(out / "LateralPid.fmu")
    for servo, start in point.engagements:
        if engagement.is_lost(case, straight, pid, start, servo):
            failed.append(f"{case.name:11} servo {servo} rad/s, from {start[0]} m and {start[1]} deg: lost")
    straight.remove()
    pid.remove()
    return lines, failed


def drive_slower(program, estimator, folder, seed, car):
    """A line of figures, and what failed, of a design at one speed on a road at another."""
    designed, driven = (Case(car, speed) for speed in (DESIGNED_MPS, DRIVEN_MPS))
    folder = folder / f"{designed.name} slower"
    folder.mkdir()
    log, fixes, rate = folder / "drive.csv", folder / "fixes.csv", RATES_RADPS[0]
    states, _ = designed.record(log, seed)
    designed.record_fixes(fixes, seed, states)
    workshop = Workshop(program, ("--max-rate", f"{rate}rad/s"))
    plant, _ = workshop.identified(log, fixes, folder)
    way = workshop.path(driven.speed, ROAD_ACCELERATION_MPS2, folder)
    scores = on_the_road(driven, seed, rate, estimator, folder, sideslip(plant), way["length_m"])
    rms = scores["cross_track_rms_m"]
    line = f"{driven.name:11} by a design on a drive at {designed.speed:.0f} m/s: {rms:.3f} m"
    is_near = scores["finished"] and rms <= LARGEST_RMS_M
    return [line], [] if is_near else [f"{line}: off the path"]


def on_the_road(case, seed, rate, estimator, folder, slip, length):
    archives = [Archive(folder / f"{name}.fmu") for name in ("ReferencePath", "LateralPid")]
    loop = road.Loop(Archive(estimator), *archives)
    count = round((length / case.speed + road.LEAD_IN_S + road.MARGIN_S) / road.SAMPLE_TIME_S) + 1
    read = sensors.Sensors(sensors.CORRECTED, [*case.seed(5), seed], 0.0, count)
    scores = road_scores(*road.follow(case.car, case.speed, loop, read, slip, length, rate))
    for archive in (loop.estimator, *archives):
        archive.remove()
    return scores


def step(case, pid, rate, folder):
    """Figures of the yaw step, and those that miss."""
    archive, start = Archive(folder / "LateralPid.fmu"), case.car.at_start(case.speed)
    found = yaw_step.metrics(*yaw_step.respond(case.car, case.speed, archive, start, servo=rate)).as_dict()
    archive.remove()
    found["settling_time_s"] = found["settling_time_s"] or yaw_step.DURATION_S
    stated, predicted = pid["specification"], pid["evidence"]["step"]
    worst = {name: max(stated[name], predicted[name] or 0.0) + margin for name, margin in MARGINS.items()}
    return found, [name for name in MARGINS if found[name] > worst[name]]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--seed", type=int)
    options = parser.parse_args()
    program, chosen, failed = Program(options.program), points(options.seed), []
    print("car and speed, steering rate, share of it that the road needs: cross-track error, RMS and largest;")
    print("yaw step: overshoot %, settling time s, steady-state error %")
    with tempfile.TemporaryDirectory() as folder:
        estimator = estimator_archive(program, Path(folder))
        whole = partial(drive, program, estimator, Path(folder))
        slower = partial(drive_slower, program, estimator, Path(folder), chosen[0].seed)
        for work, tasks in ((whole, chosen), (slower, CARS)):
            for lines, missed in engagement.in_parallel(work, tasks):
                print("\n".join(lines), flush=True)
                failed += missed
    print(f"{len(failed)} failures", *failed, sep="\n")
    raise SystemExit(1 if failed else 0)


if __name__ == "__main__":
    main()
