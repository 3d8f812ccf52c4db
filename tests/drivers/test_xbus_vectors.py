"""Single messages and short streams against what independent decoders made of them."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitway_drivers.codecs.xbus.framer import Framer
from gaitway_drivers.codecs.xbus.messages import Mid
from gaitway_drivers.codecs.xbus.mtdata2 import (
    QUANTITIES,
    REALS,
    decode_reals,
    parse_layout,
    quantity_id,
)

HERE = Path(__file__).parent
OWN = json.loads((HERE / "golden/mtdata2.json").read_text())


def check_vector(vector: dict[str, Any], item_value: Callable[..., Any]) -> None:
    framer = Framer()
    runs = []
    for number, chunk in enumerate(vector["input"]["chunks_hex"]):
        runs += framer.feed(number * 1_000_000, bytes.fromhex(chunk))
    expected = vector["expect"]
    if vector["flush_at_end"]:
        assert framer.pending_bytes == expected["pending_before_flush"]
        runs += framer.finish()
    counters = (framer.junk_bytes, framer.bad_checksums, framer.pending_bytes)
    assert counters == tuple(
        expected[name] for name in ("junk_bytes", "bad_checksums", "pending_bytes")
    )
    frames = [(run.mid, row.tobytes()) for run in runs for row in run.payloads]
    assert [(mid, len(data)) for mid, data in frames] == [
        (frame["mid"], frame["data_len"]) for frame in expected["frames"]
    ]
    tolerance = vector.get("tolerance", {"abs": 0, "rel": 0})
    for (mid, data), frame in zip(frames, expected["frames"], strict=True):
        if "data_hex" in frame:
            assert data.hex() == frame["data_hex"]
        if mid == Mid.MTDATA2:
            check_items(data, frame, tolerance, item_value)


def check_items(
    data: bytes,
    frame: dict[str, Any],
    tolerance: dict[str, float],
    item_value: Callable[..., Any],
) -> None:
    layout = parse_layout(data)
    assert layout.fault == ""
    assert [f"0x{item.data_id:04X}" for item in layout.items] == [
        item["data_id"] for item in frame["items"]
    ]
    for item, expected in zip(layout.items, frame["items"], strict=True):
        quantity = QUANTITIES.get(quantity_id(item.data_id))
        assert (quantity.name if quantity else "unknown") == expected["name"]
        value = item_value(layout, item, data)
        if "raw_hex" in expected:
            assert value.tobytes().hex() == expected["raw_hex"]
        elif isinstance(expected["value"], dict):
            assert {name: int(value[name]) for name in value.dtype.names} == expected["value"]
        else:
            np.testing.assert_allclose(
                np.ravel(value),
                np.ravel(expected["value"]),
                rtol=tolerance["rel"],
                atol=tolerance["abs"],
            )


@pytest.mark.parametrize("vector", OWN["vectors"], ids=lambda vector: vector["id"])
def test_vector_gives_the_frames_items_and_counters_of_its_oracles(
    vector: dict[str, Any], item_value: Callable[..., Any]
) -> None:
    check_vector(vector, item_value)


@pytest.mark.parametrize("name", ["fp12.20", "fp16.32"])
def test_fixed_point_numbers_decode_as_the_real_device_meant_them(name: str) -> None:
    data_id, step = {"fp12.20": (0x5041, 2.0**-20), "fp16.32": (0x5042, 2.0**-32)}[name]
    for text, expected in OWN["scalar_vectors"][name]:
        sent = np.frombuffer(bytes.fromhex(text), REALS[data_id & 0x3])
        value = decode_reals(data_id, sent)[0]
        assert abs(value - expected) <= step / 2


def test_complete_vector_file_passes_where_it_is_at_hand(item_value: Callable[..., Any]) -> None:
    shared = Path(os.environ.get("GAITWAY_SHARED", HERE.parents[2] / "shared"))
    path = shared / "wire/vectors/mtdata2.json"
    if not path.exists():
        pytest.skip(f"the complete vectors are not here: {path} (set GAITWAY_SHARED)")
    vectors = json.loads(path.read_text())["vectors"]
    assert len(vectors) >= 20
    for vector in vectors:
        try:
            check_vector(vector, item_value)
        except AssertionError as exc:
            raise AssertionError(f"{vector['id']}: {exc}") from exc
