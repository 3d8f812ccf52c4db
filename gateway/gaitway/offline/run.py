"""A walk through an estimator, and what came of it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

from gaitway.contracts import DeviceType, Estimator
from gaitway.events import Distance, Event, Stride
from gaitway.mounting import mount
from gaitway.offline.recording import OfflineRecording
from gaitway.samples import Floats, Gap

BATCH_SAMPLES: Final = 4096


def run_estimator(
    estimator: Estimator, recording: OfflineRecording, C_db: Floats, batch: int = BATCH_SAMPLES
) -> list[Event]:
    """Return everything an estimator says of a walk, in order, its end included.

    Args:
        estimator: Fresh from its factory.
        recording: The walk, axes of the IMU.
        C_db: Rotation from IMU to device components, shape (3, 3).
        batch: Samples handed over at once; live they come in smaller batches, and it is the
            estimator's promise that this changes nothing.
    """
    events: list[Event] = []
    for item in recording.items:
        if isinstance(item, Gap):
            events += estimator.update(item)
            continue
        mounted = mount(item, C_db)
        for start in range(0, len(mounted), batch):
            events += estimator.update(mounted[start : start + batch])
    events += estimator.finish()
    return events


def summarise(
    device_type: DeviceType, recording: OfflineRecording, events: Sequence[Event]
) -> dict[str, Any]:
    """Return the outcome of a walk: finite numbers, and None for what is not known.

    Without a ``Distance`` event the strides are summed, and the standard deviation is unknown.
    """
    strides = [event for event in events if isinstance(event, Stride)]
    lengths_m = [stride.stride_length_m for stride in strides]
    durations_s = [stride.stride_duration_s for stride in strides]
    distances = [event for event in events if isinstance(event, Distance)]
    last = distances[-1] if distances else None
    summary: dict[str, Any] = {
        "device": device_type.name,
        "duration_s": recording.duration_s,
        "walking_s": last.walking_s if last else math.fsum(durations_s),
        "distance_m": last.distance_m if last else math.fsum(lengths_m),
        "distance_sigma_m": last.distance_sigma_m if last else None,
        "strides": last.strides if last else len(strides),
        "stride_length_m": lengths_m,
    }
    if device_type.summarise is not None:
        summary |= device_type.summarise(events)
    return {name: _finite(value) for name, value in summary.items()}


def _finite(value: Any) -> Any:
    """Return a value with None wherever a number is not finite, as JSON has to have it."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value
