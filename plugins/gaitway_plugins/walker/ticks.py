"""Counts of an encoder to increments, across wraps and restarts of the counter."""

from typing import Final

import numpy as np

from gaitway.api import Floats

_MODULI: Final = tuple(float(2**bits) for bits in (8, 10, 12, 14, 15, 16, 20, 24, 31, 32))
"""Where counters wrap."""


def increments(counts: Floats, most: Floats) -> tuple[Floats, int]:
    """Return the counts between neighbours, and at how many places the counter began anew.

    A step that no wheel can make is a wrap, if a usual one explains it, and else a restart, which
    counts as no movement.

    Args:
        counts: Cumulative, shape (n,).
        most: Greatest possible size of each increment, shape (n - 1,).

    Returns:
        Increments of shape (n - 1,), and the number of restarts.
    """
    steps = np.diff(counts)
    restarts = 0
    for index in np.flatnonzero(np.abs(steps) > most):
        wrapped = [steps[index] + sign * m for m in _MODULI for sign in (-1.0, 1.0)]
        best = min(wrapped, key=abs)
        possible = abs(best) <= most[index]
        restarts += not possible
        steps[index] = best if possible else 0.0
    return steps, restarts
