"""A shank that moves and does not walk: no stride is invented."""

import numpy as np
import pytest

from gaitway.api import NS_PER_S, SampleBatch, Stride, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.simulation import Knot, RigidMotion, Spline, mounted, non_walking, record, rest, via
from gaitway_plugins.shank.estimator import ShankEstimator
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.simulation import MOUNTING

IMU_D = (0.04, 0.0, 0.15)
SHANK_M = 0.4


def effort(t, end_s):
    """Return 0 at rest, 1 in motion, smooth in between."""
    share = np.clip(np.minimum(t - 3.0, end_s - 3.0 - t) / 1.5, 0.0, 1.0)
    return share**2 * (3.0 - 2.0 * share)


def pedalling(t, go, rng):
    """Return ankle (forward, up) and pitch of the shank of a cyclist, on the spot or riding."""
    angle = 2 * np.pi * rng.uniform(0.6, 1.6) * np.cumsum(go) * (t[1] - t[0])
    ankle = np.stack([0.17 * np.cos(angle), 0.05 - 0.17 * np.sin(angle)], axis=1)
    hip, thigh_m, shank_m = np.array([-0.25, 0.75]), 0.42, 0.43
    way = ankle - hip
    far = np.minimum(np.hypot(*way.T), thigh_m + shank_m - 1e-3)
    bend = np.arccos((thigh_m**2 + far**2 - shank_m**2) / (2 * thigh_m * far))
    leg = np.arctan2(way[:, 1], way[:, 0]) + bend
    knee = hip + thigh_m * np.stack([np.cos(leg), np.sin(leg)], axis=1)
    ridden = rng.choice([0.0, 4.0]) * np.cumsum(go) * (t[1] - t[0])
    shank = knee - ankle
    return ankle + np.outer(ridden, [1.0, 0.0]), np.arctan2(shank[:, 0], shank[:, 1])


def dangling(t, go, rng):
    """Return a leg that swings about the knee of somebody who sits."""
    swing = rng.uniform(0.3, 0.8) * np.sin(2 * np.pi * rng.uniform(0.5, 1.2) * t)
    pitch = go * (swing + rng.uniform(-0.3, 0.3))
    return -SHANK_M * np.stack([np.sin(pitch), np.cos(pitch)], axis=1), pitch


def marching(t, go, rng):
    """Return a leg that is lifted and put down where it was."""
    lift = go * np.maximum(0.0, np.sin(2 * np.pi * rng.uniform(0.6, 1.1) * t)) ** 2
    pitch = rng.uniform(0.2, 0.9) * lift
    knee = np.stack([rng.uniform(0.1, 0.35) * lift, 0.15 * lift], axis=1)
    return knee - SHANK_M * np.stack([np.sin(pitch), np.cos(pitch)], axis=1), pitch


def in_a_bag(t, go, rng):
    """Return a sensor that dangles in the bag of somebody who walks."""
    phase = 2 * np.pi * rng.uniform(0.8, 1.0) * t
    pitch = rng.uniform(-1.5, 1.5) + go * rng.uniform(0.1, 0.5) * np.sin(phase)
    along = 1.2 * np.cumsum(go) * (t[1] - t[0]) + go * 0.05 * np.sin(phase)
    return np.stack([along, go * 0.03 * np.sin(2 * phase)], axis=1), pitch


def recorded(movement, seed, end_s=120.0):
    t = np.arange(0.0, end_s, 0.05)
    place, pitch = movement(t, effort(t, end_s), np.random.default_rng(seed))
    zero = np.zeros_like(t)
    position = spline(t, np.stack([place[:, 0], zero, place[:, 1]], axis=1))
    angles = spline(t, np.stack([zero, pitch, zero], axis=1))
    plan = WalkPlan(0.0, seed=seed)
    motion = RigidMotion(position, angles)
    return batch(record(plan, motion, mounted(MOUNTING, IMU_D), end_s, []))


def spline(t, rows):
    knots: list[Knot] = [via(float(at), *map(float, row)) for at, row in zip(t, rows, strict=True)]
    for end in (0, -1):
        knots[end] = rest(knots[end].t_s, *knots[end].values)
    return Spline(knots)


def batch(walk):
    t_ns = np.arange(len(walk.pos_n), dtype=np.int64) * round(NS_PER_S / walk.rate_hz)
    samples = SampleBatch(t_ns, 1.0 / walk.rate_hz, 0, walk.channels)
    return mount(samples, rotation_from_mounting(MOUNTING))


def strides(samples):
    estimator = ShankEstimator(ShankParams())
    events = [*estimator.update(samples), *estimator.finish()]
    return [event for event in events if isinstance(event, Stride)]


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("movement", [pedalling, dangling, marching, in_a_bag])
def test_a_leg_that_only_moves_takes_no_stride(movement, seed):
    assert strides(recorded(movement, seed)) == []


@pytest.mark.parametrize(
    "kind", ["still", "lying", "leaning", "waving", "turning-on-the-spot", "carried"]
)
def test_a_sensor_that_is_not_worn_takes_no_stride(kind):
    walk = non_walking(
        WalkPlan(0.0, seed=1), kind, duration_s=300.0, mounting=MOUNTING, device_to_imu_d=IMU_D
    )
    assert strides(batch(walk)) == []
