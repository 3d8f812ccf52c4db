"""What an accuracy experiment is: walks with truth, methods, and the figures they are judged by.

``experiments/<device>.py`` holds those of one device: ``experiments()`` returns the simulated ones
and ``people(folder)``, where it is defined, those on recordings of people.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from gaitway.contracts import SimulatedWalk, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.registry import load_registry
from gaitway.samples import SampleBatch

BATCH = 100


@dataclass(frozen=True)
class Outcome:
    """One number of one walk, as a method told it and as it was.

    Attributes:
        told: What the estimator said; None where it said nothing.
        true: What it was.
        sigma: The standard deviation the estimator gave; None where the number has none.
        what: Which number, where a walk has several: ``distance``, ``height``, ``style``, ...
    """

    told: float | None
    true: float
    sigma: float | None = None
    what: str = "distance"


@dataclass(frozen=True)
class Target:
    """What the default method must reach: ``figure`` at most or at least ``limit``."""

    figure: str
    limit: float
    at_least: bool = False

    def met(self, figures: Mapping[str, float]) -> bool:
        value = figures[self.figure]
        return value >= self.limit if self.at_least else value <= self.limit


@dataclass(frozen=True)
class Experiment:
    """One row group of the table.

    Attributes:
        device: Name of the device type.
        name: What was done, as "3 m, sensor 0.575 m from the tip".
        plans: One for each walk, from seeds 1000 on, on which no parameter was chosen; the files of
            walks that were measured on people.
        methods: Label to what one walk by that method gives; the first is the default.
        figures: Outcomes of all walks, a list a walk, to the figures by name, unit in the name.
        targets: For the default method.
        paper: What the paper reports for the same, with its figure and unit.
        people: False: simulated. True: measured on people.
        quick: How many of the walks a quick look takes.
    """

    device: str
    name: str
    plans: Sequence[WalkPlan] | Sequence[Path]
    methods: Mapping[str, Callable[[Any], list[Outcome]]]
    figures: Callable[[Sequence[Sequence[Outcome]]], dict[str, float]]
    targets: Sequence[Target] = field(default=())
    paper: str = ""
    people: bool = False
    quick: int = 4


@lru_cache(maxsize=1)
def registry():
    return load_registry()


def simulated(device: str, plan: WalkPlan) -> tuple[SimulatedWalk, SampleBatch]:
    """Return a walk and its samples in the device frame."""
    device_type = registry().devices[device]
    walk = device_type.simulate(plan)
    t_ns = np.arange(len(walk.pos_n), dtype=np.int64) * round(1e9 / walk.rate_hz)
    C_db = rotation_from_mounting(device_type.default_mounting)
    return walk, mount(SampleBatch(t_ns, 1 / walk.rate_hz, 0, walk.channels), C_db)


def estimated(device: str, params: Mapping, batch: SampleBatch, trace: bool = False):
    """Return every event of a walk, and the trace where it is asked for."""
    device_type = registry().devices[device]
    C_db = rotation_from_mounting(device_type.default_mounting)
    estimator = device_type.make_estimator(device_type.params.model_validate(params), C_db)
    kept = estimator.start_trace() if trace else None
    events = []
    for start in range(0, len(batch), BATCH):
        events += estimator.update(batch[start : start + BATCH])
    events += estimator.finish()
    return (events, kept) if trace else events


def distance_outcome(events, true_m: float) -> Outcome:
    """Return the running distance at the end; 0 and no sigma where nothing was said."""
    told = [event for event in events if event.kind == "distance"]
    if not told:
        return Outcome(0.0, true_m, None)
    return Outcome(told[-1].distance_m, true_m, told[-1].distance_sigma_m)


def distance_figures(outcomes: Sequence[Sequence[Outcome]]) -> dict[str, float]:
    """Return the usual figures of distances: errors, ratio to the truth, coverage."""
    of = [outcome for walk in outcomes for outcome in walk if outcome.what == "distance"]
    error_m = np.array([outcome.told - outcome.true for outcome in of])
    true_m = np.array([outcome.true for outcome in of])
    ratio = 1.0 + error_m / true_m
    return {
        "mae_m": float(np.mean(np.abs(error_m))),
        "rmse_m": float(np.sqrt(np.mean(error_m**2))),
        "worst_percent": float(100.0 * np.max(np.abs(error_m / true_m))),
        "mean_abs_percent": float(100.0 * np.mean(np.abs(error_m / true_m))),
        "ratio_mean": float(np.mean(ratio)),
        "ratio_sd": float(np.std(ratio)),
        "inside_95_percent": inside_percent(of),
    }


def inside_percent(of: Sequence[Outcome]) -> float:
    """Return how many of the true numbers lie in the stated 95 % interval."""
    inside = [o.sigma is not None and abs(o.told - o.true) <= 1.96 * o.sigma for o in of]
    return float(100.0 * np.mean(inside))
