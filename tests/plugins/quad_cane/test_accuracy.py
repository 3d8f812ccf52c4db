"""Distance on simulated walks with exact truth; the sensor is of the class of an MTi-1."""

import numpy as np
import pytest

SHORT_M = 3.3
"""The way of Dang & Suh (2018), Table 1; their mean absolute error there is 9.8 cm."""


def matched(result, truth):
    """Return stride errors and their standard deviations; every true stride was found."""
    assert len(result.strides) == len(truth.stride_length_m)
    lengths_m = np.array([stride.stride_length_m for stride in result.strides])
    sigmas_m = np.array([stride.stride_length_sigma_m for stride in result.strides])
    return lengths_m - truth.stride_length_m, sigmas_m


@pytest.mark.parametrize("seeds", [range(10)])
def test_ten_short_walks_are_right_to_three_centimetres_on_average(walk, batch_of, run, seeds):
    errors_m = []
    for seed in seeds:
        truth = walk(SHORT_M, seed=seed)
        errors_m.append(run(batch_of(truth)).distance_m - truth.distance_m)
    assert np.mean(np.abs(errors_m)) < 0.03
    assert np.max(np.abs(errors_m)) < 0.06


@pytest.mark.slow
@pytest.mark.parametrize("seed", [11])
def test_170_m_with_a_turn_is_right_to_half_a_percent(walk, batch_of, run, seed):
    truth = walk(170.0, seed=seed, turn_back=True)
    result = run(batch_of(truth))
    assert result.distance_m == pytest.approx(truth.distance_m, rel=0.005)
    assert len(result.strides) == len(truth.stride_length_m)
    assert result.unmeasured_s == 0.0


@pytest.mark.parametrize("speed_mps", [0.08, 0.2, 0.5, 0.9])
def test_slow_and_fast_people_are_measured_alike(walk, batch_of, run, speed_mps):
    for seed in range(3):
        truth = walk(3.0, seed=seed, speed_mps=speed_mps)
        errors_m, _ = matched(run(batch_of(truth)), truth)
        assert abs(errors_m.sum()) < 0.02 * truth.distance_m


@pytest.mark.parametrize("seed", [4])
def test_50_100_and_200_hz_agree(walk, batch_of, run, seed):
    found = [
        run(batch_of(walk(8.0, seed=seed, rate_hz=rate_hz))).distance_m
        for rate_hz in (50.0, 100.0, 200.0)
    ]
    assert found == pytest.approx([found[1]] * 3, rel=0.005)


@pytest.mark.parametrize("seed", [2])
def test_an_ideal_sensor_leaves_no_error_worth_mentioning(walk, batch_of, run, seed):
    truth = walk(SHORT_M, seed=seed, ideal_sensor=True)
    errors_m, _ = matched(run(batch_of(truth), imu_height_m=0.5), truth)
    assert np.abs(errors_m).max() < 2e-3


@pytest.mark.parametrize("seeds", [range(40, 64)])
def test_true_distances_and_strides_lie_where_the_sigmas_say(walk, batch_of, run, seeds):
    totals, strides = [], []
    for seed in seeds:
        truth = walk(6.0, seed=seed)
        result = run(batch_of(truth))
        errors_m, sigmas_m = matched(result, truth)
        strides.append(errors_m / sigmas_m)
        totals.append(errors_m.sum() / result.sigma_m)
    within = np.mean(np.abs(totals) < 1.96)
    assert within >= 0.9
    # Not honest either: a sigma that is much too large.
    assert 0.5 < np.std(totals) < 1.4
    assert 0.4 < np.std(np.concatenate(strides)) < 1.4


def test_sigmas_grow_where_contacts_show_more_noise_than_was_assumed(walk, batch_of, run):
    """The parameters promise a sensor many times better than the one that walks."""
    normalised = []
    for seed in range(80, 84):
        truth = walk(8.0, seed=seed)
        boast = {"accel_noise_mps2_rthz": 2e-4, "gyro_noise_radps_rthz": 2e-5}
        precise = {"zero_velocity_sigma_mps": 5e-4, "imu_height_m": 0.5, "imu_height_sigma_m": 0.0}
        errors_m, sigmas_m = matched(run(batch_of(truth), **boast, **precise), truth)
        normalised.append((errors_m / sigmas_m)[10:])
    assert np.std(np.concatenate(normalised)) < 1.7


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_the_published_method_runs_too_and_is_worse(walk, batch_of, run, seed):
    truth = walk(SHORT_M, seed=seed)
    published = run(batch_of(truth), method="published")
    errors_m, _ = matched(published, truth)
    assert abs(errors_m.sum()) < 0.134
    default = run(batch_of(truth))
    assert abs(default.distance_m - truth.distance_m) < abs(errors_m.sum())


@pytest.mark.parametrize("seed", [1])
def test_the_published_method_takes_a_smooth_swing_for_a_contact(walk, batch_of, run, seed):
    """Its contact test is one of norms: at constant velocity nothing tells air from floor."""
    truth = walk(SHORT_M, seed=seed)
    published = run(batch_of(truth), method="published")
    assert abs(published.distance_m - truth.distance_m) > 0.5
    assert run(batch_of(truth)).distance_m == pytest.approx(truth.distance_m, abs=0.02)


@pytest.mark.parametrize("seed", [5])
def test_contacts_are_told_when_the_cane_has_come_to_rest(walk, batch_of, run, seed):
    """From the touch of the feet to quiet it rings for less than a tenth of a second."""
    truth = walk(6.0, seed=seed)
    strides = run(batch_of(truth)).strides
    start_ns = int(batch_of(truth).t_ns[0])
    found_s = np.array([(stride.t_ns - start_ns) / 1e9 for stride in strides])
    late_s = found_s - truth.stride_end_s
    assert late_s.min() > -0.02
    assert late_s.max() < 0.15
    assert np.std(late_s) < 0.03


def test_a_stride_is_made_of_its_stance_and_its_swing(walk, batch_of, run):
    first, *others = run(batch_of(walk(6.0, seed=5))).strides
    assert first.stance_duration_s is None
    assert first.stride_duration_s == first.swing_duration_s
    for stride in others:
        parts_s = stride.stance_duration_s + stride.swing_duration_s
        assert stride.stride_duration_s == pytest.approx(parts_s)
    starts = [stride.start_t_ns for stride in others]
    assert starts == [stride.t_ns for stride in (first, *others[:-1])]
