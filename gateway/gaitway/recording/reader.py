"""Reading recordings: whole, still being written, or cut off by a power cut."""

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from mcap.opcode import Opcode
from mcap.records import Channel, Metadata

from gaitway.recording.encoding import decode
from gaitway.recording.items import Header, RecordedItem, Unreadable
from gaitway.recording.recording_file import HEADER_NAME
from gaitway.recording.sample_encoding import decode_joined
from gaitway.recording.scan import (
    Parsed,
    RawMessage,
    RawRecord,
    open_chunk,
    parse,
    scan,
    split_chunk,
)
from gaitway.recording.schemas import split_topic
from gaitway.timebase import NS_PER_S, WallAnchor

JOINED_AT_ONCE: Final = 512
"""Messages that become one batch: a longer one saves nothing and takes memory."""


@dataclass(frozen=True, slots=True)
class RecordingInfo:
    """What a recording holds, at a glance.

    Attributes:
        path: The file.
        complete: It was ended properly; false for one being written or cut off.
        unreadable_bytes: How much of it gives nothing.
        header: What the gateway was, configuration included.
        anchor: Bridge to wall-clock time; None where even that is lost.
        devices: Ids of the devices that sent something.
        counts: Messages by topic.
        duration_s: From the first message to the last.
    """

    path: Path
    complete: bool
    unreadable_bytes: int
    header: Header
    anchor: WallAnchor | None
    devices: tuple[str, ...]
    counts: Mapping[str, int]
    duration_s: float


def read(path: Path, leaves: Container[str] | None = None) -> Iterator[RecordedItem]:
    """Yield what a recording holds, in the order it was written.

    Nothing that a file contains raises: what can't be read is an ``Unreadable`` in its place.

    Args:
        path: The file.
        leaves: Last parts of the topics wanted; all where None. The header comes always.

    Raises:
        OSError: The file can't be opened or read.
    """
    names: dict[int, tuple[str, str] | None] = {}
    for record in _records(path):
        match record:
            case RawMessage():
                found = names.get(record.channel)
                if found and (leaves is None or found[1] in leaves):
                    yield _decode(*found, record)
            case Channel():
                names[record.id] = split_topic(record.topic)
            case Metadata() if record.name == HEADER_NAME:
                yield RecordedItem("", Header(record.metadata))
            case Unreadable():
                yield RecordedItem("", record)


def read_joined(path: Path, leaves: Container[str]) -> Iterator[RecordedItem]:
    """Yield as ``read``, samples of one device in a row without a hole as one batch.

    The order of what concerns one device is kept, between devices it is not.

    Args:
        path: The file.
        leaves: Last parts of the topics wanted besides the samples.

    Raises:
        OSError: The file can't be opened or read.
    """
    names: dict[int, tuple[str, str] | None] = {}
    waiting: dict[str, list[RawMessage]] = {}
    for record in _records(path):
        match record:
            case RawMessage():
                device, leaf = names.get(record.channel) or ("", "")
                if leaf == "samples":
                    messages = waiting.setdefault(device, [])
                    messages.append(record)
                    if len(messages) == JOINED_AT_ONCE:
                        yield from _decode_joined(device, waiting.pop(device))
                elif leaf in leaves:
                    yield from _decode_joined(device, waiting.pop(device, []))
                    yield _decode(device, leaf, record)
            case Channel():
                names[record.id] = split_topic(record.topic)
            case Metadata() if record.name == HEADER_NAME:
                yield RecordedItem("", Header(record.metadata))
            case Unreadable():
                yield RecordedItem("", record)
    for device, messages in waiting.items():
        yield from _decode_joined(device, messages)


def _decode_joined(device: str, messages: Sequence[RawMessage]) -> Iterator[RecordedItem]:
    try:
        batches = decode_joined([message.payload for message in messages])
    except (ValueError, LookupError, TypeError):
        for message in messages:  # one of them is damaged: that one alone gives nothing
            yield _decode(device, "samples", message)
        return
    for batch in batches:
        yield RecordedItem(device, batch)


def read_info(path: Path) -> RecordingInfo:
    """Return what a recording holds, without decoding its messages.

    Raises:
        OSError: The file can't be opened or read.
    """
    topics: dict[int, str] = {}
    counts: dict[str, int] = {}
    header = Header({})
    anchor = None
    times_ns: list[int] = []
    unreadable_bytes = 0
    complete = False
    for record in _records(path):
        match record:
            case Unreadable():
                unreadable_bytes += record.n_bytes
            case RawMessage():
                name = topics.get(record.channel, "")
                counts[name] = counts.get(name, 0) + 1
                first, last = times_ns or [record.log_time_ns] * 2
                times_ns = [min(first, record.log_time_ns), max(last, record.log_time_ns)]
            case Channel():
                topics[record.id] = record.topic
            case Metadata() if record.name == HEADER_NAME:
                header = Header(record.metadata)
            case Metadata() if record.name == "anchor":
                anchor = WallAnchor(int(record.metadata["t_ns"]), int(record.metadata["wall_ns"]))
            case RawRecord():
                complete = complete or record.opcode == Opcode.FOOTER
    found = [split_topic(name) for name in counts]
    devices = sorted({parts[0] for parts in found if parts and parts[0]})
    duration_s = (times_ns[1] - times_ns[0]) / NS_PER_S if times_ns else 0.0
    return RecordingInfo(
        path, complete, unreadable_bytes, header, anchor, tuple(devices), counts, duration_s
    )


def _records(path: Path) -> Iterator[Parsed]:
    with path.open("rb") as stream:
        for record in scan(stream):
            if isinstance(record, RawRecord) and record.opcode == Opcode.CHUNK:
                opened = open_chunk(record)
                if isinstance(opened, Unreadable):
                    yield opened
                    continue
                yield from split_chunk(opened[1])
            elif isinstance(record, RawRecord):
                yield parse(record)
            else:
                yield record


def _decode(device: str, leaf: str, message: RawMessage) -> RecordedItem:
    try:
        return RecordedItem(device, decode(leaf, message.payload))
    except (ValueError, LookupError, TypeError) as exc:
        reason = f"message {leaf!r} of another version, or damaged: {exc}"
        return RecordedItem(device, Unreadable(message.offset, len(message.content), reason))
