from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.estimation import Break, GapBridge, ImuSample
from gaitway.samples import Gap, SampleBatch, frozen_rows

PERIOD_S = 0.01
STEP_NS = 10_000_000


def batch(first, count, *, clip=False, spoil=None):
    number = np.arange(first, first + count)
    accel = np.column_stack([number, 2.0 * number, np.full(count, 9.8)])
    if spoil is not None:
        accel[spoil, 1] = np.nan
    channels = {"accel": frozen_rows(accel, 3), "gyro": frozen_rows(0.1 * accel, 3)}
    if clip:
        channels["clip"] = frozen_rows((number == first) * 4.0, 1)
    return SampleBatch(number * STEP_NS, PERIOD_S, first, channels)


def gap(first, count, reason="lost"):
    return Gap(first * STEP_NS, count, reason)


def through(*items, max_bridge_s=0.05):
    bridge = GapBridge(max_bridge_s)
    return [entry for item in items for entry in bridge.feed(item)]


def test_samples_pass_with_their_times():
    out = through(batch(0, 3))
    assert [entry.t_ns for entry in out] == [0, STEP_NS, 2 * STEP_NS]
    assert out[1].accel_d == (1.0, 2.0, 9.8)
    assert not any(entry.bridged or entry.clipped for entry in out)


def test_a_short_gap_is_bridged_in_a_straight_line():
    out = through(batch(0, 2), gap(2, 3), batch(5, 2))
    assert [entry.t_ns // STEP_NS for entry in out] == list(range(7))
    assert [entry.bridged for entry in out] == [False] * 2 + [True] * 3 + [False] * 2
    assert [entry.accel_d[0] for entry in out] == pytest.approx(range(7))


def test_a_long_gap_is_a_break_from_the_last_sample_to_the_next():
    out = through(batch(0, 2), gap(2, 6), batch(8, 2))
    assert out[2] == Break(STEP_NS, pytest.approx(7 * PERIOD_S))
    assert [type(entry) for entry in out] == [ImuSample, ImuSample, Break, ImuSample, ImuSample]


@pytest.mark.parametrize(("missing", "kind"), [(5, ImuSample), (6, Break)])
def test_the_longest_gap_that_is_bridged_is_as_said(missing, kind):
    out = through(batch(0, 2), gap(2, missing), batch(2 + missing, 2), max_bridge_s=0.05)
    assert type(out[2]) is kind


def test_gaps_that_follow_each_other_add_up():
    assert type(through(batch(0, 2), gap(2, 3), gap(5, 3), batch(8, 2))[2]) is Break


def test_a_restarted_device_is_never_bridged():
    assert type(through(batch(0, 2), gap(2, 1, "device-restart"), batch(3, 2))[2]) is Break


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300, 1e9])
def test_a_sample_that_can_be_none_is_bridged(value):
    spoilt = batch(0, 5)
    accel = spoilt.channels["accel"].copy()
    accel[2, 0] = value
    channels = {**spoilt.channels, "accel": accel}
    out = through(SampleBatch(spoilt.t_ns, PERIOD_S, 0, channels))
    assert [entry.bridged for entry in out] == [False, False, True, False, False]
    assert out[2].accel_d == pytest.approx((2.0, 4.0, 9.8))


def test_a_gap_before_the_first_sample_is_nothing():
    assert through(gap(0, 100), batch(100, 1))[0].t_ns == 100 * STEP_NS


def test_clip_flags_reach_the_samples_and_those_bridged_from_them():
    out = through(batch(0, 2, clip=True), gap(2, 1), batch(3, 2, clip=True))
    assert [entry.clipped for entry in out] == [True, False, True, True, False]


@given(st.lists(st.integers(1, 29), max_size=6), st.integers(10, 17))
def test_how_the_stream_is_cut_changes_nothing(cuts, missing_from):
    def items(cuts):
        whole = [batch(0, missing_from), gap(missing_from, 3), batch(missing_from + 3, 10)]
        for item in whole:
            if isinstance(item, Gap):
                yield item
                continue
            edges = sorted({0, len(item), *(cut for cut in cuts if cut < len(item))})
            yield from (item[a:b] for a, b in pairwise(edges))

    assert through(*items(cuts)) == through(*items([]))
