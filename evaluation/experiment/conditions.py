#!/usr/bin/env python3
"""Cars on the road as it is not in the drive that they were identified from, and what other steering laws make of it.

Each of CommonRoad's three multi-body cars is driven from 5 to 30 m/s at up to 4 m/s2; a bicycle is identified from
log and fixes, and a controller is designed for 5 to 30 m/s. It follows the standard road as packed PoseEstimator,
ReferencePath and LateralPid at constant speeds and from 10 to 22 m/s, under each of `CONDITIONS`. The rivals
(rivals.py) have the data sheet of the car, the lag of its servo, and the same estimator. Each is tuned by its grid
on the nominal road: the setting with the least mean error over cars and roads is driven everywhere. All have the
same sensor noise, which is other noise than that of the tuning.

    cargo xtask experiment --conditions                    three cars, about half an hour
    cargo xtask experiment --conditions --short            one car, two roads, fixed settings
    cargo xtask experiment --conditions --seed 7           another drive and other noise
    cargo xtask experiment --conditions --record FILE.md   the tables, with a figure beside them
"""

import argparse
import math
import tempfile
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

import shared  # noqa: F401, finds the test drive's modules
import disturbed
import engagement
import figures
import numpy as np
import over_speed
import rivals
import road
import sensors
import vehicle
from case import CARS
from excitation import SAMPLE_TIME_S
from experiment import estimator_archive
from over_speed import LONGEST_S, ROADS_MPS, SERVO_RADPS, sideslip, speed_at
from program import DONE, NOT_MET, Program, read
from sensors import ANTENNA_M, CORRECTED, DROP_OUT, LATENCY_S, UNCORRECTED
from units import Archive

OWN = "Steerwright"
LAWS = {"LQR": rivals.Lqr, "MPC": rivals.Mpc, "pure pursuit": rivals.PurePursuit, "Stanley": rivals.Stanley}
# Of --short, as the grid chose them.
SHORT_SETTINGS = {
    "LQR": {"weight_m2s2": 0.1},
    "MPC": {"weight_m2s2": 0.1},
    "pure pursuit": {"lookahead_s": 0.15, "least_m": 1.0, "lead_s": 0.15},
    "Stanley": {"gain_per_s": 4.0, "damping_s": 0.05, "preview_s": 0.0},
}
SHORT_ROADS, SHORT_CAR = ((15.0, 15.0), (10.0, 22.0)), 2
TUNING_SEED = 1000
LOST_M = 20.0  # what a lost drive counts in a mean of the tuning


@dataclass(frozen=True)
class Condition:
    """Of car and road; the rest is nominal."""

    name: str
    friction: float = 1.0
    mass: float = 1.0
    servo_radps: float = SERVO_RADPS
    play_deg: float = 0.0  # between the edges, at the road wheel
    bank_deg: float = 0.0  # falling to the left
    wind_mps: tuple = (0.0, 0.0)  # from the right: steady, and in the gusts in addition
    road_mps2: float = 4.0
    allowed_mps2: float = 6.0  # of the design: --max-lateral-acceleration
    age_s: float = LATENCY_S  # of the fixes; LATENCY_S is stated
    reception: sensors.Gnss = CORRECTED


NOMINAL = Condition("nominal")
CONDITIONS = (
    NOMINAL,
    Condition("friction 0.6", friction=0.6),
    Condition("friction 0.4, road at 3 m/s²", friction=0.4, road_mps2=3.0),
    Condition("mass +20 %", mass=1.2),
    Condition("mass −20 %", mass=0.8),
    Condition("crosswind 5 m/s, gusts of 12", wind_mps=(5.0, 7.0)),
    Condition("bank of 3°", bank_deg=3.0),
    Condition("play of 0.5°", play_deg=0.5),
    Condition("fixes 200 ms old, 100 stated", age_s=0.2),
    Condition("no fixes for 2 s", reception=DROP_OUT),
    Condition("uncorrected fixes, 1.5 m", reception=UNCORRECTED),
    Condition("servo 0.25 rad/s", servo_radps=0.25),
    Condition("servo 0.15 rad/s", servo_radps=0.15),
    Condition("road at 6 m/s²", road_mps2=6.0),
    Condition("road at 6 m/s², 8 allowed", road_mps2=6.0, allowed_mps2=8.0),
)
SHORT_CONDITIONS = (NOMINAL, CONDITIONS[1], CONDITIONS[5], CONDITIONS[7])
GUST_EVERY_S, GUST_S, DROP_OUT_FROM_S = 8.0, 3.0, 6.0


def wind(condition, time):
    """At a time, m/s: each gust rises and falls as a raised cosine."""
    steady, gust = condition.wind_mps
    phase = time % GUST_EVERY_S
    return steady + (0.5 * gust * (1.0 - math.cos(math.tau * phase / GUST_S)) if phase < GUST_S else 0.0)


@dataclass(frozen=True)
class Prepared:
    """What was designed on a car's drive: files in a folder, and the controller and road of each condition."""

    number: int
    folder: Path
    estimator: Path

    def design(self, condition):
        return self.folder / f"{condition.allowed_mps2:g}"

    def road(self, condition, last):
        return self.design(condition) / f"{last:g}_{condition.road_mps2:g}"


def prepare(program, folder, roads, conditions, seed, number):
    """Drive, model, controllers, and the roads."""
    folder = folder / f"car{number}"
    folder.mkdir()
    over_speed.record(vehicle.Car(number), folder, seed, LATENCY_S)
    model = folder / "model.json"
    columns = ("--input-channel", "steering_command_rad", "--steering-ratio", "1", "--structure", "bicycle")
    receiver = ("--antenna-x", f"{ANTENNA_M[0]}m", "--gnss-latency", f"{LATENCY_S}s")
    log = (folder / "drive.csv", folder / "fixes.csv")
    program.run("identify", *log, *columns, *receiver, "-o", model, accept=(DONE, NOT_MET))
    made = Prepared(number, folder, estimator_archive(program, folder))
    for condition in conditions:
        pid = made.design(condition) / "pid.json"
        if not pid.exists():
            pid.parent.mkdir()
            limits = ("--max-rate", f"{SERVO_RADPS}rad/s", "--max-lateral-acceleration", f"{condition.allowed_mps2}m/s2")
            program.design(model, pid, *limits, "--speeds", "5..30")
            program.package(pid.parent, pid)
        for last in {last for _, last in roads}:
            out = made.road(condition, last)
            if not out.exists():
                out.mkdir()
                limits = ("--speed", f"{last}m/s", "--lateral-acceleration", f"{condition.road_mps2}m/s2")
                program.run("path", "--pid", pid, "--plant", model, *limits, "-o", out / "path.json")
                program.package(out, out / "path.json")
    return made


class Estimator(road.Estimator):
    """Pose and course, for the rivals."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.read = self.unit.reader("x", "y", "yaw", "course")


class Own:
    """The packed ReferencePath and LateralPid."""

    def __init__(self, path, pid, speed, slip):
        self.steering = road.Steering(path, pid, speed, slip)

    def command(self, k, pose, speed):
        return self.steering.command(k, pose, speed)

    def close(self):
        self.steering.close()


@lru_cache
def sheet(number):
    return rivals.Sheet(number)


def follow(made, condition, speeds, who, setting, seed):
    """Cross-track errors at the samples, m, with a road driven from one speed to another; whether it arrives."""
    folder = made.road(condition, speeds[1])
    way = read(folder / "path.json")
    length, slip = way["points"][-1][0], sideslip(way)
    speed_of = partial(speed_at, *speeds, length)
    car = vehicle.Car(made.number, condition.friction, condition.mass)
    files = (made.estimator, folder / "ReferencePath.fmu", made.design(condition) / "LateralPid.fmu")
    archives = [Archive(file) for file in files]
    count = round((LONGEST_S + road.LEAD_IN_S) / SAMPLE_TIME_S) + 1
    lost_from = road.LEAD_IN_S + DROP_OUT_FROM_S
    reader = sensors.Sensors(condition.reception, [made.number, seed, 5], lost_from, count, condition.age_s)

    before = road.lead_in(car, speed_of(0.0))
    kind = road.Estimator if who == OWN else Estimator
    estimator = kind(archives[0], reader, before[0], slip, LATENCY_S)
    gyro = []
    for k in range(road.LEAD_IN):
        reading = reader.read(k, before[k])
        gyro.append(reading.gyro)
        estimator.pose(k, reading, before[k])
    state, at_rest = before[road.LEAD_IN].copy(), float(np.mean(gyro))
    if who == OWN:
        steering = Own(archives[1], archives[2], speed_of(0.0), slip)
    else:
        steering = LAWS[who](sheet(made.number), rivals.Road(way["points"]), **setting)

    truth = road.guide(archives[1], "truth", speed_of(0.0), slip)
    evaluate, errors, distance, arrived = road.Evaluation(truth, speed_of(0.0)), [], 0.0, False
    servo, play = state[vehicle.STEER], math.radians(condition.play_deg)
    bank = disturbed.GRAVITY_MPS2 * math.sin(math.radians(condition.bank_deg))
    for k in range(round(LONGEST_S / SAMPLE_TIME_S)):
        speed = evaluate.speed = speed_of(distance)
        reading = reader.read(road.LEAD_IN + k, state)
        pose = estimator.pose(road.LEAD_IN + k, reading, state)
        if who != OWN:
            pose = (*pose, reading.gyro - at_rest)
        command = steering.command(k, pose, reading.speed)
        error, _, _, distance = evaluate(k, state)
        errors.append(error)
        arrived = distance >= length - road.END_M
        if arrived or abs(error) > road.OFF_ROAD_M or not math.isfinite(command):
            break
        blowing = wind(condition, k * SAMPLE_TIME_S)
        pushed = (condition.servo_radps, play, bank, blowing)
        servo, known = disturbed.advance(state, servo, command, speed, car.parameters, vehicle.STEPS, *pushed)
        if not known:
            break
    for part in (estimator, steering, truth):
        part.close()
    for archive in archives:
        archive.remove()
    return np.array(errors), arrived


def drive(seed, task):
    """RMS and largest error of a drive, m; infinite where it is lost."""
    made, condition, speeds, who, setting = task
    errors, arrived = follow(made, condition, speeds, who, setting, seed)
    if not arrived:
        return math.inf, math.inf
    return math.sqrt(np.mean(errors**2)), float(np.max(np.abs(errors)))


def tuned(cars, roads):
    """The setting of each rival: the best of its grid on the nominal road, and what it reached."""
    found = {}
    for who, law in LAWS.items():
        if who == "MPC":
            found[who] = found["LQR"]
            continue
        every = rivals.settings(law)
        tasks = [(made, NOMINAL, speeds, who, setting) for setting in every for made in cars for speeds in roads]
        rms = [min(row[0], LOST_M) for row in engagement.in_parallel(partial(drive, TUNING_SEED), tasks)]
        means = np.array(rms).reshape(len(every), -1).mean(axis=1)
        best = int(np.argmin(means))
        found[who] = every[best]
        print(f"{who}: {len(every)} settings, best mean RMS {means[best]:.4f} m by {every[best]}", flush=True)
    return found


def name_of(speeds):
    first, last = speeds
    return f"{first:g} m/s" if first == last else f"{first:g} to {last:g} m/s"


def table(header, rows):
    lines = ["| " + " | ".join(row) + " |" for row in [header, ["---"] * len(header), *rows]]
    return "\n".join(lines)


def cell(scores):
    """Mean RMS and largest error of the drives that arrive, and how many do not."""
    arrived = [score for score in scores if math.isfinite(score[0])]
    lost = len(scores) - len(arrived)
    if not arrived:
        return f"{lost} lost"
    text = f"{np.mean([rms for rms, _ in arrived]):.3f} / {max(largest for _, largest in arrived):.2f}"
    return text + (f", {lost} lost" if lost else "")


def mean(scores):
    return float(np.mean([min(rms, LOST_M) for rms, _ in scores]))


def markdown(settings, conditions, roads, cars, seed, found):
    """Tables of the scores: `found[condition, speeds, who]` has those of the cars."""
    everyone = [OWN, *LAWS]
    speeds = ", ".join(map(name_of, roads))
    parts = [
        "# Roads and cars that the design did not see",
        f"Cars {', '.join(map(str, cars))} of CommonRoad, seed {seed}, the standard road at {speeds}. Mean of the RMS errors over "
        "cars and roads / largest error of all, m; a drive is lost that leaves the road by 20 m or stops short.",
        "The rivals have the data sheet and the same estimator. "
        + "; ".join(f"{who}: {', '.join(f'{k} {v:g}' for k, v in setting.items())}" for who, setting in settings.items()) + ".",
        "## By condition",
    ]
    rows, better = [], []
    for condition in conditions:
        scores = {who: [s for v in roads for s in found[condition, v, who]] for who in everyone}
        rows.append([condition.name, *(cell(scores[who]) for who in everyone)])
        best = min(LAWS, key=lambda who: mean(scores[who]))
        ratio = mean(scores[best]) / mean(scores[OWN])
        if ratio < 1.0:
            better.append(f"{condition.name}: {best}, {ratio:.2f} of the error of {OWN}")
    drives = len(conditions) * len(roads) * len(cars)
    gone = {who: sum(not math.isfinite(rms) for (_, _, by), s in found.items() for rms, _ in s if by == who) for who in everyone}
    rows.append([f"lost of {drives} drives", *(str(gone[who]) for who in everyone)])
    parts.append(table(["condition", *everyone], rows))
    parts.append("## Where a rival is better")
    parts.append("\n".join(f"- {line}." for line in better) if better else "Nowhere in the means above.")
    parts.append("## Nominal, by road")
    rows = [[name_of(v), *(cell(found[NOMINAL, v, who]) for who in everyone)] for v in roads]
    parts.append(table(["road", *everyone], rows))
    return "\n\n".join(parts) + "\n"


def draw(conditions, roads, found, file):
    """Mean RMS error by condition and contender."""
    figure, axis = figures.plt.subplots(figsize=(8.0, 0.55 * len(conditions) + 1.2), layout="constrained")
    everyone, height = [OWN, *LAWS], 0.8 / (1 + len(LAWS))
    for i, who in enumerate(everyone):
        means = [mean([s for v in roads for s in found[condition, v, who]]) for condition in conditions]
        places = np.arange(len(conditions)) + i * height
        axis.barh(places, means, height, label=who, color=("#0072b2", "#e69f00", "#000000", "#009e73", "#cc79a7")[i])
    axis.set_yticks(np.arange(len(conditions)) + 0.4 - height / 2, [condition.name for condition in conditions])
    axis.invert_yaxis()
    axis.set(xscale="log", xlabel="mean of the RMS cross-track errors, m (lost: 20 m)")
    axis.grid(axis="x", lw=0.3)
    axis.legend(fontsize=7)
    figures.save(figure, file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=600, help="of the drives and of the noise (default: %(default)s)")
    parser.add_argument("--short", action="store_true", help="one car, two roads, four conditions, settings as recorded")
    parser.add_argument("--record", type=Path, help="Markdown file of the tables; its figure has its name")
    options = parser.parse_args()
    roads = SHORT_ROADS if options.short else ROADS_MPS
    conditions = SHORT_CONDITIONS if options.short else CONDITIONS
    numbers = (SHORT_CAR,) if options.short else CARS
    program, found = Program(options.program), {}
    with tempfile.TemporaryDirectory() as name:
        work = partial(prepare, program, Path(name), roads, conditions, options.seed)
        cars = list(engagement.in_parallel(work, numbers))
        settings = SHORT_SETTINGS if options.short else tuned(cars, roads)
        contenders = {OWN: {}} | settings
        tasks = [(made, c, v, who, s) for c in conditions for v in roads for who, s in contenders.items() for made in cars]
        for task, score in zip(tasks, engagement.in_parallel(partial(drive, options.seed), tasks)):
            _, condition, speeds, who, _ = task
            found.setdefault((condition, speeds, who), []).append(score)
    text = markdown(settings, conditions, roads, numbers, options.seed, found)
    print(text)
    if options.record:
        file = options.record.with_suffix(".svg")
        draw(conditions, roads, found, file)
        heading, shown = "## By condition\n\n", f"![Mean of the RMS errors by condition]({file.name})\n\n"
        options.record.write_text(text.replace(heading, heading + shown))
    lost = [f"{c.name}, {name_of(v)}" for (c, v, who), s in found.items() if who == OWN and not all(np.isfinite(s).flat)]
    if options.short and lost:
        raise SystemExit(f"lost: {'; '.join(lost)}")


if __name__ == "__main__":
    main()
