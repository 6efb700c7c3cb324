"""The law of LateralPid (eq 14) once more, compiled, for tuning on the vehicle.

Only what tuning needs: constant gains, enabled, no feedforward. Each run holds it against the packed FMU
(`study.check_law`). Gains: kp, ki 1/s, kd s, filter time s, setpoint weight b, anti-windup time s; limits: angle
at that speed rad, increment a tick rad, yaw rate of the lateral acceleration allowed rad/s, yaw rate per
steering 1/s, and of large errors: yaw error acted on at once rad, sustained rate rad/s, reserve of time at the
largest rate s, lag of the yaw rate s.
"""

import math
from functools import lru_cache

import numba
import numpy as np
import vehicle
from excitation import SAMPLE_TIME_S
from vehicle import STEPS, advance

MEMORY = 19  # numbers that a controller remembers
# As in fmu/models/src/pid/governor.rs and actuator.rs.
RELEASE_SHARE, RATE_SHARE, ROOM = 0.7, 0.5, 1.2
RATE_FILTER, FULL_RATE, FORGOTTEN, QUICKER = 0.05, 0.9, 0.1, 0.3
FILTER, NOTICED_AFTER, UNCERTAIN, NOTICED, LARGEST = 0.05, 0.2, 0.2, 0.05, 2.0


@numba.njit
def wrapped(angle):
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@numba.njit
def within(value, bound):
    return max(-bound, min(bound, value))


@numba.njit
def reduction(total):
    """How far the rate is reduced, by the sum."""
    return max(0.0, (total - NOTICED) / (1.0 - NOTICED))


@numba.njit
def watch(watched, limits, sent, change):
    """What a slow actuator is noticed by, in place: angles, yaw rates expected and the same filtered, each of the
    actuator with the present rate and the slow one, the yaw rate filtered, and the sum."""
    _, increment, _, gain, _, sustained, _, yaw_rate_lag = limits
    ts = SAMPLE_TIME_S
    present = increment - reduction(watched[7]) * max(increment - sustained * ts, 0.0)
    for i, reach in enumerate((present, sustained * ts)):
        watched[i] += within(sent - watched[i], reach)
        watched[2 + i] += ts / (yaw_rate_lag + ts) * (gain * watched[i] - watched[2 + i])
        watched[4 + i] += ts / (FILTER + ts) * (watched[2 + i] - watched[4 + i])
    watched[6] += ts / (FILTER + ts) * (change / ts - watched[6])
    difference = watched[5] - watched[4]
    square = difference * difference
    evidence = within((watched[6] - watched[4]) * difference, LARGEST * square) - UNCERTAIN * square
    ramp = gain * (increment / ts - sustained) * NOTICED_AFTER
    noticed = evidence / (ramp * ramp * NOTICED_AFTER / 3.0) if ramp != 0.0 else 0.0
    watched[7] = min(1.0, max(0.0, watched[7] + ts * (noticed - FORGOTTEN * watched[7])))


@numba.njit
def tick(memory, gains, limits, reference, y):
    """One sample; `memory` is integral, derivative, yaw, command, reference, whether there was a sample
    before; what is withheld of the error, the rate of its release, the rate of the reference, that of the
    steering, and the time at the largest rate; and what [`watch`] remembers."""
    kp, ki, kd, filter_time, weight, anti_windup = gains
    angle, increment, fastest, gain, largest, sustained, reserve, yaw_rate_lag = limits
    ts, unweighted = SAMPLE_TIME_S, kp * (1.0 - weight)
    integral, derivative, before, u, reference_before, later = memory[:6]
    withheld_before, release, reference_rate, steering_rate, spent = memory[6:11]
    moved = wrapped(reference - reference_before) if later else 0.0
    whole = wrapped(reference - y)
    withheld, slow = withheld_before, 0.0
    if largest < math.pi:
        if later and yaw_rate_lag > 0.0:
            watch(memory[11:], limits, u, wrapped(y - before))
        slow = reduction(memory[18])
        followed = min(largest, ROOM * sustained / (kp * weight * kp * gain + ki))
        largest -= slow * (largest - followed)
        increment -= slow * max(increment - sustained * ts, 0.0)
        lag = max(0.0, unweighted / ki) if ki > 0.0 else 0.0
        released = 0.0
        if withheld == 0.0:
            release = 0.0
        else:
            rate = RELEASE_SHARE * fastest
            acceleration = min(RATE_SHARE * sustained * gain, rate / max(lag, ts))
            wanted = min(rate, math.sqrt(2.0 * acceleration * abs(withheld)))
            wanted = math.copysign(wanted, withheld)
            release += within(wanted - release, acceleration * ts)
            released = max(min(release * ts, max(withheld, 0.0)), min(withheld, 0.0))
            withheld -= released
        if later:
            seen = within(moved / ts, fastest) + released / ts
            reference_rate += ts / (lag + ts) * (seen - reference_rate)
        beyond = whole - withheld - lag * reference_rate
        withheld += beyond - within(beyond, largest)
        if withheld > 0.0:
            withheld = min(withheld, max(whole, 0.0))
        else:
            withheld = max(withheld, min(whole, 0.0))
    error = whole - withheld
    if later:
        seen = wrapped(moved - (withheld - withheld_before))
        integral += ki * ts * error - unweighted * seen
        derivative = (filter_time * derivative - kd * wrapped(y - before)) / (filter_time + ts)
    else:
        integral = ki * ts * error - unweighted * error
    wanted = kp * error + derivative + integral
    command = within(max(u - increment, min(u + increment, wanted)), angle)
    if largest < math.pi:
        steering_rate += ts / (RATE_FILTER + ts) * ((command - u) / ts - steering_rate)
        spent += ts if abs(steering_rate) * ts > FULL_RATE * increment else -FORGOTTEN * ts
        spent = max(0.0, min(spent, 2.0 * reserve))
        if spent > reserve or slow > 0.0:
            anti_windup *= 1.0 - (1.0 - QUICKER) * min(max(spent / reserve - 1.0, slow), 1.0)
    integral += min(ts / anti_windup, 1.0) * (command - wanted)
    memory[:6] = (integral, derivative, y, command, reference, 1.0)
    memory[6:11] = (withheld, release, reference_rate, steering_rate, spent)
    return command


@numba.njit
def respond(state, speed, p, gains, limits, height, count):
    """Yaw and command at `count` samples of a yaw step on the car."""
    yaw, command, memory = np.zeros(count), np.zeros(count), np.zeros(MEMORY)
    for k in range(count):
        yaw[k] = state[vehicle.YAW]
        command[k] = tick(memory, gains, limits, height, yaw[k])
        advance(state, command[k], speed, p, STEPS)
    return yaw, command


def compile_all(car):
    """Compiles what drives the car, before processes are forked which would each do it."""
    state = car.at_start(10.0)
    vehicle.rates(state, 0.0, 10.0, car.parameters)
    gains, limits = (1.0, 1.0, 0.0, 0.01, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0, math.pi, 1.0, 1.0, 0.0)
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
