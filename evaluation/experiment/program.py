"""The command line under test: each stage as a user runs it."""

import json
import subprocess
from pathlib import Path

# Both loops see what the packed controller does: no step of delay, and the actuator's own rate.
DONE, NOT_MET = 0, 1


class Program:
    def __init__(self, file):
        self.file = Path(file)

    def run(self, *arguments, accept=(DONE,)):
        words = [str(self.file), *map(str, arguments)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode not in accept:
            raise RuntimeError(f"{' '.join(words)}: exit {done.returncode}\n{done.stderr}")
        return done

    def identify(self, log, out, *options):
        columns = ("--input-channel", "steering_command_rad", "--output-channel", "yaw_rate_radps")
        speed = ("--speed-channel", "speed_mps", "--steering-ratio", "1")
        self.run("identify", log, *columns, *speed, "-o", out, *options)
        return read(out)

    def bicycle(self, toml, out):
        self.run("bicycle", toml, "-o", out)
        return read(out)

    def design(self, plant, out, *options):
        self.run("design", plant, "-o", out, *options, accept=(DONE, NOT_MET))
        return read(out)

    def path(self, out, pid, speed, lateral_acceleration, *track):
        limits = ("--speed", f"{speed}m/s")
        if not track:
            limits += ("--lateral-acceleration", f"{lateral_acceleration}m/s2")
        self.run("path", *track, "--pid", pid, *limits, "-o", out)
        return read(out)

    def package(self, out, *files):
        self.run("package", *files, "--out", out)


def read(file):
    return json.loads(Path(file).read_text())
