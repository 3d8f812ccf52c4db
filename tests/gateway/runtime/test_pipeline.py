"""The path from bytes to events, with a codec and estimators of a few lines."""

import logging
from pathlib import Path

import numpy as np
import pytest

from gaitway.config.load import ResolvedDevice
from gaitway.config.schema import DeviceConfig
from gaitway.contracts import CodecType, DeviceType, TransportType
from gaitway.estimation import Saveable
from gaitway.events import Anomaly
from gaitway.mounting import rotation_from_mounting
from gaitway.params import Params
from gaitway.recording.encoding import decode, encode
from gaitway.recording.items import Resumed
from gaitway.runtime.checkpoint import Checkpoint
from gaitway.runtime.pipeline import Pipeline
from gaitway.samples import (
    ACCEL,
    GYRO,
    Chunk,
    Command,
    DeviceBatch,
    Fault,
    Gap,
    HandshakeFailed,
    SampleBatch,
    frozen_rows,
)

MOUNTING = {"x": "up", "y": "right", "z": "forward"}
PERIOD_NS = 10_000_000


class ByteCodec:
    """Each byte is the number of a sample; 255 is noise, 254 makes the handshake fail."""

    def start(self, t_ns):
        return [Command(b"go")]

    def feed(self, chunk):
        items = []
        for byte in chunk.data:
            if byte == 255:
                items.append(Fault(chunk.t_ns, "resync", 1))
            elif byte == 254:
                items.append(HandshakeFailed(chunk.t_ns, "no answer"))
            else:
                device_ns = np.array([byte * PERIOD_NS], dtype=np.int64)
                channels = {"accel": frozen_rows([[9.8, 0.0, float(byte)]], 3)}
                items.append(DeviceBatch(chunk.t_ns, device_ns, 0.01, channels))
        return items

    def on_time(self, t_ns):
        return []

    def finish(self):
        return []


class Echo:
    """An estimator that says what it was given."""

    look_ahead_s = 0.5

    def update(self, item):
        if isinstance(item, Gap):
            return [Anomaly(t_ns=item.t_ns, anomaly="gap", detail=str(item.n_missing))]
        text = str(item.channels["accel"].tolist())
        return [Anomaly(t_ns=int(item.t_ns[0]), anomaly="sample", detail=text)]

    def finish(self):
        return [Anomaly(t_ns=0, anomaly="end", detail="")]


class Failing(Echo):
    """An estimator that can stand only sample 4."""

    def update(self, item):
        if isinstance(item, SampleBatch) and item.channels["accel"][0, 0] != 4:
            raise ZeroDivisionError("not 4")
        return []


class Outlet:
    def __init__(self):
        self.told = []

    def __getattr__(self, name):
        return lambda device, *items: self.told.append((name, *items))

    def events(self):
        return [items[0] for name, *items in self.told if name == "event"]

    def names(self):
        return [name for name, *_ in self.told]


def pipeline(estimator=Echo, requires=(ACCEL,), checkpoint=None):
    device = ResolvedDevice(
        config=DeviceConfig(id="cane", type="cane", driver={}),
        file=Path("gateway.toml"),
        device_type=DeviceType("cane", "", requires, Params, lambda params, C_db: estimator()),
        params=Params(),
        transport_type=TransportType("none", "", Params, lambda params, clock: None),
        transport_params=Params(),
        codec_type=CodecType("bytes", "", Params, lambda params: ByteCodec()),
        codec_params=Params(),
        mounting=MOUNTING,
        C_db=rotation_from_mounting(MOUNTING),
    )
    out = Outlet()
    return Pipeline(device, out, checkpoint), out


def chunk(*numbers):
    return Chunk(10**12 + numbers[-1] * PERIOD_NS, bytes(numbers))


def test_bytes_are_recorded_before_anything_is_made_of_them():
    made, out = pipeline()
    made.feed(chunk(1))
    assert out.names() == ["chunk", "samples", "event"]


def test_samples_are_recorded_as_the_device_reports_and_estimated_as_mounted():
    made, out = pipeline()
    made.feed(chunk(3))
    recorded = next(items[0] for name, *items in out.told if name == "samples")
    assert recorded.channels["accel"].tolist() == [[9.8, 0.0, 3.0]]
    assert out.events()[0].detail == "[[3.0, 0.0, 9.8]]"


def test_commands_are_recorded_and_handed_out():
    made, out = pipeline()
    assert made.link_opened(5) == [b"go"]
    assert out.told == [("chunk", Chunk(5, b"go"), "tx")]


def test_missing_samples_reach_estimator_recording_and_status():
    made, out = pipeline()
    made.feed(chunk(1, 2, 7))
    assert [event.detail for event in out.events() if event.anomaly == "gap"] == ["4"]
    assert "gap" in out.names()
    assert made.health.samples == 3
    assert made.health.samples_lost == 4


def test_faults_are_counted_and_disturb_no_sample():
    made, out = pipeline()
    made.feed(chunk(1, 255, 255, 2))
    assert made.health.samples == 2
    assert [items[0].count for name, *items in out.told if name == "fault"] == [1, 1]


def test_a_failed_handshake_is_known_until_the_link_is_opened_again():
    made, _ = pipeline()
    made.feed(chunk(254))
    assert made.failure == "no answer"
    made.link_opened(0)
    assert made.failure is None


def test_a_failing_estimator_is_replaced_and_says_so_once_in_a_row(caplog):
    made, out = pipeline(Failing)
    with caplog.at_level(logging.INFO):
        for number in (1, 2, 3, 4, 5):
            made.feed(chunk(number))
    assert [event.anomaly for event in out.events()] == ["estimator-failed"] * 2
    assert "ZeroDivisionError: not 4" in out.events()[0].detail
    assert len(caplog.records) == 2
    assert made.health.estimator == "failed"
    assert made.health.samples == 5


@pytest.mark.parametrize("estimator", [Echo, Failing])
def test_the_end_lets_the_estimator_say_what_it_held_back(estimator):
    made, out = pipeline(estimator)
    made.finish()
    assert [event.anomaly for event in out.events()] == ["end"]


def test_a_device_that_lacks_a_channel_says_so_once_and_its_samples_are_still_recorded():
    made, out = pipeline(requires=(ACCEL, GYRO))
    for number in (1, 2, 3):
        made.feed(chunk(number))
    told = [event.anomaly for event in out.events()]
    assert told == ["channel-missing", "gap", "gap", "gap"]  # a gap for each sample without it
    assert "sends no gyro" in out.events()[0].detail
    assert out.names().count("samples") == 3


def test_a_channel_that_stays_away_is_told_again_after_it_came_back(monkeypatch):
    made, out = pipeline(requires=(ACCEL, GYRO))
    decode_accel = ByteCodec.feed

    def feed(self, chunk):
        items = decode_accel(self, chunk)
        for item in items if chunk.data[0] in (1, 4) else []:
            item.channels["gyro"] = frozen_rows([[0.0, 0.0, 0.0]], 3)
        return items

    monkeypatch.setattr(ByteCodec, "feed", feed)
    for number in (1, 2, 3, 4, 5):
        made.feed(chunk(number))
    told = [event.anomaly for event in out.events()]
    assert told == ["sample", "channel-missing", "gap", "gap", "sample", "channel-missing", "gap"]


class Sum(Saveable):
    """An estimator that tells at every second sample what it has counted."""

    look_ahead_s = 0.0

    def __init__(self):
        self.samples = 0
        self.missing = 0

    def update(self, item):
        if isinstance(item, Gap):
            self.missing += item.n_missing
            return []
        self.samples += len(item)
        if self.samples % 2:
            return []
        detail = f"{self.samples} and {self.missing} missing"
        return [Anomaly(t_ns=int(item.t_ns[-1]), anomaly="sum", detail=detail)]

    def finish(self):
        return [Anomaly(t_ns=0, anomaly="end", detail="")]


class Unsaveable(Sum):
    def save(self):
        raise RuntimeError("no")


class Unrestorable(Sum):
    def restore(self, state):
        self.samples = 99
        raise RuntimeError("no")


class Strangers(Echo):
    """Written before states were: it has neither save nor restore."""


@pytest.fixture
def checkpoint(tmp_path):
    return Checkpoint("cane", tmp_path / "state" / "cane.state", {"type": "cane"}, 600.0)


def details(out):
    return [event.detail for event in out.events()]


def resumed(estimator, checkpoint, t_ns=10**12 + 10**9):
    made, out = pipeline(estimator, checkpoint=checkpoint)
    state = checkpoint.load(t_ns)
    assert state is not None
    made.resume(state)
    made.link_opened(t_ns)
    return made, out


def test_after_a_kill_it_goes_on_and_what_passed_is_a_gap_of_a_link_that_was_down(checkpoint):
    made, _ = pipeline(Sum, checkpoint=checkpoint)
    made.feed(chunk(1, 2, 3, 4))
    again, out = resumed(Sum, checkpoint)
    again.feed(chunk(11, 12))
    assert details(out) == ["6 and 6 missing"]
    (gap,) = (items[0] for name, *items in out.told if name == "gap")
    assert (gap.reason, gap.n_missing) == ("link-down", 6)


def test_a_state_is_on_file_before_its_events_are_told(checkpoint):
    class Killed(Outlet):
        def event(self, device, event):
            raise KeyboardInterrupt

    made, _ = pipeline(Sum, checkpoint=checkpoint)
    made._out = Killed()
    with pytest.raises(KeyboardInterrupt):
        made.feed(chunk(1, 2))
    again, out = resumed(Sum, checkpoint)
    again.feed(chunk(3, 4))
    assert details(out) == ["4 and 0 missing"]  # the event "2" may be missed, never told twice


def test_samples_without_events_are_kept_about_once_a_second(checkpoint):
    class Quiet(Sum):
        def update(self, item):
            super().update(item)
            return []

    writes = []
    write = checkpoint.write
    checkpoint.write = lambda *args: (writes.append(args[0]), write(*args))
    made, _ = pipeline(Quiet, checkpoint=checkpoint)
    for number in range(1, 251):
        made.feed(chunk(number))
    assert len(writes) == 3
    assert np.diff(writes).tolist() == [10**9, 10**9]


def test_a_stop_keeps_the_state_and_ends_nothing(checkpoint):
    made, out = pipeline(Sum, checkpoint=checkpoint)
    made.feed(chunk(1, 2, 3))
    made.stop(10**12 + 10**8)
    assert details(out) == ["2 and 0 missing"]
    again, out = resumed(Sum, checkpoint)
    again.feed(chunk(4))
    assert details(out) == ["4 and 0 missing"]


def test_a_stop_before_any_samples_leaves_an_earlier_state_as_old_as_it_is(checkpoint):
    made, _ = pipeline(Sum, checkpoint=checkpoint)
    made.feed(chunk(1, 2))
    again, out = resumed(Sum, checkpoint)
    again.stop(10**12 + 10**11)
    assert details(out) == []
    assert checkpoint.load(10**12 + 10**11).saved_t_ns == 10**12 + 2 * PERIOD_NS


def test_without_a_place_for_states_a_stop_ends_what_is_going_on():
    made, out = pipeline(Sum)
    made.feed(chunk(1))
    made.stop(0)
    assert [event.anomaly for event in out.events()] == ["end"]


@pytest.mark.parametrize("estimator", [Unsaveable, Strangers])
def test_what_can_t_be_saved_is_measured_on_and_no_older_state_stays(checkpoint, estimator, caplog):
    checkpoint.write(0, {}, b"older")
    made, out = pipeline(estimator, checkpoint=checkpoint)
    for number in (1, 2, 3, 4):
        made.feed(chunk(number))
    assert len(out.events()) in (2, 4)
    assert checkpoint.load(1) is None
    assert sum("begin anew" in record.message for record in caplog.records) == 1
    made.stop(10**12)
    assert out.events()[-1].anomaly == "end"


def test_a_disk_that_refuses_costs_the_state_alone(checkpoint, monkeypatch, caplog):
    monkeypatch.setattr("pathlib.Path.write_bytes", lambda *_: (_ for _ in ()).throw(OSError(28)))
    made, out = pipeline(Sum, checkpoint=checkpoint)
    made.feed(chunk(1, 2))
    assert details(out) == ["2 and 0 missing"]
    assert "begin anew" in caplog.text


@pytest.mark.parametrize("estimator", [Unrestorable, Strangers])
def test_what_can_t_be_restored_begins_anew_and_says_so(checkpoint, estimator):
    made, _ = pipeline(Sum, checkpoint=checkpoint)
    made.feed(chunk(1, 2))
    again, out = resumed(estimator, checkpoint)
    assert [event.anomaly for event in out.events()] == ["state-not-restored"]
    again.feed(chunk(3, 4))
    assert out.events()[-1].detail.startswith(("2 and 0", "[[4.0"))
    assert "gap" not in out.names()


def test_an_aligner_that_can_t_be_restored_leaves_no_half_of_the_state(checkpoint):
    made, out = pipeline(Sum)
    made.resume(Resumed(1, 0, {"clock": {}}, Sum().save()))
    made.feed(chunk(3, 4))
    assert details(out)[1:] == ["2 and 0 missing"]


def test_what_an_earlier_run_held_back_is_told_once_where_it_can_t_go_on(checkpoint, tmp_path):
    made, _ = pipeline(Sum, checkpoint=checkpoint)
    made.feed(chunk(1, 2, 3))
    made.stop(10**12 + 10**8)
    later = 10**12 + 601 * 10**9
    again, out = pipeline(Sum, checkpoint=checkpoint)
    again.resume(checkpoint.load(later))
    assert [event.anomaly for event in out.events()] == ["end"]
    assert checkpoint.load(later) is None
    again.feed(chunk(4, 5))
    assert details(out)[1:] == ["2 and 0 missing"]
    assert "gap" not in out.names()


def test_a_replay_from_the_recorded_state_tells_the_same(checkpoint):
    made, _ = pipeline(Sum, checkpoint=checkpoint)
    made.feed(chunk(1, 2, 3))
    live, told = resumed(Sum, checkpoint)
    live.feed(chunk(9, 10))
    state = next(items[0] for name, *items in told.told if name == "resumed")
    replayed, out = pipeline(Sum)
    replayed.resume(decode("resumed", encode(state)))
    replayed.link_opened(0)
    replayed.feed(chunk(9, 10))
    assert out.events() == told.events()
    assert [event.t_ns for event in out.events()]
