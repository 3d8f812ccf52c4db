"""The quad cane: Dang & Suh's 3 m and 170 m, robustness, coverage."""

from dataclasses import replace
from functools import partial

from experiment import Experiment, Target, distance_figures
from robustness import robustness, row, whole

from gaitway.contracts import WalkPlan

DEVICE = "quad-cane"
FIRST_SEED = 1000
METHODS = {"default": {}, "published": {"method": "published"}}


def experiments() -> list[Experiment]:
    short = _plans(10, distance_m=3.3)
    long = _plans(25, distance_m=170.0, turn_back=True)
    home = _plans(8, distance_m=20.0)
    return [
        _by_methods("3 m", short, Target("mae_m", 0.03), "mean abs. error 0.098 m, worst 0.134 m"),
        _by_methods(
            "170 m with a turn", long, Target("worst_percent", 0.5),
            "worst person mean +1.14 m (0.67 %), sd 0.64-1.26 m",
        ),
        *robustness(DEVICE, home, {}),
        row(
            DEVICE, "shuffling at 0.3 m/s", [replace(plan, speed_mps=0.3) for plan in home],
            partial(whole, DEVICE, {}), (Target("worst_percent", 1.0),),
        ),
        row(
            DEVICE, "200 walks of 8 m, four sensors of five an MTi's class, one cheap",
            [
                WalkPlan(8.0, seed=seed, conditions={"sensor": "mti" if seed % 5 else "cheap"})
                for seed in range(FIRST_SEED + 100, FIRST_SEED + 300)
            ],
            partial(whole, DEVICE, {}),
            (
                Target("inside_95_percent", 90.0, at_least=True),
                Target("inside_95_percent", 98.0),
            ),
        ),
    ]  # fmt: skip


def _plans(count: int, **plan) -> list[WalkPlan]:
    return [WalkPlan(seed=FIRST_SEED + number, **plan) for number in range(count)]


def _by_methods(name: str, plans: list[WalkPlan], target: Target, paper: str) -> Experiment:
    return Experiment(
        device=DEVICE, name=name, plans=plans, figures=distance_figures, targets=(target,),
        methods={label: partial(whole, DEVICE, params) for label, params in METHODS.items()},
        paper=paper,
    )  # fmt: skip
