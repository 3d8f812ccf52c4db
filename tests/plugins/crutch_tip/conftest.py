"""Crutch walks, and what the estimator says of them."""

import numpy as np
import pytest

from gaitway.api import SampleBatch, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway_plugins.crutch_tip.estimator import CrutchTipEstimator
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.simulation import MOUNTING, simulate


class Tools:
    @staticmethod
    def walk(distance_m=8.0, **plan):
        walk = simulate(WalkPlan(distance_m, **plan))
        return walk, Tools.batch(walk.channels, walk.rate_hz)

    @staticmethod
    def batch(channels, rate_hz):
        n = len(next(iter(channels.values())))
        t_ns = np.arange(n, dtype=np.int64) * round(1e9 / rate_hz)
        return mount(SampleBatch(t_ns, 1 / rate_hz, 0, channels), rotation_from_mounting(MOUNTING))

    @staticmethod
    def said(batch, size=100, trace=False, **params):
        estimator = CrutchTipEstimator(CrutchTipParams(**params))
        kept = estimator.start_trace() if trace else None
        events = []
        for start in range(0, len(batch), size):
            events += estimator.update(batch[start : start + size])
        events += estimator.finish()
        return (events, np.array(kept.rows)) if trace else events

    @staticmethod
    def cycle_rms_deg(walk, pitch_rad):
        error = np.degrees(pitch_rad - walk.truth["pitch_rad"])
        bounds = zip(walk.stride_start_s, walk.stride_end_s, strict=True)
        rows = [slice(int(a * walk.rate_hz), int(b * walk.rate_hz)) for a, b in bounds]
        return np.array([np.sqrt(np.mean(error[row] ** 2)) for row in rows])

    @staticmethod
    def of(events, kind):
        return [event for event in events if event.kind == kind]


@pytest.fixture(scope="session")
def tools():
    return Tools
