"""Counting what happens to one device, and saying it as a status event."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Final, Literal

from gaitway.events import LinkStateName, Status
from gaitway.samples import DeviceStatus, Fault, Gap
from gaitway.timebase import NS_PER_S

RATE_OVER_S: Final = 1.0


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What a status says about the rest of the gateway.

    Attributes:
        dropped: Items dropped by each bounded queue.
        recording: State of the recording.
        recording_reason: Why it is not on.
    """

    dropped: Mapping[str, int]
    recording: Literal["on", "off", "paused"]
    recording_reason: str


class Health:
    """Counters of one device since the gateway started."""

    def __init__(self) -> None:
        self.samples = 0
        self.samples_lost = 0
        self.bytes_received = 0
        self.reconnects = 0
        self.estimator: Literal["running", "failed"] = "running"
        self._faults: Counter[str] = Counter()
        self._device: dict[str, str | int | float] = {}
        self._rate_from: tuple[int, int] | None = None
        self._rate_hz: float | None = None

    def count_fault(self, fault: Fault) -> None:
        """Add a fault under its kind."""
        self._faults[fault.kind] += fault.count

    def count_gap(self, gap: Gap) -> None:
        """Add missing samples."""
        self.samples_lost += gap.n_missing

    def note_device(self, status: DeviceStatus) -> None:
        """Keep the newest of what the device said; what has no JSON form is dropped."""
        self._device.update(
            {
                str(name): value
                for name, value in status.fields.items()
                if isinstance(value, str | int) or (isinstance(value, float) and isfinite(value))
            }
        )

    def measure_rate(self, t_ns: int) -> None:
        """Measure the sample rate since it was last measured, a second ago or more."""
        if self._rate_from is None:
            self._rate_from = (t_ns, self.samples)
            return
        from_ns, from_samples = self._rate_from
        seconds = (t_ns - from_ns) / NS_PER_S
        if seconds >= RATE_OVER_S:
            received = self.samples - from_samples
            self._rate_hz = received / seconds if received else None
            self._rate_from = (t_ns, self.samples)

    def status(
        self,
        t_ns: int,
        *,
        link: LinkStateName,
        reason: str,
        since_t_ns: int,
        latency_s: float,
        surroundings: Surroundings,
    ) -> Status:
        """Return everything as an event."""
        return Status(
            t_ns=t_ns,
            link=link,
            reason=reason,
            since_t_ns=since_t_ns,
            samples=self.samples,
            samples_lost=self.samples_lost,
            sample_rate_hz=self._rate_hz if link == "streaming" else None,
            faults=dict(self._faults),
            reconnects=self.reconnects,
            bytes_received=self.bytes_received,
            estimator=self.estimator,
            latency_s=latency_s,
            dropped=dict(surroundings.dropped),
            recording=surroundings.recording,
            recording_reason=surroundings.recording_reason,
            device_info=self._device,
        )
