"""Each kind of recorded thing as JSON and back."""

import binascii
from collections.abc import Callable, Mapping
from typing import Any, Final

import orjson

from gaitway.events import EVENT_TYPES, Event
from gaitway.recording.items import Body, Dropped, LinkChange, RecordedChunk, Resumed
from gaitway.recording.sample_encoding import decode_samples, encode_samples
from gaitway.samples import Chunk, DeviceStatus, Fault, Gap, SampleBatch
from gaitway.timebase import WallAnchor


def encode(body: Body) -> bytes:
    """Return the JSON of a body.

    Raises:
        TypeError: A value has no JSON form.
    """
    match body:
        case SampleBatch():
            return encode_samples(body)
        case RecordedChunk(chunk, direction):
            text = _base64(chunk.data)
            return orjson.dumps({"t_ns": chunk.t_ns, "direction": direction, "data_base64": text})
        case Resumed():
            fields = {
                name: getattr(body, name) for name in ("t_ns", "saved_t_ns", "aligner", "ended")
            }
            return orjson.dumps(fields | {"estimator_base64": _base64(body.estimator)})
        case Event():
            return body.model_dump_json(exclude_none=True).encode()
        case DeviceStatus():
            return orjson.dumps({"t_ns": body.t_ns, "fields": dict(body.fields)})
        case _:
            return orjson.dumps(body)


def _base64(data: bytes) -> str:
    return binascii.b2a_base64(data, newline=False).decode("ascii")


def leaf_of(body: Body) -> str:
    """Return the last part of the topic of a body."""
    return body.kind if isinstance(body, Event) else LEAVES[type(body)]


def time_of(body: Body) -> int:
    """Return when a body belongs in the recording, host monotonic nanoseconds."""
    match body:
        case SampleBatch():
            return int(body.t_ns[-1])
        case RecordedChunk(chunk):
            return chunk.t_ns
        case _:
            return body.t_ns


def decode(leaf: str, data: bytes) -> Body:
    """Return the body of a message.

    Args:
        leaf: Last part of its topic.
        data: Its JSON.

    Raises:
        ValueError: It is no JSON, or its values can't be.
        LookupError: The leaf is unknown, or a field is missing.
        TypeError: A field too many, or of another type.
    """
    return DECODERS[leaf](data)


def _decode_raw(data: bytes) -> RecordedChunk:
    fields = orjson.loads(data)
    payload = binascii.a2b_base64(fields["data_base64"], strict_mode=True)
    return RecordedChunk(Chunk(fields["t_ns"], payload), fields["direction"])


def _decode_resumed(data: bytes) -> Resumed:
    fields = orjson.loads(data)
    state = binascii.a2b_base64(fields.pop("estimator_base64"), strict_mode=True)
    return Resumed(**fields, estimator=state)


def _decode_fields(kind: Callable[..., Body]) -> Callable[[bytes], Body]:
    return lambda data: kind(**orjson.loads(data))


def _decode_event(kind: type[Event]) -> Callable[[bytes], Event]:
    required = [name for name, field in kind.model_fields.items() if field.is_required()]

    def decode_event(data: bytes) -> Event:
        # What was null was left out.
        return kind.model_validate(dict.fromkeys(required) | orjson.loads(data))

    return decode_event


LEAVES: Final[Mapping[type[Any], str]] = {
    RecordedChunk: "raw",
    SampleBatch: "samples",
    Gap: "gap",
    Fault: "fault",
    LinkChange: "link",
    Resumed: "resumed",
    DeviceStatus: "device",
    Dropped: "dropped",
    WallAnchor: "anchor",
}

DECODERS: Final[Mapping[str, Callable[[bytes], Body]]] = {
    "raw": _decode_raw,
    "samples": decode_samples,
    "gap": _decode_fields(Gap),
    "fault": _decode_fields(Fault),
    "link": _decode_fields(LinkChange),
    "resumed": _decode_resumed,
    "device": _decode_fields(DeviceStatus),
    "dropped": _decode_fields(Dropped),
    "anchor": _decode_fields(WallAnchor),
    **{kind.kind: _decode_event(kind) for kind in EVENT_TYPES},
}
