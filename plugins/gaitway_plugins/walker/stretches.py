"""A calibration's recording cut into what was rolled between one standing and the next."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from gaitway.api import (
    ACCEL,
    GYRO,
    LEFT_TICKS,
    RIGHT_TICKS,
    CalibrationError,
    EstimatorInput,
    Floats,
    SampleBatch,
    missing_channels,
)
from gaitway.estimation import Break
from gaitway_plugins.walker.blocks import Block, Blocks
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.stillness import Stillness, rolling_min_m


class Stretch(NamedTuple):
    """Rolling with some standing before and after; axes of the IMU.

    Attributes:
        period_s: Of the samples.
        accel_b: Specific force, m/s^2, shape (n, 3).
        gyro_b: Angular rate without what it read while standing, rad/s, shape (n, 3).
        wheels_m: How far the left and the right wheel rolled in each sample, shape (n, 2).
        up_b: Direction of the specific force while standing, shape (3,).
        rest_b: Specific force while standing before, shape (3,).
    """

    period_s: float
    accel_b: Floats
    gyro_b: Floats
    wheels_m: Floats
    up_b: Floats
    rest_b: Floats

    @property
    def travel_m(self) -> float:
        """How far the point between the wheels went, forward positive."""
        return float(0.5 * self.wheels_m.sum())

    @property
    def apart_m(self) -> float:
        """How much further the right wheel rolled than the left."""
        return float(self.wheels_m[:, 1].sum() - self.wheels_m[:, 0].sum())

    @property
    def turned_rad(self) -> float:
        """How far the gyroscope turned about the vertical."""
        return float(self.gyro_b.sum(axis=0) @ self.up_b * self.period_s)


def stretches(items: Iterable[EstimatorInput], params: WalkerParams) -> list[Stretch]:
    """Return every stretch of rolling that has standing at both ends.

    Args:
        items: What was recorded, axes of the IMU.
        params: Of the walker.

    Raises:
        CalibrationError: A channel is missing or too many samples are.
    """
    blocks = _blocks(items, params)
    still = _stillness(blocks, params)
    rolling_m = rolling_min_m(params)
    rolls = np.array([np.abs(b.wheels_m.sum(axis=0)).max() > rolling_m for b in blocks])
    found, first = [], 0
    while first < len(blocks):
        # Standing, then whatever comes before the next standing.
        start = first + _run(still[first:], True)
        end = start + _run(still[start:], False)
        after = _run(still[end:], True)
        if start > first and after and rolls[start:end].any():
            found.append(_stretch(blocks[first : end + after], start - first, after))
        first = max(end, first + 1)
    return found


def _blocks(items: Iterable[EstimatorInput], params: WalkerParams) -> list[Block]:
    source: Blocks | None = None
    out: list[Block] = []
    for item in items:
        if isinstance(item, SampleBatch):
            missing = missing_channels((ACCEL, GYRO, LEFT_TICKS, RIGHT_TICKS), item.channels)
            if missing:
                raise CalibrationError(f"the recording lacks {', '.join(missing)}")
            source = source or Blocks(params, item.period_s)
        for entry in source.feed(item) if source is not None else []:
            if isinstance(entry, Break):
                raise CalibrationError(f"{entry.duration_s:.1f} s of samples are missing: again")
            out.append(entry)
    return out


def _stillness(blocks: list[Block], params: WalkerParams) -> list[bool]:
    test = Stillness(params)
    verdicts = [test.push(block, np.zeros(3)) for block in blocks]
    return [*verdicts[1:], test.last()] if blocks else []


def _run(flags: Sequence[bool], value: bool) -> int:
    """Return how many of the first flags have a value."""
    return next((n for n, flag in enumerate(flags) if flag is not value), len(flags))


def _stretch(blocks: list[Block], before: int, after: int) -> Stretch:
    at_rest = [*blocks[:before], *blocks[len(blocks) - after :]]
    gyro_b = np.concatenate([b.gyro_d for b in blocks])
    bias_b = np.concatenate([b.gyro_d for b in at_rest]).mean(axis=0)
    force_b = np.concatenate([b.accel_d for b in at_rest]).mean(axis=0)
    return Stretch(
        period_s=blocks[0].period_s,
        accel_b=np.concatenate([b.accel_d for b in blocks]),
        gyro_b=gyro_b - bias_b,
        wheels_m=np.concatenate([b.wheels_m for b in blocks]),
        up_b=force_b / np.sqrt(force_b.dot(force_b)),
        rest_b=np.concatenate([b.accel_d for b in blocks[:before]]).mean(axis=0),
    )
