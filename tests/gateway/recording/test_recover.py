import fcntl
import os
import random
import zlib

import pytest
from mcap.reader import make_reader

from gaitway.recording import recover as recover_module
from gaitway.recording.items import LinkChange, Unreadable
from gaitway.recording.reader import read, read_info
from gaitway.recording.recover import recover


@pytest.fixture
def leftover(make_sink, run_for, tmp_path):
    """A file as a power cut leaves it behind: written for eight seconds, not ended."""
    sink = make_sink()
    run_for(sink, 8.0)
    path = sink.path
    content = path.read_bytes()
    sink._file.abandon()
    sink._file = None
    path.write_bytes(content)
    return path


def numbers(path):
    return [int(item.body.reason) for item in read(path) if isinstance(item.body, LinkChange)]


def indexed_numbers(path):
    with path.open("rb") as stream:
        found = make_reader(stream, validate_crcs=True).iter_messages(topics=["/left/link"])
        return [int(message.data.split(b'"')[-2]) for _, _, message in found]


def names(directory):
    return sorted(path.name for path in directory.iterdir())


def test_a_leftover_becomes_a_whole_file_with_all_its_messages(leftover, tmp_path):
    before = numbers(leftover)
    (recovered,) = recover(tmp_path)
    assert names(tmp_path) == [leftover.name.removesuffix(".active")]
    assert numbers(recovered.path) == before
    assert read_info(recovered.path).complete
    assert (recovered.messages, recovered.lost_bytes) == (len(before) + 1, 0)


def test_a_recovered_file_is_indexed_as_if_it_had_been_ended(leftover, tmp_path):
    before = numbers(leftover)
    (recovered,) = recover(tmp_path)
    assert indexed_numbers(recovered.path) == before
    with recovered.path.open("rb") as stream:
        reader = make_reader(stream)
        statistics = reader.get_summary().statistics
        assert statistics.message_count == len(before) + 1
        assert statistics.message_start_time < statistics.message_end_time
        assert [record.name for record in reader.iter_metadata()] == ["gaitway", "anchor"]


@pytest.mark.parametrize("seed", range(40))
def test_a_leftover_cut_anywhere_gives_what_could_be_read_of_it(leftover, tmp_path, seed):
    os.truncate(leftover, random.Random(seed).randrange(leftover.stat().st_size))
    before = numbers(leftover)
    size = leftover.stat().st_size
    (recovered,) = recover(tmp_path)
    if recovered.messages:
        assert indexed_numbers(recovered.path) == numbers(recovered.path) == before
        assert recovered.lost_bytes < size
    else:
        assert before == []
        assert recovered.path.name == leftover.name.replace(".active", ".broken")


@pytest.mark.parametrize("seed", range(80))
def test_a_damaged_leftover_gives_a_file_without_damage(leftover, tmp_path, seed):
    rng = random.Random(seed)
    content = bytearray(leftover.read_bytes())
    content[rng.randrange(8, len(content))] ^= 1 << rng.randrange(8)
    leftover.write_bytes(content)
    before = numbers(leftover)
    (recovered,) = recover(tmp_path)
    assert numbers(recovered.path) == before
    if recovered.messages:
        assert indexed_numbers(recovered.path) == before
        assert not any(isinstance(item.body, Unreadable) for item in read(recovered.path))


CHUNK_HEADER = range(9, 33)
"""Of a chunk record: two times and the size of what is packed; no checksum covers them."""


@pytest.mark.parametrize("byte", CHUNK_HEADER)
def test_a_damaged_chunk_header_is_made_anew_from_the_chunk(leftover, tmp_path, byte):
    expected = numbers(leftover)
    content = bytearray(leftover.read_bytes())
    sizes = [int.from_bytes(content[at + 25 : at + 33], "little") for at in chunk_offsets(content)]
    content[chunk_offsets(content)[2] + byte] ^= 0x55
    leftover.write_bytes(content)
    (recovered,) = recover(tmp_path)
    assert numbers(recovered.path) == indexed_numbers(recovered.path) == expected
    with recovered.path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert [index.uncompressed_size for index in summary.chunk_indexes] == sizes
    times_ns = [index.message_start_time for index in summary.chunk_indexes]
    assert times_ns == sorted(times_ns)
    assert times_ns[-1] < summary.statistics.message_end_time < times_ns[0] + 10 * 10**9


def chunk_offsets(content):
    offsets, at = [], 8
    while at + 9 <= len(content):
        if content[at] == 0x06:
            offsets.append(at)
        at += 9 + int.from_bytes(content[at + 1 : at + 9], "little")
    return offsets


def test_the_checksum_of_the_summary_is_that_of_the_format(leftover, make_sink, run_for, tmp_path):
    """Checked against a file that the mcap package has ended itself."""
    recover(tmp_path)
    sink = make_sink(run="bbbb")
    run_for(sink, 1.0)
    sink.finish([])
    for path in tmp_path.iterdir():
        content = path.read_bytes()
        footer = len(content) - 8 - 20
        summary_start = int.from_bytes(content[footer : footer + 8], "little")
        stored = int.from_bytes(content[-12:-8], "little")
        assert zlib.crc32(content[summary_start:-12]) == stored


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", bytes(300)])
def test_a_leftover_without_a_message_is_kept_as_broken(tmp_path, content):
    path = tmp_path / "20260101T000000Z-cafe-0.mcap.active"
    path.write_bytes(content)
    (recovered,) = recover(tmp_path)
    assert names(tmp_path) == ["20260101T000000Z-cafe-0.mcap.broken"]
    assert recovered.path.read_bytes() == content
    assert recovered.messages == 0


def test_a_recovered_file_keeps_its_time_so_that_retention_sees_its_age(leftover, tmp_path):
    os.utime(leftover, ns=(10**18, 10**18))
    (recovered,) = recover(tmp_path)
    assert recovered.path.stat().st_mtime_ns == 10**18


def test_a_file_that_another_process_writes_is_left_alone(leftover, tmp_path):
    with leftover.open("rb") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        assert recover(tmp_path) == []
    assert leftover.exists()


def test_a_file_being_written_by_this_process_is_left_alone(make_sink, run_for, tmp_path):
    sink = make_sink()
    run_for(sink, 2.0)
    assert recover(tmp_path) == []
    assert recover(tmp_path, skip=sink.path) == []


def test_without_room_for_a_copy_the_leftover_waits(leftover, tmp_path, monkeypatch):
    monkeypatch.setattr(recover_module, "free_bytes", lambda _: 100)
    (recovered,) = recover(tmp_path)
    assert recovered.path == recovered.source == leftover
    assert "no room" in str(recovered)
    assert names(tmp_path) == [leftover.name]


def test_when_the_disk_fails_meanwhile_the_leftover_is_untouched(leftover, tmp_path, monkeypatch):
    def refuse(_):
        raise OSError(28, "No space left on device")

    content = leftover.read_bytes()
    monkeypatch.setattr(recover_module.os, "fsync", refuse)
    (recovered,) = recover(tmp_path)
    assert recovered.path == leftover
    assert "No space left" in str(recovered)
    assert names(tmp_path) == [leftover.name]
    assert leftover.read_bytes() == content


def test_a_recovery_that_was_interrupted_is_done_again(leftover, tmp_path):
    before = numbers(leftover)
    (tmp_path / leftover.name.replace(".active", "")).write_bytes(b"half")
    (tmp_path / leftover.name.replace(".active", ".recovering")).write_bytes(b"half")
    (recovered,) = recover(tmp_path)
    assert numbers(recovered.path) == before
    assert len(names(tmp_path)) == 1


def test_an_ended_file_that_only_lacks_its_name_is_taken_over_whole(leftover, tmp_path):
    (recovered,) = recover(tmp_path)
    content = recovered.path.read_bytes()
    recovered.path.rename(leftover)
    (again,) = recover(tmp_path)
    assert again.path.read_bytes() == content


def test_every_leftover_is_recovered_and_told(leftover, tmp_path):
    other = leftover.with_name("20250101T000000Z-beef-7.mcap.active")
    other.write_bytes(leftover.read_bytes()[:-10])
    told = [str(recovered) for recovered in recover(tmp_path)]
    assert len(told) == 2
    assert "cut off within a record" in told[0]
    assert "0 bytes lost" in told[1]


def test_no_folder_is_nothing_to_recover(tmp_path):
    assert recover(tmp_path / "none") == []
