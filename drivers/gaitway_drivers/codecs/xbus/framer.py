"""Finding whole messages among bytes.

A message is a preamble byte, bus id, message id, length, data, and a byte that makes the sum of all
but the preamble zero. Nothing is escaped, so the preamble may occur anywhere: only a good sum makes
a message.
"""

from collections import deque
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gaitway_drivers.codecs.xbus.messages import EXTENDED, MASTER, MAX_DATA_BYTES, PREAMBLE

Bytes = NDArray[np.uint8]

SHORT_HEADER_BYTES: Final = 4
LONG_HEADER_BYTES: Final = 6
_ONES: Final = np.ones(LONG_HEADER_BYTES + MAX_DATA_BYTES + 1, np.uint8)
_GOOD_SUM: Final = bytes((PREAMBLE,))
"""Sum of all bytes of a good message: all but the preamble make zero."""
LAST_BUS_ID: Final = 0x1F
MAX_RUN: Final = 128
"""Messages checked at once at most, which bounds what one bad among them costs."""
SHORTEST_STALL_NS: Final = 100_000_000


@dataclass(slots=True)
class MessageRun:
    """Consecutive good messages of the same kind and length, where they lie in the stream.

    Attributes:
        mid: Message id of all of them.
        messages: How many.
        payload_bytes: Length of the data of each.
        data: Bytes of the stream.
        start: Where in it the data of the first begin.
        step: From there to the data of the next.
    """

    mid: int
    messages: int
    payload_bytes: int
    data: bytes
    start: int
    step: int

    @property
    def payloads(self) -> Bytes:
        """Their data, one row a message, shape (messages, payload_bytes), read-only."""
        shape, strides = (self.messages, self.payload_bytes), (self.step, 1)
        return np.ndarray(shape, np.uint8, self.data, self.start, strides)

    def records(self, record: np.dtype[np.void]) -> NDArray[Any]:
        """Return their data as records no longer than the data, shape (messages,), read-only."""
        return np.ndarray((self.messages,), record, self.data, self.start, (self.step,))

    def split(self, at: int) -> tuple["MessageRun", "MessageRun"]:
        """Return the messages before one, and that one with those after it."""
        return (
            replace(self, messages=at),
            replace(self, messages=self.messages - at, start=self.start + at * self.step),
        )


class Framer:
    """Cuts a stream into messages and counts what is none.

    After a bad candidate exactly one byte is skipped, because its length may be what is wrong. A
    false preamble may claim 2 kB, so a candidate still incomplete after ``stall_ns`` is given up as
    soon as there is a good message behind its first byte; while there is none, waiting costs
    nothing. Between calls no more is held than one unfinished message.

    Attributes:
        stall_ns: How long a message may take from its first byte to its last.
        junk_bytes: Bytes that belonged to no message.
        bad_checksums: Candidates that were complete, or could not become so, and were none.
        stalls: Candidates given up because the rest did not come.
    """

    def __init__(self) -> None:
        self.stall_ns = SHORTEST_STALL_NS
        self.junk_bytes = 0
        self.bad_checksums = 0
        self.stalls = 0
        self._pending = b""
        self._fed_bytes = 0
        self._arrivals: deque[tuple[int, int]] = deque()
        self._looked_ns = 0
        self._run = 1

    @property
    def pending_bytes(self) -> int:
        """Bytes of an unfinished message."""
        return len(self._pending)

    def feed(self, t_ns: int, data: bytes) -> list[MessageRun]:
        """Return the messages that are now complete.

        Args:
            t_ns: When the bytes were read.
            data: The next bytes of the stream.
        """
        if not self._pending:
            self._arrivals.clear()
        self._fed_bytes += len(data)
        self._arrivals.append((self._fed_bytes, t_ns))
        self._pending += data
        runs = self._scan()
        if self._pending and self._is_late(t_ns):
            self._looked_ns = t_ns
            runs += self._look_behind()
        return runs

    def finish(self) -> list[MessageRun]:
        """Return what was hidden behind a message that will never be complete."""
        self.stalls += bool(self._pending)
        runs: list[MessageRun] = []
        while self._pending:
            runs += self._rescan()
        return runs

    def _is_late(self, t_ns: int) -> bool:
        """Tell whether the pending message is, and was not looked behind lately."""
        return t_ns - max(self._pending_since_ns(), self._looked_ns) > self.stall_ns

    def _look_behind(self) -> list[MessageRun]:
        """Return the good messages behind the pending one's first byte, if there are any."""
        before = (self._pending, self.junk_bytes, self.bad_checksums)
        runs: list[MessageRun] = []
        while self._pending and not runs:
            runs = self._rescan()
        if runs:
            self.stalls += 1
        else:
            self._pending, self.junk_bytes, self.bad_checksums = before
        return runs

    def _pending_since_ns(self) -> int:
        first = self._fed_bytes - len(self._pending)
        while self._arrivals[0][0] <= first:
            self._arrivals.popleft()
        return self._arrivals[0][1]

    def _rescan(self) -> list[MessageRun]:
        self.junk_bytes += 1
        self._pending = self._pending[1:]
        return self._scan()

    def _scan(self) -> list[MessageRun]:
        data, at, runs = self._pending, 0, []
        while at < len(data):
            start = data.find(PREAMBLE, at)
            if start < 0:
                start = len(data)
            self.junk_bytes += start - at
            at = start
            size = _message_bytes(data, at)
            if at + size > len(data):
                break
            run = _good_run(data, at, size, self._run) if size else None
            # Twice as far ahead after each success, so that failures cost in proportion.
            self._run = min(2 * self._run, MAX_RUN) if run is not None else 1
            if run is None:
                self.bad_checksums += 1
                self.junk_bytes += 1
                at += 1
            else:
                runs.append(run)
                at += run.messages * size
        self._pending = data[at:]
        return runs


def _message_bytes(data: bytes, at: int) -> int:
    """Return the length of the message that begins at ``at``, or 0 when none can.

    While the header is incomplete it is a lower bound, and more than there is.
    """
    available = len(data) - at
    if available < 2:
        return SHORT_HEADER_BYTES + 1
    if LAST_BUS_ID < data[at + 1] != MASTER:
        return 0
    if available < SHORT_HEADER_BYTES:
        return SHORT_HEADER_BYTES + 1
    length = data[at + 3]
    if length != EXTENDED:
        return SHORT_HEADER_BYTES + length + 1
    if available < LONG_HEADER_BYTES:
        return LONG_HEADER_BYTES + EXTENDED + 1
    length = int.from_bytes(data[at + 4 : at + 6], "big")
    return LONG_HEADER_BYTES + length + 1 if EXTENDED <= length <= MAX_DATA_BYTES else 0


def _good_run(data: bytes, at: int, size: int, most: int) -> MessageRun | None:
    """Return the messages of this size, and with this header, that follow each other from ``at``.

    At most ``most`` of them; None if already the first has a bad sum.
    """
    header_bytes = LONG_HEADER_BYTES if data[at + 3] == EXTENDED else SHORT_HEADER_BYTES
    most = min(most, (len(data) - at) // size)
    rows = np.frombuffer(data, np.uint8, most * size, at).reshape(most, size)
    if most > 1:
        headers, header = rows[:, :header_bytes].tobytes(), data[at : at + header_bytes]
        if headers != header * most:
            starts = range(0, len(headers), header_bytes)
            most = next(n for n, i in enumerate(starts) if not headers.startswith(header, i))
            rows = rows[:most]
    sums = rows.dot(_ONES[:size]).tobytes()
    good = most - len(sums.lstrip(_GOOD_SUM))
    if not good:
        return None
    payload_bytes = size - header_bytes - 1
    return MessageRun(data[at + 2], good, payload_bytes, data, at + header_bytes, size)
