"""Draw ``docs/pictures/standard-cane.png``: what the estimator makes of a simulated walk."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from gaitway.api import NS_PER_S, Distance, SampleBatch, WalkPlan
from gaitway.estimation import STANDARD_GRAVITY_MPS2, GapBridge
from gaitway.mounting import mount, rotation_from_mounting
from gaitway_plugins.standard_cane.estimator import StandardCaneEstimator
from gaitway_plugins.standard_cane.params import StandardCaneParams
from gaitway_plugins.standard_cane.simulation import MOUNTING, simulate
from gaitway_plugins.standard_cane.tip import TipTransport

HEIGHT_M = 0.778
PLAN = WalkPlan(6.0, seed=1, conditions={"imu_to_tip_m": HEIGHT_M})
PICTURE = Path(__file__).parent / "pictures" / "standard-cane.png"


def main() -> None:
    walk = simulate(PLAN)
    t_s = np.arange(len(walk.pos_n)) / walk.rate_hz
    t_ns = np.round(t_s * NS_PER_S).astype(np.int64)
    C_db = rotation_from_mounting(MOUNTING)
    batch = mount(SampleBatch(t_ns, 1.0 / walk.rate_hz, 0, walk.channels), C_db)
    figure, (path, height, force) = plt.subplots(
        3, 1, figsize=(9, 9), layout="constrained", sharex=True
    )
    path.plot(t_s, np.hypot(*walk.pos_n[:, :2].T), "k", label="true", linewidth=2.5, alpha=0.4)
    height.plot(t_s, 100.0 * walk.pos_n[:, 2], "k", linewidth=2.5, alpha=0.4, label="true")
    for number, method in enumerate(("default", "published")):
        params = StandardCaneParams(imu_to_tip_m=(-HEIGHT_M, 0.0, 0.0), method=method)
        estimator = StandardCaneEstimator(params, C_db)
        trace = estimator.start_trace()
        events = [*estimator.update(batch), *estimator.finish()]
        told_m = [event for event in events if isinstance(event, Distance)][-1].distance_m
        rows, at_s = np.array(trace.rows), np.array(trace.t_ns) / NS_PER_S
        colour = f"C{number}"
        label = f"{method}: {told_m:.3f} m of {walk.distance_m:.3f}"
        path.plot(at_s, np.hypot(rows[:, 0], rows[:, 1]), colour, linewidth=1.2, label=label)
        height.plot(at_s, 100.0 * rows[:, 2], colour, linewidth=1.2, label=method)
        if method == "default":
            for axes in (path, height, force):
                axes.fill_between(
                    at_s, 0.0, 1.0, where=rows[:, 7] > 0.5, color="C2", alpha=0.15,
                    transform=axes.get_xaxis_transform(), label="tip stands",
                )  # fmt: skip
    path.set(ylabel="way of the tip, m", title="A simulated walk of 6 m, sensor 0.778 m up")
    height.set(ylabel="height of the tip, cm")
    rows = TipTransport(np.array([0.0, 0.0, -HEIGHT_M]), 0.06, 0.01).extend(
        GapBridge(0.1).feed(batch)
    )
    at_s = [row.sample.t_ns / NS_PER_S for row in rows]
    at_imu = [np.linalg.norm(row.sample.accel_d) - STANDARD_GRAVITY_MPS2 for row in rows]
    force.plot(at_s, at_imu, "C3", linewidth=0.8, label="at the sensor")
    force.plot(
        at_s, [row.force_mps2 - STANDARD_GRAVITY_MPS2 for row in rows], "C0", linewidth=0.8,
        label="carried to the tip",
    )  # fmt: skip
    force.set(ylabel="specific force - g, m/s$^2$", xlabel="time, s", ylim=(-3.0, 3.0))
    for axes in (path, height, force):
        axes.legend(loc="upper left", fontsize=8)
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
