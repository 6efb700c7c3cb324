"""The compiled vehicle against the published one, and the compiled law against the packed FMU."""

import math

import numpy as np
import pytest
import vehicle
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

CARS = [1, 2, 3]


def plain_rate(state, command, speed, p):
    wanted = (command - state[vehicle.STEER]) / vehicle.SERVO_TIME_CONSTANT_S
    limit = vehicle.SERVO_RATE_LIMIT_RADPS
    steering_rate = max(-limit, min(limit, wanted))
    acceleration = vehicle.SPEED_HOLD_PER_S * (speed - state[vehicle.SPEED])
    return np.array(vehicle_dynamics_mb(list(state), [steering_rate, acceleration], p))


@pytest.mark.parametrize("number", CARS)
def test_compiled_rates_are_the_published_ones(number):
    """At states around driving, steered either way, slow and fast, sliding and standing."""
    car, rng = vehicle.Car(number), np.random.default_rng(number)
    for speed in (0.05, 3.0, 8.0, 15.0, 22.0, 40.0):
        rest = car.at_start(max(speed, 1.0))
        for _ in range(50):
            state = rest + rng.normal(scale=0.02, size=len(rest))
            state[vehicle.SPEED] = speed
            state[vehicle.LATERAL_VELOCITY] = 0.1 * speed * rng.normal()
            command = rng.uniform(-0.2, 0.2)
            got = vehicle.rates(state.copy(), command, speed + 1.0, car.parameters)
            expected = plain_rate(state, command, speed + 1.0, car.published)
            np.testing.assert_allclose(got, expected, rtol=1e-11, atol=1e-9)


def test_a_compiled_drive_is_the_plain_one():
    car, speed = vehicle.Car(2), 15.0
    state, h = car.at_start(speed), 0.01 / vehicle.STEPS
    command = 0.04 * np.sin(2 * math.pi * np.arange(30) * 0.01)
    compiled = car.drive(command, speed)
    for k in range(len(command) - 1):
        for _ in range(vehicle.STEPS):
            k1 = plain_rate(state, command[k], speed, car.published)
            k2 = plain_rate(state + h / 2 * k1, command[k], speed, car.published)
            k3 = plain_rate(state + h / 2 * k2, command[k], speed, car.published)
            k4 = plain_rate(state + h * k3, command[k], speed, car.published)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        np.testing.assert_allclose(compiled[k + 1], state, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("number", CARS)
def test_the_step_of_the_integration_is_short_enough(number):
    """Four times the steps change the yaw rate by far less than a gyro's noise."""
    car, speed = vehicle.Car(number), 15.0
    command = 0.04 * np.sin(2 * math.pi * 0.7 * np.arange(600) * 0.01)
    start = car.at_start(speed)
    drives = [
        vehicle.drive(start.copy(), command, speed, car.parameters, steps)[:, vehicle.YAW_RATE]
        for steps in (vehicle.STEPS, 4 * vehicle.STEPS)
    ]
    assert np.sqrt(np.mean((drives[0] - drives[1]) ** 2)) < 1e-4


def test_steering_left_turns_left():
    states = vehicle.Car(1).drive(np.full(100, 0.02), 15.0)
    assert states[-1, vehicle.YAW_RATE] > 0.05
    assert states[-1, vehicle.Y] > 0.1
