"""Output error of order 2 in continuous time, by SciPy's least_squares.

Arguments: a file of doubles (for each drive its steering, then its yaw rate), samples of a drive, sample
time in s, and the hold of the steering between samples, zoh or foh. Prints b1 b0 a1 a0 of
(b1 s + b0)/(s^2 + a1 s + a0) for each drive. b1, b0, the initial state and a constant are linear and are
eliminated (variable projection).
"""

import sys

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import cont2discrete, lfilter

path, samples, step, hold = sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), sys.argv[4]
drives = np.fromfile(path).reshape(-1, 2, samples)


def columns(theta, u):
    a1, a0 = np.exp(theta)
    out = []
    for numerator in ([1.0, 0.0], [1.0]):
        b, a, _ = cont2discrete((numerator, [1.0, a1, a0]), step, method=hold)
        out.append(lfilter(b.ravel(), a, u))
    impulse = np.zeros_like(u)
    impulse[0] = 1.0
    out.append(lfilter([1.0], a, impulse))
    out.append(lfilter([0.0, 1.0], a, impulse))
    out.append(np.ones_like(u))
    return np.column_stack(out)


def left(theta, u, y):
    x = columns(theta, u)
    return y - x @ np.linalg.lstsq(x, y, rcond=None)[0]


for u, y in drives:
    best = None
    for start in ([8.0, 20.0], [5.0, 8.0], [12.0, 60.0]):
        found = least_squares(left, np.log(start), args=(u, y), bounds=(-2.0, 9.0), xtol=1e-9)
        if best is None or found.cost < best.cost:
            best = found
    x = columns(best.x, u)
    b1, b0 = np.linalg.lstsq(x, y, rcond=None)[0][:2]
    a1, a0 = np.exp(best.x)
    print(b1, b0, a1, a0)
