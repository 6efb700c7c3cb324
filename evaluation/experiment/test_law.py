"""The compiled controller and what is computed of its loop."""

import math

import numpy as np
import pid_file
import pid_law
import pytest
import vehicle
import yaw_step

GAINS = (1.5, 2.0, 0.1, 0.02, 0.7, 0.3)


def test_metrics_of_a_known_response():
    """1 − exp(−t/T) enters the band of 2 % at T ln 50 and rises in T ln 9."""
    time, constant = 0.01 * np.arange(501), 0.2
    yaw = yaw_step.STEP_RAD * (1.0 - np.exp(-time / constant))
    m = yaw_step.metrics(yaw, np.zeros_like(yaw))
    assert m.overshoot_percent == 0.0
    assert m.settling_time_s == pytest.approx(constant * math.log(50.0), abs=1e-4)
    assert m.rise_time_s == pytest.approx(constant * math.log(9.0), abs=1e-3)
    assert m.steady_state_error_percent == pytest.approx(0.0, abs=1e-6)


def test_a_response_that_never_settles_says_so():
    yaw = 0.9 * yaw_step.STEP_RAD * np.ones(501)
    m = yaw_step.metrics(yaw, np.zeros_like(yaw))
    assert m.settling_time_s is None
    assert m.steady_state_error_percent == pytest.approx(10.0)


def test_a_car_that_is_lost_never_settles():
    yaw = yaw_step.STEP_RAD * np.ones(501)
    yaw[300:] = np.nan
    m = yaw_step.metrics(yaw, np.zeros_like(yaw))
    assert m.settling_time_s is None
    assert m.overshoot_percent > 100.0


def test_modulus_margin_of_an_integrator():
    """kp over an integrator of gain g, sampled: L = k/(z − 1), k = kp g Ts; nearest to −1 at z = −1,
    where L = −k/2."""
    omega = np.geomspace(0.5, math.pi / 0.01, 2000)
    yaw = 4.0 * 0.01 / (np.exp(1j * omega * 0.01) - 1.0)
    margin = pid_law.modulus_margin((10.0, 0.0, 0.0, 0.0, 1.0, 1.0), omega, yaw)
    assert margin == pytest.approx(1.0 - 10.0 * 4.0 * 0.01 / 2.0, abs=1e-6)


def test_gains_come_to_a_margin_from_either_side():
    omega, yaw = pid_law.sampled_yaw(vehicle.Car(2), 15.0)
    for start in (0.3, 6.0):
        gains = pid_law.scaled(GAINS, start)
        factor = pid_law.factor_to_margin(gains, omega, yaw, 0.5)
        assert pid_law.modulus_margin(pid_law.scaled(gains, factor), omega, yaw) == pytest.approx(
            0.5, abs=1e-4
        )


def test_an_unstable_loop_has_no_margin():
    """The oracle once found one that is far from −1 and grows after the search's 3 s."""
    car, speed = vehicle.Car(2), 22.0
    found = (1.406, 11.492, 0.1935, 0.00558, 0.3666, 0.1224)
    assert pid_law.modulus_margin(found, *pid_law.sampled_yaw(car, speed)) == 0.0
    stable = (0.9, 1.5, 0.08, 0.01, 0.6, 0.2)
    assert pid_law.modulus_margin(stable, *pid_law.sampled_yaw(car, speed)) > 0.5


def test_the_sampled_response_is_an_integrator_of_the_steady_gain():
    """At low frequency: yaw rate per steering over jω."""
    car, speed = vehicle.Car(2), 15.0
    omega, yaw = pid_law.sampled_yaw(car, speed)
    states = car.drive(np.full(400, 0.008), speed)
    steady = states[-1, vehicle.YAW_RATE] / 0.008
    assert abs(yaw[0]) * omega[0] == pytest.approx(steady, rel=0.03)


def test_no_other_reference_keeps_closer_to_roads():
    """Yaw over heading of the loop, written out: the gains of yaw acceleration and jerk are the best."""
    omega, yaw = pid_law.sampled_yaw(vehicle.Car(2), 15.0)
    kp, ki, kd, filter_time, weight, anti_windup = gains = (1.97, 5.07, 0.119, 0.01, 0.48, 0.15)
    s, z = 1j * omega, np.exp(1j * omega * 0.01)
    feedback = pid_law.frequency_response(gains, z)
    weighted = pid_law.frequency_response((weight * kp, ki, 0.0, filter_time, 1.0, anti_windup), z)
    preview = kp * (1.0 - weight) / ki
    steady = pid_law.steady_gain(vehicle.Car(2), 15.0)
    feedforward = 1.0 / steady + kd - weight * kp * preview - ki * preview**2 / 2.0

    def missed(acceleration, jerk):
        reference = weighted * (1.0 + acceleration * s**2 + jerk * s**3)
        steered = reference + s * (feedforward - ki * acceleration)
        error = np.exp(s * preview) * yaw * steered / (1.0 + yaw * feedback) - 1.0
        # A road's heading: clothoids. Cross-track error: its integral, but for the look-ahead.
        road = np.where(omega <= 20.0, np.gradient(omega) * (1.0 + omega**2) ** -4, 0.0)
        return np.sum(road * np.abs(error) ** 2)

    acceleration, jerk = pid_file.reference_gains(gains, preview, feedforward, omega, yaw)
    least = missed(acceleration, jerk)
    assert least < 0.25 * missed(0.0, 0.0)
    for other in ((1.1, 1.0), (0.9, 1.0), (1.0, 1.1), (1.0, 0.9)):
        assert least < missed(other[0] * acceleration, other[1] * jerk)
