"""The refinement's two criteria minimised by scipy, in another parametrisation, from the same start.

The model is polynomials: a y = b u + c e for the prediction focus (ARMAX), y = (b/a) u + v for the
simulation focus (output error), with free initial conditions. The Jacobian is scipy's finite
differences, the standard errors are sigma^2 (J'J)^-1 with the delta method by finite differences.

Reads from stdin: `focus n N`, then A, B, C, K row by row, u, y, each on a line. Prints
`cost`, then `name value standard_error` lines.
"""

import sys

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter

lines = sys.stdin.read().split("\n")
focus, n, count = lines[0].split()
n, count = int(n), int(count)
numbers = [np.array([float(x) for x in line.split()]) for line in lines[1:7]]
A, B = numbers[0].reshape(n, n), numbers[1].reshape(n, 1)
C, K = numbers[2].reshape(1, n), numbers[3].reshape(n, 1)
u, y = numbers[4], numbers[5]

a0 = np.poly(A)
b0 = np.poly(A - B @ C) - a0
c0 = np.poly(A - K @ C)


def errors(theta):
    a = np.concatenate(([1.0], theta[:n]))
    b = np.concatenate(([0.0], theta[n : 2 * n]))
    if focus == "simulation":
        # The free response is that of a filter 1/a with any initial state.
        forced = lfilter(b, a, u)
        free = lfilter([1.0], a, np.zeros(count), zi=theta[2 * n : 3 * n])[0]
        return y - forced - free
    c = np.concatenate(([1.0], theta[2 * n : 3 * n]))
    free = lfilter([1.0], c, np.zeros(count), zi=theta[3 * n : 4 * n])[0]
    return lfilter(a, c, y) - lfilter(b, c, u) - free


def response(theta, omega):
    z = np.exp(-1j * omega)
    powers = z ** np.arange(n + 1)
    return (powers[1:] @ theta[n : 2 * n]) / (1.0 + powers[1:] @ theta[:n])


start = np.concatenate((a0[1:], b0[1:]) + ((c0[1:],) if focus == "prediction" else ()) + (np.zeros(n),))
# The initial conditions first, which are linear: a start without them may be far off.
with np.errstate(all="ignore"):
    found = least_squares(
        errors, start, method="lm", x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14, max_nfev=40000
    )
theta, residual = found.x, found.fun
cost = residual @ residual / count
print("cost", repr(float(cost)))


def jacobian(of, at):
    columns = []
    for k in range(len(at)):
        h = 1e-6 * max(1.0, abs(at[k]))
        ahead, behind = at.copy(), at.copy()
        ahead[k] += h
        behind[k] -= h
        columns.append((of(ahead) - of(behind)) / (2 * h))
    return np.array(columns).T


J = jacobian(errors, theta)
sigma2 = residual @ residual / (count - len(theta))
R = np.linalg.inv(np.linalg.qr(J, mode="r"))
if focus == "simulation":
    # Coloured errors: the exact double sum over their sample autocovariance up to 40 lags, tapered.
    lags = 40
    middle = np.zeros((len(theta), len(theta)))
    for lag in range(-lags, lags + 1):
        k = abs(lag)
        r = residual[k:] @ residual[: count - k] / (count - len(theta))
        taper = 1.0 - k / (lags + 1.0)
        ahead, behind = (J[k:], J[: count - k]) if lag >= 0 else (J[: count - k], J[k:])
        middle += taper * r * ahead.T @ behind
    covariance = R @ R.T @ middle @ R @ R.T
else:
    covariance = sigma2 * R @ R.T


def report(name, of):
    by = jacobian(lambda t: np.array([of(t)]), theta)
    variance = float((by @ covariance @ by.T)[0, 0])
    print(name, repr(float(of(theta))), repr(float(np.sqrt(max(variance, 0.0)))))


report("gain", lambda t: response(t, 0.0).real)
for omega in (0.1, 0.5, 1.5):
    report(f"magnitude({omega})", lambda t, omega=omega: abs(response(t, omega)))
report("slowest_pole", lambda t: max(abs(np.roots(np.concatenate(([1.0], t[:n]))))))
