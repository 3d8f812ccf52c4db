"""Draw ``docs/pictures/shank.png``: what the shank's estimator makes of a simulated walk."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from gaitway.api import NS_PER_S, SampleBatch, Stride, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway_plugins.shank.estimator import ShankEstimator
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.published import PublishedEstimator
from gaitway_plugins.shank.simulation import MOUNTING, simulate

PLAN = WalkPlan(12.0, seed=1, speed_mps=1.25)
PICTURE = Path(__file__).parent / "pictures" / "shank.png"


def main() -> None:
    walk = simulate(PLAN)
    t_s = np.arange(len(walk.pos_n)) / walk.rate_hz
    t_ns = np.round(t_s * NS_PER_S).astype(np.int64)
    batch = mount(
        SampleBatch(t_ns, 1.0 / walk.rate_hz, 0, walk.channels), rotation_from_mounting(MOUNTING)
    )
    estimator = ShankEstimator(ShankParams())
    trace = estimator.start_trace()
    events = [*estimator.update(batch), *estimator.finish()]
    rows = np.array(trace.rows)
    at_s = np.array(trace.t_ns) / NS_PER_S

    figure, (path, speed, lengths) = plt.subplots(3, 1, figsize=(9, 9), layout="constrained")
    forward_m = np.hypot(*(walk.pos_n[:, :2] - walk.pos_n[0, :2]).T)
    path.plot(t_s, forward_m, "k", label="true", linewidth=2.5, alpha=0.4)
    path.plot(at_s, rows[:, 0], "C0", label="default")
    for number, method in enumerate(("wsi", "s1", "s2", "s3"), start=1):
        published = PublishedEstimator(ShankParams(method=method))
        told = [*published.update(batch), *published.finish()]
        strides = [event for event in told if isinstance(event, Stride)]
        ends_s = [event.t_ns / NS_PER_S for event in strides]
        total_m = np.cumsum([event.stride_length_m for event in strides])
        path.step(ends_s, total_m, f"C{number}", where="post", label=method, linewidth=1.0)
    path.set(ylabel="way of the sensor, m", title="A simulated walk of 12 m, sensor on one shank")
    path.legend()

    true_mps = np.gradient(forward_m, t_s)
    speed.plot(t_s, true_mps, "k", linewidth=2.5, alpha=0.4, label="true speed")
    speed.plot(at_s, rows[:, 2], "C0", label="estimated speed")
    speed.fill_between(
        at_s, 0.0, 1.0, where=rows[:, 4] > 0.5, transform=speed.get_xaxis_transform(),
        color="C2", alpha=0.15, label="stance",
    )  # fmt: skip
    speed.plot(at_s, rows[:, 3], "C3", linewidth=1.0, label="lean of the shank, rad")
    speed.set(ylabel="m/s, rad", xlabel="time, s")
    speed.legend(loc="upper right")

    strides = [event for event in events if isinstance(event, Stride)]
    number = np.arange(1, len(strides) + 1)
    lengths.bar(np.arange(1, len(walk.stride_length_m) + 1), walk.stride_length_m, color="0.8",
                label="true")  # fmt: skip
    lengths.errorbar(
        number, [event.stride_length_m for event in strides],
        [1.96 * event.stride_length_sigma_m for event in strides],
        fmt="C0o", capsize=3, label="default, 95 %",
    )  # fmt: skip
    lengths.set(xlabel="stride", ylabel="length, m")
    lengths.legend(loc="lower right")
    PICTURE.parent.mkdir(exist_ok=True)
    figure.savefig(PICTURE, dpi=100)


if __name__ == "__main__":
    main()
