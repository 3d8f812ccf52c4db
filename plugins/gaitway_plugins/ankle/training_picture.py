"""The picture of a training walk: what the lever arm explains, and what it leaves."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gaitway.api import Floats


def draw_training(
    innovations: Sequence[Floats], lever_b: Sequence[float], sigmas_b: Floats, figure: Any
) -> None:
    """Draw into a ``matplotlib.figure.Figure``.

    Args:
        innovations: Of each walk, what every stance leaves of the velocity that was navigated to
            it, in standard deviations, three components a stance.
        lever_b: The lever arm found, IMU axes, metres.
        sigmas_b: Its standard deviations, shape (3,).
        figure: Where to.
    """
    left, right = figure.subplots(1, 2, width_ratios=[2, 1])
    first = 0
    for number, innovation in enumerate(innovations):
        stances = innovation.reshape(-1, 3)
        places = first + np.arange(len(stances))
        for axis, mark in enumerate("osd"):
            label = f"component {axis + 1}" if number == 0 else None
            left.plot(places, stances[:, axis], mark, color=f"C{axis}", label=label)
        first += len(stances) + 1
    left.axhspan(-2.0, 2.0, color="0.9", zorder=0)
    left.set_xlabel("stance")
    left.set_ylabel("what is left of its velocity, standard deviations")
    left.legend(fontsize=8)
    right.errorbar(range(3), 100.0 * np.array(lever_b), 100.0 * sigmas_b, fmt="o", capsize=4)
    right.axhline(0.0, color="0.7", lw=0.8)
    right.set_xticks(range(3), ["x", "y", "z"])
    right.set_xlabel("axis of the IMU")
    right.set_ylabel("lever arm, cm")
