#!/usr/bin/env python3
"""From where a designed controller brings a car back: engaged next to the road, turned, with a servo as
stated and with slower ones; and yaw steps from 1 to 90 degrees.

Each of the three multi-body cars at three speeds has a controller, designed on its data sheet for a
servo of 0.4 rad/s. Straight road, ReferencePath and LateralPid as packed FMUs, true pose. A car is lost
that slides by more than 30 degrees, that comes further than 60 m from the road (from 10 m and 45
degrees at 25 m/s a turn of 6 m/s2 itself takes it to 41 m), or that is not within 0.5 m of it during
the last 2 s.

    cargo xtask experiment --engagement             9 cases of 8 starts a servo
    cargo xtask experiment --engagement --quick     one car
"""

import argparse
import math
import multiprocessing
import os
import tempfile
from functools import partial
from pathlib import Path

import shared  # noqa: F401, finds the test drive's modules
import numpy as np
import pid_law
import road
import vehicle
import yaw_step
from case import CARS, Case
from contenders import Workshop
from program import Program
from units import Archive
from vehicle import SAMPLE_TIME_S, STEPS, advance

SPEEDS_MPS = (8.0, 15.0, 25.0)
SERVOS_RADPS = (0.4, 0.25, 0.15)
# Metres to the left of the road, degrees of heading away from it.
STARTS = ((2, 0), (5, 0), (10, 0), (0, 20), (0, -20), (5, 20), (5, -20), (10, 45))
STEPS_DEG = (1, 2, 5, 10, 20, 45, 90)
ENGAGED_S, STEP_S = 30.0, 20.0
SLIDES_RAD, AWAY_M, BACK_M, BACK_S = math.radians(30.0), 60.0, 0.5, 2.0


def straight_road(workshop, case, folder):
    """The archive of a straight road for the controller in a folder."""
    track = folder / "straight.toml"
    length = 1.2 * ENGAGED_S * case.speed
    track.write_text(f'name = "straight"\n[[segments]]\nlength_m = {length:.0f}\n')
    workshop.path(case.speed, None, folder, track)
    return Archive(folder / "ReferencePath.fmu")


def is_lost(case, path, pid, start, servo):
    """Whether the car does not come back from a start; `path` and `pid` are archives."""
    state, p = case.car.at_start(case.speed), case.car.parameters
    state[vehicle.Y], state[vehicle.YAW] = start[0], math.radians(start[1])
    steering, count = road.Steering(path, pid, case.speed, {}), round(ENGAGED_S / SAMPLE_TIME_S)
    lost = False
    for k in range(count):
        x, off, yaw, speed = state[[vehicle.X, vehicle.Y, vehicle.YAW, vehicle.SPEED]]
        slip = math.atan2(state[vehicle.LATERAL_VELOCITY], speed)
        largest = AWAY_M if (count - k) * SAMPLE_TIME_S > BACK_S else BACK_M
        command = steering.command(k, (x, off, yaw, 0.0), speed)
        known = advance(state, command, case.speed, p, STEPS, servo)
        lost = abs(off) > largest or abs(slip) > SLIDES_RAD or not known
        if lost:
            break
    steering.close()
    return lost


def study(workshop, folder, case):
    """For each servo: starts from which the car is lost; overshoot, percent, and settling time, s, of steps."""
    folder = folder / case.name
    workshop.datasheet(case, folder)
    path, pid = straight_road(workshop, case, folder), Archive(folder / "LateralPid.fmu")
    found = []
    for servo in SERVOS_RADPS:
        lost = [start for start in STARTS if is_lost(case, path, pid, start, servo)]
        steps = []
        for degrees in STEPS_DEG:
            start, height = case.car.at_start(case.speed), math.radians(degrees)
            response = yaw_step.respond(case.car, case.speed, pid, start, STEP_S, height, servo)
            m = yaw_step.metrics(*response, height)
            settled = math.inf if m.settling_time_s is None else m.settling_time_s
            steps.append(f"{m.overshoot_percent:.1f}/{settled:.2f}")
        found.append((servo, lost, steps))
    path.remove()
    pid.remove()
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    cars = (2,) if options.quick else CARS
    cases = [Case(car, speed) for car in cars for speed in SPEEDS_MPS]
    workshop = Workshop(Program(options.program), ("--max-rate", f"{SERVOS_RADPS[0]}rad/s"))
    lost = dict.fromkeys(SERVOS_RADPS, 0)
    print("car        servo     lost  overshoot % / settling s of steps of", *STEPS_DEG, "deg")
    with tempfile.TemporaryDirectory() as folder:
        for case, found in zip(cases, in_parallel(partial(study, workshop, Path(folder)), cases)):
            for servo, away, steps in found:
                lost[servo] += len(away)
                print(f"{case.name:10} {servo} rad/s {len(away)}  {'  '.join(steps)}", *away, flush=True)
    for servo, count in lost.items():
        print(f"servo {servo} rad/s: {count} of {len(cases) * len(STARTS)} lost")
    raise SystemExit(1 if any(lost.values()) else 0)


def in_parallel(function, tasks):
    """What a function returns for each task, in order, as they come."""
    pid_law.compile_all(vehicle.Car(CARS[0]))  # for all forks
    with multiprocessing.get_context("fork").Pool(os.cpu_count()) as pool:
        yield from pool.imap(function, tasks)


if __name__ == "__main__":
    main()
