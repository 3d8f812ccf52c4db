"""Samples of IMU and wheels in blocks of equal length, short gaps filled, long ones said.

Everything later works on blocks, whose bounds are counted from the first sample, so that how the
stream is cut into batches can't change anything.
"""

from typing import Final, NamedTuple

import numpy as np

from gaitway.api import (
    ACCEL,
    CLIP,
    GYRO,
    LEFT_TICKS,
    RIGHT_TICKS,
    EstimatorInput,
    Floats,
    Gap,
    Ints,
    SampleBatch,
)
from gaitway.estimation import Break
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.ticks import increments

_IMU: Final = slice(0, 6)
_TICKS: Final = slice(6, 8)
_CLIPPED: Final = 8
_BRIDGED: Final = 9
_IMU_MAX: Final = 1e5
_RANGE_MPS2: Final = 14.0
"""A sensor of +-1.5 g ends at 14.7 m/s^2; no block of a walk stays at one value there."""
_GUESS_S: Final = 0.06
"""A straight line across more than this says little of what the IMU felt."""
_SPEED_MAX_MPS: Final = 4.0
"""No walker's wheels roll faster."""


class Block(NamedTuple):
    """Consecutive samples, the last of which ends at ``t_ns[-1]``.

    Attributes:
        t_ns: Host time of each sample, shape (n,).
        period_s: Of the samples.
        accel_d: Specific force, m/s^2, shape (n, 3).
        gyro_d: Angular rate, rad/s, shape (n, 3).
        wheels_m: How far the left and the right wheel rolled in each sample, shape (n, 2).
        clipped: A reading was at the end of its range.
        bridged: Too many neighbouring samples were not measured to know what the IMU felt.
    """

    t_ns: Ints
    period_s: float
    accel_d: Floats
    gyro_d: Floats
    wheels_m: Floats
    clipped: bool
    bridged: bool

    @property
    def duration_s(self) -> float:
        """Length of the block."""
        return len(self.t_ns) * self.period_s

    @property
    def start_ns(self) -> int:
        """When it began."""
        return int(self.t_ns[0]) - round(1e9 * self.period_s)

    @property
    def end_ns(self) -> int:
        """When it ended."""
        return int(self.t_ns[-1])


class Blocks:
    """Makes blocks out of batches and gaps.

    Args:
        params: Of the walker.
        period_s: Of the samples.
    """

    def __init__(self, params: WalkerParams, period_s: float) -> None:
        self._period_s: Final = period_s
        self._size: Final = max(2, round(params.block_s / period_s))
        self._tick_m: Final = params.tick_m
        self._most: Final = _SPEED_MAX_MPS * period_s / params.tick_m + 1.0
        self._max_missing: Final = int(params.max_bridge_s / period_s + 1e-6)
        self._last: Floats | None = None
        self._last_ns = 0
        self._missing = 0
        self._restarted = False
        self._rows = np.zeros((0, 10))
        self._t_ns = np.zeros(0, dtype=np.int64)

    def feed(self, item: EstimatorInput) -> list[Block | Break]:
        """Return the blocks that the next item completes."""
        if isinstance(item, Gap):
            self._missing += item.n_missing
            self._restarted |= item.reason == "device-restart"
            return []
        out: list[Block | Break] = []
        rows = _table(item)
        good = np.isfinite(rows).all(axis=1) & (np.abs(rows[:, _IMU]).max(axis=1) < _IMU_MAX)
        bounds = np.flatnonzero(np.diff(good)) + 1
        for start, stop in zip([0, *bounds], [*bounds, len(good)], strict=True):
            if good[start]:
                out += self._take(rows[start:stop], item.t_ns[start:stop])
            else:
                self._missing += int(stop - start)
        return out

    def finish(self) -> list[Block]:
        """Return the samples that fill no whole block."""
        return [self._block(len(self._rows))] if len(self._rows) else []

    def _take(self, rows: Floats, t_ns: Ints) -> list[Block | Break]:
        out: list[Block | Break] = []
        last, missing = self._last, self._missing
        if last is not None and missing and (self._restarted or missing > self._max_missing):
            out += [Break(self._last_ns, (missing + 1) * self._period_s)]
            self._rows, self._t_ns = self._rows[:0], self._t_ns[:0]
            last = None
        if last is None:
            last, missing = rows[0], 0
            self._last_ns = int(t_ns[0])
        self._missing, self._restarted = 0, False
        most = np.full(len(rows), self._most)
        most[0] *= missing + 1
        rolled = rows.copy()
        for column in (6, 7):
            counts = np.concatenate([last[column : column + 1], rows[:, column]])
            rolled[:, column] = increments(counts, most)[0] * self._tick_m
        if missing:
            rolled, t_ns = self._bridge(last, rolled, t_ns, missing)
        self._last, self._last_ns = rows[-1], int(t_ns[-1])
        self._rows = np.concatenate([self._rows, rolled])
        self._t_ns = np.concatenate([self._t_ns, t_ns])
        while len(self._rows) >= self._size:
            out.append(self._block(self._size))
        return out

    def _bridge(
        self, last: Floats, rolled: Floats, t_ns: Ints, missing: int
    ) -> tuple[Floats, Ints]:
        share = (np.arange(1, missing + 1) / (missing + 1))[:, None]
        filled = last + share * (rolled[0] - last)
        rolled[0, _TICKS] /= missing + 1
        filled[:, _TICKS] = rolled[0, _TICKS]
        filled[:, _BRIDGED] = rolled[0, _BRIDGED] = float(missing * self._period_s > _GUESS_S)
        step_ns = int(t_ns[0]) - self._last_ns
        filled_ns = self._last_ns + step_ns * np.arange(1, missing + 1) // (missing + 1)
        return np.concatenate([filled, rolled]), np.concatenate([filled_ns, t_ns])

    def _block(self, size: int) -> Block:
        rows, t_ns = self._rows[:size], self._t_ns[:size]
        self._rows, self._t_ns = self._rows[size:], self._t_ns[size:]
        return Block(
            t_ns,
            self._period_s,
            rows[:, 0:3],
            rows[:, 3:6],
            rows[:, _TICKS],
            bool(rows[:, _CLIPPED].any()) or _at_end_of_range(rows[:, 0:3]),
            bool(rows[:, _BRIDGED].any()),
        )


def _at_end_of_range(accel: Floats) -> bool:
    """Return whether three readings in a row are equal and as large as the smallest range."""
    same = (np.diff(accel, axis=0) == 0.0) & (np.abs(accel[1:]) >= _RANGE_MPS2)
    return bool((same[1:] & same[:-1]).any())


def _table(batch: SampleBatch) -> Floats:
    rows = np.zeros((len(batch), 10))
    rows[:, 0:3] = batch.channels[ACCEL.name]
    rows[:, 3:6] = batch.channels[GYRO.name]
    rows[:, 6:7] = batch.channels[LEFT_TICKS.name]
    rows[:, 7:8] = batch.channels[RIGHT_TICKS.name]
    if CLIP.name in batch.channels:
        rows[:, _CLIPPED] = batch.channels[CLIP.name][:, 0]
    return rows
