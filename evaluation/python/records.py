"""What others make of one input and one output: arguments FILE SPLIT WHAT ….

FILE holds the inputs and as many outputs; the first SPLIT samples estimate, and their means are taken
from all. WHAT is
  oe ORDER          an output-error model B(q)/F(q) with a delay of a sample, by scipy's least squares:
                    a line with the fits on both parts, percent
  n4sid ROWS ORDER  SLICOT's N4SID (ctrlsys, IB01AD and IB01BD): a line with the spectral radius and
                    the fits on both parts
  combined ROWS ORDER  SLICOT's combined method on the first SPLIT samples as they are: lines A, B, C, D
Fits are 100 (1 - |y - yhat|/|y - mean y|) of simulations, initial states estimated.
"""

import sys

import ctrlsys
import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter


def fit(y, yhat):
    with np.errstate(all="ignore"):
        value = 100 * (1 - np.linalg.norm(y - yhat) / np.linalg.norm(y - y.mean()))
    return value if np.isfinite(value) else -np.inf


def output_error(u, y, order):
    """B and F (monic) of least simulation error, from an ARX model and Steiglitz and McBride's steps."""

    def regress(u, y, n):
        past = lambda x, k: np.r_[np.zeros(k), x[:-k]]
        phi = np.c_[tuple(-past(y, k) for k in range(1, n + 1)) + tuple(past(u, k) for k in range(1, n + 1))]
        theta = np.linalg.lstsq(phi[n:], y[n:], rcond=None)[0]
        return np.r_[1, theta[:n]], np.r_[0, theta[n:]]

    def stable(f):
        roots = np.roots(f)
        big = np.abs(roots) >= 1
        roots[big] = 1 / np.conj(roots[big]) * 0.999
        return np.real(np.poly(roots))

    def free(f, count):
        impulse = np.eye(1, count)[0]
        return np.array([lfilter(np.eye(1, order, k)[0], f, impulse) for k in range(order)])

    def error(theta):
        f, b, z = np.r_[1, theta[:order]], np.r_[0, theta[order : 2 * order]], theta[2 * order :]
        if np.abs(np.roots(f)).max() >= 1:
            return np.full_like(y, 1e3)
        return y - lfilter(b, f, u) - z @ free(f, len(y))

    best = None
    f, b = regress(u, y, order)
    for step in range(12):
        f = stable(f)
        start = np.r_[f[1:], b[1:], np.zeros(order)]
        cost = np.sum(error(start) ** 2)
        if best is None or cost < best[0]:
            best = (cost, start)
        f, b = regress(lfilter([1], f, u), lfilter([1], f, y), order)
    theta = least_squares(error, best[1], x_scale="jac", max_nfev=200).x
    f, b = np.r_[1, theta[:order]], np.r_[0, theta[order : 2 * order]]

    def simulate(u, y):
        forced, modes = lfilter(b, f, u), free(f, len(y))
        z = np.linalg.lstsq(modes.T, y - forced, rcond=None)[0]
        return forced + z @ modes

    return simulate


def state_space(u, y, method, rows, order):
    u, y = (np.asfortranarray(x.reshape(-1, 1)) for x in (u, y))
    first = {"C": "M"}.get(method, method)
    _, r, _, _, info = ctrlsys.ib01ad(first, "C", "N" if first == "N" else "M", "O", "N", "N", rows, 1, 1, u.copy("F"), y.copy("F"), 0.0, -1.0)[:5]
    a, c, b, d = ctrlsys.ib01bd(method, "A", "N", rows, order, 1, 1, len(u), r, 0.0)[:4]
    return a, b, c, d


def simulate_state_space(a, b, c, d, u, y):
    def run(x, u):
        out = np.empty(len(u))
        for t, v in enumerate(u):
            out[t] = (c @ x)[0] + d[0, 0] * v
            x = a @ x + b[:, 0] * v
        return out

    with np.errstate(all="ignore"):
        n = len(a)
        forced = run(np.zeros(n), u)
        modes = np.array([run(e, np.zeros(len(u))) for e in np.eye(n)])
        if not (np.isfinite(forced).all() and np.isfinite(modes).all()):
            return np.full_like(y, np.inf)
        return forced + np.linalg.lstsq(modes.T, y - forced, rcond=None)[0] @ modes


path, split, what = sys.argv[1], int(sys.argv[2]), sys.argv[3]
u, y = np.fromfile(path, dtype="<f8").reshape(2, -1)
if what == "combined":
    rows, order = map(int, sys.argv[4:6])
    for m in state_space(u[:split], y[:split], "C", rows, order):
        print(*np.asarray(m).reshape(-1))
    sys.exit()
u, y = u - u[:split].mean(), y - y[:split].mean()
halves = [(u[:split], y[:split]), (u[split:], y[split:])]
if what == "oe":
    model = output_error(*halves[0], int(sys.argv[4]))
    print(*(fit(y, model(u, y)) for u, y in halves))
else:
    rows, order = map(int, sys.argv[4:6])
    model = state_space(*halves[0], "N", rows, order)
    radius = np.abs(np.linalg.eigvals(model[0])).max()
    print(radius, *(fit(y, simulate_state_space(*model, u, y)) for u, y in halves))
