"""The recent past of the shank in one frame that does not turn with it."""

import math
from typing import Final, NamedTuple

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import ImuSample
from gaitway.estimation.rotation import (
    IDENTITY,
    Quaternion,
    Vector,
    from_gravity,
    from_rotation_vector,
    multiply,
    normalized,
    rotate,
)

_ACCEL: Final = slice(0, 3)
_GYRO: Final = slice(3, 6)
_CLIPPED: Final = 6
_ATTITUDE: Final = slice(7, 11)
_COLUMNS: Final = 11


class Piece(NamedTuple):
    """Consecutive samples of a track; frame c is the track's.

    Attributes:
        period_s: Of the samples.
        accel_c: Specific force, shape (n, 3).
        gyro_c: Angular rate, shape (n, 3).
        clipped: How many samples were clipped.
    """

    period_s: float
    accel_c: Floats
    gyro_c: Floats
    clipped: int

    @property
    def duration_s(self) -> float:
        """From the first sample to the last."""
        return (len(self.accel_c) - 1) * self.period_s

    @property
    def time_s(self) -> Floats:
        """Time since the first sample, shape (n,)."""
        return np.arange(len(self.accel_c), dtype=np.float64) * self.period_s

    @property
    def rate_radps(self) -> Floats:
        """Size of the angular rate, shape (n,)."""
        return np.asarray(np.sqrt((self.gyro_c**2).sum(axis=1)))


class Track:
    """Turns each sample into frame c, that of the first one after levelling it.

    The gyroscope alone carries c along, so c tilts and turns slowly with what is left of the bias:
    whoever takes a piece levels it again. Samples are known by their number.

    Args:
        period_s: Of the samples.
        gyro_bias_d: Subtracted from every sample, rad/s.

    Attributes:
        gyro_bias_d: The same; may be changed for later samples.
    """

    def __init__(self, period_s: float, gyro_bias_d: Vector) -> None:
        self.gyro_bias_d = gyro_bias_d
        self._period_s: Final = period_s
        self._q_cd: Quaternion = IDENTITY
        self._gyro_d: Vector | None = None
        self._first = 0
        self._t_ns: list[int] = []
        self._data = np.zeros((512, _COLUMNS))

    @property
    def first(self) -> int:
        """Number of the oldest sample still known."""
        return self._first

    @property
    def end(self) -> int:
        """Number of the next sample."""
        return self._first + len(self._t_ns)

    def push(self, sample: ImuSample, *, clipped: bool) -> None:
        """Take the next sample."""
        (bx, by, bz), (wx, wy, wz) = self.gyro_bias_d, sample.gyro_d
        gyro_d = (wx - bx, wy - by, wz - bz)
        if self._gyro_d is None:
            self._q_cd = from_gravity(sample.accel_d) if any(sample.accel_d) else IDENTITY
        else:
            half_s = 0.5 * self._period_s
            ox, oy, oz = self._gyro_d
            turn = ((ox + gyro_d[0]) * half_s, (oy + gyro_d[1]) * half_s, (oz + gyro_d[2]) * half_s)
            self._q_cd = normalized(multiply(self._q_cd, from_rotation_vector(turn)))
        self._gyro_d = gyro_d
        if len(self._t_ns) == len(self._data):
            self._data = np.concatenate([self._data, np.zeros_like(self._data)])
        q_cd = self._q_cd
        self._data[len(self._t_ns)] = (
            *rotate(q_cd, sample.accel_d), *rotate(q_cd, gyro_d), clipped, *q_cd,
        )  # fmt: skip
        self._t_ns.append(sample.t_ns)

    def t_ns(self, index: int) -> int:
        """Return the host time of a sample."""
        return self._t_ns[index - self._first]

    def piece(self, begin: int, end: int) -> Piece:
        """Return the samples from ``begin`` to ``end``, both included."""
        rows = self._rows(begin, end).copy()
        return Piece(self._period_s, rows[:, _ACCEL], rows[:, _GYRO], int(rows[:, _CLIPPED].sum()))

    def attitude(self, index: int) -> Quaternion:
        """Return ``q_cd`` at a sample."""
        w, x, y, z = self._rows(index, index)[0, _ATTITUDE].tolist()
        return (w, x, y, z)

    def attitudes(self, begin: int, end: int) -> Floats:
        """Return ``q_cd`` from ``begin`` to ``end``, both included, shape (n, 4)."""
        return self._rows(begin, end)[:, _ATTITUDE].copy()

    def drop_before(self, index: int) -> None:
        """Forget samples that nobody will ask for."""
        count = index - self._first
        if count > 0:
            left = len(self._t_ns) - count
            self._data[:left] = self._data[count : count + left].copy()
            del self._t_ns[:count]
            self._first = index

    def _rows(self, begin: int, end: int) -> Floats:
        return self._data[begin - self._first : end + 1 - self._first]


def samples(duration_s: float, period_s: float) -> int:
    """Return how many sample periods a duration is, at least one."""
    return max(1, math.floor(duration_s / period_s + 0.5))
