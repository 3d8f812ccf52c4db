"""What a home does to a recording: other rates, lost samples, gaps; against the walk as it was."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

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
from gaitway.samples import Gap, SampleBatch

SAME = (Target("worst_percent", 0.5),)
LITTLE_MORE = (Target("mean_abs_percent", 1.0),)


def robustness(device: str, plans: Sequence[WalkPlan], params: Mapping) -> list[Experiment]:
    """Return the rows that every device has."""
    rows = {
        "50 Hz, against 100 Hz": (partial(_at_rate, 50.0), SAME),
        "200 Hz, against 100 Hz": (partial(_at_rate, 200.0), SAME),
        "2 % of samples lost, against none": (_thinned, LITTLE_MORE),
        "a gap of 0.5 s, against none": (_interrupted, LITTLE_MORE),
    }
    return [
        row(device, name, plans, partial(method, device, params), targets)
        for name, (method, targets) in rows.items()
    ]


def row(
    device: str,
    name: str,
    plans: Sequence[WalkPlan],
    method: Callable[[WalkPlan], list[Outcome]],
    targets: Sequence[Target],
) -> Experiment:
    """Return an experiment with the default method alone."""
    return Experiment(
        device=device, name=name, plans=plans, methods={"default": method},
        figures=distance_figures, targets=targets,
    )  # fmt: skip


def whole(device: str, params: Mapping, plan: WalkPlan) -> list[Outcome]:
    """Return the distance of a walk as it is."""
    walk, batch = simulated(device, plan)
    return [distance_outcome(estimated(device, params, batch), walk.distance_m)]


def _at_rate(rate_hz: float, device: str, params: Mapping, plan: WalkPlan) -> list[Outcome]:
    batch = simulated(device, replace(plan, rate_hz=rate_hz))[1]
    return [distance_outcome(estimated(device, params, batch), _usual_m(device, params, plan))]


def _thinned(device: str, params: Mapping, plan: WalkPlan) -> list[Outcome]:
    batch = simulated(device, plan)[1]
    kept = np.random.default_rng(plan.seed).random(len(batch)) >= 0.02
    kept[0] = True
    return [distance_outcome(_left(device, params, batch, kept), _usual_m(device, params, plan))]


def _interrupted(device: str, params: Mapping, plan: WalkPlan) -> list[Outcome]:
    walk, batch = simulated(device, plan)
    first_s, last_s = walk.stride_end_s[0], walk.stride_start_s[-1]
    gap_s = float(np.random.default_rng(plan.seed).uniform(first_s, last_s - 0.5))
    kept = np.ones(len(batch), dtype=bool)
    kept[round(gap_s * walk.rate_hz) : round((gap_s + 0.5) * walk.rate_hz)] = False
    return [distance_outcome(_left(device, params, batch, kept), _usual_m(device, params, plan))]


def _usual_m(device: str, params: Mapping, plan: WalkPlan) -> float:
    return distance_outcome(estimated(device, params, simulated(device, plan)[1]), 0.0).told


def _left(device: str, params: Mapping, batch: SampleBatch, kept) -> list:
    """Return the events of what is left of a walk."""
    device_type = registry().devices[device]
    C_db = rotation_from_mounting(device_type.default_mounting)
    estimator = device_type.make_estimator(device_type.params.model_validate(params), C_db)
    edges = [0, *(np.flatnonzero(np.diff(kept)) + 1).tolist(), len(kept)]
    events = []
    for begin, end in pairwise(edges):
        lost = Gap(int(batch.t_ns[begin]), end - begin, "lost")
        events += estimator.update(batch[begin:end] if kept[begin] else lost)
    return [*events, *estimator.finish()]
