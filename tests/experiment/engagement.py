#!/usr/bin/env python3
"""From where a designed controller brings a car back: engaged next to the road, turned, with a servo as
stated and with slower ones; and yaw steps from 1 to 90 degrees.

Each of the three multi-body cars at three speeds has a controller, designed on its data sheet for a
servo of 0.4 rad/s. Straight road, look-ahead guidance as `path` sets it up, true pose. A car is lost
that slides by more than 30 degrees, that comes further than 60 m from the road (from 10 m and 45
degrees at 25 m/s a turn of 6 m/s2 itself takes it to 41 m), or that is not within 0.5 m of it during
the last 2 s.

    cargo xtask experiment --engagement             9 cases of 8 starts a servo
    cargo xtask experiment --engagement --quick     one car
    engagement.py --pids FOLDER                                   controllers that are there: car2_15mps.json
"""

import argparse
import math
import tempfile
from pathlib import Path

import shared  # noqa: F401, finds the test drive's modules
import numba
import numpy as np
import pid_law
import vehicle
from case import Case
from pid_file import gains_of, limits_of
from program import Program, read
from vehicle import STEPS, advance

SPEEDS_MPS = (8.0, 15.0, 25.0)
SERVOS_RADPS = (0.4, 0.25, 0.15)
# Metres to the left of the road, degrees of heading away from it.
STARTS = ((2, 0), (5, 0), (10, 0), (0, 20), (0, -20), (5, 20), (5, -20), (10, 45))
STEPS_DEG = (1, 2, 5, 10, 20, 45, 90)
ENGAGED_S, STEP_S = 30.0, 20.0
SLIDES_RAD, AWAY_M, BACK_M, BACK_S = math.radians(30.0), 60.0, 0.5, 2.0


@numba.njit
def run(state, speed, p, gains, limits, height, lookahead, servo, count):
    """Yaw, cross-track error and sideslip; a step of `height`, or the road where `lookahead` is not 0."""
    found, memory = np.zeros((count, 3)), np.zeros(pid_law.MEMORY)
    for k in range(count):
        yaw, off = state[vehicle.YAW], state[vehicle.Y]
        found[k] = (yaw, off, math.atan2(state[vehicle.LATERAL_VELOCITY], state[vehicle.SPEED]))
        reference = math.atan2(-off, lookahead) if lookahead > 0.0 else height
        command = pid_law.tick(memory, gains, limits, reference, yaw)
        if not advance(state, command, speed, p, STEPS, servo):
            found[k:] = 1e3
            break
    return found


def lookahead_of(pid, speed):
    """Metres, as `path` sets it up."""
    time = max(1.0, 4.0 * pid["guidance"]["preview_time_s"])
    return max(time * speed, min(max(0.5 * time * speed, 2.0), 5.0))


def is_lost(found):
    last = found[-round(BACK_S / vehicle.SAMPLE_TIME_S) :, 1]
    off, slip = np.max(np.abs(found[:, 1])), np.max(np.abs(found[:, 2]))
    return bool(off > AWAY_M or slip > SLIDES_RAD or np.max(np.abs(last)) > BACK_M)


def study(case, pid, servo):
    """Starts from which the car is lost, and overshoot, percent, and settling time, s, of each step."""
    gains, limits, p = gains_of(pid), limits_of(pid), case.car.parameters
    lost, steps = [], []
    for off, degrees in STARTS:
        state = case.car.at_start(case.speed)
        state[vehicle.Y], state[vehicle.YAW] = off, math.radians(degrees)
        ahead, count = lookahead_of(pid, case.speed), round(ENGAGED_S / vehicle.SAMPLE_TIME_S)
        if is_lost(run(state, case.speed, p, gains, limits, 0.0, ahead, servo, count)):
            lost.append((off, degrees))
    for degrees in STEPS_DEG:
        state, height = case.car.at_start(case.speed), math.radians(degrees)
        count = round(STEP_S / vehicle.SAMPLE_TIME_S)
        y = run(state, case.speed, p, gains, limits, height, 0.0, servo, count)[:, 0] / height
        outside = np.flatnonzero(np.abs(y - 1.0) > 0.02)
        settled = (outside[-1] + 1) * vehicle.SAMPLE_TIME_S
        steps.append((100.0 * max(0.0, y.max() - 1.0), settled if settled < STEP_S else math.inf))
    return lost, steps


def designed(program, case, folder):
    toml, bicycle, pid = (folder / f"{case.name}.{end}" for end in ("toml", "bicycle.json", "json"))
    toml.write_text(case.datasheet())
    program.bicycle(toml, bicycle)
    return program.design(bicycle, pid, "--max-rate", f"{SERVOS_RADPS[0]}rad/s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path)
    parser.add_argument("--pids", type=Path)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    if (options.program is None) == (options.pids is None):
        parser.error("give --program or --pids")
    cars = (2,) if options.quick else (1, 2, 3)
    cases = [Case(car, speed) for car in cars for speed in SPEEDS_MPS]
    lost = dict.fromkeys(SERVOS_RADPS, 0)
    print("car        servo     lost  overshoot % / settling s of steps of", *STEPS_DEG, "deg")
    with tempfile.TemporaryDirectory() as folder:
        for case in cases:
            if options.pids:
                pid = read(options.pids / f"{case.name}.json")
            else:
                pid = designed(Program(options.program), case, Path(folder))
            for servo in SERVOS_RADPS:
                away, steps = study(case, pid, servo)
                lost[servo] += len(away)
                row = "  ".join(f"{overshoot:.1f}/{settling:.2f}" for overshoot, settling in steps)
                print(f"{case.name:10} {servo} rad/s {len(away)}  {row}", *away, flush=True)
    for servo, count in lost.items():
        print(f"servo {servo} rad/s: {count} of {len(cases) * len(STARTS)} lost")
    raise SystemExit(1 if any(lost.values()) else 0)


if __name__ == "__main__":
    main()
