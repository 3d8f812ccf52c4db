"""Draw ``docs/pictures/quad_cane.png``: what both methods make of one simulated walk."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from gaitway.api import NS_PER_S, Distance, SampleBatch, Stride, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway_plugins.quad_cane.estimator import QuadCaneEstimator
from gaitway_plugins.quad_cane.params import QuadCaneParams
from gaitway_plugins.quad_cane.simulation import MOUNTING, simulate

PLAN = WalkPlan(4.0, seed=4)
PICTURE = Path(__file__).parent / "pictures" / "quad_cane.png"


def main() -> None:
    walk = simulate(PLAN)
    t_s = np.arange(len(walk.pos_n)) / walk.rate_hz
    t_ns = np.round(t_s * NS_PER_S).astype(np.int64)
    batch = mount(
        SampleBatch(t_ns, 1.0 / walk.rate_hz, 0, walk.channels), rotation_from_mounting(MOUNTING)
    )
    figure, (way, speed, sigma) = plt.subplots(3, 1, figsize=(9, 9), layout="constrained")
    true_m = np.hypot(*(walk.pos_n[:, :2] - walk.pos_n[0, :2]).T)
    way.plot(t_s, true_m, "k", lw=3, alpha=0.3, label="true way of the base")
    for number, method in enumerate(("default", "published")):
        estimator = QuadCaneEstimator(QuadCaneParams(method=method))
        trace = estimator.start_trace()
        events = [*estimator.update(batch), *estimator.finish()]
        at_s, rows = np.array(trace.t_ns) / NS_PER_S, np.array(trace.rows)
        column = {name: rows[:, place] for place, name in enumerate(trace.columns)}
        told = [event for event in events if isinstance(event, Distance)]
        name = f"{method}: {told[-1].distance_m:.2f} +- {told[-1].distance_sigma_m:.2f} m"
        colour = f"C{number}"
        moved_m = np.hypot(column["pos_x_m"], column["pos_y_m"])
        way.plot(at_s, moved_m, colour, label=f"{name} of {walk.distance_m:.2f} m")
        speed.plot(at_s, np.hypot(column["vel_x_mps"], column["vel_y_mps"]), colour, label=method)
        sigma.plot(at_s, 1000.0 * column["swing_sigma_m"], colour, label=method)
        if method == "default":
            contact = column["contact"] > 0.5
            speed.fill_between(at_s, 0.0, 1.0, where=contact, color="0.85", label="contact")
            for stride in (event for event in events if isinstance(event, Stride)):
                way.axvline(stride.t_ns / NS_PER_S, color="0.8", lw=0.8, zorder=0)
    way.set_ylabel("way, m")
    speed.set_ylabel("navigated speed of the IMU, m/s")
    sigma.set_ylabel("sigma of the present swing, mm")
    sigma.set_yscale("log")
    sigma.set_xlabel("time, s")
    for axes in (way, speed, sigma):
        axes.legend(loc="upper left", fontsize=8)
    figure.suptitle("Quad cane, a simulated walk")
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
