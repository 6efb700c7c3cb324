"""The car on the road: PoseEstimator, ReferencePath and LateralPid as packed FMUs under fmpy.

Each sample: sensors, estimator, path, controller, in this order (Gauss–Seidel, no loop delay), then
the car moves on with the command held. A second ReferencePath, fed with the true pose, evaluates.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import vehicle
from excitation import SAMPLE_TIME_S
from sensors import ANTENNA_M, INITIAL_YAW_STD_RAD, LATENCY_S
from units import Unit
from vehicle import STEPS, advance

LEAD_IN_S = 10.0
LEAD_IN = round(LEAD_IN_S / SAMPLE_TIME_S)
MARGIN_S = 2.0  # what the car may take longer than the road's length at its speed
END_M = 0.5  # so near to the road's end it is reached
TRACED = ("time", "cross_track", "course", "yaw", "position", "command", "curvature", "x", "y")
OFF_ROAD_M = 20.0  # then the run is over: lost
# The terms of the sideslip that the estimator uses.
ESTIMATED = (
    "sideslip_per_yaw_rate",
    "sideslip_growth",
    "sideslip_per_yaw_acceleration",
    "sideslip_reference_speed",
    "distance_rear",
)


@dataclass
class Loop:
    """The archives that steer."""

    estimator: object  # None: the true pose
    path: object
    pid: object


class Estimator:
    """A PoseEstimator fed by the sensors."""

    def __init__(self, archive, sensors, state, sideslip, latency_s=LATENCY_S):
        self.unit = Unit(archive, "PoseEstimator")
        self.unit.set(
            gnss_latency=latency_s,
            antenna_x=ANTENNA_M[0],
            antenna_y=ANTENNA_M[1],
            initial_x=state[vehicle.X],
            initial_y=state[vehicle.Y],
            initial_yaw=state[vehicle.YAW] + sensors.initial_yaw,
            initial_yaw_std=INITIAL_YAW_STD_RAD,
            gnss_std=sensors.gnss.deviation_m,
            **{name: sideslip[name] for name in ESTIMATED if name in sideslip},
        )
        self.unit.initialize()
        self.measure = self.unit.writer("gnss_x", "gnss_y", "yaw_rate", "speed")
        self.count = self.unit.writer("gnss_fix_count")
        self.read = self.unit.reader("x", "y", "yaw", "sideslip_per_yaw_rate_offset")

    def pose(self, k, reading, _state):
        self.measure(reading.gnss_x, reading.gnss_y, reading.gyro, reading.speed)
        self.count(reading.fixes)
        tick(self.unit, k)
        return self.read()

    def close(self):
        self.unit.close()


class Truth:
    """Instead of an estimator."""

    def pose(self, _k, _reading, state):
        return state[vehicle.X], state[vehicle.Y], state[vehicle.YAW], 0.0

    def close(self):
        pass


def tick(unit, k):
    """What is read at sample k counts there."""
    if k > 0:
        unit.step((k - 1) * SAMPLE_TIME_S, SAMPLE_TIME_S)


def guide(archive, name, speed, sideslip):
    unit = Unit(archive, name)
    unit.set(speed=speed, **sideslip)
    unit.initialize()
    return unit


class Steering:
    """ReferencePath and LateralPid: pose and speed in, command out."""

    def __init__(self, path, pid, speed, sideslip):
        self.path, self.pid = guide(path, "path", speed, sideslip), Unit(pid, "LateralPid")
        self.pid.set(speed=speed)
        self.pid.initialize()
        self.locate = self.path.writer("x", "y", "yaw", "sideslip_per_yaw_rate_offset", "speed")
        self.ask = self.path.reader("yaw_reference", "steering_feedforward")
        self.refer = self.pid.writer("yaw_reference", "yaw", "steering_feedforward", "speed")
        self.steer = self.pid.reader("steering_angle")

    def command(self, k, pose, speed):
        """The command for the pose of an estimator."""
        self.locate(*pose, speed)
        tick(self.path, k)
        reference, feedforward = self.ask()
        self.refer(reference, pose[2], feedforward, speed)
        tick(self.pid, k)
        return self.steer()[0]

    def close(self):
        self.path.close()
        self.pid.close()


def follow(car, speed, loop, sensors, sideslip, length, servo=vehicle.SERVO_RATE_LIMIT_RADPS):
    """Drives the road to its end; returns rows of [`TRACED`], one a sample, and whether it got there.

    For [`LEAD_IN_S`] before, the car rolls straight towards the road's start, not steered, while the
    estimator finds its yaw and the gyro's bias.
    """
    before, p = lead_in(car, speed), car.parameters
    state = before[0]
    estimator = Estimator(loop.estimator, sensors, state, sideslip) if loop.estimator else Truth()
    for k in range(LEAD_IN):
        estimator.pose(k, sensors.read(k, before[k]), before[k])
    state = before[LEAD_IN].copy()

    steering = Steering(loop.path, loop.pid, speed, sideslip)
    truth = guide(loop.path, "truth", speed, sideslip)
    evaluate = Evaluation(truth, speed)
    rows, finished = [], False
    for k in range(round((length / speed + MARGIN_S) / SAMPLE_TIME_S)):
        reading = sensors.read(LEAD_IN + k, state)
        pose = estimator.pose(LEAD_IN + k, reading, state)
        x, y, yaw, _ = pose
        command = steering.command(k, pose, reading.speed)

        off = (yaw - state[vehicle.YAW], x - state[vehicle.X], y - state[vehicle.Y])
        cross_track, course, curvature, distance = evaluate(k, state)
        errors = (cross_track, course, math.remainder(off[0], math.tau), math.hypot(*off[1:]))
        place = (state[vehicle.X], state[vehicle.Y])
        rows.append((k * SAMPLE_TIME_S, *errors, command, curvature, *place))
        finished = distance >= length - END_M
        if finished or abs(cross_track) > OFF_ROAD_M or not math.isfinite(command):
            break
        if not advance(state, command, speed, p, STEPS, servo):
            break
    for part in (estimator, steering, truth):
        part.close()
    return np.array(rows), finished


@lru_cache
def lead_in(car, speed):
    """States of the car which, not steered, comes to the road's start along the road; the last is
    there."""
    start, none = car.at_start(speed), np.zeros(LEAD_IN)
    end = start.copy()
    vehicle.drive(end, none, speed, car.parameters, STEPS)
    # A car on flat ground does the same wherever it is and heads.
    yaw = start[vehicle.YAW] - end[vehicle.YAW]
    x, y = (start[i] - end[i] for i in (vehicle.X, vehicle.Y))
    state = start.copy()
    state[vehicle.YAW] = yaw
    state[vehicle.X] = x * math.cos(yaw) - y * math.sin(yaw)
    state[vehicle.Y] = x * math.sin(yaw) + y * math.cos(yaw)
    states = vehicle.drive(state, none, speed, car.parameters, STEPS)
    return np.vstack([states, state])


class Evaluation:
    """True cross-track error, course error, the road's curvature and distance along it."""

    def __init__(self, unit, speed):
        self.unit, self.speed = unit, speed
        self.locate = unit.writer("x", "y", "yaw", "speed")
        self.read = unit.reader("cross_track_error", "heading_error", "curvature", "distance")

    def __call__(self, k, state):
        self.locate(state[vehicle.X], state[vehicle.Y], state[vehicle.YAW], self.speed)
        tick(self.unit, k)
        cross_track, heading, curvature, distance = self.read()
        sideslip = math.atan2(state[vehicle.LATERAL_VELOCITY], state[vehicle.SPEED])
        return cross_track, math.remainder(heading + sideslip, math.tau), curvature, distance
