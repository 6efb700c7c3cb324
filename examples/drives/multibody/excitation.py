"""The steering of a test drive: sweeps, steps, slaloms and pseudo-random levels.

Each piece is an array of lateral accelerations wanted, in m/s2, one a sample of 10 ms, which becomes
road-wheel angles by the steady cornering of a neutral car, delta = L a_y / v^2. Both halves of the
drive excite 0.1 to 2 Hz with 1 to 4 m/s2, so that one half identifies and the other validates.
"""

import math
from dataclasses import dataclass

import numpy as np

SAMPLE_TIME_S = 0.01
COMMAND_RATE_LIMIT_RADPS = 0.35  # the driver's hands stay below the servo's limit


def samples(duration_s):
    """Times of the samples of a piece that lasts `duration_s`."""
    return SAMPLE_TIME_S * np.arange(round(duration_s / SAMPLE_TIME_S))


def straight(duration_s):
    return np.zeros(len(samples(duration_s)))


def steps(sizes, hold_s, rest_s):
    """From straight to each size and back."""
    return np.concatenate(
        [np.concatenate([straight(hold_s) + size, straight(rest_s)]) for size in sizes]
    )


def slalom(amplitude, frequency_hz, cycles):
    return amplitude * np.sin(2 * np.pi * frequency_hz * samples(cycles / frequency_hz))


def multilevel(rng, amplitude, shortest_s, longest_s, duration_s):
    """Pseudo-random levels, each held for a pseudo-random while."""
    count = len(samples(duration_s))
    levels = np.empty(0)
    while len(levels) < count:
        level = amplitude * rng.uniform(-1.0, 1.0)
        levels = np.append(levels, straight(rng.uniform(shortest_s, longest_s)) + level)
    return levels[:count]


def limit_rate(command):
    """Turns steps into the ramps a servo can follow."""
    largest = COMMAND_RATE_LIMIT_RADPS * SAMPLE_TIME_S
    limited = np.zeros_like(command)
    for k in range(1, len(command)):
        limited[k] = limited[k - 1] + np.clip(command[k] - limited[k - 1], -largest, largest)
    return limited


@dataclass(frozen=True)
class Excitation:
    """The drive of a car of this wheelbase at this speed."""

    wheelbase_m: float
    speed_mps: float

    def road_wheel_angle(self, lateral_acceleration_mps2):
        """Steady cornering of a neutral car: delta = L a_y / v^2."""
        return self.wheelbase_m * lateral_acceleration_mps2 / self.speed_mps**2

    def sweep(self, amplitude, start_hz, stop_hz, duration_s):
        """Logarithmic sweep; its amplitude falls where the rate limit asks for it."""
        growth = math.log(stop_hz / start_hz) / duration_s
        frequency = start_hz * np.exp(growth * samples(duration_s))
        phase = 2 * np.pi * (frequency - start_hz) / growth
        per_angle = self.road_wheel_angle(1.0)
        reachable = COMMAND_RATE_LIMIT_RADPS / (2 * np.pi * frequency) / per_angle
        return np.minimum(amplitude, reachable) * np.sin(phase)

    def steering_command(self, rng):
        """The whole drive: road-wheel angles."""
        first_half = [
            straight(1.0),
            self.sweep(3.0, 0.1, 2.0, 20.0),
            straight(1.0),
            steps([1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 3.8, -3.8], 1.2, 0.8),
            straight(0.5),
            slalom(3.5, 0.5, 4),
            straight(0.5),
            slalom(2.0, 0.8, 4),
        ]
        second_half = [
            straight(1.0),
            self.sweep(2.0, 2.0, 0.1, 14.0),
            straight(1.0),
            steps([-3.5, 2.5, -1.5, 1.5, 3.5], 0.9, 0.6),
            straight(0.5),
            slalom(3.8, 0.4, 3),
            straight(0.5),
            multilevel(rng, 3.8, 0.2, 1.2, 18.0),
            straight(1.0),
        ]
        return limit_rate(self.road_wheel_angle(np.concatenate(first_half + second_half)))
