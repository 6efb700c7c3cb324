"""Figures of the outcome, as SVG: the loop, the roads, tracking with the identified plant and with the
bicycle model, yaw steps, cross-track errors, and the ratios to the rivals."""

import json
import math

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np
from contenders import ERRORS, FITTED, IDENTIFIED, LAG, NAMES, NO_LAG, ORACLE
from excitation import SAMPLE_TIME_S
from road import TRACED
from scores import ratios
from sensors import CORRECTED
from study import points_file, trace_file
from yaw_step import STEP_RAD

COLOURS = {
    IDENTIFIED: "#0072b2",
    NO_LAG: "#d55e00",
    LAG: "#e69f00",
    ERRORS: "#cc79a7",
    FITTED: "#009e73",
    ORACLE: "#000000",
}
# The same bytes each time: no date, and names by content.
matplotlib.rcParams["svg.hashsalt"] = "steerwright"
matplotlib.rcParams["font.size"] = 8


def draw(runs, out):
    cases = list(dict.fromkeys(run["case"] for run in runs))
    loop(out)
    paths(cases, out)
    tracking(cases, IDENTIFIED, out / "tracking_identified.svg", out)
    tracking(cases, NO_LAG, out / "tracking_bicycle.svg", out)
    yaw_steps(cases, out)
    the_road(cases, out)
    compared(runs, out)


def save(figure, file):
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)


def grid(cases):
    columns = min(3, len(cases))
    rows = math.ceil(len(cases) / columns)
    size = (4.0 * columns, 2.6 * rows)
    figure, axes = plt.subplots(rows, columns, figsize=size, squeeze=False, layout="constrained")
    return figure, list(zip(cases, axes.flat))


def legend(figure, axes):
    lines, names = axes[0][1].get_legend_handles_labels()
    figure.legend(lines, names, loc="outside lower center", ncols=3, fontsize=7)


def traces(out, case, who, what):
    file = trace_file(out, case, who, what)
    return np.load(file) if file.exists() else None


def road_of(out, case):
    """x, y in m and curvature in 1/m of the case's road."""
    points = np.array(json.loads(points_file(out, case).read_text())["points"])
    return points[:, 1], points[:, 2], points[:, 4]


def loop(out):
    """What measures what, and what of it is a packed FMU."""
    figure, axis = plt.subplots(figsize=(9.0, 2.9), layout="constrained")
    axis.set(xlim=(0, 18), ylim=(0, 5.6))
    axis.axis("off")
    boxes = {
        "estimator": (0.6, 3.0, 3.0, 1.4, "PoseEstimator\n(FMU, 100 Hz)", "#d7e8f4"),
        "path": (5.2, 3.0, 3.0, 1.4, "ReferencePath\n(FMU, 100 Hz)", "#d7e8f4"),
        "pid": (9.8, 3.0, 3.0, 1.4, "LateralPid\n(FMU, 100 Hz)", "#d7e8f4"),
        "car": (14.4, 3.0, 3.2, 1.4, "servo and 29-state car\n(speed held)", "#f3e3d0"),
        "sensors": (7.0, 0.3, 5.6, 1.3, "GNSS 10 Hz, 100 ms late; gyro with bias;\nwheel speed", "#eeeeee"),
    }
    for x, y, width, height, text, colour in boxes.values():
        axis.add_patch(plt.Rectangle((x, y), width, height, facecolor=colour, edgecolor="0.3"))
        axis.text(x + width / 2, y + height / 2, text, ha="center", va="center")

    def arrow(points, text, at):
        for a, b in zip(points, points[1:]):
            style = "-|>" if b == points[-1] else "-"
            drawn = {"arrowstyle": style, "lw": 1, "shrinkA": 0, "shrinkB": 0, "color": "0.2"}
            axis.annotate("", xy=b, xytext=a, arrowprops=drawn)
        axis.text(*at, text, ha="center", va="bottom", fontsize=7)

    arrow([(3.6, 3.7), (5.2, 3.7)], "x, y, ψ", (4.4, 3.75))
    arrow([(8.2, 3.7), (9.8, 3.7)], "ψ reference,\nfeedforward", (9.0, 3.75))
    arrow([(12.8, 3.7), (14.4, 3.7)], "steering\ncommand", (13.6, 3.75))
    arrow([(16.0, 3.0), (16.0, 0.95), (12.6, 0.95)], "position, yaw rate, speed", (14.4, 1.0))
    arrow([(7.0, 0.95), (2.1, 0.95), (2.1, 3.0)], "fixes, yaw rate, speed", (4.5, 1.0))
    arrow([(2.1, 4.4), (2.1, 5.0), (11.3, 5.0), (11.3, 4.4)], "ψ", (6.7, 5.02))
    save(figure, out / "loop.svg")


def paths(cases, out):
    """The road of each speed: from above, and its curvature."""
    speeds = {case.split("_")[1]: case for case in cases}
    figure, axes = plt.subplots(
        len(speeds), 2, figsize=(9.0, 1.9 * len(speeds)), squeeze=False, layout="constrained"
    )
    for (speed, case), (above, along) in zip(speeds.items(), axes):
        x, y, curvature = road_of(out, case)
        above.plot(x, y, color="0.2", lw=1)
        above.set(title=f"{speed.removesuffix('mps')} m/s", xlabel="x, m", ylabel="y, m", aspect="equal")
        along.plot(np.hypot(np.diff(x), np.diff(y)).cumsum(), curvature[1:], color="0.2", lw=1)
        along.set(xlabel="distance, m", ylabel="curvature, 1/m")
        along.grid(lw=0.3)
    save(figure, out / "paths.svg")


def tracking(cases, who, file, out):
    """Of one car, BMW where there is one: driven path, cross-track and course error, command."""
    shown = [c for c in cases if c.startswith("car2")] or cases
    rows = ("y, m", "cross-track\nerror, m", "course\nerror, °", "command, °")
    size = (3.4 * len(shown), 6.0)
    figure, axes = plt.subplots(
        len(rows), len(shown), figsize=size, squeeze=False, sharex="col", sharey="row", layout="constrained"
    )
    for case, column in zip(shown, axes.T):
        found = traces(out, case, who, "road")
        if found is None:
            continue
        value = dict(zip(TRACED, found[CORRECTED.name].T))
        x, y, _ = road_of(out, case)
        column[0].plot(x, y, color="0.6", lw=2.5, label="road")
        column[0].plot(value["x"], value["y"], color=COLOURS[who], lw=0.9, label="driven")
        column[0].set_title(case)
        for axis, name, unit in zip(column[1:], ("cross_track", "course", "command"), (1, None, None)):
            shown_value = value[name] if unit else np.degrees(value[name])
            axis.plot(value["x"], shown_value, color=COLOURS[who], lw=0.8)
        column[-1].set_xlabel("x, m")
        for axis in column:
            axis.grid(lw=0.3)
    for axis, label in zip(axes[:, 0], rows):
        axis.set_ylabel(label)
    axes[0, 0].legend(fontsize=7)
    save(figure, file)


def yaw_steps(cases, out):
    """Yaw over the step's height on the car, by contender, with the settling band."""
    figure, axes = grid(cases)
    for case, axis in axes:
        axis.axhspan(0.98, 1.02, color="0.9")
        for who in NAMES:
            found = traces(out, case, who, "step")
            if found is not None:
                time = SAMPLE_TIME_S * np.arange(len(found["yaw"]))
                axis.plot(time, found["yaw"] / STEP_RAD, color=COLOURS[who], lw=1, label=who)
        axis.set(title=case, xlim=(0, 1.5), ylim=(0, 1.3), xlabel="s", ylabel="yaw / 5°")
    legend(figure, axes)
    save(figure, out / "yaw_steps.svg")


def the_road(cases, out):
    """Cross-track error along the road, with corrected GNSS."""
    figure, axes = grid(cases)
    for case, axis in axes:
        for who in NAMES:
            found = traces(out, case, who, "road")
            if found is not None:
                column = dict(zip(TRACED, found[CORRECTED.name].T))
                axis.plot(
                    column["time"], column["cross_track"], color=COLOURS[who], lw=0.8, label=who
                )
        axis.set(title=case, xlabel="s", ylabel="cross-track error, m")
        axis.grid(lw=0.3)
    legend(figure, axes)
    save(figure, out / "road.svg")


def compared(runs, out):
    """Identified over rival, with confidence intervals; left of 1 is better."""
    found = ratios(runs)
    columns = 4
    shape = (math.ceil(len(found) / columns), columns)
    size = (2.6 * columns, 2.0 * shape[0])
    figure, axes = plt.subplots(*shape, figsize=size, sharey=True, layout="constrained")
    rivals = [who for who in NAMES if who != IDENTIFIED]
    for axis, (what, each) in zip(axes.flat, found.items()):
        axis.axvline(1.0, color="0.6", lw=0.8)
        for place, rival in enumerate(rivals):
            if each[rival] is not None:
                middle, low, high = each[rival]
                axis.plot([low, high], [place, place], color=COLOURS[rival])
                axis.plot(middle, place, "o", color=COLOURS[rival], ms=3)
        axis.set_xscale("log")
        shown = [value for r in each.values() if r is not None for value in r]
        least, most = min([*shown, 0.7]) / 1.1, max([*shown, 1.4]) * 1.1
        axis.set_xlim(least, most)
        ticks = [t for t in (0.03, 0.1, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 10.0) if least < t < most]
        axis.set_xticks(ticks, [f"{t:g}" for t in ticks])
        axis.minorticks_off()
        axis.set_title(what, fontsize=7)
    for axis in axes.flat[len(found) :]:
        axis.axis("off")
    for row in axes:
        row[0].set_yticks(range(len(rivals)), rivals)
    save(figure, out / "ratios.svg")
