#!/usr/bin/env python3
"""Whether a controller keeps on the car what its design promises: from fast and slow logs, and from a measured angle.

Each of CommonRoad's three multi-body cars drives once. Of its log every row, every fifth or every tenth is kept, with
the command of the steering servo or with the measured angle. State space and bicycle are identified, a controller is
designed, and the car steps its yaw by 5 degrees. A command of a slow log was set at 100 Hz, or was held between the
rows (`held`). The measured angle does not show the servo, which is then stated to the design, or is not.

A design whose grade is `pass` keeps its promise with at most 2 % of overshoot and 1.1 s to settle, as the
specification's 1 % and 1 s with a margin. It fails where one of them does not.

    cargo xtask experiment --promises                          at 15 m/s
    cargo xtask experiment --promises --speed 12 --seed 7      elsewhere
"""

import argparse
import math
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import shared  # noqa: F401, finds the test drive's modules
import engagement
import yaw_step
from case import CARS, Case
from contenders import DESIGN
from excitation import SAMPLE_TIME_S
from program import DONE, NOT_MET, Program, read
from units import Archive

COMMAND, HELD, ANGLE, STATED = "command", "held", "angle", "angle, servo stated"
COLUMNS = {COMMAND: "steering_command_rad", HELD: "steering_command_rad"}
EVERY = (1, 5, 10)  # rows of 10 ms
STRUCTURES = ("state-space", "bicycle")
LARGEST = {"overshoot_percent": 2.0, "settling_time_s": 1.1}


@dataclass(frozen=True)
class Log:
    steering: str
    every: int

    @property
    def name(self):
        return f"{self.steering}, {1.0 / (SAMPLE_TIME_S * self.every):.0f} Hz"

    def write(self, case, seed, file):
        case.record(file, seed, held=self.every if self.steering == HELD else 1)
        header, *rows = file.read_text().splitlines()
        file.write_text("\n".join([header, *rows[:: self.every]]) + "\n", newline="\n")


def logs():
    fast = [Log(steering, every) for every in EVERY for steering in (COMMAND, ANGLE, STATED)]
    return fast + [Log(HELD, every) for every in EVERY[1:]]


def promise(program, options, task):
    """A line of figures, whether the grade is `pass`, and whether the promise is kept."""
    number, log, structure = task
    case = Case(number, options.speed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        log.write(case, options.seed, folder / "drive.csv")
        model, pid = folder / "model.json", folder / "pid.json"
        columns = ("--input-channel", COLUMNS.get(log.steering, "steering_angle_rad"), "--steering-ratio", "1")
        identified = program.run(
            "identify", folder / "drive.csv", *columns, "--structure", structure, "-o", model, accept=(DONE, NOT_MET)
        )
        servo = ("--actuator-lag", f"{case.lag}s") if log.steering == STATED else ()
        line = f"car {number}, {log.name:<28} {structure:<12}"
        if not model.exists():
            return f"{line} no model: {identified.stderr.splitlines()[0]}", False, False
        designed = program.run("design", model, "-o", pid, *DESIGN, *servo, accept=(DONE, NOT_MET))
        if not pid.exists():
            return f"{line} no controller: {designed.stderr.splitlines()[0]}", False, False
        found = read(pid)
        program.package(folder, pid)
        archive = Archive(folder / "LateralPid.fmu")
        response = yaw_step.respond(case.car, case.speed, archive, case.car.at_start(case.speed))
        archive.remove()
    reached = yaw_step.metrics(*response).as_dict()
    grade, promised = found["designed_for"]["quality"]["grade"], found["evidence"]["step"]
    figures = [[math.nan if of[key] is None else of[key] for key in LARGEST] for of in (promised, reached)]
    kept = all(reached[key] is not None and reached[key] <= most for key, most in LARGEST.items())
    (promised_overshoot, promised_settling), (overshoot, settling) = figures
    line += f" {grade:<4}  promised {promised_overshoot:.2f} % {promised_settling:.2f} s"
    line += f"  reached {overshoot:5.2f} % {settling:.2f} s"
    return line + ("" if kept else "  not kept"), grade == "pass", kept


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--speed", type=float, default=15.0, help="m/s")
    parser.add_argument("--seed", type=int, default=1, help="of the drives")
    options = parser.parse_args()
    tasks = [(car, log, structure) for log in logs() for structure in STRUCTURES for car in CARS]
    work = partial(promise, Program(options.program), options)
    counts, wrong = {}, []
    for (_, log, _), (line, passes, kept) in zip(tasks, engagement.in_parallel(work, tasks)):
        print(line, flush=True)
        rows, passed, broken = counts.get(log.name, (0, 0, 0))
        counts[log.name] = rows + 1, passed + passes, broken + (passes and not kept)
        if passes and not kept:
            wrong.append(line)
    for name, (rows, passed, broken) in counts.items():
        print(f"{name:<28} {passed} of {rows} pass, {broken} of them not kept")
    raise SystemExit(1 if wrong else 0)


if __name__ == "__main__":
    main()
