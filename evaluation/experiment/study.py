"""One seed of one case: from its drive to all that is scored."""

import hashlib
import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import compiled
import contenders
import numpy as np
import oracle
import pid_law
import road
import sensors
import vehicle
import yaw_step
from contenders import ERRORS, FITTED, FIXED, IDENTIFIED, LAG, NAMES, NO_LAG, ORACLE, Workshop
from pid_file import gains_of, limits_of
from pid_law import modulus_margin, sampled_yaw, steady_gain
from units import Archive

ROAD_ACCELERATION_MPS2 = 4.0  # where the road is curved most
LAW_TOLERANCE_RAD = 1e-9
EQUAL_MARGIN = "equal margin"  # as if a way of reception
REDESIGNED = "re-designed"  # likewise
EQUAL, AGAIN = "equal", "again"  # folders of the controllers with that margin
SERVO_INCREMENT_RAD = vehicle.SERVO_RATE_LIMIT_RADPS * road.SAMPLE_TIME_S
TRACED_SEED = 1  # whose traces are kept for the figures


@dataclass
class Study:
    """Where files go, and who makes them."""

    workshop: Workshop
    estimator: Path | None
    out: Path
    key: str

    def seed_folder(self, case, seed):
        return self.out / "work" / case.name / f"seed_{seed:03}"

    def folder(self, case, who, seed=None):
        """A contender's files; those of [`FIXED`] are the same for every seed."""
        shared = self.out / "work" / case.name
        made = shared if who in FIXED else self.seed_folder(case, seed)
        made /= contenders.file_name(who)
        made.mkdir(parents=True, exist_ok=True)
        return made

    def keep(self, case, who, what, seed, **arrays):
        """Traces for the figures."""
        if seed in (None, TRACED_SEED):
            file = trace_file(self.out, case.name, who, what)
            file.parent.mkdir(parents=True, exist_ok=True)
            np.savez_compressed(file, **arrays)

    # ---- What is the same for every seed ----

    def prepare(self, case):
        """Controllers of [`FIXED`], packed, and their yaw steps; returns what was found."""
        file = self.out / "cases" / f"{case.name}.json"
        packed = all((self.folder(case, who) / "ReferencePath.fmu").exists() for who in FIXED)
        if packed and (done := unchanged(file, self.key)):
            return done
        car = case.car
        start, shop = car.at_start(case.speed), self.workshop
        found = {"key": self.key, "case": case.name, "contenders": {}}
        pids = {}
        for who, lag in ((NO_LAG, contenders.NO_LAG_S), (LAG, case.lag)):
            folder = self.folder(case, who)
            _, pids[who] = shop.datasheet(case, folder, lag=lag)
        tuned = self.tuned(case, pids[LAG])
        folder = self.folder(case, ORACLE)
        loop = sampled_yaw(car, case.speed)
        pids[ORACLE] = shop.oracle(pids[LAG], tuned["gains"], tuned["margin"], loop, folder)
        for who, pid in pids.items():
            found["contenders"][who] = self.contender(case, who, start, pid)
        # What the car itself does in the step is the oracle's prediction.
        best = found["contenders"][ORACLE]
        best["predicted"] = best["achieved"]
        found["datasheet"] = case.datasheet()
        write(file, found)
        return found

    def tuned(self, case, pid):
        """The oracle's gains, which no change of the command line touches."""
        kept = [pid["specification"][name] for name in ("overshoot_percent", "modulus_margin")]
        stated = json.dumps([kept, pid["limits"]], sort_keys=True)
        key = hashlib.sha256(stated.encode())
        for module in (compiled, oracle, pid_law, vehicle, yaw_step):
            key.update(Path(module.__file__).read_bytes())
        file = self.out / "oracle" / f"{case.name}.json"
        if done := unchanged(file, key.hexdigest()):
            return done
        gains, margin = oracle.tune(case.car, case.speed, pid)
        found = {"key": key.hexdigest(), "gains": gains, "margin": margin}
        write(file, found)
        return found

    def contender(self, case, who, start, pid, seed=None):
        """Its yaw step, and its way along the road packed."""
        folder = self.folder(case, who, seed)
        found = self.steps(case, who, start, pid, seed)
        found["path"] = self.workshop.path(case.speed, ROAD_ACCELERATION_MPS2, folder)
        loop = sampled_yaw(case.car, case.speed)
        factor = self.workshop.at_margin(pid, *loop, folder / EQUAL)
        if factor is not None:
            self.workshop.path(case.speed, ROAD_ACCELERATION_MPS2, folder / EQUAL)
        found["gains_times"] = factor
        asked = self.workshop.redesigned(who, pid, *loop, folder)
        found["modulus_margin_asked"] = asked
        if asked not in (None, pid["specification"]["modulus_margin"]):
            self.workshop.path(case.speed, ROAD_ACCELERATION_MPS2, folder / AGAIN)
        found["path"]["steering_rate_radps"] = needed_steering_rate(case, found["path"])
        return found

    def steps(self, case, who, start, pid, seed):
        """Predicted and achieved metrics of the yaw step of the packed controller."""
        archive = Archive(self.folder(case, who, seed) / "LateralPid.fmu")
        response = yaw_step.respond(case.car, case.speed, archive, start)
        archive.remove()
        check_law(case, start, pid, response)
        predicted = pid["evidence"]["step"]
        keys = ("overshoot_percent", "settling_time_s", "steady_state_error_percent")
        loop = gains_of(pid), *sampled_yaw(case.car, case.speed)
        self.keep(case, who, "step", seed, yaw=response[0], u=response[1])
        return {
            "gains": dict(pid["gains"]),
            "guidance": dict(pid["guidance"]),
            "predicted": {key: predicted[key] for key in keys},
            "achieved": yaw_step.metrics(*response).as_dict(),
            "modulus_margin_predicted": pid["evidence"]["margins"]["modulus_margin"],
            "modulus_margin_on_the_car": modulus_margin(*loop),
        }

    # ---- One seed ----

    def run(self, case, seed):
        file = self.out / "seeds" / f"{case.name}_{seed:03}.json"
        if done := unchanged(file, self.key):
            return done
        common = self.prepare(case)
        start = case.car.at_start(case.speed)
        folder = self.seed_folder(case, seed)
        folder.mkdir(parents=True, exist_ok=True)
        log = folder / "drive.csv"
        states, acceleration = case.record(log, seed)
        fixes = folder / "fixes.csv"
        case.record_fixes(fixes, seed, states)
        found = {"key": self.key, "case": case.name, "seed": seed, "contenders": {}}
        shop, pids = self.workshop, {}
        plant, pids[IDENTIFIED] = shop.identified(log, fixes, self.folder(case, IDENTIFIED, seed))
        _, pids[FITTED] = shop.fitted(case, log, self.folder(case, FITTED, seed))
        _, pids[ERRORS] = shop.with_errors(case, seed, self.folder(case, ERRORS, seed))
        found["identification"] = identification(plant)
        slip = sideslip(plant)
        found["drive"] = {"largest_lateral_acceleration_mps2": acceleration, "sideslip": slip}
        for who in NAMES:
            if who in FIXED:
                one = dict(common["contenders"][who])
            else:
                one = self.contender(case, who, start, pids[who], seed)
            found["contenders"][who] = one | {"road": self.roads(case, seed, who, slip, one)}
        if seed != TRACED_SEED:
            shutil.rmtree(folder)
        write(file, found)
        return found

    def roads(self, case, seed, who, slip, contender):
        """Each reception's drive along the road, and that at equal margin."""
        folder, length = self.folder(case, who, seed), contender["path"]["length_m"]
        estimator = Archive(self.estimator) if self.estimator else None
        duration = length / case.speed
        # In the first half of the seeds in the lane change, later in the turns: where it happens.
        lost = np.random.default_rng([*case.seed(4), seed]).uniform(1.0, duration - 5.0)

        def drive(where, receptions):
            archives = [Archive(where / f"{name}.fmu") for name in ("ReferencePath", "LateralPid")]
            loop = road.Loop(estimator, *archives)
            count = round((duration + road.LEAD_IN_S + road.MARGIN_S) / road.SAMPLE_TIME_S) + 1
            for reception in receptions:
                errors = [*case.seed(5), seed]
                read = sensors.Sensors(reception, errors, road.LEAD_IN_S + lost, count)
                yield reception, *road.follow(case.car, case.speed, loop, read, slip, length)
            for archive in archives:
                archive.remove()

        traces, scores = {}, {}
        for reception, trace, finished in drive(folder, sensors.RECEPTIONS):
            traces[reception.name] = trace
            scores[reception.name] = road_scores(trace, finished)
        scores[sensors.DROP_OUT.name] |= drop_out_scores(traces, lost)
        scores[EQUAL_MARGIN] = None
        if contender["gains_times"] is not None:
            for _, trace, finished in drive(folder / EQUAL, [sensors.CORRECTED]):
                scores[EQUAL_MARGIN] = road_scores(trace, finished)
                traces[EQUAL_MARGIN] = trace
        asked = contender["modulus_margin_asked"]
        # One whose margin with the car is enough stays as it is.
        scores[REDESIGNED] = None if asked is None else scores[sensors.CORRECTED.name]
        if asked in contenders.HIGHER_MARGINS:
            for _, trace, finished in drive(folder / AGAIN, [sensors.CORRECTED]):
                scores[REDESIGNED] = road_scores(trace, finished)
        if estimator:
            estimator.remove()
        if seed == TRACED_SEED:
            self.keep(case, who, "road", seed, **traces)
        return scores


def points_file(out, case_name):
    """The road of a case, the same for every contender but for its guidance."""
    return out / "work" / case_name / contenders.file_name(LAG) / "path.json"


def trace_file(out, case_name, who, what):
    return out / "traces" / case_name / f"{contenders.file_name(who)}_{what}.npz"


def unchanged(file, key):
    """An outcome of the same program and the same experiment; `None` where there is none."""
    if not file.exists():
        return None
    found = json.loads(file.read_text())
    return found if found["key"] == key else None


def check_law(case, start, pid, response):
    """The law that the oracle was tuned with is the packed one."""
    gains, limits, count = gains_of(pid), limits_of(pid), len(response[0])
    p, height = case.car.parameters, yaw_step.STEP_RAD
    again = pid_law.respond(start.copy(), case.speed, p, gains, limits, height, count)
    if not np.all(np.isfinite(again[0])):
        return  # lost either way
    off = max(float(np.max(np.abs(a - b))) for a, b in zip(again, response))
    if off > LAW_TOLERANCE_RAD:
        raise RuntimeError(f"{case.name}: the packed LateralPid differs from its law by {off} rad")


def identification(plant):
    evidence = plant["evidence"]
    return {
        "order": len(plant["discrete"]["A"]),
        "method": evidence["method"],
        "fit_percent": evidence["fit"]["validation"],
    }


def sideslip(plant):
    """That of the drive's fixes, by the parameters of the FMUs. Every contender is guided
    with it, since it is a property of the car and not of a controller."""
    stated = plant["sideslip"]
    terms = {
        "sideslip_growth": "sideslip_growth_s5pm2",
        "sideslip_per_yaw_acceleration": "sideslip_per_yaw_acceleration_s2",
        "distance_rear": "distance_rear_m",
    }
    found = {name: stated[key]["value"] for name, key in terms.items() if key in stated}
    speed = {"sideslip_reference_speed": plant["operating_point"]["speed_mps"]}
    return {"sideslip_per_yaw_rate": stated["sideslip_per_yaw_rate_s"]} | speed | found


def needed_steering_rate(case, way):
    """Steering of a steady turn, changed as quickly as the road's curvature, rad/s."""
    slope, gain = way["largest_curvature_slope_per_m2"], steady_gain(case.car, case.speed)
    return slope * case.speed**2 / gain


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def road_scores(trace, finished):
    column = dict(zip(road.TRACED, trace.T))
    command = column["command"]
    return {
        "finished": bool(finished),
        "cross_track_rms_m": rms(column["cross_track"]),
        "cross_track_largest_m": float(np.max(np.abs(column["cross_track"]))),
        "course_rms_rad": rms(column["course"]),
        "course_largest_rad": float(np.max(np.abs(column["course"]))),
        "steering_rate_rms_radps": rms(np.diff(command)) / road.SAMPLE_TIME_S,
        "at_rate_limit": float(np.mean(np.abs(np.diff(command)) > 0.999 * SERVO_INCREMENT_RAD)),
        "estimated_position_rms_m": rms(column["position"]),
        "estimated_yaw_rms_rad": rms(column["yaw"]),
    }


def drop_out_scores(traces, lost):
    """What 2 s without fixes do, against the same drive with them."""
    with_fixes, without = (traces[r.name] for r in (sensors.CORRECTED, sensors.DROP_OUT))
    shared = min(len(with_fixes), len(without))
    off = without[:shared, 1] - with_fixes[:shared, 1]
    begin = round(lost / road.SAMPLE_TIME_S)
    back = begin + round((sensors.DROP_OUT.drop_out_s + sensors.LATENCY_S) / road.SAMPLE_TIME_S)
    within = np.abs(without[begin : back + 300, 1])
    returning = off[back : back + 500]
    away = float(returning[0]) if len(returning) else 0.0
    beyond = np.max(-np.sign(away) * returning) if len(returning) else 0.0
    return {
        "drop_out_from_s": float(lost),
        "drop_out_largest_m": float(np.max(within)) if len(within) else None,
        "drop_out_away_at_return_m": abs(away),
        "drop_out_overshoot_m": float(max(0.0, beyond)),
    }


def write(file, value):
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part")
    part.write_text(json.dumps(value, indent=1) + "\n")
    part.replace(file)
