"""Who steers: the design on the identified plant, its rivals, and the oracle.

All are designed by the same command with the same options; only the model differs.
"""

from dataclasses import dataclass

import numpy as np
import pid_file
from pid_law import factor_to_margin, modulus_margin, scaled
from program import read
from sensors import ANTENNA_M, LATENCY_S

IDENTIFIED = "identified"
NO_LAG = "datasheet, no lag"
LAG = "datasheet"
ERRORS = "datasheet ±15 %"
FITTED = "fitted bicycle"
ORACLE = "tuned on the car"
# (a) to (e) of the rivals, after the contender itself.
NAMES = (IDENTIFIED, NO_LAG, LAG, ERRORS, FITTED, ORACLE)
# The same for every seed of a case.
FIXED = (NO_LAG, LAG, ORACLE)

# A bicycle file needs a lag: this one is nothing to a controller that ticks at 10 ms.
NO_LAG_S = 1e-4
DATASHEET_ERROR = 0.15
# Of the modulus margin, asked of a design again whose margin with the car is less than was asked.
HIGHER_MARGINS = (0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9)
# Option of every design: the largest rate of the steering servo.
DESIGN = ("--max-rate", "0.4rad/s")


def file_name(who):
    """Of a contender, for folders and files."""
    return who.replace(",", "").replace(" ", "_").replace("±", "").replace("%", "percent")


@dataclass
class Workshop:
    """Makes controllers with the command line."""

    program: object
    design: tuple

    def controller(self, model, folder, *more):
        """Designs on a model's file and packs; returns the pid.json as read."""
        folder.mkdir(parents=True, exist_ok=True)
        pid = self.program.design(model, folder / "pid.json", *self.design, *more)
        self.program.package(folder, folder / "pid.json")
        return pid

    def identified(self, log, fixes, folder):
        receiver = ("--gnss-latency", f"{LATENCY_S}s", "--antenna-x", f"{ANTENNA_M[0]}m")
        plant = self.program.identify(log, folder / "plant.json", fixes, *receiver)
        return plant, self.controller(folder / "plant.json", folder)

    def fitted(self, case, log, folder):
        p = case.car.published
        mass = ("--mass", p.m, "--front-share", f"{100.0 * p.b / (p.a + p.b)}%")
        model = folder / "bicycle.json"
        bicycle = self.program.identify(log, model, "--structure", "bicycle", *mass)
        return bicycle, self.controller(model, folder)

    def datasheet(self, case, folder, **changes):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "vehicle.toml").write_text(case.datasheet(**changes))
        bicycle = self.program.bicycle(folder / "vehicle.toml", folder / "bicycle.json")
        return bicycle, self.controller(folder / "bicycle.json", folder)

    def with_errors(self, case, seed, folder):
        """Mass, inertia and each axle's tyres off by up to the error, uniformly."""
        rng = np.random.default_rng([*case.seed(3), seed])
        keys = (
            "mass_kg",
            "yaw_inertia_kgm2",
            "cornering_stiffness_front_npr",
            "cornering_stiffness_rear_npr",
        )
        factors = rng.uniform(1.0 - DATASHEET_ERROR, 1.0 + DATASHEET_ERROR, len(keys))
        return self.datasheet(case, folder, scale=dict(zip(keys, map(float, factors))))

    def oracle(self, pid, gains, margin, loop, folder):
        """Tuned gains in the file of a design, whose limits and specification they share."""
        made = pid_file.with_gains(pid, gains, margin, ORACLE, loop)
        pid_file.write(made, folder / "pid.json")
        self.program.package(folder, folder / "pid.json")
        return read(folder / "pid.json")

    def at_margin(self, pid, omega, yaw, folder):
        """All three gains multiplied by one factor, so that the loop with the car has the modulus
        margin of the specification; `None` where no factor does. Returns the factor, too."""
        gains = pid_file.gains_of(pid)
        wanted = pid["specification"]["modulus_margin"]
        factor = factor_to_margin(gains, omega, yaw, wanted)
        if factor is None:
            return None
        folder.mkdir(parents=True, exist_ok=True)
        again = scaled(gains, factor)
        made = pid_file.with_gains(pid, again, wanted, "at equal margin", (omega, yaw))
        pid_file.write(made, folder / "pid.json")
        self.program.package(folder, folder / "pid.json")
        return factor

    def redesigned(self, who, pid, omega, yaw, folder):
        """Designed once more by its own method, the modulus margin that is asked for raised until
        the loop with the car has what was asked first.

        Returns the margin to ask for: the first one where it has that already; `None` where none
        of [`HIGHER_MARGINS`] does."""
        wanted = pid["specification"]["modulus_margin"]
        model = folder / ("plant.json" if who == IDENTIFIED else "bicycle.json")

        def keeps(found):
            return modulus_margin(pid_file.gains_of(found), omega, yaw) >= wanted

        if who == ORACLE or keeps(pid):
            return wanted
        for asked in HIGHER_MARGINS:
            if asked > wanted:
                again = self.controller(model, folder / "again", "--modulus-margin", asked)
                if keeps(again):
                    return asked
        return None

    def path(self, speed, lateral_acceleration, folder, *track):
        """Packs the standard road, or a track's, for the folder's controller; returns its figures."""
        file = folder / "path.json"
        made = self.program.path(file, folder / "pid.json", speed, lateral_acceleration, *track)
        self.program.package(folder, file)
        points = np.array(made["points"])
        s, curvature = points[:, 0], points[:, 4]
        return {
            "guidance": made["guidance"],
            "length_m": float(s[-1]),
            "largest_curvature_per_m": float(np.max(np.abs(curvature))),
            "largest_curvature_slope_per_m2": float(np.max(np.abs(np.diff(curvature) / np.diff(s)))),
        }
