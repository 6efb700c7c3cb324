"""SLICOT's N4SID (ctrlsys, IB01AD and IB01BD) on several inputs and outputs: arguments FILE INPUTS OUTPUTS.

FILE holds the inputs and outputs, channel after channel. The first half estimates, and its means are taken from both; the
second half validates by simulation from an estimated initial state. A grid of twelve settings: block rows 10, 15 and 20, or
as many as the record allows, and orders 2, 4, 6 and 8. Prints the mean fit of the best setting, the seconds of one model and
of the grid, and after a bar the fits by output with the setting.
"""

import sys
import time

import ctrlsys
import numpy as np

path, m, p = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
data = np.fromfile(path, dtype="<f8").reshape(m + p, -1)
n = data.shape[1]
half = n - n // 2
data = data - data[:, :half].mean(axis=1, keepdims=True)
u, y = data[:m].T, data[m:].T


def simulated(a, b, c, d, u, y):
    """From the initial state that fits the output best."""
    states, free, row = np.zeros(len(a)), [], c
    forced = np.empty_like(y)
    for k in range(len(u)):
        forced[k] = c @ states + d @ u[k]
        states = a @ states + b @ u[k]
        free.append(row)
        row = row @ a
    free = np.concatenate(free)
    x0 = np.linalg.lstsq(free, (y - forced).ravel(), rcond=None)[0]
    return forced + (free @ x0).reshape(y.shape)


def fits(y, simulated):
    with np.errstate(all="ignore"):
        off = np.linalg.norm(y - simulated, axis=0) / np.linalg.norm(y - y.mean(axis=0), axis=0)
    return np.where(np.isfinite(off), 100 * (1 - off), -1e9)


def model(rows, order):
    """A, B, C, D of one setting."""
    f = np.asfortranarray
    first, second = f(u[:half].copy()), f(y[:half].copy())
    found, r, *_ = ctrlsys.ib01ad("N", "C", "N", "O", "N", "N", rows, m, p, first, second, 0.0, -1.0)
    result = ctrlsys.ib01bd("N", "A", "N", rows, order, m, p, half, r, 0.0)
    return result[:4]


most = (half + 1) // (2 * (m + p + 1))
grid = sorted({min(rows, most) for rows in (10, 15, 20)})
best, seconds, started = None, [], time.process_time()
for rows in grid:
    for order in (1, 2, 3, 4, 5, 6, 8) if len(grid) == 1 else (2, 4, 6, 8):
        if order >= rows * p:
            continue
        before = time.process_time()
        try:
            a, c, b, d = model(rows, order)
        except Exception:
            continue
        seconds.append(time.process_time() - before)
        own = fits(y[half:], simulated(a, b, c, d, u[half:], y[half:]))
        if best is None or own.mean() > best[0]:
            best = (own.mean(), own, rows, order)
if best is None:
    print("nan nan nan | no model")
else:
    text = ", ".join(f"{x:.2f}" for x in best[1])
    print(best[0], np.median(seconds), time.process_time() - started, f"| {text} (block rows {best[2]}, order {best[3]})")
