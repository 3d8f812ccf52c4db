"""A stream without holes: short gaps bridged, long ones said."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from gaitway.estimation.rotation import Vector
from gaitway.samples import ACCEL, CLIP, GYRO, EstimatorInput, Floats, Gap, Ints, SampleBatch

_SENSOR_MAX: Final = 1e5
"""Beyond any accelerometer's m/s^2 and any gyroscope's rad/s: such a reading is no reading."""


class ImuSample(NamedTuple):
    """One sample of an inertial sensor, mean over the period that ends at its time.

    Attributes:
        t_ns: Host time.
        accel_d: Specific force, m/s^2.
        gyro_d: Angular rate, rad/s.
        clipped: An axis was at the end of its range.
        bridged: Not measured but interpolated between its neighbours.
    """

    t_ns: int
    accel_d: Vector
    gyro_d: Vector
    clipped: bool
    bridged: bool


@dataclass(frozen=True, slots=True, eq=False)
class ImuBlock:
    """Consecutive samples of an inertial sensor, as arrays.

    Attributes:
        t_ns: Host time, shape (n,).
        accel_d: Specific force, m/s^2, shape (n, 3).
        gyro_d: Angular rate, rad/s, shape (n, 3).
        clipped: Where an axis was at the end of its range, shape (n,).
        bridged: Which were not measured but interpolated, shape (n,).
    """

    t_ns: Ints
    accel_d: Floats
    gyro_d: Floats
    clipped: NDArray[np.bool_]
    bridged: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.t_ns)

    def __getitem__(self, rows: slice) -> "ImuBlock":
        """Return the samples of a slice."""
        return ImuBlock(
            self.t_ns[rows],
            self.accel_d[rows],
            self.gyro_d[rows],
            self.clipped[rows],
            self.bridged[rows],
        )

    @classmethod
    def joined(cls, *blocks: Self) -> "ImuBlock":
        """Return blocks that follow each other as one; at least one."""
        if len(blocks) == 1:
            return blocks[0]
        return ImuBlock(
            np.concatenate([block.t_ns for block in blocks]),
            np.concatenate([block.accel_d for block in blocks]),
            np.concatenate([block.gyro_d for block in blocks]),
            np.concatenate([block.clipped for block in blocks]),
            np.concatenate([block.bridged for block in blocks]),
        )

    def sample(self, row: int) -> ImuSample:
        """Return one sample."""
        ax, ay, az = self.accel_d[row].tolist()
        gx, gy, gz = self.gyro_d[row].tolist()
        clipped, bridged = bool(self.clipped[row]), bool(self.bridged[row])
        return ImuSample(int(self.t_ns[row]), (ax, ay, az), (gx, gy, gz), clipped, bridged)

    def samples(self) -> Iterator[ImuSample]:
        """Yield every sample."""
        columns = (self.t_ns, self.accel_d, self.gyro_d, self.clipped, self.bridged)
        for t_ns, accel, gyro, clipped, bridged in zip(
            *(column.tolist() for column in columns), strict=True
        ):
            yield ImuSample(t_ns, tuple(accel), tuple(gyro), clipped, bridged)


class Break(NamedTuple):
    """Samples are missing, too many to bridge.

    Attributes:
        t_ns: Host time of the last sample before.
        duration_s: From there to the first sample after.
    """

    t_ns: int
    duration_s: float


class BlockBridge:
    """Turns batches and gaps into blocks of samples and breaks.

    A gap of at most ``max_bridge_s`` is filled in a straight line from the sample before to the one
    after, and told apart by ``bridged``; a longer one, or one in which the device started anew,
    becomes a ``Break``. A sample that is not finite counts as missing. How the stream is cut into
    batches changes nothing but where blocks end.

    Args:
        max_bridge_s: Longest gap that is bridged.
    """

    def __init__(self, max_bridge_s: float) -> None:
        self._max_bridge_s = max_bridge_s
        self._last: ImuBlock | None = None
        self._missing = 0
        self._restarted = False

    def feed(self, item: EstimatorInput) -> list[ImuBlock | Break]:
        """Return what the next item makes known, in the order of time."""
        if isinstance(item, Gap):
            self._missing += item.n_missing
            self._restarted |= item.reason == "device-restart"
            return []
        block = _block(item)
        # An infinity or a NaN anywhere makes the sum one too.
        good = (np.abs(block.accel_d).sum(axis=1) + np.abs(block.gyro_d).sum(axis=1)) < _SENSOR_MAX
        if good.all():
            return self._take(block, item.period_s) if len(block) else []
        out: list[ImuBlock | Break] = []
        edges = [0, *(np.flatnonzero(np.diff(good)) + 1).tolist(), len(good)]
        for start, stop in pairwise(edges):
            if good[start]:
                out += self._take(block[start:stop], item.period_s)
            else:
                self._missing += stop - start
        return out

    def _take(self, block: ImuBlock, period_s: float) -> list[ImuBlock | Break]:
        across = self._across(block[:1], period_s) if self._missing else []
        self._last = block[-1:]
        return [*across, block]

    def _across(self, after: ImuBlock, period_s: float) -> list[ImuBlock | Break]:
        before, missing, restarted = self._last, self._missing, self._restarted
        self._missing, self._restarted = 0, False
        if before is None:
            return []
        if restarted or missing > math.floor(self._max_bridge_s / period_s + 1e-6):
            return [Break(int(before.t_ns[0]), (missing + 1) * period_s)]
        return [_between(before, after, missing)]


class GapBridge:
    """The same a sample at a time, for stages that look at each by itself.

    Args:
        max_bridge_s: Longest gap that is bridged.
    """

    def __init__(self, max_bridge_s: float) -> None:
        self._blocks = BlockBridge(max_bridge_s)

    def feed(self, item: EstimatorInput) -> list[ImuSample | Break]:
        """Return what the next item makes known, in the order of time."""
        out: list[ImuSample | Break] = []
        for entry in self._blocks.feed(item):
            out += [entry] if isinstance(entry, Break) else entry.samples()
        return out


def _block(batch: SampleBatch) -> ImuBlock:
    flags = batch.channels.get(CLIP.name)
    clipped = np.zeros(len(batch), np.bool_) if flags is None else flags[:, 0] != 0.0
    return ImuBlock(
        batch.t_ns,
        batch.channels[ACCEL.name],
        batch.channels[GYRO.name],
        clipped,
        np.zeros(len(batch), np.bool_),
    )


def _between(before: ImuBlock, after: ImuBlock, missing: int) -> ImuBlock:
    part = np.arange(1, missing + 1)
    share = (part / (missing + 1))[:, np.newaxis]
    clipped = bool(before.clipped[0] or after.clipped[0])
    return ImuBlock(
        before.t_ns[0] + (after.t_ns[0] - before.t_ns[0]) * part // (missing + 1),
        before.accel_d + share * (after.accel_d - before.accel_d),
        before.gyro_d + share * (after.gyro_d - before.gyro_d),
        np.full(missing, clipped),
        np.ones(missing, np.bool_),
    )
