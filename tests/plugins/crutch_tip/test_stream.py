"""What must not matter: how the stream is cut, that the gateway restarts, how it is looked at."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitway.api import FORCE, GYRO, Bout, Gap, Load, SampleBatch
from gaitway_plugins.crutch_tip.estimator import CrutchTipEstimator
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.stream import Stream


@pytest.fixture(scope="module")
def stream(walk, batch_of):
    return batch_of(walk())


def cut(batch, edges):
    inside = sorted({edge % len(batch) for edge in edges} | {0})
    return [batch[a:b] for a, b in pairwise([*inside, len(batch)])]


@pytest.mark.parametrize("method", ["default", "published"])
@pytest.mark.parametrize("size", [1, 7, 100])
def test_batches_of_any_size_give_the_same_events_and_trace(stream, run, size, method):
    whole = run(stream, method=method)
    parts = run(*cut(stream, range(0, len(stream), size)), method=method)
    assert parts.events == whole.events
    np.testing.assert_array_equal(parts.rows, whole.rows)


@given(edges=st.lists(st.integers(0, 10_000), max_size=20))
@settings(max_examples=8, deadline=None)
def test_cutting_around_gaps_changes_nothing(stream, run, without, edges):
    holed = without(stream, (3.0, 3.05), (6.0, 6.5))
    finer = [
        part for item in holed for part in ([item] if isinstance(item, Gap) else cut(item, edges))
    ]
    assert run(*finer).events == run(*holed).events


def test_nothing_is_lost_or_invented_over_a_restart_in_mid_walk(stream, walk, run):
    """Saved between two samples, half a second is missed, and another estimator goes on."""
    first, second = (CrutchTipEstimator(CrutchTipParams()) for _ in range(2))
    lift_s = walk().truth["lift_s"][4]
    row = round((lift_s + 0.2) / stream.period_s)
    missed = round(0.3 / stream.period_s)
    events = list(first.update(stream[:row]))
    second.restore(first.save())
    events += second.update(Gap(int(stream.t_ns[row]), missed, "gateway-restart"))
    events += second.update(stream[row + missed :])
    events += second.finish()
    whole = run(stream)
    assert sum(isinstance(event, Load) for event in events) == len(whole.loads)
    steps = sum(event.strides or 0 for event in events if isinstance(event, Bout))
    assert steps == whole.steps


def test_saved_and_restored_between_two_samples_every_event_is_the_same(stream, run):
    first, second = (CrutchTipEstimator(CrutchTipParams()) for _ in range(2))
    events = list(first.update(stream[:777]))
    second.restore(first.save())
    events += [*second.update(stream[777:]), *second.finish()]
    assert events == run(stream).events


def test_a_load_is_told_no_later_than_the_look_ahead(stream):
    estimator = CrutchTipEstimator(CrutchTipParams())
    late_s = []
    for row in range(len(stream)):
        events = estimator.update(stream[row : row + 1])
        late_s += [(stream.t_ns[row] - e.t_ns) / 1e9 for e in events if isinstance(e, Load)]
    assert len(late_s) >= 8
    assert max(late_s) <= estimator.look_ahead_s + stream.period_s


@given(
    lost=st.lists(st.tuples(st.integers(1, 90), st.integers(1, 30)), max_size=4),
    holes=st.lists(st.integers(0, 99), max_size=5),
)
@settings(max_examples=50, deadline=None)
def test_rows_never_have_holes_and_never_go_back_in_time(made, lost, holes):
    batch = made(1.0)
    gyro = batch.channels[GYRO.name].copy()
    gyro[holes] = np.nan
    batch = SampleBatch(batch.t_ns, batch.period_s, 0, {**batch.channels, GYRO.name: gyro})
    stream, rows, at = Stream(CrutchTipParams()), [], 0
    for begin, count in sorted(lost):
        if begin < at:
            continue
        rows += stream.feed(batch[at:begin]) + stream.feed(Gap(int(batch.t_ns[begin]), count, "x"))
        at = min(begin + count, len(batch))
    rows += stream.feed(batch[at:])
    told = [row for row in rows if hasattr(row, "values")]
    assert all(np.isfinite(row.values[:, :5]).all() for row in told)
    times = np.concatenate([row.t_ns for row in told]) if told else np.empty(0)
    assert (np.diff(times) > 0).all()


def test_short_holes_are_bridged_whether_told_as_gap_or_as_nan(stream, run, without):
    gone = without(stream, (5.0, 5.05))
    force = stream.channels[FORCE.name].copy()
    force[500:505] = np.nan
    blind = SampleBatch(stream.t_ns, stream.period_s, 0, {**stream.channels, FORCE.name: force})
    whole = run(stream)
    assert len(run(*gone).loads) == len(whole.loads)
    assert run(blind).events == run(*gone).events
