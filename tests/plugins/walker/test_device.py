"""The walker as the gateway sees it: simulation, summary, samples that come live."""

from collections import Counter

import numpy as np
import pytest

from gaitway.api import SampleBatch, WalkPlan
from gaitway.registry import load_registry
from gaitway_plugins.walker.simulation import simulate

STYLES = ["continuous", "step-by-step", "full-lift", "back-tips"]


@pytest.fixture(scope="module")
def walker():
    return load_registry().devices["walker"]


def walked(walker, plan):
    walk = simulate(plan)
    t_ns = np.arange(len(walk.pos_n), dtype=np.int64) * round(1e9 / walk.rate_hz)
    batch = SampleBatch(t_ns, 1 / walk.rate_hz, 0, walk.channels)
    estimator = walker.make_estimator(walker.params(), np.eye(3))
    return walk, [*estimator.update(batch), *estimator.finish()]


def test_the_walker_needs_both_wheels_and_the_imu(walker):
    assert [channel.name for channel in walker.requires] == [
        "accel", "gyro", "left_ticks", "right_ticks",
    ]  # fmt: skip


@pytest.mark.parametrize("style", STYLES)
def test_a_simulated_walk_has_the_truth_of_every_step(style):
    walk = simulate(WalkPlan(5.0, seed=3, conditions={"style": style}))
    assert set(walk.truth["style"]) == {style}
    assert len(walk.truth["style"]) == len(walk.stride_length_m) == len(walk.stride_end_s)
    along = np.hypot(*np.diff(walk.pos_n[:, :2], axis=0).T).sum()
    assert along == pytest.approx(walk.distance_m, rel=0.01)
    for side in ("left_ticks", "right_ticks"):
        ticks = walk.channels[side]
        assert ticks.shape == (len(walk.pos_n), 1)
        assert np.array_equal(ticks, np.round(ticks))


@pytest.mark.parametrize("style", STYLES)
def test_each_style_is_measured_and_recognised(walker, style):
    plan = WalkPlan(5.0, seed=11, conditions={"style": style, "sensor": "cheap", "tilt_deg": 1.0})
    walk, events = walked(walker, plan)
    summary = walker.summarise(events)
    assert summary["style_counts"] == Counter(walk.truth["style"]) | dict.fromkeys(
        set(STYLES) - {style}, 0
    )
    told = [event for event in events if event.kind == "distance"][-1]
    assert told.distance_m == pytest.approx(walk.distance_m, rel=0.02)
    assert summary["net_displacement_m"] == pytest.approx(walk.distance_m, rel=0.03)


def test_a_mixed_walk_keeps_its_styles_apart(walker):
    walk, events = walked(walker, WalkPlan(8.0, seed=5, conditions={"style": "mixed"}))
    styles = [event.style for event in events if event.kind == "stride"]
    assert styles == list(walk.truth["style"])


def test_a_turn_back_ends_where_it_began(walker):
    plan = WalkPlan(5.0, seed=2, turn_back=True, conditions={"style": "step-by-step"})
    walk, events = walked(walker, plan)
    summary = walker.summarise(events)
    true_m = float(np.hypot(*walk.pos_n[-1, :2]))
    assert abs(summary["net_displacement_m"] - true_m) < 0.25
    assert summary["turns"] == 1


@pytest.mark.parametrize("does", ["stand", "lean", "turn-on-the-spot", "carry", "rock", "drag"])
def test_nothing_but_walking_makes_a_step(walker, does):
    _, events = walked(walker, WalkPlan(5.0, seed=4, conditions={"does": does}))
    assert not [event for event in events if event.kind == "stride"]
    assert walker.summarise(events)["style_counts"] == dict.fromkeys(STYLES, 0)


@pytest.mark.parametrize("conditions", [{"styles": "mixed"}, {"style": "hopping"}])
def test_an_unknown_condition_is_refused(conditions):
    with pytest.raises(ValueError, match="style"):
        simulate(WalkPlan(5.0, conditions=conditions))
