"""A car of the experiment: the multi-body vehicle behind a steering servo, at a held speed.

Servo: dδ/dt = (command − δ)/T with |dδ/dt| ≤ limit. Speed hold: acceleration = 2/s · (v0 − v).
Both as in examples/drives/multibody. Integration is the classical Runge–Kutta method of order four, the
command held for a sample.

States: x, y m; road-wheel angle rad; v_x m/s; yaw rad; yaw rate rad/s; … (29, see
`vehicle_dynamics_mb`). ISO 8855: yaw and steering positive to the left.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import compiled
import numba
import numpy as np
from excitation import SAMPLE_TIME_S
from vehiclemodels.init_mb import init_mb
from vehiclemodels.vehicle_parameters import setup_vehicle_parameters

STEPS = 5  # of the integration in a sample; twice as many change the yaw rate by 1e-5 rad/s rms
SETTLING_S = 4.0  # the suspension finds its rest before anything starts

SPEED_HOLD_PER_S = 2.0  # acceleration per speed error
SERVO_TIME_CONSTANT_S = 0.05
SERVO_RATE_LIMIT_RADPS = 0.4

# Places in the state vector.
X, Y, STEER, SPEED, YAW, YAW_RATE, LATERAL_VELOCITY = 0, 1, 2, 3, 4, 5, 10
# Vanish by symmetry where the car drives straight; the position starts at the origin.
ZERO_AT_START = (X, Y, STEER, YAW, YAW_RATE, 6, 7, 10, 13, 14, 15, 18, 19, 20, 27, 28)

NAMES = {1: "Ford Escort", 2: "BMW 320i", 3: "VW Vanagon"}


@lru_cache
def published_parameters(number, friction=1.0, mass=1.0):
    """Of a car on a road with a share of the friction at which its tyres were measured: what they carry at most is
    less, their stiffness is the same. The body has what changes the mass to its share, spread like the body."""
    found = setup_vehicle_parameters(vehicle_id=number)
    found.tire.p_dx1 *= friction
    found.tire.p_dy1 *= friction
    load = (mass - 1.0) * found.m
    share = 1.0 + load / found.m_s
    found.m, found.m_s = found.m + load, found.m_s + load
    for name in ("I_z", "I_Phi_s", "I_y_s", "I_xz_s"):
        setattr(found, name, share * getattr(found, name))
    return found


@lru_cache
def parameters(number, friction=1.0, mass=1.0):
    return compiled.values(published_parameters(number, friction, mass))


vehicle_dynamics = compiled.vehicle_dynamics()
# The same for every car, since all have the same fields.
unpack = compiled.unpacking(published_parameters(1))


@numba.njit
def rate(state, command, speed, p, out, servo_rate=SERVO_RATE_LIMIT_RADPS):
    """Of the car's 29 states, with servo and speed hold."""
    wanted = (command - state[STEER]) / SERVO_TIME_CONSTANT_S
    steering_rate = max(-servo_rate, min(servo_rate, wanted))
    acceleration = SPEED_HOLD_PER_S * (speed - state[SPEED])
    found = vehicle_dynamics(state, [steering_rate, acceleration], p)
    for i in range(len(out)):
        out[i] = found[i]


@numba.njit
def rates(state, command, speed, values):
    """[`rate`] for those who have but the values."""
    out = np.empty(len(state))
    rate(state, command, speed, unpack(values), out)
    return out


@numba.njit
def advance(state, command, speed, values, steps, servo_rate=SERVO_RATE_LIMIT_RADPS):
    """A sample further, in place; whether all states are numbers still."""
    p = unpack(values)
    h = SAMPLE_TIME_S / steps
    n = len(state)
    k1, k2, k3, k4 = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    known = True
    for _ in range(steps):
        rate(state, command, speed, p, k1, servo_rate)
        rate(state + h / 2 * k1, command, speed, p, k2, servo_rate)
        rate(state + h / 2 * k2, command, speed, p, k3, servo_rate)
        rate(state + h * k3, command, speed, p, k4, servo_rate)
        for i in range(n):
            state[i] = state[i] + h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
    for i in range(n):
        known = known and math.isfinite(state[i])
    return known


@numba.njit
def drive(state, command, speed, values, steps):
    """States at the samples, each before its command acts."""
    states = np.empty((len(command), len(state)))
    for k in range(len(command)):
        for i in range(len(state)):  # a slice would take seconds to compile
            states[k, i] = state[i]
        advance(state, command[k], speed, values, steps)
    return states


@lru_cache
def at_start(number, speed, friction=1.0, mass=1.0):
    published = published_parameters(number, friction, mass)
    state = np.array(init_mb([0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0], published), dtype=float)
    none = np.zeros(round(SETTLING_S / SAMPLE_TIME_S))
    drive(state, none, speed, parameters(number, friction, mass), STEPS)
    state[list(ZERO_AT_START)] = 0.0
    return state


@dataclass(frozen=True)
class Car:
    """One of the published parameter sets."""

    number: int
    friction: float = 1.0
    mass: float = 1.0

    @property
    def published(self):
        return published_parameters(self.number, self.friction, self.mass)

    @property
    def parameters(self):
        return parameters(self.number, self.friction, self.mass)

    def at_start(self, speed):
        """Straight ahead, wheels spinning, the suspension at rest."""
        return at_start(self.number, speed, self.friction, self.mass).copy()

    def drive(self, command, speed):
        """States at the samples of a steering command."""
        return drive(self.at_start(speed), command, speed, self.parameters, STEPS)

    def lateral_acceleration(self, states, command, speed):
        """Of the body: dv_y/dt + r v_x."""
        p, found = self.parameters, np.empty(len(states))
        for k, state in enumerate(states):
            changing = rates(state, command[k], speed, p)[LATERAL_VELOCITY]
            found[k] = changing + state[YAW_RATE] * state[SPEED]
        return found

