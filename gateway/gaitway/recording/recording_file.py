"""One MCAP file while it is being written.

It is called ``….mcap.active`` until it is whole. The definitions of all topics and the anchor make
up a first chunk of their own, on the disk before anything else, so that a cut-off file can be read.
"""

import contextlib
import errno
import fcntl
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from mcap.writer import CompressionType, Writer

from gaitway.recording.encoding import encode
from gaitway.recording.schemas import SCHEMAS, split_topic, topic
from gaitway.timebase import WallAnchor

ACTIVE_SUFFIX: Final = ".active"
HEADER_NAME: Final = "gaitway"
"""Name of the metadata record that holds what the gateway was."""
CHUNK_BYTES: Final = 128 * 1024
"""A chunk ends here if the sync does not end it before: keeps each compression short."""
MAX_LOG_TIME_NS: Final = 2**63 - 1


class RecordingFile:
    """An open file. Every method may raise ``OSError``; then ``abandon`` it.

    Args:
        path: Its final name, without ``.active``.
        anchor: Bridge from monotonic time to ``log_time``.
        header: What the gateway is.
        names: Every topic, in the order they are numbered; a topic that is written and is not
            among them is added, to be known in the next file too.
    """

    def __init__(
        self, path: Path, anchor: WallAnchor, header: Mapping[str, str], names: list[str]
    ) -> None:
        self.final_path = path
        self.path = path.with_name(path.name + ACTIVE_SUFFIX)
        self.anchor = anchor
        self._names = names
        self._channels: dict[str, int] = {}
        self._sequences: dict[str, int] = {}
        self._stream = self.path.open("xb")
        self._begun_bytes = self._synced_bytes = 0
        try:
            # Tells another process that this file is no leftover; not every file system can.
            with contextlib.suppress(OSError):
                fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._writer = Writer(
                self._stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD
            )
            self._begin(header)
        except BaseException:
            self.abandon()
            raise

    @property
    def size_bytes(self) -> int:
        """How long the file is, up to the last sync."""
        return self._synced_bytes

    @property
    def holds_messages(self) -> bool:
        """Whether more than the definitions and the anchor is on the disk."""
        return self._synced_bytes > self._begun_bytes

    def write(self, name: str, t_ns: int, payload: bytes) -> None:
        """Add a message.

        Args:
            name: Topic.
            t_ns: When it belongs, host monotonic.
            payload: Its JSON.
        """
        channel = self._channels.get(name)
        if channel is None:
            self._names.append(name)
            channel = self._register(name)
        sequence = self._sequences.get(name, 0)
        self._sequences[name] = sequence + 1
        log_time_ns = min(max(self.anchor.to_wall_ns(t_ns), 0), MAX_LOG_TIME_NS)
        self._writer.add_message(
            channel, log_time_ns, payload, publish_time=log_time_ns, sequence=sequence % 2**32
        )

    def sync(self) -> None:
        """Bring everything written so far onto the disk, past every cache."""
        self._writer.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
        os.fsync(self._stream.fileno())
        self._synced_bytes = self._stream.tell()

    def finish(self) -> None:
        """Write the index, and give the file its final name."""
        self._writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
        self._stream.flush()
        os.fsync(self._stream.fileno())
        self._stream.close()
        self.path.rename(self.final_path)
        sync_directory(self.path.parent)

    def abandon(self) -> None:
        """Close the file as it was at the last sync, for ``recover``; remove it if it is empty."""
        if self._stream.closed:
            return
        descriptor = os.dup(self._stream.fileno())
        try:
            with contextlib.suppress(OSError):
                self._stream.close()
            with contextlib.suppress(OSError):
                os.ftruncate(descriptor, self._synced_bytes)
                os.fsync(descriptor)
        finally:
            os.close(descriptor)
        if not self.holds_messages:
            with contextlib.suppress(OSError):
                self.path.unlink()

    def _begin(self, header: Mapping[str, str]) -> None:
        self._writer.start(profile="gaitway")
        self._writer.add_metadata(HEADER_NAME, dict(header))
        anchor = {"t_ns": str(self.anchor.t_ns), "wall_ns": str(self.anchor.wall_ns)}
        self._writer.add_metadata("anchor", anchor)
        self._schemas = {
            leaf: self._writer.register_schema(schema_name, "jsonschema", text)
            for leaf, (schema_name, text) in SCHEMAS.items()
        }
        for name in self._names:
            self._register(name)
        self.write(topic("", "anchor"), self.anchor.t_ns, encode(self.anchor))
        self.sync()
        self._begun_bytes = self._synced_bytes
        sync_directory(self.path.parent)

    def _register(self, name: str) -> int:
        parts = split_topic(name)
        assert parts is not None, name
        self._channels[name] = self._writer.register_channel(name, "json", self._schemas[parts[1]])
        return self._channels[name]


def sync_directory(directory: Path) -> None:
    """Bring the names in a directory onto the disk.

    Raises:
        OSError: The disk refused.
    """
    descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    except OSError as exc:
        if exc.errno != errno.EINVAL:  # some network file systems know no such thing
            raise
    finally:
        os.close(descriptor)
