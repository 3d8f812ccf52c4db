"""Draw docs/pictures/walker.png: a simulated walk in all styles, both methods, innovations."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gaitway.api import Event, Floats, SampleBatch, SimulatedWalk, Stride, WalkPlan
from gaitway.estimation import Innovation, Measurement
from gaitway_plugins.walker.estimator import WalkerEstimator
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.simulation import simulate
from gaitway_plugins.walker.tracing import STYLES

ROOT = Path(__file__).parent
PLAN = WalkPlan(24.0, seed=1001, conditions={"style": "mixed", "turns": 1.0})
COLOURS = {
    "continuous": "tab:blue", "step-by-step": "tab:green",
    "full-lift": "tab:red", "back-tips": "tab:orange",
}  # fmt: skip


def main() -> None:
    walk = simulate(PLAN)
    figure = Figure(figsize=(9.0, 12.0), layout="constrained")
    path, phases, errors, innovations = figure.subplots(4, 1, height_ratios=(3, 2, 2, 2))
    path.plot(*walk.pos_n[:, :2].T, color="0.7", linewidth=5, label="truth")
    for method, dash in (("default", "-"), ("published", ":")):
        events, rows, time_s, seen = estimated(walk, method)
        path.plot(rows[:, 0], rows[:, 1], dash, color="black", label=method)
        strides = [event for event in events if isinstance(event, Stride)]
        draw_error(errors, walk, strides, method, dash)
        if method == "default":
            draw_phases(phases, rows, time_s, strides)
            draw_innovations(innovations, seen)
    path.set_aspect("equal")
    path.set_xlabel("x (m)")
    path.set_ylabel("y (m)")
    path.set_title("path of the floor point between the wheels")
    path.legend()
    errors.set_ylabel("told - true (m)")
    errors.set_title("distance after each step")
    errors.legend()
    innovations.set_xlabel("time (s)")
    target = ROOT / "pictures" / "walker.png"
    target.parent.mkdir(exist_ok=True)
    figure.savefig(target, dpi=90)
    sys.stdout.write(f"{target}\n")


def estimated(walk: SimulatedWalk, method: str) -> tuple[list[Event], Floats, Floats, list[Any]]:
    estimator = WalkerEstimator(WalkerParams.model_validate({"method": method}))
    seen = listen(estimator)
    trace = estimator.start_trace()
    t_ns = np.arange(len(walk.pos_n), dtype=np.int64) * round(1e9 / walk.rate_hz)
    events = list(estimator.update(SampleBatch(t_ns, 1 / walk.rate_hz, 0, walk.channels)))
    events += estimator.finish()
    return events, np.array(trace.rows), np.array(trace.t_ns) / 1e9, seen


def listen(estimator: Any) -> list[Any]:
    """Return where the innovations of three axes will be, with the time of their block."""
    seen: list[Any] = []
    navigator = estimator._navigator  # noqa: SLF001
    kf, step = navigator._kf, navigator.step  # noqa: SLF001
    correct, now = kf.correct, [0.0]

    def listened(measurement: Measurement) -> Innovation:
        found: Innovation = correct(measurement)
        if len(measurement.z) == 3:
            seen.append((now[0], *found.standardised))
        return found

    def stepped(block: Any, **given: Any) -> Any:
        now[0] = block.end_ns / 1e9
        return step(block, **given)

    kf.correct, navigator.step = listened, stepped
    return seen


def draw_phases(axes: Any, rows: Floats, time_s: Floats, strides: Sequence[Stride]) -> None:
    axes.plot(time_s, rows[:, 4], color="black", linewidth=0.8, label="wheel speed (m/s)")
    axes.plot(time_s, 5.0 * rows[:, 2], color="tab:purple", linewidth=0.8, label="5 x height (m)")
    for stride in strides:
        moved_s = stride.t_ns / 1e9 - (stride.swing_duration_s or 0.0), stride.t_ns / 1e9
        axes.axvspan(*moved_s, color=COLOURS[stride.style or ""], alpha=0.35, linewidth=0)
    for style in STYLES:
        axes.axvspan(0.0, 0.0, color=COLOURS[style], alpha=0.35, label=style)
    axes.set_xlim(0.0, time_s[-1])
    axes.set_title("steps and their styles (default)")
    axes.legend(ncols=3, fontsize="small", loc="upper right")
    axes.set_ylim(-0.1, 1.4)


def draw_error(
    axes: Any, walk: SimulatedWalk, strides: Sequence[Stride], method: str, dash: str
) -> None:
    way_m = np.hypot(*np.diff(walk.pos_n[:, :2], axis=0, prepend=walk.pos_n[:1, :2]).T).cumsum()
    time_s = np.array([stride.t_ns / 1e9 for stride in strides])
    told_m = np.cumsum([stride.stride_length_m for stride in strides])
    true_m = np.interp(time_s, np.arange(len(way_m)) / walk.rate_hz, way_m)
    axes.plot(time_s, told_m - true_m, dash, color="black", label=method)


def draw_innovations(axes: Any, seen: Sequence[Any]) -> None:
    rows = np.array(seen)
    axes.plot(rows[:, 0], rows[:, 1:], ".", markersize=2)
    for bound in (-1.96, 1.96):
        axes.axhline(bound, color="0.6", linewidth=0.8)
    axes.set_ylim(-6.0, 6.0)
    axes.set_title("innovations of velocity, standing and rolling (standard deviations, default)")


if __name__ == "__main__":
    main()
