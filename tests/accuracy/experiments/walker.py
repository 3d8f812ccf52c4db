"""The walker: Doan & Pham's 20 m in four styles, robustness, coverage, and what is no walking."""

from collections.abc import Callable, Mapping, Sequence
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
    simulated,
)

from gaitway.contracts import WalkPlan
from gaitway.samples import Gap, SampleBatch

DEVICE = "walker"
FIRST_SEED = 1000
WALKS = 25
LIMITS_M = {"continuous": 0.10, "step-by-step": 0.10, "full-lift": 0.25, "back-tips": 0.20}
PAPER_M = {"continuous": 0.412, "step-by-step": 0.200, "full-lift": 0.473, "back-tips": 0.369}
NOT_WALKING = ("stand", "lean", "turn-on-the-spot", "carry", "rock", "drag")
Cut = Callable[[SampleBatch, int], list[SampleBatch | Gap]]


def experiments() -> list[Experiment]:
    return [*_styles(), *_robustness(), _not_walking(), _coverage()]


def _styles() -> list[Experiment]:
    return [
        Experiment(
            device=DEVICE, name=f"20 m {style}", figures=figures, quick=5,
            plans=[_plan(20.0, FIRST_SEED + 30 * number + walk, style=style)
                   for walk in range(WALKS)],
            methods={"default": _walked(), "published": _walked({"method": "published"})},
            targets=(Target("rmse_m", LIMITS_M[style]), Target("style_percent", 98.0, True)),
            paper=f"RMSE {PAPER_M[style]:.3f} m",
        )
        for number, style in enumerate(LIMITS_M)
    ]  # fmt: skip


def _robustness() -> list[Experiment]:
    hard = {"sensor": "cheap", "tilt_deg": 1.0, "shock": 3.0}
    rows = {
        "50 Hz": ({}, {"rate_hz": 50.0}, None),
        "200 Hz": ({}, {"rate_hz": 200.0}, None),
        "2 % of samples lost": ({}, {}, _lose_samples),
        "0.5 s gaps": ({}, {}, _lose_halves),
        "cheap sensor, 1 deg awry, hard shocks": (hard, {}, None),
        "0.3 m/s": ({"step_m": 0.25}, {"speed_mps": 0.3}, None),
        "four corners": ({"turns": 4.0}, {}, None),
    }
    return [
        Experiment(
            device=DEVICE, name=f"20 m mixed, {name}", figures=figures, quick=2,
            plans=[_plan(20.0, FIRST_SEED + 200 + walk, style="mixed", more=conditions, **plan)
                   for walk in range(6)],
            methods={"default": _walked(cut=cut)},
            targets=(Target("rmse_m", 0.25), Target("style_percent", 95.0, True)),
        )
        for name, (conditions, plan, cut) in rows.items()
    ]  # fmt: skip


def _not_walking() -> Experiment:
    plans = [
        WalkPlan(10.0, seed=FIRST_SEED + 300 + number, conditions={"does": does})
        for number in range(9)
        for does in NOT_WALKING
    ]
    return Experiment(
        device=DEVICE, name="not walking", plans=plans, methods={"default": _idled},
        figures=_idle_figures, targets=(Target("false_strides", 0.0),), quick=6,
    )  # fmt: skip


def _coverage() -> Experiment:
    sensors = ("mti", "cheap")
    plans = [
        _plan(6.0, FIRST_SEED + 500 + walk, style=list(LIMITS_M)[walk % 4],
              more={"sensor": sensors[walk // 4 % 2]})
        for walk in range(200)
    ]  # fmt: skip
    return Experiment(
        device=DEVICE, name="6 m in every style, coverage", plans=plans,
        methods={"default": _walked()}, figures=figures, quick=20,
        targets=(Target("inside_95_percent", 90.0, True),),
    )  # fmt: skip


def figures(outcomes: Sequence[Sequence[Outcome]]) -> dict[str, float]:
    """Return those of distances, and how many of the steps have the right style."""
    of_steps = [o for walk in outcomes for o in walk if o.what == "style"]
    right = sum(o.told for o in of_steps) / sum(o.true for o in of_steps)
    return distance_figures(outcomes) | {"style_percent": 100.0 * right}


def _plan(distance_m: float, seed: int, style: str, more: Mapping = {}, **changes) -> WalkPlan:
    return WalkPlan(distance_m, seed=seed, conditions={"style": style, **more}, **changes)


def _walked(params: Mapping = {}, cut: Cut | None = None):
    return partial(_outcomes, params, cut)


def _outcomes(params: Mapping, cut: Cut | None, plan: WalkPlan) -> list[Outcome]:
    walk, batch = simulated(DEVICE, plan)
    if cut is None:
        events = estimated(DEVICE, params, batch)
    else:
        events = _fed(params, cut(batch, plan.seed))
    strides = [event for event in events if event.kind == "stride"]
    told = np.array([event.t_ns / 1e9 for event in strides])
    right = 0
    for style, end_s in zip(walk.truth["style"], walk.stride_end_s, strict=True):
        nearest = int(np.argmin(np.abs(told - end_s))) if len(told) else None
        right += nearest is not None and strides[nearest].style == style
    # Steps too many count against it as well.
    steps = max(len(strides), len(walk.stride_end_s))
    style = Outcome(float(right), float(steps), None, "style")
    return [distance_outcome(events, walk.distance_m), style]


def _fed(params: Mapping, items: Sequence[SampleBatch | Gap]):
    from experiment import registry

    device = registry().devices[DEVICE]
    estimator = device.make_estimator(device.params.model_validate(params), np.eye(3))
    events = [event for item in items for event in estimator.update(item)]
    return [*events, *estimator.finish()]


def _lose(batch: SampleBatch, lost: np.ndarray) -> list[SampleBatch | Gap]:
    edges = [0, *(np.flatnonzero(np.diff(lost)) + 1).tolist(), len(lost)]
    return [
        Gap(int(batch.t_ns[begin]), end - begin, "lost") if lost[begin] else batch[begin:end]
        for begin, end in pairwise(edges)
    ]


def _lose_samples(batch: SampleBatch, seed: int) -> list[SampleBatch | Gap]:
    lost = np.random.default_rng(seed).random(len(batch)) < 0.02
    lost[0] = False
    return _lose(batch, lost)


def _lose_halves(batch: SampleBatch, seed: int) -> list[SampleBatch | Gap]:
    lost = np.zeros(len(batch), dtype=bool)
    half = round(0.5 / batch.period_s)
    for begin in np.random.default_rng(seed).integers(500, len(batch) - 500, 3):
        lost[begin : begin + half] = True
    return _lose(batch, lost)


def _idled(plan: WalkPlan) -> list[Outcome]:
    _, batch = simulated(DEVICE, plan)
    events = estimated(DEVICE, {}, batch)
    strides = sum(event.kind == "stride" for event in events)
    minutes = len(batch) * batch.period_s / 60.0
    return [Outcome(float(strides), 0.0, None, "strides"), Outcome(minutes, minutes, None, "min")]


def _idle_figures(outcomes: Sequence[Sequence[Outcome]]) -> dict[str, float]:
    return {
        "false_strides": sum(walk[0].told for walk in outcomes),
        "minutes": sum(walk[1].told for walk in outcomes),
    }
