"""A second, crude simulator by other rules: an exact pendulum, a swing of least jerk, by hand."""

import numpy as np
import pytest

from gaitway.api import SampleBatch
from gaitway_plugins.standard_cane.estimator import StandardCaneEstimator
from gaitway_plugins.standard_cane.params import StandardCaneParams

HZ = 2000
GRAVITY_N = np.array([0.0, 0.0, 9.81])


def _least_jerk(s):
    s = np.clip(s, 0.0, 1.0)
    return s**3 * (10 - 15 * s + 6 * s**2)


def _tip_and_pitch(t, steps, length_m, cycle_s, rest_s):
    """Return the tip's x and z and the pitch: hand at constant height, level speed in between."""
    swing_s = 0.45 * cycle_s
    lean = np.arcsin(0.5 * 0.55 * length_m / 0.9)
    x, z, pitch = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    for k in range(steps):
        lift_s = rest_s + k * cycle_s
        s = (t - lift_s) / swing_s
        x += length_m * _least_jerk(s)
        z += 0.06 * np.where((s > 0) & (s < 1), 64 * (s * (1 - s)) ** 3, 0.0)
        pitch += (-lean if k == 0 else -2 * lean) * _least_jerk(s)
        stance = (t - lift_s - swing_s) / (cycle_s - swing_s)
        pitch += (2 * lean if k < steps - 1 else lean) * _least_jerk(stance)
    return x, z, pitch


def _recorded(rate_hz, height_m, *, length_m=0.8, cycle_s=1.2, rest_s=1.5, seed=0, bias=0.0):
    """Return a batch in d and its true distance; positions differentiated twice at 2 kHz."""
    rng = np.random.default_rng(seed)
    steps = 8
    t = np.arange(round((2 * rest_s + steps * cycle_s) * HZ)) / HZ
    x, z, pitch = _tip_and_pitch(t, steps, length_m, cycle_s, rest_s)
    pos = np.c_[x + height_m * np.sin(pitch), 0.0 * t, z + height_m * np.cos(pitch)]
    acc = np.gradient(np.gradient(pos, 1 / HZ, axis=0), 1 / HZ, axis=0) + GRAVITY_N
    c, s = np.cos(pitch), np.sin(pitch)
    accel = np.c_[c * acc[:, 0] - s * acc[:, 2], acc[:, 1], s * acc[:, 0] + c * acc[:, 2]]
    gyro = np.c_[0.0 * t, np.gradient(pitch, 1 / HZ), 0.0 * t]
    every = round(HZ / rate_hz)
    n = len(t) // every
    accel, gyro = (v[: n * every].reshape(n, every, 3).mean(axis=1) for v in (accel, gyro))
    accel = accel + rng.normal(0.0, 1.5e-3 * np.sqrt(rate_hz), accel.shape)
    gyro = gyro + rng.normal(0.0, 2e-4 * np.sqrt(rate_hz), gyro.shape) + bias
    t_ns = np.arange(n, dtype=np.int64) * (10**9 // rate_hz)
    return SampleBatch(t_ns, 1 / rate_hz, 0, {"accel": accel, "gyro": gyro}), steps * length_m


@pytest.mark.parametrize("rate_hz", [50, 100, 200])
@pytest.mark.parametrize("height_m", [0.315, 0.778])
@pytest.mark.parametrize(("length_m", "cycle_s"), [(0.3, 1.0), (0.8, 1.2), (1.2, 1.0)])
def test_an_exact_pendulum_is_measured(rate_hz, height_m, length_m, cycle_s):
    batch, true_m = _recorded(
        rate_hz, height_m, length_m=length_m, cycle_s=cycle_s, bias=np.array([0.01, -0.015, 0.01])
    )
    params = StandardCaneParams(imu_to_tip_m=(0.0, 0.0, -height_m))
    one = StandardCaneEstimator(params, np.eye(3))
    events = [*one.update(batch), *one.finish()]
    assert sum(event.kind == "stride" for event in events) == 8
    distance = [event for event in events if event.kind == "distance"][-1]
    assert distance.distance_m == pytest.approx(true_m, rel=0.01)
