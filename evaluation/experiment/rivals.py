"""Steering laws that others use, each with the data sheet of the car and the lag of its servo.

They get what the packed units get: the pose and course of the packed PoseEstimator, the gyro less its mean at rest,
and the speed. Errors are to the left of the road; `Law.steer` returns the angle that is sent.

* Pure pursuit (Coulter 1992): the arc along the course to a point of the road ahead, with the steady understeer.
* Stanley (Thrun and others 2006; Hoffmann and others 2007): heading and offset at the front axle, with steady
  sideslip, feedforward of the curvature, and damping of the yaw rate.
* LQR with preview (Sharp and Valtetsis 2001): bicycle and servo, the command's rate as input, gains over speed.
* MPC: the same model and weights over 2 s of 50 ms, with the largest rate of the servo as a constraint.
"""

import itertools
import math
from functools import lru_cache

import numba
import numpy as np
from datasheet import bicycle_parameters
from excitation import SAMPLE_TIME_S
from scipy.linalg import expm, solve_discrete_are
from vehicle import SERVO_RATE_LIMIT_RADPS, SERVO_TIME_CONSTANT_S, Car

LARGEST_ANGLE_RAD = math.radians(22.0)
LEAST_SPEED_MPS = 3.0
PREVIEW = 150  # samples
HORIZON, HORIZON_STEP_S = 40, 0.05
STATES = 6  # offset, heading error, lateral velocity, yaw rate, angle of the servo, command
MOST_STEPS = 200


class Sheet:
    """The linear bicycle of a data sheet."""

    def __init__(self, number):
        values = bicycle_parameters(Car(number).published)
        self.mass, self.inertia = values["mass_kg"], values["yaw_inertia_kgm2"]
        self.front, self.rear = values["distance_front_m"], values["distance_rear_m"]
        self.stiff_front = values["cornering_stiffness_front_npr"]
        self.stiff_rear = values["cornering_stiffness_rear_npr"]
        self.wheelbase = self.front + self.rear
        moment = self.rear * self.stiff_rear - self.front * self.stiff_front
        self.understeer = self.mass * moment / (self.stiff_front * self.stiff_rear * self.wheelbase)

    def steady_angle(self, speed, curvature):
        return (self.wheelbase + self.understeer * speed**2) * curvature

    def steady_sideslip(self, speed, curvature):
        """Of the centre of gravity, rad."""
        load = self.mass * self.front * speed**2 / (self.stiff_rear * self.wheelbase)
        return (self.rear - load) * curvature

    def matrices(self, speed, step):
        """A, B and E for a step: x⁺ = A x + B (rate of the command) + E (curvature), the inputs held."""
        m, j, a, b = self.mass, self.inertia, self.front, self.rear
        cf, cr = self.stiff_front, self.stiff_rear
        f = np.zeros((STATES + 2, STATES + 2))
        f[0, 1:3] = speed, 1.0
        f[1, 3], f[1, 7] = 1.0, -speed
        f[2, 2:5] = -(cf + cr) / (m * speed), (b * cr - a * cf) / (m * speed) - speed, cf / m
        f[3, 2:5] = (b * cr - a * cf) / (j * speed), -(a * a * cf + b * b * cr) / (j * speed), a * cf / j
        f[4, 4:6] = -1.0 / SERVO_TIME_CONSTANT_S, 1.0 / SERVO_TIME_CONSTANT_S
        f[5, 6] = 1.0
        e = expm(f * step)
        return e[:STATES, :STATES], e[:STATES, STATES : STATES + 1], e[:STATES, STATES + 1 :]

    def steady(self, speed):
        """The states in a steady turn per curvature."""
        slip, angle = self.steady_sideslip(speed, 1.0), self.steady_angle(speed, 1.0)
        return np.array([0.0, -slip, speed * slip, speed, angle, angle])


class Road:
    """Points of a path.json."""

    def __init__(self, points):
        points = np.asarray(points, dtype=float)
        self.s, self.x, self.y = (np.ascontiguousarray(points[:, i]) for i in range(3))
        self.heading = np.unwrap(np.arctan2(np.gradient(self.y, self.s), np.gradient(self.x, self.s)))
        self.curvature = np.ascontiguousarray(points[:, 4])

    def curvature_at(self, s):
        return np.interp(s, self.s, self.curvature)

    def heading_at(self, s):
        return np.interp(s, self.s, self.heading)

    def locate(self, x, y, near):
        """Distance along the road and offset to its left of the nearest point, searched for from a distance."""
        return nearest(self.s, self.x, self.y, x, y, near)


@numba.njit
def nearest(s, px, py, x, y, near):
    i = min(max(np.searchsorted(s, near) - 1, 0), len(s) - 2)
    best, found, offset = math.inf, s[0], 0.0
    for k in range(max(0, i - 20), min(len(s) - 1, i + 60)):
        dx, dy, length = px[k + 1] - px[k], py[k + 1] - py[k], s[k + 1] - s[k]
        chord = math.hypot(dx, dy)
        part = ((x - px[k]) * dx + (y - py[k]) * dy) / (chord * chord)
        # The first and the last piece go on as straight lines.
        low, high = (-math.inf if k == 0 else 0.0), (math.inf if k == len(s) - 2 else 1.0)
        part = min(max(part, low), high)
        away = math.hypot(x - px[k] - part * dx, y - py[k] - part * dy)
        if away < best:
            best, found = away, s[k] + part * length
            offset = (dx * (y - py[k]) - dy * (x - px[k])) / chord
    return found, math.copysign(best, offset)


class Law:
    """What the laws share: the place on the road, and the limits."""

    def __init__(self, sheet, road):
        self.sheet, self.road, self.distance, self.sent = sheet, road, 0.0, 0.0

    def command(self, _k, pose, speed):
        x, y, yaw, course, yaw_rate = pose
        speed = max(speed, LEAST_SPEED_MPS)
        self.distance, offset = self.road.locate(x, y, self.distance)
        angle = self.steer(x, y, yaw, course, yaw_rate, speed, offset)
        self.sent = min(max(angle, -LARGEST_ANGLE_RAD), LARGEST_ANGLE_RAD)
        return self.sent

    def close(self):
        pass


class PurePursuit(Law):
    GRID = {"lookahead_s": (0.1, 0.15, 0.2, 0.3, 0.5), "least_m": (1.0, 2.0), "lead_s": (0.0, 0.05, 0.1, 0.15)}

    def __init__(self, sheet, road, lookahead_s, least_m, lead_s):
        super().__init__(sheet, road)
        self.lookahead_s, self.least_m, self.lead_s = lookahead_s, least_m, lead_s

    def steer(self, x, y, yaw, course, yaw_rate, speed, offset):
        # Where the car is when the servo has followed.
        turned = yaw_rate * self.lead_s
        x += speed * self.lead_s * math.cos(course + 0.5 * turned)
        y += speed * self.lead_s * math.sin(course + 0.5 * turned)
        ahead = max(self.least_m, self.lookahead_s * speed)
        goal_x, goal_y = self.point(self.distance + speed * self.lead_s + ahead)
        bearing = math.atan2(goal_y - y, goal_x - x) - course - turned
        arc = 2.0 * math.sin(bearing) / math.hypot(goal_x - x, goal_y - y)
        return self.sheet.steady_angle(speed, arc)

    def point(self, s):
        beyond = max(0.0, s - self.road.s[-1])
        heading = self.road.heading[-1]
        x, y = np.interp(s, self.road.s, self.road.x), np.interp(s, self.road.s, self.road.y)
        return x + beyond * math.cos(heading), y + beyond * math.sin(heading)


class Stanley(Law):
    GRID = {"gain_per_s": (1.0, 2.0, 4.0, 8.0), "damping_s": (0.0, 0.05, 0.1), "preview_s": (0.0, 0.1, 0.2)}

    def __init__(self, sheet, road, gain_per_s, damping_s, preview_s):
        super().__init__(sheet, road)
        self.gain, self.damping, self.preview = gain_per_s, damping_s, preview_s

    def steer(self, x, y, yaw, course, yaw_rate, speed, offset):
        here = self.distance + self.sheet.front
        ahead = here + speed * self.preview
        curvature = self.road.curvature_at(ahead)
        front_x, front_y = x + self.sheet.front * math.cos(yaw), y + self.sheet.front * math.sin(yaw)
        _, at_front = self.road.locate(front_x, front_y, here)
        # Of a car that follows the road in a steady turn: its yaw, and its front axle beside the road.
        slip = self.sheet.steady_sideslip(speed, self.road.curvature_at(here))
        steady = self.sheet.front * (-slip) - 0.5 * self.sheet.front**2 * self.road.curvature_at(here)
        heading = math.remainder(yaw - self.road.heading_at(self.distance) + slip, math.tau)
        rate = yaw_rate - speed * self.road.curvature_at(self.distance)
        back = math.atan2(self.gain * (at_front - steady), speed + 1.0)
        return self.sheet.steady_angle(speed, curvature) - heading - back - self.damping * rate


class Lqr(Law):
    GRID = {"weight_m2s2": (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)}
    SPEEDS = np.arange(3.0, 34.0, 1.0)

    def __init__(self, sheet, road, weight_m2s2):
        super().__init__(sheet, road)
        found = [preview_gains(sheet, float(speed), weight_m2s2) for speed in self.SPEEDS]
        self.feedback = np.array([feedback for feedback, _ in found])
        self.ahead = np.array([ahead for _, ahead in found])
        self.wheel = 0.0

    def steer(self, x, y, yaw, course, yaw_rate, speed, offset):
        state = self.state(yaw, course, yaw_rate, speed, offset)
        place = min(max((speed - self.SPEEDS[0]) / (self.SPEEDS[1] - self.SPEEDS[0]), 0.0), len(self.SPEEDS) - 1.001)
        i, part = int(place), place - int(place)
        feedback = (1 - part) * self.feedback[i] + part * self.feedback[i + 1]
        ahead = (1 - part) * self.ahead[i] + part * self.ahead[i + 1]
        curvature = self.road.curvature_at(self.distance + speed * SAMPLE_TIME_S * np.arange(PREVIEW))
        return self.moved(-(feedback @ state + ahead @ curvature))

    def state(self, yaw, course, yaw_rate, speed, offset):
        heading = math.remainder(yaw - self.road.heading_at(self.distance), math.tau)
        lateral = speed * math.tan(math.remainder(course - yaw, math.tau))
        return np.array([offset, heading, lateral, yaw_rate, self.wheel, self.sent])

    def moved(self, rate):
        """The command after a sample; what the servo does by its data sheet is kept."""
        largest = SERVO_RATE_LIMIT_RADPS
        angle = self.sent + SAMPLE_TIME_S * min(max(rate, -largest), largest)
        wanted = (angle - self.wheel) / SERVO_TIME_CONSTANT_S
        self.wheel += SAMPLE_TIME_S * min(max(wanted, -largest), largest)
        return angle


@lru_cache(maxsize=4096)
def preview_gains(sheet, speed, weight):
    """Gains on the state, and on the curvature at the next samples; beyond them it is taken for constant."""
    a, b, e = sheet.matrices(speed, SAMPLE_TIME_S)
    q = np.zeros((STATES, STATES))
    q[0, 0] = 1.0
    p = solve_discrete_are(a, b, q + 1e-9 * np.eye(STATES), np.array([[weight]]))
    inverse = 1.0 / (weight + (b.T @ p @ b)[0, 0])
    feedback = inverse * (b.T @ p @ a)
    closed = (a - b @ feedback).T
    ahead, weighted = np.empty(PREVIEW), p @ e
    for k in range(PREVIEW - 1):
        ahead[k] = inverse * (b.T @ weighted)[0, 0]
        weighted = closed @ weighted
    ahead[-1] = inverse * (b.T @ np.linalg.solve(np.eye(STATES) - closed, weighted))[0, 0]
    return feedback[0], ahead


class Mpc(Lqr):
    """With the weight of the LQR, which has the same cost where no limit acts."""

    def __init__(self, sheet, road, weight_m2s2):
        Law.__init__(self, sheet, road)
        self.weight, self.wheel, self.rates = weight_m2s2, 0.0, np.zeros(HORIZON)

    def steer(self, x, y, yaw, course, yaw_rate, speed, offset):
        state = self.state(yaw, course, yaw_rate, speed, offset)
        hessian, of_state, of_curvature = condensed(self.sheet, float(round(speed)), self.weight)
        curvature = self.road.curvature_at(self.distance + speed * HORIZON_STEP_S * np.arange(HORIZON + 1))
        linear = of_state @ state + of_curvature @ curvature
        bounded_least(hessian, linear, SERVO_RATE_LIMIT_RADPS, self.rates)
        return self.moved(self.rates[0])


@lru_cache(maxsize=4096)
def condensed(sheet, speed, weight):
    """H, and what multiplies state and curvature in the linear term, of ½ u'H u + u'(…) over the rates u."""
    a, b, e = sheet.matrices(speed, HORIZON_STEP_S)
    q = np.zeros((STATES, STATES))
    q[0, 0] = 1.0
    last = solve_discrete_are(a, b, q + 1e-9 * np.eye(STATES), np.array([[weight]]))
    n = HORIZON
    of_state, of_rates, of_curvature = np.eye(STATES), np.zeros((STATES, n)), np.zeros((STATES, n + 1))
    hessian, linear = weight * np.eye(n), [np.zeros((n, STATES)), np.zeros((n, n + 1))]
    for k in range(1, n + 1):
        of_state, of_rates, of_curvature = a @ of_state, a @ of_rates, a @ of_curvature
        of_rates[:, k - 1] += b[:, 0]
        of_curvature[:, k - 1] += e[:, 0]
        shifted = of_curvature.copy()
        cost = q
        if k == n:
            # The rest is that of an unlimited loop from there, in the steady turn of the last curvature.
            cost = last
            shifted[:, n] -= sheet.steady(speed)
        hessian += of_rates.T @ cost @ of_rates
        linear[0] += of_rates.T @ cost @ of_state
        linear[1] += of_rates.T @ cost @ shifted
    return hessian, linear[0], linear[1]


@numba.njit
def bounded_least(hessian, linear, bound, u):
    """The least of ½ u'H u + u'f within ±bound, from u, in place: the primal active set method, one bound at a time."""
    n = len(u)
    held = np.zeros(n, np.int64)
    for i in range(n):
        held[i] = 1 if u[i] >= bound else (-1 if u[i] <= -bound else 0)
    for _ in range(MOST_STEPS):
        free = np.flatnonzero(held == 0)
        count = len(free)
        slope = hessian @ u + linear
        reach, hit = 1.0, -1
        if count > 0:
            inner, right = np.empty((count, count)), np.empty(count)
            for i in range(count):
                right[i] = -slope[free[i]]
                for j in range(count):
                    inner[i, j] = hessian[free[i], free[j]]
            step = np.linalg.solve(inner, right)
            for i in range(count):
                room = (bound if step[i] > 0.0 else -bound) - u[free[i]]
                if abs(step[i]) * reach > abs(room):
                    reach, hit = room / step[i], i
            for i in range(count):
                u[free[i]] += reach * step[i]
        if hit >= 0:
            k = free[hit]
            held[k] = 1 if step[hit] > 0.0 else -1
            u[k] = held[k] * bound
            continue
        # At the least of these bounds: the one that holds most against the slope is let go.
        slope = hessian @ u + linear
        worst, release = 1e-9, -1
        for i in range(n):
            if held[i] * slope[i] > worst:
                worst, release = held[i] * slope[i], i
        if release < 0:
            break
        held[release] = 0


def settings(law):
    """Every point of a law's grid."""
    return [dict(zip(law.GRID, values)) for values in itertools.product(*law.GRID.values())]
