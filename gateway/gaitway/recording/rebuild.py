"""A valid MCAP file from the good records of a damaged one."""

import zlib
from struct import Struct
from typing import BinaryIO, Final

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.writer import MCAP0_MAGIC

from gaitway.recording.items import Unreadable
from gaitway.recording.scan import HEAD, RawMessage, RawRecord, open_chunk, parse, split_chunk

FOOTER_START: Final = Struct("<BQQQ")
"""What of the footer its own checksum covers: opcode, length, the two offsets."""
FOOTER_BYTES: Final = 20


class Rebuild:
    """Takes over good chunks, still compressed, and makes all indexes and the summary anew.

    Args:
        out: Where to; at its start.
    """

    def __init__(self, out: BinaryIO) -> None:
        self._out = out
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = {}
        out.write(MCAP0_MAGIC)

    @property
    def messages(self) -> int:
        """Messages saved so far."""
        return sum(self._counts.values())

    def add(self, record: RawRecord) -> Unreadable | None:
        """Take over a record; return what is lost if it is no good."""
        match record.opcode:
            case Opcode.HEADER:
                self._copy(record)
            case Opcode.CHUNK:
                return self._add_chunk(record)
            case Opcode.METADATA:
                metadata = parse(record)
                if not isinstance(metadata, Metadata):
                    return Unreadable(record.offset, record.size, "damaged metadata")
                offset = self._copy(record)
                self._metadata.append(MetadataIndex(offset, record.size, metadata.name))
        return None

    def finish(self) -> None:
        """Write the summary and the end."""
        self._put(DataEnd(data_section_crc=0))
        start = self._out.tell()
        summary = _as_bytes(
            *self._schemas.values(),
            *self._channels.values(),
            self._statistics(),
            *self._chunks,
            *self._metadata,
        )
        self._out.write(summary)
        crc = zlib.crc32(
            FOOTER_START.pack(Opcode.FOOTER, FOOTER_BYTES, start, 0), zlib.crc32(summary)
        )
        self._put(Footer(summary_start=start, summary_offset_start=0, summary_crc=crc))
        self._out.write(MCAP0_MAGIC)

    def _add_chunk(self, record: RawRecord) -> Unreadable | None:
        opened = open_chunk(record)
        if isinstance(opened, Unreadable):
            return opened
        chunk, content = opened
        indexes: dict[int, MessageIndex] = {}
        for parsed in split_chunk(content):
            match parsed:
                case RawMessage() if parsed.channel in self._channels:
                    index = indexes.setdefault(parsed.channel, MessageIndex(parsed.channel, []))
                    index.records.append((parsed.log_time_ns, parsed.offset))
                case RawMessage() | Unreadable():
                    reason = "a chunk without the definitions it needs"
                    return Unreadable(record.offset, record.size, reason)
                case Channel():
                    self._channels[parsed.id] = parsed
                case Schema():
                    self._schemas[parsed.id] = parsed
        self._put_chunk(chunk, content, indexes)
        return None

    def _put_chunk(self, chunk: Chunk, content: bytes, indexes: dict[int, MessageIndex]) -> None:
        """Write a chunk whose content was right; what its checksum does not cover is made anew."""
        times_ns = [time_ns for index in indexes.values() for time_ns, _ in index.records]
        chunk.message_start_time = min(times_ns, default=0)
        chunk.message_end_time = max(times_ns, default=0)
        chunk.uncompressed_size = len(content)
        chunk.uncompressed_crc = zlib.crc32(content)
        start = self._put(chunk)
        end = self._out.tell()
        offsets = {channel_id: self._put(index) for channel_id, index in indexes.items()}
        self._chunks.append(
            ChunkIndex(
                chunk_start_offset=start,
                chunk_length=end - start,
                message_start_time=chunk.message_start_time,
                message_end_time=chunk.message_end_time,
                message_index_offsets=offsets,
                message_index_length=self._out.tell() - end,
                compression=chunk.compression,
                compressed_size=len(chunk.data),
                uncompressed_size=chunk.uncompressed_size,
            )
        )
        for channel_id, index in indexes.items():
            self._counts[channel_id] = self._counts.get(channel_id, 0) + len(index.records)

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=self.messages,
            metadata_count=len(self._metadata),
            message_start_time=min((chunk.message_start_time for chunk in self._chunks), default=0),
            message_end_time=max((chunk.message_end_time for chunk in self._chunks), default=0),
            schema_count=len(self._schemas),
        )

    def _copy(self, record: RawRecord) -> int:
        offset = self._out.tell()
        self._out.write(HEAD.pack(record.opcode, len(record.content)))
        self._out.write(record.content)
        return offset

    def _put(self, record: McapRecord) -> int:
        offset = self._out.tell()
        self._out.write(_as_bytes(record))
        return offset


def _as_bytes(*records: McapRecord) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
