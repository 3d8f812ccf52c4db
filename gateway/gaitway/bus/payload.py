"""Events as published: the event's own fields inside a small envelope, as JSON."""

from typing import Any

import orjson

from gaitway.events import Event
from gaitway.timebase import WallAnchor


def encode(
    event: Event, *, device: str, device_type: str, run: str, sequence: int, anchor: WallAnchor
) -> bytes:
    """Return the payload of an event.

    Args:
        event: What happened.
        device: Id of the device.
        device_type: Its type.
        run: Identity of this run of the gateway; sequence and monotonic times belong to it.
        sequence: Number of the event among its device's of this kind, from 0, none left out.
        anchor: Bridge to wall-clock time.
    """
    envelope: dict[str, Any] = {
        "device": device,
        "device_type": device_type,
        "kind": event.kind,
        "run": run,
        "sequence": sequence,
        "time_utc": anchor.to_utc(event.t_ns),
    }
    return orjson.dumps(envelope | event.model_dump())
