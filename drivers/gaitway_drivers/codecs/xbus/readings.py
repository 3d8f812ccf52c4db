"""Turning the items of measurements into the channels of gaitway.

Angular rate and specific force come straight from the device where it sends them; else from its
increments, which are their mean over the period before. The sensor's attitude is given for a
z-up frame whatever frame the device was set to.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gaitway.api import ACCEL, ATTITUDE, CLIP, GYRO, Floats
from gaitway_drivers.codecs.xbus import mtdata2
from gaitway_drivers.codecs.xbus.framer import MessageRun
from gaitway_drivers.codecs.xbus.mtdata2 import Layout, decode_reals

DELTA_V: Final = "delta_v"
"""Velocity increment over a period, until the period is known."""
DELTA_Q: Final = "delta_q"
"""Rotation over a period as a quaternion, until the period is known."""

FIRST_CLIP_BIT: Final = 8
CLIP_MASK: Final = 0b111111
"""Bits 8-10 of the status word are the accelerometer's axes, bits 11-13 the gyroscope's."""
CLIP_BYTE: Final = 2
"""Where they are in the four bytes sent."""
_CLIP_OF_BYTE: Final = (np.arange(256) & CLIP_MASK).astype(np.float64)[:, np.newaxis]

SMALL_ANGLE: Final = 1e-8
"""Below this half angle (radians) its sine equals itself in float64."""


@dataclass(slots=True)
class Readings:
    """What consecutive measurements of one layout say.

    Attributes:
        messages: How many measurements.
        counters: Packet counter of each.
        ticks: SampleTimeFine of each, as sent.
        temperatures: Degrees Celsius of each.
        values: Channel name, or ``DELTA_V`` or ``DELTA_Q``, to values of shape (n, k).
    """

    messages: int
    counters: list[int] | None
    ticks: list[int] | None
    temperatures: list[float] | None
    values: Mapping[str, Floats]

    def row(self, index: int) -> "Readings":
        """Return one of the measurements."""
        one = slice(index, index + 1)
        return Readings(
            1,
            None if self.counters is None else self.counters[one],
            None if self.ticks is None else self.ticks[one],
            None if self.temperatures is None else self.temperatures[one],
            {name: rows[one] for name, rows in self.values.items()},
        )


def is_inertial(values: Mapping[str, Floats]) -> bool:
    """Tell whether there is angular rate or specific force among the values."""
    return bool(values.keys() & {ACCEL.name, GYRO.name, DELTA_V, DELTA_Q})


def is_complete(values: Mapping[str, Floats]) -> bool:
    """Tell whether the values make a sample: angular rate and specific force both."""
    return (ACCEL.name in values or DELTA_V in values) and (
        GYRO.name in values or DELTA_Q in values
    )


def read(layout: Layout, run: MessageRun) -> Readings:
    """Return what measurements of one layout say; if it has a fault, only their counters."""
    plan = _plan(layout)
    records = run.records(plan.record)
    celsius = None
    with np.errstate(invalid="ignore"):  # a device may send signalling NaNs
        values = {
            name: decode(data_id, records[field]) for name, data_id, field, decode in plan.channels
        }
        if plan.temperature is not None:
            data_id, field = plan.temperature
            celsius = decode_reals(data_id, records[field])[:, 0].tolist()
    return Readings(
        run.messages,
        None if plan.counter is None else records[plan.counter].tolist(),
        None if plan.ticks is None else records[plan.ticks].tolist(),
        celsius,
        values,
    )


def to_channels(values: Mapping[str, Floats], period_s: float) -> Mapping[str, Floats]:
    """Return values as channels, increments turned into means over the period they cover.

    Args:
        values: As in ``Readings``, complete.
        period_s: Sample period.
    """
    if DELTA_V not in values and DELTA_Q not in values:
        return values
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


def _attitude(data_id: int, sent: NDArray[Any]) -> Floats:
    q = decode_reals(data_id, sent)
    if data_id & 0xC == mtdata2.NED:
        # Half a turn about north makes z point up: (0, 1, 0, 0) times q.
        q = q.take((1, 0, 3, 2), axis=1) * (-1.0, 1.0, -1.0, 1.0)
    (flipped,) = (q[:, 0] < 0.0).nonzero()
    if len(flipped):
        q[flipped] *= -1.0
    return q


def _clip(_data_id: int, status: NDArray[Any]) -> Floats:
    return _CLIP_OF_BYTE.take(status.getfield(np.uint8, CLIP_BYTE), axis=0)


_Decode = Callable[[int, NDArray[Any]], Floats]
_CHANNEL_ITEMS: Final[tuple[tuple[str, int, _Decode], ...]] = (
    (ACCEL.name, mtdata2.ACCELERATION, decode_reals),
    (GYRO.name, mtdata2.RATE_OF_TURN, decode_reals),
    (ATTITUDE.name, mtdata2.QUATERNION, _attitude),
    (CLIP.name, mtdata2.STATUS_WORD, _clip),
    (DELTA_V, mtdata2.DELTA_V, decode_reals),
    (DELTA_Q, mtdata2.DELTA_Q, decode_reals),
)


@dataclass(slots=True)
class _Plan:
    """What is read from measurements of one layout: fields of their record."""

    record: np.dtype[np.void]
    counter: str | None
    ticks: str | None
    temperature: tuple[int, str] | None
    channels: tuple[tuple[str, int, str, _Decode], ...]


@lru_cache(maxsize=mtdata2.MAX_LAYOUTS)
def _plan(layout: Layout) -> _Plan:
    counter, ticks = layout.find(mtdata2.PACKET_COUNTER), layout.find(mtdata2.SAMPLE_TIME_FINE)
    temperature = layout.find(mtdata2.TEMPERATURE)
    found = [(name, layout.find(quantity), decode) for name, quantity, decode in _CHANNEL_ITEMS]
    plan = _Plan(
        record=layout.record(),
        counter=counter and counter.name,
        ticks=ticks and ticks.name,
        temperature=temperature and (temperature.data_id, temperature.name),
        channels=tuple(
            (name, item.data_id, item.name, decode) for name, item, decode in found if item
        ),
    )
    if layout.fault:
        return replace(plan, ticks=None, temperature=None, channels=())
    return plan
