"""Figures of the outcome, as SVG: yaw steps, the road, and the ratios to the rivals."""

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
from study import trace_file
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
