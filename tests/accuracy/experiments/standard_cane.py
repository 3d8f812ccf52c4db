"""The standard cane: Dang & Suh's 3 m at three heights and 170 m, robustness, coverage."""

from dataclasses import replace
from functools import partial

from experiment import Experiment, Target, distance_figures
from robustness import robustness, row, whole

from gaitway.contracts import WalkPlan

DEVICE = "standard-cane"
FIRST_SEED = 1000
METHODS = ("default", "published")
PAPER_MAE_CM = {0.315: 5.0, 0.575: 6.2, 0.778: 18.6}
PAPER_LONG = "worst person mean +2.15 m (1.27 %), sd 1.03-2.68 m"


def experiments() -> list[Experiment]:
    home = _plans(8, 0.575, distance_m=20.0)
    return [
        *(
            _by_methods(
                f"3 m, sensor {height_m} m from the tip", height_m,
                _plans(10, height_m, distance_m=2.8), Target("mae_m", 0.04),
                f"mean abs. error {paper_cm} cm",
            )
            for height_m, paper_cm in PAPER_MAE_CM.items()
        ),
        *(
            _by_methods(
                f"170 m with a turn, sensor {height_m} m from the tip", height_m,
                _plans(25, height_m, distance_m=170.0, turn_back=True),
                Target("worst_percent", 0.7), PAPER_LONG,
            )
            for height_m in (0.315, 0.778)
        ),
        *robustness(DEVICE, home, _lever(0.575)),
        row(
            DEVICE, "shuffling at 0.3 m/s", [replace(plan, speed_mps=0.3) for plan in home],
            partial(whole, DEVICE, _lever(0.575)), (Target("worst_percent", 1.4),),
        ),
        _coverage(),
    ]  # fmt: skip


def _coverage() -> Experiment:
    plans = [
        WalkPlan(
            8.0, seed=seed, rate_hz=(50.0, 100.0)[seed % 2], rest_s=1.0 + 0.5 * (seed % 4),
            conditions={
                "imu_to_tip_m": 0.575, "shock": float(seed % 3), "sway_rad": 0.01 * (seed % 4),
            },
        )
        for seed in range(FIRST_SEED + 100, FIRST_SEED + 300)
    ]  # fmt: skip
    inside = (Target("inside_95_percent", 90.0, at_least=True), Target("inside_95_percent", 98.0))
    name = "200 walks of 8 m, rests, shocks and rates of all kinds"
    return row(DEVICE, name, plans, partial(whole, DEVICE, _lever(0.575)), inside)


def _plans(count: int, height_m: float, **plan) -> list[WalkPlan]:
    conditions = {"imu_to_tip_m": height_m}
    return [
        WalkPlan(seed=FIRST_SEED + number, conditions=conditions, **plan) for number in range(count)
    ]


def _lever(height_m: float) -> dict:
    return {"imu_to_tip_m": (-height_m, 0.0, 0.0)}


def _by_methods(
    name: str, height_m: float, plans: list[WalkPlan], target: Target, paper: str
) -> Experiment:
    methods = {
        method: partial(whole, DEVICE, {"method": method} | _lever(height_m)) for method in METHODS
    }
    return Experiment(
        device=DEVICE, name=name, plans=plans, figures=distance_figures, targets=(target,),
        methods=methods, paper=paper,
    )  # fmt: skip
