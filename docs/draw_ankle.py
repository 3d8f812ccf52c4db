"""Draws docs/pictures/ankle.png: path on stairs, phases, innovations, both methods on 40 m."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from gaitway.contracts import CalibrationPart, SimulatedWalk, Trace, WalkPlan
from gaitway.estimation import Innovation
from gaitway.events import Distance, Event, Stride
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.registry import load_registry
from gaitway.samples import SampleBatch

PICTURE = Path(__file__).parent / "pictures" / "ankle.png"
DEVICE = load_registry().devices["ankle"]
C_DB = rotation_from_mounting(DEVICE.default_mounting)
SEEDS = range(1000, 1008)


def recorded(plan: WalkPlan) -> tuple[SimulatedWalk, SampleBatch]:
    walk = DEVICE.simulate(plan)
    t_ns = np.arange(len(walk.pos_n), dtype=np.int64) * round(1e9 / walk.rate_hz)
    return walk, SampleBatch(t_ns, 1 / walk.rate_hz, 0, walk.channels)


def learned(seed: int) -> Mapping[str, Any]:
    _, batch = recorded(WalkPlan(3.0, seed=seed))
    (training,) = DEVICE.calibrations
    return training.fit(
        DEVICE.params(), training.options(), [CalibrationPart([batch], C_DB)]
    ).params


def estimated(
    batch: SampleBatch, params: Mapping[str, Any]
) -> tuple[list[Event], Trace, list[tuple[float, Innovation]]]:
    estimator = DEVICE.make_estimator(DEVICE.params.model_validate(params), C_DB)
    trace = estimator.start_trace()
    events: list[Event] = []
    innovations: list[tuple[float, Innovation]] = []
    mounted = mount(batch, C_DB)
    for start in range(0, len(mounted), 5):
        events += estimator.update(mounted[start : start + 5])
        stretch = getattr(estimator, "_stretch", None)
        if stretch is not None:
            found = stretch.navigator.innovation
            if not innovations or innovations[-1][1] is not found:
                innovations.append((mounted.t_ns[start] / 1e9, found))
    events += estimator.finish()
    return events, trace, innovations


def draw_path(axes: Axes, walk: SimulatedWalk, trace: Trace) -> None:
    rows = np.array(trace.rows)
    away = np.hypot(rows[:, 0] - rows[120, 0], rows[:, 1] - rows[120, 1])
    true = np.hypot(*(walk.pos_n[:, :2] - walk.pos_n[0, :2]).T)
    axes.plot(true, walk.pos_n[:, 2] - walk.pos_n[0, 2], color="0.6", lw=3, label="true, ankle")
    axes.plot(away, rows[:, 2] - rows[120, 2], color="C0", lw=1, label="estimated, IMU")
    axes.set(xlabel="away, m", ylabel="height, m", title="stairs up, trained on 3 m level")
    axes.legend()


def draw_phases(axes: Axes, trace: Trace, strides: Sequence[Stride]) -> None:
    t_s = np.array(trace.t_ns) / 1e9
    rows = np.array(trace.rows)
    axes.plot(t_s, rows[:, trace.columns.index("pivot_speed_mps")], lw=1)
    for stride in strides:
        axes.axvspan(stride.start_t_ns / 1e9, stride.lift_t_ns / 1e9, color="C2", alpha=0.2, lw=0)
    axes.set(xlabel="time, s", ylabel="speed of the pivot, m/s", title="stance (green) and swing")


def draw_innovations(axes: Axes, innovations: Sequence[tuple[float, Innovation]]) -> None:
    t_s = [t for t, _ in innovations]
    of = np.array([found.standardised for _, found in innovations])
    for column, name in enumerate(("x", "y", "z")):
        axes.plot(t_s, of[:, column], ".", label=name)
    axes.axhspan(-1.96, 1.96, color="0.9", zorder=0)
    axes.set(xlabel="time, s", ylabel="standardised", title="innovations of w x r in stance")
    axes.legend()


def draw_methods(axes: Axes) -> None:
    for seed in SEEDS:
        walk, batch = recorded(WalkPlan(40.0, seed=seed, repetition=1))
        params = learned(seed)
        for number, method in enumerate(("default", "published", "zupt")):
            events, _, _ = estimated(batch, {**params, "method": method})
            told = [event for event in events if isinstance(event, Distance)][-1]
            error = 100.0 * (told.distance_m / walk.distance_m - 1.0)
            label = method if seed == SEEDS[0] else None
            place = seed - SEEDS[0] + 0.2 * (number - 1)
            axes.plot(place, error, "os^"[number], color=f"C{number}", label=label)
    axes.axhline(0.0, color="0.6", lw=1)
    axes.set_ylim(-22.0, 6.0)
    axes.set(
        xlabel="walk", ylabel="error, %", title="40 m, same walks and lever arm (1: below -80 %)"
    )
    axes.legend()


def main() -> None:
    walk, batch = recorded(
        WalkPlan(6.0, seed=1000, repetition=1, conditions={"terrain": "stairs-up"})
    )
    events, trace, innovations = estimated(batch, learned(1000))
    strides = [event for event in events if isinstance(event, Stride)]
    figure, axes = plt.subplots(2, 2, figsize=(11, 7.5), layout="constrained")
    draw_path(axes[0, 0], walk, trace)
    draw_phases(axes[0, 1], trace, strides)
    draw_innovations(axes[1, 0], innovations)
    draw_methods(axes[1, 1])
    figure.suptitle("Ankle, simulated (gaitway simulate ankle)")
    figure.savefig(PICTURE, dpi=90)


if __name__ == "__main__":
    main()
