r"""The speed profile of a path.json compared with what others compute for its limits.

    pip install numpy casadi trajectory-planning-helpers
    steerwright path road.toml --profile -o path.json
    python evaluation/python/speed_profile.py path.json

    python evaluation/python/speed_profile.py --circuit circuit.csv
    steerwright path circuit.csv --closed --profile --max-speed 60m/s --max-acceleration 5m/s2 --max-deceleration 50m/s2 \
        --max-lateral-acceleration 50m/s2 --friction 1.0 --max-jerk none -o circuit.json
    python evaluation/python/speed_profile.py circuit.json

`--circuit` writes the points of a closed road of 1.4 km.
`optimum` is the shortest time that Ipopt reaches (CasADi) on a discretisation of its own: speed and acceleration at the
points as unknowns, the jerk between them constant in time, collocated by the trapezoidal rule in the distance, from a low
constant speed and from the profile of the file itself. A start or an end at standstill has the speed of the profile
half a metre from it, since the rule does not hold there.
`two passes` is calc_vel_profile of trajectory-planning-helpers (TUM), for a profile without jerk and steering on a closed
path: its friction circle, motor limit and largest speed are those of the file.
Both print the time and the file's time over it.
"""

import importlib.util
import json
import pathlib
import sys
import types

import numpy as np

GRAVITY = 9.80665
# From a standstill, m.
AWAY = 0.5


def profile_of(document):
    """Distances, speeds, accelerations and curvatures, at points no closer than a quarter of a metre."""
    rows = np.array(document["profile"]["points"])
    path = np.array(document["points"])
    kept = [0]
    for k in range(1, len(rows) - 1):
        if rows[k, 0] - rows[kept[-1], 0] >= 0.25 and rows[-1, 0] - rows[k, 0] >= 0.25:
            kept.append(k)
    rows = rows[[*kept, len(rows) - 1]]
    distance, curvature = path[:, 0], path[:, 4]
    if document["closed"] and distance[-1] < rows[-1, 0]:
        distance, curvature = np.append(distance, rows[-1, 0]), np.append(curvature, curvature[0])
    return rows, np.interp(rows[:, 0], distance, curvature)


def time_along(distance, speed):
    return float(np.sum(2.0 * np.diff(distance) / (speed[1:] + speed[:-1])))


def optimum(document, from_file):
    """The shortest time by Ipopt, and the time of the file between the same two places, s."""
    import casadi

    rows, curvature = profile_of(document)
    limits, closed = document["profile"]["limits"], document["closed"]
    if not closed:
        inside = np.ones(len(rows), bool)
        if rows[0, 1] == 0.0:
            inside &= rows[:, 0] >= rows[0, 0] + AWAY
        if rows[-1, 1] == 0.0:
            inside &= rows[:, 0] <= rows[-1, 0] - AWAY
        rows, curvature = rows[inside], curvature[inside]
    distance, count = rows[:, 0], len(rows)
    h = np.diff(distance)
    problem = casadi.Opti()
    v, a = problem.variable(count), problem.variable(count)
    time = casadi.sum1(2.0 * h / (v[1:] + v[:-1]))
    problem.minimize(time)
    problem.subject_to(v[1:] ** 2 - v[:-1] ** 2 == h * (a[1:] + a[:-1]))
    problem.subject_to(problem.bounded(0.01, v, limits["max_speed_mps"]))
    lateral = v**2 * curvature
    bound = limits["max_lateral_acceleration_mps2"]
    problem.subject_to(problem.bounded(-bound, lateral, bound))
    problem.subject_to(
        problem.bounded(-limits["max_deceleration_mps2"], a, limits["max_acceleration_mps2"])
    )
    if jerk := limits.get("max_jerk_mps3"):
        mean = 0.5 * (v[1:] + v[:-1])
        problem.subject_to(problem.bounded(-jerk, (a[1:] - a[:-1]) / h * mean, jerk))
    if friction := limits.get("friction"):
        problem.subject_to(lateral**2 + a**2 <= (friction * GRAVITY) ** 2)
    if steering := limits.get("steering"):
        slow, gradient = steering["steering_per_curvature_radm"], steering["understeer_gradient_rads2pm"]
        per_curvature = slow + gradient * v**2
        if angle := steering.get("max_angle_rad"):
            problem.subject_to(problem.bounded(-angle, per_curvature * curvature, angle))
        if rate := steering.get("max_rate_radps"):
            slope = np.diff(curvature) / h
            for own, side in ((slice(0, -1), slope), (slice(1, None), slope)):
                of_speed = 2.0 * gradient * v[own] * curvature[own] * a[own]
                needed = per_curvature[own] * side * v[own] + of_speed
                problem.subject_to(problem.bounded(-rate, needed, rate))
    if closed:
        problem.subject_to(v[0] == v[-1])
        problem.subject_to(a[0] == a[-1])
    else:
        problem.subject_to(v[0] == rows[0, 1])
        problem.subject_to(v[-1] == rows[-1, 1])
        if limits.get("max_jerk_mps3"):
            problem.subject_to(a[0] == rows[0, 2])
            problem.subject_to(a[-1] == rows[-1, 2])
    problem.set_initial(v, rows[:, 1] if from_file else np.full(count, min(2.0, rows[:, 1].max())))
    problem.set_initial(a, rows[:, 2] if from_file else np.zeros(count))
    problem.solver("ipopt", {"print_time": False}, {"print_level": 0, "max_iter": 3000, "sb": "yes"})
    try:
        solution = problem.solve()
    except RuntimeError as error:
        return None, str(error).splitlines()[-1]
    return float(solution.value(time)), time_along(distance, rows[:, 1])


def two_passes(document):
    """The time of a lap by calc_vel_profile, s."""
    # The package imports a compiled solver that this function does not use.
    package = importlib.util.find_spec("trajectory_planning_helpers")
    folder = pathlib.Path(package.submodule_search_locations[0])
    sys.modules.setdefault("trajectory_planning_helpers", types.ModuleType("trajectory_planning_helpers"))
    modules = {}
    for name in ("conv_filt", "calc_vel_profile"):
        full = f"trajectory_planning_helpers.{name}"
        spec = importlib.util.spec_from_file_location(full, folder / f"{name}.py")
        modules[name] = sys.modules[full] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(modules[name])
    rows, curvature = profile_of(document)
    limits = document["profile"]["limits"]
    grip, top = limits["friction"] * GRAVITY, limits["max_speed_mps"]
    speeds = np.array([0.0, top + 1.0])
    constant = np.full(2, 1.0)
    speed = modules["calc_vel_profile"].calc_vel_profile(
        ax_max_machines=np.column_stack((speeds, limits["max_acceleration_mps2"] * constant)),
        kappa=curvature[:-1],
        el_lengths=np.diff(rows[:, 0]),
        closed=True,
        drag_coeff=0.0,
        m_veh=1000.0,
        ggv=np.column_stack((speeds, grip * constant, grip * constant)),
        v_max=top,
        dyn_model_exp=2.0,
    )
    return time_along(rows[:, 0], np.append(speed, speed[0]))


def circuit(count=900):
    """Points of a closed road, m."""
    angle = 2.0 * np.pi * np.arange(count) / count
    waves = 0.28 * np.cos(2 * angle) + 0.22 * np.sin(3 * angle) + 0.1 * np.cos(5 * angle + 1.0)
    radius = 180.0 * (1.0 + waves)
    rows = (f"{x:.4f},{y:.4f}" for x, y in zip(radius * np.cos(angle), radius * np.sin(angle)))
    return "\n".join(("x_m,y_m", *rows, ""))


if sys.argv[1:2] == ["--circuit"]:
    pathlib.Path(sys.argv[2]).write_text(circuit())
    sys.exit()
for file in sys.argv[1:]:
    document = json.loads(pathlib.Path(file).read_text())
    profile = document["profile"]
    limits = profile["limits"]
    print(f"{file}: {profile['time_s']:.3f} s")
    for label, from_file in (("from a low speed", False), ("from the file", True)):
        best, own = optimum(document, from_file)
        if best is None:
            print(f"  optimum {label}: Ipopt stopped: {own}")
        else:
            print(f"  optimum {label}: {best:.3f} s, the file {own:.3f} s: ratio {own / best:.5f}")
    grip = limits.get("friction", 0.0) * GRAVITY
    is_circle_alone = (
        document["closed"]
        and grip > 0.0
        and "max_jerk_mps3" not in limits
        and "steering" not in limits
        and min(limits["max_lateral_acceleration_mps2"], limits["max_deceleration_mps2"]) >= grip
    )
    if is_circle_alone:
        passes = two_passes(document)
        print(f"  two passes: {passes:.3f} s, ratio {profile['time_s'] / passes:.5f}")
