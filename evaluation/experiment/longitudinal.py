#!/usr/bin/env python3
"""The response of the speed to an acceleration command, on cars that no one of this project wrote.

Each of CommonRoad's three multi-body cars follows a profile of 5 to 30 m/s with steps, by a PI controller whose
acceleration command reaches the wheels at once, or by an actuator with a delay and a lag. `identify --structure
longitudinal` reads command and speed. Its response is then compared with that of the car itself, to small sines of the
command at constant speeds.

    cargo xtask experiment --longitudinal
    cargo xtask experiment --longitudinal -- --seed 7 --rate 50
"""

import argparse
import cmath
import math
import tempfile
from functools import partial
from pathlib import Path

import shared  # noqa: F401, finds the test drive's modules
import engagement
import numba
import numpy as np
import vehicle
from case import CARS
from drive_log import noisy, write_table
from program import DONE, NOT_MET, Program, read

STEP_S = 0.002
DURATION_S = 420.0
SPEEDS_MPS = (5.0, 30.0)
SPEED_NOISE_MPS = 0.03
LARGEST_COMMAND_MPS2 = (-4.0, 2.5)
# Delay and lag of the actuator, s.
ACTUATORS = ((0.0, 0.0), (0.12, 0.25))
COMPARED_MPS = (8.0, 22.0)
COMPARED_HZ = (0.1, 0.3, 1.0)
SINE_MPS2 = 0.3
# Largest error of the response of a model that passes, at 0.1 Hz.
TOLERANCE = 0.2


@numba.njit
def advance(state, acceleration, values, p):
    """A step of straight driving further, in place, by the classical Runge-Kutta method."""
    n = len(state)

    def rate(at):
        found = vehicle.vehicle_dynamics(at, [0.0, acceleration], p)
        out = np.empty(n)
        for i in range(n):
            out[i] = found[i]
        return out

    k1 = rate(state)
    k2 = rate(state + STEP_S / 2 * k1)
    k3 = rate(state + STEP_S / 2 * k2)
    k4 = rate(state + STEP_S * k3)
    for i in range(n):
        state[i] += STEP_S / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])


@numba.njit
def drive(state, profile, unrest, is_closed, every, delay, lag, values):
    """Command and speed every `every` steps. In a closed loop the command follows the profile of the speed, otherwise it
    is the profile. The actuator delays by whole steps."""
    p = vehicle.unpack(values)
    count = len(profile)
    sent = np.zeros(count)
    commands, speeds = np.empty(count // every), np.empty(count // every)
    integral, command, acting = 0.0, 0.0, 0.0
    for k in range(count):
        if is_closed:
            if k % every == 0:
                error = profile[k] - state[vehicle.SPEED]
                integral = max(-2.0, min(2.0, integral + 0.15 * every * STEP_S * error))
                command = max(-4.0, min(2.5, 0.8 * error + integral + unrest[k // every]))
        else:
            command = profile[k]
        if k % every == 0:
            commands[k // every], speeds[k // every] = command, state[vehicle.SPEED]
        sent[k] = command
        late = sent[k - delay] if k >= delay else 0.0
        acting = late if lag == 0.0 else acting + STEP_S * (late - acting) / lag
        advance(state, acting, values, p)
    return commands, speeds


def profile(rng):
    """Speeds to follow, m/s: steps and ramps."""
    wanted, count = [], round(DURATION_S / STEP_S)
    value = 12.0
    while len(wanted) < count:
        goal, seconds = rng.uniform(*SPEEDS_MPS), rng.uniform(4.0, 14.0)
        # A third are steps, the others ramps of up to 2 m/s2.
        slope = math.inf if rng.uniform() < 0.33 else rng.uniform(0.5, 2.0)
        for _ in range(round(seconds / STEP_S)):
            value += max(-slope * STEP_S, min(slope * STEP_S, goal - value))
            wanted.append(value)
    return np.array(wanted[:count])


def response_of_car(car, speed, frequency_hz, delay, lag):
    """From the command to the rate of the speed, by a small sine around a constant speed."""
    cycles = max(4, math.ceil(3.0 * frequency_hz))
    period = round(1.0 / frequency_hz / STEP_S)
    time_s = STEP_S * np.arange((cycles + 2) * period)
    sine = SINE_MPS2 * np.sin(2.0 * math.pi * frequency_hz * time_s)
    unrest = np.zeros(len(sine))
    commands, speeds = drive(car.at_start(speed), sine, unrest, False, 1, delay, lag, car.parameters)
    rates = np.gradient(speeds, STEP_S)
    used = slice(2 * period, None)
    wave = np.exp(-2j * math.pi * frequency_hz * time_s[used])
    return (rates[used] @ wave) / (commands[used] @ wave)


def response_of_model(model, speed, frequency_hz):
    """The same of a file."""
    rows = model["gains"]
    gain = np.interp(speed, [row["speed_mps"] for row in rows], [row["gain"]["value"] for row in rows])
    s = 2j * math.pi * frequency_hz
    fast = gain * cmath.exp(-s * model["delay_s"]["value"]) / (1.0 + s * model["time_constant_s"]["value"])
    damping = model.get("resistance_per_speed", {"value": 0.0})["value"] + 2.0 * speed * model["drag_per_m"]["value"]
    return fast * s / (s + damping)


def text_of(estimate):
    return f"{estimate['value']:.4f} ± {1.96 * estimate['standard_error']:.4f}"


def compare(program, seed, rate_hz, task):
    number, (delay_s, lag_s) = task
    car = vehicle.Car(number)
    rng = np.random.default_rng([number, seed, 3])
    every, delay = round(1.0 / rate_hz / STEP_S), round(delay_s / STEP_S)
    wanted = profile(rng)
    unrest = 0.1 * rng.standard_normal(len(wanted) // every)
    commands, speeds = drive(car.at_start(12.0), wanted, unrest, True, every, delay, lag_s, car.parameters)
    with tempfile.TemporaryDirectory() as name:
        log, file = Path(name) / "drive.csv", Path(name) / "longitudinal.json"
        columns = [every * STEP_S * np.arange(len(speeds)), commands, noisy(rng, speeds, SPEED_NOISE_MPS)]
        write_table(log, "time_s,acceleration_command_mps2,speed_mps", (3, 5, 4), columns)
        program.run("identify", log, "--structure", "longitudinal", "-o", file, accept=(DONE, NOT_MET))
        model = read(file)
    quality, evidence = model["quality"], model["evidence"]
    lines = [
        f"{vehicle.NAMES[number]}, actuator with {1e3 * delay_s:.0f} ms delay and {1e3 * lag_s:.0f} ms lag: "
        f"{quality['grade']}, fit {evidence['validation_fit']:.1f} % on validation data",
        "  gain " + ", ".join(f"{row['speed_mps']:.0f} m/s {text_of(row['gain'])}" for row in model["gains"]),
        f"  lag {text_of(model['time_constant_s'])} s, delay {text_of(model['delay_s'])} s",
        f"  resistance {text_of(model['resistance_mps2'])} m/s2, drag {text_of(model['drag_per_m'])} 1/m",
    ]
    lines += [f"  {reason['code']}: {reason['message']}" for reason in quality.get("reasons", [])]
    wrong = 0
    for speed in COMPARED_MPS:
        errors = []
        for frequency_hz in COMPARED_HZ:
            truth = response_of_car(car, speed, frequency_hz, delay, lag_s)
            of_model = response_of_model(model, speed, frequency_hz)
            errors.append(abs(of_model / truth - 1.0))
            is_wrong = frequency_hz == COMPARED_HZ[0] and abs(abs(of_model / truth) - 1.0) > TOLERANCE
            wrong += is_wrong and quality["grade"] == "pass"
        shown = ", ".join(f"{100 * e:.1f} % at {hz:g} Hz" for e, hz in zip(errors, COMPARED_HZ))
        lines.append(f"  error of the response at {speed:.0f} m/s: {shown}")
    return quality["grade"], wrong, "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1, help="of the drives")
    parser.add_argument("--rate", type=float, default=50.0, help="of the log, Hz")
    options = parser.parse_args()
    tasks = [(number, actuator) for actuator in ACTUATORS for number in CARS]
    work = partial(compare, Program(options.program), options.seed, options.rate)
    passed, wrong = 0, 0
    for grade, own_wrong, text in engagement.in_parallel(work, tasks):
        print(text, flush=True)
        passed += grade == "pass"
        wrong += own_wrong
    print(f"{passed} of {len(tasks)} pass; of these {wrong} responses are wrong by more than {TOLERANCE:.0%} at {COMPARED_HZ[0]} Hz")
    raise SystemExit(0 if passed == len(tasks) and wrong == 0 else 1)


if __name__ == "__main__":
    main()
