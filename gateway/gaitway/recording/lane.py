"""The queue between the event loop and the writer thread: bounded, never blocking, counting."""

import threading
from dataclasses import dataclass
from typing import Final

from gaitway.recording.encoding import leaf_of
from gaitway.recording.items import Body, Dropped, RecordedChunk, Resumed
from gaitway.recording.schemas import topic
from gaitway.samples import SampleBatch

MAX_ITEMS: Final = 20_000
"""Over a minute and a half of two 100 Hz devices in batches of 2: longer than an SD card stalls."""
MAX_BYTES: Final = 16_000_000
"""What a 512 MB Pi can spare."""
ITEM_BYTES: Final = 800
"""What the Python objects of one item weigh besides their data."""


@dataclass(frozen=True, slots=True)
class LaneItem:
    """Something to be recorded.

    Attributes:
        device: Whose it is; empty for the gateway's own.
        body: What it is.
    """

    device: str
    body: Body


class Lane:
    """A queue that takes no more when it is full, and says so in the recording.

    Blocking instead would lose bytes in the driver of the serial port, where nobody counts them;
    dropping the oldest would tear out what a reader has already half of. When there is room again,
    a ``Dropped`` goes in ahead of the next item.
    """

    def __init__(self, max_items: int = MAX_ITEMS, max_bytes: int = MAX_BYTES) -> None:
        self._max_items = max_items
        self._max_bytes = max_bytes
        self._lock = threading.Lock()
        self._items: list[LaneItem] = []
        self._bytes = 0
        self._closed = False
        self._dropped: dict[str, int] = {}
        self._untold: Dropped | None = None

    @property
    def dropped(self) -> dict[str, int]:
        """Items dropped since the start, by topic."""
        with self._lock:
            return dict(self._dropped)

    def put(self, device: str, body: Body, t_ns: int) -> bool:
        """Append an item unless there is no room; return whether it was taken.

        Args:
            device: Whose it is.
            body: What it is.
            t_ns: The present time, host monotonic.
        """
        weight = _weight(body)
        with self._lock:
            full = len(self._items) >= self._max_items or self._bytes + weight > self._max_bytes
            if full or self._closed:
                self._count(topic(device, leaf_of(body)), t_ns)
                return False
            if self._untold is not None:
                self._items.append(LaneItem("", self._untold))
                self._untold = None
            self._items.append(LaneItem(device, body))
            self._bytes += weight
            return True

    def take(self) -> list[LaneItem]:
        """Return everything that waits, oldest first, and leave the lane empty."""
        with self._lock:
            items, self._items, self._bytes = self._items, [], 0
            return items

    def close(self) -> list[LaneItem]:
        """Take nothing more; return what waits, with the last word on what was dropped."""
        with self._lock:
            self._closed = True
            items, self._items, self._bytes = self._items, [], 0
            if self._untold is not None:
                items.append(LaneItem("", self._untold))
                self._untold = None
            return items

    def lose(self, name: str, count: int) -> None:
        """Count items of a topic as dropped that were taken and could not be written."""
        with self._lock:
            self._dropped[name] = self._dropped.get(name, 0) + count

    def _count(self, name: str, t_ns: int) -> None:
        self._dropped[name] = self._dropped.get(name, 0) + 1
        if self._untold is None:
            self._untold = Dropped(t_ns, t_ns, "the queue of the recorder was full", {})
        counts = self._untold.counts
        counts[name] = counts.get(name, 0) + 1
        self._untold = Dropped(self._untold.t_ns, t_ns, self._untold.reason, counts)


def _weight(body: Body) -> int:
    match body:
        case RecordedChunk(chunk):
            return ITEM_BYTES + len(chunk.data)
        case Resumed():
            return ITEM_BYTES + len(body.estimator)
        case SampleBatch():
            return ITEM_BYTES + sum(values.nbytes for values in body.channels.values())
        case _:
            return ITEM_BYTES
