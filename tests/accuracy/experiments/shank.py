"""The shank: Orlowski & Loose's 20, 40 and 60 m at three speeds, robustness, and people."""

import json
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
from experiment import (
    Experiment,
    Outcome,
    Target,
    distance_figures,
    distance_outcome,
    estimated,
    registry,
    simulated,
)

from gaitway.contracts import WalkPlan
from gaitway.mounting import rotation_from_mounting
from gaitway.offline.csv_input import read_csv
from gaitway.offline.run import run_estimator
from gaitway.samples import Gap, SampleBatch

DEVICE = "shank"
PUBLISHED = ("wsi", "s1", "s2", "s3")
SPEEDS_MPS = {"slow": 0.85, "normal": 1.25, "fast": 1.65}
FIRST_SEED = 2000
WALKS = 8
CELL = (
    Target("ratio_mean", 1.02),
    Target("ratio_mean", 0.98, at_least=True),
    Target("ratio_sd", 0.04),
)
PAPER = "ratio 0.97 +- 0.09, cells 0.89 to 1.10 (103 of 144 recordings, outliers removed)"
Method = Callable[[WalkPlan], list[Outcome]]


def experiments() -> list[Experiment]:
    return [*_cells(), *_robustness(), _coverage()]


def people(folder: Path) -> list[Experiment]:
    by_person: dict[str, list[Path]] = defaultdict(list)
    for path in sorted(folder.glob("shank10m_*.csv")):
        by_person[path.stem.split("_")[1]].append(path)
    everybody = [path for paths in by_person.values() for path in paths]
    if not everybody:
        return []
    return [
        Experiment(
            device=DEVICE, name=f"nominal 10 m, {who}", plans=paths,
            methods={
                name: partial(_measured, params)
                for name, params in ({"default": {}} | _published()).items()
            },
            figures=distance_figures, people=True, quick=len(paths),
        )
        for who, paths in {**by_person, "all": everybody}.items()
    ]  # fmt: skip


def _cells() -> list[Experiment]:
    methods = {"default": _method({})} | {
        name: _method(params) for name, params in _published().items()
    }
    return [
        Experiment(
            device=DEVICE, name=f"{distance_m:.0f} m {pace}", methods=methods,
            plans=_plans(distance_m, speed_mps=speed_mps, first=FIRST_SEED + 10 * number),
            figures=distance_figures, targets=CELL, paper=PAPER,
        )
        for number, (distance_m, (pace, speed_mps)) in enumerate(
            (distance_m, pace) for distance_m in (20.0, 40.0, 60.0) for pace in SPEEDS_MPS.items()
        )
    ]  # fmt: skip


def _robustness() -> list[Experiment]:
    walks = _plans(20.0, first=FIRST_SEED + 100)
    same = (Target("worst_percent", 0.5),)
    little_more = (Target("mean_abs_percent", 1.0),)
    slow = [replace(plan, speed_mps=0.3) for plan in walks]
    flat = [replace(plan, conditions={"foot": "flat"}) for plan in walks]
    return [
        _row("50 Hz, against 100 Hz", walks, partial(_at_rate, 50.0), same),
        _row("200 Hz, against 100 Hz", walks, partial(_at_rate, 200.0), same),
        _row("2 % of samples lost, against none", walks, _thinned, little_more),
        _row("a gap of 0.5 s, against none", walks, _interrupted, little_more),
        _row("shuffling at 0.3 m/s", slow, _method({}), CELL[:2]),
        _row("a foot that stands flat", flat, _method({}), ()),
    ]


def _coverage() -> Experiment:
    plans = [WalkPlan(10.0, seed=seed) for seed in range(FIRST_SEED + 200, FIRST_SEED + 400)]
    targets = (
        Target("inside_95_percent", 90.0, at_least=True),
        Target("inside_95_percent", 98.0),
    )
    return _row("200 walks of 10 m", plans, _method({}), targets)


def _row(name: str, plans: list[WalkPlan], method: Method, targets) -> Experiment:
    return Experiment(
        device=DEVICE, name=name, plans=plans, methods={"default": method},
        figures=distance_figures, targets=targets,
    )  # fmt: skip


def _published() -> dict[str, Mapping[str, str]]:
    return {name: {"method": name} for name in PUBLISHED}


def _plans(distance_m: float, first: int, speed_mps: float | None = None) -> list[WalkPlan]:
    return [
        WalkPlan(distance_m, seed=first + number, speed_mps=speed_mps) for number in range(WALKS)
    ]


def _method(params: Mapping[str, str]) -> Method:
    return partial(_walked, params)


def _walked(params: Mapping[str, str], plan: WalkPlan) -> list[Outcome]:
    walk, batch = simulated(DEVICE, plan)
    return [distance_outcome(estimated(DEVICE, params, batch), walk.distance_m)]


def _told_m(batch: SampleBatch) -> float:
    return distance_outcome(estimated(DEVICE, {}, batch), 0.0).told


def _at_rate(rate_hz: float, plan: WalkPlan) -> list[Outcome]:
    """Compare a rate with 100 Hz: the same person, walk and sensor."""
    usual_m = _told_m(simulated(DEVICE, plan)[1])
    batch = simulated(DEVICE, replace(plan, rate_hz=rate_hz))[1]
    return [distance_outcome(estimated(DEVICE, {}, batch), usual_m)]


def _thinned(plan: WalkPlan) -> list[Outcome]:
    _, batch = simulated(DEVICE, plan)
    kept = np.random.default_rng(plan.seed).random(len(batch)) >= 0.02
    kept[0] = True
    return [distance_outcome(_events_of(batch, kept), _told_m(batch))]


def _interrupted(plan: WalkPlan) -> list[Outcome]:
    walk, batch = simulated(DEVICE, plan)
    first_s, last_s = walk.stride_end_s[0], walk.stride_start_s[-1]
    gap_s = float(np.random.default_rng(plan.seed).uniform(first_s, last_s - 0.5))
    kept = np.ones(len(batch), dtype=bool)
    kept[round(gap_s * walk.rate_hz) : round((gap_s + 0.5) * walk.rate_hz)] = False
    return [distance_outcome(_events_of(batch, kept), _told_m(batch))]


def _events_of(batch: SampleBatch, kept) -> list:
    """Return the events of what is left of a walk."""
    device = registry().devices[DEVICE]
    C_db = rotation_from_mounting(device.default_mounting)
    estimator = device.make_estimator(device.params(), C_db)
    edges = [0, *(np.flatnonzero(np.diff(kept)) + 1).tolist(), len(kept)]
    events = []
    for begin, end in pairwise(edges):
        lost = Gap(int(batch.t_ns[begin]), end - begin, "lost")
        events += estimator.update(batch[begin:end] if kept[begin] else lost)
    return [*events, *estimator.finish()]


def _measured(params: Mapping[str, str], path: Path) -> list[Outcome]:
    device = registry().devices[DEVICE]
    C_db = rotation_from_mounting(device.default_mounting)
    estimator = device.make_estimator(device.params.model_validate(params), C_db)
    events = run_estimator(estimator, read_csv(path, device.requires), C_db)
    truth = json.loads((path.parent / "truth.json").read_text())
    return [distance_outcome(events, truth[path.stem]["distance_m"])]
