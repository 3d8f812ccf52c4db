"""What must not matter: how the stream is cut, when it was recorded, how it is looked at."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitway.api import ACCEL, GYRO, Gap, SampleBatch, Stride
from gaitway_plugins.quad_cane.estimator import QuadCaneEstimator
from gaitway_plugins.quad_cane.params import QuadCaneParams

SEED = 8


@pytest.fixture(scope="module")
def stream(walk, batch_of):
    return batch_of(walk(2.0, seed=SEED, rest_s=1.5))


def cut(batch, edges):
    inside = sorted({edge % len(batch) for edge in edges} | {0})
    return [batch[a:b] for a, b in pairwise([*inside, len(batch)])]


@given(edges=st.lists(st.integers(0, 10_000), max_size=30))
@settings(max_examples=8, deadline=None)
def test_how_the_stream_is_cut_changes_nothing(stream, run, edges):
    assert run(*cut(stream, edges)).events == run(stream).events


@pytest.mark.parametrize("size", [1, 3, 7, 64])
def test_batches_of_any_size_give_the_same_events(stream, run, size):
    assert run(*cut(stream, range(0, len(stream), size))).events == run(stream).events


@given(edges=st.lists(st.integers(0, 10_000), max_size=30))
@settings(max_examples=4, deadline=None)
def test_cutting_around_a_gap_changes_nothing(stream, run, without, edges):
    holed = without(stream, (3.0, 3.3), (4.5, 4.55))
    finer = [
        part for item in holed for part in ([item] if isinstance(item, Gap) else cut(item, edges))
    ]
    assert run(*finer).events == run(*holed).events


def test_an_hour_later_everything_is_an_hour_later(stream, run):
    hour_ns = 3_600_000_000_000
    later = SampleBatch(stream.t_ns + hour_ns, stream.period_s, stream.sequence, stream.channels)
    moved = [
        event.model_copy(
            update={
                name: getattr(event, name) - hour_ns
                for name in ("t_ns", "start_t_ns", "since_t_ns", "lift_t_ns")
                if getattr(event, name, None) is not None
            }
        )
        for event in run(later).events
    ]
    assert moved == run(stream).events


@pytest.mark.parametrize("settle_s", [0.3, 5.0])
def test_strides_are_told_no_later_than_the_look_ahead(stream, settle_s):
    """However long a stance is given to settle: what is not known in time is not waited for."""
    estimator = QuadCaneEstimator(QuadCaneParams(settle_s=settle_s))
    late_s = []
    for row in range(len(stream)):
        events = estimator.update(stream[row : row + 1])
        late_s += [(stream.t_ns[row] - e.t_ns) / 1e9 for e in events if isinstance(e, Stride)]
    assert len(late_s) >= 4
    assert max(late_s) <= estimator.look_ahead_s + 1e-9
    assert min(late_s) >= estimator.look_ahead_s - 2 * stream.period_s


def test_looking_at_the_trace_changes_no_event(stream, run):
    traced = QuadCaneEstimator(QuadCaneParams())
    trace = traced.start_trace()
    events = [*traced.update(stream), *traced.finish()]
    assert events == run(stream).events
    assert np.diff(trace.t_ns).min() > 0
    assert trace.t_ns == stream.t_ns.tolist()


def test_the_trace_follows_the_true_way(walk, batch_of):
    truth = walk(2.0, seed=SEED, rest_s=1.5)
    estimator = QuadCaneEstimator(QuadCaneParams(imu_height_m=0.5))
    trace = estimator.start_trace()
    estimator.update(batch_of(truth))
    estimator.finish()
    rows = np.array(trace.rows)
    columns = {name: rows[:, n] for n, name in enumerate(trace.columns)}
    way_m = np.hypot(columns["pos_x_m"], columns["pos_y_m"])
    true_m = np.hypot(*(truth.pos_n - truth.pos_n[0])[:, :2].T)
    known = np.isfinite(way_m)
    assert known[60:-7].all()
    assert np.abs(way_m - true_m)[known].max() < 0.02
    still = columns["contact"] == 1.0
    assert np.abs(columns["vel_x_mps"][still]).max() < 0.05
    assert columns["walking"][:-7].min() == 1.0


def test_the_clip_channel_may_be_missing(stream, run):
    bare = SampleBatch(
        stream.t_ns,
        stream.period_s,
        0,
        {name: stream.channels[name] for name in (ACCEL.name, GYRO.name)},
    )
    assert run(bare).events == run(stream).events
