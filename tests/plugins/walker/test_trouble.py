"""What the walker says when something is wrong, and what it does not publish then."""

import numpy as np
import pytest

from gaitway_plugins.walker.params import WalkerParams

HIGH = (-0.1, 0.05, 0.9)


def anomalies(tools, walk):
    return [event.anomaly for event in tools.of(tools.said(walk), "anomaly")]


def changed(walk, **channels):
    walk.channels = walk.channels | channels
    return walk


def test_a_stuck_encoder_is_said_and_the_other_one_and_the_gyroscope_go_on(tools):
    walk = tools.moved("continuous", steps=12)
    ticks = walk.channels["left_ticks"]
    walk = changed(walk, left_ticks=np.zeros_like(ticks))
    events = tools.said(walk)
    assert "encoder-stuck" in [a.anomaly for a in tools.of(events, "anomaly")]
    assert tools.distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.01)


@pytest.mark.parametrize("sides", [("left_ticks",), ("left_ticks", "right_ticks")])
def test_a_reversed_encoder_is_said_and_no_distance_made_of_it(tools, sides):
    walk = tools.moved("step-by-step", steps=12)
    walk = changed(walk, **{side: -walk.channels[side] for side in sides})
    events = tools.said(walk)
    names = [a.anomaly for a in tools.of(events, "anomaly")]
    assert "not-mounted-as-configured" in names
    assert "distance-untrusted" in names
    assert not tools.of(events, "stride")
    assert tools.distance(events).distance_sigma_m > 1.0


def quick_tips(tools, reverse=1.0):
    """Return steps that roll while the back tips go up and down, as fast as people do."""
    hand, tip, rng = tools.Hand(), np.radians(5.5), np.random.default_rng(1)
    hand.go(2.0)
    for _ in range(12):
        n = round(rng.normal(650, 40))
        up, roll, down = round(0.35 * n), round(0.7 * n), n - round(0.35 * n)
        pitch, way = np.zeros(n), np.zeros(n)
        pitch[:up] = tools.hump(tip)(up)
        pitch[down:] = tools.hump(-tip)(n - down)
        way[(n - roll) // 2 :][:roll] = tools.hump(0.4)(roll)
        hand.go(n / 1000, roll=lambda _, way=way: way, pitch=lambda _, pitch=pitch: pitch)
        hand.go(rng.normal(0.5, 0.03))
    hand.go(2.0)
    walk = tools.sensed(hand, imu=np.array(HIGH))
    sides = ("left_ticks", "right_ticks")
    return changed(walk, **{side: reverse * walk.channels[side] for side in sides})


def test_quick_back_tips_are_no_wheels_that_count_backward(tools):
    walk = quick_tips(tools)
    events = tools.said(walk, imu_position_m=HIGH)
    assert not tools.of(events, "anomaly")
    assert len(tools.of(events, "stride")) == 12
    assert tools.distance(events).distance_m == pytest.approx(walk.distance_m, abs=0.02)


def test_back_tips_lifted_while_slowing_down_are_none_either(tools):
    hand, tip, rng = tools.Hand(), np.radians(7.0), np.random.default_rng(1)
    hand.go(2.0)
    for _ in range(20):
        n = round(rng.normal(700, 40))
        pitch, begin, end = np.zeros(n), round(0.55 * n), round(0.9 * n)
        pitch[begin:end] = tools.hump(tip)(end - begin)
        hand.go(n / 1000, roll=tools.hump(0.4), pitch=lambda _, pitch=pitch: pitch)
        hand.go(0.3, pitch=tools.hump(-tip))
        hand.go(rng.normal(0.5, 0.03))
    hand.go(2.0)
    events = tools.said(tools.sensed(hand, imu=np.array(HIGH)), imu_position_m=HIGH)
    assert not tools.of(events, "anomaly")


def test_wheels_that_count_backward_are_seen_under_quick_back_tips_too(tools):
    walk = quick_tips(tools, reverse=-1.0)
    events = tools.said(walk, imu_position_m=HIGH)
    named = {a.anomaly for a in tools.of(events, "anomaly")}
    assert named == {"not-mounted-as-configured", "distance-untrusted"}
    assert not tools.of(events, "stride")


def test_dragging_is_said_and_not_counted(tools):
    walk = tools.moved("full-lift", height_m=0.0)
    events = tools.said(walk)
    assert anomalies(tools, walk).count("dragging") == 10
    assert not tools.of(events, "stride")


def test_a_walker_that_lies_on_its_side_has_tipped_over(tools):
    hand = tools.Hand()
    hand.go(2.0)
    hand.go(1.0, pitch=tools.hump(1.5))
    hand.go(3.0)
    assert anomalies(tools, tools.sensed(hand)) == ["tipped-over"]


def test_a_sensor_that_sits_otherwise_than_configured_is_said_at_rest(tools):
    walk = tools.moved("step-by-step", steps=1)
    turned = walk.channels["accel"][:, [2, 1, 0]] * [1, 1, -1]
    assert "not-mounted-as-configured" in anomalies(tools, changed(walk, accel=turned))


def test_a_free_fall_is_a_drop(tools):
    walk = tools.moved("step-by-step", steps=1)
    accel = walk.channels["accel"].copy()
    accel[100:130] = 0.0
    assert "dropped" in anomalies(tools, changed(walk, accel=accel))


def test_a_clipped_lift_is_said_and_less_certain(tools):
    walk = tools.moved("full-lift", steps=3)
    plain = tools.of(tools.said(walk), "stride")[1]
    clip = np.zeros((len(walk), 1))
    clip[round(walk.ends_s[1] / walk.period_s) - 20] = 4.0
    events = tools.said(changed(walk, clip=clip))
    assert "sensor-clipped" in [a.anomaly for a in tools.of(events, "anomaly")]
    assert tools.of(events, "stride")[1].stride_length_sigma_m > plain.stride_length_sigma_m


def test_readings_at_the_end_of_the_range_are_seen_without_a_flag(tools):
    walk = tools.moved("full-lift", steps=3, profile=tools.hump, duration_s=0.6, height_m=0.12)
    accel = np.clip(walk.channels["accel"], -14.5, 14.5)
    assert "sensor-clipped" in anomalies(tools, changed(walk, accel=accel))


def test_counters_may_wrap_and_begin_anywhere(tools):
    walk = tools.moved("continuous")
    wrapped = {
        side: np.mod(walk.channels[side] + 1000.0, 1024.0) for side in ("left_ticks", "right_ticks")
    }
    expected = tools.distance(tools.said(walk)).distance_m
    assert tools.distance(tools.said(changed(walk, **wrapped))).distance_m == expected


def test_a_sample_that_is_no_number_is_a_lost_one(tools):
    walk = tools.moved("step-by-step")
    accel, ticks = walk.channels["accel"].copy(), walk.channels["left_ticks"].copy()
    accel[500], ticks[700] = np.nan, np.inf
    events = tools.said(changed(walk, accel=accel, left_ticks=ticks))
    assert tools.distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.005)


def test_being_carried_is_said_and_begins_a_new_path(tools):
    hand = tools.Hand()
    hand.go(2.0)
    for _ in range(2):
        hand.go(0.9, roll=tools.hump(0.4))
        hand.go(0.8)
    hand.go(0.8, climb=tools.hump(0.3))
    for _ in range(8):
        hand.go(0.5, lift=tools.hump(0.5), climb=tools.up_down(0.04))
    hand.go(0.8, climb=tools.hump(-0.3))
    hand.go(2.0)
    for _ in range(2):
        hand.go(0.9, roll=tools.hump(0.4))
        hand.go(0.8)
    hand.go(2.0)
    events = tools.said(tools.sensed(hand))
    assert "carried" in [a.anomaly for a in tools.of(events, "anomaly")]
    assert tools.distance(events).distance_m == pytest.approx(1.6, abs=0.02)
    assert len({pose.since_t_ns for pose in tools.of(events, "pose")}) == 2


def test_what_sets_a_fallen_walker_up_again_is_no_step(tools):
    hand = tools.Hand()
    hand.go(2.0)
    for _ in range(4):
        hand.go(0.5, pitch=tools.hump(1.4), climb=tools.up_down(0.05), lift=tools.hump(0.4))
        hand.go(3.0)
        hand.go(1.0, pitch=tools.hump(-1.4), climb=tools.up_down(0.05), lift=tools.hump(0.4))
        hand.go(3.0)
    events = tools.said(tools.sensed(hand))
    assert "tipped-over" in [a.anomaly for a in tools.of(events, "anomaly")]
    assert not tools.of(events, "stride")


def test_after_a_fall_it_counts_again_once_it_has_stood(tools):
    hand = tools.Hand()
    hand.go(2.0)
    hand.go(0.8, pitch=tools.hump(1.4))
    hand.go(2.0)
    hand.go(1.0, pitch=tools.hump(-1.4))
    hand.go(2.0)
    for _ in range(5):
        hand.go(0.8, lift=tools.hump(0.4), climb=tools.up_down(0.07))
        hand.go(0.6)
    hand.go(2.0)
    events = tools.said(tools.sensed(hand))
    assert len(tools.of(events, "stride")) == 5
    assert tools.distance(events).distance_m == pytest.approx(2.0, abs=0.05)


def test_a_ride_makes_no_steps_where_it_halts_for_a_moment(tools):
    hand = tools.Hand()
    hand.go(2.0)
    for _ in range(5):
        hand.go(2.5, lift=tools.hump(8.0), climb=tools.up_down(0.05))
        hand.go(0.5)
        hand.go(0.6, lift=tools.hump(0.5), climb=tools.up_down(0.05))
        hand.go(0.5)
    hand.go(2.0)
    events = tools.said(tools.sensed(hand))
    assert not tools.of(events, "stride")
    refused = [a for a in tools.of(events, "anomaly") if "borne off" in (a.detail or "")]
    assert len(refused) == 1


def test_parameters_refuse_nonsense():
    with pytest.raises(ValueError, match="wheel_radius_m"):
        WalkerParams(wheel_radius_m=0.0)
