"""The whole path of a sample, from the bytes of a read to the filter's state."""

import time

import numpy as np
from codec_table import frames_of

from gaitway.estimation import ErrorStateFilter, ImuNoise
from gaitway.samples import ACCEL, GYRO, Chunk, DeviceBatch
from gaitway_drivers import gaitway_codecs

NOISE = ImuNoise(5e-3, 5e-4, 1e-4, 1e-5)


def path_table() -> None:
    """Print microseconds per frame from Xbus bytes to decoded samples to a navigated state."""
    print("\nbytes to decoded to estimated (xbus -> filter), us/frame")
    print("frames per read   decoding   9 states   15 states")
    (codec_type,) = (each for each in gaitway_codecs() if each.name == "xbus")
    frames = frames_of(codec_type)
    for together in (1, 10, 100):
        chunks = [
            Chunk(10_000_000 * start, b"".join(frames[start : start + together]))
            for start in range(0, len(frames), together)
        ]
        took = [_us(codec_type, chunks, states) / len(frames) for states in (None, 9, 15)]
        print(f"{together:15} {took[0]:10.2f} {took[1]:10.2f} {took[2]:11.2f}")


def _us(codec_type, chunks, states):
    codec = codec_type.make(codec_type.params.model_validate({"listen_only": True}))
    codec.start(0)
    kf = None if states is None else ErrorStateFilter(states=states)
    began = time.perf_counter()
    for chunk in chunks:
        for item in codec.feed(chunk):
            if kf is not None and isinstance(item, DeviceBatch):
                kf.run(item.channels[ACCEL.name], item.channels[GYRO.name], item.period_s, NOISE)
    took_s = time.perf_counter() - began
    assert kf is None or np.isfinite(kf.nominal).all()
    return 1e6 * took_s
