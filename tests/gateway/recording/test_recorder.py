import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from gaitway.events import Anomaly
from gaitway.recording import recording_file
from gaitway.recording.items import Dropped, LinkChange, RecordedChunk, Unreadable
from gaitway.recording.reader import read, read_info
from gaitway.recording.recorder import Recorder
from gaitway.samples import DeviceStatus, Fault, Gap, SampleBatch
from gaitway.testing.clocks import ManualClock
from gaitway.timebase import NS_PER_S, HostClock

DEADLINE_S = 20.0


def wait_until(condition):
    end_s = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < end_s, "did not happen in time"
        time.sleep(0.01)


@pytest.fixture
def make_recorder(params):
    made = []

    def make(clock=None, **bounds):
        recorder = Recorder(
            params, clock or HostClock(), ["left"], {"run": "cafe"}, "cafe", **bounds
        )
        made.append(recorder)
        return recorder

    yield make
    for recorder in made:
        if recorder.healthy:
            assert recorder.close(DEADLINE_S)


@pytest.fixture
def hanging_disk(monkeypatch):
    """A disk that hangs while the event is clear; set again when the test ends."""
    free, real_fsync = threading.Event(), os.fsync
    free.set()

    def fsync(descriptor):
        free.wait()
        real_fsync(descriptor)

    monkeypatch.setattr(recording_file.os, "fsync", fsync)
    yield free
    free.set()


def bodies(directory):
    return [item.body for path in sorted(directory.iterdir()) for item in read(path)]


def test_every_method_records_what_it_is_given(make_recorder, tmp_path, clock, make_batch):
    recorder = make_recorder()
    recorder.start()
    batch = make_batch()
    status, event = DeviceStatus(4, {"a": 1}), Anomaly(t_ns=5, anomaly="x", detail="y")
    recorder.record_link("left", 1, "syncing", "open")
    recorder.record_chunk("left", 2, b"\x01", "rx")
    recorder.record_chunk("left", 2, b"\x02", "tx")
    recorder.record_samples("left", batch)
    recorder.record_samples("right", batch[2:])  # holds none
    recorder.record_gap("left", Gap(3, 1, "lost"))
    recorder.record_fault("left", Fault(3, "resync", 1))
    recorder.record_device_status("left", status)
    recorder.record_event("left", event)
    assert recorder.close(DEADLINE_S)
    assert recorder.dropped == 0
    found = bodies(tmp_path)[2:]
    samples = found.pop(3)
    assert [(type(body), getattr(body, "direction", None)) for body in found[:3]] == [
        (LinkChange, None),
        (RecordedChunk, "rx"),
        (RecordedChunk, "tx"),
    ]
    assert found[3:] == [Gap(3, 1, "lost"), Fault(3, "resync", 1), status, event]
    assert np.array_equal(samples.channels["gyro"], batch.channels["gyro"])


def test_the_recorder_is_off_on_and_off_again(make_recorder):
    recorder = make_recorder()
    assert (recorder.state, recorder.healthy, recorder.path) == ("off", False, None)
    recorder.start()
    wait_until(lambda: recorder.state == "on")
    assert recorder.path.name.endswith("-cafe-0.mcap.active")
    recorder.close(DEADLINE_S)
    assert (recorder.state, recorder.healthy, recorder.path) == ("off", False, None)


def test_no_thread_is_left_after_close(make_recorder):
    before = threading.active_count()
    recorder = make_recorder()
    recorder.start()
    assert "gaitway-recorder" in [thread.name for thread in threading.enumerate()]
    recorder.close(DEADLINE_S)
    assert threading.active_count() == before


def test_what_comes_after_close_is_counted_as_dropped(make_recorder):
    recorder = make_recorder()
    recorder.start()
    recorder.close(DEADLINE_S)
    recorder.record_link("left", 1, "closed", "")
    assert recorder.dropped == 1
    assert recorder.dropped_by_topic == {"/left/link": 1}


def test_recording_never_blocks_on_a_disk_that_hangs_and_tells_what_it_dropped(
    make_recorder, hanging_disk, tmp_path
):
    recorder = make_recorder(max_items=100)
    recorder.start()
    wait_until(lambda: recorder.state == "on")
    hanging_disk.clear()
    number = 0
    while recorder.dropped < 50:
        recorder.record_link("left", number, "opening", str(number))
        number += 1
        if number % 100 == 0:
            time.sleep(0.01)
        assert number < 10**6
    dropped = recorder.dropped
    hanging_disk.set()
    wait_until(lambda: recorder._lane._items == [])
    recorder.record_link("left", number, "opening", str(number))
    number += 1
    assert recorder.close(DEADLINE_S)
    found = bodies(tmp_path)
    written = [int(body.reason) for body in found if isinstance(body, LinkChange)]
    (told,) = (body for body in found if isinstance(body, Dropped))
    assert told.counts == {"/left/link": dropped}
    assert len(written) + dropped == number
    assert written == sorted(written)


def test_close_returns_in_time_when_the_disk_hangs(make_recorder, hanging_disk):
    recorder = make_recorder()
    recorder.start()
    wait_until(lambda: recorder.state == "on")
    hanging_disk.clear()
    recorder.record_link("left", 1, "opening", "")
    begun_s = time.monotonic()
    assert not recorder.close(0.3)
    assert time.monotonic() - begun_s < 2.0
    hanging_disk.set()


def test_a_fault_in_the_writer_costs_no_thread_and_is_counted(make_recorder, monkeypatch):
    clock = ManualClock()
    recorder = make_recorder(clock)

    def wrong(*_):
        raise RuntimeError("a bug")

    with monkeypatch.context() as broken:
        broken.setattr(recording_file.RecordingFile, "write", wrong)
        recorder.start()
        wait_until(lambda: recorder.state == "paused")
    recorder.record_link("left", 1, "opening", "")
    assert "a bug" in recorder.state_reason
    assert recorder.healthy
    clock.advance(5.0)
    wait_until(lambda: recorder.state == "on")


def test_threads_may_record_at_once_and_nothing_is_lost(make_recorder, tmp_path):
    recorder = make_recorder()
    recorder.start()

    def work(name):
        for number in range(500):
            recorder.record_link(name, number, "opening", str(number))

    threads = [threading.Thread(target=work, args=(name,)) for name in ("left", "right", "other")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert recorder.close(DEADLINE_S)
    (path,) = tmp_path.iterdir()
    assert read_info(path).counts["/other/link"] == 500
    assert [
        int(item.body.reason) for item in read(path, {"link"}) if item.device == "left"
    ] == list(range(500))


CHILD = """
import sys, time
from pathlib import Path
import numpy as np
from gaitway.recording.params import RecordingParams
from gaitway.recording.recorder import Recorder
from gaitway.samples import SampleBatch
from gaitway.timebase import HostClock
params = RecordingParams(directory=Path(sys.argv[1]), min_free_gb=0.0, max_file_s=1.5)
recorder = Recorder(params, HostClock(), ["left"], {}, "cafe")
recorder.start()
sequence = 0
while True:
    t_ns = time.monotonic_ns()
    recorder.record_chunk("left", t_ns, sequence.to_bytes(4, "big"), "rx")
    rows = np.full((1, 3), float(sequence))
    recorder.record_samples("left", SampleBatch(np.array([t_ns]), 0.01, sequence, {"accel": rows}))
    sequence += 1
    print(sequence, flush=True)
    time.sleep(0.01)
"""


@pytest.mark.parametrize("seed", range(3))
def test_killed_at_any_moment_everything_older_than_a_second_is_there(tmp_path, seed):
    with subprocess.Popen(
        [sys.executable, "-c", CHILD, str(tmp_path)], stdout=subprocess.PIPE
    ) as child:
        child.stdout.readline()
        time.sleep(random.Random(seed).uniform(1.2, 3.2))
        killed_ns = time.monotonic_ns()
        child.send_signal(signal.SIGKILL)
        child.wait()
    items = [item for path in sorted(tmp_path.iterdir()) for item in read(path)]
    chunks = [item.body.chunk for item in items if isinstance(item.body, RecordedChunk)]
    numbers = [int.from_bytes(chunk.data, "big") for chunk in chunks]
    samples = [item.body for item in items if isinstance(item.body, SampleBatch)]
    assert numbers == list(range(len(numbers)))
    assert killed_ns - chunks[-1].t_ns < NS_PER_S
    assert np.concatenate([batch.channels["accel"][:, 0] for batch in samples]).tolist() == numbers
    assert not any(isinstance(item.body, Unreadable) for item in items)


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 24 MB of its own, for those who may mount one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=24m", "tmpfs", str(disk)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("needs the right to mount a tmpfs")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


def test_a_disk_that_fills_up_pauses_recording_and_room_brings_it_back(params, small_disk):
    clock = ManualClock()
    recorder = Recorder(
        params.model_copy(update={"directory": small_disk / "recordings"}),
        clock,
        ["left"],
        {},
        "cafe",
    )
    recorder.start()
    number = 0

    def record_some():
        nonlocal number
        clock.advance(0.8)
        recorder.record_link("left", clock.now_ns(), "opening", str(number))
        number += 1
        time.sleep(0.02)
        return recorder.state

    try:
        wait_until(lambda: record_some() == "on")
        fill(small_disk / "others")
        wait_until(
            lambda: (
                recorder.record_chunk("left", 1, os.urandom(10_000), "rx")
                or record_some() == "paused"
            )
        )
        assert "No space left" in recorder.state_reason
        assert recorder.healthy
        (small_disk / "others").unlink()
        wait_until(lambda: record_some() == "on")
    finally:
        assert recorder.close(DEADLINE_S)
    found = bodies(small_disk / "recordings")
    written = [int(body.reason) for body in found if isinstance(body, LinkChange)]
    assert written == list(range(number))
    assert recorder.dropped == 0


def fill(path: Path):
    with path.open("wb") as stream:
        try:
            while True:
                stream.write(bytes(100_000))
                stream.flush()
        except OSError:
            pass
