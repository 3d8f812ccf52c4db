"""A recording through today's code: the same pipeline, fed with the recorded bytes and times."""

import json
import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gaitway.config.load import ResolvedDevice, resolve_recorded
from gaitway.errors import InputDataError
from gaitway.events import Event, Status
from gaitway.recording.items import (
    Header,
    LinkChange,
    RecordedChunk,
    RecordedItem,
    Resumed,
    Unreadable,
)
from gaitway.recording.reader import read
from gaitway.registry import Registry
from gaitway.runtime.link_state import LinkState
from gaitway.runtime.outlet import Direction
from gaitway.runtime.pipeline import Pipeline
from gaitway.samples import Chunk, DeviceStatus, Fault, Gap, SampleBatch

logger = logging.getLogger(__name__)


@dataclass(slots=True)
class DeviceReplay:
    """What one device's estimator said then, and says today.

    Attributes:
        recorded: Events of the recording, in order; status events are left out.
        replayed: Events of today's code.
        at_end: How many of the replayed came only because the bytes ended.
    """

    recorded: list[Event] = field(default_factory=list)
    replayed: list[Event] = field(default_factory=list)
    at_end: int = 0

    @property
    def first_difference(self) -> int | None:
        """Return the number of the first event that differs, None when all are equal.

        A recording that was cut off lacks what the estimator would have said at its end: those
        last events may be missing from it.
        """
        for number, (then, now) in enumerate(zip(self.recorded, self.replayed, strict=False)):
            if type(then) is not type(now) or then != now:
                return number
        shorter = min(len(self.recorded), len(self.replayed))
        if len(self.recorded) > shorter or len(self.replayed) - self.at_end > shorter:
            return shorter
        return None


@dataclass(slots=True)
class Replay:
    """A whole replay.

    Attributes:
        devices: By id.
        unreadable: Parts of the files that gave nothing.
        starts_late: The first file is not the first of its run, so running sums can't agree.
    """

    devices: dict[str, DeviceReplay]
    unreadable: list[Unreadable]
    starts_late: bool


class _Listener:
    """The outlet of a replay: keeps the events and nothing else."""

    def __init__(self, devices: Mapping[str, DeviceReplay]) -> None:
        self._devices = devices

    def event(self, device: str, event: Event) -> None:
        self._devices[device].replayed.append(event)

    def chunk(self, device: str, chunk: Chunk, direction: Direction) -> None:
        """Leave out what the recording has already."""

    def samples(self, device: str, batch: SampleBatch) -> None:
        """Leave out."""

    def gap(self, device: str, gap: Gap) -> None:
        """Leave out."""

    def fault(self, device: str, fault: Fault) -> None:
        """Leave out."""

    def resumed(self, device: str, resumed: Resumed) -> None:
        """Leave out."""

    def device_status(self, device: str, status: DeviceStatus) -> None:
        """Leave out."""

    def link(self, device: str, t_ns: int, state: str, reason: str) -> None:
        """Leave out."""


def replay(files: Sequence[Path], registry: Registry) -> Replay:
    """Run recordings of one run of the gateway, in their order, through today's code.

    Raises:
        InputDataError: The files hold no gaitway recording, or not all of one run.
        ConfigError: A device type or codec of the recording is not installed.
    """
    items = _items(files)
    first = next(items, None)
    if first is None or not isinstance(first.body, Header):
        raise InputDataError(f"{files[0]}: is no recording of gaitway (it has no header)")
    header = first.body.entries
    resolved = resolve_recorded(json.loads(header["config"]), files[0], registry)
    devices = {device.config.id: DeviceReplay() for device in resolved}
    result = Replay(devices, [], starts_late=not _is_first(files[0]))
    pipelines = {device.config.id: _Player(device, _Listener(devices)) for device in resolved}
    for item in items:
        match item.body:
            case Header() if item.body.entries["run"] != header["run"]:
                raise InputDataError(
                    f"the files come from different runs of the gateway, {header['run']} and "
                    f"{item.body.entries['run']} (replay each run by itself)"
                )
            case Unreadable():
                result.unreadable.append(item.body)
            case Status():
                pass
            case Event():
                devices[item.device].recorded.append(item.body)
            case Resumed():
                pipelines[item.device].resume(item.body)
            case RecordedChunk() | LinkChange():
                pipelines[item.device].play(item.body)
            case _:
                pass
    for device, player in pipelines.items():
        before = len(devices[device].replayed)
        player.finish()
        devices[device].at_end = len(devices[device].replayed) - before
    return result


class _Player:
    """Feeds one device's pipeline as the daemon did."""

    def __init__(self, device: ResolvedDevice, out: _Listener) -> None:
        self._pipeline = Pipeline(device, out)
        self._open = False
        self._last_t_ns = 0

    def resume(self, state: Resumed) -> None:
        self._pipeline.resume(state)

    def play(self, body: RecordedChunk | LinkChange) -> None:
        try:
            self._feed(body)
        except Exception:
            # As the daemon: a codec that raises loses its link, which the recording has next.
            logger.exception("the driver failed")

    def _feed(self, body: RecordedChunk | LinkChange) -> None:
        if isinstance(body, RecordedChunk):
            if body.direction == "rx":
                self._last_t_ns = body.chunk.t_ns
                self._pipeline.feed(body.chunk)
        elif body.state == LinkState.SYNCING.value:
            self._open = True
            self._pipeline.link_opened(body.t_ns)
        elif body.state in (LinkState.WAITING.value, LinkState.CLOSED.value) and self._open:
            self._open = False
            self._pipeline.link_lost(body.t_ns)

    def finish(self) -> None:
        if self._open:
            self._pipeline.link_lost(self._last_t_ns)
        self._pipeline.finish()


def _items(files: Iterable[Path]) -> Iterator[RecordedItem]:
    for file in files:
        yield from read(file)


def _is_first(file: Path) -> bool:
    """Tell from its name whether a file is the first of its run: it is numbered from 0."""
    return file.name.split(".")[0].rsplit("-", 1)[-1] == "0"


def describe_difference(then: Event | None, now: Event | None) -> str:
    """Return one line about two events that should be equal."""
    if then is None or now is None:
        lone, where = (now, "only today") if then is None else (then, "only in the recording")
        assert lone is not None
        return f"{lone.kind} at t_ns {lone.t_ns}: {where}"
    if type(then) is not type(now):
        return f"{then.kind} then, {now.kind} today, at t_ns {now.t_ns}"
    before: dict[str, Any] = then.model_dump()
    after: dict[str, Any] = now.model_dump()
    changes = [
        f"{name} {before[name]} -> {after[name]}" for name in before if before[name] != after[name]
    ]
    return f"{now.kind} at t_ns {now.t_ns}: {', '.join(changes)}"
