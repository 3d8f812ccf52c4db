"""Turning the items of measurements into the channels of gaitway.

Angular rate and specific force come straight from the device where it sends them; else from its
increments, which are their mean over the period before. The sensor's attitude is given for a
z-up frame whatever frame the device was set to.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from gaitway.api import ACCEL, ATTITUDE, CLIP, GYRO, Floats, Ints
from gaitway_drivers.codecs.xbus import mtdata2
from gaitway_drivers.codecs.xbus.framer import Bytes
from gaitway_drivers.codecs.xbus.mtdata2 import Item, Layout, decode_item, decode_reals

DELTA_V: Final = "delta_v"
"""Velocity increment over a period, until the period is known."""
DELTA_Q: Final = "delta_q"
"""Rotation over a period as a quaternion, until the period is known."""

FIRST_CLIP_BIT: Final = 8
CLIP_MASK: Final = 0b111111
"""Bits 8-10 of the status word are the accelerometer's axes, bits 11-13 the gyroscope's."""
CLIP_BYTE: Final = 3 - FIRST_CLIP_BIT // 8
"""Where they are in the four bytes of the word, as they are sent: the lowest bits of this one."""

SMALL_ANGLE: Final = 1e-8
"""Below this half angle (radians) its sine equals itself in float64."""


@dataclass(frozen=True, slots=True)
class Readings:
    """What consecutive measurements of one layout say.

    Attributes:
        count: How many measurements.
        counters: Packet counter of each.
        ticks: SampleTimeFine of each, as sent, shape (n,).
        temperatures: Degrees Celsius, shape (n,).
        values: Channel name, or ``DELTA_V`` or ``DELTA_Q``, to values of shape (n, k).
    """

    count: int
    counters: list[int] | None
    ticks: Ints | None
    temperatures: Floats | None
    values: Mapping[str, Floats]

    def row(self, index: int) -> "Readings":
        """Return one of the measurements."""
        one = slice(index, index + 1)
        return Readings(
            count=1,
            counters=None if self.counters is None else self.counters[one],
            ticks=None if self.ticks is None else self.ticks[one],
            temperatures=None if self.temperatures is None else self.temperatures[one],
            values={name: rows[one] for name, rows in self.values.items()},
        )


def is_inertial(values: Mapping[str, Floats]) -> bool:
    """Tell whether there is angular rate or specific force among the values."""
    return bool(values.keys() & {ACCEL.name, GYRO.name, DELTA_V, DELTA_Q})


def is_complete(values: Mapping[str, Floats]) -> bool:
    """Tell whether the values make a sample: angular rate and specific force both."""
    return (ACCEL.name in values or DELTA_V in values) and (
        GYRO.name in values or DELTA_Q in values
    )


def read(layout: Layout, payloads: Bytes) -> Readings:
    """Return what payloads of one layout say; a layout with a fault tells only its counter."""
    counter = layout.find(mtdata2.PACKET_COUNTER)
    counters = None if counter is None else decode_item(counter, payloads).tolist()
    if layout.fault:
        return Readings(len(payloads), counters, None, None, {})
    ticks = layout.find(mtdata2.SAMPLE_TIME_FINE)
    temperature = layout.find(mtdata2.TEMPERATURE)
    values: dict[str, Floats] = {}
    with np.errstate(invalid="ignore"):  # a device may send signalling NaNs
        for name, quantity, decode in _CHANNEL_ITEMS:
            item = layout.find(quantity)
            if item is not None:
                values[name] = decode(item, payloads)
        celsius = None if temperature is None else decode_reals(temperature, payloads)[:, 0]
    return Readings(
        count=len(payloads),
        counters=counters,
        ticks=None if ticks is None else decode_item(ticks, payloads).astype(np.int64),
        temperatures=celsius,
        values=values,
    )


def to_channels(values: Mapping[str, Floats], period_s: float) -> dict[str, Floats]:
    """Return values as channels, increments turned into means over the period they cover.

    Args:
        values: As in ``Readings``, complete.
        period_s: Sample period.
    """
    channels = dict(values)
    delta_v, delta_q = channels.pop(DELTA_V, None), channels.pop(DELTA_Q, None)
    if delta_v is not None and ACCEL.name not in channels:
        channels[ACCEL.name] = delta_v / period_s
    if delta_q is not None and GYRO.name not in channels:
        channels[GYRO.name] = _rotation_vector(delta_q) / period_s
    return channels


def _rotation_vector(q: Floats) -> Floats:
    """Return unit quaternions of shape (n, 4) as rotation vectors in radians, shape (n, 3)."""
    with np.errstate(invalid="ignore", over="ignore"):
        q = np.where(q[:, :1] < 0.0, -q, q)
        sine = np.linalg.norm(q[:, 1:], axis=1, keepdims=True)
        half_angle = np.arctan2(sine, q[:, :1])
        ratio = np.where(sine < SMALL_ANGLE, 1.0, half_angle / np.maximum(sine, SMALL_ANGLE))
        return 2.0 * ratio * q[:, 1:]


def _attitude(item: Item, payloads: Bytes) -> Floats:
    q = decode_reals(item, payloads)
    if item.data_id & 0xC == mtdata2.NED:
        # Half a turn about north makes z point up: (0, 1, 0, 0) times q.
        q = q.take((1, 0, 3, 2), axis=1) * (-1.0, 1.0, -1.0, 1.0)
    flipped = q[:, 0] < 0.0
    if flipped.any():
        q[flipped] *= -1.0
    return q


def _clip(item: Item, payloads: Bytes) -> Floats:
    at = item.start + CLIP_BYTE
    return (payloads[:, at : at + 1] & CLIP_MASK).astype(np.float64)


_CHANNEL_ITEMS: Final[tuple[tuple[str, int, Callable[[Item, Bytes], Floats]], ...]] = (
    (ACCEL.name, mtdata2.ACCELERATION, decode_reals),
    (GYRO.name, mtdata2.RATE_OF_TURN, decode_reals),
    (ATTITUDE.name, mtdata2.QUATERNION, _attitude),
    (CLIP.name, mtdata2.STATUS_WORD, _clip),
    (DELTA_V, mtdata2.DELTA_V, decode_reals),
    (DELTA_Q, mtdata2.DELTA_Q, decode_reals),
)
