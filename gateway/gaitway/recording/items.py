"""What a recording holds, in gaitway's own types; the same for writing and reading."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import orjson

from gaitway.events import Event
from gaitway.samples import Chunk, DeviceStatus, Fault, Gap, SampleBatch
from gaitway.timebase import WallAnchor

Direction = Literal["rx", "tx"]
"""rx: from the device; tx: what the gateway sent to it."""


@dataclass(frozen=True, slots=True)
class RecordedChunk:
    """Bytes that went over a link.

    Attributes:
        chunk: The bytes and when they were read or sent.
        direction: Which way they went.
    """

    chunk: Chunk
    direction: Direction


@dataclass(frozen=True, slots=True)
class LinkChange:
    """A link came into another state; replay starts the codec anew where a link opened.

    Attributes:
        t_ns: When, host monotonic.
        state: Name of the state it came into.
        reason: Why, one line.
    """

    t_ns: int
    state: str
    reason: str


@dataclass(frozen=True, slots=True)
class Resumed:
    """A device goes on from where an earlier run of the gateway left it, or ends what that began.

    Attributes:
        t_ns: When the state was taken over, host monotonic.
        saved_t_ns: When it was saved, same clock.
        aligner: What ``Aligner.save`` returned.
        estimator: What the estimator's ``save`` returned.
        ended: Why it can't go on and only says what was still held back; empty where it goes on.
    """

    t_ns: int
    saved_t_ns: int
    aligner: Mapping[str, Any]
    estimator: bytes
    ended: str = ""


@dataclass(frozen=True, slots=True)
class Dropped:
    """Items that were meant to be recorded and are not.

    Attributes:
        t_ns: When the first of them was dropped, host monotonic.
        until_t_ns: When the last of them was dropped.
        reason: Why, one line.
        counts: How many, by topic.
    """

    t_ns: int
    until_t_ns: int
    reason: str
    counts: dict[str, int]


@dataclass(frozen=True, slots=True)
class Header:
    """What the gateway was when it wrote the file.

    Attributes:
        entries: Effective configuration, versions, host, run id: names to text.
    """

    entries: Mapping[str, str]

    @property
    def config(self) -> dict[str, Any]:
        """The effective configuration at the time; empty where it was not recorded."""
        try:
            config = orjson.loads(self.entries.get("config", "{}"))
        except orjson.JSONDecodeError:
            return {}
        return config if isinstance(config, dict) else {}


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A part of a file that gives nothing: the cut-off end, a damaged chunk, a strange message.

    Attributes:
        offset: Where it begins in the file, or a message in its unpacked chunk, bytes.
        n_bytes: How long it is.
        reason: One line for a person.
    """

    offset: int
    n_bytes: int
    reason: str


Body = (
    RecordedChunk | SampleBatch | Gap | Fault | DeviceStatus | LinkChange | Resumed | Event
    | Dropped | WallAnchor
)  # fmt: skip
"""What is written as a message."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedItem:
    """One thing read from a recording.

    Attributes:
        device: Whose it is; empty for what concerns the gateway or the file.
        body: What it is; tell the kinds apart by their type.
    """

    device: str
    body: Body | Header | Unreadable
