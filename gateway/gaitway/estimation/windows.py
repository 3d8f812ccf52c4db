"""Centred windows over a stream: what they say of a sample, they say half a window later.

The cost of a sample does not depend on the length of the window, and nothing drifts: running sums
are taken anew every time the window has been filled once.
"""

import math
from collections import deque
from typing import Final


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
        self._values: deque[float] = deque()
        self._sum = 0.0
        self._pushed = 0

    def push(self, value: float) -> float | None:
        """Take the next value; return the mean about the one ``half`` before, once there is one."""
        if len(self._values) == self._size:
            self._sum -= self._values.popleft()
        self._values.append(value)
        self._sum += value
        self._pushed += 1
        if self._pushed % self._size == 0:
            self._sum = math.fsum(self._values)
        return self._sum / len(self._values) if self._pushed > self._half else None

    def finish(self) -> list[float]:
        """Return the means about the last samples, whose windows the end of the stream cuts."""
        means = []
        waiting = min(self._half, self._pushed)
        for reach in range(waiting + self._half, self._half, -1):
            while len(self._values) > reach:
                self._values.popleft()
            means.append(math.fsum(self._values) / len(self._values))
        return means


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
