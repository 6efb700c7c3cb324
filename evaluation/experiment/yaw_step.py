"""The yaw step of 5° on the vehicle itself, steered by a packed LateralPid; and what it reaches."""

import math
from dataclasses import asdict, dataclass

import numpy as np
import vehicle
from excitation import SAMPLE_TIME_S
from units import Unit
from vehicle import STEPS, advance

STEP_RAD = math.radians(5.0)
SERVO = vehicle.SERVO_RATE_LIMIT_RADPS
BAND = 0.02  # of the step: the settling band
DURATION_S = 5.0  # the steady-state error is read there
LOST = 10.0  # yaw over the step of a car whose model knows no way on


@dataclass
class Metrics:
    """Settling is read between samples; `None` for never within the time."""

    overshoot_percent: float
    settling_time_s: float | None
    steady_state_error_percent: float
    rise_time_s: float | None
    largest_angle_rad: float

    def as_dict(self):
        return asdict(self)


def respond(car, speed, controller, start, duration=DURATION_S, height=STEP_RAD, servo=SERVO):
    """Yaw and command at the samples; the reference steps at time 0.

    `controller` is the archive of a LateralPid, ticking at the samples; `servo` the largest rate of the
    servo, rad/s.
    """
    pid = Unit(controller, "LateralPid")
    pid.set(yaw_reference=height, yaw=0.0, speed=speed)
    pid.initialize()
    measure, read = pid.writer("yaw_reference", "yaw"), pid.reader("steering_angle")
    state, p = start.copy(), car.parameters
    count = round(duration / SAMPLE_TIME_S)
    yaw, command = np.zeros(count + 1), np.zeros(count + 1)
    for k in range(count + 1):
        yaw[k] = state[vehicle.YAW]
        measure(height, yaw[k])
        if k > 0:
            # Tick k sees what is measured at its instant.
            pid.step((k - 1) * SAMPLE_TIME_S, SAMPLE_TIME_S)
        (command[k],) = read()
        if not advance(state, command[k], speed, p, STEPS, servo):
            yaw[k + 1 :], command[k + 1 :] = LOST * height, command[k]
            break
    pid.close()
    return yaw, command


def metrics(yaw, command, height=STEP_RAD):
    """Of a response sampled each 10 ms."""
    # A comparison with what is no number is false: it would count as settled.
    y = np.where(np.isfinite(yaw), yaw / height, LOST)
    last = len(y) - 1

    def crossing(k, level):
        """Between samples k and k + 1, s."""
        part = (level - y[k]) / (y[k + 1] - y[k]) if y[k + 1] != y[k] else 0.0
        return float((k + min(max(part, 0.0), 1.0)) * SAMPLE_TIME_S)

    outside = np.flatnonzero(np.abs(y - 1.0) > BAND)
    settling = 0.0
    if len(outside):
        k = int(outside[-1])
        settling = None if k == last else crossing(k, 1.0 + math.copysign(BAND, y[k] - 1.0))

    def first(level):
        above = np.flatnonzero(y >= level)
        return crossing(int(above[0]) - 1, level) if len(above) and above[0] > 0 else None

    low, high = first(0.1), first(0.9)
    return Metrics(
        overshoot_percent=float(max(0.0, 100.0 * (y.max() - 1.0))),
        settling_time_s=settling,
        steady_state_error_percent=float(100.0 * abs(1.0 - y[last])),
        rise_time_s=None if low is None or high is None else high - low,
        largest_angle_rad=float(np.max(np.abs(command))),
    )
