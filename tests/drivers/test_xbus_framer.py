"""The framer on split, broken and hostile streams."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway_drivers.codecs.xbus.framer import SHORTEST_STALL_NS, Framer
from gaitway_drivers.codecs.xbus.messages import MAX_DATA_BYTES, Mid, encode_message

LONGEST_MESSAGE = 7 + MAX_DATA_BYTES
FALSE_HEADER = bytes.fromhex("faff36ff0800")

messages = st.lists(
    st.tuples(st.sampled_from(list(Mid)), st.binary(max_size=400)), min_size=1, max_size=8
)
hostile = st.lists(
    st.one_of(
        st.sampled_from(
            [
                b"\xfa",
                b"\xfa\xff\x36",
                FALSE_HEADER,
                b"\xfa\xff\x36\x05",
                encode_message(Mid.MTDATA2, b"\xfa\xff\x36"),
                encode_message(Mid.MTDATA2, bytes(300)),
            ]
        ),
        st.binary(max_size=20),
    ),
    max_size=30,
).map(b"".join)
cuts = st.lists(st.integers(min_value=1, max_value=120), max_size=40)


def cut(data: bytes, sizes: list[int]) -> list[bytes]:
    chunks = []
    for size in sizes:
        chunks.append(data[:size])
        data = data[size:]
    return [chunk for chunk in [*chunks, data] if chunk]


def feed_all(framer: Framer, chunks: list[bytes], t_ns: int = 0) -> list[tuple[int, bytes]]:
    runs = [run for chunk in chunks for run in framer.feed(t_ns, chunk)]
    return [(run.mid, row.tobytes()) for run in runs for row in run.payloads]


@given(messages, cuts)
def test_any_cut_gives_the_messages_that_were_written(sent, sizes) -> None:
    framer = Framer()
    stream = b"".join(encode_message(mid, data) for mid, data in sent)
    assert feed_all(framer, cut(stream, sizes)) == sent
    assert (framer.junk_bytes, framer.bad_checksums, framer.pending_bytes) == (0, 0, 0)


@given(hostile, cuts)
def test_any_cut_of_any_bytes_gives_the_same_messages_and_counts(data, sizes) -> None:
    whole, parts = Framer(), Framer()
    assert feed_all(whole, [data] if data else []) == feed_all(parts, cut(data, sizes))
    assert (whole.junk_bytes, whole.bad_checksums, whole.pending_bytes) == (
        parts.junk_bytes,
        parts.bad_checksums,
        parts.pending_bytes,
    )


@given(st.lists(hostile.filter(len), max_size=6))
def test_every_byte_is_message_junk_or_pending_and_few_are_pending(chunks) -> None:
    framer = Framer()
    found = feed_all(framer, chunks)
    used = sum(len(encode_message(mid, data)) for mid, data in found)
    assert used + framer.junk_bytes + framer.pending_bytes == sum(map(len, chunks))
    assert framer.pending_bytes < LONGEST_MESSAGE


@pytest.mark.parametrize("seed", range(20))
def test_a_flipped_bit_costs_no_other_message_and_invents_none(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sent = [(int(Mid.MTDATA2), rng.bytes(83)) for _ in range(12)]
    stream = bytearray(b"".join(encode_message(mid, data) for mid, data in sent))
    hit = int(rng.integers(len(stream)))
    stream[hit] ^= 1 << int(rng.integers(8))
    framer = Framer()
    found = feed_all(framer, [bytes(stream)])
    found += [(run.mid, row.tobytes()) for run in framer.finish() for row in run.payloads]
    assert found == sent[: hit // 88] + sent[hit // 88 + 1 :]


def test_a_false_header_that_claims_2_kb_holds_good_messages_back_for_the_stall_time_only() -> None:
    framer = Framer()
    good = encode_message(Mid.MTDATA2, bytes(20))
    assert feed_all(framer, [FALSE_HEADER + good]) == []
    assert feed_all(framer, [good], SHORTEST_STALL_NS) == []
    assert len(feed_all(framer, [good], SHORTEST_STALL_NS + 1)) == 3
    assert (framer.stalls, framer.junk_bytes, framer.pending_bytes) == (1, len(FALSE_HEADER), 0)


def test_false_headers_in_a_row_are_given_up_together() -> None:
    framer = Framer()
    good = encode_message(Mid.MTDATA2, bytes(20))
    feed_all(framer, [FALSE_HEADER * 3 + good])
    assert len(feed_all(framer, [good], 2 * SHORTEST_STALL_NS)) == 2


def test_a_message_that_comes_slowly_is_not_given_up() -> None:
    framer = Framer()
    message = encode_message(Mid.MTDATA2, bytes(80))
    found = []
    for number, byte in enumerate(message):
        found += feed_all(framer, [bytes((byte,))], number * SHORTEST_STALL_NS)
    assert len(found) == 1
    assert (framer.junk_bytes, framer.stalls) == (0, 0)


def test_the_age_of_a_message_counts_from_its_own_first_byte() -> None:
    framer = Framer()
    good = encode_message(Mid.MTDATA2, bytes(20))
    feed_all(framer, [good[:10]], 0)
    feed_all(framer, [good[10:] + FALSE_HEADER + good], SHORTEST_STALL_NS)
    assert feed_all(framer, [good], SHORTEST_STALL_NS + 10) == []
    assert framer.stalls == 0


@pytest.mark.parametrize("header", ["fa2036", "fa7f", "fafe", "faff36ff0801", "faff36ff00fe"])
def test_a_header_that_no_device_sends_is_left_at_once(header: str) -> None:
    framer = Framer()
    good = encode_message(Mid.MTDATA2, b"")
    assert feed_all(framer, [bytes.fromhex(header) + good]) == [(Mid.MTDATA2, b"")]
    assert framer.bad_checksums == 1


HOSTILE = {
    "preambles": b"\xfa",
    "bad checksums": b"\xfa\xff\x36\x00\x00",
    "every second message bad": encode_message(0x36, b"") + b"\xfa\xff\x36\x00\x00",
    "one bad after a long run": encode_message(0x36, b"") * 128 + b"\xfa\xff\x36\x00\x00",
    "long claims": b"\xfa\xff\xff\xff\x08\x00",
    "noise": np.random.default_rng(1).bytes(997),
}


@pytest.mark.parametrize("pattern", HOSTILE.values(), ids=HOSTILE.keys())
def test_the_cost_of_garbage_grows_with_its_length_only(pattern: bytes) -> None:
    def cost_s(length: int) -> float:
        data = (pattern * (length // len(pattern) + 1))[:length]
        began_s = time.process_time()
        Framer().feed(0, data)
        return time.process_time() - began_s

    assert min(cost_s(80_000) for _ in range(3)) < 10 * min(cost_s(20_000) for _ in range(3))


def test_long_runs_cost_no_more_when_one_message_in_two_is_bad() -> None:
    framer = Framer()
    looked: list[int] = []
    count_rows = np.frombuffer

    def counting(data: bytes, dtype: type, count: int, offset: int) -> object:
        looked.append(count)
        return count_rows(data, dtype, count, offset)

    pattern = HOSTILE["every second message bad"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(np, "frombuffer", counting)
        framer.feed(0, pattern * 1000)
    assert sum(looked) < 3 * len(pattern) * 1000


def test_data_longer_than_a_message_holds_are_refused() -> None:
    with pytest.raises(ValueError, match="2049 bytes"):
        encode_message(Mid.MTDATA2, bytes(MAX_DATA_BYTES + 1))


@pytest.mark.parametrize(("length", "total"), [(0, 5), (254, 259), (255, 262), (2048, 2055)])
def test_a_message_uses_the_short_length_as_long_as_it_can(length: int, total: int) -> None:
    message = encode_message(Mid.MTDATA2, bytes(length))
    assert len(message) == total
    assert feed_all(Framer(), [message]) == [(Mid.MTDATA2, bytes(length))]
