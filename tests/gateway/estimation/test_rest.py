import numpy as np
import pytest

from gaitway.estimation import (
    ATT,
    GYRO_BIAS,
    ErrorStateFilter,
    Rest,
    RestDetector,
    align_at_rest,
    level_at_rest,
)
from gaitway.estimation.rotation import rotate

BIAS = np.array([0.01, -0.02, 0.005])
UP = np.array([0.5, -1.0, 9.7])


def detector(**changes):
    settings = {
        "window_s": 0.5,
        "accel_std_max_mps2": 0.08,
        "gyro_std_max_radps": 0.02,
        "gyro_max_radps": 0.06,
    }
    return RestDetector(0.01, **(settings | changes))


def readings(count, rng, accel_std=0.02, gyro_std=0.002, bias=BIAS):
    accel = UP + accel_std * rng.standard_normal((count, 3))
    gyro = bias + gyro_std * rng.standard_normal((count, 3))
    return [(tuple(a), tuple(w)) for a, w in zip(accel.tolist(), gyro.tolist(), strict=True)]


def rng(seed=3):
    return np.random.default_rng(seed)


def test_a_rest_is_told_when_its_window_is_full_with_the_means():
    rests = detector()
    answers = [rests.push(*reading) for reading in readings(50, rng())]
    assert answers[:49] == [None] * 49
    assert answers[49].gyro_d == pytest.approx(BIAS, abs=2e-3)
    assert answers[49].accel_d == pytest.approx(UP, abs=0.02)
    assert answers[49].duration_s == pytest.approx(0.5)


@pytest.mark.parametrize(
    "unrest", [{"accel_std": 0.2}, {"gyro_std": 0.05}, {"bias": np.array([0.0, 0.1, 0.0])}]
)
def test_shaking_and_turning_are_no_rest(unrest):
    rests = detector()
    assert not any(rests.push(*reading) for reading in readings(500, rng(), **unrest))


def test_movement_keeps_rest_away_until_it_has_left_the_window():
    rests = detector()
    for reading in readings(200, rng()):
        rests.push(*reading)
    rests.push((0.0, 0.0, 30.0), (5.0, 0.0, 0.0))
    answers = [rests.push(*reading) for reading in readings(60, rng())]
    assert answers[:49] == [None] * 49
    assert all(answers[49:])


def test_a_rest_is_found_after_large_values():
    """Running sums are taken anew, so no rounding is left of values long gone."""
    rests = detector()
    for value in np.linspace(-5e8, 5e8, 2000):
        rests.push((value, value, value), (value, value, value))
    last = [rests.push(*reading) for reading in readings(150, rng())][-1]
    assert last.gyro_d == pytest.approx(BIAS, abs=2e-3)


def test_alignment_stands_upright_with_no_heading_and_the_bias_it_felt():
    kf = ErrorStateFilter()
    align_at_rest(
        kf,
        Rest(tuple(UP.tolist()), tuple(BIAS.tolist()), 0.5),
        accel_bias_sigma_mps2=0.05,
        gyro_bias_sigma_radps=1e-3,
        velocity_sigma_mps=1e-3,
    )
    assert rotate(kf.q_nd, UP.tolist()) == pytest.approx((0.0, 0.0, np.linalg.norm(UP)), abs=1e-3)
    assert kf.gyro_bias_d == pytest.approx(BIAS)
    assert kf.covariance[8, 8] == 0.0


def test_levelling_keeps_what_is_known_of_the_biases():
    kf = ErrorStateFilter()
    kf.gyro_bias_d[:] = 0.03
    kf.set_block(GYRO_BIAS, 1e-8)
    level_at_rest(kf, Rest(tuple(UP.tolist()), tuple(BIAS.tolist()), 0.5), velocity_sigma_mps=1e-3)
    assert kf.gyro_bias_d == pytest.approx(np.full(3, 0.03))
    assert kf.covariance[GYRO_BIAS, GYRO_BIAS] == pytest.approx(1e-8 * np.eye(3))
    assert kf.covariance[ATT, ATT].diagonal()[:2].max() < 1e-3
