#!/usr/bin/env python3
"""Whole roads with their speed profiles: from standstill to 30 m/s and back to standstill, steered and driven at once.

Each of CommonRoad's three multi-body cars is driven twice. Of the first drive, at 5 to 30 m/s and up to 4 m/s2, a
bicycle is identified and a steering controller is designed for 5 to 30 m/s; of the second, straight with an
acceleration command behind an actuator with a delay and a lag, the longitudinal model and a speed controller. `path
--profile` computes the speed along roads that a seed draws. PoseEstimator, ReferencePath, LateralPid and SpeedController as
packed FMUs hold the car for 10 s by a speed reference of 0, and then drive it along each road, with corrected GNSS, a gyro with
a bias and a noisy speed.

The rivals follow the same profile with the same estimator and know the data sheet and the actuators. Their speed loops
compare with the profile at the car, and add its acceleration as it is where the actuator will have followed:

* LQR with preview (rivals.py) and a PI speed loop by SIMC (Skogestad 2003) on an integrator with the delay
  θ = delay + lag/2 + half a sample: kp = 1/(2θ), ki = kp/(8θ).
* Pure pursuit (rivals.py) and a P speed loop, kp = 1/(2θ).

    cargo xtask experiment --whole-road                    30 drives of each, about 20 minutes
    cargo xtask experiment --whole-road --short            one drive of each
    cargo xtask experiment --whole-road --own              without the rivals, and with the true pose and speed, too
    cargo xtask experiment --whole-road --seed 7           other roads, drives and noise
    cargo xtask experiment --whole-road --record FILE.md   the tables, with a figure beside them
"""

import argparse
import math
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import shared  # noqa: F401, finds the test drive's modules
import conditions
import engagement
import figures
import longitudinal
import moving
import numpy as np
import over_speed
import rivals
import road
import sensors
import vehicle
from case import CARS
from drive_log import noisy, write_table
from excitation import SAMPLE_TIME_S
from experiment import estimator_archive
from over_speed import SERVO_RADPS, sideslip
from program import DONE, NOT_MET, Program, read
from sensors import ANTENNA_M, CORRECTED, LATENCY_S
from units import Archive, Unit

OWN, TRUE = "Steerwright", "Steerwright, true pose and speed"
LQR, PURSUIT = "LQR with preview, PI", "pure pursuit, P"
EVERYONE = (OWN, LQR, PURSUIT)
ROADS, NOISES = 5, 2
FASTEST_MPS, LATERAL_MPS2 = 30.0, 4.0
AT_REST_S = 10.0  # before the start, held by a speed reference of 0
LONGEST_S = 300.0
STANDS_MPS, STANDS_S = 0.01, 1.0
OFF_PATH_M, SHORT_OF_END_M = 0.5, 2.0
JERK_OVER = round(0.1 / SAMPLE_TIME_S)
LARGEST_MPS2 = (-3.5, 2.0)  # of the rivals' commands, as of the profile
# Required of Steerwright.
SPEED_RMS_MPS = 0.3


def turn(radius, degrees):
    """A bend to the left of a positive radius, m, with clothoids that are as long as 1.5 s at its speed."""
    curvature = 1.0 / radius
    ramp = 1.5 * min(math.sqrt(LATERAL_MPS2 * abs(radius)), FASTEST_MPS)
    hold = max(math.radians(degrees) * abs(radius) - ramp, 1.0)
    return [(ramp, 0.0, curvature), (hold, curvature, curvature), (ramp, curvature, 0.0)]


def drawn_road(rng):
    """Segments of a road: length, and curvature at begin and end. Bends, a straight to the largest speed, two
    sweeping bends that are driven at it, and bends again."""

    def bends(count):
        found = []
        for _ in range(count):
            radius = math.exp(rng.uniform(math.log(12.0), math.log(80.0))) * rng.choice((-1.0, 1.0))
            found += [*turn(radius, rng.uniform(30.0, 100.0)), (rng.uniform(10.0, 80.0), 0.0, 0.0)]
        return found

    side, sweeps = rng.choice((-1.0, 1.0)), []
    for sign in (side, -side):
        sweeps += turn(sign * rng.uniform(230.0, 350.0), rng.uniform(20.0, 40.0))
    straights = [(rng.uniform(*bounds), 0.0, 0.0) for bounds in ((20.0, 60.0), (300.0, 350.0), (50.0, 150.0), (20.0, 60.0))]
    return [straights[0], *bends(3), straights[1], *sweeps, straights[2], *bends(2), straights[3]]


def write_road(file, name, segments):
    lines = [f'name = "{name}"']
    for length, begin, end in segments:
        lines += ["[[segments]]", f"length_m = {length:.2f}"]
        lines += [f"curvature_per_m = {begin:.6f}", f"end_curvature_per_m = {end:.6f}"]
    file.write_text("\n".join(lines) + "\n")


def record_longitudinal(car, file, seed):
    """A straight drive with an acceleration command, at 50 Hz."""
    rng, every = np.random.default_rng([car.number, seed, 3]), round(0.02 / longitudinal.STEP_S)
    wanted = longitudinal.profile(rng)
    unrest = 0.1 * rng.standard_normal(len(wanted) // every)
    delay = round(moving.ACTUATOR_DELAY_S / longitudinal.STEP_S)
    driven = (True, every, delay, moving.ACTUATOR_LAG_S, car.parameters)
    commands, speeds = longitudinal.drive(car.at_start(12.0), wanted, unrest, *driven)
    times = every * longitudinal.STEP_S * np.arange(len(speeds))
    columns = [times, commands, noisy(rng, speeds, longitudinal.SPEED_NOISE_MPS)]
    write_table(file, "time_s,acceleration_command_mps2,speed_mps", (3, 5, 4), columns)


@dataclass(frozen=True)
class Prepared:
    """What was designed for a car: files in a folder."""

    number: int
    folder: Path
    estimator: Path

    def road(self, place):
        return self.folder / f"road{place}"


def prepare(program, folder, roads, seed, number):
    """Drives, models, controllers, and the roads with their profiles, packed."""
    car, folder = vehicle.Car(number), folder / f"car{number}"
    folder.mkdir()
    over_speed.record(car, folder, seed, LATENCY_S)
    model, pid = folder / "model.json", folder / "pid.json"
    columns = ("--input-channel", "steering_command_rad", "--steering-ratio", "1", "--structure", "bicycle")
    receiver = ("--antenna-x", f"{ANTENNA_M[0]}m", "--gnss-latency", f"{LATENCY_S}s")
    log = (folder / "drive.csv", folder / "fixes.csv")
    program.run("identify", *log, *columns, *receiver, "-o", model, accept=(DONE, NOT_MET))
    program.design(model, pid, "--max-rate", f"{SERVO_RADPS}rad/s", "--speeds", "5..30")

    straight, response, speed = (folder / name for name in ("straight.csv", "longitudinal.json", "speed_controller.json"))
    record_longitudinal(car, straight, seed)
    program.run("identify", straight, "--structure", "longitudinal", "-o", response, accept=(DONE, NOT_MET))
    program.design(response, speed)
    program.package(folder, pid, speed)
    made = Prepared(number, folder, estimator_archive(program, folder))
    for place, segments in enumerate(roads):
        out = made.road(place)
        out.mkdir()
        write_road(out / "road.toml", f"road {place + 1}", segments)
        limits = ("--speed", f"{FASTEST_MPS}m/s", "--max-lateral-acceleration", f"{LATERAL_MPS2}m/s2")
        given = ("--pid", pid, "--plant", model, "--speed-controller", speed)
        program.run("path", out / "road.toml", *given, "--profile", *limits, "-o", out / "path.json")
        program.package(out, out / "path.json")
    return made


class SpeedLoop:
    """A P or PI controller of the speed with the acceleration of the profile, which holds the car at standstill."""

    def __init__(self, with_integral):
        delay = moving.ACTUATOR_DELAY_S + 0.5 * moving.ACTUATOR_LAG_S + 0.5 * SAMPLE_TIME_S
        self.kp = 1.0 / (2.0 * delay)
        self.ki = self.kp / (8.0 * delay) if with_integral else 0.0
        self.integral = 0.0

    def command(self, _k, reference, acceleration, speed):
        if reference < 0.15 and acceleration <= 0.0 and speed < 0.3:
            return -2.0
        error = reference - speed
        wanted = acceleration + self.kp * error + self.integral
        low, high = LARGEST_MPS2
        if low < wanted < high or wanted * error < 0.0:
            self.integral += self.ki * SAMPLE_TIME_S * error
        return max(low, min(high, wanted))

    def close(self):
        pass


class SpeedUnit:
    """The packed SpeedController."""

    def __init__(self, archive):
        self.unit = Unit(archive, "speed")
        self.unit.initialize()
        self.refer = self.unit.writer("speed_reference", "acceleration_reference", "speed")
        self.ask = self.unit.reader("acceleration_command")

    def command(self, k, *values):
        self.refer(*values)
        road.tick(self.unit, k)
        return self.ask()[0]

    def close(self):
        self.unit.close()


class Guide:
    """A ReferencePath: the references of the speed at a pose."""

    def __init__(self, archive, name, slip):
        self.unit = road.guide(archive, name, 0.0, slip)
        self.locate = self.unit.writer("x", "y", "yaw", "speed")
        self.read = self.unit.reader("speed_reference", "acceleration_reference", "cross_track_error", "distance")

    def __call__(self, k, pose, speed):
        self.locate(*pose[:3], speed)
        road.tick(self.unit, k)
        return self.read()

    def close(self):
        self.unit.close()


def preview(time):
    """Parameters of a ReferencePath that reads its profile that much later, s."""
    return {"speed_preview_time": time, "brake_preview_time": time}


class Car(moving.Moving):
    """What its sensors read: wheels that stand turn no speed sensor."""

    def measure(self, reader, k):
        reading = reader.read(k, self.state)
        reading.speed = max(reading.speed, 0.0) if self.state[vehicle.SPEED] > 0.0 else 0.0
        return reading


def follow(made, place, who, seed):
    """Rows of time, distance, true speed, its reference there, cross-track error, lateral acceleration; one a sample from
    the start until the car stands, and whether it stands."""
    folder = made.road(place)
    way = read(folder / "path.json")
    length, slip, is_own = way["points"][-1][0], sideslip(way), who in (OWN, TRUE)
    files = (made.estimator, folder / "ReferencePath.fmu", made.folder / "LateralPid.fmu", made.folder / "SpeedController.fmu")
    archives = [Archive(file) for file in files]
    rest, count = round(AT_REST_S / SAMPLE_TIME_S), round((AT_REST_S + LONGEST_S) / SAMPLE_TIME_S) + 1
    reader = sensors.Sensors(CORRECTED, [made.number, place, seed, 5], 0.0, count)
    car = Car(vehicle.Car(made.number), SERVO_RADPS)
    state = car.state
    if who == TRUE:
        estimator = road.Truth()
    else:
        kind = road.Estimator if is_own else conditions.Estimator
        estimator = kind(archives[0], reader, state, slip, LATENCY_S)
    if is_own:
        steering, speed_loop = road.Steering(archives[1], archives[2], 0.0, slip), SpeedUnit(archives[3])
    else:
        law = LQR_LAW if who == LQR else PURSUIT_LAW
        setting = conditions.SHORT_SETTINGS[law]
        steering = conditions.LAWS[law](conditions.sheet(made.number), rivals.Road(way["points"]), **setting)
        speed_loop = SpeedLoop(who == LQR)
    # The rivals compare with the profile at the car, and take the acceleration from where the actuator has followed.
    lag = moving.ACTUATOR_DELAY_S + moving.ACTUATOR_LAG_S
    guide = Guide(archives[1], "guide", slip if is_own else slip | preview(lag))
    here, truth = (Guide(archives[1], name, slip | preview(0.0)) for name in ("here", "truth"))

    rows, at_rest, stood, stands = [], 0.0, 0.0, False
    for k in range(count - 1):
        reading = car.measure(reader, k)
        if k < rest:
            at_rest += (reading.gyro - at_rest) / (k + 1)
        pose = estimator.pose(k, reading, state)
        speed = state[vehicle.SPEED] if who == TRUE else reading.speed
        reference, wanted, _, _ = guide(k, pose, speed)
        at_car = here(k, pose, speed)[0]
        if not is_own:
            reference = at_car
        if k < rest:
            reference, wanted = 0.0, 0.0
        angle = steering.command(k, pose if is_own else (*pose, reading.gyro - at_rest), speed)
        command = speed_loop.command(k, reference, wanted, speed)
        true_pose = (state[vehicle.X], state[vehicle.Y], state[vehicle.YAW])
        due, _, error, distance = truth(k, true_pose, state[vehicle.SPEED])
        lateral, before = state[vehicle.LATERAL_VELOCITY], state[vehicle.SPEED]
        if not (math.isfinite(angle) and math.isfinite(command) and car.advance(angle, command)):
            break
        if k < rest:
            continue
        turning = (state[vehicle.LATERAL_VELOCITY] - lateral) / SAMPLE_TIME_S + state[vehicle.YAW_RATE] * before
        rows.append(((k - rest) * SAMPLE_TIME_S, distance, before, due, error, turning, angle, command))
        if abs(error) > road.OFF_ROAD_M:
            break
        stood = stood + SAMPLE_TIME_S if before < STANDS_MPS and distance > 0.5 * length else 0.0
        stands = stood >= STANDS_S
        if stands:
            break
    for part in (estimator, steering, speed_loop, guide, here, truth):
        part.close()
    for archive in archives:
        archive.remove()
    return np.array(rows), stands, length


LQR_LAW, PURSUIT_LAW = "LQR", "pure pursuit"


@dataclass(frozen=True)
class Score:
    """Of a drive."""

    speed_rms: float
    speed_largest: float
    rms: float
    largest: float
    before_end: float  # where it stands, m; beyond the end below 0
    back: float  # rolled back, m
    lateral: float
    jerk: float
    stands: bool
    time: float

    @property
    def is_off(self):
        """Off the path, or it does not stand near the end."""
        return not self.stands or self.largest > OFF_PATH_M or abs(self.before_end) > SHORT_OF_END_M


def score(rows, stands, length):
    moving_rows = rows[: -round(STANDS_S / SAMPLE_TIME_S)] if stands else rows
    time, distance, speed, due, error, lateral = moving_rows.T[:6]
    off = speed - due
    acceleration = (rows[JERK_OVER:, 2] - rows[:-JERK_OVER, 2]) / (JERK_OVER * SAMPLE_TIME_S)
    jerk = (acceleration[JERK_OVER:] - acceleration[:-JERK_OVER]) / (JERK_OVER * SAMPLE_TIME_S)
    furthest = np.maximum.accumulate(rows[:, 1])
    return Score(
        speed_rms=math.sqrt(np.mean(off**2)),
        speed_largest=float(np.max(np.abs(off))),
        rms=math.sqrt(np.mean(error**2)),
        largest=float(np.max(np.abs(error))),
        before_end=float(length - rows[-1, 1]),
        back=float(np.max(furthest - rows[:, 1])),
        lateral=float(np.max(np.abs(lateral))),
        jerk=float(np.max(np.abs(jerk))),
        stands=stands,
        time=float(time[-1]),
    )


def drive(task):
    made, place, who, seed = task
    rows, stands, length = follow(made, place, who, seed)
    return rows[::10], score(rows, stands, length)


def table(header, rows):
    lines = ["| " + " | ".join(row) + " |" for row in [header, ["---"] * len(header), *rows]]
    return "\n".join(lines)


def cells(scores):
    """Means of the RMS errors, largest of the others."""
    arrived = [s for s in scores if s.stands]
    if not arrived:
        return ["–"] * 7 + [f"{len(scores)} of {len(scores)}"]
    rms, speed_rms = (np.mean([getattr(s, name) for s in arrived]) for name in ("rms", "speed_rms"))
    worst = max(s.speed_rms for s in arrived)
    ends = [s.before_end for s in arrived]
    return [
        f"{speed_rms:.3f} / {worst:.3f}",
        f"{max(s.speed_largest for s in arrived):.2f}",
        f"{rms:.3f} / {max(s.rms for s in arrived):.3f}",
        f"{max(s.largest for s in arrived):.2f}",
        f"{round(min(ends), 2) + 0.0:.2f} to {max(ends):.2f}",
        f"{max(s.lateral for s in arrived):.1f}",
        f"{max(s.jerk for s in arrived):.1f}",
        f"{sum(s.is_off for s in scores)} of {len(scores)}",
    ]


HEADER = (
    "controllers",
    "speed: RMS, mean / largest, m/s",
    "speed: largest, m/s",
    "lateral: RMS, mean / largest, m",
    "lateral: largest, m",
    "stands before the end, m",
    "lateral acceleration, m/s²",
    "jerk, m/s³",
    "off the path",
)


def markdown(cars, seed, tasks, scores):
    found = {}
    for (made, place, who, _), s in zip(tasks, scores):
        found.setdefault((who, None), []).append(s)
        found.setdefault((who, f"car {made.number}"), []).append(s)
        found.setdefault((who, f"road {place + 1}"), []).append(s)
    drives = len(found[OWN, None])
    own = found[OWN, None]
    parts = [
        "# Whole roads with their speed profiles",
        f"Cars {', '.join(map(str, cars))} of CommonRoad, seed {seed}, {drives} drives of each, from standstill to "
        f"{FASTEST_MPS:g} m/s and back to standstill; profiles within {LATERAL_MPS2:g} m/s² of lateral acceleration, and within "
        "0.9 of acceleration and deceleration and 0.7 of the jerk of the speed controller, 2 m/s², 3.5 m/s² and 2.5 m/s³. Errors are those of "
        "the true car, of the drives that end at a standstill: the speed against the profile at its place, and the distance from "
        "the path. The jerk is that of the speed over 0.1 s. A drive is off the path beyond "
        f"{OFF_PATH_M:g} m from it, or where the car does not stand within {SHORT_OF_END_M:g} m of its end.",
        f"The rivals: LQR with preview, {setting_text(LQR_LAW)}, and a PI speed loop; pure pursuit, {setting_text(PURSUIT_LAW)}, "
        "and a P speed loop; the settings are those of [conditions.md](conditions.md), tuned at 6.5 to 27 m/s. The speed loops follow the rule SIMC on "
        "an integrator with the delay, half the lag and half a sample of the actuator, and add the acceleration of the profile where "
        "the actuator will have followed.",
        table(HEADER, [[who, *cells(found[who, None])] for who in EVERYONE]),
        f"Largest distance that a car of {OWN} rolls back: {max(s.back for s in own):.3f} m. The largest speed errors are those of "
        "the start, where the profile is read 0.1 m ahead of a car that stands.",
    ]
    better = []
    names = (("speed RMS", "speed_rms"), ("lateral RMS", "rms"), ("lateral acceleration", "lateral"), ("jerk", "jerk"))
    for title, name in names:
        for who in (LQR, PURSUIT):
            both = [pair for pair in zip(found[who, None], own) if not (pair[0].is_off or pair[1].is_off)]
            ratio = np.mean([getattr(s, name) for s, _ in both]) / np.mean([getattr(s, name) for _, s in both]) if both else 1.0
            if ratio < 1.0:
                better.append(f"- {title}: {who}, {ratio:.2f} of that of {OWN} in the mean of the drives that neither leaves.")
    parts += ["## Where a rival is better", "\n".join(better) if better else "Nowhere in the means of the drives that neither leaves."]
    lost = {}
    for (made, place, who, _), s in zip(tasks, scores):
        if s.is_off:
            lost.setdefault(who, {}).setdefault(made.number, set()).add(place + 1)
    lines = [
        f"- {who}: " + "; ".join(f"car {n} on road {', '.join(map(str, sorted(places)))}" for n, places in by_car.items()) + "."
        for who, by_car in lost.items()
    ]
    parts += ["## Off the path", "\n".join(lines) if lines else "None."]
    groups = list(dict.fromkeys(group for _, group in found if group))
    rows = [[group, *cells(found[OWN, group])] for group in sorted(groups)]
    parts += [f"## {OWN}, by car and road", table(("drives", *HEADER[1:]), rows)]
    return "\n\n".join(parts) + "\n"


def setting_text(law):
    return ", ".join(f"{key} {value:g}" for key, value in conditions.SHORT_SETTINGS[law].items())


def draw(tasks, traces, file):
    """Speed, its error and the distance from the path of everyone's first drive."""
    figure, axes = figures.plt.subplots(3, 1, figsize=(8.0, 6.0), sharex=True, layout="constrained")
    colours = dict(zip(EVERYONE, ("#0072b2", "#e69f00", "#009e73")))
    first = tasks[0][:2]
    for (made, place, who, seed), rows in zip(tasks, traces):
        if (made, place) != first or seed != tasks[0][3]:
            continue
        _, distance, speed, due, error = rows.T[:5]
        if who == OWN:
            axes[0].plot(distance, due, color="#000000", lw=1.5, ls=":", label="profile")
        axes[0].plot(distance, speed, color=colours[who], lw=0.8, label=who)
        axes[1].plot(distance, speed - due, color=colours[who], lw=0.8)
        axes[2].plot(distance, error, color=colours[who], lw=0.8)
    axes[0].set(ylabel="speed, m/s")
    axes[1].set(ylabel="speed error, m/s", ylim=(-1.5, 1.5))
    axes[2].set(ylabel="distance from the path, m", xlabel="distance along the road, m")
    axes[0].legend(fontsize=7)
    for axis in axes:
        axis.grid(lw=0.3)
    figures.save(figure, file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=700, help="of roads, drives and noise (default: %(default)s)")
    parser.add_argument("--short", action="store_true", help="one car and one road")
    parser.add_argument("--record", type=Path, help="Markdown file of the tables; its figure has its name")
    parser.add_argument("--own", action="store_true", help="without the rivals, and with the true pose and speed, too")
    options = parser.parse_args()
    rng = np.random.default_rng([options.seed, 31])
    roads = [drawn_road(rng) for _ in range(1 if options.short else ROADS)]
    numbers, noises = ((2,), 1) if options.short else (CARS, NOISES)
    program = Program(options.program)
    everyone = (OWN, TRUE) if options.own else EVERYONE
    with tempfile.TemporaryDirectory() as name:
        work = partial(prepare, program, Path(name), roads, options.seed)
        cars = list(engagement.in_parallel(work, numbers))
        tasks = [
            (made, place, who, options.seed + noise)
            for noise in range(noises)
            for place in range(len(roads))
            for made in cars
            for who in everyone
        ]
        traces, scores = [], []
        for (made, place, who, _), (trace, s) in zip(tasks, engagement.in_parallel(drive, tasks)):
            traces.append(trace)
            scores.append(s)
            print(
                f"car {made.number} road {place + 1} {who:33} {s.time:5.1f} s  speed {s.speed_rms:.3f} {s.speed_largest:.2f}  "
                f"lateral {s.rms:.3f} {s.largest:.2f}  end {s.before_end:.2f}  {s.lateral:.1f} m/s2 {s.jerk:.1f} m/s3"
                f"{'  off the path' if s.is_off else ''}",
                flush=True,
            )
    if not options.own:
        text = markdown(numbers, options.seed, tasks, scores)
        print(text)
        if options.record:
            file = options.record.with_suffix(".svg")
            draw(tasks, traces, file)
            shown = f"![Speed and distance from the path of a drive]({file.name})\n\n"
            options.record.write_text(text.replace("## Where a rival", shown + "## Where a rival"))
    own = [s for (_, _, who, _), s in zip(tasks, scores) if who == OWN]
    off, slow = sum(s.is_off for s in own), sum(s.speed_rms > SPEED_RMS_MPS for s in own)
    print(f"{off} of {len(own)} off the path, {slow} beyond {SPEED_RMS_MPS} m/s of speed RMS")
    raise SystemExit(1 if off or slow else 0)


if __name__ == "__main__":
    main()
