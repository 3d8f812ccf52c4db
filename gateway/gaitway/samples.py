"""What flows from a device towards its estimator.

::

    Chunk --Codec--> DeviceBatch | Fault | DeviceStatus | Command | HandshakeFailed
          --Aligner--> SampleBatch | Gap --Estimator--> events

A codec speaks in the device's own time (``DeviceBatch.device_ns``); only the aligner, which knows
both clocks, makes a ``SampleBatch`` in the host's. The two are separate types so that unaligned
time can't be taken for aligned.
"""

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Channel:
    """One physical quantity of a sample.

    Attributes:
        name: Key into ``SampleBatch.channels``; carries the frame where the quantity has one.
        columns: What each column is called in CSV files and recordings, unit included.
    """

    name: str
    columns: tuple[str, ...]


ACCEL: Final = Channel("accel", ("accel_x_mps2", "accel_y_mps2", "accel_z_mps2"))
"""Specific force. In frame b from the codec; in frame d once the mounting was applied."""
GYRO: Final = Channel("gyro", ("gyro_x_radps", "gyro_y_radps", "gyro_z_radps"))
"""Angular rate. In frame b from the codec; in frame d once the mounting was applied."""
ATTITUDE: Final = Channel("q_nb", ("q_w", "q_x", "q_y", "q_z"))
"""Attitude reported by the sensor itself (``q_nd`` once the mounting was applied)."""
CLIP: Final = Channel("clip", ("clip_flags",))
"""Bits 0-2: accelerometer x, y, z clipped; bits 3-5: gyroscope x, y, z clipped; IMU axes."""
FORCE: Final = Channel("force", ("force_newton",))
FORCE_VOLT: Final = Channel("force_volt", ("force_volt",))
INCLINATION: Final = Channel("inclination", ("inclination_rad",))
INCLINATION_ROLL: Final = Channel("inclination_roll", ("inclination_roll_rad",))
LEFT_TICKS: Final = Channel("left_ticks", ("left_ticks",))
RIGHT_TICKS: Final = Channel("right_ticks", ("right_ticks",))

CHANNELS: Final = (
    ACCEL, GYRO, ATTITUDE, CLIP, FORCE, FORCE_VOLT,
    INCLINATION, INCLINATION_ROLL, LEFT_TICKS, RIGHT_TICKS,
)  # fmt: skip
"""Every channel the core has a name for; a plugin may bring its own."""


Required = Sequence[Channel | tuple[Channel, ...]]
"""What an estimator can't do without; of a tuple of channels any one will do."""


def missing_channels(required: Required, held: Container[str]) -> list[str]:
    """Return what is not among the names held, alternatives as ``force or force_volt``."""
    missing = []
    for entry in required:
        names = [channel.name for channel in (entry if isinstance(entry, tuple) else (entry,))]
        if not any(name in held for name in names):
            missing.append(" or ".join(names))
    return missing


@dataclass(frozen=True, slots=True)
class Chunk:
    """Bytes as they came off a link.

    Attributes:
        t_ns: When they were read, host monotonic.
        data: The bytes; never empty.
    """

    t_ns: int
    data: bytes


@dataclass(frozen=True, slots=True, eq=False)
class DeviceBatch:
    """Consecutive samples in the device's own time, axes as the device reports them.

    Attributes:
        arrival_ns: When the bytes of the last sample were read, host monotonic.
        device_ns: Device time of each sample, unwrapped, strictly rising, shape (n,).
        period_s: Nominal sample period of this stream.
        channels: Channel name to values, each of shape (n, k), read-only.
        restarted: The device's clock began anew with the first of these samples.
    """

    arrival_ns: int
    device_ns: Ints
    period_s: float
    channels: Mapping[str, Floats]
    restarted: bool = False

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.device_ns)


@dataclass(frozen=True, slots=True, eq=False)
class SampleBatch:
    """Consecutive samples, none missing between them, in host time.

    Samples lie on a grid of ``period_s``; an estimator integrates with ``period_s`` and uses
    ``t_ns`` only to say when something happened, so host jitter changes no length.

    Attributes:
        t_ns: Host monotonic time of each sample, strictly rising, shape (n,).
        period_s: Sample period.
        sequence: Number of the first sample on the device's grid; gaps are counted.
        channels: Channel name to values, each of shape (n, k), read-only.
    """

    t_ns: Ints
    period_s: float
    sequence: int
    channels: Mapping[str, Floats]

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.t_ns)

    def __getitem__(self, rows: slice) -> "SampleBatch":
        """Return the samples of a contiguous slice as a batch of their own."""
        start, stop, step = rows.indices(len(self))
        if step != 1:
            raise ValueError("a SampleBatch holds consecutive samples: slice with step 1")
        return SampleBatch(
            t_ns=self.t_ns[start:stop],
            period_s=self.period_s,
            sequence=self.sequence + start,
            channels={name: values[start:stop] for name, values in self.channels.items()},
        )


GapReason = Literal["lost", "link-down", "device-restart"]


@dataclass(frozen=True, slots=True)
class Gap:
    """Samples that are missing between the one before and the one after.

    Attributes:
        t_ns: Host time of the first missing sample.
        n_missing: How many samples of the grid are missing, at least 1.
        reason: ``lost`` on the way; ``link-down`` while nobody listened; ``device-restart`` when
            the device's clock began anew and the number is the host's estimate.
    """

    t_ns: int
    n_missing: int
    reason: GapReason


@dataclass(frozen=True, slots=True)
class Fault:
    """Bytes or samples that could not be used.

    Attributes:
        t_ns: Host time of the chunk that showed it.
        kind: Short kebab-case name, for example ``resync``, ``bad-checksum``, ``lost-messages``.
        count: Bytes for byte faults, samples or messages for the others.
        detail: One line for a person.
    """

    t_ns: int
    kind: str
    count: int
    detail: str = ""


@dataclass(frozen=True, slots=True)
class DeviceStatus:
    """What a device said about itself: ids, firmware, settings read back, battery.

    Attributes:
        t_ns: Host time of the chunk that told it.
        fields: Names with units to values, for example ``{"battery_percent": 80}``.
    """

    t_ns: int
    fields: Mapping[str, str | int | float]


@dataclass(frozen=True, slots=True)
class Command:
    """Bytes the codec wants sent to the device."""

    payload: bytes


@dataclass(frozen=True, slots=True)
class HandshakeFailed:
    """The device did not answer as it must; the link is opened anew after a pause.

    Attributes:
        t_ns: Host time at which the codec gave up.
        reason: What was asked, what came, what to check; one line.
    """

    t_ns: int
    reason: str


CodecItem = DeviceBatch | Fault | DeviceStatus | Command | HandshakeFailed
EstimatorInput = SampleBatch | Gap


def frozen_rows(values: object, columns: int) -> Floats:
    """Return values as a read-only C-contiguous float64 array of shape (n, columns)."""
    rows = np.array(values, dtype=np.float64, order="C").reshape(-1, columns)
    rows.setflags(write=False)
    return rows
