"""Xbus messages: their numbers, what errors mean, and how one is written."""

from collections.abc import Mapping
from enum import IntEnum, unique
from typing import Final

PREAMBLE: Final = 0xFA
MASTER: Final = 0xFF
"""Bus id of a stand-alone device."""
EXTENDED: Final = 0xFF
"""Length byte that says: the real length follows as two bytes."""
MAX_DATA_BYTES: Final = 2048


@unique
class Mid(IntEnum):
    """Message ids; an acknowledgement is its request plus one."""

    REQ_DEVICE_ID = 0x00
    DEVICE_ID = 0x01
    GO_TO_MEASUREMENT = 0x10
    GO_TO_MEASUREMENT_ACK = 0x11
    REQ_FIRMWARE = 0x12
    FIRMWARE = 0x13
    REQ_PRODUCT_CODE = 0x1C
    PRODUCT_CODE = 0x1D
    GO_TO_CONFIG = 0x30
    GO_TO_CONFIG_ACK = 0x31
    MTDATA2 = 0x36
    WAKE_UP = 0x3E
    WAKE_UP_ACK = 0x3F
    RESET = 0x40
    RESET_ACK = 0x41
    ERROR = 0x42
    WARNING = 0x43
    SET_OUTPUT_CONFIGURATION = 0xC0
    OUTPUT_CONFIGURATION = 0xC1


INVALID_MESSAGE: Final = 0x04
INVALID_PARAMETER: Final = 0x21

ERROR_MEANINGS: Final[Mapping[int, str]] = {
    0x03: "period outside the range",
    INVALID_MESSAGE: "message not valid in this state",
    0x1E: "timer overflow: more output asked for than it can compute or send in a period",
    0x20: "baud rate outside the range",
    INVALID_PARAMETER: "parameter not valid for this device",
    0x28: "fault within the device: power it off and on",
}


def describe_error(data: bytes) -> str:
    """Return in words what the data of an Error or Warning message says."""
    if not data:
        return "no code given"
    meaning = ERROR_MEANINGS.get(data[0], "of unknown meaning")
    more = f" (and {data[1:5].hex()})" if len(data) > 1 else ""
    return f"code 0x{data[0]:02X}: {meaning}{more}"


def encode_message(mid: int, data: bytes = b"", bid: int = MASTER) -> bytes:
    """Return a whole message; more than 254 bytes of data use the extended length.

    Raises:
        ValueError: The data are longer than a message can hold.
    """
    if len(data) > MAX_DATA_BYTES:
        raise ValueError(f"{len(data)} bytes of data; an Xbus message holds {MAX_DATA_BYTES}")
    if len(data) < EXTENDED:
        body = bytes((bid, mid, len(data))) + data
    else:
        body = bytes((bid, mid, EXTENDED)) + len(data).to_bytes(2, "big") + data
    return bytes((PREAMBLE,)) + body + bytes((-sum(body) & 0xFF,))
