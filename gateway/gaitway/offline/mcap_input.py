"""Walks from our own recordings: the samples as they were decoded then."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gaitway.errors import InputDataError
from gaitway.offline.recording import OfflineRecording
from gaitway.recording.items import Dropped, Header, Unreadable
from gaitway.recording.reader import read_joined
from gaitway.samples import EstimatorInput, Gap, SampleBatch
from gaitway.timebase import NS_PER_S


def read_mcap(path: Path, device_id: str | None = None) -> OfflineRecording:
    """Return the walk of one device from a recording, whole or cut off.

    What the file says of the device's type, mounting and parameters comes along.

    Args:
        path: The file.
        device_id: Which device; may be left out where only one sent samples.

    Raises:
        InputDataError: The file holds no samples of that device, or of several.
    """
    items, notes, header = _collect(path)
    device = _choose(path, items, device_id, notes)
    walk = _joined(items[device])
    batches = [item for item in walk if isinstance(item, SampleBatch)]
    settings = _settings(header, device)
    return OfflineRecording(
        source=path,
        period_s=batches[0].period_s,
        items=walk,
        channels=frozenset.intersection(*(frozenset(batch.channels) for batch in batches)),
        notes=notes,
        device=device,
        device_type=settings.get("type"),
        mounting=settings.get("mounting"),
        params=settings.get("params") or {},
    )


def _collect(path: Path) -> tuple[dict[str, list[EstimatorInput]], list[str], Header]:
    """Return samples and gaps by device, notes on what is missing, and the header."""
    items: dict[str, list[EstimatorInput]] = {}
    notes: list[str] = []
    header = Header({})
    try:
        for item in read_joined(path, leaves={"gap", "dropped"}):
            match item.body:
                case SampleBatch() | Gap():
                    items.setdefault(item.device, []).append(item.body)
                case Header():
                    header = item.body
                case Unreadable(offset, n_bytes, reason):
                    notes.append(f"{n_bytes} bytes at {offset} can't be read: {reason}")
                case Dropped(counts=counts):
                    notes.append(f"the recorder dropped {sum(counts.values())} messages here")
    except OSError as exc:
        raise InputDataError(f"{path}: {exc.strerror}") from exc
    return items, notes, header


def _choose(
    path: Path, items: Mapping[str, list[EstimatorInput]], device: str | None, notes: list[str]
) -> str:
    held = sorted(
        name
        for name, found in items.items()
        if any(isinstance(item, SampleBatch) for item in found)
    )
    if not held:
        why = f" ({notes[0]})" if notes else ""
        raise InputDataError(f"{path}: holds no samples of any device{why}")
    if device is None and len(held) > 1:
        raise InputDataError(
            f"{path}: holds samples of {', '.join(held)} (say which with --id {held[0]})"
        )
    if device is not None and device not in held:
        raise InputDataError(f"{path}: holds no samples of {device!r}, only of {', '.join(held)}")
    return device or held[0]


def _joined(found: list[EstimatorInput]) -> list[EstimatorInput]:
    """Return the items from the first samples to the last, a gap wherever numbers are missing."""
    walk: list[EstimatorInput] = []
    expected = 0
    for item in found:
        if isinstance(item, Gap):
            if walk:
                walk.append(item)
                expected += item.n_missing
            continue
        if walk and item.sequence != expected:
            walk.append(_gap_before(item, walk, expected))
        walk.append(item)
        expected = item.sequence + len(item)
    while isinstance(walk[-1], Gap):
        walk.pop()
    return walk


def _gap_before(batch: SampleBatch, walk: list[EstimatorInput], expected: int) -> Gap:
    """Return the gap that the recording does not mention: samples the recorder had to drop."""
    last = next(item for item in reversed(walk) if isinstance(item, SampleBatch))
    period_ns = round(batch.period_s * NS_PER_S)
    first_ns = int(last.t_ns[-1]) + period_ns
    if batch.sequence > expected:
        return Gap(first_ns, batch.sequence - expected, "lost")
    return Gap(first_ns, max(1, round((int(batch.t_ns[0]) - first_ns) / period_ns)), "lost")


def _settings(header: Header, device: str) -> Mapping[str, Any]:
    for entry in header.config.get("devices", ()):
        if entry.get("id") == device:
            return dict(entry)
    return {}
