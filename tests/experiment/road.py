"""The car on the road: PoseEstimator, ReferencePath and LateralPid as packed FMUs under fmpy.

Each sample: sensors, estimator, path, controller, in this order (Gauss–Seidel, no loop delay), then
the car moves on with the command held. A second ReferencePath, fed with the true pose, judges.
"""

import math
from dataclasses import dataclass

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
TRACED = ("time", "cross_track", "course", "yaw", "position", "command", "curvature")
OFF_ROAD_M = 20.0  # then the run is over: lost


@dataclass
class Loop:
    """The archives that steer."""

    estimator: object  # None: the true pose
    path: object
    pid: object

    def remove(self):
        for archive in (self.estimator, self.path, self.pid):
            if archive is not None:
                archive.remove()


class Estimator:
    """A PoseEstimator fed by the sensors."""

    def __init__(self, archive, sensors, state, sideslip):
        self.deviation = sensors.gnss.deviation_m
        self.unit = Unit(archive, "PoseEstimator")
        self.unit.set(
            gnss_latency=LATENCY_S,
            antenna_x=ANTENNA_M[0],
            antenna_y=ANTENNA_M[1],
            sideslip_per_yaw_rate=sideslip,
            initial_x=state[vehicle.X],
            initial_y=state[vehicle.Y],
            initial_yaw=state[vehicle.YAW] + sensors.initial_yaw,
            initial_yaw_std=INITIAL_YAW_STD_RAD,
        )
        self.unit.initialize()

    def pose(self, k, reading, _state):
        self.unit.set(
            gnss_x=reading.gnss_x,
            gnss_y=reading.gnss_y,
            gnss_std=self.deviation,
            gnss_fix_count=reading.fixes,
            yaw_rate=reading.gyro,
            speed=reading.speed,
        )
        tick(self.unit, k)
        return self.unit.get("x", "y", "yaw")

    def close(self):
        self.unit.close()


class Truth:
    """Instead of an estimator."""

    def pose(self, _k, _reading, state):
        return state[vehicle.X], state[vehicle.Y], state[vehicle.YAW]

    def close(self):
        pass


def tick(unit, k):
    """What is read at sample k counts there."""
    if k > 0:
        unit.step((k - 1) * SAMPLE_TIME_S, SAMPLE_TIME_S)


def guide(archive, name, speed, sideslip):
    unit = Unit(archive, name)
    unit.set(sideslip_per_yaw_rate=sideslip, speed=speed)
    unit.initialize()
    return unit


def follow(car, speed, loop, sensors, start, sideslip, length):
    """Drives the road to its end; returns rows of [`TRACED`], one a sample, and whether it got there.

    For [`LEAD_IN_S`] before, the car rolls straight towards the road's start, not steered, while the
    estimator finds its yaw and the gyro's bias.
    """
    state, p = before_the_road(car, speed, start), car.parameters
    estimator = Estimator(loop.estimator, sensors, state, sideslip) if loop.estimator else Truth()
    for k in range(LEAD_IN):
        estimator.pose(k, sensors.read(k, state), state)
        advance(state, 0.0, speed, p, STEPS)

    path, judge = (guide(loop.path, name, speed, sideslip) for name in ("path", "judge"))
    pid = Unit(loop.pid, "LateralPid")
    pid.initialize()
    rows, finished = [], False
    for k in range(round((length / speed + MARGIN_S) / SAMPLE_TIME_S)):
        reading = sensors.read(LEAD_IN + k, state)
        x, y, yaw = estimator.pose(LEAD_IN + k, reading, state)
        path.set(x=x, y=y, yaw=yaw, speed=reading.speed)
        tick(path, k)
        reference, feedforward = path.get("yaw_reference", "steering_feedforward")
        pid.set(yaw_reference=reference, yaw=yaw, steering_feedforward=feedforward)
        tick(pid, k)
        command = pid.get("steering_angle")[0]

        judged = judgement(judge, k, state, speed)
        off = (yaw - state[vehicle.YAW], x - state[vehicle.X], y - state[vehicle.Y])
        cross_track, course, curvature, distance = judged
        errors = (cross_track, course, math.remainder(off[0], math.tau), math.hypot(*off[1:]))
        rows.append((k * SAMPLE_TIME_S, *errors, command, curvature))
        finished = distance >= length - END_M
        if finished or abs(cross_track) > OFF_ROAD_M or not math.isfinite(command):
            break
        advance(state, command, speed, p, STEPS)
        if not np.all(np.isfinite(state)):
            break
    for unit in (estimator, path, judge, pid):
        unit.close()
    return np.array(rows), finished


def before_the_road(car, speed, start):
    """The pose from which the car, not steered, comes to the road's start along the road."""
    end = start.copy()
    vehicle.drive(end, np.zeros(LEAD_IN), speed, car.parameters, STEPS)
    # A car on flat ground does the same wherever it is and heads.
    yaw = start[vehicle.YAW] - end[vehicle.YAW]
    x, y = (start[i] - end[i] for i in (vehicle.X, vehicle.Y))
    state = start.copy()
    state[vehicle.YAW] = yaw
    state[vehicle.X] = x * math.cos(yaw) - y * math.sin(yaw)
    state[vehicle.Y] = x * math.sin(yaw) + y * math.cos(yaw)
    return state


def judgement(judge, k, state, speed):
    """True cross-track error, course error, the road's curvature and distance along it."""
    judge.set(x=state[vehicle.X], y=state[vehicle.Y], yaw=state[vehicle.YAW], speed=speed)
    tick(judge, k)
    names = ("cross_track_error", "heading_error", "curvature", "distance")
    cross_track, heading, curvature, distance = judge.get(*names)
    sideslip = math.atan2(state[vehicle.LATERAL_VELOCITY], state[vehicle.SPEED])
    return cross_track, math.remainder(heading + sideslip, math.tau), curvature, distance
