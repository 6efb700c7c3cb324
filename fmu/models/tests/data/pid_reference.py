"""Closed loops of the yaw controller, simulated by SciPy and the textbook's positional form.

Writes pid_reference.csv next to this file: `python pid_reference.py` (NumPy, SciPy). Nothing here
knows the project's code. The plant is yaw rate = 4/(0.1 s + 1) times steering, held from tick to
tick and sampled by scipy.signal.cont2discrete; the reference steps to 0.5 rad at tick 0 and goes
to -0.2 rad at tick 150; a disturbance of -0.02 rad acts on the steering from tick 75 on.

`linear` is no simulation of the controller at all: the transfer functions of the closed loop from
reference and disturbance, formed with polynomials and run by scipy.signal.lfilter. The others are
the positional form of the PID with back-calculation (Astrom and Hagglund, 1995, eq 3.18), each with
one limit that acts.
"""

import pathlib

import numpy as np
from scipy import signal

TS, N = 0.02, 300
KP, KI, KD, TF, B, C, TT = 1.1, 0.9, 0.06, 0.03, 0.7, 0.0, 0.25
FREE = 1e6
CASES = {
    "linear": (FREE, FREE, FREE),
    "angle": (0.12, FREE, FREE),
    "increment": (FREE, 0.015, FREE),
    "rate": (FREE, FREE, 0.5),
}


def reference():
    r = np.full(N, 0.5)
    r[150:] = -0.2
    return r


def disturbance():
    d = np.zeros(N)
    d[75:] = -0.02
    return d


def plus(*polynomials):
    """Sum of polynomials in 1/z, lowest power first."""
    length = max(len(p) for p in polynomials)
    return sum(np.pad(p, (0, length - len(p))) for p in polynomials)


def linear():
    # Numerator and denominator of equal length: in 1/z, lowest power first, as they are.
    num, den, _ = signal.cont2discrete(([4.0], [0.1, 1.0, 0.0]), TS, "zoh")
    num = num.ravel()
    difference = np.array([1.0, -1.0])
    filtered = np.array([TF + TS, -TF])
    # u = (R r - S y)/Q with the common denominator of integrator and filter.
    q = np.convolve(difference, filtered)
    integral = KI * TS * filtered
    derivative = KD * np.convolve(difference, difference)
    of_r = plus(KP * B * q, integral, C * derivative)
    of_y = plus(KP * q, integral, derivative)
    closed = plus(np.convolve(den, q), np.convolve(num, of_y))
    y = signal.lfilter(np.convolve(num, of_r), closed, reference())
    y = y + signal.lfilter(np.convolve(num, q), closed, disturbance())
    u = signal.lfilter(np.convolve(den, of_r), closed, reference())
    u = u - signal.lfilter(np.convolve(num, of_y), closed, disturbance())
    return y, u


def limited(angle, increment, rate):
    a, b, c, _, _ = signal.cont2discrete(
        (np.array([[-10.0, 0.0], [1.0, 0.0]]), np.array([[40.0], [0.0]]), np.eye(2), np.zeros((2, 1))), TS
    )
    z = np.zeros((2, 1))
    r, d = reference(), disturbance()
    integral, slope, before = 0.0, 0.0, 0.0
    y_before = 0.0
    ys, us = [], []
    for k in range(N):
        y = z[1, 0]
        slope = (TF * slope - KD * (y - y_before)) / (TF + TS)
        # The increment of the integral belongs to the tick, as in backward Euler.
        integral += KI * TS * (r[k] - y)
        v = KP * (B * r[k] - y) + integral + slope
        most = min(increment, rate * TS)
        u = min(max(v, before - most), before + most)
        u = min(max(u, -angle), angle)
        integral += TS / TT * (u - v)
        ys.append(y)
        us.append(u)
        y_before, before = y, u
        z = a @ z + b * (u + d[k])
    return np.array(ys), np.array(us)


def main():
    columns = {}
    for name, limits in CASES.items():
        y, u = linear() if name == "linear" else limited(*limits)
        columns[f"{name}_yaw"], columns[f"{name}_steering"] = y, u
    # The two ways agree where no limit acts.
    y, u = limited(FREE, FREE, FREE)
    assert np.abs(y - columns["linear_yaw"]).max() < 1e-9
    assert np.abs(u - columns["linear_steering"]).max() < 1e-8
    rows = [",".join(columns)]
    rows += [",".join(f"{v:.12e}" for v in row) for row in zip(*columns.values())]
    here = pathlib.Path(__file__).with_name("pid_reference.csv")
    here.write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
