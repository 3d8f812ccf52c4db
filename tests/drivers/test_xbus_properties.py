"""What holds for the whole codec, whatever comes and however it is cut."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitway.api import ACCEL, ATTITUDE, CLIP, GYRO, Chunk, DeviceBatch
from gaitway_drivers.codecs.xbus.codec import XbusCodec
from gaitway_drivers.codecs.xbus.framer import Framer
from gaitway_drivers.codecs.xbus.messages import Mid, encode_message
from gaitway_drivers.codecs.xbus.mtdata2 import (
    MAX_LAYOUTS,
    REALS,
    LayoutCache,
    decode_reals,
    encode_item,
    encode_reals,
    parse_layout,
)
from gaitway_drivers.codecs.xbus.outputs import Output
from gaitway_drivers.codecs.xbus.peripheral import XbusPeripheral
from gaitway_drivers.codecs.xbus.session import STEPS
from gaitway_drivers.params import XbusParams

IMU_IDS = (0x4020, 0x8020, 0x2010, 0x4010, 0x8030)
RESOLUTIONS = {0: 2.0**-23, 1: 2.0**-20, 2: 2.0**-32, 3: 0.0}
"""Resolution of each number format for numbers below 1."""

cuts = st.lists(st.integers(min_value=1, max_value=300), max_size=60)


def cut(data, sizes):
    chunks = []
    for size in sizes:
        chunks.append(data[:size])
        data = data[size:]
    return [*chunks, data]


@st.composite
def streams(draw):
    """Draw a stream of measurements with holes, splits, restarts, strays and garbage."""
    parts = []
    counter = draw(st.integers(0, 65535))
    ticks = draw(st.sampled_from([0, 50_000, 864_000_000 - 700, 2**32 - 700]))
    for _ in range(draw(st.integers(1, 60))):
        kind = draw(st.sampled_from("sssssssssshpqgtuwx"))
        number = encode_item(0x1020, counter.to_bytes(2, "big"))
        at = encode_item(0x1060, ticks.to_bytes(4, "big"))
        values = {
            i: encode_reals(i, np.full(4 if i in (0x2010, 0x8030) else 3, 0.5)) for i in IMU_IDS
        }
        data = {
            "s": number + at + values[0x4020] + values[0x8020],
            "h": number + at + values[0x4010] + values[0x8030] + values[0x2010],
            "p": number + at + values[0x4020],
            "q": number + at + values[0x8020] + values[0x2010],
            "g": number + encode_item(0x1060, bytes(4)) + encode_item(0x7010, bytes(94)),
            "t": number + at + encode_reals(0x0810, np.array([draw(st.floats(-40, 85))])),
            "u": number + values[0x4020] + values[0x8020],
        }.get(kind)
        if data is not None:
            parts.append(encode_message(Mid.MTDATA2, data))
        elif kind == "w":
            parts.append(encode_message(Mid.WAKE_UP))
        else:
            parts.append(draw(st.binary(max_size=20)))
        counter = (counter + draw(st.sampled_from([1, 1, 1, 1, 1, 2, 900]))) % 65536
        ticks = (ticks + draw(st.sampled_from([100, 100, 100, 100, 0, 300, 5000, -2000]))) % 2**32
    return b"".join(parts)


@settings(max_examples=120)
@given(streams(), cuts, st.sampled_from([None, 100.0]))
def test_any_cut_gives_the_same_samples_and_faults(decode, digest, data, sizes, rate_hz):
    assert digest(decode(cut(data, sizes), rate_hz=rate_hz)) == digest(
        decode([data], rate_hz=rate_hz)
    )


@settings(max_examples=40)
@given(cuts)
def test_any_cut_of_a_real_recording_gives_the_same_samples(capture, decode, digest, sizes):
    rows, faults = digest(decode(cut(capture, sizes)))
    assert (rows, faults) == digest(decode([capture]))
    assert (len(rows), faults) == (96, {})


def test_byte_by_byte_gives_the_same_samples(capture, decode, digest):
    assert digest(decode([bytes((byte,)) for byte in capture])) == digest(decode([capture]))


@settings(max_examples=150)
@given(st.data(), st.booleans())
def test_bytes_changed_at_random_never_raise(capture, decode, digest, data, listen_only):
    stream = bytearray(capture[:3000])
    places = st.integers(0, len(stream) - 1)
    for place in data.draw(st.lists(places, max_size=30)):
        stream[place] = data.draw(st.integers(0, 255))
    codec = XbusCodec(XbusParams(listen_only=listen_only))
    items = codec.start(0)
    for number, part in enumerate(cut(bytes(stream), data.draw(cuts))):
        if part:
            items += codec.feed(Chunk(number, part))
            items += codec.on_time(number)
    digest(items + codec.finish())


@settings(max_examples=150)
@given(
    st.integers(0, len(STEPS)),
    st.lists(st.tuples(st.sampled_from(list(Mid)), st.binary(max_size=40)), max_size=30),
    st.lists(st.binary(max_size=12), min_size=len(STEPS), max_size=len(STEPS)),
)
def test_any_messages_in_any_order_never_raise(decode, digest, steps, strays, answers):
    sent = [(step.answer, data) for step, data in zip(STEPS[:steps], answers, strict=False)]
    sent += strays
    stream = b"".join(encode_message(mid, data) for mid, data in sent)
    digest(decode([stream]))
    codec = XbusCodec(XbusParams())
    codec.start(0)
    digest(codec.feed(Chunk(1, stream or b"\x00")) + codec.finish())


@given(st.binary(max_size=300))
def test_any_payload_has_a_layout_that_stays_inside_it(payload):
    layout = parse_layout(payload)
    assert all(item.stop <= len(payload) for item in layout.items)
    assert all(payload[item.start - 1] == item.stop - item.start for item in layout.items)
    assert (len(layout.mask), len(layout.ids)) == (len(payload), len(payload))


def test_layouts_are_remembered_in_bounded_number():
    cache = LayoutCache()
    for length in range(3, 200):
        payload = encode_item(0x9990, bytes(length))
        (run,) = Framer().feed(0, encode_message(Mid.MTDATA2, payload))
        ((layout, alike),) = cache.split(run)
        assert (len(layout.items), alike.messages) == (1, 1)
    assert len(cache._layouts) <= MAX_LAYOUTS


def test_hostile_streams_do_not_grow_memory():
    rng = np.random.default_rng(5)
    codec = XbusCodec(XbusParams(listen_only=True))
    codec.start(0)

    def feed_round(number):
        chunk = b"".join(
            encode_message(
                Mid.MTDATA2,
                b"".join(
                    encode_item(int(rng.choice([0x4020, 0x1060, 0x1020, 0x9990])), rng.bytes(size))
                    for size in rng.integers(0, 40, size=3)
                ),
            )
            for _ in range(20)
        )
        codec.feed(Chunk(number, chunk + rng.bytes(500)))

    for number in range(20):
        feed_round(number)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for number in range(20, 90):
            feed_round(number)
        grown_bytes = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert grown_bytes < 100_000


@pytest.mark.parametrize("number_format", range(4))
@given(st.lists(st.floats(-2000, 2000), min_size=1, max_size=9))
def test_numbers_survive_the_wire_within_their_resolution(number_format, values):
    data_id = 0x4020 | number_format
    wire = encode_reals(data_id, np.array(values))
    assert len(wire) == 3 + REALS[number_format].itemsize * len(values)
    back = decode_reals(data_id, np.frombuffer(wire, REALS[number_format], offset=3))
    scale = 2048.0 if number_format == 0 else 1.0
    np.testing.assert_allclose(back, values, rtol=0, atol=RESOLUTIONS[number_format] * scale)


vectors = st.lists(st.floats(-30, 30), min_size=3, max_size=3)


@settings(max_examples=60)
@given(
    st.lists(st.tuples(vectors, vectors, st.integers(0, 63)), min_size=12, max_size=30),
    st.sampled_from([25.0, 100.0, 400.0]),
    st.integers(0, 3),
    st.sampled_from([b"", encode_item(0x7010, bytes(94)) * 3]),
)
def test_what_the_peripheral_encodes_the_codec_decodes(
    decode, samples, rate_hz, number_format, extra_items
):
    ids = (0x1020, 0x1060, 0x4020 | number_format, 0x8020 | number_format, 0xE020)
    peripheral = XbusPeripheral(
        rate_hz,
        outputs=[Output(data_id, round(rate_hz)) for data_id in ids],
        auto_measure=True,
        extra_items=extra_items,
    )
    stream = peripheral.start()
    for index, (accel, gyro, clip) in enumerate(samples):
        channels = {
            ACCEL.name: np.array(accel),
            GYRO.name: np.array(gyro),
            CLIP.name: np.array([float(clip)]),
        }
        stream += peripheral.encode(index, channels)
    batches = [item for item in decode([stream]) if isinstance(item, DeviceBatch)]
    assert {batch.period_s for batch in batches} == {1.0 / rate_hz}
    at_ns = np.concatenate([batch.device_ns for batch in batches])
    assert at_ns.tolist() == [round(i * 1e9 / rate_hz) for i in range(len(samples))]
    atol = RESOLUTIONS[number_format] * (32 if number_format == 0 else 1)
    for column, name in enumerate((ACCEL.name, GYRO.name)):
        decoded = np.concatenate([batch.channels[name] for batch in batches])
        np.testing.assert_allclose(decoded, [s[column] for s in samples], rtol=0, atol=atol)
    clip = np.concatenate([batch.channels[CLIP.name] for batch in batches])
    assert clip[:, 0].tolist() == [float(sample[2]) for sample in samples]


@pytest.mark.parametrize("count", [1, 2, 7, 128, 300])
def test_many_messages_at_once_decode_as_one_by_one(decode, digest, count):
    rng = np.random.default_rng(3)
    peripheral = XbusPeripheral(100.0, auto_measure=True)
    frames = [peripheral.start()]
    for index in range(600):
        quaternion = rng.normal(size=4)
        channels = {
            ACCEL.name: rng.normal(size=3),
            GYRO.name: rng.normal(size=3),
            ATTITUDE.name: quaternion / np.linalg.norm(quaternion),
            CLIP.name: rng.integers(0, 64, size=1).astype(float),
        }
        frames.append(peripheral.encode(index, channels))
    chunks = [b"".join(frames[at : at + count]) for at in range(0, len(frames), count)]
    rows, faults = digest(decode(chunks))
    assert (rows, faults) == digest(decode(frames))
    assert (len(rows), faults) == (600, {})
