"""What the driver tests share: recorded bytes, and short ways to feed and compare."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitway.api import Chunk, CodecItem, DeviceBatch, Fault
from gaitway_drivers.codecs.xbus.codec import XbusCodec
from gaitway_drivers.codecs.xbus.messages import Mid, encode_message
from gaitway_drivers.codecs.xbus.mtdata2 import (
    QUANTITIES,
    Item,
    Layout,
    decode_reals,
    encode_item,
    encode_reals,
    quantity_id,
)
from gaitway_drivers.params import XbusParams

Decode = Callable[..., list[CodecItem]]


@pytest.fixture(scope="session")
def golden() -> Path:
    return Path(__file__).parent / "golden"


@pytest.fixture(scope="session")
def capture(golden: Path) -> bytes:
    """One second of a real MTi-G-710 at 100 Hz, float32."""
    return (golden / "xsens_einride/1/output.bin").read_bytes()


@pytest.fixture(scope="session")
def decode() -> Decode:
    """Listen to chunks of bytes, one a millisecond, from start to finish."""

    def run(chunks: Iterable[bytes], *, rate_hz: float | None = None) -> list[CodecItem]:
        codec = XbusCodec(XbusParams(listen_only=True, rate_hz=rate_hz))
        items = codec.start(0)
        for number, data in enumerate(chunks):
            if data:
                items += codec.feed(Chunk(number * 1_000_000, data))
        return items + codec.finish()

    return run


@pytest.fixture(scope="session")
def digest() -> Callable[[Sequence[CodecItem]], tuple[list[object], dict[str, int]]]:
    """Reduce items to what must not depend on chunking: each sample, and faults summed by kind."""

    def run(items: Sequence[CodecItem]) -> tuple[list[object], dict[str, int]]:
        rows: list[object] = []
        faults: dict[str, int] = {}
        for item in items:
            if isinstance(item, DeviceBatch):
                assert (np.diff(item.device_ns) > 0).all()
                for index, at_ns in enumerate(item.device_ns.tolist()):
                    values = {
                        name: channel[index].tobytes() for name, channel in item.channels.items()
                    }
                    rows.append((at_ns, item.period_s, item.restarted and index == 0, values))
            elif isinstance(item, Fault):
                faults[item.kind] = faults.get(item.kind, 0) + item.count
        return rows, faults

    return run


@pytest.fixture(scope="session")
def measurement() -> Callable[..., bytes]:
    """Write one measurement: counter, ticks, then real-valued items by their data ids."""

    def write(
        counter: int | None, ticks: int | None, reals: dict[int, Sequence[float]], rest: bytes = b""
    ) -> bytes:
        data = b""
        if counter is not None:
            data += encode_item(0x1020, (counter % 65536).to_bytes(2, "big"))
        if ticks is not None:
            data += encode_item(0x1060, (ticks % 2**32).to_bytes(4, "big"))
        for data_id, values in reals.items():
            data += encode_reals(data_id, np.array(values, dtype=float))
        return encode_message(Mid.MTDATA2, data + rest)

    return write


@pytest.fixture(scope="session")
def item_value() -> Callable[[Layout, Item, bytes], Any]:
    """Decode one item of a payload: reals as an array, anything else as it is."""

    def read(layout: Layout, item: Item, payload: bytes) -> Any:
        sent = np.frombuffer(payload, layout.record())[item.name]
        quantity = QUANTITIES.get(quantity_id(item.data_id))
        return decode_reals(item.data_id, sent)[0] if quantity and quantity.reals else sent[0]

    return read
