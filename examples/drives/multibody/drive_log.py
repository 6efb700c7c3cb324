"""The log of a drive: what the sensors read, 100 Hz, and the command issued then."""

import numpy as np

YAW_RATE_NOISE_RADPS = 0.002  # standard deviations, white
SPEED_NOISE_MPS = 0.02
STEERING_NOISE_RAD = 0.0005
ACCELERATION_NOISE_MPS2 = 0.05

HEADER = (
    "time_s,steering_command_rad,steering_angle_rad,"
    "yaw_rate_radps,speed_mps,lateral_acceleration_mps2"
)


def noisy(rng, values, deviation):
    return values + deviation * rng.standard_normal(len(values))


def write_table(path, header, decimals, columns):
    rows = (",".join(f"{value:.{d}f}" for value, d in zip(row, decimals)) for row in zip(*columns))
    path.write_text("\n".join([header, *rows]) + "\n", newline="\n")


def write_drive(path, rng, sample_time, command, steering, yaw_rate, speed, acceleration):
    """Writes true signals with seeded noise. Returns the yaw rate as the gyro read it."""
    yaw_rate = noisy(rng, yaw_rate, YAW_RATE_NOISE_RADPS)
    columns = [
        sample_time * np.arange(len(command)),
        command,
        noisy(rng, steering, STEERING_NOISE_RAD),
        yaw_rate,
        noisy(rng, speed, SPEED_NOISE_MPS),
        noisy(rng, acceleration, ACCELERATION_NOISE_MPS2),
    ]
    write_table(path, HEADER, (2, 7, 7, 7, 5, 5), columns)
    return yaw_rate
