"""The oracle: a controller tuned on the vehicle itself, to the design's requirements.

The quickest settling with overshoot and steady-state error within the specification and the modulus
margin kept, by differential evolution over kp, ki, kd, filter time and setpoint weight. It knows
what no design can: the vehicle, and without noise. What it finds depends on the car, the
specification and the limits alone.
"""

import math

import numpy as np
from pid_file import limits_of
from pid_law import modulus_margin, respond, sampled_yaw, steady_gain
from scipy.optimize import differential_evolution
from yaw_step import STEP_RAD, metrics

SEARCH_S = 3.0  # of each response, while searching
SAMPLES = 300
SEED = 1
POPULATION, GENERATIONS = 12, 40
OUTSIDE = 100.0  # cost of a requirement missed by all of its bound
# Of the search: kp times the car's gain 1/s, ki/kp 1/s, kd/kp s, filter time s, setpoint weight.
SMALLEST = (1.0, 0.2, 0.005, 0.003, 0.0)
LARGEST = (30.0, 10.0, 0.3, 0.06, 1.0)


def gains_at(x):
    """Of the search's coordinates: logarithms of kp, ki/kp, kd/kp and the filter time, and b."""
    kp, reset, lead, filter_time = np.exp(x[:4])
    # Åström and Hägglund, as in the design.
    anti_windup = min(max(math.sqrt(lead / reset), 0.1), 1.0 / reset)
    return (kp, kp * reset, kp * lead, filter_time, x[4], anti_windup)


def tune(car, speed, pid):
    """Tuned gains and their modulus margin; of `pid`, a design's file, specification and limits."""
    spec, limits, p = pid["specification"], limits_of(pid), car.parameters
    start, (omega, yaw) = car.at_start(speed), sampled_yaw(car, speed)

    def cost(x):
        gains = gains_at(x)
        margin = modulus_margin(gains, omega, yaw)
        missed = max(0.0, spec["modulus_margin"] - margin) / spec["modulus_margin"]
        if missed > 0.3:
            return OUTSIDE * (1.0 + missed)
        response = respond(start.copy(), speed, p, gains, limits, STEP_RAD, SAMPLES)
        m = metrics(*response)
        settling = SEARCH_S if m.settling_time_s is None else m.settling_time_s
        overshoot = spec["overshoot_percent"]
        missed += max(0.0, m.overshoot_percent - overshoot) / max(overshoot, 0.1)
        error = float(np.mean(np.abs(1.0 - response[0] / STEP_RAD))) * SEARCH_S
        return OUTSIDE * missed + settling + 0.1 * error

    gain = steady_gain(car, speed)
    low, high = ([c[0] / gain, *c[1:4]] for c in (SMALLEST, LARGEST))
    bounds = [*zip(np.log(low), np.log(high)), (SMALLEST[4], LARGEST[4])]
    found = differential_evolution(
        cost, bounds, seed=SEED, popsize=POPULATION, maxiter=GENERATIONS, tol=1e-3, polish=False
    )
    gains = gains_at(found.x)
    return list(map(float, gains)), modulus_margin(gains, omega, yaw)
