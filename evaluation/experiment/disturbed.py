"""The car of [`vehicle`] with play between servo and road wheels, on a banked road, in a crosswind.

The servo has its own angle here; the wheels follow it at the edges of the play. Bank is an acceleration of all
bodies to the left, wind a force on the sprung body at an arm ahead of the centre of gravity.
"""

import math

import numba
import numpy as np
from excitation import SAMPLE_TIME_S
from vehicle import LATERAL_VELOCITY, SERVO_TIME_CONSTANT_S, SPEED, SPEED_HOLD_PER_S, STEER, YAW_RATE
from vehicle import unpack, vehicle_dynamics

AXLE_LATERAL_VELOCITIES = (15, 20)
AIR_KGPM3, SIDE_M2, SIDE_FORCE_PER_RAD, ARM_M = 1.2, 2.2, 2.0, 0.3
GRAVITY_MPS2 = 9.81


@numba.njit
def rate(state, steering_rate, speed, p, out, bank, force, moment):
    """Of the 29 states; acceleration of the bank in m/s2, force and moment of the wind in N and N m."""
    acceleration = SPEED_HOLD_PER_S * (speed - state[SPEED])
    found = vehicle_dynamics(state, [steering_rate, acceleration], p)
    for i in range(len(out)):
        out[i] = found[i]
    out[YAW_RATE] += moment / p.I_z
    out[LATERAL_VELOCITY] += force / p.m_s + bank
    for i in AXLE_LATERAL_VELOCITIES:
        out[i] += bank


@numba.njit
def side_wind(speed, wind):
    """Force to the left, N, of a wind from the right, m/s: a share of the dynamic pressure by the angle of the air."""
    pressure = 0.5 * AIR_KGPM3 * (speed * speed + wind * wind)
    return pressure * SIDE_M2 * SIDE_FORCE_PER_RAD * math.atan2(wind, max(speed, 1.0))


@numba.njit
def advance(state, servo, command, speed, values, steps, servo_rate, play, bank, wind):
    """A sample further, state in place; the servo's angle then, and whether all states are numbers still."""
    p = unpack(values)
    h, n = SAMPLE_TIME_S / steps, len(state)
    k1, k2, k3, k4 = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    towards = 1.0 - math.exp(-h / SERVO_TIME_CONSTANT_S)
    for _ in range(steps):
        servo += max(-servo_rate * h, min(servo_rate * h, towards * (command - servo)))
        wheel = max(servo - 0.5 * play, min(servo + 0.5 * play, state[STEER]))
        turning = (wheel - state[STEER]) / h
        force = side_wind(state[SPEED], wind)
        moment = ARM_M * force
        rate(state, turning, speed, p, k1, bank, force, moment)
        rate(state + h / 2 * k1, turning, speed, p, k2, bank, force, moment)
        rate(state + h / 2 * k2, turning, speed, p, k3, bank, force, moment)
        rate(state + h * k3, turning, speed, p, k4, bank, force, moment)
        for i in range(n):
            state[i] = state[i] + h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
    known = True
    for i in range(n):
        known = known and math.isfinite(state[i])
    return servo, known
