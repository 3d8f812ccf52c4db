import errno
import os

import pytest
from mcap.reader import make_reader

from gaitway.events import Event
from gaitway.recording import recording_file, retention
from gaitway.recording.items import Dropped, LinkChange, Unreadable
from gaitway.recording.lane import LaneItem
from gaitway.recording.reader import read, read_info
from gaitway.samples import DeviceStatus
from gaitway.timebase import NS_PER_S


def files(directory):
    return sorted(path.name for path in directory.iterdir())


def in_order(directory):
    def run_and_number(path):
        _, run, number = path.name.split(".")[0].split("-")
        return run, int(number)

    return sorted(directory.iterdir(), key=run_and_number)


def numbers(path):
    return [int(item.body.reason) for item in read(path) if isinstance(item.body, LinkChange)]


def all_numbers(directory):
    return [number for path in in_order(directory) for number in numbers(path)]


def fail(error):
    def refuse(*_):
        raise OSError(error, os.strerror(error))

    return refuse


def test_a_file_is_named_by_utc_run_and_number_and_active_while_written(
    make_sink, run_for, tmp_path
):
    sink = make_sink()
    run_for(sink, 1.0)
    assert sink.path.name == "20260101T000000Z-cafe01-0.mcap.active"
    sink.finish([])
    assert files(tmp_path) == ["20260101T000000Z-cafe01-0.mcap"]
    assert sink.path is None


def test_state_is_off_then_on_then_off(make_sink, run_for):
    sink = make_sink()
    assert sink.status[0] == "off"
    run_for(sink, 0.2)
    assert sink.status == ("on", "")
    sink.finish([])
    assert sink.status[0] == "off"


def test_a_finished_file_is_indexed_and_read_by_the_mcap_package(make_sink, run_for, tmp_path):
    sink = make_sink()
    count = run_for(sink, 3.0)
    sink.finish([])
    (path,) = tmp_path.iterdir()
    with path.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary.statistics.message_count == count + 1
        assert len(summary.chunk_indexes) >= 3
        found = [
            (schema.encoding, channel.message_encoding, message.publish_time - message.log_time)
            for schema, channel, message in reader.iter_messages(topics=["/left/link"])
        ]
        assert found == [("jsonschema", "json", 0)] * count


def test_log_time_is_wall_clock_time_by_the_anchor_of_the_file(make_sink, clock, tmp_path):
    sink = make_sink()
    assert sink.ready()
    clock.advance(1.5)
    sink.write([LaneItem("left", LinkChange(clock.now_ns(), "opening", ""))])
    sink.finish([])
    (path,) = tmp_path.iterdir()
    with path.open("rb") as stream:
        (found,) = make_reader(stream).iter_messages(topics=["/left/link"])
    assert found[2].log_time == clock.wall_ns()


@pytest.mark.parametrize("t_ns", [-(2**62), 0, 2**64])
def test_an_impossible_time_costs_nothing_else(make_sink, t_ns, tmp_path):
    sink = make_sink()
    assert sink.ready()
    sink.write([LaneItem("left", LinkChange(t_ns, "opening", "0"))])
    sink.finish([])
    assert all_numbers(tmp_path) == ([0] if t_ns < 2**64 else [])


def test_topics_have_the_same_ids_in_every_file_even_one_that_came_late(
    make_sink, run_for, clock, tmp_path
):
    sink = make_sink(max_file_s=2.0)
    run_for(sink, 1.0)
    sink.write([LaneItem("late", LinkChange(clock.now_ns(), "opening", "0"))])
    run_for(sink, 4.0)
    sink.finish([])
    ids = []
    for path in in_order(tmp_path):
        with path.open("rb") as stream:
            channels = make_reader(stream).get_summary().channels
        ids.append({channel.topic: number for number, channel in channels.items()})
    assert len(ids) >= 2
    assert "/late/link" in ids[0]
    assert all(found == ids[0] for found in ids)


def test_a_new_file_begins_after_max_file_s_and_nothing_is_lost_between(
    make_sink, run_for, tmp_path
):
    sink = make_sink(max_file_s=10.0)
    count = run_for(sink, 35.0)
    sink.finish([])
    assert len(files(tmp_path)) == 4
    assert all_numbers(tmp_path) == list(range(count))


def test_a_new_file_begins_at_max_file_mb(make_sink, clock, tmp_path):
    sink = make_sink(max_file_mb=0.1)
    rng = os.urandom
    for _ in range(40):
        clock.advance(0.8)
        assert sink.ready()
        status = DeviceStatus(clock.now_ns(), {"serial": rng(10_000).hex()})
        sink.write([LaneItem("left", status)])
    sink.finish([])
    sizes = [path.stat().st_size for path in in_order(tmp_path)]
    assert 4 <= len(sizes) <= 6
    assert max(sizes) < 140_000  # one more item and the schemas


def test_an_idle_recording_leaves_the_disk_alone_and_begins_no_files(
    make_sink, clock, tmp_path, monkeypatch
):
    sink = make_sink(max_file_s=2.0)
    assert sink.ready()
    size = sink.path.stat().st_size
    synced = []
    with monkeypatch.context() as counted:
        counted.setattr(recording_file.os, "fsync", synced.append)
        for _ in range(50):
            clock.advance(1.0)
            sink.write([])
    assert synced == []
    assert [path.stat().st_size for path in tmp_path.iterdir()] == [size]


@pytest.mark.parametrize("step_s", [-3600.0, -0.6, 0.6, 1e6])
def test_a_step_of_the_wall_clock_begins_a_file_with_an_anchor_of_its_own(
    make_sink, run_for, clock, tmp_path, step_s
):
    sink = make_sink()
    number = run_for(sink, 3.0)
    clock.step_wall(step_s)
    run_for(sink, 3.0, number)
    sink.finish([])
    before, after = (read_info(path).anchor for path in in_order(tmp_path))
    shift_ns = after.to_wall_ns(0) - before.to_wall_ns(0)
    assert shift_ns == round(step_s * NS_PER_S)


def test_a_slow_drift_of_the_wall_clock_below_half_a_second_begins_no_file(
    make_sink, run_for, clock, tmp_path
):
    sink = make_sink()
    number = run_for(sink, 2.0)
    clock.step_wall(0.4)
    run_for(sink, 2.0, number)
    sink.finish([])
    assert len(files(tmp_path)) == 1


def test_what_reached_the_disk_by_fsync_is_never_older_than_a_second(
    make_sink, run_for, clock, tmp_path, monkeypatch
):
    """A power cut leaves no more than was synced: cut the file there, at every moment."""
    synced = {}
    real_fsync = os.fsync

    def fsync(descriptor):
        real_fsync(descriptor)
        synced[os.fstat(descriptor).st_ino] = os.fstat(descriptor).st_size

    monkeypatch.setattr(recording_file.os, "fsync", fsync)
    sink = make_sink()
    number, born = 0, []
    for _ in range(40):
        born.append(clock.now_ns() + 200_000_000)
        number = run_for(sink, 0.2, number)
        clock.advance(0.199)  # up to the moment before the next pass
        cut = tmp_path / "cut"
        cut.write_bytes(sink.path.read_bytes()[: synced[sink.path.stat().st_ino]])
        old = [index for index, t_ns in enumerate(born) if clock.now_ns() - t_ns > NS_PER_S]
        assert numbers(cut)[: len(old)] == old
        clock.advance(-0.199)


def test_definitions_and_anchor_are_on_the_disk_at_once(make_sink, tmp_path):
    assert make_sink().ready()
    (path,) = tmp_path.iterdir()
    info = read_info(path)
    assert info.counts == {"/gateway/anchor": 1}
    assert (info.header.entries["run"], info.complete, info.unreadable_bytes) == (
        "cafe01",
        False,
        0,
    )


@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EIO, errno.EROFS])
def test_a_disk_that_refuses_pauses_and_one_that_comes_back_has_lost_nothing(
    make_sink, run_for, tmp_path, monkeypatch, error, lost
):
    sink = make_sink()
    waiting = []
    number = run_for(sink, 3.0, 0, waiting)
    with monkeypatch.context() as broken:
        broken.setattr(recording_file.os, "fsync", fail(error))
        number = run_for(sink, 12.0, number, waiting)
        assert sink.status[0] == "paused"
        assert os.strerror(error) in sink.status[1]
    number = run_for(sink, 8.0, number, waiting)
    assert sink.status == ("on", "")
    sink.finish([])
    assert all_numbers(tmp_path) == list(range(number))
    assert lost == {}


def test_a_paused_recording_leaves_no_litter_however_long(
    make_sink, run_for, tmp_path, monkeypatch
):
    sink = make_sink()
    number = run_for(sink, 3.0)
    monkeypatch.setattr(recording_file.os, "fsync", fail(errno.ENOSPC))
    run_for(sink, 120.0, number)
    assert files(tmp_path) == ["20260101T000000Z-cafe01-0.mcap.active"]


def test_a_folder_that_cannot_be_made_pauses_with_its_reason(make_sink, tmp_path):
    (tmp_path / "file").write_text("")
    sink = make_sink(directory=tmp_path / "file" / "recordings")
    assert not sink.ready()
    assert sink.status[0] == "paused"
    assert "file" in sink.status[1]


def test_the_first_refusal_is_a_warning_and_the_next_are_not(
    make_sink, run_for, monkeypatch, caplog
):
    sink = make_sink()
    monkeypatch.setattr(recording_file.os, "fsync", fail(errno.ENOSPC))
    run_for(sink, 30.0)
    warnings = [record for record in caplog.records if record.levelname == "WARNING"]
    assert len(warnings) == 1


def test_what_a_dead_disk_never_took_is_counted_at_the_end(make_sink, run_for, monkeypatch, lost):
    sink = make_sink()
    run_for(sink, 0.6)  # not synced yet
    monkeypatch.setattr(recording_file.os, "fsync", fail(errno.EIO))
    sink.finish([LaneItem("left", LinkChange(1, "opening", ""))])
    assert lost == {"/left/link": 4}
    assert sink.status[0] == "off"


def test_what_waited_for_a_disk_that_never_came_is_counted_at_the_end(make_sink, tmp_path, lost):
    (tmp_path / "file").write_text("")
    sink = make_sink(directory=tmp_path / "file" / "recordings")
    sink.finish([LaneItem("left", LinkChange(1, "opening", ""))])
    assert lost == {"/left/link": 1}


def test_a_recording_begins_only_with_some_room_above_the_reserve(make_sink, monkeypatch):
    """Else it would end at once, again and again."""
    monkeypatch.setattr(retention, "free_bytes", lambda _: 2.005e9)
    assert not make_sink(min_free_gb=2.0).ready()
    monkeypatch.setattr(retention, "free_bytes", lambda _: 2.02e9)
    assert make_sink(min_free_gb=2.0).ready()


def test_too_little_free_disk_pauses_and_ends_the_file_properly(
    make_sink, run_for, tmp_path, monkeypatch
):
    sink = make_sink(min_free_gb=2.0)
    monkeypatch.setattr(retention, "free_bytes", lambda _: 3e9)
    number = run_for(sink, 3.0)
    monkeypatch.setattr(retention, "free_bytes", lambda _: 1.9e9)
    number = run_for(sink, 1.0, number)
    assert sink.status[0] == "paused"
    assert "min_free_gb = 2" in sink.status[1]
    (path,) = tmp_path.iterdir()
    assert read_info(path).complete
    monkeypatch.setattr(retention, "free_bytes", lambda _: 3e9)
    run_for(sink, 6.0, number)
    assert sink.status == ("on", "")


def test_an_old_recording_is_deleted_rather_than_recording_paused(
    make_sink, run_for, tmp_path, monkeypatch
):
    old = tmp_path / "20250101T000000Z-beef-0.mcap"
    old.write_bytes(b"old")
    monkeypatch.setattr(retention, "free_bytes", lambda _: 1.9e9 if old.exists() else 2.1e9)
    sink = make_sink(min_free_gb=2.0)
    run_for(sink, 1.0)
    assert sink.status == ("on", "")
    assert not old.exists()


def test_what_cannot_be_written_as_json_costs_itself_and_is_told(make_sink, clock, tmp_path, lost):
    sink = make_sink()
    assert sink.ready()
    good = DeviceStatus(clock.now_ns(), {"battery_percent": 80})
    bad = DeviceStatus(clock.now_ns(), {"battery_percent": object()})
    sink.write([LaneItem("left", body) for body in (good, bad, good)])
    sink.finish([])
    (path,) = tmp_path.iterdir()
    bodies = [item.body for item in read(path)]
    assert [body for body in bodies if isinstance(body, DeviceStatus)] == [good, good]
    (told,) = (body for body in bodies if isinstance(body, Dropped))
    assert told.counts == lost == {"/left/device": 1}


def test_what_cannot_be_written_is_a_warning_once(make_sink, lost, caplog):
    sink = make_sink()
    assert sink.ready()
    sink.write([LaneItem("left", DeviceStatus(1, {"a": object()}))] * 5)
    assert lost == {"/left/device": 5}
    assert [record.levelname for record in caplog.records].count("WARNING") == 1


def test_an_event_of_unknown_kind_costs_itself(make_sink, tmp_path, lost):
    class Strange(Event):
        kind = "strange"

    sink = make_sink()
    assert sink.ready()
    sink.write([LaneItem("left", Strange(t_ns=1))])
    sink.finish([])
    assert lost == {"/left/strange": 1}
    (path,) = tmp_path.iterdir()
    assert not any(isinstance(item.body, Unreadable) for item in read(path))


def test_after_a_fault_of_the_program_a_new_file_begins_and_the_loss_is_counted(
    make_sink, run_for, clock, tmp_path, lost
):
    sink = make_sink()
    number = run_for(sink, 0.4)
    sink.fail(RuntimeError("a bug"))
    assert sink.status[0] == "paused"
    assert "a bug" in sink.status[1]
    clock.advance(5.0)
    run_for(sink, 1.0, number)
    sink.finish([])
    assert lost == {"/left/link": 2}
    assert all_numbers(tmp_path) == [2, 3, 4, 5, 6]


@pytest.fixture
def leftover(make_sink, run_for):
    """What a run left behind that ended without closing its file; the numbers in it."""
    earlier = make_sink(run="aaaa")
    run_for(earlier, 4.0)
    held = numbers(earlier.path)
    earlier._file.abandon()
    earlier._file = None
    assert len(held) > 10
    return held


def test_a_leftover_of_an_earlier_run_is_recovered_when_recording_begins(
    make_sink, run_for, tmp_path, leftover
):
    sink = make_sink(run="bbbb")
    run_for(sink, 1.0)
    sink.finish([])
    first, second = files(tmp_path)
    assert first.endswith("-aaaa-0.mcap")
    assert second.endswith("-bbbb-0.mcap")
    assert numbers(tmp_path / first) == leftover


def test_the_file_being_written_is_no_leftover_even_without_locks(
    make_sink, run_for, tmp_path, leftover, monkeypatch
):
    monkeypatch.setattr(recording_file.fcntl, "flock", fail(errno.ENOLCK))
    sink = make_sink(run="bbbb")
    count = run_for(sink, 1.0)
    assert [name.split("-")[1:] for name in files(tmp_path)] == [
        ["aaaa", "0.mcap"],
        ["bbbb", "0.mcap.active"],
    ]
    sink.finish([])
    assert numbers(in_order(tmp_path)[-1]) == list(range(count))
