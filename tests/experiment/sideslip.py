"""The sideslip per yaw rate in a turn, s, from the recorded drive and its GNSS positions.

Course is yaw plus sideslip: with the gyro integrated, course(t) − ∫gyro dt = ψ0 + bias·t + S·r(t),
and S comes by least squares. Course is that between fixes 0.2 s apart. Every contender is guided
with the same S, which is a property of the car and not of a controller.
"""

import numpy as np
import vehicle
from drive_log import noisy
from excitation import SAMPLE_TIME_S
from sensors import CORRECTED, FIX_EVERY, GYRO_NOISE_RADPS


def calibrate(states, rng):
    fixes = slice(None, None, FIX_EVERY)
    x = noisy(rng, states[fixes, vehicle.X], CORRECTED.deviation_m)
    y = noisy(rng, states[fixes, vehicle.Y], CORRECTED.deviation_m)
    gyro = noisy(rng, states[:, vehicle.YAW_RATE], GYRO_NOISE_RADPS)
    turned = np.cumsum(gyro) * SAMPLE_TIME_S
    window = np.ones(2 * FIX_EVERY) / (2 * FIX_EVERY)
    yaw = np.convolve(turned, window, "same")[fixes][1:-1]
    rate = np.convolve(gyro, window, "same")[fixes][1:-1]
    course = np.unwrap(np.arctan2(y[2:] - y[:-2], x[2:] - x[:-2]))
    time = SAMPLE_TIME_S * FIX_EVERY * np.arange(len(course))
    unknowns = np.column_stack([np.ones_like(time), time, rate])
    return float(np.linalg.lstsq(unknowns, course - yaw, rcond=None)[0][2])
