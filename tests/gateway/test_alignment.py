import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.alignment import Aligner
from gaitway.samples import DeviceBatch, Fault, Gap, SampleBatch, frozen_rows
from gaitway.timebase import NS_PER_S

PERIOD_NS = 10_000_000
HOST_NS = 5_000 * NS_PER_S


def device_batch(indices, arrival_ns=None, *, restarted=False, base_ns=0):
    device_ns = np.array([base_ns + index * PERIOD_NS for index in indices], dtype=np.int64)
    if arrival_ns is None:
        arrival_ns = HOST_NS + int(indices[-1]) * PERIOD_NS
    rows = frozen_rows([[index, 0.0, 9.8] for index in indices], 3)
    return DeviceBatch(arrival_ns, device_ns, 0.01, {"accel": rows}, restarted)


def align(*batches):
    aligner = Aligner()
    return [item for batch in batches for item in aligner.align(batch)]


def gaps(items):
    return [(item.n_missing, item.reason) for item in items if isinstance(item, Gap)]


def seen(items):
    return [
        int(row) for item in items if isinstance(item, SampleBatch)
        for row in item.channels["accel"][:, 0]
    ]  # fmt: skip


def test_samples_in_a_row_make_one_batch_without_gap():
    items = align(device_batch(range(5)), device_batch(range(5, 9)))
    assert gaps(items) == []
    assert [item.sequence for item in items] == [0, 5]


def test_a_hole_within_a_batch_is_a_gap_of_that_many_samples():
    items = align(device_batch([0, 1, 2, 10, 11]))
    assert gaps(items) == [(7, "lost")]
    assert [item.sequence for item in items if isinstance(item, SampleBatch)] == [0, 10]


def test_the_gap_begins_where_the_first_missing_sample_was():
    items = align(device_batch([0, 1, 5]))
    first, gap, second = items
    assert gap.t_ns == first.t_ns[-1] + PERIOD_NS
    assert second.t_ns[0] == gap.t_ns + 3 * PERIOD_NS


@given(
    present=st.lists(st.booleans(), min_size=5, max_size=80).filter(any),
    cuts=st.lists(st.integers(1, 10), max_size=80),
)
def test_however_samples_are_lost_and_batched_none_is_invented(present, cuts):
    indices = [index for index, here in enumerate(present) if here]
    batches, start = [], 0
    for size in [*cuts, len(indices)]:
        if indices[start : start + size]:
            batches.append(device_batch(indices[start : start + size]))
        start += size
    items = align(*batches)
    assert seen(items) == indices
    missing = sum(item.n_missing for item in items if isinstance(item, Gap))
    assert missing == indices[-1] - indices[0] + 1 - len(indices)


def test_a_sample_told_twice_or_late_is_dropped_and_counted():
    items = align(device_batch([0, 1, 2]), device_batch([1, 2, 3]))
    assert seen(items) == [0, 1, 2, 3]
    assert [(item.kind, item.count) for item in items if isinstance(item, Fault)] == [
        ("time-reversed", 2)
    ]


def test_a_restarted_device_gives_a_gap_measured_in_host_time():
    away = device_batch([0, 1], HOST_NS + 30 * NS_PER_S, restarted=True)
    items = align(device_batch([500, 501], HOST_NS), away)
    ((n_missing, reason),) = gaps(items)
    assert reason == "device-restart"
    assert abs(n_missing - 3000) <= 2


def test_a_device_clock_that_jumps_back_unannounced_counts_as_a_restart():
    items = align(device_batch([500, 501], HOST_NS), device_batch([0, 1], HOST_NS + NS_PER_S))
    assert seen(items) == [500, 501, 0, 1]
    assert gaps(items)[0][1] == "device-restart"


def test_a_device_clock_that_leaps_ahead_of_host_time_counts_as_a_restart():
    """Otherwise an hour would be reported missing that never passed."""
    items = align(device_batch([0, 1], HOST_NS), device_batch([360_000], HOST_NS + 2 * PERIOD_NS))
    ((n_missing, reason),) = gaps(items)
    assert (n_missing, reason) == (1, "device-restart")


def test_a_link_that_was_down_keeps_the_devices_own_count():
    aligner = Aligner()
    aligner.align(device_batch([0, 1]))
    aligner.link_opened()
    items = aligner.align(device_batch([1000, 1001]))
    assert gaps(items) == [(998, "link-down")]


def test_stamps_rise_over_everything_that_can_happen():
    items = align(
        device_batch(range(50)),
        device_batch(range(45, 60)),
        device_batch([400], HOST_NS + 400 * PERIOD_NS),
        device_batch([0, 1], HOST_NS + 401 * PERIOD_NS, restarted=True),
    )
    stamps = np.concatenate([item.t_ns for item in items if isinstance(item, SampleBatch)])
    assert (np.diff(stamps) > 0).all()


def test_one_that_goes_on_from_a_saved_state_stamps_and_counts_as_if_nothing_had_been():
    original, restored = Aligner(), Aligner()
    rng = np.random.default_rng(0)
    for start in range(0, 60_000, 100):  # ten minutes: windows, slew and drift are all at work
        arrival_ns = HOST_NS + round((start + 99) * PERIOD_NS * (1 + 3e-5))
        late_ns = int(rng.exponential(2e6))
        original.align(device_batch(range(start, start + 100), arrival_ns + late_ns))
    restored.restore(json.loads(json.dumps(original.save())))
    original.link_opened()
    restored.link_opened()
    late = device_batch(range(60_500, 60_520), HOST_NS + round(60_520 * PERIOD_NS * (1 + 3e-5)))
    (gap, batch), (gap2, batch2) = original.align(late), restored.align(late)
    assert (gap.n_missing, gap.reason) == (500, "link-down")
    assert gap2 == gap
    assert (batch2.t_ns.tolist(), batch2.sequence) == (batch.t_ns.tolist(), batch.sequence)


def test_a_restored_one_estimates_the_gap_when_the_device_s_clock_began_anew():
    original, restored = Aligner(), Aligner()
    original.align(device_batch(range(1000, 1100)))
    restored.restore(original.save())
    items = restored.align(device_batch(range(5), HOST_NS + 1204 * PERIOD_NS))
    assert gaps(items) == [(100, "device-restart")]


@pytest.mark.parametrize("lost", ["clock", "last_device_ns", "last_t_ns", "sequence"])
def test_a_state_that_lacks_something_changes_nothing(lost):
    aligner = Aligner()
    aligner.align(device_batch(range(9)))
    before = aligner.save()
    with pytest.raises(LookupError):
        aligner.restore({key: value for key, value in before.items() if key != lost})
    assert aligner.save() == before
