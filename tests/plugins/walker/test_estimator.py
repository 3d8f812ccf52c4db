"""What the walker's estimator promises, on walks moved by hand."""

from collections import Counter

import numpy as np
import pytest

from gaitway.api import Gap
from gaitway_plugins.walker.estimator import WalkerEstimator
from gaitway_plugins.walker.params import WalkerParams

STYLES = ["continuous", "step-by-step", "full-lift", "back-tips"]
HARD = {
    "gyro_bias": (0.017, -0.017, 0.017), "accel_bias": (0.1, -0.1, 0.1), "noise": 0.05,
}  # fmt: skip


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize(
    "changes",
    [{}, {"rate_hz": 50.0}, {"rate_hz": 200.0, **HARD}, {"sway_rad": 0.008}, {"rest_s": 1.0}],
    ids=str,
)
def test_every_step_is_counted_with_its_style_and_length(tools, style, changes):
    walk = tools.moved(style, **changes)
    events = tools.said(walk)
    assert Counter(s.style for s in tools.of(events, "stride")) == {style: 10}
    told = tools.distance(events)
    assert told.distance_m == pytest.approx(walk.distance_m, rel=0.008)
    assert abs(told.distance_m - walk.distance_m) < 2.0 * told.distance_sigma_m
    assert not tools.of(events, "anomaly")


@pytest.mark.parametrize("duration_s", [0.7, 1.5])
def test_an_even_glide_in_the_air_is_no_standing(tools, duration_s):
    hand = tools.Hand()
    hand.go(2.0)
    for _ in range(5):
        hand.go(0.4, climb=tools.hump(0.07))
        hand.go(duration_s, lift=tools.trapeze(0.4, 0.1))
        hand.go(0.4, climb=tools.hump(-0.07))
        hand.go(1.0)
    hand.go(1.0)
    events = tools.said(tools.sensed(hand))
    assert len(tools.of(events, "stride")) == 5
    assert tools.distance(events).distance_m == pytest.approx(2.0, abs=0.04)


def test_a_lift_may_pause_in_the_air(tools):
    hand = tools.Hand()
    hand.go(2.0)
    for _ in range(5):
        hand.go(0.4, climb=tools.hump(0.08))
        hand.go(0.4)
        hand.go(0.8, lift=tools.hump(0.4))
        hand.go(0.4)
        hand.go(0.4, climb=tools.hump(-0.08))
        hand.go(1.0)
    hand.go(2.0)
    events = tools.said(tools.sensed(hand))
    assert [s.style for s in tools.of(events, "stride")] == ["full-lift"] * 5
    assert tools.distance(events).distance_m == pytest.approx(2.0, abs=0.03)


@pytest.mark.parametrize("imu", [(-0.2, 0.1, 0.9), (0.1, -0.1, 0.3)])
def test_a_wrong_place_of_the_sensor_changes_no_length(tools, imu):
    for style in ("full-lift", "back-tips"):
        walk = tools.moved(style, imu=imu)
        assert tools.distance(tools.said(walk)).distance_m == pytest.approx(4.0, rel=0.01)


def test_a_short_roll_between_stops_is_a_step_and_a_long_even_one_is_continuous(tools):
    long = tools.said(tools.moved("continuous", modulation=0.0))
    assert [s.style for s in tools.of(long, "stride")] == ["continuous"]
    short = tools.said(tools.moved("step-by-step", steps=1))
    assert [s.style for s in tools.of(short, "stride")] == ["step-by-step"]


def test_a_step_is_told_with_its_standing_and_its_moving(tools):
    events = tools.said(tools.moved("step-by-step", duration_s=0.9, pause_s=0.8))
    for stride in tools.of(events, "stride")[1:]:
        assert stride.stride_duration_s == pytest.approx(1.7, abs=0.15)
        assert stride.swing_duration_s == pytest.approx(0.9, abs=0.25)
        assert stride.stance_duration_s == pytest.approx(0.8, abs=0.25)


def test_the_path_turns_with_the_walker(tools):
    for style in ("step-by-step", "full-lift", "back-tips"):
        events = tools.said(tools.moved(style, turn_deg=18.0, gyro_bias=(0.01, 0.0, 0.01)))
        pose = tools.of(events, "pose")[-1]
        chord = 0.4 * np.exp(1j * np.radians(18.0 * (np.arange(10) + 0.5))).sum()
        chord *= np.exp(-1j * np.radians(9.0))
        assert abs(complex(pose.pos_x_m, pose.pos_y_m) - chord) < 0.06
        assert pose.pos_y_sigma_m < 0.1


def test_a_turn_is_told_with_its_angle(tools):
    hand = tools.Hand()
    hand.go(2.0)
    hand.go(2.0, roll=tools.hump(0.8))
    hand.go(1.0)
    hand.go(1.5, yaw=tools.hump(np.radians(90.0)))
    hand.go(1.0)
    hand.go(2.0, roll=tools.hump(0.8))
    hand.go(2.0)
    (turn,) = tools.of(tools.said(tools.sensed(hand)), "turn")
    assert turn.turn_angle_rad == pytest.approx(np.pi / 2, abs=0.05)
    assert turn.turn_duration_s == pytest.approx(1.5, abs=0.5)


def test_every_roll_is_a_push(tools):
    pushes = tools.of(tools.said(tools.moved("step-by-step")), "push")
    assert len(pushes) == 10
    assert pushes[4].push_length_m == pytest.approx(0.4, abs=0.005)
    assert pushes[4].peak_speed_mps == pytest.approx(1.875 * 0.4 / 0.9, rel=0.1)
    assert not tools.of(tools.said(tools.moved("full-lift")), "push")


def rocking(tools, pause_s):
    hand = tools.Hand()
    hand.go(2.0)
    for _ in range(12):
        hand.go(0.7, roll=tools.hump(0.1))
        hand.go(pause_s)
        hand.go(0.7, roll=tools.hump(-0.1))
        hand.go(pause_s)
    return hand


def spinning(tools):
    hand = tools.Hand()
    hand.go(2.0)
    for angle in (2.0, -3.0, 1.5):
        hand.go(2.0, yaw=tools.hump(angle))
        hand.go(1.0)
    return hand


def leaning(tools):
    hand = tools.Hand()
    hand.go(2.0)
    for _ in range(12):
        hand.go(0.5, pitch=tools.hump(0.01))
        hand.go(0.5, pitch=tools.hump(-0.01))
    return hand


def held_up(tools):
    hand = tools.Hand()
    hand.go(2.0)
    hand.go(1.5, climb=tools.hump(0.4))
    for _ in range(6):
        hand.go(0.8, lift=tools.hump(0.6))
        hand.go(0.7, pitch=tools.hump(0.2))
        hand.go(0.7, pitch=tools.hump(-0.2))
    hand.go(1.5, climb=tools.hump(-0.4))
    return hand


@pytest.mark.parametrize(
    "make",
    [lambda t: rocking(t, 0.0), lambda t: rocking(t, 0.6), spinning, leaning, held_up],
    ids=["rocking", "rocking with stops", "spinning", "leaning", "held up"],
)
def test_no_step_is_made_of_anything_but_walking(tools, make):
    hand = make(tools)
    hand.go(2.0)
    assert not tools.of(tools.said(tools.sensed(hand)), "stride")


def test_backing_up_and_coming_again_counts_the_same_ground_once(tools):
    hand = tools.Hand()
    hand.go(2.0)
    for by in (0.4, 0.4, -0.2, 0.2, 0.4):
        hand.go(0.9, roll=tools.hump(by))
        hand.go(0.8)
    hand.go(2.0)
    told = tools.distance(tools.said(tools.sensed(hand)))
    assert told.distance_m == pytest.approx(1.2, abs=0.01)
    assert told.strides == 3


@pytest.fixture(scope="module", params=STYLES)
def reference(request, tools):
    walk = tools.moved(request.param, steps=6, turn_deg=5.0)
    return walk, tools.said(walk)


@pytest.mark.parametrize("size", [1, 7, 100])
def test_the_size_of_batches_changes_nothing(tools, reference, size):
    walk, events = reference
    assert tools.said(walk, size) == events


@pytest.mark.parametrize("method", ["default", "published"])
@pytest.mark.parametrize("cut", [450, 777])
def test_a_saved_estimator_goes_on_as_if_nothing_had_been(tools, method, cut):
    walk = tools.moved("full-lift", steps=6)
    params = WalkerParams(method=method)
    events = tools.said(walk, estimator=WalkerEstimator(params))
    before, after = WalkerEstimator(params), WalkerEstimator(params)
    told = list(before.update(walk.batch(0, cut)))
    after.restore(before.save())
    assert [*told, *after.update(walk.batch(cut)), *after.finish()] == events


def test_a_restart_in_the_middle_of_a_roll_loses_no_distance(tools):
    walk = tools.moved("continuous", steps=10)
    before, after = WalkerEstimator(WalkerParams()), WalkerEstimator(WalkerParams())
    events = list(before.update(walk.batch(0, 600)))
    after.restore(before.save())
    events += after.update(Gap(t_ns=6 * 10**9, n_missing=40, reason="link-down"))
    events += [*after.update(walk.batch(640)), *after.finish()]
    assert tools.distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.005)


def test_the_filter_is_consistent_and_its_covariance_one(tools):
    estimator = WalkerEstimator(WalkerParams())
    kf = estimator._navigator._kf
    correct, nis = kf.correct, []

    def listened(measurement):
        assert np.linalg.eigvalsh(kf.covariance).min() > -1e-12
        assert np.array_equal(kf.covariance, kf.covariance.T)
        found = correct(measurement)
        nis.append(found.nis / len(measurement.z))
        return found

    kf.correct = listened
    for style in STYLES:
        walk = tools.moved(style, steps=4, noise=0.03, gyro_bias=(0.01, 0.01, -0.01))
        estimator.update(walk.batch(start_ns=0))
    assert np.mean(nis) < 1.0
    assert np.mean(np.array(nis) > 9.0) < 0.01


@pytest.mark.parametrize("style", STYLES)
def test_lost_samples_and_half_second_gaps_cost_little(tools, style):
    walk = tools.moved(style, steps=20)
    lost = np.flatnonzero(np.random.default_rng(1).random(len(walk)) < 0.01)
    single = [(int(at), int(at) + 1) for at in lost[lost > 10][::2] if at + 1 not in lost]
    for losses in (single, [(700, 750), (1500, 1550)]):
        told = tools.distance(tools.said(walk, losses=losses))
        assert told.distance_m == pytest.approx(walk.distance_m, rel=0.01)
        assert abs(told.distance_m - walk.distance_m) < 2.0 * told.distance_sigma_m


def test_a_long_gap_while_walking_is_said_and_makes_the_distance_less_certain(tools):
    walk = tools.moved("step-by-step", steps=12)
    events = tools.said(walk, losses=[(800, 1200)])
    assert "gap-in-stride" in {a.anomaly for a in tools.of(events, "anomaly")}
    told = tools.distance(events)
    assert told.distance_m < walk.distance_m
    assert told.distance_sigma_m > 1.5
    assert told.unmeasured_s == pytest.approx(4.0, abs=0.1)


def test_events_come_within_the_declared_latency(tools):
    estimator, walk = WalkerEstimator(WalkerParams()), tools.moved("step-by-step")
    for at in range(len(walk)):
        for event in estimator.update(walk.batch(at, at + 1)):
            if event.kind == "stride":
                assert at * walk.period_s - event.t_ns / 1e9 <= estimator.look_ahead_s + 1e-6


def test_the_published_method_loses_lifts_and_keeps_rolls(tools):
    rolled = tools.moved("continuous")
    events = tools.said(rolled, method="published")
    assert tools.distance(events).distance_m == pytest.approx(rolled.distance_m, rel=0.02)
    lifted = tools.moved("full-lift", duration_s=1.6, noise=0.002)
    published, default = (
        sum(s.stride_length_m for s in tools.of(tools.said(lifted, method=method), "stride"))
        for method in ("published", "default")
    )
    assert abs(default - lifted.distance_m) < 0.05
    assert published < 0.75 * lifted.distance_m


def test_the_trace_has_a_row_a_sample_with_phase_and_style(tools):
    walk = tools.moved("full-lift", steps=4)
    estimator = WalkerEstimator(WalkerParams())
    trace = estimator.start_trace()
    tools.said(walk, estimator=estimator)
    rows = np.array(trace.rows)
    assert len(rows) == len(walk)
    assert rows[-1, 0] == pytest.approx(1.6, abs=0.02)
    assert set(rows[:, trace.columns.index("style")]) == {0.0, 3.0}
    assert set(rows[:, trace.columns.index("phase")]) == {0.0, 2.0}
