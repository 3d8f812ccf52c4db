"""The records of an MCAP file, as far as they are whole.

The mcap package's own readers either refuse a file without its index or raise whatever the cut
happened to hit; this one says where the file stops making sense, and why.
"""

import io
import os
from collections.abc import Iterator
from struct import Struct
from typing import BinaryIO, Final, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata, Schema
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

from gaitway.recording.items import Unreadable

HEAD: Final = Struct("<BQ")
MESSAGE: Final = Struct("<HIQQ")
MESSAGE_OPCODE: Final = int(Opcode.MESSAGE)
OPCODES: Final = frozenset(int(opcode) for opcode in Opcode)
FIRST_PRIVATE_OPCODE: Final = 0x80


class RawRecord(NamedTuple):
    """One record as it stands in a file or in a chunk.

    Attributes:
        opcode: What it is.
        offset: Where it begins, bytes.
        content: What follows opcode and length.
    """

    opcode: int
    offset: int
    content: bytes

    @property
    def size(self) -> int:
        """How long it is with opcode and length, bytes."""
        return HEAD.size + len(self.content)


class RawMessage(NamedTuple):
    """A message within a chunk.

    Attributes:
        offset: Where its record begins in the chunk, bytes.
        channel: Id of its channel.
        log_time_ns: Its log_time, nanoseconds since 1970.
        content: The record's content; the payload follows ``MESSAGE``.
    """

    offset: int
    channel: int
    log_time_ns: int
    content: bytes

    @property
    def payload(self) -> bytes:
        """What was recorded."""
        return self.content[MESSAGE.size :]


Parsed = RawRecord | RawMessage | Channel | Schema | Metadata | Unreadable


def scan(stream: BinaryIO) -> Iterator[RawRecord | Unreadable]:
    """Yield the records of a file from its start, up to its footer or to where it is cut off.

    A last ``Unreadable`` says what is left over; a file that just ends after a whole record, as one
    still being written does, gives none.
    """
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    offset = len(MCAP0_MAGIC)
    if stream.read(offset) != MCAP0_MAGIC:
        yield Unreadable(0, size, "this is no MCAP file: it does not begin like one")
        return
    while offset < size:
        head = stream.read(HEAD.size)
        if len(head) < HEAD.size:
            yield Unreadable(offset, size - offset, "cut off within a record")
            return
        opcode, length = HEAD.unpack(head)
        if opcode not in OPCODES and opcode < FIRST_PRIVATE_OPCODE:
            yield Unreadable(offset, size - offset, f"no record begins with byte {opcode}")
            return
        if length > size - offset - HEAD.size:
            yield Unreadable(offset, size - offset, "cut off within a record")
            return
        yield RawRecord(opcode, offset, stream.read(length))
        if opcode == Opcode.FOOTER:
            return
        offset += HEAD.size + length


def open_chunk(record: RawRecord) -> tuple[Chunk, bytes] | Unreadable:
    """Return a chunk and the records within it, unpacked and checked against their checksum."""
    try:
        chunk = Chunk.read(ReadDataStream(io.BytesIO(record.content)))
        stream, size = get_chunk_data_stream(chunk, validate_crc=True)
        return chunk, stream.read(size)
    # What a damaged chunk makes zstandard, struct and mcap raise has no common base.
    except Exception as exc:  # noqa: BLE001
        return Unreadable(record.offset, record.size, f"damaged chunk: {type(exc).__name__}: {exc}")


def split_chunk(content: bytes) -> Iterator[Parsed]:
    """Yield what the records within an unpacked chunk say."""
    offset = 0
    while offset + HEAD.size <= len(content):
        opcode, length = HEAD.unpack_from(content, offset)
        start, end = offset + HEAD.size, offset + HEAD.size + length
        if opcode == MESSAGE_OPCODE and length >= MESSAGE.size and end <= len(content):
            channel, _, log_time_ns, _ = MESSAGE.unpack_from(content, start)
            yield RawMessage(offset, channel, log_time_ns, content[start:end])
        else:
            yield parse(RawRecord(opcode, offset, content[start:end]))
        offset = end


def parse(record: RawRecord) -> Parsed:
    """Return what a record says if it is a message, a definition or metadata, else itself."""
    if record.opcode == MESSAGE_OPCODE and len(record.content) >= MESSAGE.size:
        channel, _, log_time_ns, _ = MESSAGE.unpack_from(record.content)
        return RawMessage(record.offset, channel, log_time_ns, record.content)
    stream = ReadDataStream(io.BytesIO(record.content))
    try:
        match record.opcode:
            case Opcode.CHANNEL:
                definition: Channel = Channel.read(stream)
                return definition
            case Opcode.SCHEMA:
                schema: Schema = Schema.read(stream)
                return schema
            case Opcode.METADATA:
                metadata: Metadata = Metadata.read(stream)
                return metadata
    # What damaged bytes make struct and mcap raise has no common base.
    except Exception as exc:  # noqa: BLE001
        return Unreadable(record.offset, record.size, f"damaged record: {exc}")
    return record
