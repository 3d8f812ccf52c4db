"""Batches, gaps, restarts: how the samples come changes nothing, and what is missing is said."""

import numpy as np
import pytest

from gaitway.api import SampleBatch


@pytest.mark.parametrize("size", [1, 7, 100])
def test_splitting_batches_changes_nothing(walk, batch_of, run, size):
    batch = batch_of(walk(3.0, seed=3))
    pieces = [batch[start : start + size] for start in range(0, len(batch), size)]
    assert run(*pieces).events == run(batch).events


def test_every_event_is_told_within_the_look_ahead(walk, batch_of, estimator):
    one, batch = estimator(), batch_of(walk(6.0, seed=3))
    for start in range(len(batch)):
        for event in one.update(batch[start : start + 1]):
            if event.kind == "stride":
                late_s = (int(batch.t_ns[start]) - event.t_ns) / 1e9
                assert late_s <= one.look_ahead_s + 2 * batch.period_s


def test_a_restart_in_a_walk_goes_on_as_if_nothing_had_happened(walk, batch_of, run, estimator):
    batch = batch_of(walk(6.0, seed=3))
    for at in (len(batch) // 2, len(batch) // 2 + 37):
        first, second = estimator(), estimator()
        events = list(first.update(batch[:at]))
        second.restore(first.save())
        events += [*second.update(batch[at:]), *second.finish()]
        assert events == run(batch).events


def test_a_damaged_state_is_refused(estimator):
    state = bytearray(estimator().save())
    state[-3] ^= 1
    with pytest.raises(ValueError, match="state"):
        estimator().restore(bytes(state))


def test_samples_lost_at_random_cost_next_to_nothing(walk, batch_of, run, without):
    truth = walk(12.0, seed=4)
    batch = batch_of(truth)
    lost_s = np.sort(np.random.default_rng(1).choice(len(batch) - 20, len(batch) // 50, False)) + 10
    lost_s = lost_s[np.diff(lost_s, prepend=-9) > 1] * batch.period_s
    told = run(*without(batch, *((t_s, t_s + batch.period_s) for t_s in lost_s.tolist())))
    assert told.distance_m == pytest.approx(truth.distance_m, rel=0.01)


@pytest.mark.parametrize("phase", [0.2, 0.5, 0.8])
def test_half_a_second_missing_costs_no_distance(walk, batch_of, run, without, phase):
    truth = walk(20.0, seed=5)
    at_s = float(truth.stride_start_s[9] * (1 - phase) + truth.stride_end_s[9] * phase)
    told = run(*without(batch_of(truth), (at_s, at_s + 0.5)))
    assert len(told.strides) == len(truth.stride_length_m)
    assert "gap-in-stride" in told.anomalies
    assert told.distance_m == pytest.approx(truth.distance_m, rel=0.01)
    assert told.sigma_m > run(batch_of(truth)).sigma_m


def test_many_seconds_missing_are_unmeasured_and_never_invented(walk, batch_of, run, without):
    truth = walk(20.0, seed=5)
    told = run(*without(batch_of(truth), (8.0, 15.0)))
    assert told.distance_m < truth.distance_m
    assert told.distances[-1].unmeasured_s >= 7.0
    assert "distance-untrusted" in told.anomalies
    assert truth.distance_m - told.distance_m < 3.0 * told.sigma_m


def test_a_clipped_swing_is_said(walk, batch_of, run):
    truth = walk(6.0, seed=3)
    batch = batch_of(truth)
    clip = np.array(batch.channels["clip"])
    clip[round(float(truth.stride_end_s[2] - 0.2) / batch.period_s)] = 8.0
    told = run(SampleBatch(batch.t_ns, batch.period_s, 0, dict(batch.channels) | {"clip": clip}))
    assert told.anomalies == ["sensor-clipped"]
    assert told.sigma_m > run(batch).sigma_m
