"""The ankle: Wu, Wang & Pottie's 40 m and stairs, each trained on its own 3 m; robustness; people.

Every simulated walk has its own training walk by the same person with the same sensor.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from experiment import (
    Experiment,
    Outcome,
    Target,
    distance_figures,
    distance_outcome,
    estimated,
    inside_percent,
    registry,
    simulated,
)

from gaitway.contracts import CalibrationPart, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.offline.csv_input import read_csv
from gaitway.offline.run import run_estimator
from gaitway.samples import Gap, SampleBatch
from gaitway.simulation import NonWalking, non_walking

DEVICE = "ankle"
FIRST_SEED = 1000
METHODS = ("default", "published", "zupt")
LEVEL = (Target("mean_abs_percent", 2.0), Target("worst_percent", 4.0))
STAIRS = (Target("mean_abs_percent", 3.0), Target("height_mean_abs_percent", 5.0))
AWAY = ("waving", "leaning", "carried", "turning-on-the-spot", "lying", "still")
ITEMS_OF = SampleBatch | Gap
Change = Callable[[SampleBatch, WalkPlan], Sequence[ITEMS_OF]]


def experiments() -> list[Experiment]:
    return [*_papers(), *_robustness(), _coverage(), _hour()]


def people(folder: Path) -> list[Experiment]:
    """Return walks of people without a training walk: NO1 is on whom nothing was chosen."""
    paths = sorted(folder.glob("shank10m_*.csv"))
    groups = {
        "NO1 (held out)": [path for path in paths if "_NO1_" in path.stem],
        "NO2, NO3 (assumed_lever_m chosen on)": [p for p in paths if "_NO1_" not in p.stem],
    }
    return [
        Experiment(
            device=DEVICE, name=f"nominal 10 m, no training, {who}", plans=walks, people=True,
            methods={method: partial(_measured, method) for method in METHODS},
            figures=distance_figures, quick=len(walks),
        )
        for who, walks in groups.items() if walks
    ]  # fmt: skip


def _papers() -> list[Experiment]:
    level = [WalkPlan(40.0, seed=FIRST_SEED + n, repetition=1) for n in range(20)]
    methods = {method: partial(_trained, method, _whole) for method in METHODS}
    rows = [
        Experiment(
            device=DEVICE, name="40 m, trained on 3 m", plans=level, methods=methods,
            figures=_figures, targets=LEVEL,
            paper="mean abs. error 3.53 % (with zero velocity 13.4 %), 10 people",
        )
    ]  # fmt: skip
    for number, (terrain, told) in enumerate(
        {"stairs-up": "3.61 % (24.65 %)", "stairs-down": "4.06 % (8.14 %)"}.items(), start=1
    ):
        first = FIRST_SEED + 100 * number
        plans = [
            WalkPlan(8.0, seed=first + n, repetition=1, conditions={"terrain": terrain})
            for n in range(10)
        ]
        rows.append(
            Experiment(
                device=DEVICE, name=f"{terrain}, trained on 3 m level", plans=plans,
                methods=methods, figures=_figures, targets=STAIRS,
                paper=f"mean abs. error {told}, 4 people",
            )
        )  # fmt: skip
    return rows


def _robustness() -> list[Experiment]:
    walks = [WalkPlan(25.0, seed=FIRST_SEED + 300 + n, repetition=1) for n in range(6)]
    cheap = [replace(plan, conditions={"sensor": "cheap"}) for plan in walks]
    slow = [replace(plan, speed_mps=0.3, distance_m=12.0) for plan in walks]
    same = (Target("worst_percent", 0.5),)
    little_more = (Target("mean_abs_percent", 1.0),)
    level = (Target("mean_abs_percent", 2.0),)
    return [
        _row("50 Hz, against 100 Hz", walks, partial(_at_rate, 50.0), same),
        _row("200 Hz, against 100 Hz", walks, partial(_at_rate, 200.0), same),
        _row("2 % of samples lost, against none", walks, partial(_against, _thinned), little_more),
        _row("a gap of 0.5 s, against none", walks, partial(_against, _interrupted), little_more),
        _row("cheap sensor, 1 deg/s and 1 deg off", cheap, partial(_trained, "default", _whole),
             level),
        _row("shuffling at 0.3 m/s", slow, partial(_trained, "default", _whole), level),
        _row("turning back", [replace(plan, turn_back=True) for plan in walks],
             partial(_trained, "default", _whole), level),
    ]  # fmt: skip


def _coverage() -> Experiment:
    speeds = (None, 0.5, 0.9, 1.7)
    plans = [
        WalkPlan(
            10.0, seed=FIRST_SEED + 400 + n, repetition=1, speed_mps=speeds[n % 4],
            conditions={"sensor": ("mti", "cheap")[n % 2]},
        )
        for n in range(200)
    ]  # fmt: skip
    targets = (Target("inside_95_percent", 90.0, at_least=True),)
    return _row("200 walks of 10 m", plans, partial(_trained, "default", _whole), targets)


def _hour() -> Experiment:
    plans = [WalkPlan(1.0, seed=FIRST_SEED + 600 + n) for n in range(12)]
    return Experiment(
        device=DEVICE, name="an hour of no walking, 12 x 300 s", plans=plans,
        methods={"default": _no_walk},
        figures=lambda walks: {"false_strides": float(sum(o.told or 0 for w in walks for o in w))},
        targets=(Target("false_strides", 0.0),),
    )  # fmt: skip


def _row(name: str, plans: list[WalkPlan], method, targets) -> Experiment:
    return Experiment(
        device=DEVICE, name=name, plans=plans, methods={"default": method}, figures=_figures,
        targets=targets,
    )  # fmt: skip


def _figures(walks: Sequence[Sequence[Outcome]]) -> dict[str, float]:
    figures = distance_figures(walks)
    heights = [o for walk in walks for o in walk if o.what == "height" and o.told is not None]
    if heights:
        error_m = np.array([o.told - o.true for o in heights])
        figures["height_mae_m"] = float(np.mean(np.abs(error_m)))
        figures["height_inside_95_percent"] = inside_percent(heights)
        climbed_m = np.array([o.true for o in heights])
        if np.all(climbed_m != 0.0):
            figures["height_mean_abs_percent"] = float(100 * np.mean(np.abs(error_m / climbed_m)))
    return figures


def _learned(plan: WalkPlan) -> Mapping[str, Any]:
    """Return the parameters that a training walk by the same person gives."""
    device = registry().devices[DEVICE]
    sensor = {key: value for key, value in plan.conditions.items() if key == "sensor"}
    short = replace(plan, distance_m=3.0, repetition=0, turn_back=False, conditions=sensor)
    walk = device.simulate(short)
    t_ns = np.arange(len(walk.pos_n), dtype=np.int64) * round(1e9 / walk.rate_hz)
    items = [SampleBatch(t_ns, 1 / walk.rate_hz, 0, walk.channels)]
    C_db = rotation_from_mounting(device.default_mounting)
    (training,) = device.calibrations
    part = CalibrationPart(items, C_db)
    return training.fit(device.params(), training.options(), [part]).params


def _trained(method: str, change: Change, plan: WalkPlan) -> list[Outcome]:
    walk, batch = simulated(DEVICE, plan)
    events = _said({**_learned(plan), "method": method}, change(batch, plan))
    climbed_m = float(walk.truth["stride_height_m"].sum())
    summary = registry().devices[DEVICE].summarise(events)
    height = Outcome(summary["height_m"], climbed_m, summary["height_sigma_m"], "height")
    return [distance_outcome(events, walk.distance_m), height]


def _against(change: Change, plan: WalkPlan) -> list[Outcome]:
    """Return the distance of spoiled samples against that of the same unspoiled."""
    whole, spoiled = _trained("default", _whole, plan)[0], _trained("default", change, plan)[0]
    return [Outcome(spoiled.told, whole.told, spoiled.sigma)]


def _at_rate(rate_hz: float, plan: WalkPlan) -> list[Outcome]:
    """Return the distance at a rate against that at 100 Hz, with the same lever arm."""
    learned = _learned(plan)
    told = [
        distance_outcome(estimated(DEVICE, learned, simulated(DEVICE, at)[1]), plan.distance_m)
        for at in (replace(plan, rate_hz=rate_hz), plan)
    ]
    return [Outcome(told[0].told, told[1].told, told[0].sigma)]


def _said(params: Mapping[str, Any], items: Sequence[ITEMS_OF]):
    device = registry().devices[DEVICE]
    C_db = rotation_from_mounting(device.default_mounting)
    estimator = device.make_estimator(device.params.model_validate(params), C_db)
    events = [event for item in items for event in estimator.update(item)]
    return [*events, *estimator.finish()]


def _whole(batch: SampleBatch, _plan: WalkPlan) -> list[ITEMS_OF]:
    return [batch]


def _thinned(batch: SampleBatch, plan: WalkPlan) -> list[ITEMS_OF]:
    kept = np.flatnonzero(np.random.default_rng(plan.seed).random(len(batch)) > 0.02)
    items: list[ITEMS_OF] = []
    at = 0
    for index in kept.tolist():
        if index > at:
            items.append(Gap(int(batch.t_ns[at]), index - at, "lost"))
        items.append(batch[index : index + 1])
        at = index + 1
    return items


def _interrupted(batch: SampleBatch, plan: WalkPlan) -> list[ITEMS_OF]:
    missing = round(0.5 / batch.period_s)
    rng = np.random.default_rng(plan.seed)
    begin = int(rng.integers(len(batch) // 3, 2 * len(batch) // 3))
    gap = Gap(int(batch.t_ns[begin]), missing, "lost")
    return [batch[:begin], gap, batch[begin + missing :]]


def _no_walk(plan: WalkPlan) -> list[Outcome]:
    kind: NonWalking = AWAY[plan.seed % len(AWAY)]
    walk = non_walking(plan, kind, duration_s=300.0, device_to_imu_d=(0.0, 0.0, 0.1))
    t_ns = np.arange(len(walk.pos_n), dtype=np.int64) * round(1e9 / walk.rate_hz)
    C_db = rotation_from_mounting(registry().devices[DEVICE].default_mounting)
    batch = mount(SampleBatch(t_ns, 1 / walk.rate_hz, 0, walk.channels), C_db)
    events = estimated(DEVICE, {}, batch)
    return [Outcome(float(sum(event.kind == "stride" for event in events)), 0.0, what="strides")]


def _measured(method: str, path: Path) -> list[Outcome]:
    device = registry().devices[DEVICE]
    C_db = rotation_from_mounting(device.default_mounting)
    estimator = device.make_estimator(device.params(method=method), C_db)
    events = run_estimator(estimator, read_csv(path, device.requires), C_db)
    return [distance_outcome(events, 10.0)]
