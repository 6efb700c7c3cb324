#!/usr/bin/env python3
"""Cars driven over a range of speeds by one design, on a model of a drive over that range with a receiver's fixes.

Each of CommonRoad's three multi-body cars is driven from 5 to 30 m/s at up to 4 m/s2. A model of a structure is
identified from log and fixes, a controller is designed for 5 to 30 m/s, and the car follows the standard road by
PoseEstimator, ReferencePath and LateralPid as packed FMUs, with corrected GNSS: at constant speeds, and from 10 to
22 m/s. Every road is driven twice: with the sideslip of the file, and with its correction on the road.

    cargo xtask experiment --over-speed                    three cars
    cargo xtask experiment --over-speed --drives 20        other seeds, too
    cargo xtask experiment --over-speed --friction 0.6     the road's, not that of the drive
    cargo xtask experiment --over-speed --age 0.2 --age-error -0.1    fixes are 0.2 s old, 0.1 s is stated
"""

import argparse
import math
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import shared  # noqa: F401, finds the test drive's modules
import engagement
import numpy as np
import road
import sensors
import vehicle
import whole_drive
from case import CARS
from drive_log import noisy, write_table
from excitation import SAMPLE_TIME_S
from experiment import estimator_archive
from program import DONE, NOT_MET, Program, read
from sensors import ANTENNA_M, CORRECTED, FIX_EVERY, LATENCY_S
from units import Archive

# Speed at the start of a road and at its end, m/s.
ROADS_MPS = ((6.5, 6.5), (13.0, 13.0), (20.0, 20.0), (27.0, 27.0), (10.0, 22.0))
ROAD_ACCELERATION_MPS2 = 4.0
SERVO_RADPS = 0.4
LONGEST_S = 200.0
# Of the drive that is identified.
DRIVEN = {"LARGEST_LATERAL_MPS2": 4.0, "LARGEST_ACCELERATION_MPS2": 1.5, "DURATION_S": 240.0}


def record(car, folder, seed, age_s):
    """A drive and the fixes of its receiver."""
    for name, value in DRIVEN.items():
        setattr(whole_drive, name, value)
    _, states = whole_drive.record(car, folder / "drive.csv", seed)
    at = states[::FIX_EVERY]
    stated = SAMPLE_TIME_S * FIX_EVERY * np.arange(len(at)) + age_s
    rng = np.random.default_rng([car.number, seed, 77])
    places = sensors.antenna(at[:, vehicle.X], at[:, vehicle.Y], at[:, vehicle.YAW])
    fixes = [noisy(rng, values, CORRECTED.deviation_m) for values in places]
    write_table(folder / "fixes.csv", "time_s,x_m,y_m", (2, 4, 4), [stated, *fixes])


def sideslip(way):
    """That of a path, by the parameters of the FMUs."""
    stated = way["guidance"]
    names = {
        "sideslip_per_yaw_rate": "sideslip_per_yaw_rate_s",
        "sideslip_growth": "sideslip_growth_s5pm2",
        "sideslip_per_yaw_acceleration": "sideslip_per_yaw_acceleration_s2",
        "distance_rear": "distance_rear_m",
    }
    found = {name: stated.get(key, 0.0) for name, key in names.items()}
    return found | {"sideslip_reference_speed": way["speed_mps"]}


def follow(car, speeds, loop, reader, slip, length, latency_s):
    """Cross-track errors at the samples, m, of a car with a speed for each distance, and whether it arrives."""
    before = road.lead_in(car, speeds(0.0))
    estimator = road.Estimator(loop.estimator, reader, before[0], slip, latency_s)
    for k in range(road.LEAD_IN):
        estimator.pose(k, reader.read(k, before[k]), before[k])
    state = before[road.LEAD_IN].copy()
    steering = road.Steering(loop.path, loop.pid, speeds(0.0), slip)
    truth = road.guide(loop.path, "truth", speeds(0.0), slip)
    evaluate, errors, distance, arrived = road.Evaluation(truth, speeds(0.0)), [], 0.0, False
    for k in range(round(LONGEST_S / SAMPLE_TIME_S)):
        evaluate.speed = speeds(distance)
        reading = reader.read(road.LEAD_IN + k, state)
        pose = estimator.pose(road.LEAD_IN + k, reading, state)
        command = steering.command(k, pose, reading.speed)
        error, _, _, distance = evaluate(k, state)
        errors.append(error)
        arrived = distance >= length - road.END_M
        if arrived or abs(error) > road.OFF_ROAD_M or not math.isfinite(command):
            break
        if not vehicle.advance(state, command, evaluate.speed, car.parameters, vehicle.STEPS, SERVO_RADPS):
            break
    for part in (estimator, steering, truth):
        part.close()
    return np.array(errors), arrived


def speed_at(first, last, length, distance):
    """Speed at a distance of a road that is driven from one speed to another, m/s."""
    return first + (last - first) * min(max(distance / length, 0.0), 1.0)


@dataclass(frozen=True)
class Conditions:
    """Of the drives."""

    structure: str
    age_s: float  # of the fixes
    stated_age_s: float | None  # None: it is identified
    friction: float  # of the road, as a share of that of the drive


def drive(program, conditions, task):
    """The row of a car and a seed: RMS and largest errors of each road, without and with correction; none where no
    controller is designed on the model."""
    number, seed = task
    car, found, stated_s = vehicle.Car(number, conditions.friction), [], conditions.stated_age_s
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        record(vehicle.Car(number), folder, seed, conditions.age_s)
        receiver = ("--antenna-x", f"{ANTENNA_M[0]}m", *(() if stated_s is None else ("--gnss-latency", f"{stated_s}s")))
        model, pid = folder / "model.json", folder / "pid.json"
        columns = ("--input-channel", "steering_command_rad", "--steering-ratio", "1")
        log = (folder / "drive.csv", folder / "fixes.csv")
        program.run(
            "identify", *log, *columns, *receiver, "--structure", conditions.structure, "-o", model, accept=(DONE, NOT_MET)
        )
        # Without a sideslip the age that was stated counts.
        latency_s = read(model).get("sideslip", {}).get("gnss_latency_s", stated_s or 0.0)
        limits = ("--max-rate", f"{SERVO_RADPS}rad/s", "--speeds", "5..30")
        program.run("design", model, "-o", pid, *limits, accept=(DONE, NOT_MET))
        if not pid.exists():
            return task, []
        estimator = estimator_archive(program, folder)
        program.package(folder, pid)
        for first, last in ROADS_MPS:
            name = f"{first:g} m/s" if first == last else f"{first:g} to {last:g} m/s"
            limits = ("--speed", f"{last}m/s", "--lateral-acceleration", f"{ROAD_ACCELERATION_MPS2}m/s2")
            program.run("path", "--pid", pid, "--plant", model, *limits, "-o", folder / "path.json", "--force")
            way = read(folder / "path.json")
            length = way["points"][-1][0]
            speeds = partial(speed_at, first, last, length)
            program.package(folder, folder / "path.json")
            for corrected in (False, True):
                slip = sideslip(way) | ({} if corrected else {"sideslip_correction_time": 0.0})
                archives = [Archive(folder / f"{unit}.fmu") for unit in ("ReferencePath", "LateralPid")]
                loop = road.Loop(Archive(estimator), *archives)
                count = round((LONGEST_S + road.LEAD_IN_S) / SAMPLE_TIME_S) + 1
                reader = sensors.Sensors(CORRECTED, [number, seed, 5], 0.0, count, conditions.age_s)
                errors, arrived = follow(car, speeds, loop, reader, slip, length, latency_s)
                for archive in (loop.estimator, *archives):
                    archive.remove()
                rms, largest = math.sqrt(np.mean(errors**2)), float(np.max(np.abs(errors)))
                found.append((name, corrected, rms if arrived else math.inf, largest))
    return task, found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--drives", type=int, default=len(CARS))
    parser.add_argument("--seed", type=int, default=500, help="of the first drive")
    parser.add_argument("--structure", default="bicycle")
    parser.add_argument("--unstated-age", action="store_true", help="the age of the fixes is that which was identified")
    parser.add_argument("--age", type=float, default=LATENCY_S, help="of the fixes, s (default: %(default)s)")
    parser.add_argument("--age-error", type=float, default=0.0, help="of the fixes: stated less true, s")
    parser.add_argument("--friction", type=float, default=1.0, help="of the road, as a share of that of the drive")
    options = parser.parse_args()
    tasks = [(CARS[i % len(CARS)], options.seed + i) for i in range(options.drives)]
    print("cross-track error, RMS and largest, m: with the sideslip of the file, with its correction on the road")
    all_found = []
    stated_age_s = None if options.unstated_age else round(options.age + options.age_error, 6)
    conditions = Conditions(options.structure, options.age, stated_age_s, options.friction)
    work = partial(drive, Program(options.program), conditions)
    refused = 0
    for (number, seed), found in engagement.in_parallel(work, tasks):
        if not found:
            refused += 1
            print(f"car {number} seed {seed}  no controller is designed on the model", flush=True)
            continue
        texts = []
        for (name, _, *file), (*_, rms, largest) in zip(found[::2], found[1::2]):
            texts.append(f"{name}: {file[0]:.3f} {file[1]:.2f}, {rms:.3f} {largest:.2f}")
        print(f"car {number} seed {seed}  " + "; ".join(texts), flush=True)
        all_found += found
    for name in dict.fromkeys(row[0] for row in all_found):
        means = []
        for corrected in (False, True):
            rows = [row for row in all_found if row[:2] == (name, corrected)]
            worst = max(row[3] for row in rows)
            means.append(f"{np.mean([row[2] for row in rows]):.3f}, each at most {max(r[2] for r in rows):.3f}, largest {worst:.2f}")
        print(f"{name:<16} mean RMS {means[0]}; corrected {means[1]}")
    lost = sum(not math.isfinite(row[2]) for row in all_found)
    print(f"{lost} of {len(all_found)} lost; no controller after {refused} of {len(tasks)} drives")
    raise SystemExit(1 if lost else 0)


if __name__ == "__main__":
    main()
