"""A controller's file: what stands in it, and the same with other gains."""

import json
from pathlib import Path


def limits_of(pid):
    limits = pid["limits"]
    rate = limits["max_rate_radps"] * pid["sample_time_s"]
    return (limits["max_angle_rad"], min(limits["max_increment_rad"], rate))


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


def with_gains(pid, gains, margin, name):
    """The file with other gains, and the guidance that belongs to them; `margin`: its modulus margin."""
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
    pid["guidance"] |= {
        "preview_time_s": preview,
        "feedforward_gain_radm": share * speed / steady,
    }
    pid["evidence"]["margins"]["modulus_margin"] = margin
    return pid


def steady_gain(pid):
    """Yaw rate per steering in a steady turn, 1/s: the design's, out of its own guidance."""
    kp, ki, kd, _, weight, _ = gains_of(pid)
    preview = pid["guidance"]["preview_time_s"]
    speed = pid["designed_for"]["speed_mps"]
    # feedforward = speed · (1/G + kd − b kp p − ki p²/2)
    rest = kd - weight * kp * preview - ki * preview**2 / 2.0
    return 1.0 / (pid["guidance"]["feedforward_gain_radm"] / speed - rest)


def write(pid, file):
    Path(file).write_text(json.dumps(pid, indent=2) + "\n")
