#!/usr/bin/env python3
"""Reference solutions of the nonlinear vehicle, by an integrator that is not ours.

The equations are written here again, by their definition: four tyres at their own loads, the
actuator's clip as an if, nothing in closed form. SciPy's DOP853 solves them at a relative tolerance
of 1e-12 and starts again where the actuator enters or leaves its rate limit or an end stop.

    python nonlinear_reference.py > nonlinear_reference.csv      (numpy 2, scipy 1.15 or newer)
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

CAR = {
    "mass": 1300.0, "yaw_inertia": 2100.0, "distance_front": 1.1, "distance_rear": 1.5,
    "cornering_stiffness_front": 110e3, "cornering_stiffness_rear": 125e3,
    "friction_coefficient": 0.95, "friction_balance_rear": 1.0, "tyre_shape_factor": 1.4, "tyre_curvature_factor": -0.6,
    "friction_load_sensitivity": 0.12, "stiffness_load_sensitivity": 0.25,
    "centre_of_gravity_height": 0.55, "track_width": 1.45, "roll_stiffness_front": 0.6,
    "roll_time_constant": 0.15, "drive_share_front": 0.3, "brake_share_front": 0.7, "combined_slip": 0.0, "steering_ratio": 14.0, "actuator_time_constant": 0.06,
    "actuator_delay": 0.0, "road_wheel_rate_max": 0.5, "road_wheel_angle_max": 0.5,
    "side_force_area": 5.0, "side_force_arm": 0.4, "steering_play": 0.0,
}
GRAVITY = 9.81
# The load has followed another speed than that at the start, in these cases; m/s.
BEFORE = {"braking": 30.5, "driving": 13.6, "braking with combined slip": 30.5, "driving with combined slip": 29.4}
# Velocity of the air to the left, in these cases; m/s.
CROSSWIND = {"crosswind": 18.0, "crosswind and play": -25.0, "walking in a crosswind": 20.0}
AIR_DENSITY = 1.225
STATES = ("lateral_velocity", "yaw_rate", "road_wheel_angle", "roll_acceleration", "yaw", "x", "y")

# What differs from CAR; speed; (v_y, r, delta, a_phi) at the start; steering angle and its slope; time.
CASES = {
    "gentle": ({}, 20.0, (0.0, 0.0, 0.0, 0.0), 0.3, 0.0, 1.5),
    "rate limit": ({}, 15.0, (0.0, 0.0, 0.0, 0.0), 3.0, 0.0, 0.6),
    "slow": ({}, 5.0, (0.0, 0.0, 0.0, 0.0), 4.0, 0.0, 0.6),
    "beyond the limit": ({}, 30.0, (0.0, 0.0, 0.0, 0.0), 2.8, 0.0, 1.2),
    "ramp through the stops": ({"road_wheel_angle_max": 0.1}, 18.0, (0.0, 0.0, 0.05, 0.0), -4.0, 18.0, 0.5),
    "ramp faster than the rate": ({"road_wheel_rate_max": 0.2}, 12.0, (0.0, 0.0, 0.0, 0.0), -0.1, 7.0, 0.4),
    "no curvature, no sensitivity": (
        {"tyre_curvature_factor": 0.0, "friction_load_sensitivity": 0.0, "stiffness_load_sensitivity": 0.0},
        25.0, (1.0, -0.3, 0.02, 2.0), -0.5, 0.0, 1.0),
    "low friction": ({"friction_coefficient": 0.25, "tyre_curvature_factor": 0.7}, 22.0, (0.0, 0.0, 0.0, 0.0), 1.0, 0.5, 1.0),
    "more grip at the rear": ({"friction_balance_rear": 1.25}, 30.0, (0.0, 0.0, 0.0, 0.0), 2.8, 0.0, 1.2),
    "braking": ({}, 30.0, (0.0, 0.0, 0.0, 0.0), 1.6, 0.0, 1.0),
    "driving": ({}, 14.0, (0.0, 0.0, 0.0, 0.0), 2.2, 0.0, 1.0),
    "braking with combined slip": ({"combined_slip": 1.0}, 30.0, (0.0, 0.0, 0.0, 0.0), 1.6, 0.0, 1.0),
    "driving with combined slip": ({"combined_slip": 0.8}, 30.0, (0.0, 0.0, 0.0, 0.0), 1.6, 0.0, 1.0),
    "crosswind": ({}, 28.0, (0.0, 0.0, 0.0, 0.0), 0.2, 0.0, 1.5),
    "play": ({"steering_play": 0.02}, 26.0, (0.0, 0.0, 0.0, 0.0), 1.2, -5.0, 0.8),
    "crosswind and play": (
        {"steering_play": 0.03, "side_force_arm": -0.2}, 24.0, (0.2, -0.1, 0.04, 0.0), -0.9, 2.0, 1.2),
    "walking in a crosswind": ({}, 0.6, (0.0, 0.0, 0.0, 0.0), 1.0, 0.0, 1.0),
    "walking": ({}, 0.6, (0.1, 0.05, 0.0, 0.0), 5.0, 0.0, 2.0),
    "standing": ({}, 0.0, (0.2, 0.3, 0.1, 1.0), 5.0, 0.0, 0.5),
}


def tyre(slip, load, static_load, stiffness, balance, p):
    x = load / static_load
    if load <= 0.0:
        return 0.0
    peak = balance * p["friction_coefficient"] * (1 - p["friction_load_sensitivity"] * (x - 1)) * load
    k = stiffness * x * (1 - p["stiffness_load_sensitivity"] * (x - 1))
    c, e = p["tyre_shape_factor"], p["tyre_curvature_factor"]
    b = k / (c * peak)
    return peak * math.sin(c * math.atan(b * slip - e * (b * slip - math.atan(b * slip))))


def axle(slip, load, gained, stiffness, transfer, balance, p):
    now = load + gained
    transfer = max(-now / 2, min(now / 2, transfer))
    return sum(
        tyre(slip, now / 2 + side * transfer, load / 2, stiffness / 2, balance, p) for side in (-1, 1)
    )


def air(v, w, p):
    """Force to the left and moment of a crosswind."""
    force = AIR_DENSITY / 2 * (v**2 + w**2) * p["side_force_area"] * math.atan2(w, max(v, 1.0))
    return np.array([force / p["mass"], force * p["side_force_arm"] / p["yaw_inertia"]])


def forces(vy, r, delta, roll, along, v, p):
    """Rates of v_y and r, with the tyres at speed v."""
    m, lf, lr = p["mass"], p["distance_front"], p["distance_rear"]
    weight, wheelbase = m * GRAVITY, lf + lr
    moment = m * p["centre_of_gravity_height"] * roll / p["track_width"]
    share = p["roll_stiffness_front"]
    pitch = m * p["centre_of_gravity_height"] * along / wheelbase
    of_front = p["drive_share_front" if along > 0.0 else "brake_share_front"]
    driving = [share * p["combined_slip"] * m * along for share in (of_front, 1.0 - of_front)]
    front = ellipse(driving[0], weight * lr / wheelbase - pitch, 1.0, p) * axle(
        delta - math.atan((vy + lf * r) / v), weight * lr / wheelbase, -pitch,
        p["cornering_stiffness_front"], share * moment, 1.0, p)
    rear = ellipse(driving[1], weight * lf / wheelbase + pitch, p["friction_balance_rear"], p) * axle(
        -math.atan((vy - lr * r) / v), weight * lf / wheelbase, pitch,
        p["cornering_stiffness_rear"], (1 - share) * moment, p["friction_balance_rear"], p)
    across = front * math.cos(delta)
    return np.array([(across + rear) / m - v * r, (lf * across - lr * rear) / p["yaw_inertia"]])


def ellipse(driving, load, balance, p):
    """What a force along the wheels leaves of an axle's lateral force."""
    return math.sqrt(1.0 - (driving / (balance * p["friction_coefficient"] * load)) ** 2)


def bicycle(v, p):
    """F and the column of delta of the linear bicycle."""
    m, j, lf, lr = p["mass"], p["yaw_inertia"], p["distance_front"], p["distance_rear"]
    cf, cr = p["cornering_stiffness_front"], p["cornering_stiffness_rear"]
    f = np.array([
        [-(cf + cr) / (m * v), -(cf * lf - cr * lr) / (m * v) - v],
        [-(cf * lf - cr * lr) / (j * v), -(cf * lf**2 + cr * lr**2) / (j * v)],
    ])
    return f, np.array([cf / m, cf * lf / j])


def steady(v, p):
    """(v_y, r) per delta in a steady turn of the linear bicycle."""
    if v == 0.0:
        return np.zeros(2)
    f, column = bicycle(v, p)
    return -np.linalg.solve(f, column)


def lateral(vy, r, delta, roll, along, v, p, crosswind):
    wind = air(v, crosswind, p)
    if v >= 1.0:
        return forces(vy, r, delta, roll, along, v, p) + wind
    target, end = steady(v, p) * math.tan(delta), steady(1.0, p) * math.tan(delta)
    w = np.array([vy, r])
    at_walk = forces(*(w - target + end), delta, roll, along, 1.0, p) + wind
    return v * at_walk + (1 - v) * (bicycle(1.0, p)[0] @ (w - target))


def command(t, start, slope, p):
    stop = p["road_wheel_angle_max"]
    return max(-stop, min(stop, (start + slope * t) / p["steering_ratio"]))


def along(followed, v, p):
    """Longitudinal acceleration that the load has followed."""
    return (v - followed) / p["roll_time_constant"]


def servo_rate(t, delta, start, slope, p):
    rate = p["road_wheel_rate_max"]
    return max(-rate, min(rate, (command(t, start, slope, p) - delta) / p["actuator_time_constant"]))


def rates(t, s, v, start, slope, p, crosswind, wheel_of):
    vy, r, delta, roll, yaw, _, _, followed = s
    vy_rate, r_rate = lateral(vy, r, wheel_of(delta), roll, along(followed, v, p), v, p, crosswind)
    steer = servo_rate(t, delta, start, slope, p)
    return [
        vy_rate, r_rate, steer, (vy_rate + v * r - roll) / p["roll_time_constant"], r,
        v * math.cos(yaw) - vy * math.sin(yaw), v * math.sin(yaw) + vy * math.cos(yaw),
        along(followed, v, p),
    ]


def played(t, delta, wheel, start, slope, p):
    """The wheels as a function of the servo, and events at which it becomes another, in a gap."""
    half = p["steering_play"] / 2
    if half == 0.0:
        return (lambda delta: delta), []

    def turns(t, s):
        return servo_rate(t, s[2], start, slope, p)

    def edge(side):
        def event(_, s):
            return s[2] - wheel - side * half
        event.terminal = True
        return event

    turns.terminal = True
    side = math.copysign(1.0, turns(t, (0.0, 0.0, delta)))
    if (delta - wheel) * side >= half - 1e-12:
        return (lambda delta: delta - side * half), [turns]
    return (lambda _: wheel), [edge(-1.0), edge(1.0)]


def solve(p, v, before, initial, start, slope, time, crosswind):
    def limit(side):
        def event(t, s):
            wanted = (command(t, start, slope, p) - s[2]) / p["actuator_time_constant"]
            return wanted - side * p["road_wheel_rate_max"]
        event.terminal = True
        return event

    def stop(side):
        def event(t, _):
            return (start + slope * t) / p["steering_ratio"] - side * p["road_wheel_angle_max"]
        event.terminal = True
        return event

    t, state, wheel = 0.0, np.array([*initial, 0.0, 0.0, 0.0, before]), initial[2]
    while t < time:
        wheel_of, turning = played(t, state[2], wheel, start, slope, p)

        def moving(t, s):
            return rates(t, s, v, start, slope, p, crosswind, wheel_of)

        run = solve_ivp(
            moving, (t, time), state, method="DOP853", rtol=1e-12, atol=1e-14, max_step=0.004,
            events=[limit(-1), limit(1), stop(-1), stop(1), *turning])
        assert run.status >= 0, run.message
        t, state = run.t[-1], run.y[:, -1]
        if t < time:
            # Past the event, so that it does not fire again at once.
            nudge = min(1e-10, time - t)
            state = state + nudge * np.array(moving(t, state))
            t += nudge
        wheel = wheel_of(state[2])
    vy, r, _, roll, *_, followed = state
    acceleration = lateral(vy, r, wheel, roll, along(followed, v, p), v, p, crosswind)[0] + v * r
    return [vy, r, wheel, *state[3:-1], acceleration]


def main():
    inputs = ["speed", "crosswind", "speed_before", *(f"start_{name}" for name in STATES[:4]), "steering", "slope", "time"]
    print(",".join(["case", *CAR, *inputs, *STATES, "lateral_acceleration"]))
    for name, (changes, v, initial, start, slope, time) in CASES.items():
        p = CAR | changes
        before = BEFORE.get(name, v)
        crosswind = CROSSWIND.get(name, 0.0)
        solved = solve(p, v, before, initial, start, slope, time, crosswind)
        numbers = [*p.values(), v, crosswind, before, *initial, start, slope, time, *solved]
        print(",".join([name.replace(",", " and"), *(repr(float(x)) for x in numbers)]))


if __name__ == "__main__":
    main()
