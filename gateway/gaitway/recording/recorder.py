"""The recorder: methods that never block in front, one thread that writes behind."""

import logging
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from gaitway.events import Event
from gaitway.recording.items import Body, Direction, LinkChange, RecordedChunk, Resumed
from gaitway.recording.lane import MAX_BYTES, MAX_ITEMS, Lane
from gaitway.recording.params import RecordingParams
from gaitway.recording.sink import Sink, State
from gaitway.samples import Chunk, DeviceStatus, Fault, Gap, SampleBatch
from gaitway.timebase import Clock

logger = logging.getLogger(__name__)

PASS_S: Final = 0.2
"""How often the thread wakes; fewer wake-ups cost less, and 0.2 s fits four times in a sync."""


class Recorder:
    """Records everything that comes in and everything that is made of it.

    The ``record_*`` methods only append to a bounded queue. A disk that fails pauses recording and
    is tried again for ever; what does not fit the queue meanwhile is counted.

    Args:
        params: Where to, and what to keep.
        clock: Stamps files; decides on syncs and rotation.
        devices: Ids of the devices, so that every file defines their topics at its start.
        header: What the gateway is, names to text; goes into every file.
        run: Identity of this run of the gateway, up to 32 lower-case letters and digits; part of
            the file names.
        max_items: Bound of the queue.
        max_bytes: Bound of the queue.
    """

    def __init__(
        self,
        params: RecordingParams,
        clock: Clock,
        devices: Sequence[str],
        header: Mapping[str, str],
        run: str,
        *,
        max_items: int = MAX_ITEMS,
        max_bytes: int = MAX_BYTES,
    ) -> None:
        self._clock = clock
        self._lane = Lane(max_items, max_bytes)
        self._sink = Sink(
            params,
            clock,
            run=run,
            header=header,
            devices=devices,
            lose=self._lane.lose,
        )
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._work, name="gaitway-recorder", daemon=True)

    @property
    def state(self) -> State:
        """on; paused while the disk refuses; off before the start and after the end."""
        return self._sink.status[0]

    @property
    def state_reason(self) -> str:
        """Why it is not on, and what to do about it."""
        return self._sink.status[1]

    @property
    def healthy(self) -> bool:
        """Whether the writer thread lives; a disk that hangs is no reason to end the gateway."""
        return self._thread.is_alive()

    @property
    def dropped(self) -> int:
        """Items that were not recorded since the start."""
        return sum(self._lane.dropped.values())

    @property
    def dropped_by_topic(self) -> dict[str, int]:
        """Items that were not recorded since the start, by topic."""
        return self._lane.dropped

    @property
    def path(self) -> Path | None:
        """The file being written, if there is one."""
        return self._sink.path

    def start(self) -> None:
        """Begin: open a file, and make whole files of what an earlier run left behind."""
        self._thread.start()

    def close(self, timeout_s: float) -> bool:
        """Write what waits and end the file; blocks.

        Args:
            timeout_s: How long to wait for a disk that hangs.

        Returns:
            Whether the recording was ended in time.
        """
        self._closing.set()
        self._thread.join(timeout_s)
        return not self._thread.is_alive()

    def record_chunk(self, device: str, t_ns: int, data: bytes, direction: Direction) -> None:
        """Record bytes that were read from a link or sent to it."""
        self._put(device, RecordedChunk(Chunk(t_ns, data), direction))

    def record_samples(self, device: str, batch: SampleBatch) -> None:
        """Record samples, axes as the device reports them (frame b)."""
        if len(batch):
            self._put(device, batch)

    def record_gap(self, device: str, gap: Gap) -> None:
        """Record that samples are missing."""
        self._put(device, gap)

    def record_fault(self, device: str, fault: Fault) -> None:
        """Record that bytes or samples could not be used."""
        self._put(device, fault)

    def record_event(self, device: str, event: Event) -> None:
        """Record what an estimator or the gateway said."""
        self._put(device, event)

    def record_device_status(self, device: str, status: DeviceStatus) -> None:
        """Record what a device said about itself."""
        self._put(device, status)

    def record_link(self, device: str, t_ns: int, state: str, reason: str) -> None:
        """Record that a link was opened, lost or came into another state."""
        self._put(device, LinkChange(t_ns, state, reason))

    def record_resumed(self, device: str, resumed: Resumed) -> None:
        """Record from which state of an earlier run a device goes on."""
        self._put(device, resumed)

    def _put(self, device: str, body: Body) -> None:
        self._lane.put(device, body, self._clock.now_ns())

    def _work(self) -> None:
        while not self._closing.wait(PASS_S):
            self._pass()
        try:
            self._sink.finish(self._lane.close())
        except Exception:
            logger.exception("the recording could not be ended")

    def _pass(self) -> None:
        try:
            if self._sink.ready():
                self._sink.write(self._lane.take())
        # A fault in here or in a library must cost what was at hand and not the thread.
        except Exception as exc:
            logger.exception("recording failed")
            self._sink.fail(exc)
