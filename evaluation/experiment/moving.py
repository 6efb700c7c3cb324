"""The car of [`vehicle`] with both of its inputs, from standstill: a steering servo, and an actuator of the acceleration.

The actuator delays the command by whole samples and follows it with a lag. Brakes do not push: at standstill the car
stays where the acceleration is not above 0.

The published model is that of a rolling car above 0.1 m/s. Below, its own equations are kinematic, but its tyres carry
nothing there: its wheels would spin up and its yaw rate would grow. There wheels, yaw rate and lateral velocities are those of
the same kinematic car. The slip of a tyre settles within a time that falls with the speed, and so does the step of the
integration.
"""

import math
from dataclasses import dataclass

import numba
import numpy as np
import vehicle
from excitation import SAMPLE_TIME_S
from vehicle import SPEED, STEER, YAW_RATE

ACTUATOR_DELAY_S, ACTUATOR_LAG_S = 0.12, 0.25
DELAY = round(ACTUATOR_DELAY_S / SAMPLE_TIME_S)
KINEMATIC_MPS = 0.1
LONGEST_STEP_S, STEP_PER_SPEED_S2PM = 0.002, 1.5e-4
FRONT_LATERAL, REAR_LATERAL, WHEELS = 15, 20, (23, 24, 25, 26)


@numba.njit
def rolling(state, p):
    """The states of a kinematic car, in place."""
    speed, angle = max(state[SPEED], 0.0), state[STEER]
    slip = math.atan(math.tan(angle) * p.b / (p.a + p.b))
    rate = speed * math.cos(slip) * math.tan(angle) / (p.a + p.b)
    lateral = speed * math.tan(slip)
    state[SPEED], state[YAW_RATE], state[vehicle.LATERAL_VELOCITY] = speed, rate, lateral
    state[FRONT_LATERAL], state[REAR_LATERAL] = lateral + p.a * rate, lateral - p.b * rate
    for wheel in WHEELS:
        state[wheel] = speed / p.R_w


@numba.njit
def derivative(state, command, acceleration, p, out, servo_rate):
    wanted = (command - state[STEER]) / vehicle.SERVO_TIME_CONSTANT_S
    found = vehicle.vehicle_dynamics(state, [max(-servo_rate, min(servo_rate, wanted)), acceleration], p)
    for i in range(len(out)):
        out[i] = found[i]


@numba.njit
def advance(state, acting, command, late, values, servo_rate):
    """A sample further, state in place, by the classical Runge-Kutta method; `late` is the delayed command of the
    acceleration. The acceleration of the actuator then, and whether all states are numbers still."""
    p = vehicle.unpack(values)
    longest = min(LONGEST_STEP_S, STEP_PER_SPEED_S2PM * max(state[SPEED], KINEMATIC_MPS))
    count = math.ceil(SAMPLE_TIME_S / longest)
    h, n = SAMPLE_TIME_S / count, len(state)
    k1, k2, k3, k4 = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    towards = 1.0 - math.exp(-h / ACTUATOR_LAG_S)
    for _ in range(count):
        acting += towards * (late - acting)
        pushed = acting if state[SPEED] > 0.0 else max(acting, 0.0)
        derivative(state, command, pushed, p, k1, servo_rate)
        derivative(state + h / 2 * k1, command, pushed, p, k2, servo_rate)
        derivative(state + h / 2 * k2, command, pushed, p, k3, servo_rate)
        derivative(state + h * k3, command, pushed, p, k4, servo_rate)
        for i in range(n):
            state[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
        if state[SPEED] < KINEMATIC_MPS:
            rolling(state, p)
    known = True
    for i in range(n):
        known = known and math.isfinite(state[i])
    return acting, known


@dataclass
class Moving:
    """A car at rest at the origin, along the x axis."""

    car: vehicle.Car
    servo_radps: float = vehicle.SERVO_RATE_LIMIT_RADPS

    def __post_init__(self):
        self.state, self.acting = self.car.at_start(0.0), 0.0
        self.sent = [0.0] * DELAY

    def advance(self, steering, acceleration):
        """A sample further with these commands; whether all states are numbers still."""
        self.sent.append(acceleration)
        late = self.sent.pop(0)
        self.acting, known = advance(self.state, self.acting, steering, late, self.car.parameters, self.servo_radps)
        return known
