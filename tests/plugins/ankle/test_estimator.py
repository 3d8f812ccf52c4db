"""What the ankle promises of distance, height, trajectory, and of what is no walk."""

import numpy as np
import pytest

from gaitway.api import Bout, Gap, Pose, SampleBatch, WalkPlan
from gaitway.mounting import mount
from gaitway.simulation import non_walking


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 200.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_measures_a_leg_that_turns_about_its_heel_to_half_a_percent(tools, rate_hz, seed):
    walk = tools.heel(distance_m=20.0, rate_hz=rate_hz, seed=seed)
    told = tools.distance(
        tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), tools.heel_batch(walk))
    )
    assert told.distance_m == pytest.approx(walk.distance_m, rel=0.005)
    assert told.strides == len(walk.strides_m)
    assert abs(told.distance_m - walk.distance_m) < 1.96 * told.distance_sigma_m


@pytest.mark.parametrize(
    "style",
    [
        {"length_m": 0.4, "cycle_s": 1.33, "swing_rad": 0.25, "distance_m": 8.0},
        {"length_m": 1.6, "cycle_s": 0.95, "swing_rad": 0.9},
        {"sway_rad": 0.02},
        {"turn_rad": 3.0},
        {"bias_accel": 0.1, "bias_gyro": 0.017, "noise_accel": 3e-3, "noise_gyro": 5e-4,
         "scale": 5e-3},
        {"rest_s": 1.0},
    ],
    ids=["shuffle", "fast", "swaying", "turning", "cheap-sensor", "short-rest"],
)  # fmt: skip
def test_measures_other_ways_of_walking_to_a_percent(tools, style):
    walk = tools.heel(**{"distance_m": 20.0, "seed": 3, **style})
    events = tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), tools.heel_batch(walk))
    assert tools.distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.01)
    assert tools.anomalies(events) == set()


@pytest.mark.parametrize("rise_m", [0.34, -0.34])
def test_measures_stairs_with_their_height(tools, rise_m):
    walk = tools.heel(distance_m=6.0, length_m=0.56, rise_m=rise_m, seed=1)
    events = tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), tools.heel_batch(walk))
    strides = tools.strides(events)
    assert tools.distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.02)
    assert sum(s.height_change_m for s in strides) == pytest.approx(walk.height_m, rel=0.02)
    assert {s.terrain for s in strides} == {"stairs-up" if rise_m > 0 else "stairs-down"}


@pytest.mark.parametrize("terrain", ["stairs-up", "stairs-down"])
def test_measures_the_stairs_of_a_rolling_foot(tools, terrain):
    walk, batch = tools.simulated(seed=2, distance_m=6.0, conditions={"terrain": terrain})
    events = tools.said(tools.estimator(lever_arm_m=(0.08, 0.0, 0.01)), batch)
    climbed_m = walk.truth["stride_height_m"].sum()
    assert tools.distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.03)
    told_m = sum(s.height_change_m for s in tools.strides(events))
    assert told_m == pytest.approx(climbed_m, rel=0.05)
    assert [s.terrain for s in tools.strides(events)] == list(walk.truth["terrain"])


def test_an_unknown_lever_arm_shows_in_sigma(tools):
    batch = tools.heel_batch(tools.heel(distance_m=20.0, seed=1))
    assumed = tools.distance(tools.said(tools.estimator(), batch))
    known = tools.distance(tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), batch))
    assert assumed.distance_sigma_m > 3.0 * known.distance_sigma_m
    assert abs(assumed.distance_m - 20.0) < 2.5 * assumed.distance_sigma_m


def test_a_lever_arm_is_told_in_the_axes_of_the_imu(tools):
    batch = tools.heel_batch(tools.heel(distance_m=20.0, seed=1))
    right = tools.distance(tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), batch))
    turned = tools.distance(tools.said(tools.estimator(lever_arm_m=(0.03, 0.0, 0.12)), batch))
    assert right.distance_m == pytest.approx(20.0, rel=0.01)
    assert turned.distance_m < 0.97 * right.distance_m


def test_contact_and_lift_are_those_of_the_foot(tools):
    walk, batch = tools.simulated(seed=1)
    strides = tools.strides(tools.said(tools.estimator(lever_arm_m=(0.08, 0.0, 0.01)), batch))
    contacts_s = np.array([s.t_ns for s in strides]) / 1e9
    lifts_s = np.array([s.lift_t_ns for s in strides]) / 1e9
    assert np.abs(contacts_s - walk.truth["contact_s"]).max() < 0.12
    assert np.abs(lifts_s - walk.truth["lift_s"]).max() < 0.2
    for s in strides:
        assert s.start_t_ns < s.lift_t_ns < s.t_ns
        total_s = s.stance_duration_s + s.swing_duration_s
        assert total_s == pytest.approx(s.stride_duration_s, abs=1e-6)


def test_the_path_goes_where_the_leg_went(tools):
    walk = tools.heel(distance_m=20.0, turn_rad=1.5, seed=4)
    events = tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), tools.heel_batch(walk))
    last = [event for event in events if isinstance(event, Pose)][-1]
    assert last.heading_rad == pytest.approx(1.5, abs=0.25)
    assert last.pos_y_m > 5.0
    assert abs(last.height_m) < 2.5 * last.height_sigma_m


def test_a_walk_is_one_bout(tools):
    walk = tools.heel(distance_m=20.0, rest_s=5.0, seed=1)
    events = tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), tools.heel_batch(walk))
    start, end = (event for event in events if isinstance(event, Bout))
    assert (start.phase, end.phase) == ("start", "end")
    assert end.distance_m == pytest.approx(walk.distance_m, rel=0.005)


def test_lost_samples_cost_less_than_a_percent(tools):
    _, batch = tools.simulated(seed=5, distance_m=25.0)
    lever = {"lever_arm_m": (0.08, 0.0, 0.01)}
    whole = tools.distance(tools.said(tools.estimator(**lever), batch)).distance_m
    rng = np.random.default_rng(1)
    kept = np.flatnonzero(rng.random(len(batch)) > 0.02)
    items, at = [], 0
    for index in kept:
        if index > at:
            items.append(Gap(int(batch.t_ns[at]), int(index) - at, "lost"))
        items.append(batch[index : index + 1])
        at = index + 1
    lossy = tools.distance(tools.said_of(tools.estimator(**lever), items)).distance_m
    assert lossy == pytest.approx(whole, rel=0.01)


@pytest.mark.parametrize("begin", [900, 930, 960, 990])
def test_half_a_second_lost_costs_less_than_a_percent_and_is_said(tools, begin):
    _, batch = tools.simulated(seed=5, distance_m=25.0)
    lever = {"lever_arm_m": (0.08, 0.0, 0.01)}
    whole = tools.distance(tools.said(tools.estimator(**lever), batch))
    gap = Gap(int(batch.t_ns[begin]), 50, "lost")
    items = [batch[:begin], gap, batch[begin + 50 :]]
    events = tools.said_of(tools.estimator(**lever), items)
    told = tools.distance(events)
    assert told.distance_m == pytest.approx(whole.distance_m, rel=0.01)
    assert told.distance_sigma_m > whole.distance_sigma_m
    assert "gap-in-stride" in tools.anomalies(events)


def test_a_long_gap_makes_no_distance_up(tools):
    _, batch = tools.simulated(seed=5, distance_m=25.0)
    gap = Gap(int(batch.t_ns[900]), 800, "link-down")
    estimator = tools.estimator(lever_arm_m=(0.08, 0.0, 0.01))
    events = tools.said_of(estimator, [batch[:900], gap, batch[1700:]])
    told = tools.distance(events)
    assert told.unmeasured_s > 7.0
    assert told.distance_m < 0.8 * 25.0


@pytest.mark.parametrize("cycle_s", [1.0, 1.3])
def test_the_foot_is_flat_before_the_heel_rises_though_the_leg_turns_slower_then(tools, cycle_s):
    walk = tools.heel(distance_m=20.0, heel_rise_s=0.22, cycle_s=cycle_s, seed=4)
    events = tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), tools.heel_batch(walk))
    assert tools.distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.015)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_what_is_dragged_along_does_not_swing_like_a_leg(tools, seed):
    events = tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), tools.dragged(seed))
    assert tools.strides(events) == []


def test_stairs_are_less_certain_than_the_level_the_lever_arm_is_from(tools):
    walk = tools.heel(distance_m=6.0, length_m=0.56, rise_m=0.34, seed=1)
    estimator = tools.estimator(lever_arm_m=tools.LEVER_B, lever_arm_sigma_m=0.0)
    told = tools.distance(tools.said(estimator, tools.heel_batch(walk)))
    assert 0.02 * told.distance_m < told.distance_sigma_m < 0.05 * told.distance_m


@pytest.mark.parametrize("size", [1, 7, 1000])
def test_how_samples_are_cut_into_batches_changes_nothing(tools, size):
    _, batch = tools.simulated(seed=3, distance_m=6.0)
    assert tools.said(tools.estimator(), batch, size) == tools.said(tools.estimator(), batch)


@pytest.mark.parametrize("at", [150, 620, 777])
def test_a_restart_in_mid_walk_goes_on(tools, at):
    _, batch = tools.simulated(seed=3)
    before, after = tools.estimator(), tools.estimator()
    events = list(before.update(batch[:at]))
    after.restore(before.save())
    events += tools.said(after, batch[at:])
    assert events == tools.said(tools.estimator(), batch)


@pytest.mark.parametrize(
    "kind", ["still", "lying", "leaning", "waving", "turning-on-the-spot", "carried"]
)
@pytest.mark.parametrize("seed", [1, 2])
def test_what_is_no_walk_has_no_strides(tools, kind, seed):
    walk = non_walking(WalkPlan(1.0, seed=seed), kind, device_to_imu_d=(0.0, 0.0, 0.1))
    t_ns = np.arange(len(walk.pos_n), dtype=np.int64) * 10_000_000
    batch = mount(SampleBatch(t_ns, 0.01, 0, walk.channels), tools.C_db)
    events = tools.said(tools.estimator(), batch)
    assert tools.strides(events) == []


def test_starting_in_mid_walk_measures_what_is_left(tools):
    walk, batch = tools.simulated(seed=6, distance_m=20.0)
    estimator = tools.estimator(lever_arm_m=(0.08, 0.0, 0.01))
    told = tools.distance(tools.said(estimator, batch[800:]))
    left_m = np.hypot(*(walk.pos_n[-1] - walk.pos_n[800])[:2])
    assert told.distance_m == pytest.approx(left_m, abs=1.8)


@pytest.mark.parametrize("flagged", [True, False])
def test_says_when_the_sensor_clipped(tools, flagged):
    walk = tools.heel(distance_m=12.0, seed=1)
    batch = tools.heel_batch(walk)
    accel = np.clip(batch.channels["accel"], -16.0, 16.0)
    flags = (np.abs(accel) >= 16.0).any(axis=1)[:, None].astype(float)
    assert flags.any()
    channels = {**batch.channels, "accel": accel} | ({"clip": flags} if flagged else {})
    clipped = SampleBatch(batch.t_ns, batch.period_s, 0, channels)
    events = tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), clipped)
    assert "sensor-clipped" in tools.anomalies(events)
    whole = tools.distance(tools.said(tools.estimator(lever_arm_m=tools.LEVER_B), batch))
    assert tools.distance(events).distance_sigma_m > whole.distance_sigma_m


def test_says_when_it_was_dropped(tools):
    _, batch = tools.simulated(seed=1, distance_m=4.0)
    accel = batch.channels["accel"].copy()
    accel[100:130] = 0.1
    falling = SampleBatch(batch.t_ns, batch.period_s, 0, {**batch.channels, "accel": accel})
    assert "device-dropped" in tools.anomalies(tools.said(tools.estimator(), falling))


def test_says_when_it_is_not_mounted_as_configured(tools):
    walk = tools.heel(distance_m=20.0, seed=1)
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = {"accel": walk.accel @ quarter.T, "gyro": walk.gyro @ quarter.T}
    batch = tools.heel_batch(walk)
    wrong = SampleBatch(batch.t_ns, batch.period_s, 0, turned)
    events = tools.said(tools.estimator(lever_arm_m=(0.12, 0.0, 0.0)), wrong)
    assert "not-mounted-as-configured" in tools.anomalies(events)


def test_the_trace_has_a_row_a_sample_from_the_first_anchor_on(tools):
    _, batch = tools.simulated(seed=3, distance_m=6.0)
    estimator = tools.estimator()
    trace = estimator.start_trace()
    tools.said(estimator, batch)
    assert trace.t_ns == sorted(set(trace.t_ns))
    assert len(trace.t_ns) == len(batch)
    height = np.array(trace.rows)[:, trace.columns.index("pos_z_m")]
    assert np.isfinite(height[100:-100]).mean() > 0.95


def test_events_come_within_the_declared_look_ahead(tools):
    _, batch = tools.simulated(seed=4)
    estimator = tools.estimator()
    late_s = [
        (int(batch.t_ns[end - 1]) - event.t_ns) / 1e9
        for end in range(10, len(batch), 10)
        for event in estimator.update(batch[end - 10 : end])
        if event.kind == "distance"
    ]
    assert late_s
    # The first stride waits for the second.
    assert np.sort(late_s)[:-1].max() < estimator.look_ahead_s + 0.1
