"""From volts to newtons, and from newtons to contact and lift."""

from typing import Final, NamedTuple

import numpy as np

from gaitway.api import FORCE, FORCE_VOLT, Floats, SampleBatch
from gaitway_plugins.crutch_tip.params import CrutchTipParams

RELEASE: Final = 0.8
"""A loaded crutch is relieved below this share of the force that loaded it, so that a force at the
threshold does not flicker."""


def force_newton(batch: SampleBatch, params: CrutchTipParams) -> Floats:
    """Return the axial force of each sample, newtons, shape (n,).

    From ``FORCE`` where the device tells newtons; else from ``FORCE_VOLT`` by the piecewise line of
    the calibration (Sesar et al. 2019, Eqs. 1-3, made continuous).
    """
    if FORCE.name in batch.channels:
        return batch.channels[FORCE.name][:, 0]
    volt = batch.channels[FORCE_VOLT.name][:, 0]
    newton = piecewise_line(
        volt, np.array(params.force_knots_volt), np.array(params.force_knots_newton)
    )
    return np.where(volt < params.force_dead_volt, 0.0, newton)


def piecewise_line(x: Floats, knots_x: Floats, knots_y: Floats) -> Floats:
    """Return a continuous line through knots, the outer pieces going on beyond the ends."""
    piece = np.clip(np.searchsorted(knots_x, x, side="right") - 1, 0, len(knots_x) - 2)
    slopes = np.diff(knots_y) / np.diff(knots_x)
    y: Floats = knots_y[piece] + slopes[piece] * (x - knots_x[piece])
    return y


class Edge(NamedTuple):
    """The crutch is loaded or relieved.

    Attributes:
        sample: Number of the first that is.
        loaded: Which of the two.
    """

    sample: int
    loaded: bool


class ContactDetector:
    """Finds contacts and lifts by a threshold with hysteresis, confirmed when they last.

    Both are told where the force passed the one threshold: the hysteresis only decides.

    Args:
        force_min_newton: Force from which the crutch is loaded (the paper's F_min).
        hold: Samples for which a change has to last.

    Attributes:
        index: Samples taken so far.
    """

    def __init__(self, force_min_newton: float, hold: int) -> None:
        self._on = force_min_newton
        self._off = RELEASE * force_min_newton
        self._hold: Final = max(1, hold)
        self._loaded = False
        self._changed = 0
        self._above = 0
        self.index = 0

    def extend(self, force: Floats) -> list[Edge]:
        """Take forces, newtons, shape (n,); return the changes that are certain now."""
        edges = []
        for value in force.tolist():
            other = value < self._off if self._loaded else value >= self._on
            self._changed = self._changed + 1 if other else 0
            self.index += 1
            if value >= self._on:
                self._above = self.index
            if self._changed >= self._hold:
                self._loaded = not self._loaded
                first = self.index - self._changed if self._loaded else self._above
                edges.append(Edge(first, self._loaded))
                self._changed = 0
        return edges
