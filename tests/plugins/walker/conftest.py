"""A walker moved by hand: built from accelerations, not from the plugin's simulation."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from gaitway.api import Gap, SampleBatch
from gaitway_plugins.walker.estimator import WalkerEstimator
from gaitway_plugins.walker.params import WalkerParams

G = 9.80665
GRAVITY = np.array([0.0, 0.0, G])
FINE = 1000


@dataclass
class Walk:
    """Samples in frame d, and what is true."""

    channels: dict
    period_s: float
    distance_m: float
    lengths_m: list
    ends_s: list
    yaw_rad: float = 0.0
    style: str = ""

    def batch(self, begin=0, end=None, start_ns=0):
        end = len(self) if end is None else end
        step_ns = round(self.period_s * 1e9)
        t_ns = start_ns + np.arange(begin, end, dtype=np.int64) * step_ns
        channels = {name: rows[begin:end] for name, rows in self.channels.items()}
        return SampleBatch(t_ns, self.period_s, begin, channels)

    def __len__(self):
        return len(self.channels["accel"])


@dataclass
class Hand:
    """Speeds and rates a millisecond at a time."""

    roll: list = field(default_factory=list)
    lift: list = field(default_factory=list)
    climb: list = field(default_factory=list)
    pitch: list = field(default_factory=list)
    yaw: list = field(default_factory=list)

    def go(self, duration_s, **profiles):
        n = round(duration_s * FINE)
        for name in ("roll", "lift", "climb", "pitch", "yaw"):
            profile = profiles.get(name)
            getattr(self, name).append(np.zeros(n) if profile is None else profile(n))


def hump(area):
    """Return a profile of least jerk with an integral."""

    def of(n):
        u = (np.arange(n) + 0.5) / n
        return 30.0 * u**2 * (1 - u) ** 2 * area / (n / FINE)

    return of


def trapeze(area, ramp=0.2):
    """Return a profile that glides evenly between ramps."""

    def of(n):
        u = (np.arange(n) + 0.5) / n
        shape = np.clip(np.minimum(u, 1 - u) / ramp, 0, 1)
        return shape * area / (shape.sum() / FINE)

    return of


def up_down(height):
    return lambda n: np.concatenate([hump(height)(n // 2), hump(-height)(n - n // 2)])


def moved(
    style, steps=10, *, length_m=0.4, duration_s=0.9, rest_s=2.0, pause_s=0.8, rate_hz=100.0,
    modulation=0.2, height_m=0.07, pitch_deg=4.0, profile=hump, turn_deg=0.0, noise=0.01,
    gyro_bias=(0.0, 0.0, 0.0), accel_bias=(0.0, 0.0, 0.0), imu=(0.0, 0.0, 0.7), seed=0,
    radius_m=0.0635, track_m=0.61, sway_rad=0.0,
):  # fmt: skip
    """Return a walk in one style; every step turns by ``turn_deg``."""
    hand, ends_s, turn = Hand(), [], np.radians(turn_deg)
    hand.go(rest_s)
    if style == "continuous":
        n = round(steps * duration_s * FINE)
        t = np.arange(n) / FINE
        speed = length_m / duration_s * (1 - modulation * np.cos(2 * np.pi * t / duration_s))
        ramp = np.clip(np.minimum(t, t[-1] - t) / 0.4, 0, 1)
        hand.go(n / FINE, roll=lambda n: speed * ramp)
        ends_s = [rest_s + (k + 1) * duration_s for k in range(steps)]
    for _ in range(0 if style == "continuous" else steps):
        if style == "full-lift":
            hand.go(duration_s, lift=profile(length_m), climb=up_down(height_m), yaw=hump(turn))
        elif style == "back-tips":
            hand.go(0.3, pitch=hump(np.radians(pitch_deg)))
            hand.go(duration_s, roll=profile(length_m), yaw=hump(turn))
            hand.go(0.3, pitch=hump(-np.radians(pitch_deg)))
        else:
            hand.go(duration_s, roll=profile(length_m), yaw=hump(turn))
        ends_s.append(sum(map(len, hand.roll)) / FINE)
        hand.go(pause_s)
    hand.go(rest_s)
    walk = _sensed(
        hand, rate_hz, np.array(imu), noise, gyro_bias, accel_bias, seed, radius_m, track_m,
        sway_rad,
    )  # fmt: skip
    walk.ends_s, walk.style = ends_s, style
    walk.lengths_m = [walk.distance_m / steps] * steps
    return walk


def _sensed(hand, rate_hz, imu, noise, gyro_bias, accel_bias, seed, radius_m, track_m, sway_rad):
    roll, lift, climb, pitch_rate, yaw_rate = (
        np.concatenate(getattr(hand, name)) for name in ("roll", "lift", "climb", "pitch", "yaw")
    )
    t = np.arange(len(roll)) / FINE
    pitch = np.cumsum(pitch_rate) / FINE + sway_rad * np.sin(2 * np.pi * 0.7 * t)
    yaw = np.cumsum(yaw_rate) / FINE
    speed = roll + lift
    pos = np.cumsum(np.stack([speed * np.cos(yaw), speed * np.sin(yaw), climb], 1), axis=0) / FINE
    cy, sy, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    zero = np.zeros_like(t)
    C = np.stack(
        [
            np.stack([cy * cp, -sy, cy * sp], 1),
            np.stack([sy * cp, cy, sy * sp], 1),
            np.stack([-sp, zero, cp], 1),
        ],
        axis=1,
    )
    sensor = pos + C @ imu
    accel_n = np.gradient(np.gradient(sensor, 1 / FINE, axis=0), 1 / FINE, axis=0)
    accel = np.einsum("nij,ni->nj", C, accel_n + GRAVITY)
    rate_pitch, rate_yaw = np.gradient(pitch, 1 / FINE), np.gradient(yaw, 1 / FINE)
    gyro = np.stack([-sp * rate_yaw, rate_pitch, cp * rate_yaw], 1)
    every = round(FINE / rate_hz)
    n = len(t) // every
    rng = np.random.default_rng(seed)
    size = noise * np.sqrt(rate_hz / 100.0)
    mean = lambda rows: rows[: n * every].reshape(n, every, 3).mean(axis=1)  # noqa: E731
    accel = mean(accel) + accel_bias + size * rng.standard_normal((n, 3))
    gyro = mean(gyro) + gyro_bias + 0.1 * size * rng.standard_normal((n, 3))
    tick_m = 2 * np.pi * radius_m / 1024
    ticks = []
    for side in (-1.0, 1.0):
        way = np.cumsum(roll + side * 0.5 * track_m * rate_yaw * (np.abs(lift) == 0)) / FINE
        ticks.append(np.floor(way[every - 1 :: every][:n] / tick_m)[:, None])
    channels = {"accel": accel, "gyro": gyro, "left_ticks": ticks[0], "right_ticks": ticks[1]}
    distance_m = float(np.sum(np.abs(speed)) / FINE)
    return Walk(channels, 1 / rate_hz, distance_m, [], [], float(yaw[-1]))


def said(walk, size=None, losses=(), estimator=None, **changes):
    """Return every event of a walk, fed in batches of a size, without the samples lost."""
    estimator = estimator or WalkerEstimator(WalkerParams(**changes))
    events, at = [], 0
    for begin, end in [*sorted(losses), (len(walk), None)]:
        while at < begin:
            to = begin if size is None else min(begin, at + size)
            events += estimator.update(walk.batch(at, to))
            at = to
        if end is not None:
            t_ns = begin * round(walk.period_s * 1e9)
            events += estimator.update(Gap(t_ns=t_ns, n_missing=end - begin, reason="lost"))
            at = end
    return [*events, *estimator.finish()]


class Tools:
    moved = staticmethod(moved)
    said = staticmethod(said)
    hump = staticmethod(hump)
    trapeze = staticmethod(trapeze)
    up_down = staticmethod(up_down)
    Hand = Hand
    G = G

    @staticmethod
    def sensed(hand, **changes):
        settings = {
            "rate_hz": 100.0, "imu": np.array([0.0, 0.0, 0.7]), "noise": 0.01,
            "gyro_bias": (0.0, 0.0, 0.0), "accel_bias": (0.0, 0.0, 0.0), "seed": 0,
            "radius_m": 0.0635, "track_m": 0.61, "sway_rad": 0.0,
        }  # fmt: skip
        return _sensed(hand, **(settings | changes))

    @staticmethod
    def of(events, kind):
        return [event for event in events if event.kind == kind]

    @staticmethod
    def distance(events):
        return [event for event in events if event.kind == "distance"][-1]


@pytest.fixture(scope="session")
def tools():
    return Tools
