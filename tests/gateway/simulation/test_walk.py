from dataclasses import replace

import numpy as np
import pytest

from gaitway.contracts import WalkPlan
from gaitway.simulation import (
    Constant,
    ImuModel,
    RigidMotion,
    Spline,
    Stacked,
    TrueStride,
    mounted,
    record,
    rest,
)

UPRIGHT = {"x": "forward", "y": "left", "z": "up"}
PLACE = mounted(UPRIGHT, (0.0, 0.0, 0.5))
PUSH = RigidMotion(
    Stacked(Spline([rest(1.0, 0.0), rest(1.6, 0.8)]), Constant(0.0, 0.0)),
    Stacked(Constant(0.0), Spline([rest(1.0, 0.1), rest(1.6, 0.3)]), Constant(0.0)),
)
STRIDES = [TrueStride(1.0, 1.6, 0.8)]
PLAN = WalkPlan(distance_m=0.8, seed=1)


def test_sample_i_is_at_i_over_the_rate_from_zero_to_the_duration():
    walk = record(replace(PLAN, rate_hz=50.0), PUSH, PLACE, 3.0, STRIDES)
    assert walk.rate_hz == 50.0
    assert walk.pos_n.shape == (151, 3)
    assert walk.q_nb.shape == (151, 4)
    assert {name: values.shape for name, values in walk.channels.items()} == {
        "accel": (151, 3),
        "gyro": (151, 3),
        "clip": (151, 1),
    }
    assert walk.pos_n[50, 0] == 0.0
    assert walk.pos_n[51, 0] > 0.0


def test_sample_stands_for_the_interval_that_ends_with_it():
    walk = record(replace(PLAN, ideal_sensor=True), PUSH, PLACE, 3.0, STRIDES)
    assert np.abs(walk.channels["gyro"][:101]).max() < 1e-12
    assert np.abs(walk.channels["gyro"][101]).max() > 1e-6
    turned_rad = walk.channels["gyro"][: 130 + 1, 1].sum() / 100.0
    assert turned_rad == pytest.approx(0.1, abs=1e-9)


def test_truth_is_of_the_point_that_is_measured():
    walk = record(PLAN, PUSH, PLACE, 3.0, STRIDES, measured_d=(0.0, 0.0, 0.5))
    expected = [0.8 + 0.5 * np.sin(0.3), 0.0, 0.5 * np.cos(0.3)]
    np.testing.assert_allclose(walk.pos_n[-1], expected, atol=1e-12)


def test_strides_are_kept_in_order():
    strides = [*STRIDES, TrueStride(1.6, 2.2, 0.3)]
    walk = record(PLAN, PUSH, PLACE, 3.0, strides)
    np.testing.assert_array_equal(walk.stride_start_s, [1.0, 1.6])
    np.testing.assert_array_equal(walk.stride_end_s, [1.6, 2.2])
    np.testing.assert_array_equal(walk.stride_length_m, [0.8, 0.3])
    assert walk.distance_m == pytest.approx(1.1)


def test_the_errors_of_a_sensor_are_small_and_there():
    ideal = record(replace(PLAN, ideal_sensor=True), PUSH, PLACE, 3.0, STRIDES)
    real = record(PLAN, PUSH, PLACE, 3.0, STRIDES)
    for name, bound in (("accel", 0.3), ("gyro", 0.05)):
        error = np.abs(real.channels[name] - ideal.channels[name])
        assert 1e-4 < error.max() < bound


def test_takes_another_kind_of_imu():
    model = ImuModel(accel=replace(ImuModel().accel, full_scale=9.0))
    walk = record(PLAN, PUSH, PLACE, 3.0, STRIDES, model=model)
    assert np.all(walk.channels["clip"][:100] == 4.0)


def test_an_ideal_sensor_never_clips():
    model = ImuModel(accel=replace(ImuModel().accel, full_scale=9.0))
    walk = record(replace(PLAN, ideal_sensor=True), PUSH, PLACE, 3.0, STRIDES, model=model)
    assert not walk.channels["clip"].any()
    assert walk.channels["accel"][0, 2] > 9.7


def test_channels_can_not_be_written_to():
    walk = record(PLAN, PUSH, PLACE, 3.0, STRIDES)
    assert not any(values.flags.writeable for values in walk.channels.values())
