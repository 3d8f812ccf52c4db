"""Centred windows over a stream: what they say of a sample, they say half a window later.

The cost of a sample does not depend on the length of the window. ``push`` takes a sample,
``extend`` many; both make the same sums in the same order, so it does not matter which is used.
"""

import math
from collections import deque
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gaitway.samples import Floats

_REBASE: Final = 1 << 16
"""Samples after which running sums begin anew, so that no rounding adds up over years."""


def half_window(window_s: float, period_s: float) -> int:
    """Return how many samples a centred window reaches to either side, never more than half of it.

    Args:
        window_s: Length of the window.
        period_s: Of the samples.
    """
    return math.floor(0.5 * window_s / period_s + 1e-6)


class CentredMean:
    """Running mean over a centred window, shorter where the stream begins and ends.

    Args:
        half: Samples to either side: the window has ``2 * half + 1``, and ``push`` answers for the
            sample that came ``half`` pushes before.
    """

    def __init__(self, half: int) -> None:
        self._half: Final = half
        self._size: Final = 2 * half + 1
        self._sums: deque[float] = deque([0.0], self._size + 1)
        self._pushed = 0

    def push(self, value: float) -> float | None:
        """Take the next value; return the mean about the one ``half`` before, once there is one."""
        if self._pushed % _REBASE == 0:
            self._rebase()
        sums = self._sums
        sums.append(sums[-1] + value)
        self._pushed += 1
        if self._pushed <= self._half:
            return None
        return (sums[-1] - sums[0]) / (len(sums) - 1)

    def extend(self, values: Floats) -> Floats:
        """Take values; return the means that are known now, of the samples ``half`` before.

        Args:
            values: Shape (n,).
        """
        means = []
        at = 0
        while at < len(values):
            if self._pushed % _REBASE == 0:
                self._rebase()
            stop = min(len(values), at + _REBASE - self._pushed % _REBASE)
            means.append(self._extend(values[at:stop]))
            at = stop
        return np.concatenate(means) if means else np.empty(0)

    def finish(self) -> list[float]:
        """Return the means about the last samples, whose windows the end of the stream cuts."""
        means = []
        waiting = min(self._half, self._pushed)
        for reach in range(waiting + self._half, self._half, -1):
            while len(self._sums) > reach + 1:
                self._sums.popleft()
            means.append((self._sums[-1] - self._sums[0]) / (len(self._sums) - 1))
        return means

    def _extend(self, values: Floats) -> Floats:
        before = np.array(self._sums)
        first_unknown = max(0, self._half - self._pushed)
        # Sequential, as push is: the same sums to the last bit.
        sums = np.concatenate([before, np.cumsum(np.concatenate([before[-1:], values]))[1:]])
        self._pushed += len(values)
        self._sums.extend(islice(sums.tolist(), max(len(before), len(sums) - self._size - 1), None))
        ends = np.arange(len(before) + first_unknown, len(sums))
        begins = np.maximum(ends - self._size, 0)
        means: Floats = (sums[ends] - sums[begins]) / (ends - begins)
        return means

    def _rebase(self) -> None:
        first = self._sums[0]
        self._sums = deque([value - first for value in self._sums], self._size + 1)


class CentredHold:
    """Whether a condition held at every sample of a centred window.

    Args:
        half: Samples to either side, as for ``CentredMean``.
    """

    def __init__(self, half: int) -> None:
        self._size: Final = 2 * half + 1
        self._run = 0

    def push(self, condition: bool) -> bool:
        """Take the next sample's; return whether it held all around the sample ``half`` before.

        A window that the beginning of the stream cuts does not hold.
        """
        self._run = self._run + 1 if condition else 0
        return self._run >= self._size

    def extend(self, conditions: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Take many at once; return for each what ``push`` would.

        Args:
            conditions: Shape (n,).
        """
        number = np.arange(1, len(conditions) + 1)
        failed = np.maximum.accumulate(np.where(conditions, -self._run, number))
        runs = number - failed
        if len(runs):
            self._run = int(runs[-1])
        held: NDArray[np.bool_] = runs >= self._size
        return held
