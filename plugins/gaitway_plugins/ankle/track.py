"""The samples that may still be asked for, by number."""

from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import ImuSample
from gaitway.estimation.rotation import Vector


class Track:
    """Keeps the recent samples of a stretch.

    Args:
        period_s: Of the samples.
    """

    def __init__(self, period_s: float) -> None:
        self.period_s: Final = period_s
        self._first = 0
        self._samples: list[ImuSample] = []

    @property
    def first(self) -> int:
        """Return the number of the oldest sample kept."""
        return self._first

    @property
    def end(self) -> int:
        """Return the number of the next sample."""
        return self._first + len(self._samples)

    def push(self, sample: ImuSample) -> None:
        """Take the next sample."""
        self._samples.append(sample)

    def t_ns(self, index: int) -> int:
        """Return the host time of a sample."""
        return self._samples[index - self._first].t_ns

    def accel_d(self, begin: int, end: int) -> Floats:
        """Return specific force from ``begin`` up to ``end``, that one not, shape (n, 3)."""
        return np.array([s.accel_d for s in self._rows(begin, end)]).reshape(-1, 3)

    def gyro_d(self, begin: int, end: int) -> Floats:
        """Return the angular rate likewise, shape (n, 3)."""
        return np.array([s.gyro_d for s in self._rows(begin, end)]).reshape(-1, 3)

    def rate_at(self, index: int) -> Vector:
        """Return the angular rate at the end of a sample: the mean of its own and the next."""
        rows = self.gyro_d(index, min(index + 2, self.end))
        x, y, z = rows.mean(axis=0).tolist()
        return (x, y, z)

    def clipped(self, begin: int, end: int) -> int:
        """Return how many samples from ``begin`` up to ``end`` were clipped."""
        return sum(s.clipped for s in self._rows(begin, end))

    def drop_before(self, index: int) -> None:
        """Forget samples that nobody will ask for."""
        count = index - self._first
        if count > 0:
            del self._samples[:count]
            self._first += count

    def _rows(self, begin: int, end: int) -> list[ImuSample]:
        return self._samples[begin - self._first : end - self._first]
