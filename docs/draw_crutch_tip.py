"""Draw ``docs/pictures/crutch_tip.png``: a simulated walk by both methods of the crutch tip."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from gaitway.api import NS_PER_S, Load, SampleBatch, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway_plugins.crutch_tip.estimator import CrutchTipEstimator
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.simulation import MOUNTING, simulate

PLAN = WalkPlan(10.0, seed=8, rest_s=1.0, turn_back=True, conditions={"turn_cycles": 2.0})
PICTURE = Path(__file__).parent / "pictures" / "crutch_tip.png"


def main() -> None:
    walk = simulate(PLAN)
    t_s = np.arange(len(walk.pos_n)) / walk.rate_hz
    t_ns = np.round(t_s * NS_PER_S).astype(np.int64)
    batch = mount(
        SampleBatch(t_ns, 1.0 / walk.rate_hz, 0, walk.channels), rotation_from_mounting(MOUNTING)
    )
    figure, (pitch, error, force) = plt.subplots(
        3, 1, figsize=(10, 9), sharex=True, layout="constrained"
    )
    true_deg = np.degrees(walk.truth["pitch_rad"])
    pitch.plot(t_s, true_deg, "k", linewidth=3.0, alpha=0.35, label="true")
    for method, colour in (("published", "C1"), ("default", "C0")):
        estimator = CrutchTipEstimator(CrutchTipParams(method=method))
        trace = estimator.start_trace()
        events = [*estimator.update(batch), *estimator.finish()]
        told_deg, sigma_deg, _, _ = np.degrees(trace.rows).T
        pitch.plot(t_s, told_deg, colour, linewidth=1.0, label=method)
        error.plot(t_s, told_deg - true_deg, colour, linewidth=1.0, label=method)
    error.fill_between(t_s, -1.96 * sigma_deg, 1.96 * sigma_deg, color="C0", alpha=0.2, lw=0)
    pitch.plot(t_s, np.degrees(walk.channels["inclination"][:, 0]), "C2:", lw=0.8,
               label="inclinometer")  # fmt: skip
    pitch.set(ylabel="pitch, deg", ylim=(-45, 55),
              title="A simulated walk, 5 m there and back, with a crutch")  # fmt: skip
    error.set(ylabel="error of the pitch, deg", ylim=(-12, 12))
    loads = [event for event in events if isinstance(event, Load)]
    force.plot(t_s, walk.channels["force"][:, 0], "C0", linewidth=1.0, label="measured")
    force.plot(t_s, walk.truth["force_newton"], "k", linewidth=2.5, alpha=0.35, label="true")
    force.errorbar(
        [0.5 * (load.start_t_ns + load.t_ns) / NS_PER_S for load in loads],
        [load.peak_force_newton for load in loads],
        [1.96 * load.peak_force_sigma_newton for load in loads],
        fmt="C3o", markersize=3, capsize=3, label="peak told, 95 %",
    )  # fmt: skip
    force.set(ylabel="axial force, N", xlabel="time, s", ylim=(-10, 360))
    for axes in (pitch, error, force):
        axes.fill_between(
            t_s, 0.0, 1.0, where=walk.truth["turning"] > 0.0, color="C4", alpha=0.15, lw=0,
            transform=axes.get_xaxis_transform(), label="turning",
        )  # fmt: skip
        axes.legend(loc="upper right", fontsize=8)
    PICTURE.parent.mkdir(exist_ok=True)
    figure.savefig(PICTURE, dpi=100)


if __name__ == "__main__":
    main()
