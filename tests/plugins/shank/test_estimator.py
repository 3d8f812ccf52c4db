"""The default method on walks whose truth is known to the last bit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitway.api import Anomaly, Bout, Stride
from gaitway_plugins.shank.estimator import ShankEstimator
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.published import PublishedEstimator


def estimator(**changes):
    return ShankEstimator(ShankParams(**changes))


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 200.0])
def test_the_distance_of_an_ideal_walk_is_right_at_any_rate(tools, rate_hz):
    walk = tools.walk(rate_hz=rate_hz)
    events = tools.said(estimator(), walk)
    assert tools.last_distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.02)
    assert len(tools.lengths_m(events)) == 6


@pytest.mark.parametrize(
    "changes",
    [
        {"noise": 0.1, "seed": 1},
        {"bias": (0.01, 0.02, -0.01)},
        {"yaw_rad": 0.6},
        {"cycle_s": 1.4, "bump_mps": 3.5},
    ],
    ids=str,
)
def test_noise_bias_a_twisted_strap_and_a_slow_walk_change_little(tools, changes):
    walk = tools.walk(**changes)
    events = tools.said(estimator(), walk)
    assert tools.last_distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.025)


def test_the_first_and_the_last_half_stride_count(tools):
    walk = tools.walk(strides=2)
    strides = [e for e in tools.said(estimator(), walk) if isinstance(e, Stride)]
    assert len(strides) == 2
    assert sum(stride.stride_length_m for stride in strides) == pytest.approx(
        walk.distance_m, rel=0.03
    )
    assert strides[0].start_t_ns < 3.0e9 < strides[0].t_ns
    assert strides[-1].t_ns > walk.toe_offs[-1] * 1e7


def test_a_walk_is_one_bout_with_all_its_strides(tools):
    bouts = [e for e in tools.said(estimator(), tools.walk()) if isinstance(e, Bout)]
    assert [bout.phase for bout in bouts] == ["start", "end"]
    assert bouts[1].strides == 6


def test_no_stillness_is_needed_before_walking(tools):
    walk = tools.walk()
    begin = walk.toe_offs[1] + 50
    rest = tools.Walk(walk.accel[begin:], walk.gyro[begin:], 0.01, 0.0, [])
    lengths_m = tools.lengths_m(tools.said(estimator(), rest))
    assert lengths_m[:2] == pytest.approx([0.894] * 2, rel=0.02)


def test_a_gyroscope_that_always_reads_backward_hides_no_end_of_a_swing(tools):
    walk = tools.walk(bias=(0.0, -0.04, 0.0))
    assert len(tools.lengths_m(tools.said(estimator(), walk))) == 6


def test_the_height_of_the_sensor_is_learned_on_the_way(tools):
    walk = tools.walk(height_m=0.26, creep_mps=0.11, strides=60)
    lengths_m = np.array(tools.lengths_m(tools.said(estimator(), walk)))
    assert np.mean(lengths_m[1:4]) < 0.96 * walk.distance_m / 60
    assert np.mean(lengths_m[40:58]) == pytest.approx(walk.distance_m / 60, rel=0.03)


def test_sigma_grows_with_the_distance(tools):
    short = tools.last_distance(tools.said(estimator(), tools.walk(strides=3)))
    long = tools.last_distance(tools.said(estimator(), tools.walk(strides=12)))
    assert 2.0 * short.distance_sigma_m < long.distance_sigma_m
    assert long.distance_sigma_m > 0.05 * long.distance_m


@pytest.fixture(scope="module")
def reference(tools):
    walk = tools.walk(strides=3, rest_s=2.5, noise=0.05, seed=2)
    return walk, tools.said(estimator(), walk)


@pytest.mark.parametrize("size", [1, 7, 100])
def test_the_size_of_batches_changes_nothing(tools, reference, size):
    walk, events = reference
    assert tools.said(estimator(), walk, range(size, len(walk), size)) == events


@settings(max_examples=15, deadline=None)
@given(cuts=st.sets(st.integers(1, 800), max_size=12))
def test_where_batches_are_cut_changes_nothing(tools, reference, cuts):
    walk, events = reference
    assert tools.said(estimator(), walk, cuts) == events


def test_the_same_samples_give_the_same_events(tools, reference):
    walk, events = reference
    assert tools.said(estimator(), walk) == events


def test_an_hour_later_everything_is_an_hour_later_and_else_the_same(tools, reference):
    walk, events = reference
    hour_ns = 3_600_000_000_000

    def back(event):
        names = ("t_ns", "start_t_ns", "since_t_ns", "lift_t_ns")
        times = {n: getattr(event, n, None) for n in names}
        moved = {n: t_ns - hour_ns for n, t_ns in times.items() if t_ns is not None}
        return event.model_copy(update=moved)

    later = tools.said(estimator(), walk, start_ns=hour_ns)
    assert later != events
    assert [back(event) for event in later] == events


def test_every_stride_is_told_within_the_look_ahead(tools):
    walk, est = tools.walk(noise=0.02), estimator()
    waits_s = [
        (at * 1e7 - event.t_ns) / 1e9
        for at in range(len(walk))
        for event in est.update(walk.batch(at, at + 1))
        if isinstance(event, Stride)
    ]
    assert len(waits_s) == 6
    assert 0.0 < max(waits_s) <= est.look_ahead_s
    assert max(waits_s[:-1]) < 1.0


def test_standing_gives_nothing(tools):
    rng = np.random.default_rng(3)
    accel = rng.normal(0.0, 0.1, (3000, 3)) + np.array([0.3, 0.0, 9.8])
    gyro = rng.normal(0.0, 0.03, (3000, 3)) - 0.02
    assert tools.said(estimator(), tools.Walk(accel, gyro, 0.01, 0.0, [])) == []


@pytest.mark.parametrize(("frequency_hz", "swing_deg"), [(0.5, 40), (0.9, 35), (1.2, 20)])
def test_a_leg_swinging_from_a_seat_gives_no_stride(tools, frequency_hz, swing_deg):
    t = np.arange(0.0, 30.0, 0.01)
    pitch = -np.radians(swing_deg) * np.sin(2 * np.pi * frequency_hz * t) * (t > 3.0)
    ahead, up = -0.3 * np.sin(pitch), -0.3 * np.cos(pitch)
    force = [np.gradient(np.gradient(x, 0.01), 0.01) for x in (ahead, up)]
    force[1] += 9.81
    cos, sin, zero = np.cos(pitch), np.sin(pitch), np.zeros_like(t)
    accel = np.stack([cos * force[0] - sin * force[1], zero, sin * force[0] + cos * force[1]], 1)
    gyro = np.stack([zero, np.gradient(pitch, 0.01), zero], axis=1)
    events = tools.said(estimator(), tools.Walk(accel, gyro, 0.01, 0.0, []))
    assert tools.lengths_m(events) == []


@pytest.mark.parametrize("seed", range(4))
def test_fidgeting_gives_next_to_no_strides(tools, seed):
    rng = np.random.default_rng(seed)
    kernel = np.hanning(60) / np.hanning(60).sum()

    def smooth(scale):
        noise = rng.standard_normal((3000, 3))
        columns = [np.convolve(column, kernel, "same") for column in noise.T]
        return scale * np.stack(columns, axis=1) / np.std(columns)

    walk = tools.Walk(smooth(1.5) + np.array([0.0, 0.0, 9.8]), smooth(1.5), 0.01, 0.0, [])
    assert len(tools.lengths_m(tools.said(estimator(), walk))) <= 1


def test_stepping_on_the_spot_gives_no_stride(tools):
    walk = tools.walk(bump_mps=-0.23, creep_mps=0.0)
    assert tools.lengths_m(tools.said(estimator(roll_share=0.0), walk)) == []


@pytest.mark.parametrize("after_toe_off", [-30, 15], ids=["in stance", "in swing"])
def test_strides_lost_in_mid_walk_are_interpolated_and_said_so(tools, after_toe_off):
    walk = tools.walk(strides=8)
    whole = tools.last_distance(tools.said(estimator(), walk))
    events = tools.said_with_gap(estimator(), walk, walk.toe_offs[3] + after_toe_off, 50)
    distance = tools.last_distance(events)
    assert distance.distance_m == pytest.approx(whole.distance_m, rel=0.01)
    assert distance.distance_sigma_m > 1.02 * whole.distance_sigma_m
    assert distance.unmeasured_s > 1.0
    said = [e for e in events if isinstance(e, Anomaly)]
    assert [e.anomaly for e in said] == ["gap-in-stride"]
    assert "interpolated" in said[0].detail


def test_strides_lost_early_wait_for_one_that_is_like_them(tools):
    walk = tools.walk(strides=8)
    whole = tools.last_distance(tools.said(estimator(), walk))
    events = tools.said_with_gap(estimator(), walk, walk.toe_offs[1] + 25, 50)
    assert tools.last_distance(events).distance_m == pytest.approx(whole.distance_m, rel=0.02)
    starts = [e.start_t_ns for e in events if isinstance(e, Stride)]
    assert starts == sorted(starts)


def test_of_what_a_long_gap_swallowed_nothing_is_made_up(tools):
    walk = tools.walk(strides=8)
    whole = tools.said(estimator(), walk)
    events = tools.said_with_gap(estimator(), walk, walk.toe_offs[3] + 15, 150)
    lengths_m = tools.lengths_m(events)
    assert len(lengths_m) < len(tools.lengths_m(whole))
    distance = tools.last_distance(events)
    lost_m = tools.last_distance(whole).distance_m - distance.distance_m
    assert 0.0 < lost_m < 1.96 * distance.distance_sigma_m


def test_a_gap_of_a_few_samples_is_bridged(tools):
    walk = tools.walk()
    events = tools.said_with_gap(estimator(), walk, walk.toe_offs[2] + 10, 3)
    assert tools.last_distance(events).distance_m == pytest.approx(walk.distance_m, rel=0.03)
    assert tools.last_distance(events).unmeasured_s == 0.0


def test_a_gap_while_resting_costs_nothing(tools):
    walk = tools.walk(rest_s=6.0)
    events = tools.said_with_gap(estimator(), walk, 100, 250)
    assert len(tools.lengths_m(events)) == 6
    assert tools.last_distance(events).unmeasured_s == 0.0


def test_clipping_is_seen_in_the_data_and_widens_sigma(tools):
    walk = tools.walk()
    clipped = tools.Walk(np.clip(walk.accel, -14.7, 14.7), walk.gyro, 0.01, 0.0, [])
    events = tools.said(estimator(), clipped)
    assert "sensor-clipped" in {e.anomaly for e in events if isinstance(e, Anomaly)}
    plain = tools.said(estimator(), walk)
    assert [e for e in plain if isinstance(e, Anomaly)] == []
    assert (
        tools.last_distance(events).distance_sigma_m > tools.last_distance(plain).distance_sigma_m
    )


def test_a_stance_too_short_for_one_gives_no_stride(tools):
    assert tools.lengths_m(tools.said(estimator(min_stance_s=0.8), tools.walk())) == []


def test_a_stride_longer_than_anybody_s_is_not_counted(tools):
    assert tools.lengths_m(tools.said(estimator(max_stride_m=0.5), tools.walk())) == []


def test_a_stride_that_does_not_close_is_not_counted_and_said(tools):
    walk = tools.walk(strides=8)
    walk.accel[walk.toe_offs[3] + 10 : walk.toe_offs[3] + 14] += (150.0, 0.0, 150.0)
    events = tools.said(estimator(), walk)
    assert "implausible-stride" in {e.anomaly for e in events if isinstance(e, Anomaly)}
    assert tools.last_distance(events).unmeasured_s > 0.5


def test_the_trace_has_every_sample_once_and_ends_at_the_distance(tools, reference):
    walk, events = reference
    est = estimator()
    trace = est.start_trace()
    assert tools.said(est, walk, range(50, len(walk), 50)) == events
    assert trace.t_ns == [round(i * 1e7) for i in range(len(walk))]
    rows = np.array(trace.rows)
    assert rows[-1, 0] == pytest.approx(tools.last_distance(events).distance_m)
    assert trace.columns == ("pos_x_m", "pos_z_m", "vel_x_mps", "pitch_rad", "stance")
    in_swing = rows[:, 4] == 0.0
    assert 0.3 < in_swing.sum() * 0.01 / 3 < 0.45
    assert rows[in_swing, 2].mean() > 3.0 * rows[~in_swing, 2].mean()


def test_the_trace_has_every_sample_around_a_gap(tools):
    walk, est = tools.walk(), estimator()
    trace = est.start_trace()
    tools.said_with_gap(est, walk, 520, 30)
    assert trace.t_ns == [round(i * 1e7) for i in [*range(520), *range(550, len(walk))]]


def test_memory_does_not_grow_with_the_recording(tools):
    walk, est = tools.walk(strides=30, rest_s=60.0), estimator()
    sizes = []
    for begin in range(0, len(walk), 50):
        est.update(walk.batch(begin, min(begin + 50, len(walk))))
        sizes.append(len(est._stretch._track._t_ns))
    assert max(sizes) < 600


@pytest.mark.parametrize("share", [0.1, 0.4, 0.55, 0.8])
@pytest.mark.parametrize("method", ["default", "s2"])
def test_a_restart_in_mid_walk_neither_invents_nor_loses(tools, reference, share, method):
    walk, _ = reference
    kind = ShankEstimator if method == "default" else PublishedEstimator
    params = ShankParams(method=method)
    cut = round(share * len(walk))
    first, second = kind(params), kind(params)
    before = first.update(walk.batch(0, cut))
    second.restore(first.save())
    after = [*second.update(walk.batch(cut, len(walk))), *second.finish()]
    assert [*before, *after] == tools.said(kind(params), walk)
