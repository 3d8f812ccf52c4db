"""The crutch tip: pitch over straight and turning cycles, force, and stated intervals."""

from functools import partial

import numpy as np
from experiment import Experiment, Outcome, Target, estimated, inside_percent, simulated

from gaitway.contracts import WalkPlan

DEVICE = "crutch-tip"


def outcomes(params, plan) -> list[Outcome]:
    """Return the pitch RMS of each cycle, pitches five a second, and the peak of each stance."""
    walk, batch = simulated(DEVICE, plan)
    events, trace = estimated(DEVICE, params, batch, trace=True)
    rows, true = np.array(trace.rows), walk.truth
    error = np.degrees(rows[:, 0] - true["pitch_rad"])
    found = []
    bounds = zip(walk.stride_start_s, walk.stride_end_s, true["turning"], strict=True)
    for start_s, end_s, turning in bounds:
        cycle = error[int(start_s * walk.rate_hz) : int(end_s * walk.rate_hz)]
        what = "turning" if turning else "straight"
        found.append(Outcome(float(np.sqrt(np.mean(cycle**2))), 0.0, None, what))
    for row in range(0, len(rows), max(1, round(walk.rate_hz / 5))):
        pitch, sigma = rows[row, :2].tolist()
        found.append(Outcome(pitch, float(true["pitch_rad"][row]), sigma, "pitch"))
    loads = [event for event in events if event.kind == "load"]
    found.append(Outcome(float(len(loads)), float(len(true["peak_newton"])), None, "stances"))
    if len(loads) == len(true["peak_newton"]):
        found += [
            Outcome(load.peak_force_newton, float(peak), load.peak_force_sigma_newton, "force")
            for load, peak in zip(loads, true["peak_newton"], strict=True)
        ]
    return found


def figures(walks) -> dict[str, float]:
    """Return RMS errors, coverage and miscounted stances."""
    of = {what: [o for walk in walks for o in walk if o.what == what] for what in WHAT}

    def rms(what):
        return float(np.sqrt(np.mean([(o.told - o.true) ** 2 for o in of[what]])))

    found = {"straight_deg": rms("straight"), "force_newton": rms("force")}
    if of["turning"]:
        found["turning_deg"] = rms("turning")
    found["pitch_inside_95_percent"] = inside_percent(of["pitch"])
    found["force_inside_95_percent"] = inside_percent(of["force"])
    found["stances_wrong"] = float(sum(abs(o.told - o.true) for o in of["stances"]))
    return found


WHAT = ("straight", "turning", "pitch", "stances", "force")
METHODS = {method: partial(outcomes, {"method": method}) for method in ("default", "published")}
PITCH = [Target("straight_deg", 1.0), Target("turning_deg", 3.0), Target("stances_wrong", 0.0)]


def experiments() -> list[Experiment]:
    """Return the table's rows, what makes them harder, and the coverage."""

    def experiment(name, plans, targets, paper=""):
        return Experiment(DEVICE, name, plans, METHODS, figures, targets, paper)

    def there_and_back(seeds, **plan):
        return [WalkPlan(10.0, seed=seed, turn_back=True, **plan) for seed in seeds]

    paper = "1.40 deg straight, 15.3-27.5 deg turning; force 8.78 N"
    seeds = range(1000, 1006)
    rows = [experiment("5 m there and back x 6", there_and_back(seeds), PITCH, paper)]
    for rate_hz in (50.0, 200.0):
        plans = there_and_back(seeds, rate_hz=rate_hz)
        rows.append(experiment(f"the same at {rate_hz:.0f} Hz", plans, PITCH))
    for name, conditions in (
        ("cheap sensor", {"sensor": "cheap"}),
        ("no roll inclination", {"seen": "no-roll"}),
        ("force in volts", {"force": "volt"}),
    ):
        rows.append(experiment(name, there_and_back(seeds, conditions=conditions), PITCH))
    inside = [
        Target("pitch_inside_95_percent", 90.0, at_least=True),
        Target("pitch_inside_95_percent", 98.0),
        Target("force_inside_95_percent", 90.0, at_least=True),
    ]
    short = [WalkPlan(5.0, seed=1100 + k, turn_back=k % 2 == 1) for k in range(200)]
    return [*rows, experiment("200 short walks", short, inside)]
