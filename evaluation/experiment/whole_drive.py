#!/usr/bin/env python3
"""Models of a whole drive, from 5 to 30 m/s and to 7 m/s², on cars that no one of this project wrote.

Each of CommonRoad's three multi-body cars is driven twice; bicycle and single-track model are identified on the
first drive and simulated freely on the second. The packed vehicle is then compared with the car itself in small
steps at constant speeds, by its frequency response.

    cargo xtask experiment --whole-drive
"""

import argparse
import json
import math
import tempfile
import time
from pathlib import Path

import shared  # finds the test drive's modules
import numba
import numpy as np
import pid_law
import vehicle
from drive_log import write_drive
from excitation import SAMPLE_TIME_S, limit_rate
from program import DONE, NOT_MET, Program
from units import Archive, Unit

DURATION_S = 150.0
SPEEDS_MPS = (5.0, 30.0)
LARGEST_ACCELERATION_MPS2 = 3.0  # along
LARGEST_LATERAL_MPS2 = 7.0
LARGEST_ANGLE_RAD = 0.35
COMPARED_MPS = (8.0, 15.0, 22.0, 30.0)
BAND_HZ = (0.1, 2.0)
DRIVEN_CHANNELS = ("steering_command_rad", "yaw_rate_radps", "speed_mps")
WARM_UP_S = 3.0


@numba.njit
def drive(state, command, speed, values):
    """States at the samples, each before its command acts, with a speed for each sample."""
    states = np.empty((len(command), len(state)))
    for k in range(len(command)):
        for i in range(len(state)):
            states[k, i] = state[i]
        vehicle.advance(state, command[k], speed[k], values, vehicle.STEPS)
    return states


def slow(rng, count, period_s):
    """A random signal with a deviation of 1 that changes within about `period_s`."""
    width = round(period_s / SAMPLE_TIME_S)
    window = np.hanning(2 * width + 1)
    signal = np.convolve(rng.standard_normal(count + 2 * width), window, mode="valid")
    return signal / math.sqrt(np.sum(window**2))


def speeds(rng, count):
    """Speed wanted, m/s, between the bounds and within the bound of its rate."""
    low, high = SPEEDS_MPS
    wanted = 0.5 * (low + high) + 0.5 * (high - low) * np.clip(1.3 * slow(rng, count, 12.0), -1.0, 1.0)
    most = LARGEST_ACCELERATION_MPS2 * SAMPLE_TIME_S
    for k in range(1, count):
        wanted[k] = wanted[k - 1] + np.clip(wanted[k] - wanted[k - 1], -most, most)
    return wanted


def steering(car, speed, lateral):
    """Road-wheel angles of steady turns, as quickly as the driver turns the wheel."""
    wheelbase, at = car.published.a + car.published.b, 15.0
    understeer = (at / pid_law.steady_gain(car, at) - wheelbase) / at**2
    command = (wheelbase / speed**2 + understeer) * lateral
    command = limit_rate(np.clip(command, -LARGEST_ANGLE_RAD, LARGEST_ANGLE_RAD))
    return np.round(command, 7) + 0.0


def lateral_acceleration(car, states, command, speed):
    """Of the body: dv_y/dt + r v_x."""
    rates = [
        vehicle.rates(state, command[k], speed[k], car.parameters)[vehicle.LATERAL_VELOCITY]
        for k, state in enumerate(states)
    ]
    return np.array(rates) + states[:, vehicle.YAW_RATE] * states[:, vehicle.SPEED]


def record(car, file, seed):
    """Drives and writes the log; returns the largest lateral acceleration, m/s2."""
    levels, noise = np.random.default_rng([car.number, seed]).spawn(2)
    count = round(DURATION_S / SAMPLE_TIME_S)
    speed = speeds(levels, count)
    lateral = 0.35 * slow(levels, count, 1.5) + 0.2 * slow(levels, count, 0.4)
    lateral = LARGEST_LATERAL_MPS2 * np.clip(lateral, -1.0, 1.0)
    for _ in range(10):
        command = steering(car, speed, lateral)
        states = drive(car.at_start(speed[0]), command, speed, car.parameters)
        acceleration = lateral_acceleration(car, states, command, speed)
        # Beyond the limit it rises without more steering.
        excess = np.max(np.abs(acceleration)) / LARGEST_LATERAL_MPS2
        if excess < 1.02:
            break
        lateral *= max(0.8, 1.0 / excess)
    truth = [states[:, i] for i in (vehicle.STEER, vehicle.YAW_RATE, vehicle.SPEED)]
    write_drive(file, noise, SAMPLE_TIME_S, command, *truth, acceleration)
    return float(np.max(np.abs(acceleration))), states


def small_step(archive, car, speed):
    """Increments of yaw a sample per steering of a packed vehicle, as `pid_law.small_step` has them of the car."""
    wheelbase = car.published.a + car.published.b
    size = min(
        0.5 * wheelbase / speed**2,
        0.9 * vehicle.SERVO_RATE_LIMIT_RADPS * vehicle.SERVO_TIME_CONSTANT_S,
    )
    unit = Unit(archive, "NonlinearVehicle")
    unit.set(speed=speed)
    unit.initialize()
    unit.set(steering_angle=size)
    yaw = []
    for k in range(round(4.0 / SAMPLE_TIME_S)):
        yaw.append(unit.get("yaw")[0])
        unit.step(k * SAMPLE_TIME_S, SAMPLE_TIME_S)
    unit.close()
    return np.diff(yaw) / size


def response(increments, omega):
    """From steering to yaw rate, of the increments of yaw after a step."""
    impulse = np.diff(increments, prepend=0.0)
    powers = np.exp(-1j * np.outer(omega, SAMPLE_TIME_S * (1.0 + np.arange(len(impulse)))))
    return (powers @ impulse) / SAMPLE_TIME_S


def compare(program, car, folder):
    logs = [folder / f"{name}.csv" for name in ("first", "second")]
    found = {}
    for seed, log in enumerate(logs):
        found[log.stem], _ = record(car, log, seed)
    print(f"{vehicle.NAMES[car.number]}: lateral acceleration to {found['first']:.1f} and {found['second']:.1f} m/s2")
    columns = ("--input-channel", "steering_command_rad", "--steering-ratio", "1")
    for structure, file in (("bicycle", "bicycle.json"), ("single-track", "vehicle.json")):
        out = folder / file
        begun = time.monotonic()
        program.run("identify", *logs, *columns, "--structure", structure, "-o", out, accept=(DONE, NOT_MET))
        seconds = time.monotonic() - begun
        document = json.loads(out.read_text())
        evidence = document["evidence"]
        if structure == "bicycle":
            fits = evidence["estimation_fit"], evidence["validation_fit"]
        else:
            fits = tuple(evidence[part]["yaw_rate"] for part in ("estimation", "validation"))
        print(
            f"  {structure:<13} first drive {fits[0]:.2f} %, second drive {fits[1]:.2f} %, "
            f"{document['quality']['grade']}, {seconds:.1f} s"
        )
    program.package(folder / "fmus", folder / "vehicle.json")
    archive = Archive(folder / "fmus" / "NonlinearVehicle.fmu")
    omega = 2.0 * math.pi * np.geomspace(*BAND_HZ, 60)
    for speed in COMPARED_MPS:
        of_car = response(pid_law.small_step(car, speed), omega)
        of_model = response(small_step(archive, car, speed), omega)
        error = np.abs(of_model - of_car) / np.abs(of_car)
        at = np.argmax(error)
        rms = math.sqrt(np.mean(error**2))
        print(
            f"  at {speed:.0f} m/s from {BAND_HZ[0]} to {BAND_HZ[1]} Hz: error of the response {100 * rms:.1f} % RMS, "
            f"at most {100 * error[at]:.1f} % at {omega[at] / (2 * math.pi):.2f} Hz"
        )
    archive.remove()


def fit_of(archive, log):
    """Fit of the yaw rate, %, of a packed model on a log, without its first seconds."""
    time_s, command, measured, speed = (log[name] for name in ("time_s", *DRIVEN_CHANNELS))
    unit = Unit(archive, "plant")
    unit.set(speed=speed[0])
    unit.initialize()
    simulated = np.empty(len(time_s))
    write, read = unit.writer("steering_angle", "speed"), unit.reader("yaw_rate")
    for k in range(len(time_s)):
        write(command[k], speed[k])
        simulated[k] = read()[0]
        unit.step(k * SAMPLE_TIME_S, SAMPLE_TIME_S)
    unit.close()
    rest = slice(round(WARM_UP_S / SAMPLE_TIME_S), None)
    error, signal = simulated[rest] - measured[rest], measured[rest] - np.mean(measured[rest])
    return 100.0 * (1.0 - math.sqrt(np.mean((error - np.mean(error)) ** 2) / np.mean(signal**2)))


def another_drive(program, car, count, folder):
    """Models of each of some drives, packed, on the drive after it: the default, and each structure alone."""
    logs = [folder / f"{seed}.csv" for seed in range(count)]
    for seed, log in enumerate(logs):
        record(car, log, 100 + seed)
    names = ("time_s", *DRIVEN_CHANNELS)
    tables = []
    for log in logs:
        table = np.genfromtxt(log, delimiter=",", names=True)
        tables.append({name: table[name] for name in names})
    for k, log in enumerate(logs):
        words = []
        for structure in ("auto", "bicycle", "single-track"):
            out, fmus = folder / "model.json", folder / "fmus"
            columns = ("--input-channel", "steering_command_rad", "--steering-ratio", "1")
            program.run("identify", log, *columns, "--structure", structure, "-o", out, "--force", accept=(DONE, NOT_MET))
            program.run("package", out, "--out", fmus, "--force", "--accept-untrusted")
            archive = Archive(next(fmus.glob("*.fmu")))
            fit = fit_of(archive, tables[(k + 1) % count])
            model = archive.description.modelName
            words.append(f"{structure} {fit:.2f} %" + (f" ({model})" if structure == "auto" else ""))
            archive.remove()
            for file in fmus.glob("*"):
                file.unlink()
        print(f"{vehicle.NAMES[car.number]}, drive {k + 1} on the next: {', '.join(words)}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--cars", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--drives", type=int, help="fits on another drive, of so many drives of each car, instead")
    options = parser.parse_args()
    for number in options.cars:
        with tempfile.TemporaryDirectory() as folder:
            if options.drives:
                another_drive(Program(options.program), vehicle.Car(number), options.drives, Path(folder))
                continue
            compare(Program(options.program), vehicle.Car(number), Path(folder))


if __name__ == "__main__":
    main()
