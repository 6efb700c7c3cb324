"""What the seeds say: figures of each case and contender, and ratios with confidence intervals."""

import csv
import math

import numpy as np
from contenders import IDENTIFIED, NAMES, ORACLE
from sensors import CORRECTED, DROP_OUT, UNCORRECTED
from study import EQUAL_MARGIN, REDESIGNED

RESAMPLES = 2000
CONFIDENCE = 0.95
SEED = 1
# Below these a difference is nothing on the road, and a ratio would be of noise.
LEAST_TIME_S = 0.01


def metric(run, who, path):
    """A figure of a contender's, by the path of its keys; `None` where there is none."""
    value = run["contenders"][who]
    for key in path:
        value = value.get(key) if isinstance(value, dict) else None
    return value


def prediction_error_s(run, who):
    """How far the predicted settling time is from the achieved one, s; 5 for one that never is."""
    predicted = metric(run, who, ("predicted", "settling_time_s"))
    achieved = metric(run, who, ("achieved", "settling_time_s"))
    return abs((5.0 if predicted is None else predicted) - (5.0 if achieved is None else achieved))


def road(reception, key):
    return lambda run, who: metric(run, who, ("road", reception.name, key))


def way(name, key):
    return lambda run, who: metric(run, who, ("road", name, key))


# What is compared with each rival, as ratios of the identified design's to the rival's.
COMPARED = {
    # The oracle predicts nothing: it was tuned on the car itself.
    "error of predicted settling time": lambda run, who: (
        None if who == ORACLE else max(prediction_error_s(run, who), LEAST_TIME_S)
    ),
    "cross-track RMS, corrected GNSS": road(CORRECTED, "cross_track_rms_m"),
    "largest cross-track error, corrected": road(CORRECTED, "cross_track_largest_m"),
    "course error RMS, corrected": road(CORRECTED, "course_rms_rad"),
    "largest course error, corrected": road(CORRECTED, "course_largest_rad"),
    "cross-track RMS at equal modulus margin": way(EQUAL_MARGIN, "cross_track_rms_m"),
    "largest cross-track error at equal margin": way(EQUAL_MARGIN, "cross_track_largest_m"),
    "course error RMS at equal margin": way(EQUAL_MARGIN, "course_rms_rad"),
    "largest course error at equal margin": way(EQUAL_MARGIN, "course_largest_rad"),
    "cross-track RMS, re-designed": way(REDESIGNED, "cross_track_rms_m"),
    "largest cross-track error, re-designed": way(REDESIGNED, "cross_track_largest_m"),
    "course error RMS, re-designed": way(REDESIGNED, "course_rms_rad"),
    "cross-track RMS, drop-outs": road(DROP_OUT, "cross_track_rms_m"),
    "cross-track RMS, uncorrected GNSS": road(UNCORRECTED, "cross_track_rms_m"),
    "steering rate RMS, corrected": road(CORRECTED, "steering_rate_rms_radps"),
}


def ratio(runs, figure, rival):
    """Geometric mean over cases and seeds of identified over rival, and its confidence interval.

    Seeds are resampled within each case, so that no case comes to weigh more than another.
    """
    cases = {}
    for run in runs:
        own, other = figure(run, IDENTIFIED), figure(run, rival)
        if own and other:
            cases.setdefault(run["case"], []).append(math.log(own / other))
    if not cases:
        return None
    logs = [np.array(values) for values in cases.values()]
    rng = np.random.default_rng(SEED)
    drawn = np.mean(
        [values[rng.integers(len(values), size=(RESAMPLES, len(values)))].mean(1) for values in logs],
        axis=0,
    )
    low, high = np.quantile(drawn, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])
    middle = float(np.mean([values.mean() for values in logs]))
    return tuple(math.exp(value) for value in (middle, low, high))


def ratios(runs):
    rivals = [who for who in NAMES if who != IDENTIFIED]
    return {
        what: {rival: ratio(runs, figure, rival) for rival in rivals}
        for what, figure in COMPARED.items()
    }


def reached(runs, way, *who):
    """Of the runs, how many of these contenders all have a drive at the common margin."""
    return sum(all(run["contenders"][w]["road"][way] is not None for w in who) for run in runs)


def worst(values):
    """The largest; never settling is worse than all."""
    values = list(values)
    return None if any(v is None for v in values) else max(values)


def rows(runs):
    """One flat row for each case, seed and contender."""
    for run in runs:
        for who in NAMES:
            found = run["contenders"][who]
            row = {"case": run["case"], "seed": run["seed"], "contender": who}
            if who == IDENTIFIED:
                row |= run["identification"]
            row["settling_prediction_error_s"] = prediction_error_s(run, who)
            for part in ("predicted", "achieved"):
                row |= {f"{part}_{key}": value for key, value in found[part].items()}
            row["modulus_margin_predicted"] = found["modulus_margin_predicted"]
            row["gains_times_at_equal_margin"] = found["gains_times"]
            row["modulus_margin_on_the_car"] = found["modulus_margin_on_the_car"]
            for reception in (CORRECTED, DROP_OUT, UNCORRECTED):
                scores = found["road"][reception.name]
                row |= {f"{reception.name}_{key}": value for key, value in scores.items()}
            row["modulus_margin_asked_re-designed"] = found["modulus_margin_asked"]
            for way in (EQUAL_MARGIN, REDESIGNED):
                scores = found["road"][way] or {}
                row |= {f"{way}_{key}": value for key, value in scores.items()}
            yield row


def write_csv(runs, file):
    table = list(rows(runs))
    names = list(dict.fromkeys(name for row in table for name in row))
    with file.open("w", newline="") as out:
        writer = csv.DictWriter(out, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
