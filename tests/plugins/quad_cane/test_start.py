"""How it begins: without ceremony, with what there is, and nothing said before."""

import numpy as np
import pytest

from gaitway.api import ACCEL, GYRO, SampleBatch
from gaitway.simulation import rest
from gaitway_plugins.quad_cane.estimator import QuadCaneEstimator
from gaitway_plugins.quad_cane.params import QuadCaneParams

SEED = 12


@pytest.fixture(scope="module")
def truth(walk):
    return walk(5.0, seed=SEED)


def test_it_begins_in_the_middle_of_a_walk_with_the_first_stillness(truth, batch_of, run):
    batch = batch_of(truth)
    start = round((truth.stride_end_s[1] - 0.3) / batch.period_s)
    result = run(batch[start:])
    assert len(result.strides) >= len(truth.stride_length_m) - 4
    known_m = truth.stride_length_m[-len(result.strides) :].sum()
    assert result.distance_m == pytest.approx(known_m, abs=0.03)


def test_nothing_is_said_before_the_first_stillness(truth, batch_of, run):
    batch = batch_of(truth)
    lift_s = truth.stride_start_s[0]
    in_the_air = batch[round((lift_s + 0.2) / batch.period_s) :][:60]
    assert run(in_the_air).events == []


@pytest.mark.parametrize("bias_radps", [np.radians(1.0), -np.radians(1.0)])
def test_a_gyroscope_bias_of_a_degree_per_second_at_turn_on_costs_nothing(
    truth, batch_of, run, bias_radps
):
    batch = batch_of(truth)
    biased = {**batch.channels, GYRO.name: batch.channels[GYRO.name] + bias_radps}
    result = run(SampleBatch(batch.t_ns, batch.period_s, 0, biased))
    assert result.distance_m == pytest.approx(truth.distance_m, abs=0.03)
    assert len(result.strides) == len(truth.stride_length_m)


def test_a_gyroscope_bias_that_wanders_while_walking_is_followed(walk, batch_of, run):
    """Half a degree per second within 80 s: far more than an hour of an MTi-1."""
    truth = walk(16.0, seed=SEED)
    batch = batch_of(truth)
    drift = np.linspace(0.0, np.radians(0.5), len(batch))[:, None] * [1.0, -0.7, 0.5]
    drifting = {**batch.channels, GYRO.name: batch.channels[GYRO.name] + drift}
    result = run(SampleBatch(batch.t_ns, batch.period_s, 0, drifting))
    assert result.distance_m == pytest.approx(truth.distance_m, rel=0.01)
    assert len(result.strides) == len(truth.stride_length_m)


def test_an_empty_stream_ends_quietly(run):
    assert run().events == []


def test_a_new_sample_period_begins_anew_and_keeps_the_books(walk, batch_of, run):
    slow, fast = walk(3.0, seed=1, rate_hz=50.0), walk(3.0, seed=2, rate_hz=100.0)
    first = batch_of(slow)
    second = batch_of(fast, int(first.t_ns[-1]) + 20_000_000)
    result = run(first, second)
    assert result.distance_m == pytest.approx(slow.distance_m + fast.distance_m, abs=0.04)


def test_a_bias_that_drifts_while_the_cane_stands_is_followed_on_every_axis(by_hand, batch_of):
    standing = by_hand([rest(1.0, 0.0, 0.0, 0.0)], [rest(1.0, 0.0, 0.0, 0.0)], 120.0)
    batch = batch_of(standing)
    drift = np.linspace(0.0, 2e-3, len(batch))[:, None] * [1.0, -1.0, 1.0]
    gyro = batch.channels[GYRO.name] + drift
    estimator = QuadCaneEstimator(QuadCaneParams())
    estimator.update(SampleBatch(batch.t_ns, batch.period_s, 0, {**batch.channels, "gyro": gyro}))
    found = estimator._stretch.navigator._kf.gyro_bias_d
    now = gyro[-500:].mean(axis=0)
    before = gyro[:500].mean(axis=0)
    assert np.abs(found - now).max() < 0.6 * np.abs(before - now).max()


def test_an_accelerometer_that_is_five_percent_off_is_not_worked_with(truth, batch_of, run):
    """Its rest is no contact by the paper's test, so nothing that follows could be trusted."""
    batch = batch_of(truth)
    scaled = {**batch.channels, ACCEL.name: 1.05 * batch.channels[ACCEL.name]}
    assert run(SampleBatch(batch.t_ns, batch.period_s, 0, scaled)).events == []
