"""Frames per second of each codec that can be simulated."""

import time

import numpy as np

from gaitway.samples import Chunk, DeviceBatch
from gaitway_drivers import gaitway_codecs

RATE_HZ = 100.0


def codec_table() -> None:
    """Print frames per second of each codec that can be simulated."""
    print("codec                frames per feed   frames/s    us/frame")
    for codec_type in gaitway_codecs():
        frames = frames_of(codec_type)
        for together in (1, 10, 100):
            codec = codec_type.make(codec_type.params.model_validate({"listen_only": True}))
            chunks = [
                Chunk(10_000_000 * start, b"".join(frames[start : start + together]))
                for start in range(0, len(frames), together)
            ]
            codec.start(0)
            began = time.perf_counter()
            decoded = sum(
                len(item) for chunk in chunks for item in codec.feed(chunk)
                if isinstance(item, DeviceBatch)
            )  # fmt: skip
            seconds = time.perf_counter() - began
            assert decoded == len(frames)
            rate = decoded / seconds
            print(f"{codec_type.name:20} {together:15} {rate:10.0f} {1e6 / rate:11.2f}")


def frames_of(codec_type):
    """Return what a device sends, once it was started by the codec's own handshake."""
    channels = {"accel": np.array([0.1, 0.2, 9.8]), "gyro": np.array([0.01, 0.02, 0.03])}
    codec = codec_type.make(codec_type.params.model_validate({}))
    peripheral = codec_type.make_peripheral(RATE_HZ)
    t_ns = 0
    items = codec.start(t_ns)
    while not peripheral.encode(0, channels):
        for item in items:
            reply = peripheral.feed(item.payload) if hasattr(item, "payload") else b""
            items = codec.feed(Chunk(t_ns, reply)) if reply else []
        t_ns += 50_000_000
        items += codec.on_time(t_ns)
    return [peripheral.encode(index, channels) for index in range(20_000)]
