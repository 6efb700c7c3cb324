"""The cases: three cars at three speeds, and the drive that is recorded of each."""

from dataclasses import dataclass

import numpy as np
import sensors
import vehicle
from datasheet import bicycle_parameters
from drive_log import noisy, write_drive, write_table
from excitation import SAMPLE_TIME_S, Excitation

CARS = (1, 2, 3)
SPEEDS_MPS = (8.0, 15.0, 22.0)


@dataclass(frozen=True)
class Case:
    number: int
    speed: float

    @property
    def name(self):
        return f"car{self.number}_{self.speed:g}mps"

    @property
    def car(self):
        return vehicle.Car(self.number)

    def seed(self, purpose):
        """Of a generator: own numbers for each case and purpose."""
        return [self.number, round(self.speed), purpose]

    @property
    def lag(self):
        """Of the steering, as its maker would state it, s."""
        return vehicle.SERVO_TIME_CONSTANT_S

    def record(self, file, seed, held=1):
        """Drives and writes the log; returns the states and the largest lateral acceleration, m/s2.

        The seed names levels of the steering and sensor noise; each command is held for so many samples.
        """
        p = self.car.published
        levels, noise = np.random.default_rng([*self.seed(0), seed]).spawn(2)
        command = Excitation(p.a + p.b, self.speed).steering_command(levels)
        # The logged digits are the command that is driven; adding zero drops the sign of -0.
        command = np.round(command, 7) + 0.0
        command = command[np.arange(len(command)) // held * held]
        states = self.car.drive(command, self.speed)
        acceleration = self.car.lateral_acceleration(states, command, self.speed)
        truth = [states[:, i] for i in (vehicle.STEER, vehicle.YAW_RATE, vehicle.SPEED)]
        write_drive(file, noise, SAMPLE_TIME_S, command, *truth, acceleration)
        return states, float(np.max(np.abs(acceleration)))

    def record_fixes(self, file, seed, states):
        """Writes where a receiver with corrections had its antenna on that drive, each fix with the
        time at which it was handed over."""
        rng = np.random.default_rng([*self.seed(1), seed])
        at = states[:: sensors.FIX_EVERY]
        x, y = sensors.antenna(at[:, vehicle.X], at[:, vehicle.Y], at[:, vehicle.YAW])
        stated = SAMPLE_TIME_S * sensors.FIX_EVERY * np.arange(len(at)) + sensors.LATENCY_S
        fixes = [noisy(rng, values, sensors.CORRECTED.deviation_m) for values in (x, y)]
        write_table(file, "time_s,x_m,y_m", (2, 4, 4), [stated, *fixes])

    def datasheet(self, scale=None, lag=None):
        """TOML of the linear bicycle; `scale` multiplies some of its parameters."""
        values = bicycle_parameters(self.car.published)
        for key, factor in (scale or {}).items():
            values[key] *= factor
        values["actuator_time_constant_s"] = self.lag if lag is None else lag
        values["steering_ratio"] = 1.0
        values["speed_mps"] = self.speed
        lines = [f'name = "{vehicle.NAMES[self.number]}"']
        return "\n".join(lines + [f"{key} = {value!r}" for key, value in values.items()]) + "\n"


def every():
    return [Case(car, speed) for car in CARS for speed in SPEEDS_MPS]
