"""The outcome as Markdown."""

import math

import numpy as np
from contenders import FITTED, IDENTIFIED, LAG, NAMES, NO_LAG, ORACLE, ERRORS
from scores import metric, prediction_error_s, ratios, reached, worst
from study import EQUAL_MARGIN, REDESIGNED
from sensors import CORRECTED, DROP_OUT, UNCORRECTED
from datasheet import bicycle_parameters
from vehicle import NAMES as NAMES_OF_CARS
from vehicle import SERVO_RATE_LIMIT_RADPS, SERVO_TIME_CONSTANT_S, published_parameters

# Targets of the yaw step, and the settling times of controllers tuned on the car itself.
OVERSHOOT_PERCENT, SETTLING_S, ERROR_PERCENT = 1.0, 1.0, 2.0
TUNED_SETTLING_S = {8: 0.64, 15: 0.54, 22: 0.47}
WITHIN = 1.25
CROSS_TRACK_RMS_M = 0.10
AS_DESIGNED = "cross-track RMS, corrected GNSS"
EQUAL = "cross-track RMS at equal modulus margin"
AGAIN = "cross-track RMS, re-designed"
DROP_OUT_M, DROP_OUT_OVERSHOOT_M = 0.5, 0.05

CARS = (
    "The data sheet of CommonRoad's 29-state cars, on which the data sheet designs are based. Servo "
    f"between command and road wheel: {SERVO_TIME_CONSTANT_S} s lag, {SERVO_RATE_LIMIT_RADPS} rad/s at most."
)
MEASURED = (
    "Recorded for identification: command, yaw rate and speed of a drive of 103 s at 100 Hz. On the road the "
    "packed estimator, path and controller run one after the other each 10 ms; a second ReferencePath at "
    "the true pose evaluates."
)
AT_MARGIN = (
    "Two comparisons. *A factor*: kp, ki and kd are multiplied by one factor, such that the loop with "
    "the car has the modulus margin required of every design. There may be no such factor: if the "
    "ratio of the gains leaves too little phase, neither lower nor higher gains help. Ratios are over "
    "the drives for which both designs have a factor; a design without one loses the comparison. "
    "*Re-designed*: the required margin of each design method is raised until the loop with the car has "
    "at least the original margin; designs that have it are not changed."
)
ROADS = (
    "Steering rate needed: the steering of a steady turn, changing at the rate of the road's curvature. The "
    f"servo turns at most {SERVO_RATE_LIMIT_RADPS} rad/s; at its limit: share of the samples, corrected GNSS."
)


def table(header, lines):
    text = [header, ["---"] * len(header), *lines]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in text)


def seconds(value):
    return "never" if value is None else f"{value:.3f} s"


def by_case(runs):
    found = {}
    for run in runs:
        found.setdefault(run["case"], []).append(run)
    return found


def speed_of(case):
    return int(case.split("_")[1].removesuffix("mps"))


def step_kept(run, who):
    """Whether the yaw step on the car meets its targets."""
    settling = metric(run, who, ("achieved", "settling_time_s"))
    return (
        metric(run, who, ("achieved", "overshoot_percent")) <= OVERSHOOT_PERCENT
        and settling is not None
        and settling <= SETTLING_S
        and metric(run, who, ("achieved", "steady_state_error_percent")) <= ERROR_PERCENT
    )


def step_soon(run, who):
    """Whether it settles about as quickly as one that is tuned on the car."""
    settling = metric(run, who, ("achieved", "settling_time_s"))
    return settling is not None and settling <= WITHIN * TUNED_SETTLING_S[speed_of(run["case"])]


def of(test, runs):
    """k of n"""
    return f"{sum(map(bool, map(test, runs)))} of {len(runs)}"


def cars(runs):
    """The vehicles: their data sheets."""
    sheets = {}
    for run in runs:
        number = int(run["case"][3])
        sheets[number] = bicycle_parameters(published_parameters(number))
    header = ["parameter", *(f"car {number}, {NAMES_OF_CARS[number]}" for number in sheets)]
    keys = list(next(iter(sheets.values())))
    return table(header, [[f"`{key}`", *(f"{sheet[key]:.5g}" for sheet in sheets.values())] for key in keys])


def steps(runs):
    """The yaw step: identified, predicted, achieved; the worst of the seeds."""
    header = ["case", "order", "fit", "overshoot", "settling", "predicted", "error at 5 s"]
    header += ["modulus on the car", "settling, tuned on the car", "kept", "within 25 %"]
    lines = []
    for case, seeds in by_case(runs).items():
        get = lambda *path: [metric(run, IDENTIFIED, path) for run in seeds]
        overshoot = max(get("achieved", "overshoot_percent"))
        settling = worst(get("achieved", "settling_time_s"))
        error = max(get("achieved", "steady_state_error_percent"))
        orders = sorted({run["identification"]["order"] for run in seeds})
        fits = [run["identification"]["fit_percent"] for run in seeds]
        lines.append(
            [
                case,
                ", ".join(map(str, orders)),
                f"{np.mean(fits):.2f} %",
                f"{overshoot:.2f} %",
                seconds(settling),
                seconds(worst(get("predicted", "settling_time_s"))),
                f"{error:.2f} %",
                f"{min(get('modulus_margin_on_the_car')):.3f}",
                seconds(metric(seeds[0], ORACLE, ("achieved", "settling_time_s"))),
                of(lambda run: step_kept(run, IDENTIFIED), seeds),
                of(lambda run: step_soon(run, IDENTIFIED), seeds),
            ]
        )
    return table(header, lines)


def contenders(runs):
    """Over all cases and seeds: how each contender's yaw step and road went."""
    header = ["designed on", "error of predicted settling", "error of predicted overshoot"]
    header += ["step meets all targets", "modulus on the car", "cross-track RMS", "largest"]
    header += ["course RMS", "steering rate RMS", "at its limit", "RMS, drop-outs", "RMS, uncorrected"]
    header += ["road finished"]
    lines = []
    for who in NAMES:
        get = lambda *path: [metric(run, who, path) for run in runs]
        road = lambda reception, key: get("road", reception.name, key)
        over = zip(get("predicted", "overshoot_percent"), get("achieved", "overshoot_percent"))
        kept = [step_kept(run, who) for run in runs]
        off = np.mean([prediction_error_s(run, who) for run in runs])
        cross = road(CORRECTED, "cross_track_rms_m")
        finished = [v for r in (CORRECTED, DROP_OUT, UNCORRECTED) for v in road(r, "finished")]
        lines.append(
            [
                who,
                "–" if who == ORACLE else f"{off:.3f} s",
                "–" if who == ORACLE else f"{np.mean([abs(a - b) for a, b in over]):.2f} %",
                f"{100 * np.mean(kept):.0f} %",
                f"{min(get('modulus_margin_on_the_car')):.3f}",
                f"{np.mean(cross):.3f} m",
                f"{np.mean(road(CORRECTED, 'cross_track_largest_m')):.3f} m",
                f"{math.degrees(np.mean(road(CORRECTED, 'course_rms_rad'))):.2f}°",
                f"{np.mean(road(CORRECTED, 'steering_rate_rms_radps')):.3f} rad/s",
                f"{100 * np.mean(road(CORRECTED, 'at_rate_limit')):.1f} %",
                f"{np.mean(road(DROP_OUT, 'cross_track_rms_m')):.3f} m",
                f"{np.mean(road(UNCORRECTED, 'cross_track_rms_m')):.3f} m",
                f"{sum(finished)} of {len(finished)}",
            ]
        )
    return table(header, lines)


def at_margin(runs):
    """The common modulus margin with the car, and the results on the road with it."""
    header = ["designed on", "margin on the car", "a factor exists", "factor", "RMS with it"]
    header += ["steering rate RMS with it", "re-designed", "required margin", "RMS re-designed"]
    lines = []
    for who in NAMES:
        get = lambda *path: [metric(run, who, path) for run in runs]

        def mean(values, form):
            values = [v for v in values if v is not None]
            return form.format(np.mean(values)) if values else "–"

        margins = get("modulus_margin_on_the_car")
        lines.append(
            [
                who,
                f"{min(margins):.3f} to {max(margins):.3f}",
                f"{reached(runs, EQUAL_MARGIN, who)} of {len(runs)}",
                mean(get("gains_times"), "{:.2f}"),
                mean(get("road", EQUAL_MARGIN, "cross_track_rms_m"), "{:.3f} m"),
                mean(get("road", EQUAL_MARGIN, "steering_rate_rms_radps"), "{:.3f} rad/s"),
                f"{reached(runs, REDESIGNED, who)} of {len(runs)}",
                mean(get("modulus_margin_asked"), "{:.2f}"),
                mean(get("road", REDESIGNED, "cross_track_rms_m"), "{:.3f} m"),
            ]
        )
    return table(header, lines)


def compared(runs):
    """Ratios of the identified design to each rival, with their confidence intervals."""
    rivals = [NO_LAG, LAG, ERRORS, FITTED, ORACLE]
    lines = [
        [what, *("–" if r[rival] is None else "{:.3f} ({:.3f}–{:.3f})".format(*r[rival]) for rival in rivals)]
        for what, r in ratios(runs).items()
    ]
    return table(["identified over", *rivals], lines)


def roads(runs):
    """The identified design on the road, case by case."""
    header = ["case", "curvature", "steering rate needed", "at its limit", "look-ahead", "preview"]
    header += ["sideslip per yaw rate", "its growth", "sideslip per yaw acceleration"]
    header += ["cross-track RMS", "largest", "RMS, drop-out", "largest, drop-out"]
    header += ["beyond the road on return", "RMS, uncorrected", "finished"]
    lines = []
    for case, seeds in by_case(runs).items():
        get = lambda reception, key: [
            metric(run, IDENTIFIED, ("road", reception.name, key)) for run in seeds
        ]
        # Terms that a drive does not determine are 0.
        slip = lambda term: np.mean([run["drive"]["sideslip"].get(term, 0.0) for run in seeds])
        guide = seeds[0]["contenders"][IDENTIFIED]["path"]
        guidance = guide["guidance"]
        every = [v for r in (CORRECTED, DROP_OUT, UNCORRECTED) for v in get(r, "finished")]
        ahead = max(guidance["lookahead_min_m"], guidance["lookahead_time_s"] * speed_of(case))
        lines.append(
            [
                case,
                f"{guide['largest_curvature_per_m']:.4f} 1/m",
                f"{guide['steering_rate_radps']:.3f} rad/s",
                f"{100 * np.mean(get(CORRECTED, 'at_rate_limit')):.1f} %",
                f"{ahead:.1f} m",
                f"{guidance['preview_time_s']:.3f} s",
                f"{slip('sideslip_per_yaw_rate'):.4f} s",
                f"{1e3 * slip('sideslip_growth'):.2f} ms per (m/s²)²",
                f"{slip('sideslip_per_yaw_acceleration'):.4f} s²",
                f"{max(get(CORRECTED, 'cross_track_rms_m')):.3f} m",
                f"{max(get(CORRECTED, 'cross_track_largest_m')):.3f} m",
                f"{max(get(DROP_OUT, 'cross_track_rms_m')):.3f} m",
                f"{worst(get(DROP_OUT, 'drop_out_largest_m')):.3f} m",
                f"{max(get(DROP_OUT, 'drop_out_overshoot_m')):.3f} m",
                f"{max(get(UNCORRECTED, 'cross_track_rms_m')):.3f} m",
                f"{sum(every)} of {len(every)}",
            ]
        )
    return table(header, lines)


def targets(runs):
    """The design targets with their results."""
    cases = by_case(runs)
    own = lambda run, *path: metric(run, IDENTIFIED, path)

    at_15 = [run for run in runs if speed_of(run["case"]) == 15]
    rms = [own(run, "road", CORRECTED.name, "cross_track_rms_m") for run in at_15]
    away = [own(run, "road", DROP_OUT.name, "drop_out_largest_m") for run in runs]
    beyond = [own(run, "road", DROP_OUT.name, "drop_out_overshoot_m") for run in runs]
    found = ratios(runs)

    def ratio_text(rival, what=AS_DESIGNED, way=None):
        r = found[what][rival]
        text = "none" if r is None else "{:.3f} ({:.3f}–{:.3f})".format(*r)
        if way is None or reached(runs, way, IDENTIFIED, rival) == len(runs):
            return text
        both = reached(runs, way, IDENTIFIED, rival)
        alone = reached(runs, way, IDENTIFIED) - both
        return f"{text} over {both} of {len(runs)} drives; {alone} with identified only"

    def every(test):
        """Of the cases, where each seed passes; and of all drives."""
        cases_kept = sum(all(map(test, seeds)) for seeds in cases.values())
        return f"{cases_kept} of {len(cases)} ({of(test, runs)} drives)"

    lines = [
        ["yaw step meets 1 %, 1 s, 2 %, every seed", "all cases", every(lambda run: step_kept(run, IDENTIFIED))],
        ["settling within 25 % of the tuned controller, every seed", "all cases", every(lambda run: step_soon(run, IDENTIFIED))],
        ["cross-track RMS at 15 m/s, corrected, worst seed", f"{CROSS_TRACK_RMS_M:.2f} m", f"{max(rms):.3f} m" if rms else "–"],
        ["in and after a drop-out, worst seed", f"{DROP_OUT_M} m", f"{max(away):.3f} m"],
        ["overshoot on return, worst seed", f"{DROP_OUT_OVERSHOOT_M} m", f"{max(beyond):.3f} m"],
    ]
    rivals = ((NO_LAG, "< 1"), (ERRORS, "< 1"), (LAG, "≤ 1.05"), (FITTED, "≤ 1.05"))
    for what, figure, way in (
        ("cross-track RMS over that of", AS_DESIGNED, None),
        ("at equal modulus margin with the car", EQUAL, EQUAL_MARGIN),
        ("re-designed to that margin", AGAIN, REDESIGNED),
    ):
        lines += [[f"{what}: {rival}", aim, ratio_text(rival, figure, way)] for rival, aim in rivals]
    return table(["quantity", "target", "result"], lines)


def everything(runs, conditions):
    seeds = len({run["seed"] for run in runs})
    return "\n\n".join(
        [
            "# Controllers on an independent vehicle model",
            conditions,
            f"{len(by_case(runs))} cases, {seeds} seeds each.",
            "## The cars",
            CARS,
            cars(runs),
            "## Measurement and loop",
            MEASURED,
            "## Design targets",
            targets(runs),
            "## Yaw step of 5° on the car, designed on the identified plant (worst seed)",
            steps(runs),
            "## Contenders as designed, means over all cases and seeds",
            contenders(runs),
            "## The common modulus margin with the car, means over the drives that have it",
            AT_MARGIN,
            at_margin(runs),
            "## Ratios: geometric mean, 95 % confidence interval",
            compared(runs),
            "## The road, identified design (worst seed)",
            ROADS,
            roads(runs),
        ]
    ) + "\n"


def failures(failed, succeeded):
    """The drives without a result, with the reason; they are not part of the other tables."""
    if not failed:
        return ""
    rows = [[run["case"], run["seed"], " ".join(run["failed"].split())] for run in failed]
    title = f"\n## Without a result: {len(failed)} of {len(failed) + succeeded} drives\n\n"
    return title + table(["case", "seed", "why"], rows) + "\n"
