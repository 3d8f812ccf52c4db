import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gaitway.recording.items import LinkChange
from gaitway.recording.lane import LaneItem
from gaitway.recording.merging import MAX_SAMPLES, merge_samples
from gaitway.samples import SampleBatch


def batch(sequence, n=2, period_s=0.01, channel="force", width=1):
    t_ns = (np.arange(n) + sequence) * 10_000_000
    values = np.arange(sequence, sequence + n, dtype=np.float64)
    return SampleBatch(t_ns, period_s, sequence, {channel: np.repeat(values[:, None], width, 1)})


def lane(*bodies, device="left"):
    return [LaneItem(device, body) for body in bodies]


def sequences(items):
    return [(item.device, item.body.sequence, len(item.body)) for item in items]


def test_batches_that_follow_each_other_become_one():
    (item,) = merge_samples(lane(batch(0), batch(2), batch(4, n=1)))
    assert sequences([item]) == [("left", 0, 5)]
    assert item.body.t_ns.tolist() == [0, 10_000_000, 20_000_000, 30_000_000, 40_000_000]
    assert item.body.channels["force"].ravel().tolist() == [0, 1, 2, 3, 4]


def test_what_does_not_follow_stays_apart():
    items = lane(
        batch(0), batch(3), batch(5, period_s=0.02), batch(7, channel="inclination"),
        batch(9, channel="inclination", width=2),
    )  # fmt: skip
    assert merge_samples(items) == items


def test_devices_are_merged_each_by_itself():
    left, right = lane(batch(0), batch(2)), lane(batch(0), batch(2), device="right")
    mixed = [left[0], right[0], left[1], right[1]]
    assert sequences(merge_samples(mixed)) == [("left", 0, 4), ("right", 0, 4)]


def test_everything_else_keeps_its_place():
    link = LinkChange(1, "opening", "")
    merged = merge_samples(lane(batch(0), link, batch(2), link))
    assert [type(item.body) for item in merged] == [LinkChange, SampleBatch, LinkChange]


@given(st.lists(st.tuples(st.sampled_from("ab"), st.integers(1, 90), st.integers(0, 1))))
def test_no_sample_is_lost_changed_or_moved_among_those_of_its_device(steps):
    at, items = {"a": 0, "b": 0}, []
    for device, n, hole in steps:
        at[device] += hole
        items.append(LaneItem(device, batch(at[device], n=n)))
        at[device] += n

    def values(found, device):
        mine = [item.body.channels["force"] for item in found if item.device == device]
        return np.concatenate([np.empty((0, 1)), *mine]).ravel().tolist()

    merged = merge_samples(items)
    assert all(len(item.body) <= MAX_SAMPLES for item in merged)
    assert [values(merged, device) for device in "ab"] == [values(items, d) for d in "ab"]
