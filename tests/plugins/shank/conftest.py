"""A shank walked by hand, and what an estimator says of it."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from gaitway.api import Distance, Gap, SampleBatch, Stride

G = 9.80665


@dataclass
class Walk:
    """Samples in frame d with the distance that was walked."""

    accel: np.ndarray
    gyro: np.ndarray
    period_s: float
    distance_m: float
    toe_offs: list[int]

    def batch(self, begin, end, start_ns=0):
        step_ns = round(self.period_s * 1e9)
        return SampleBatch(
            t_ns=start_ns + np.arange(begin, end, dtype=np.int64) * step_ns,
            period_s=self.period_s,
            sequence=begin,
            channels={"accel": self.accel[begin:end], "gyro": self.gyro[begin:end]},
        )

    def __len__(self):
        return len(self.accel)


def planar_walk(
    *, strides=6, cycle_s=1.1, bump_mps=5.5, height_m=0.185, creep_mps=0.07, rest_s=3.0,
    rate_hz=100.0, noise=0.0, seed=0, bias=(0.0, 0.0, 0.0), yaw_rad=0.0,
):  # fmt: skip
    """Return a planar walk: on the floor v = height w + creep, in swing a bump of velocity more.

    The leg stands for 0.64 of a cycle with two humps of leaning rate, then swings back as far.
    """
    period_s = 1.0 / rate_hz
    t = np.arange(0.0, 2 * rest_s + strides * cycle_s, period_s)
    phase, cycle = np.modf((t - rest_s) / cycle_s)
    walking = (t >= rest_s) & (cycle < strides)
    swing = np.where(phase >= 0.64, (phase - 0.64) / 0.36, 0.0)
    stance = np.where(phase < 0.64, phase / 0.64, 0.0)
    humps = np.sin(2 * np.pi * stance) ** 2 + 0.5 * np.sin(np.pi * stance) ** 2
    back = np.sin(np.pi * swing) ** 2
    rate = np.where(walking, 1.6 * humps - 1.6 * (0.75 * 0.64) / (0.5 * 0.36) * back, 0.0)
    ends = np.clip((t - rest_s) / 0.3, 0.0, 1.0)
    ends *= np.clip((rest_s + (strides - 0.2) * cycle_s - t) / 0.1, 0.0, 1.0)
    speed = height_m * rate + creep_mps * ends**2 * (3 - 2 * ends)
    speed += np.where(walking, bump_mps * np.sin(np.pi * swing) ** 4, 0.0)
    pitch = np.cumsum(rate) * period_s
    force = np.gradient(speed, period_s)
    cos, sin = np.cos(pitch), np.sin(pitch)
    zero = np.zeros_like(t)
    accel = np.stack([cos * force - sin * G, zero, sin * force + cos * G], axis=1)
    gyro = np.stack([zero, rate, zero], axis=1)
    twist = np.array(
        [
            [np.cos(yaw_rad), np.sin(yaw_rad), 0.0],
            [-np.sin(yaw_rad), np.cos(yaw_rad), 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
    rng = np.random.default_rng(seed)
    accel = accel @ twist.T + noise * rng.standard_normal(accel.shape)
    gyro = gyro @ twist.T + 0.1 * noise * rng.standard_normal(gyro.shape) + np.array(bias)
    toe_offs = [round((rest_s + (k + 0.64) * cycle_s) / period_s) for k in range(strides)]
    return Walk(accel, gyro, period_s, float(np.sum(speed) * period_s), toe_offs)


def said(estimator, walk, cuts=(), start_ns=0):
    """Return all events of a walk fed in batches that end at the cuts."""
    events = []
    bounds = [0, *sorted(cuts), len(walk)]
    for begin, end in pairwise(bounds):
        events += estimator.update(walk.batch(begin, end, start_ns))
    return [*events, *estimator.finish()]


def said_with_gap(estimator, walk, at, missing):
    """Return all events of a walk of which some samples never came."""
    step_ns = round(walk.period_s * 1e9)
    return [
        *estimator.update(walk.batch(0, at)),
        *estimator.update(Gap(t_ns=at * step_ns, n_missing=missing, reason="lost")),
        *estimator.update(walk.batch(at + missing, len(walk))),
        *estimator.finish(),
    ]


def lengths_m(events):
    return [event.stride_length_m for event in events if isinstance(event, Stride)]


def last_distance(events):
    return [event for event in events if isinstance(event, Distance)][-1]


class Tools:
    walk = staticmethod(planar_walk)
    said = staticmethod(said)
    said_with_gap = staticmethod(said_with_gap)
    lengths_m = staticmethod(lengths_m)
    last_distance = staticmethod(last_distance)
    Walk = Walk


@pytest.fixture(scope="session")
def tools():
    return Tools
