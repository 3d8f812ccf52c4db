"""The estimator's parts, each where its answer can be worked out by hand."""

import numpy as np
import pytest

from gaitway.estimation import ImuSample
from gaitway.estimation.rotation import from_rotation_vector, to_matrix
from gaitway_plugins.shank.clipping import ClipDetector
from gaitway_plugins.shank.footing import Footing
from gaitway_plugins.shank.learning import AnkleHeight, RestLearner
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.rollover import RollOver, fit_roll_over, pivot_depth
from gaitway_plugins.shank.stride import find_way
from gaitway_plugins.shank.swings import Mark, SwingDetector
from gaitway_plugins.shank.track import Piece, Track

G = 9.80665
T_S = np.arange(0.0, 1.005, 0.01)


def still(rows=101, accel=(0.0, 0.0, G), gyro=(0.0, 1.0, 0.0)):
    return Piece(0.01, np.tile(accel, (rows, 1)), np.tile(gyro, (rows, 1)), 0)


def rolling(height_m, creep_mps=0.0, tilt_rad=0.0):
    """Return the foot-flat part of a stance whose track is tilted, and its forward velocity."""
    rate = 1.0 + 0.8 * np.cos(2 * np.pi * T_S)
    speed = height_m * rate + creep_mps
    zero = np.zeros_like(T_S)
    accel_n = np.stack([np.gradient(speed, 0.01), zero, zero + G], axis=1)
    gyro_n = np.stack([zero, rate, zero], axis=1)
    C_nc = to_matrix(from_rotation_vector((0.0, tilt_rad, 0.0)))
    return Piece(0.01, accel_n @ C_nc, gyro_n @ C_nc, 0), speed


def footing(C_nc, speed_mps=0.0):
    vel_n = np.array([speed_mps, 0.0, 0.0])
    fit = RollOver(C_nc, np.zeros((2, 3)), 0.0)
    return Footing(index=0, t_ns=0, vel_n=vel_n, fit=fit, flat=None, fits=True)


@pytest.mark.parametrize("tilt_rad", [0.0, 0.3, -0.5])
def test_a_roll_over_gives_tilt_and_velocity_whatever_the_track_s_tilt(tilt_rad):
    piece, speed = rolling(0.2, 0.07, tilt_rad)
    fit = fit_roll_over(piece, height_m=0.2, roll_share=0.3, gravity_mps2=G)
    assert fit.C_nc[2] == pytest.approx([-np.sin(tilt_rad), 0.0, np.cos(tilt_rad)], abs=2e-3)
    assert fit.vel_n[:, 0] == pytest.approx(speed, abs=0.01)
    assert fit.rms_mps < 5e-3


def test_a_roll_over_about_another_point_fits_worse():
    piece, _ = rolling(-0.3)
    fit = fit_roll_over(piece, height_m=0.2, roll_share=0.0, gravity_mps2=G)
    assert fit.rms_mps == pytest.approx(0.5 * 0.8 / 2.0, rel=0.1)


@pytest.mark.parametrize("height_m", [0.2, 0.05, -0.3])
def test_the_depth_of_the_pivot_is_read_off_a_stance(height_m):
    piece, _ = rolling(height_m, creep_mps=0.2)
    depth_m, sigma_m = pivot_depth(piece, np.eye(3), G)
    assert depth_m == pytest.approx(height_m, abs=0.01)
    assert 0.01 < sigma_m < 0.1


def test_a_way_at_constant_speed_is_speed_times_time():
    way = find_way(still(), footing(np.eye(3), 1.5), footing(np.eye(3), 1.5), G)
    assert way.length_m == pytest.approx(1.5)
    assert way.closing_mps2 == pytest.approx(0.0)


def test_what_velocity_lacks_at_the_end_is_spread_evenly():
    way = find_way(still(), footing(np.eye(3), 1.0), footing(np.eye(3), 2.0), G)
    assert way.closing_mps2 == pytest.approx(1.0)
    assert way.length_m == pytest.approx(1.5)


def test_a_tilt_step_is_spread_over_the_turning():
    tilted_nc = to_matrix(from_rotation_vector((0.0, 0.1, 0.0)))
    way = find_way(still(), footing(np.eye(3)), footing(tilted_nc), G)
    assert way.tilt_step_rad == pytest.approx(0.1)
    # A force that grows evenly from -g a / 2 to g a / 2 moves by g a T^2 / 12.
    assert way.length_m == pytest.approx(G * 0.1 / 12.0, rel=0.01)


def test_the_velocity_after_is_turned_into_the_heading_before():
    turned_nc = to_matrix(from_rotation_vector((0.0, 0.0, 0.5)))
    after = Footing(
        0, 0, turned_nc @ np.array([1.0, 0.0, 0.0]), RollOver(turned_nc, np.zeros((2, 3)), 0.0),
        None, True,
    )  # fmt: skip
    way = find_way(still(), footing(np.eye(3), 1.0), after, G)
    assert way.pos_n[-1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)


def learned(bias_d, sway_rad, seconds=6, gravity=9.95):
    """Return a learner after standing with a sway, on a sensor with a bias."""
    learner = RestLearner(ShankParams())
    track = Track(0.01, learner.gyro_bias_d)
    begin = 0
    for i in range(seconds * 100 + 1):
        pitch = sway_rad * np.sin(0.9 * i * 0.01)
        rate = 0.9 * sway_rad * np.cos(0.9 * i * 0.01)
        accel = (-gravity * np.sin(pitch), 0.0, gravity * np.cos(pitch))
        gyro = tuple(np.array([0.0, rate, 0.0]) + bias_d)
        track.push(ImuSample(i, accel, gyro, False, False), clipped=False)
        if i - begin == 100:
            learner.learn(track.piece(begin, i), track.attitude((begin + i) // 2))
            track.gyro_bias_d = learner.gyro_bias_d
            begin = i
    return learner


def test_bias_and_gravity_are_learned_from_standing_that_sways():
    learner = learned((0.012, -0.015, 0.0), sway_rad=0.05, seconds=15)
    assert learner.gyro_bias_d[:2] == pytest.approx((0.012, -0.015), abs=2e-3)
    assert learner.gravity_mps2 == pytest.approx(9.95, abs=0.01)


def test_sway_alone_is_not_taken_for_bias():
    # Over one second the mean rate of this sway is up to 0.04 rad/s.
    assert learned((0.0, 0.0, 0.0), sway_rad=0.05).gyro_bias_d == pytest.approx((0, 0, 0), abs=1e-3)


def test_the_height_above_the_ankle_settles():
    ankle = AnkleHeight(ShankParams())
    rate = 1.0 + np.cos(2 * np.pi * T_S)
    for _ in range(100):
        ankle.learn(0.25 * rate + 0.4, rate)
    settled_m = ankle.height_m
    assert settled_m == pytest.approx(0.25, abs=0.005)
    ankle.learn(0.35 * rate, rate)
    assert settled_m < ankle.height_m < settled_m + 0.005


def test_an_odd_stance_teaches_nothing():
    ankle = AnkleHeight(ShankParams())
    rate = 1.0 + np.cos(2 * np.pi * T_S)
    ankle.learn(1.2 * rate, rate)
    ankle.learn(rate, np.ones_like(rate))
    assert ankle.height_m == ShankParams().ankle_to_imu_m


def marks(rates):
    detector = SwingDetector(ShankParams(), 0.01)
    return [(f.mark, f.at) for rate in rates if (f := detector.push(rate)) is not None]


def test_a_swing_is_told_with_the_samples_at_which_it_began_and_ended():
    rates = [1.0] * 50 + [-4.0] * 40 + [1.0] * 20
    assert marks(rates) == [(Mark.TOE_OFF, 50), (Mark.CONTACT, 90)]


@pytest.mark.parametrize("run", [[-0.9] * 60, [-5.0] * 3], ids=["slow", "short"])
def test_a_slow_or_short_turn_back_is_no_swing(run):
    assert marks([0.5] * 20 + run + [0.5] * 20) == []


def test_an_endless_swing_is_told_once():
    found = marks([1.0] * 5 + [-3.0] * 300 + [1.0] * 5)
    assert found == [(Mark.TOE_OFF, 5), (Mark.TOO_LONG, 126)]


def clipped(readings):
    detector = ClipDetector()
    samples = [ImuSample(0, (x, 0.0, 9.8), (0.0, 0.1, 0.0), False, False) for x in readings]
    return [detector.push(sample) for sample in samples]


def test_three_equal_high_readings_are_a_ceiling():
    assert clipped([10.0, 14.7, 14.7, 14.7, 14.7, 9.0]) == [False, False, False, True, True, False]


def test_equal_readings_of_a_sensor_at_rest_are_none():
    assert clipped([0.3] * 10) == [False] * 10


@pytest.mark.parametrize("gyro_y_radps", [0.0, 0.1], ids=["some equal", "none equal"])
def test_a_device_that_says_it_clipped_is_believed(gyro_y_radps):
    sample = ImuSample(0, (1.0, 0.1, 9.8), (0.1, gyro_y_radps, 0.1), True, False)
    assert ClipDetector().push(sample)


@pytest.mark.parametrize(
    "changes",
    [{"roll_begin": 0.5, "roll_end": 0.5}, {"standing_window_s": 3.0}],
    ids=str,
)
def test_parameters_that_contradict_each_other_are_refused(changes):
    with pytest.raises(ValueError, match=r"must"):
        ShankParams(**changes)
