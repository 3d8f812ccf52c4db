import os
import random
import zlib

import jsonschema
import numpy as np
import orjson
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from gaitway.events import Anomaly
from gaitway.recording.encoding import encode
from gaitway.recording.items import Header, LinkChange, RecordedChunk, Unreadable
from gaitway.recording.lane import LaneItem
from gaitway.recording.reader import read, read_info, read_joined
from gaitway.samples import DeviceStatus, Fault, Gap, SampleBatch
from gaitway.timebase import WallAnchor

CHUNKS = 4


@pytest.fixture
def recorded(make_sink, make_batch, make_chunk, clock, tmp_path):
    """A finished recording of a few chunks, and the bodies that were written, in order."""
    sink = make_sink()
    bodies = []
    for number in range(CHUNKS):
        assert sink.ready()
        t_ns = clock.now_ns()
        some = [
            make_chunk(bytes([number] * 20)),
            make_batch(n=5, sequence=6 * number, seed=number),
            Gap(t_ns, 1, "lost"),
            Fault(t_ns, "resync", 3, "noise"),
            LinkChange(t_ns, "streaming", "samples flow"),
            DeviceStatus(t_ns, {"battery_percent": number}),
            Anomaly(t_ns=t_ns, anomaly="no-contact", detail=""),
        ]
        clock.advance(0.8)
        sink.write([LaneItem("left", body) for body in some])
        bodies += some
    sink.finish([])
    (path,) = tmp_path.iterdir()
    return path, bodies


def comparable(body):
    if isinstance(body, SampleBatch):
        values = {name: rows.tolist() for name, rows in body.channels.items()}
        return body.t_ns.tolist(), body.period_s, body.sequence, values
    return body


def of_device(path):
    return [item.body for item in read(path) if item.device == "left"]


def same(left, right):
    return [comparable(body) for body in left] == [comparable(body) for body in right]


def damages(path):
    return [item.body for item in read(path) if isinstance(item.body, Unreadable)]


def test_everything_written_is_read_back_in_order(recorded):
    path, bodies = recorded
    assert same(of_device(path), bodies)
    assert damages(path) == []


def test_a_recording_begins_with_header_and_anchor(recorded):
    path, _ = recorded
    first, second = (item.body for item, _ in zip(read(path), range(2), strict=False))
    assert first == Header({"config": '{"devices": []}', "run": "cafe01"})
    assert isinstance(second, WallAnchor)


def test_only_the_wanted_topics_are_decoded_and_the_header_always(recorded):
    path, _ = recorded
    kinds = {type(item.body) for item in read(path, leaves={"samples", "gap"})}
    assert kinds == {Header, SampleBatch, Gap}


def test_every_message_fits_the_schema_it_comes_with(recorded):
    path, bodies = recorded
    with path.open("rb") as stream:
        found = list(make_reader(stream).iter_messages())
    assert len(found) == len(bodies) + 1
    for schema, _, message in found:
        jsonschema.validate(orjson.loads(message.data), orjson.loads(schema.data))


def test_info_tells_what_is_in_it(recorded):
    path, _ = recorded
    info = read_info(path)
    assert (info.complete, info.unreadable_bytes, info.devices) == (True, 0, ("left",))
    assert info.counts["/left/samples"] == CHUNKS
    assert info.header.config == {"devices": []}
    assert info.duration_s == pytest.approx(2.4 + 0.18 + 0.04)


def test_a_file_cut_off_anywhere_gives_all_whole_chunks_and_no_exception(recorded):
    """At every byte of the data, and at every 13th of the summary behind it."""
    path, bodies = recorded
    content = path.read_bytes()
    data_end = chunk_offsets(content)[-1] + 800
    assert data_end < len(content)
    seen = set()
    for size in [*range(len(content), data_end, -13), *range(data_end, -1, -1)]:
        os.truncate(path, size)
        items = list(read(path))
        found = [item.body for item in items if item.device]
        assert len(found) % 7 == 0  # seven bodies were written to a chunk
        assert same(found, bodies[: len(found)])
        seen.add(len(found))
        lost = sum(item.body.n_bytes for item in items if isinstance(item.body, Unreadable))
        assert lost == size - last_whole_record(content, size)
    assert seen == {7 * chunks for chunks in range(CHUNKS + 1)}


def last_whole_record(content, size):
    """Where the last whole record of a cut-off file ends, by the format's definition."""
    end = 8 if size >= 8 else 0
    while end and end + 9 <= size and content[end - 8 : end] != b"" and end < len(content) - 8:
        length = int.from_bytes(content[end + 1 : end + 9], "little")
        if end + 9 + length > size:
            break
        if content[end] == 0x02:  # the footer ends the file, whatever of the magic is there
            return size
        end += 9 + length
    return end


def test_a_damaged_chunk_costs_itself_alone(recorded):
    path, bodies = recorded
    content = bytearray(path.read_bytes())
    at = chunk_offsets(content)[3]
    content[at + 100] ^= 0x10
    path.write_bytes(content)
    assert same(of_device(path), bodies[:14] + bodies[21:])
    assert ["damaged chunk" in damage.reason for damage in damages(path)] == [True]
    assert read_info(path).unreadable_bytes > 0


def chunk_offsets(content):
    offsets, at = [], 8
    while at < len(content) - 8:
        if content[at] == 0x06:
            offsets.append(at)
        at += 9 + int.from_bytes(content[at + 1 : at + 9], "little")
    return offsets


def test_zeros_at_the_end_as_some_file_systems_leave_them_are_told(recorded):
    path, bodies = recorded
    content = path.read_bytes()
    at = chunk_offsets(content)[4]
    path.write_bytes(content[:at] + bytes(5000))
    assert same(of_device(path), bodies[:21])
    assert damages(path) == [Unreadable(at, 5000, "no record begins with byte 0")]


@pytest.mark.parametrize("seed", range(60))
def test_random_damage_never_raises(recorded, seed):
    path, _ = recorded
    rng = random.Random(seed)
    content = bytearray(path.read_bytes())
    for _ in range(rng.randrange(1, 8)):
        content[rng.randrange(len(content))] = rng.randrange(256)
    path.write_bytes(content)
    list(read(path))
    read_info(path)


@pytest.mark.parametrize("content", [b"", b"t_s,accel\n1,2\n", bytes(100)])
def test_what_is_no_mcap_file_is_said_to_be_none(tmp_path, content):
    path = tmp_path / "walk.mcap"
    path.write_bytes(content)
    (damage,) = damages(path)
    assert (damage.offset, damage.n_bytes) == (0, len(content))
    assert "no MCAP file" in damage.reason


def foreign(path, topic, *payloads):
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("x", "jsonschema", b"{}")
        channel = writer.register_channel(topic, "json", schema)
        for payload in payloads:
            writer.add_message(channel, 1, payload, 1)
        writer.finish()


def test_topics_of_others_are_passed_over(tmp_path):
    path = tmp_path / "other.mcap"
    foreign(path, "/camera/image", b"{}")
    assert list(read(path)) == []


@pytest.mark.parametrize(
    "payload", [b"{}", b"nonsense", b'{"t_ns":1,"n_missing":1,"reason":"lost","more":1}', b"[]"]
)
def test_a_message_of_another_version_is_told_and_skipped(tmp_path, payload):
    path = tmp_path / "future.mcap"
    foreign(path, "/left/gap", payload)
    (item,) = read(path)
    assert isinstance(item.body, Unreadable)
    assert "of another version, or damaged" in item.body.reason


def test_a_file_still_being_written_is_read_up_to_the_last_sync(make_sink, run_for):
    sink = make_sink()
    run_for(sink, 3.0)
    found = [item.body for item in read(sink.path) if isinstance(item.body, LinkChange)]
    assert len(found) >= 12
    assert not read_info(sink.path).complete
    assert read_info(sink.path).unreadable_bytes == 0


def test_raw_bytes_come_back_as_they_went(make_sink, make_chunk, tmp_path):
    sink = make_sink()
    assert sink.ready()
    data = np.arange(1000).astype(np.uint8).tobytes()
    sink.write([LaneItem("left", make_chunk(data))])
    sink.finish([])
    (path,) = tmp_path.iterdir()
    (found,) = (item.body for item in read(path) if isinstance(item.body, RecordedChunk))
    assert zlib.crc32(found.chunk.data) == zlib.crc32(data)


def joined(path, leaves=()):
    return [item.body for item in read_joined(path, leaves) if item.device == "left"]


def write_batches(make_sink, tmp_path, batches):
    sink = make_sink()
    assert sink.ready()
    for batch in batches:  # one by one, as merging would join them before they are written
        sink.write([LaneItem("left", batch)])
    sink.finish([])
    (path,) = tmp_path.iterdir()
    return path


def test_joined_batches_hold_every_sample_and_end_at_every_hole(make_sink, make_batch, tmp_path):
    batches = [make_batch(n=5, sequence=first, seed=first) for first in (0, 5, 10, 17, 22)]
    path = write_batches(make_sink, tmp_path, batches)
    found = joined(path)
    assert [(body.sequence, len(body)) for body in found] == [(0, 15), (17, 10)]
    assert np.concatenate([body.t_ns for body in found]).tolist() == [
        t_ns for batch in batches for t_ns in batch.t_ns.tolist()
    ]
    for name, values in batches[0].channels.items():
        whole = np.concatenate([batch.channels[name] for batch in batches])
        assert np.array_equal(np.concatenate([body.channels[name] for body in found]), whole)
        assert found[0].channels[name].shape[1] == values.shape[1]


def test_samples_on_both_sides_of_another_item_are_not_joined(recorded):
    path, bodies = recorded
    wanted = [body for body in bodies if isinstance(body, SampleBatch | Gap)]
    assert same(joined(path, {"gap"}), wanted)


def test_a_value_that_is_no_number_or_other_channels_end_a_joined_batch(
    make_sink, make_batch, tmp_path
):
    batches = [make_batch(n=2, sequence=first) for first in (0, 2, 4, 6)]
    odd = {name: values.copy() for name, values in batches[1].channels.items()}
    next(iter(odd.values()))[0, 0] = np.nan
    batches[1] = SampleBatch(batches[1].t_ns, batches[1].period_s, 2, odd)
    few = dict(list(batches[3].channels.items())[:1])
    batches[3] = SampleBatch(batches[3].t_ns, batches[3].period_s, 6, few)
    found = joined(write_batches(make_sink, tmp_path, batches))
    assert sum(map(len, found)) == 8
    assert sum(int(np.isnan(v).sum()) for body in found for v in body.channels.values()) == 1
    assert set(found[-1].channels) == set(few)


@pytest.mark.parametrize("change", ["shorter", "odd columns"])
def test_a_damaged_message_costs_itself_alone_among_joined_ones(make_batch, tmp_path, change):
    messages = [encode(make_batch(n=2, sequence=first)) for first in (0, 2, 4)]
    fields = orjson.loads(messages[1])
    if change == "shorter":
        fields["accel_x_mps2"].pop()
    else:
        del fields["accel_y_mps2"]
    messages[1] = orjson.dumps(fields)
    path = tmp_path / "damaged.mcap"
    foreign(path, "/left/samples", *messages)
    found = joined(path)
    assert [type(body) for body in found] == [SampleBatch, Unreadable, SampleBatch]
    assert [body.sequence for body in found if isinstance(body, SampleBatch)] == [0, 4]
