"""What the car measures on the road, with seeded noise.

GNSS: ten fixes a second of the antenna's position, each handed over 100 ms after it was valid; the
corrected one errs by centimetres, the uncorrected one by metres, white. During a drop-out none is
handed over. Gyro: a constant bias and white noise. Speed: white noise.
"""

import math
from dataclasses import dataclass

import numpy as np
import vehicle
from excitation import SAMPLE_TIME_S

FIX_EVERY = 10  # samples
LATENCY_S = 0.1
ANTENNA_M = (0.4, 0.2)  # ahead and to the left of the centre of gravity

GYRO_BIAS_RADPS = 0.005  # standard deviation between drives
GYRO_NOISE_RADPS = 0.002
SPEED_NOISE_MPS = 0.02
INITIAL_YAW_STD_RAD = math.radians(0.5)


def antenna(x, y, yaw):
    """Where it is, m, for a pose of the centre of gravity."""
    ahead, left = ANTENNA_M
    cos, sin = np.cos(yaw), np.sin(yaw)
    return x + ahead * cos - left * sin, y + ahead * sin + left * cos


@dataclass(frozen=True)
class Gnss:
    """A way of reception."""

    name: str
    deviation_m: float
    drop_out_s: float = 0.0


CORRECTED = Gnss("corrected", 0.02)
DROP_OUT = Gnss("drop-out", 0.02, drop_out_s=2.0)
UNCORRECTED = Gnss("uncorrected", 1.5)
RECEPTIONS = (CORRECTED, DROP_OUT, UNCORRECTED)


@dataclass
class Reading:
    gyro: float
    speed: float
    gnss_x: float
    gnss_y: float
    fixes: int


class Sensors:
    """Reads the car sample by sample; the same seed gives the same errors to every contender."""

    def __init__(self, gnss, seed, drop_out_from, count, latency_s=LATENCY_S):
        rng = np.random.default_rng(seed)
        self.gnss, self.latency = gnss, round(latency_s / SAMPLE_TIME_S)
        self.lost = range(
            round(drop_out_from / SAMPLE_TIME_S),
            round((drop_out_from + gnss.drop_out_s) / SAMPLE_TIME_S),
        )
        self.bias = GYRO_BIAS_RADPS * rng.standard_normal()
        self.initial_yaw = INITIAL_YAW_STD_RAD * rng.standard_normal()
        self.gyro = GYRO_NOISE_RADPS * rng.standard_normal(count)
        self.speed = SPEED_NOISE_MPS * rng.standard_normal(count)
        self.position = gnss.deviation_m * rng.standard_normal((count, 2))
        self.under_way = {}
        self.last = (0.0, 0.0)
        self.fixes = 0

    def read(self, k, state):
        if k % FIX_EVERY == 0 and k not in self.lost:
            x, y = antenna(state[vehicle.X], state[vehicle.Y], state[vehicle.YAW])
            fix = (x + self.position[k, 0], y + self.position[k, 1])
            self.under_way[k + self.latency] = fix
        if k in self.under_way:
            self.last = self.under_way.pop(k)
            self.fixes += 1
        return Reading(
            gyro=state[vehicle.YAW_RATE] + self.bias + self.gyro[k],
            speed=state[vehicle.SPEED] + self.speed[k],
            gnss_x=self.last[0],
            gnss_y=self.last[1],
            fixes=self.fixes,
        )
