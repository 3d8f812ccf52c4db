"""A walk from a file, ready for an estimator."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gaitway.errors import InputDataError
from gaitway.mounting import Mounting
from gaitway.samples import EstimatorInput, Gap, Required, SampleBatch, missing_channels
from gaitway.timebase import NS_PER_S


@dataclass(frozen=True, slots=True, eq=False)
class OfflineRecording:
    """Samples and gaps of one device in the order of time, axes of the IMU (frame b).

    Attributes:
        source: The file.
        period_s: Sample period.
        items: What the estimator is given; begins and ends with samples.
        channels: Names of the channels that every batch holds.
        notes: What was passed over or repaired, a line each, for a person.
        device: Id of the device, where the file knows it.
        device_type: Its type, where the file knows it.
        mounting: How its IMU sits, where the file knows it.
        params: Parameters of its estimator, where the file knows them.
    """

    source: Path
    period_s: float
    items: Sequence[EstimatorInput]
    channels: frozenset[str]
    notes: Sequence[str] = ()
    device: str | None = None
    device_type: str | None = None
    mounting: Mounting | None = None
    params: Mapping[str, Any] = field(default_factory=dict)

    @property
    def batches(self) -> list[SampleBatch]:
        """The samples without the gaps."""
        return [item for item in self.items if isinstance(item, SampleBatch)]

    @property
    def samples(self) -> int:
        """How many samples there are."""
        return sum(len(batch) for batch in self.batches)

    @property
    def samples_lost(self) -> int:
        """How many samples are missing between the first and the last."""
        return sum(item.n_missing for item in self.items if isinstance(item, Gap))

    @property
    def duration_s(self) -> float:
        """From the first sample to the last."""
        batches = self.batches
        return int(batches[-1].t_ns[-1] - batches[0].t_ns[0]) / NS_PER_S

    def require(self, channels: Required) -> None:
        """Check that the walk holds what an estimator can't do without.

        Raises:
            InputDataError: A channel is missing.
        """
        missing = missing_channels(channels, self.channels)
        if missing:
            held = ", ".join(sorted(self.channels)) or "none"
            raise InputDataError(
                f"{self.source}: holds no channel {', '.join(missing)}, which this device type "
                f"needs (it holds: {held})"
            )
