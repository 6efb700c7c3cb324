"""A controller's file: what stands in it, and the same with other gains."""

import json
import math
from pathlib import Path

import numpy as np
from pid_law import SAMPLE_TIME_S, frequency_response

# As in the design.
LOOKAHEAD_RADPS, HIGHEST_RADPS, LARGEST_S2, LARGEST_S3 = 1.0, 20.0, 0.02, 0.004


def limits_of(pid):
    """As `pid_law` takes them, at the speed designed for."""
    limits, speed = pid["limits"], max(pid["designed_for"]["speed_mps"], 1.0)
    increment = min(limits["max_increment_rad"], limits["max_rate_radps"] * pid["sample_time_s"])
    angle, fastest, gain = limits["max_angle_rad"], math.inf, speed
    if lateral := limits.get("lateral_acceleration"):
        turn = lateral["steering_per_curvature_radm"] / speed**2
        turn += lateral["understeer_gradient_rads2pm"]
        angle = min(angle, lateral["max_mps2"] * turn)
        fastest, gain = lateral["max_mps2"] / speed, 1.0 / (speed * turn)
    large = limits.get("large_errors", {})
    error = large.get("max_yaw_error_rad", math.pi)
    sustained = large.get("sustained_rate_radps", limits["max_rate_radps"])
    reserve = max(large.get("rate_reserve_time_s", 1.0), SAMPLE_TIME_S)
    lag = large.get("yaw_rate_lag_s", 0.0)
    return (angle, increment, fastest, gain, error, sustained, reserve, lag)


def gains_of(pid):
    g = pid["gains"]
    return (
        g["kp"],
        g["ki"],
        g["kd"],
        g["derivative_filter_time_s"],
        g["setpoint_weight_proportional"],
        g["anti_windup_time_s"],
    )


def with_gains(pid, gains, margin, name, loop):
    """The file with other gains, and the guidance that belongs to them; `margin`: its modulus margin,
    `loop`: frequencies, rad/s, and the response from command to yaw there."""
    kp, ki, kd, filter_time, weight, anti_windup = map(float, gains)
    pid = json.loads(json.dumps(pid))
    steady = steady_gain(pid)
    pid["name"] = name
    pid["gains"] |= {
        "kp": kp,
        "ki": ki,
        "kd": kd,
        "derivative_filter_time_s": filter_time,
        "setpoint_weight_proportional": weight,
        "anti_windup_time_s": anti_windup,
    }
    preview = kp * (1.0 - weight) / ki
    share = 1.0 + steady * (kd - weight * kp * preview - ki * preview**2 / 2.0)
    speed = pid["designed_for"]["speed_mps"]
    feedforward = share / steady
    shape, jerk = reference_gains(gains, preview, feedforward, *loop)
    pid["guidance"] |= {
        "preview_time_s": preview,
        "feedforward_gain_radm": (feedforward - ki * shape) * speed,
        "yaw_acceleration_gain_s2": shape,
        "yaw_jerk_gain_s3": jerk,
    }
    pid["evidence"]["margins"]["modulus_margin"] = margin
    return pid


def steady_gain(pid):
    """Yaw rate per steering in a steady turn, 1/s: the design's, out of its own guidance."""
    kp, ki, kd, _, weight, _ = gains_of(pid)
    preview = pid["guidance"]["preview_time_s"]
    speed = pid["designed_for"]["speed_mps"]
    # feedforward = speed · (1/G + kd − b kp p − ki p²/2 − ki g)
    shape = pid["guidance"].get("yaw_acceleration_gain_s2", 0.0)
    rest = kd - weight * kp * preview - ki * preview**2 / 2.0 - ki * shape
    return 1.0 / (pid["guidance"]["feedforward_gain_radm"] / speed - rest)


def reference_gains(gains, preview, feedforward, omega, yaw):
    """What of yaw acceleration, s², and jerk, s³, belongs into the reference: the design's rule
    (`Advice::on_roads` in control/src/closed_loop), by least squares over roads. `feedforward`: steering
    per yaw rate, s."""
    j_omega = 1j * omega
    z = np.exp(j_omega * SAMPLE_TIME_S)
    feedback = frequency_response(gains, z)
    kp, ki, _, _, weight, _ = gains
    reference = frequency_response((weight * kp, ki, 0.0, *gains[3:]), z)
    closed = np.exp(j_omega * preview) * yaw / (1.0 + yaw * feedback)
    zeroth = closed * (reference + j_omega * feedforward) - 1.0
    first = closed * (j_omega**2 * reference - j_omega * ki)
    weights = np.gradient(omega) * (omega**2 + LOOKAHEAD_RADPS**2) ** -4.0
    weights = np.where(omega <= HIGHEST_RADPS, weights, 0.0)
    both = np.array([first, closed * j_omega**3 * reference])
    square = (both.conj() * weights @ both.T).real
    product = (both.conj() @ (weights * zeroth)).real
    jerk = np.clip(-np.linalg.solve(square, product)[1], -LARGEST_S3, LARGEST_S3)
    # With one at its bound, the other that belongs to it.
    gain = -(product[0] + square[0, 1] * jerk) / square[0, 0]
    gain = np.clip(gain, -LARGEST_S2, LARGEST_S2)
    jerk = -(product[1] + square[0, 1] * gain) / square[1, 1]
    return float(gain), float(np.clip(jerk, -LARGEST_S3, LARGEST_S3))


def write(pid, file):
    Path(file).write_text(json.dumps(pid, indent=2) + "\n")
