"""Where recorded items go: into a file, the next file, or nowhere while the disk refuses."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, Literal

from gaitway.recording.encoding import encode, leaf_of, time_of
from gaitway.recording.items import Body, Dropped
from gaitway.recording.lane import LaneItem
from gaitway.recording.merging import merge_samples
from gaitway.recording.params import RecordingParams
from gaitway.recording.recording_file import RecordingFile
from gaitway.recording.recover import recover
from gaitway.recording.retention import BYTES_PER_MB, lacks_reserve, make_room
from gaitway.recording.schemas import SCHEMAS, topic, topics
from gaitway.timebase import NS_PER_S, Clock, WallAnchor

logger = logging.getLogger(__name__)

State = Literal["on", "paused", "off"]

SYNC_S: Final = 0.75
"""With passes 0.2 s apart, an item is on the disk 0.8 s after it came, the sync itself apart."""
RETRY_S: Final = 5.0
START_MARGIN_BYTES: Final = 10_000_000
"""A file is begun only with this much above the reserve, so that it isn't ended at once."""
STEP_S: Final = 0.5
"""A wall clock further off than this ends the file, so that no log_time is."""


@dataclass(frozen=True, slots=True)
class _Encoded:
    name: str
    t_ns: int
    payload: bytes


class Sink:
    """One recording of many files; for one thread, which may block here.

    Items written since the last sync are kept and written again into the next file when a disk
    fails, so a disk that comes back costs nothing but time.

    Args:
        params: Where to, and what to keep.
        clock: Says when to sync and to rotate.
        run: Identity of this run of the gateway, part of the file names.
        header: What the gateway is; goes into every file.
        devices: Ids of the devices.
        lose: Called with a topic and a count for what can't be written.
    """

    def __init__(
        self,
        params: RecordingParams,
        clock: Clock,
        *,
        run: str,
        header: Mapping[str, str],
        devices: Sequence[str],
        lose: Callable[[str, int], None],
    ) -> None:
        self._params = params
        self._clock = clock
        self._run = run
        self._header = header
        self._lose = lose
        self._names = topics(tuple(devices))
        self._file: RecordingFile | None = None
        self._number = 0
        self._opened_ns = 0
        self._checked_ns = 0
        self._retry_ns = 0
        self._unsynced: list[_Encoded] = []
        self._refused: set[str] = set()
        self._leftovers = True
        self._status: tuple[State, str] = ("off", "not begun yet")

    @property
    def status(self) -> tuple[State, str]:
        """State and the reason for it."""
        return self._status

    @property
    def path(self) -> Path | None:
        """The file being written."""
        file = self._file
        return file.path if file else None

    def ready(self) -> bool:
        """Return whether items can be written, opening a file if one is due."""
        if self._file is None and self._clock.now_ns() >= self._retry_ns:
            try:
                self._open()
            except OSError as exc:
                self._abandon(exc)
        return self._file is not None

    def write(self, items: Sequence[LaneItem]) -> None:
        """Write items; sync, and go over to the next file, when it is time. Needs ``ready``."""
        assert self._file is not None
        try:
            encoded = [self._encode(item) for item in merge_samples(items)]
            self._unsynced += encoded
            for message in encoded:
                self._file.write(message.name, message.t_ns, message.payload)
            if self._clock.now_ns() - self._checked_ns >= SYNC_S * NS_PER_S:
                self._checked_ns = self._clock.now_ns()
                self._sync(self._file)
                self._keep_bounds(self._file)
        except OSError as exc:
            self._abandon(exc)

    def fail(self, exc: Exception) -> None:
        """Give up what was not synced, which may be the cause, and try again in a while."""
        self._lose_unsynced()
        self._abandon(exc)

    def finish(self, items: Sequence[LaneItem]) -> None:
        """Write the last items and end the file; count what could not be written."""
        self._retry_ns = 0
        if (items or self._unsynced or self._file) and self.ready():
            self.write(items)
            items = ()
        try:
            if self._file is not None:
                self._sync(self._file)
                self._finish(self._file)
        except OSError as exc:
            self._abandon(exc)
        self._lose_unsynced()
        for item in items:
            self._lose(topic(item.device, leaf_of(item.body)), 1)
        self._status = ("off", "stopped")

    def _open(self) -> None:
        self._params.directory.mkdir(parents=True, exist_ok=True)
        make_room(self._params, self._clock.wall_ns(), margin_bytes=START_MARGIN_BYTES)
        if lacks_reserve(self._params, margin_bytes=START_MARGIN_BYTES):
            raise OSError(_no_reserve(self._params))
        anchor = WallAnchor.take(self._clock)
        stamp = datetime.fromtimestamp(anchor.wall_ns // NS_PER_S, UTC)
        name = f"{stamp:%Y%m%dT%H%M%SZ}-{self._run}-{self._number}.mcap"
        path = self._params.directory / name
        self._file = RecordingFile(path, anchor, self._header, self._names)
        self._number += 1
        self._opened_ns = self._checked_ns = anchor.t_ns
        for encoded in self._unsynced:
            self._file.write(encoded.name, encoded.t_ns, encoded.payload)
        if self._status[0] != "on":
            logger.info("recording to %s", self._file.path)
        self._status = ("on", "")
        if self._leftovers:
            self._recover()

    def _encode(self, item: LaneItem) -> _Encoded:
        try:
            return _encode(item.device, item.body)
        # What a plugin put into an event, or a codec into a status, must cost that item alone.
        except Exception as exc:  # noqa: BLE001
            name = topic(item.device, leaf_of(item.body))
            self._lose(name, 1)
            level = logging.DEBUG if name in self._refused else logging.WARNING
            self._refused.add(name)
            logger.log(level, "a message of %s can't be recorded: %s", name, exc)
            now_ns = self._clock.now_ns()
            return _encode("", Dropped(now_ns, now_ns, f"not recordable: {exc}", {name: 1}))

    def _sync(self, file: RecordingFile) -> None:
        if self._unsynced:
            file.sync()
            self._unsynced.clear()

    def _keep_bounds(self, file: RecordingFile) -> None:
        """End the file when it is long enough, the wall clock was set, or the disk fills up."""
        if lacks_reserve(self._params):
            make_room(self._params, self._clock.wall_ns())
            if lacks_reserve(self._params):
                self._finish(file)
                self._pause(_no_reserve(self._params))
                return
        age_ns = self._clock.now_ns() - self._opened_ns
        too_long = file.holds_messages and age_ns >= self._params.max_file_s * NS_PER_S
        too_big = file.size_bytes >= self._params.max_file_mb * BYTES_PER_MB
        stepped_by_s = file.anchor.stepped_by_s(self._clock)
        if abs(stepped_by_s) > STEP_S:
            logger.info("the wall clock moved by %.3f s: a new recording begins", stepped_by_s)
        elif not (too_long or too_big):
            return
        self._finish(file)
        self._open()

    def _finish(self, file: RecordingFile) -> None:
        file.finish()
        self._file = None

    def _abandon(self, exc: Exception) -> None:
        """Leave the file as it was at the last sync, and try again in a while."""
        if self._file is not None:
            self._file.abandon()
            self._leftovers = True
        self._pause(str(exc))

    def _lose_unsynced(self) -> None:
        for encoded in self._unsynced:
            self._lose(encoded.name, 1)
        self._unsynced.clear()

    def _pause(self, reason: str) -> None:
        self._file = None
        self._retry_ns = self._clock.now_ns() + round(RETRY_S * NS_PER_S)
        level = logging.DEBUG if self._status[0] == "paused" else logging.WARNING
        self._status = ("paused", f"{reason} (tried again every {RETRY_S:g} s)")
        logger.log(level, "recording paused: %s", self._status[1])

    def _recover(self) -> None:
        self._leftovers = False
        for recovered in recover(self._params.directory, skip=self.path):
            logger.warning("%s", recovered)


def _no_reserve(params: RecordingParams) -> str:
    return (
        f"less than min_free_gb = {params.min_free_gb:g} is free on the disk of "
        f"{params.directory} and no recording is left to delete: make room"
    )


def _encode(device: str, body: Body) -> _Encoded:
    leaf = leaf_of(body)
    if leaf not in SCHEMAS:
        raise LookupError(f"unknown kind of event {leaf!r}")
    return _Encoded(topic(device, leaf), time_of(body), encode(body))
