"""A stream without holes: short gaps bridged, long ones said."""

import math
from typing import NamedTuple

from gaitway.estimation.rotation import Vector
from gaitway.samples import ACCEL, CLIP, GYRO, EstimatorInput, Gap, SampleBatch

_SENSOR_MAX: float = 1e5
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


class Break(NamedTuple):
    """Samples are missing, too many to bridge.

    Attributes:
        t_ns: Host time of the last sample before.
        duration_s: From there to the first sample after.
    """

    t_ns: int
    duration_s: float


class GapBridge:
    """Turns batches and gaps into samples and breaks.

    A gap of at most ``max_bridge_s`` is filled in a straight line from the sample before to the one
    after, and told apart by ``bridged``; a longer one, or one in which the device started anew,
    becomes a ``Break``. A sample that is not finite counts as missing. How the stream is cut into
    batches changes nothing.

    Args:
        max_bridge_s: Longest gap that is bridged.
    """

    def __init__(self, max_bridge_s: float) -> None:
        self._max_bridge_s = max_bridge_s
        self._last: ImuSample | None = None
        self._missing = 0
        self._restarted = False

    def feed(self, item: EstimatorInput) -> list[ImuSample | Break]:
        """Return what the next item makes known, in the order of time."""
        if isinstance(item, Gap):
            self._missing += item.n_missing
            self._restarted |= item.reason == "device-restart"
            return []
        out: list[ImuSample | Break] = []
        for sample in _rows(item):
            # An infinity or a NaN anywhere makes the sum one too.
            if not abs(sum(map(abs, sample.accel_d + sample.gyro_d))) < _SENSOR_MAX:
                self._missing += 1
                continue
            if self._missing:
                out += self._across(sample, item.period_s)
            out.append(sample)
            self._last = sample
        return out

    def _across(self, after: ImuSample, period_s: float) -> list[ImuSample | Break]:
        before, missing, restarted = self._last, self._missing, self._restarted
        self._missing, self._restarted = 0, False
        if before is None:
            return []
        if restarted or missing > math.floor(self._max_bridge_s / period_s + 1e-6):
            return [Break(before.t_ns, (missing + 1) * period_s)]
        return [_between(before, after, part, missing + 1) for part in range(1, missing + 1)]


def _rows(batch: SampleBatch) -> list[ImuSample]:
    flags = batch.channels.get(CLIP.name)
    clipped = [False] * len(batch) if flags is None else (flags[:, 0] != 0).tolist()
    accel = map(tuple, batch.channels[ACCEL.name].tolist())
    gyro = map(tuple, batch.channels[GYRO.name].tolist())
    return [
        ImuSample(t_ns, a, w, c, bridged=False)
        for t_ns, a, w, c in zip(batch.t_ns.tolist(), accel, gyro, clipped, strict=True)
    ]


def _between(before: ImuSample, after: ImuSample, part: int, whole: int) -> ImuSample:
    share = part / whole

    def mix(old: Vector, new: Vector) -> Vector:
        x, y, z = (o + share * (n - o) for o, n in zip(old, new, strict=True))
        return (x, y, z)

    return ImuSample(
        t_ns=before.t_ns + (after.t_ns - before.t_ns) * part // whole,
        accel_d=mix(before.accel_d, after.accel_d),
        gyro_d=mix(before.gyro_d, after.gyro_d),
        clipped=before.clipped or after.clipped,
        bridged=True,
    )
