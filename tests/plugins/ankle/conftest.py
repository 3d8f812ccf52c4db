"""Ankles that walk, and what an estimator says of them."""

import importlib.util
import sys
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from gaitway.api import Anomaly, Distance, SampleBatch, Stride, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway_plugins.ankle.estimator import AnkleEstimator
from gaitway_plugins.ankle.params import AnkleParams
from gaitway_plugins.ankle.simulation import MOUNTING, simulate


def _heel_pivot():
    name = "ankle_heel_pivot"
    if name not in sys.modules:
        path = Path(__file__).with_name("heel_pivot.py")
        spec = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    return sys.modules[name]


class Tools:
    """Walks and their outcomes; the device's axes unless said otherwise."""

    C_db = rotation_from_mounting(MOUNTING)
    LEVER_B = (0.12, 0.0, 0.03)
    """Of the heel walk, in IMU axes: up, right, forward."""

    @staticmethod
    @lru_cache(maxsize=32)
    def _heel(items):
        return _heel_pivot().heel_walk(**dict(items))

    @classmethod
    def heel(cls, **options):
        """Return the crude walker's walk."""
        return cls._heel(tuple(sorted(options.items())))

    @staticmethod
    def heel_batch(walk):
        n = len(walk.accel)
        t_ns = np.arange(n, dtype=np.int64) * round(1e9 / walk.rate_hz)
        return SampleBatch(t_ns, 1 / walk.rate_hz, 0, {"accel": walk.accel, "gyro": walk.gyro})

    @classmethod
    def simulated(cls, **plan):
        """Return a walk of ``gaitway simulate`` and its samples in the device frame."""
        walk = simulate(WalkPlan(**{"distance_m": 12.0, **plan}))
        t_ns = np.arange(len(walk.pos_n), dtype=np.int64) * round(1e9 / walk.rate_hz)
        batch = SampleBatch(t_ns, 1 / walk.rate_hz, 0, walk.channels)
        return walk, mount(batch, cls.C_db)

    @classmethod
    def estimator(cls, **params):
        return AnkleEstimator(AnkleParams(**params), cls.C_db)

    @staticmethod
    def said(estimator, batch, size=100):
        """Return all events of samples fed in batches of a size."""
        events = []
        for start in range(0, len(batch), size):
            events += estimator.update(batch[start : start + size])
        return [*events, *estimator.finish()]

    @staticmethod
    def said_of(estimator, items):
        """Return all events of batches and gaps."""
        events = [event for item in items for event in estimator.update(item)]
        return [*events, *estimator.finish()]

    @staticmethod
    def strides(events):
        return [event for event in events if isinstance(event, Stride)]

    @staticmethod
    def anomalies(events):
        return {event.anomaly for event in events if isinstance(event, Anomaly)}

    @staticmethod
    def distance(events):
        return [event for event in events if isinstance(event, Distance)][-1]

    @staticmethod
    def dragged(seed, minutes=5.0):
        """Return what a sensor feels that is dragged over a floor, leaning and trembling."""
        rng, hz = np.random.default_rng(seed), 100.0
        n = round(60.0 * minutes * hz)

        def band(low_hz, high_hz):
            kept = np.abs(np.fft.rfftfreq(n, 1.0 / hz) - 0.5 * (low_hz + high_hz))
            spectrum = np.fft.rfft(rng.standard_normal(n))
            noise = np.fft.irfft(np.where(kept < 0.5 * (high_hz - low_hz), spectrum, 0.0), n)
            return noise / noise.std()

        t = np.arange(n) / hz
        on = np.convolve(np.sin(2.0 * np.pi * t / 30.0) > -0.5, np.ones(40) / 40.0, "same")
        on[:300] = on[-300:] = 0.0
        pitch = on * (0.35 + 0.026 * band(0.5, 3.0))
        roll = on * 0.026 * band(0.5, 3.0)
        forward = np.gradient(0.5 * on * (1.0 + 0.3 * band(0.3, 1.2))) * hz
        forward += 0.6 * on * band(15.0, 40.0)
        force_n = np.column_stack([forward, np.zeros(n), 9.80665 + 1.5 * on * band(20.0, 45.0)])
        c, s = np.cos(pitch), np.sin(pitch)
        tilted = np.column_stack([
            c * force_n[:, 0] - s * force_n[:, 2], roll * force_n[:, 2],
            s * force_n[:, 0] + c * force_n[:, 2],
        ])  # fmt: skip
        gyro = np.column_stack([np.gradient(roll), np.gradient(pitch), np.zeros(n)]) * hz
        accel = tilted + 0.02 * rng.standard_normal((n, 3))
        gyro += 2e-3 * rng.standard_normal((n, 3))
        t_ns = np.arange(n, dtype=np.int64) * 10_000_000
        return SampleBatch(t_ns, 1 / hz, 0, {"accel": accel, "gyro": gyro})

    @staticmethod
    def cut(batch, *bounds):
        return [batch[begin:end] for begin, end in pairwise([0, *bounds, len(batch)])]


@pytest.fixture(scope="session")
def tools():
    return Tools
