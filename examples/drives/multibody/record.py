#!/usr/bin/env python3
"""Record a test drive on CommonRoad's 29-state multi-body vehicle.

A BMW 320i (parameter set 2) drives at a held 15 m/s while its steering is
excited as a test driver would: sweep, steps, slalom, and in the second half a
pseudo-random sequence of levels. Sensors with seeded noise are logged to

    drive.csv      100 Hz: command, steering angle, yaw rate, speed, lateral acceleration
    position.csv    10 Hz: position of the centre of gravity
    vehicle.toml   the linear bicycle that the car's data sheet gives

Axes and signs are ISO 8855: x forward, y left, yaw and steering positive to the
left. A row holds what the sensors read at `time_s` and the command issued at
that instant, which holds until the next row. The vehicle model is used as
published, unmodified; its tyre forces jump by about 4 % of the wheel load where
the camber angle changes sign, so driving straight ends in a faint weave.

    python record.py                 write the three files next to this script
    python record.py --verify        also check step size, steering sign and the linear bicycle
"""

import argparse
from functools import partial
from pathlib import Path

import numpy as np
from datasheet import bicycle_parameters
from drive_log import noisy, write_drive, write_table
from excitation import SAMPLE_TIME_S, Excitation, straight
from vehiclemodels.init_mb import init_mb
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

SPEED_MPS = 15.0
SPEED_HOLD_PER_S = 2.0  # acceleration per speed error

POSITION_EVERY = 10  # samples of drive.csv between two positions
STEP_S = 0.0005  # of the Runge-Kutta integration; divides SAMPLE_TIME_S
SETTLING_S = 4.0  # the suspension finds its rest before the recording

SERVO_TIME_CONSTANT_S = 0.05
SERVO_RATE_LIMIT_RADPS = 0.4

POSITION_NOISE_M = 0.02  # standard deviation, white

# Places in the model's state vector.
X, Y, STEER, SPEED, YAW, YAW_RATE, LATERAL_VELOCITY = 0, 1, 2, 3, 4, 5, 10
# Set to zero when the recording starts: the position, and lateral motion, yaw and roll of
# body and axles, which vanish by symmetry when the car drives straight.
ZERO_AT_START = (X, Y, STEER, YAW, YAW_RATE, 6, 7, 10, 13, 14, 15, 18, 19, 20, 27, 28)


def excitation(p):
    return Excitation(p.a + p.b, SPEED_MPS)


# ---- The vehicle ----


def servo_rate(command_rad, steer_rad):
    wanted = (command_rad - steer_rad) / SERVO_TIME_CONSTANT_S
    return max(-SERVO_RATE_LIMIT_RADPS, min(SERVO_RATE_LIMIT_RADPS, wanted))


def derivative(state, command_rad, p):
    """The multi-body model behind the steering servo and the speed hold."""
    acceleration = SPEED_HOLD_PER_S * (SPEED_MPS - state[SPEED])
    return vehicle_dynamics_mb(state, [servo_rate(command_rad, state[STEER]), acceleration], p)


def runge_kutta(rate, state, step):
    """One classical step of order four."""
    k1 = rate(state)
    k2 = rate([s + step / 2 * k for s, k in zip(state, k1)])
    k3 = rate([s + step / 2 * k for s, k in zip(state, k2)])
    k4 = rate([s + step * k for s, k in zip(state, k3)])
    return [s + step / 6 * (a + 2 * b + 2 * c + d) for s, a, b, c, d in zip(state, k1, k2, k3, k4)]


def simulate(rate, state, command, step):
    """States at the samples; `rate(state, command)` with the command held between them."""
    states = []
    for value in command:
        states.append(state)
        held = partial(rate, command=value)
        for _ in range(round(SAMPLE_TIME_S / step)):
            state = runge_kutta(held, state, step)
    return np.array(states)


def vehicle_rate(p):
    return lambda state, command: derivative(state, command, p)


def settled(p):
    """Straight at 15 m/s, wheels spinning, with the suspension at rest."""
    start = [float(s) for s in init_mb([0.0, 0.0, 0.0, SPEED_MPS, 0.0, 0.0, 0.0], p)]
    state = simulate(vehicle_rate(p), start, straight(SETTLING_S), STEP_S)[-1]
    state[list(ZERO_AT_START)] = 0.0
    return state.tolist()


def drive(p, command, step):
    return simulate(vehicle_rate(p), settled(p), command, step)


def lateral_acceleration(states, command, p):
    """Of the body: dv_y/dt + r v_x."""
    rates = [derivative(list(s), c, p)[LATERAL_VELOCITY] for s, c in zip(states.tolist(), command)]
    return np.array(rates) + states[:, YAW_RATE] * states[:, SPEED]


# ---- The data sheet's bicycle ----


def vehicle_toml(p):
    b = bicycle_parameters(p)
    return f"""\
# The linear bicycle that the data sheet of the recorded car gives. Values come from
# parameter set 2 of commonroad-vehicle-models 3.0.2 (its symbols in the comments) and
# from record.py, which wrote this file.
name = "BMW 320i (CommonRoad parameter set 2)"
mass_kg = {b["mass_kg"]:.4f}  # m
yaw_inertia_kgm2 = {b["yaw_inertia_kgm2"]:.4f}  # I_z
distance_front_m = {b["distance_front_m"]:.7f}  # a, centre of gravity to front axle
distance_rear_m = {b["distance_rear_m"]:.7f}  # b, centre of gravity to rear axle
# N/rad an axle, as in CommonRoad's single-track model: mu C_S F_z with mu = p_dy1,
# C_S = -p_ky1/p_dy1 and the static loads F_zf = m g b/(a+b), F_zr = m g a/(a+b).
cornering_stiffness_front_npr = {b["cornering_stiffness_front_npr"]:.2f}
cornering_stiffness_rear_npr = {b["cornering_stiffness_rear_npr"]:.2f}
actuator_time_constant_s = {SERVO_TIME_CONSTANT_S}  # the steering servo of record.py
steering_ratio = 1.0  # the log holds road-wheel angles
speed_mps = {SPEED_MPS}  # held during the drive
"""


def bicycle_rate(p):
    """States v_y, r, delta at the recorded speed."""
    b = bicycle_parameters(p)
    m, inertia, v = b["mass_kg"], b["yaw_inertia_kgm2"], SPEED_MPS
    lf, lr = b["distance_front_m"], b["distance_rear_m"]
    cf, cr = b["cornering_stiffness_front_npr"], b["cornering_stiffness_rear_npr"]

    def rate(state, command):
        vy, r, delta = state
        front = cf * (delta - (vy + lf * r) / v)
        rear = cr * (-(vy - lr * r) / v)
        return [
            (front + rear) / m - v * r,
            (lf * front - lr * rear) / inertia,
            (command - delta) / SERVO_TIME_CONSTANT_S,
        ]

    return rate


# ---- Files and figures ----


def write_logs(out, rng, command, states, acceleration):
    """Returns the yaw rate as the gyro read it."""
    truth = (states[:, STEER], states[:, YAW_RATE], states[:, SPEED], acceleration)
    yaw_rate = write_drive(out / "drive.csv", rng, SAMPLE_TIME_S, command, *truth)

    fixes = states[::POSITION_EVERY]
    columns = [
        SAMPLE_TIME_S * np.arange(len(states))[::POSITION_EVERY],
        noisy(rng, fixes[:, X], POSITION_NOISE_M),
        noisy(rng, fixes[:, Y], POSITION_NOISE_M),
    ]
    write_table(out / "position.csv", "time_s,x_m,y_m", (1, 4, 4), columns)
    return yaw_rate


def report(what, figure):
    print(f"{what:<30}{figure}")


def print_figures(command, states, acceleration):
    error = np.abs(command - states[:, STEER])
    saturated = np.mean(error >= SERVO_RATE_LIMIT_RADPS * SERVO_TIME_CONSTANT_S)
    speed = states[:, SPEED]
    report("length", f"{len(command) * SAMPLE_TIME_S:.2f} s")
    report("largest lateral acceleration", f"{np.max(np.abs(acceleration)):.2f} m/s2")
    report("speed", f"{speed.min():.3f} to {speed.max():.3f} m/s")
    report("largest steering command", f"{np.degrees(np.max(np.abs(command))):.2f} deg")
    report("servo at its rate limit", f"{100 * saturated:.2f} % of the time")


def fit_percent(measured, simulated):
    spread = np.linalg.norm(measured - measured.mean())
    return 100 * (1 - np.linalg.norm(measured - simulated) / spread)


def print_verification(p, command, states, yaw_rate):
    change = (drive(p, command, STEP_S / 2) - states)[:, YAW_RATE]
    largest, rms = np.max(np.abs(change)), np.sqrt(np.mean(change**2))
    report("halving the step changes", f"yaw rate by {largest:.1e} rad/s at most, {rms:.1e} rms")

    left = drive(p, straight(1.0) + excitation(p).road_wheel_angle(1.0), STEP_S)[-1]
    report("steering left for 1 s gives", f"yaw rate {left[YAW_RATE]:+.3f} rad/s, y {left[Y]:+.3f} m")

    bicycle = simulate(bicycle_rate(p), [0.0, 0.0, 0.0], command, STEP_S)[:, 1]
    report(
        "fit of the linear bicycle",
        f"{fit_percent(yaw_rate, bicycle):.2f} % of the logged yaw rate",
    )
    ceiling = fit_percent(yaw_rate, states[:, YAW_RATE])
    report("fit of the true yaw rate", f"{ceiling:.2f} % (what the sensor noise leaves)")


def arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=320,
        help="of the sensor noise and the random levels (default: %(default)s)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path(__file__).parent,
        help="folder of the files (default: next to this script)",
    )
    parser.add_argument(
        "--verify",
        action="store_true",
        help="check step size, steering sign and the linear bicycle, too",
    )
    return parser.parse_args()


def main():
    options = arguments()
    options.out.mkdir(parents=True, exist_ok=True)
    levels_rng, noise_rng = np.random.default_rng(options.seed).spawn(2)

    p = parameters_vehicle2()
    # The logged digits are the command that is driven; adding zero drops the sign of -0.
    command = np.round(excitation(p).steering_command(levels_rng), 7) + 0.0
    states = drive(p, command, STEP_S)
    acceleration = lateral_acceleration(states, command, p)

    yaw_rate = write_logs(options.out, noise_rng, command, states, acceleration)
    (options.out / "vehicle.toml").write_text(vehicle_toml(p), newline="\n")
    print_figures(command, states, acceleration)
    if options.verify:
        print_verification(p, command, states, yaw_rate)


if __name__ == "__main__":
    main()
