"""The parts of the ankle by themselves."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.api import Stride, WalkPlan
from gaitway.estimation.rotation import normalized, rotate
from gaitway.registry import load_registry
from gaitway_plugins.ankle.books import Books, Told
from gaitway_plugins.ankle.lever import Lever
from gaitway_plugins.ankle.motion import rotated
from gaitway_plugins.ankle.navigator import Anchor
from gaitway_plugins.ankle.params import AnkleParams
from gaitway_plugins.ankle.published import PublishedEstimator
from gaitway_plugins.ankle.quiet import QuietDetector
from gaitway_plugins.ankle.simulation import STAIR_RISE_M, simulate
from gaitway_plugins.ankle.way import Way

numbers = st.floats(-5.0, 5.0)


@given(st.tuples(*[st.floats(0.1, 1.0)] * 4), st.tuples(*[numbers] * 3))
def test_many_vectors_rotate_as_one_does(q, vector):
    q = normalized(q)
    told = rotated(np.array([q, q]), np.array([vector, vector]))
    np.testing.assert_allclose(told, [rotate(q, vector)] * 2, atol=1e-12)


@pytest.mark.parametrize("scale", [0.3, 1.0, 1.5])
def test_finds_one_quiet_part_a_stance_at_any_pace(scale):
    detector = QuietDetector(AnkleParams(), 0.01)
    t = np.arange(0.0, 8.0, 0.01)
    swinging = (t % 1.2) > 0.8
    rate = scale * np.where(swinging, -5.0 * np.sin(np.pi * ((t % 1.2) - 0.8) / 0.4) ** 2, 0.6)
    found = [
        quiet
        for value in rate
        if (quiet := detector.push((0.0, 0.0, 9.81), (0.0, float(value), 0.0))) is not None
    ]
    assert len(found) == 6
    for number, quiet in enumerate(found):
        assert 1.2 * number <= quiet.middle * 0.01 <= 1.2 * number + 0.8


def test_standing_is_no_peak():
    detector = QuietDetector(AnkleParams(), 0.01)
    rng = np.random.default_rng(1)
    for _ in range(1000):
        gyro = tuple((0.02 * rng.standard_normal(3)).tolist())
        assert detector.push((0.0, 0.1, 9.8), gyro) is None
    assert not detector.moving
    assert detector.quiet_since == 0


def test_a_lever_arm_turns_with_the_mounting(tools):
    lever = Lever.of(AnkleParams(lever_arm_m=(0.1, 0.02, 0.03)), tools.C_db)
    np.testing.assert_allclose(lever.pivot_to_imu_d, (0.03, -0.02, 0.1), atol=1e-12)
    np.testing.assert_allclose(lever.imu_to_pivot_d, (-0.03, 0.02, -0.1), atol=1e-12)


def test_published_is_near_where_zero_velocity_is_short(tools):
    walk = tools.heel(distance_m=20.0, seed=1)
    batch = tools.heel_batch(walk)
    told = {}
    for method in ("published", "zupt"):
        params = AnkleParams(method=method, lever_arm_m=tools.LEVER_B)
        events = tools.said(PublishedEstimator(params, tools.C_db), batch)
        told[method] = tools.distance(events).distance_m / walk.distance_m
    assert told["published"] == pytest.approx(1.0, abs=0.036)
    assert told["zupt"] < 0.93


@pytest.mark.parametrize("size", [1, 7, 100])
def test_batches_change_nothing_of_the_published_method(tools, size):
    batch = tools.heel_batch(tools.heel(distance_m=8.0, seed=1))
    params = AnkleParams(method="published", lever_arm_m=tools.LEVER_B)
    told = tools.said(PublishedEstimator(params, tools.C_db), batch, size)
    assert told == tools.said(PublishedEstimator(params, tools.C_db), batch, 1000)


def test_published_goes_on_after_a_restart(tools):
    batch = tools.heel_batch(tools.heel(distance_m=8.0, seed=1))
    params = AnkleParams(method="published", lever_arm_m=tools.LEVER_B)
    before, after = (PublishedEstimator(params, tools.C_db) for _ in range(2))
    events = list(before.update(batch[:510]))
    after.restore(before.save())
    events += tools.said(after, batch[510:])
    assert events == tools.said(PublishedEstimator(params, tools.C_db), batch)


def test_stairs_of_the_simulation_climb_two_steps_a_stride():
    walk = simulate(WalkPlan(5.0, seed=1, conditions={"terrain": "stairs-up"}))
    heights_m = walk.truth["stride_height_m"]
    np.testing.assert_allclose(heights_m[1:-1], 2.0 * STAIR_RISE_M)
    climbed_m = walk.pos_n[-1, 2] - walk.pos_n[0, 2]
    assert climbed_m == pytest.approx(heights_m.sum(), abs=0.005)


def test_a_straight_level_walk_is_as_long_as_planned():
    for distance_m in (3.0, 40.0):
        walk = simulate(WalkPlan(distance_m, seed=2))
        assert walk.distance_m == pytest.approx(distance_m, rel=0.005)


@pytest.mark.parametrize("conditions", [{"terrain": "sand"}, {"weather": "rain"}])
def test_the_simulation_refuses_what_it_does_not_know(conditions):
    with pytest.raises(ValueError, match="terrain"):
        simulate(WalkPlan(5.0, conditions=conditions))


def test_the_summary_adds_height_and_the_path_in_space(tools):
    device = load_registry().devices["ankle"]
    walk = tools.heel(distance_m=6.0, length_m=0.56, rise_m=0.34, seed=1)
    estimator = device.make_estimator(AnkleParams(lever_arm_m=tools.LEVER_B), tools.C_db)
    events = tools.said(estimator, tools.heel_batch(walk))
    summary = device.summarise(events)
    assert summary["height_m"] == pytest.approx(walk.height_m, rel=0.02)
    strides = [event for event in events if isinstance(event, Stride)]
    path_m = sum(np.hypot(s.stride_length_m, s.height_change_m) for s in strides)
    assert summary["path_length_m"] == pytest.approx(path_m)
    json.dumps(summary)
    assert device.summarise([])["height_m"] is None


def told_stride(number, length_m):
    zero, q_nd = np.zeros(3), (1.0, 0.0, 0.0, 0.0)
    ends = [Anchor(110 * k, 1_100_000_000 * k, zero, q_nd, np.zeros((3, 3)), 0.0)
            for k in (number, number + 1)]  # fmt: skip
    step_n, covariance = np.array([length_m, 0.0, 0.0]), np.eye(3) * 1e-4
    way = Way(ends[0], ends[1], step_n, covariance, 0, 1, 3.0, 1.0, 1.0, doubtful=False)
    begin, end = ends[0].t_ns, ends[1].t_ns
    return Told(way, begin, (begin + end) // 2, end, 0.0)


@pytest.mark.parametrize(("lengths_m", "low", "high"), [
    ([1.2] * 6, 0.12 * 1.2, 0.2), ([0.4] * 4 + [0.6, 1.2, 1.2], 0.28, 0.6),
])  # fmt: skip
def test_a_gap_goes_on_at_the_last_pace_and_says_how_steady_that_was(lengths_m, low, high):
    books = Books(AnkleParams(), Lever((0.0, 0.0, 0.1), (0.0, 0.0, 0.0)))
    books.begin(0)
    for number, length_m in enumerate(lengths_m):
        books.stride(told_stride(number, length_m))
    now_ns = 1_100_000_000 * len(lengths_m)
    events = books.unseen(now_ns, now_ns + 1_100_000_000, "gap-in-stride", "")
    (filled,) = [event for event in events if isinstance(event, Stride)]
    assert filled.stride_length_m == pytest.approx(1.2)
    assert low <= filled.stride_length_sigma_m < high
