"""The rivals' laws on what they are designed for, and the disturbed car without disturbance."""

import math

import disturbed
import numpy as np
import pytest
import rivals
import vehicle
from scipy.optimize import minimize

SHEET = rivals.Sheet(2)


def road(curvature, length=400.0):
    """Straight, then within 30 m into a turn that is kept."""
    s = np.arange(0.0, length, 0.5)
    along = curvature * np.clip((s - 50.0) / 30.0, 0.0, 1.0)
    heading = np.concatenate([[0.0], np.cumsum(0.25 * (along[1:] + along[:-1]))])
    step = [np.concatenate([[0.0], np.cumsum(0.25 * (f(heading)[1:] + f(heading)[:-1]))]) for f in (np.cos, np.sin)]
    return rivals.Road(np.column_stack([s, *step, heading, along]))


def on_the_linear_car(law, speed, seconds=20.0):
    """Offsets of the data sheet's own bicycle behind its servo."""
    x = y = yaw = 0.0
    a, b, _ = SHEET.matrices(speed, 0.01)
    inner = np.zeros(rivals.STATES)
    offsets = []
    for k in range(round(seconds / 0.01)):
        course = yaw + inner[2] / speed
        sent = inner[5]
        command = law.command(k, (x, y, yaw, course, inner[3]), speed)
        offsets.append(law.road.locate(x, y, law.distance)[1])
        # The bicycle's own states by its matrices; place and yaw by its speed.
        inner = a @ np.concatenate([[0.0, 0.0], inner[2:5], [command]])
        inner[5] = command
        assert abs(command - sent) < 0.1
        x += 0.01 * speed * math.cos(course)
        y += 0.01 * speed * math.sin(course)
        yaw += 0.01 * inner[3]
    return np.array(offsets)


@pytest.mark.parametrize(
    ("law", "setting", "largest"),
    [
        (rivals.Lqr, {"weight_m2s2": 0.1}, 0.03),
        (rivals.Mpc, {"weight_m2s2": 0.1}, 0.05),
        (rivals.PurePursuit, {"lookahead_s": 0.4, "least_m": 2.0, "lead_s": 0.05}, 0.3),
        (rivals.Stanley, {"gain_per_s": 1.0, "damping_s": 0.05, "preview_s": 0.05}, 0.1),
    ],
)
@pytest.mark.parametrize("curvature", [0.015, -0.015])
def test_a_law_follows_a_turn_with_the_car_of_its_data_sheet(law, setting, largest, curvature):
    offsets = on_the_linear_car(law(SHEET, road(curvature), **setting), 15.0)
    assert np.max(np.abs(offsets)) < largest
    # In the steady turn LQR and MPC have no error but of the steps, the others that of their geometry.
    assert abs(offsets[-1]) < largest / 2


def test_the_rates_of_the_mpc_are_the_least_of_its_cost_within_the_bound():
    hessian, of_state, of_curvature = rivals.condensed(SHEET, 15.0, 0.1)
    for offset in (0.02, 1.0, -3.0):
        linear = of_state @ np.array([offset, 0.0, 0.0, 0.0, 0.0, 0.0]) + of_curvature @ np.full(rivals.HORIZON + 1, 0.01)
        found = np.zeros(rivals.HORIZON)
        rivals.bounded_least(hessian, linear, 0.4, found)
        cost = lambda u: 0.5 * u @ hessian @ u + linear @ u
        slope = lambda u: hessian @ u + linear
        start, bounds = np.zeros(rivals.HORIZON), [(-0.4, 0.4)] * rivals.HORIZON
        best = minimize(cost, start, jac=slope, bounds=bounds, method="L-BFGS-B", options={"maxiter": 5000, "ftol": 1e-15})
        assert cost(found) - best.fun < 1e-4 * abs(best.fun)
        assert np.max(np.abs(found)) <= 0.4


def test_without_limits_the_mpc_steers_as_the_lqr():
    """Its steps are five times as long."""
    state = {"yaw": 0.01, "course": 0.012, "yaw_rate": 0.02, "speed": 15.0, "offset": 0.05}
    rates = []
    for law in (rivals.Lqr, rivals.Mpc):
        made = law(SHEET, road(0.01), weight_m2s2=1.0)
        made.distance = 20.0
        before = made.sent
        rates.append((made.steer(0.0, 0.0, **state) - before) / 0.01)
    assert rates[0] == pytest.approx(rates[1], rel=0.25)


def test_the_disturbed_car_without_disturbance_is_the_car():
    car, speed = vehicle.Car(2), 15.0
    one, other, servo = car.at_start(speed), car.at_start(speed), 0.0
    for k in range(200):
        command = 0.03 * math.sin(0.05 * k)
        vehicle.advance(one, command, speed, car.parameters, vehicle.STEPS)
        servo, known = disturbed.advance(
            other, servo, command, speed, car.parameters, vehicle.STEPS, vehicle.SERVO_RATE_LIMIT_RADPS, 0.0, 0.0, 0.0
        )
        assert known
    assert abs(one[vehicle.YAW_RATE] - other[vehicle.YAW_RATE]) < 2e-4
    assert math.hypot(one[vehicle.X] - other[vehicle.X], one[vehicle.Y] - other[vehicle.Y]) < 2e-3


def test_bank_wind_and_play_do_what_their_names_say():
    car, speed = vehicle.Car(1), 20.0
    still = (vehicle.SERVO_RATE_LIMIT_RADPS, 0.0, 0.0, 0.0)

    def after(pushed, command=0.0):
        state, servo = car.at_start(speed), 0.0
        for _ in range(300):
            servo, _ = disturbed.advance(state, servo, command, speed, car.parameters, vehicle.STEPS, *pushed)
        return state, servo

    banked, _ = after((*still[:2], 9.81 * math.sin(math.radians(3.0)), 0.0))
    blown, _ = after((*still[:3], 10.0))
    assert banked[vehicle.Y] > 0.1 and blown[vehicle.Y] > 0.5
    # The tyres take up the bank; an understeering car turns down it.
    assert banked[vehicle.YAW_RATE] > 0.0
    wheel, servo = after((still[0], math.radians(0.5), 0.0, 0.0), 0.02)
    assert servo == pytest.approx(0.02, abs=1e-4)
    assert wheel[vehicle.STEER] == pytest.approx(0.02 - 0.5 * math.radians(0.5), abs=1e-4)
