"""MTData2: which items a measurement holds, and what they say.

A payload is a row of items, each a data id (two bytes), a size (one byte) and a value, in any
order. Bits 0-1 of the id are the number format of real values and bits 2-3 their coordinate frame;
the rest says which quantity it is. Everything is big-endian.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitway.api import Floats
from gaitway_drivers.codecs.xbus.framer import Bytes, MessageRun

ITEM_HEADER_BYTES: Final = 3
MAX_LAYOUTS: Final = 32
"""Layouts remembered; a device uses a handful, and a hostile stream can't fill memory."""

FLOAT32, FP12_20, FP16_32, FLOAT64 = range(4)
# The fraction comes first although everything else is big-endian.
_FP16_32 = np.dtype([("fraction", ">u4"), ("whole", ">i2")])
REALS: Final = (np.dtype(">f4"), np.dtype(">i4"), _FP16_32, np.dtype(">f8"))
"""One real number in each format."""

ENU, NED, NWU = 0x0, 0x4, 0x8

TEMPERATURE: Final = 0x0810
UTC_TIME: Final = 0x1010
PACKET_COUNTER: Final = 0x1020
SAMPLE_TIME_FINE: Final = 0x1060
QUATERNION: Final = 0x2010
DELTA_V: Final = 0x4010
ACCELERATION: Final = 0x4020
RATE_OF_TURN: Final = 0x8020
DELTA_Q: Final = 0x8030
STATUS_WORD: Final = 0xE020


class Quantity(NamedTuple):
    """What one data id stands for.

    Attributes:
        name: Its name.
        reals: How many real numbers, in the format of the id's bits 0-1; 0 if ``fields`` say it.
        fields: The layout of anything else.
    """

    name: str
    reals: int
    fields: np.dtype[Any] | None = None


_UTC = np.dtype(
    [("ns", ">u4"), ("year", ">u2")]
    + [(name, "u1") for name in ("month", "day", "hour", "minute", "second", "flags")]
)
_RAW = np.dtype(
    [("accel", ">u2", 3), ("gyro", ">u2", 3), ("mag", ">u2", 3), ("temperature", ">i2")]
)

QUANTITIES: Final[Mapping[int, Quantity]] = {
    TEMPERATURE: Quantity("temperature", 1),
    UTC_TIME: Quantity("utc_time", 0, _UTC),
    PACKET_COUNTER: Quantity("packet_counter", 0, np.dtype(">u2")),
    SAMPLE_TIME_FINE: Quantity("sample_time_fine", 0, np.dtype(">u4")),
    0x1070: Quantity("sample_time_coarse", 0, np.dtype(">u4")),
    QUATERNION: Quantity("quaternion", 4),
    0x2020: Quantity("rotation_matrix", 9),
    0x2030: Quantity("euler", 3),
    0x3010: Quantity("baro_pressure", 0, np.dtype(">u4")),
    DELTA_V: Quantity("delta_v", 3),
    ACCELERATION: Quantity("acceleration", 3),
    0x4030: Quantity("free_acceleration", 3),
    0x4040: Quantity("acceleration_hr", 3),
    0x5020: Quantity("altitude_ellipsoid", 1),
    0x5030: Quantity("position_ecef", 3),
    0x5040: Quantity("lat_lon", 2),
    0x7010: Quantity("gnss_pvt", 0, np.dtype("V94")),
    RATE_OF_TURN: Quantity("rate_of_turn", 3),
    DELTA_Q: Quantity("delta_q", 4),
    0x8040: Quantity("rate_of_turn_hr", 3),
    0xA010: Quantity("raw", 0, _RAW),
    0xC020: Quantity("magnetic_field", 3),
    0xD010: Quantity("velocity", 3),
    0xE010: Quantity("status_byte", 0, np.dtype("u1")),
    STATUS_WORD: Quantity("status_word", 0, np.dtype(">u4")),
}
"""By data id without its format and coordinate bits. Ids not listed are skipped by their size."""


def quantity_id(data_id: int) -> int:
    """Return a data id without its number format and coordinate frame."""
    return data_id & 0xFFF0


def value_bytes(data_id: int) -> int | None:
    """Return how long the value of a data id is; None if the id is not known."""
    quantity = QUANTITIES.get(quantity_id(data_id))
    if quantity is None:
        return None
    if quantity.fields is not None:
        return quantity.fields.itemsize
    return quantity.reals * REALS[data_id & 0x3].itemsize


class Item(NamedTuple):
    """Where in a payload the value of a data id is."""

    data_id: int
    start: int
    stop: int

    @property
    def name(self) -> str:
        """Its name among the items of a payload, which may hold two of one data id."""
        return str(self.start)

    @property
    def wire_type(self) -> np.dtype[Any]:
        """How its value is sent."""
        quantity = QUANTITIES.get(quantity_id(self.data_id))
        if quantity is None:
            return np.dtype(f"V{self.stop - self.start}")
        if quantity.fields is None:
            return np.dtype((REALS[self.data_id & 0x3], (quantity.reals,)))
        return quantity.fields


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Which items a payload holds and where; payloads of one stream share a few of these.

    Attributes:
        items: In the order of the payload, up to the one that is wrong if there is one.
        fault: What is wrong with the payload; empty if nothing is.
        mask: 255 where a payload says what its items are, 0 where it holds values, shape (k,).
        ids: What it says there, as long as a payload.
    """

    items: tuple[Item, ...]
    fault: str
    mask: Bytes
    ids: bytes

    def find(self, quantity: int) -> Item | None:
        """Return the first item of a quantity, whatever its format and frame."""
        return next((item for item in self.items if quantity_id(item.data_id) == quantity), None)

    def record(self) -> np.dtype[np.void]:
        """Return a payload as a record: a field for each item, under its name."""
        return np.dtype(
            {
                "names": [item.name for item in self.items],
                "formats": [item.wire_type for item in self.items],
                "offsets": [item.start for item in self.items],
                "itemsize": len(self.ids),
            }
        )

    def count_alike(self, payloads: Bytes) -> int:
        """Return how many of the payloads, from the first on, have this layout."""
        ids = payloads & self.mask
        if ids.tobytes() == self.ids * len(payloads):
            return len(payloads)
        return int(np.argmax((ids != np.frombuffer(self.ids, np.uint8)).any(axis=1)))


def parse_layout(payload: bytes) -> Layout:
    """Return the layout of one payload; what is wrong with it is said there, never raised."""
    items: list[Item] = []
    mask = np.zeros(len(payload), np.uint8)
    fault = ""
    at = 0
    while at < len(payload) and not fault:
        start = at + ITEM_HEADER_BYTES
        mask[at:start] = 0xFF
        if start > len(payload):
            fault = "it ends within the header of an item"
            break
        data_id, size = int.from_bytes(payload[at : at + 2], "big"), payload[at + 2]
        expected = value_bytes(data_id)
        if start + size > len(payload):
            fault = f"item {data_id:04X} of {size} bytes reaches beyond its end"
        elif expected not in (None, size):
            fault = f"item {data_id:04X} has {size} bytes, not {expected}"
        else:
            items.append(Item(data_id, start, start + size))
        at = start + size
    ids = np.frombuffer(payload, np.uint8) & mask
    return Layout(tuple(items), fault, mask, ids.tobytes())


class LayoutCache:
    """Finds the layout of payloads, parsing only those it has not seen lately."""

    def __init__(self) -> None:
        self._layouts: dict[int, Layout] = {}

    def split(self, run: MessageRun) -> list[tuple[Layout, MessageRun]]:
        """Return measurements in runs of one layout."""
        parts: list[tuple[Layout, MessageRun]] = []
        while True:
            payloads = run.payloads
            layout = self._layouts.get(run.payload_bytes)
            alike = layout.count_alike(payloads) if layout is not None else 0
            if layout is None or alike == 0:
                layout = parse_layout(payloads[0].tobytes())
                alike = layout.count_alike(payloads)
                if len(self._layouts) >= MAX_LAYOUTS:
                    self._layouts.clear()
                self._layouts[run.payload_bytes] = layout
            if alike == run.messages:
                return [*parts, (layout, run)]
            whole, run = run.split(alike)
            parts.append((layout, whole))


def decode_reals(data_id: int, sent: NDArray[Any]) -> Floats:
    """Return real numbers, whatever their format, shape (n, reals).

    A signalling NaN from the device makes NumPy warn unless ``np.errstate`` says otherwise.

    Args:
        data_id: Its bits 0-1 are the format.
        sent: The numbers as they were sent, shape (n, reals).
    """
    number_format = data_id & 0x3
    if number_format == FP12_20:
        return sent / 2.0**20
    if number_format == FP16_32:
        return sent["whole"] + sent["fraction"] / 2.0**32
    return sent.astype(np.float64)


def encode_reals(data_id: int, values: Floats) -> bytes:
    """Return a whole item of real numbers in the format its id says.

    Args:
        data_id: Its bits 0-1 choose the format.
        values: The numbers, shape (k,).
    """
    number_format = data_id & 0x3
    if number_format == FLOAT32:
        value = values.astype(">f4").tobytes()
    elif number_format == FLOAT64:
        value = values.astype(">f8").tobytes()
    elif number_format == FP12_20:
        value = np.rint(values * 2.0**20).astype(">i4").tobytes()
    else:
        fixed = np.rint(values * 2.0**32).astype(np.int64)
        parts = np.zeros(len(values), _FP16_32)
        parts["whole"], parts["fraction"] = fixed >> 32, fixed & 0xFFFFFFFF
        value = parts.tobytes()
    return encode_item(data_id, value)


def encode_item(data_id: int, value: bytes) -> bytes:
    """Return a whole item: id, size, value."""
    return data_id.to_bytes(2, "big") + bytes((len(value),)) + value
