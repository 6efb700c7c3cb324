"""The law of LateralPid (eq 14) once more, compiled, for tuning on the vehicle.

Only what tuning needs: constant gains, enabled, no feedforward, no wrapping. Each run holds it
against the packed FMU (`study.check_law`). Gains: kp, ki 1/s, kd s, filter time s, setpoint weight b,
anti-windup time s; limits: angle rad, increment a tick rad.
"""

import math
from functools import lru_cache

import numba
import numpy as np
import vehicle
from excitation import SAMPLE_TIME_S
from vehicle import STEPS, advance


@numba.njit
def respond(state, speed, p, gains, limits, height, count):
    """Yaw and command at `count` samples of a yaw step on the car."""
    kp, ki, kd, filter_time, weight, anti_windup = gains
    angle, increment = limits
    ts = SAMPLE_TIME_S
    yaw, command = np.zeros(count), np.zeros(count)
    integral, derivative, before, u = 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        y = state[vehicle.YAW]
        error = height - y
        if k == 0:
            integral = ki * ts * error - kp * (1.0 - weight) * error
            before = y
        else:
            integral += ki * ts * error
        derivative = (filter_time * derivative - kd * (y - before)) / (filter_time + ts)
        before = y
        wanted = kp * error + derivative + integral
        u = max(-angle, min(angle, max(u - increment, min(u + increment, wanted))))
        integral += min(ts / anti_windup, 1.0) * (u - wanted)
        yaw[k], command[k] = y, u
        advance(state, u, speed, p, STEPS)
    return yaw, command


def compile_all(car):
    """Compiles what drives the car, before processes are forked which would each do it."""
    state = car.at_start(10.0)
    vehicle.rates(state, 0.0, 10.0, car.parameters)
    gains, limits = (1.0, 1.0, 0.0, 0.01, 1.0, 1.0), (1.0, 1.0)
    respond(state, 10.0, car.parameters, gains, limits, 0.0, 1)


def frequency_response(gains, z):
    """Command per yaw error at z = exp(jωTs), of the feedback."""
    kp, ki, kd, filter_time, _, _ = gains
    ts = SAMPLE_TIME_S
    integral = ki * ts / (1.0 - 1.0 / z)
    derivative = kd * (1.0 - 1.0 / z) / (filter_time + ts - filter_time / z)
    return kp + integral + derivative


def small_step(car, speed):
    """Increments of yaw a sample per steering, after a small step of the command, 0.5 m/s², that
    stays below the servo's rate limit."""
    wheelbase = car.published.a + car.published.b
    size = min(
        0.5 * wheelbase / speed**2,
        0.9 * vehicle.SERVO_RATE_LIMIT_RADPS * vehicle.SERVO_TIME_CONSTANT_S,
    )
    command = np.full(round(4.0 / SAMPLE_TIME_S), size)
    return np.diff(car.drive(command, speed)[:, vehicle.YAW]) / size


def steady_gain(car, speed):
    """Yaw rate per steering in a steady turn, 1/s."""
    return float(np.mean(small_step(car, speed)[-100:])) / SAMPLE_TIME_S


@lru_cache
def sampled_yaw(car, speed):
    """Frequencies, rad/s, and the car's own response from command to yaw there, sampled and held."""
    increments = small_step(car, speed)
    impulse = np.diff(increments, prepend=0.0)
    omega = np.geomspace(0.5, math.pi / SAMPLE_TIME_S, 400)
    z = np.exp(1j * omega * SAMPLE_TIME_S)
    powers = z[:, None] ** -(1.0 + np.arange(len(impulse)))
    return omega, (powers @ impulse) / (1.0 - 1.0 / z)


def modulus_margin(gains, omega, yaw):
    """Smallest distance of the loop from −1; 0 for an unstable loop, which may be far from it.

    Nyquist: with both integrators on the circle and all other poles within, 1 + L of a stable loop
    comes from −180° to 0° without a turn about the origin.
    """
    controller = frequency_response(gains, np.exp(1j * omega * SAMPLE_TIME_S))
    difference = 1.0 + controller * yaw
    if abs(np.unwrap(np.angle(difference))[-1]) > 0.5 * math.pi:
        return 0.0
    return float(np.min(np.abs(difference)))


def scaled(gains, factor):
    """kp, ki and kd times a factor."""
    return (*(factor * gain for gain in gains[:3]), *gains[3:])


def factor_to_margin(gains, omega, yaw, wanted):
    """The factor of the gains at which the loop comes to have a modulus margin; `None` if none does.

    Found in small steps from the gains as they are, up while they have more and down while they
    have less, since beyond instability the distance from −1 grows again.
    """

    def keeps(factor):
        return modulus_margin(scaled(gains, factor), omega, yaw) >= wanted

    enough = keeps(1.0)
    step = 1.02 if enough else 1.0 / 1.02
    here = 1.0
    for _ in range(200):
        there = here * step
        if keeps(there) != enough:
            break
        here = there
    else:
        return None
    low, high = min(here, there), max(here, there)
    for _ in range(30):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if keeps(middle) else (low, middle)
    return float(low)
