"""The JSON Schema of every topic, within the subset that MCAP viewers understand.

Viewers such as Foxglove and Lichtblick read a schema property by property and refuse one without a
single ``type``. So no ``anyOf`` and no ``$ref``: where an event's number may be ``null``, the
recording leaves it out instead.
"""

from typing import Any, Final

import orjson

from gaitway.events import EVENT_TYPES, Event
from gaitway.recording.sample_encoding import CHANNEL_OF_COLUMN
from gaitway.samples import CHANNELS

Schema = dict[str, Any]

T_NS: Final[Schema] = {
    "type": "integer",
    "description": "Nanoseconds of the gateway's monotonic clock.",
}
TEXT: Final[Schema] = {"type": "string"}
COUNT: Final[Schema] = {"type": "integer", "minimum": 0}


def _table(
    title: str, description: str, properties: Schema, *, optional: tuple[str, ...]
) -> Schema:
    return {
        "title": title,
        "description": description,
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if name not in optional],
        "additionalProperties": False,
    }


def _counts(description: str) -> Schema:
    return {
        "type": "object",
        "description": description,
        "properties": {},
        "additionalProperties": {"type": "integer"},
    }


def _samples_schema() -> Schema:
    numbers = {"type": "array", "items": {"type": "number"}}
    columns: Schema = {
        column: numbers | {"description": f"Column {index} of channel {name}, axes of the IMU."}
        for column, (name, index) in CHANNEL_OF_COLUMN.items()
    }
    fixed: Schema = {
        "t_ns": {"type": "array", "items": T_NS, "description": "Time of each sample."},
        "period_s": {"type": "number", "description": "Sample period."},
        "sequence": {
            "type": "integer",
            "description": "Number of the first sample on the device's grid; gaps are counted.",
        },
        "float32": {
            "type": "array",
            "items": TEXT,
            "description": "Channels whose columns must be rounded to float32 after parsing; "
            f"known channels are {', '.join(channel.name for channel in CHANNELS)}.",
        },
        "not_finite": {
            "type": "array",
            "items": {
                "type": "object",
                "properties": {
                    "column": TEXT,
                    "row": COUNT,
                    "value": {"type": "string", "enum": ["nan", "inf", "-inf"]},
                },
                "required": ["column", "row", "value"],
            },
            "description": "Values JSON has no number for; 0 stands in their place.",
        },
    }
    schema = _table(
        "Samples",
        "Consecutive samples: a list for each column, frame b, before the mounting is applied.",
        fixed | columns,
        optional=("not_finite", *columns),
    )
    return schema | {"patternProperties": {r"^.+\.[0-9]+$": numbers}}


def _event_schema(kind: type[Event]) -> Schema:
    """Return the schema of an event without ``anyOf``: what may be null may be absent."""
    schema = kind.model_json_schema()
    for name, prop in schema["properties"].items():
        alternatives = prop.pop("anyOf", None)
        if alternatives is not None:
            (known,) = (choice for choice in alternatives if choice != {"type": "null"})
            prop.update(known)
            prop.pop("default", None)
            if name in schema["required"]:
                schema["required"].remove(name)
        if prop["type"] == "object":
            prop.setdefault("properties", {})
    return schema


DEVICE_SCHEMAS: Final[dict[str, Schema]] = {
    "raw": _table(
        "RawChunk",
        "Bytes as they went over the link.",
        {
            "t_ns": T_NS,
            "direction": {"type": "string", "enum": ["rx", "tx"]},
            "data_base64": {"type": "string", "contentEncoding": "base64"},
        },
        optional=(),
    ),
    "samples": _samples_schema(),
    "gap": _table(
        "Gap",
        "Samples that are missing.",
        {"t_ns": T_NS, "n_missing": {"type": "integer", "minimum": 1}, "reason": TEXT},
        optional=(),
    ),
    "fault": _table(
        "Fault",
        "Bytes or samples that could not be used.",
        {"t_ns": T_NS, "kind": TEXT, "count": COUNT, "detail": TEXT},
        optional=(),
    ),
    "link": _table(
        "LinkChange",
        "The link came into another state.",
        {"t_ns": T_NS, "state": TEXT, "reason": TEXT},
        optional=(),
    ),
    "resumed": _table(
        "Resumed",
        "The device goes on from where an earlier run left it, or ends what that began.",
        {
            "t_ns": T_NS,
            "saved_t_ns": T_NS,
            "aligner": {"type": "object", "properties": {}},
            "estimator_base64": {"type": "string", "contentEncoding": "base64"},
            "ended": TEXT,
        },
        optional=(),
    ),
    "device": _table(
        "DeviceStatus",
        "What the device said about itself.",
        {"t_ns": T_NS, "fields": {"type": "object", "properties": {}}},
        optional=(),
    ),
} | {kind.kind: _event_schema(kind) for kind in EVENT_TYPES}
"""Of the topics ``/{device}/{leaf}``, by leaf."""

GATEWAY_SCHEMAS: Final[dict[str, Schema]] = {
    "anchor": _table(
        "Anchor",
        "One moment on both clocks: log_time of this file is t_ns - this t_ns + wall_ns.",
        {"t_ns": T_NS, "wall_ns": {"type": "integer", "description": "Nanoseconds since 1970."}},
        optional=(),
    ),
    "dropped": _table(
        "Dropped",
        "Items that were meant to be recorded and are not.",
        {"t_ns": T_NS, "until_t_ns": T_NS, "reason": TEXT, "counts": _counts("By topic.")},
        optional=(),
    ),
}
"""Of the topics ``/gateway/{leaf}``, by leaf."""

SCHEMAS: Final[dict[str, tuple[str, bytes]]] = {
    leaf: (f"gaitway.recording.{schema['title']}", orjson.dumps(schema))
    for leaf, schema in (GATEWAY_SCHEMAS | DEVICE_SCHEMAS).items()
}
"""Leaf of the topic to name and text of its schema, in the order they are numbered in files."""

GATEWAY: Final = "gateway"


def topic(device: str, leaf: str) -> str:
    """Return the topic of one kind of message; the gateway's own belong to device ``""``."""
    return f"/{device or GATEWAY}/{leaf}"


def topics(devices: tuple[str, ...]) -> list[str]:
    """Return every topic of a recording of these devices, in the order they are numbered."""
    return [topic("", leaf) for leaf in GATEWAY_SCHEMAS] + [
        topic(device, leaf) for device in devices for leaf in DEVICE_SCHEMAS
    ]


def split_topic(name: str) -> tuple[str, str] | None:
    """Return (device, leaf) of a topic of ours, None for any other."""
    parts = name.split("/")
    if len(parts) != 3 or parts[0] or parts[2] not in SCHEMAS:
        return None
    return ("" if parts[2] in GATEWAY_SCHEMAS else parts[1]), parts[2]
