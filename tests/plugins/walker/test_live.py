"""A walker whose IMU and encoders come in one stream, through the gateway's path."""

from pathlib import Path

import numpy as np
import pytest

from gaitway.api import Chunk, CodecType, DeviceBatch, Params, TransportType, frozen_rows
from gaitway.config.load import ResolvedDevice
from gaitway.config.schema import DeviceConfig
from gaitway.mounting import rotation_from_mounting
from gaitway.registry import load_registry
from gaitway.runtime.pipeline import Pipeline
from gaitway_plugins.walker.params import WalkerParams

PERIOD_NS = 10_000_000
SIZE = 10


class WalkCodec:
    """Two bytes are the number of ten samples with all four channels."""

    def __init__(self, walk):
        self.walk = walk

    def start(self, t_ns):
        return []

    def feed(self, chunk):
        begin = SIZE * int.from_bytes(chunk.data, "big")
        rows = slice(begin, begin + SIZE)
        channels = {
            name: frozen_rows(values[rows], values.shape[1])
            for name, values in self.walk.channels.items()
        }
        device_ns = np.arange(begin, begin + SIZE, dtype=np.int64) * PERIOD_NS
        return [DeviceBatch(chunk.t_ns, device_ns, 0.01, channels)]

    def on_time(self, t_ns):
        return []

    def finish(self):
        return []


class Outlet:
    def __init__(self):
        self.events = []

    def __getattr__(self, name):
        return lambda device, *items: self.events.extend(items if name == "event" else ())


def test_imu_and_wheels_in_one_batch_are_measured_live(tools):
    walk = tools.moved("full-lift", steps=4)
    mounting = {"x": "forward", "y": "left", "z": "up"}
    device = ResolvedDevice(
        config=DeviceConfig(id="walker", type="walker", driver={}),
        file=Path("gateway.toml"),
        device_type=load_registry().devices["walker"],
        params=WalkerParams(),
        transport_type=TransportType("none", "", Params, lambda params, clock: None),
        transport_params=Params(),
        codec_type=CodecType("walk", "", Params, lambda params: WalkCodec(walk)),
        codec_params=Params(),
        mounting=mounting,
        C_db=rotation_from_mounting(mounting),
    )
    out = Outlet()
    pipeline = Pipeline(device, out, None)
    for number in range(len(walk) // SIZE):
        t_ns = 10**12 + (number + 1) * SIZE * PERIOD_NS
        pipeline.feed(Chunk(t_ns, number.to_bytes(2, "big")))
    pipeline.finish()
    strides = tools.of(out.events, "stride")
    assert [stride.style for stride in strides] == ["full-lift"] * 4
    assert tools.distance(out.events).distance_m == pytest.approx(1.6, abs=0.02)
