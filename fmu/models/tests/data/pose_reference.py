#!/usr/bin/env python3
"""An extended Kalman filter that is not ours, on a drive with delayed fixes.

The equations are taken from their continuous-time form: the mean by Runge and Kutta's method in
short steps, its Jacobian by differences, the noise by Van Loan's matrix exponential. Nothing is
buffered: for each fix the whole drive is filtered again, the fixes sorted by when they were valid.

    python pose_reference.py > pose_reference.csv      (numpy 2, scipy 1.15 or newer)

A row is a communication point: what the sensors said there, and the estimate after it.
"""

import numpy as np
from scipy.linalg import expm

STEP, LATENCY, ANTENNA, SLIP = 0.02, 0.07, np.array([1.2, -0.4]), 0.08
DENSITY = {"r": 2e-3, "b": 1e-3, "v": 0.1, "l": 0.08, "s": 4e-3}
START = np.array([3.0, -2.0, 0.5, 0.0, 0.0])
START_STD = np.array([0.8, 0.8, 0.15, 0.03, 0.04])
STATES = len(START)
GATE = 18.42


def rates(state, g, v):
    """Of any number of states, one a column."""
    yaw, rate = state[2], g - state[3]
    lateral = (SLIP + state[4]) * v * rate
    return np.array([v * np.cos(yaw) - lateral * np.sin(yaw),
                     v * np.sin(yaw) + lateral * np.cos(yaw), rate, 0 * rate, 0 * rate])


def flow(state, g, v, t, pieces=4):
    h = t / pieces
    for _ in range(pieces):
        k1 = rates(state, g, v)
        k2 = rates(state + 0.5 * h * k1, g, v)
        k3 = rates(state + 0.5 * h * k2, g, v)
        k4 = rates(state + h * k3, g, v)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state


def predict(mean, cov, g, v, t):
    size = 1e-4
    moved = flow(np.column_stack([mean] + [mean + s * size * e for s in (1, -1) for e in np.eye(STATES)]), g, v, t)
    jacobian = (moved[:, 1 : STATES + 1] - moved[:, STATES + 1 :]) / (2 * size)
    velocity = (moved[:2, 0] - mean[:2]) / t
    heading = mean[2] + 0.5 * (g - mean[3]) * t
    u = np.array([np.cos(heading), np.sin(heading)])
    n = np.array([-u[1], u[0]])
    a = np.zeros((STATES, STATES))
    slip = SLIP + mean[4]
    a[:2, 2] = -velocity[1], velocity[0]
    a[:2, 3] = -slip * v * n
    a[2, 3] = -1
    a[:2, 4] = v * (g - mean[3]) * n
    noise = np.zeros((STATES, STATES))
    for q, g_ in (
        ("r", [*(slip * v * n), 1, 0, 0]),
        ("b", [0, 0, 0, 1, 0]),
        ("v", [*u, 0, 0, 0]),
        ("l", [*n, 0, 0, 0]),
        ("s", [0, 0, 0, 0, 1]),
    ):
        noise += DENSITY[q] ** 2 * np.outer(g_, g_)
    van_loan = expm(np.block([[-a, noise], [np.zeros((STATES, STATES)), a.T]]) * t)
    return moved[:, 0], jacobian @ cov @ jacobian.T + van_loan[STATES:, STATES:].T @ van_loan[:STATES, STATES:]


def turned(yaw, arm):
    return np.array([arm[0] * np.cos(yaw) - arm[1] * np.sin(yaw), arm[0] * np.sin(yaw) + arm[1] * np.cos(yaw)])


def correct(mean, cov, fix, std):
    arm = turned(mean[2], ANTENNA)
    h = np.array([[1, 0, -arm[1], 0, 0], [0, 1, arm[0], 0, 0]])
    s = h @ cov @ h.T + std**2 * np.eye(2)
    nu = fix - mean[:2] - arm
    if nu @ np.linalg.solve(s, nu) > GATE:
        return mean, cov
    gain = np.linalg.solve(s, h @ cov).T
    return mean + gain @ nu, cov - gain @ s @ gain.T


def estimate(intervals, fixes, now):
    """The estimate at a time, from the start."""
    mean, cov, time = START.copy(), np.diag(START_STD**2), 0.0
    pending = sorted(fixes, key=lambda f: f[0])
    for end, g, v in intervals:
        while time < end - 1e-12:
            until = end
            if pending and pending[0][0] <= end + 1e-12:
                until = min(end, pending[0][0])
            if until > time + 1e-12:
                mean, cov = predict(mean, cov, g, v, until - time)
                time = until
            while pending and abs(pending[0][0] - time) <= 1e-9:
                mean, cov = correct(mean, cov, *pending.pop(0)[1:])
    assert abs(time - now) < 1e-9 and not pending
    return mean, cov


def main():
    rng = np.random.default_rng(5)
    state = np.append(START[:3] + rng.normal(size=3) * [0.8, 0.8, 0.15], [0.025, 0.03])
    places, intervals, fixes = [(0.0, state)], [], []
    before, count = None, 0
    print("time,yaw_rate,speed,gnss_x,gnss_y,gnss_std,gnss_fix_count,x,y,yaw,bias,sideslip,"
          + ",".join(f"p{i}{j}" for i in range(STATES) for j in range(i + 1)))
    fix, std = np.zeros(2), 0.0
    for k in range(1, 301):
        time = k * STEP
        rate, speed = 0.5 * np.sin(1.1 * time) + 0.1, 9.0 + 2.0 * np.sin(0.7 * time)
        # The drive: the truth matters little here, only that the fixes are near it.
        state = flow(state, rate + state[3], speed, STEP)
        places.append((time, state))
        g = round(rate + state[3] + rng.normal() * DENSITY["r"] / STEP**0.5, 6)
        v = round(speed + rng.normal() * DENSITY["v"] / STEP**0.5, 4)
        last = before or (g, v)
        intervals.append((time, 0.5 * (last[0] + g), 0.5 * (last[1] + v)))
        before = (g, v)
        valid = time - LATENCY
        # At 10 Hz, not in a drop-out of 1.5 s.
        if k % 5 == 0 and not 2.0 < time < 3.5:
            count += 1
            std = [0.02, 0.5, 1.5][count % 3]
            index = int(valid / STEP)
            if valid >= 0.0:
                t0, s0 = places[index]
                _, s1 = places[index + 1]
                at = s0 + (s1 - s0) * (valid - t0) / STEP
                fix = at[:2] + turned(at[2], ANTENNA) + rng.normal(size=2) * std
            if count == 12:
                fix = fix + [12.0, -9.0]
            fix = np.round(fix, 3)
            if count == 20:
                std = -1.0
            if valid >= 0.0 and std > 0.0:
                fixes.append((valid, fix, std))
        mean, cov = estimate(intervals, fixes, time)
        row = [time, *before, *fix, std]
        lower = [cov[i, j] for i in range(STATES) for j in range(i + 1)]
        print(",".join(f"{x:.6g}" for x in row) + f",{count},"
              + ",".join(f"{x:.10g}" for x in [*mean, *lower]))


main()
