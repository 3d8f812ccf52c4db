"""The path from bytes to events, with a codec and estimators of a few lines."""

import logging
from pathlib import Path

import numpy as np
import pytest

from gaitway.config.load import ResolvedDevice
from gaitway.config.schema import DeviceConfig
from gaitway.contracts import CodecType, DeviceType, TransportType
from gaitway.events import Anomaly
from gaitway.mounting import rotation_from_mounting
from gaitway.params import Params
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


def pipeline(estimator=Echo, requires=(ACCEL,)):
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
    return Pipeline(device, out), out


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
