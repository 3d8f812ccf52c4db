"""How near the truth, on people no parameter was chosen on (seeds from 1000 on)."""

import math

import numpy as np
import pytest

from gaitway.api import SampleBatch


@pytest.mark.parametrize("height_m", [0.315, 0.575, 0.778])
def test_short_walks_are_measured_to_four_centimetres_wherever_the_sensor_sits(
    walk, batch_of, run, height_m
):
    errors_m = []
    for seed in range(1000, 1006):
        truth = walk(2.8, height_m, seed=seed)
        told = run(batch_of(truth), height_m=height_m)
        assert len(told.strides) == len(truth.stride_length_m)
        errors_m.append(told.distance_m - truth.distance_m)
    assert np.abs(errors_m).mean() < 0.04


def test_a_long_walk_with_a_turn_is_measured_to_seven_permille(walk, batch_of, run, estimator):
    truth = walk(85.0, 0.778, seed=1010, turn_back=True)
    one = estimator(0.778)
    trace = one.start_trace()
    events = [*one.update(batch_of(truth)), *one.finish()]
    distance = [event for event in events if event.kind == "distance"][-1]
    assert distance.distance_m == pytest.approx(truth.distance_m, rel=0.007)
    rows = np.array(trace.rows)
    standing = rows[:, trace.columns.index("contact")] > 0
    assert np.abs(rows[standing, trace.columns.index("tip_z_m")]).max() < 0.05


def test_sample_rates_agree(walk, batch_of, run):
    told = [
        run(batch_of(walk(12.0, seed=1020, rate_hz=rate_hz))).distance_m
        for rate_hz in (50.0, 100.0, 200.0)
    ]
    assert max(told) / min(told) < 1.005


def test_a_slow_walk_is_measured(walk, batch_of, run):
    truth = walk(6.0, seed=1021, speed_mps=0.3)
    assert run(batch_of(truth)).distance_m == pytest.approx(truth.distance_m, rel=0.02)


def test_a_gyroscope_may_be_off_by_a_degree_a_second(walk, batch_of, run):
    truth = walk(8.0, seed=1022, conditions=[("sway_rad", 0.03)])
    batch = batch_of(truth)
    channels = dict(batch.channels) | {
        "gyro": batch.channels["gyro"] + math.radians(1.0) * np.array([0.6, -0.6, 0.5])
    }
    off = SampleBatch(batch.t_ns, batch.period_s, 0, channels)
    assert run(off).distance_m == pytest.approx(truth.distance_m, rel=0.01)


def test_sigma_is_honest(walk, batch_of, run):
    z = []
    for seed in range(1030, 1042):
        truth = walk(4.0, seed=seed, rate_hz=50.0)
        told = run(batch_of(truth))
        z.append((told.distance_m - truth.distance_m) / told.sigma_m)
    assert 0.3 < math.sqrt(np.mean(np.square(z))) < 1.6


def test_a_wrong_lever_shows_as_its_sigma_says(walk, batch_of, run):
    truth = walk(12.0, seed=1043)
    told = run(batch_of(truth), height_m=0.565, imu_to_tip_sigma_m=0.01)
    assert told.distance_m != pytest.approx(truth.distance_m, rel=0.004)
    assert abs(told.distance_m - truth.distance_m) < 1.5 * told.sigma_m


def test_the_published_method_runs(walk, batch_of, run):
    truth = walk(8.0, 0.315, seed=1044)
    default, published = (
        run(batch_of(truth), height_m=0.315, method=method) for method in ("default", "published")
    )
    assert abs(default.distance_m - truth.distance_m) < abs(
        published.distance_m - truth.distance_m
    )
