"""Draw docs/pictures/crutch-tip.png: both methods on one simulated walk with a turn."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gaitway.api import SampleBatch, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway_plugins.crutch_tip.estimator import CrutchTipEstimator
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.simulation import MOUNTING, simulate


def main() -> None:
    walk = simulate(WalkPlan(10.0, seed=1002, turn_back=True))
    t_s = np.arange(len(walk.pos_n)) / walk.rate_hz
    t_ns = np.round(1e9 * t_s).astype(np.int64)
    samples = SampleBatch(t_ns, 1.0 / walk.rate_hz, 0, walk.channels)
    batch = mount(samples, rotation_from_mounting(MOUNTING))
    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    pitch, error, force = figure.subplots(3, 1, sharex=True)
    true_deg = np.degrees(walk.truth["pitch_rad"])
    pitch.plot(t_s, true_deg, "k", linewidth=2.5, alpha=0.3, label="true")
    for method in ("published", "default"):
        estimator = CrutchTipEstimator(CrutchTipParams(method=method))
        trace = estimator.start_trace()
        estimator.update(batch)
        estimator.finish()
        rows = np.array(trace.rows)
        pitch.plot(t_s, np.degrees(rows[:, 0]), linewidth=1.0, label=method)
        error.plot(t_s, np.degrees(rows[:, 0]) - true_deg, linewidth=1.0, label=method)
    sigma = 1.96 * np.degrees(rows[:, 1])
    error.fill_between(t_s, -sigma, sigma, alpha=0.2, label="95 % of the default")
    force.plot(t_s, rows[:, 2], linewidth=1.0)
    force.fill_between(t_s, 0.0, rows[:, 3] * rows[:, 2].max(), alpha=0.15, label="stance")
    turns = walk.truth["turning"] > 0.0
    for start_s, end_s in zip(walk.stride_start_s[turns], walk.stride_end_s[turns], strict=True):
        for axes in (pitch, error, force):
            axes.axvspan(start_s, end_s, color="purple", alpha=0.08)
    pitch.set(ylabel="pitch, degrees", title="One walk with a turn (purple)")
    error.set(ylabel="error, degrees")
    force.set(ylabel="force, newton", xlabel="seconds")
    for axes in (pitch, error, force):
        axes.legend(loc="upper right", fontsize=8)
    figure.savefig(Path(__file__).parent / "pictures" / "crutch-tip.png", dpi=90)


if __name__ == "__main__":
    main()
