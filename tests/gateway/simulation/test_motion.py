import numpy as np
import pytest

from gaitway.simulation import (
    GRAVITY_MPS2,
    Constant,
    ImuRun,
    RigidMotion,
    ideal_imu,
    imu_attitude,
    mounted,
)

UPRIGHT = {"x": "forward", "y": "left", "z": "up"}
STANDING = RigidMotion(Constant(1.0, 2.0, 3.0), Constant(0.3, 0.0, 0.0))
T_S = np.arange(101) / 100.0


class Line:
    """A curve of constant rate and acceleration from zero."""

    def __init__(self, rates, accelerations):
        self.rates, self.accelerations = np.array(rates), np.array(accelerations)

    def __call__(self, t_s, order=0):
        t = t_s[:, None]
        if order == 0:
            return self.rates * t + 0.5 * self.accelerations * t**2
        return self.rates + self.accelerations * t


STILL = Line([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("mounting", "expected"),
    [
        (UPRIGHT, [0, 0, GRAVITY_MPS2]),
        ({"x": "up", "y": "right", "z": "forward"}, [GRAVITY_MPS2, 0, 0]),
        ({"x": "left", "y": "down", "z": "backward"}, [0, -GRAVITY_MPS2, 0]),
    ],
)
def test_at_rest_the_axis_that_points_up_reads_plus_g(mounting, expected):
    run = ideal_imu(STANDING, mounted(mounting, (0.1, 0.2, 0.5)), T_S)
    np.testing.assert_allclose(run.accel_b, np.tile(expected, (100, 1)), atol=1e-12)
    np.testing.assert_allclose(run.gyro_b, np.zeros((100, 3)), atol=1e-12)


def test_in_free_fall_nothing_is_felt():
    falling = RigidMotion(Line([1.0, 0.0, 0.0], [0.0, 0.0, -GRAVITY_MPS2]), STILL)
    run = ideal_imu(falling, mounted(UPRIGHT, (0.0, 0.0, 0.5)), T_S)
    np.testing.assert_allclose(run.accel_b, np.zeros((100, 3)), atol=1e-9)


def test_speeding_up_is_felt_forward():
    starting = RigidMotion(Line([0.0, 0.0, 0.0], [2.0, 0.0, 0.0]), STILL)
    run = ideal_imu(starting, mounted(UPRIGHT, (0.0, 0.0, 0.0)), T_S)
    np.testing.assert_allclose(run.accel_b[:, 0], 2.0, atol=1e-9)


def test_spinning_shows_rate_and_centripetal_force_at_the_lever_arm():
    spinning = RigidMotion(Constant(0.0, 0.0, 0.0), Line([5.0, 0.0, 0.0], [0.0, 0.0, 0.0]))
    run = ideal_imu(spinning, mounted(UPRIGHT, (0.2, 0.0, 0.1)), T_S)
    np.testing.assert_allclose(run.gyro_b, np.tile([0.0, 0.0, 5.0], (100, 1)), atol=1e-9)
    np.testing.assert_allclose(
        run.accel_b, np.tile([-25.0 * 0.2, 0.0, GRAVITY_MPS2], (100, 1)), atol=1e-9
    )


def test_a_long_interval_says_the_same_as_the_short_ones_in_it():
    rng = np.random.default_rng(5)
    tumbling = RigidMotion(
        Line(rng.normal(size=3), rng.normal(size=3)), Line(rng.normal(size=3), rng.normal(size=3))
    )
    place = mounted(UPRIGHT, (0.1, -0.3, 0.4))
    direct = ideal_imu(tumbling, place, T_S[::10])
    merged = ideal_imu(tumbling, place, T_S).merged(10)
    assert merged.period_s == pytest.approx(0.1)
    np.testing.assert_allclose(merged.gyro_b, direct.gyro_b, atol=1e-10)
    np.testing.assert_allclose(merged.accel_b, direct.accel_b, atol=1e-10)


def test_merging_intervals_without_turning_is_the_plain_mean():
    run = ImuRun(0.01, np.zeros((4, 3)), np.arange(12.0).reshape(4, 3))
    np.testing.assert_allclose(run.merged(2).accel_b, [[1.5, 2.5, 3.5], [7.5, 8.5, 9.5]])


def test_attitude_takes_imu_components_to_the_world():
    place = mounted({"x": "up", "y": "right", "z": "forward"}, (0.0, 0.0, 0.0))
    q_nb = imu_attitude(RigidMotion(STILL, Constant(0.0, 0.0, 0.0)), place, np.zeros(1))
    np.testing.assert_allclose(np.abs(q_nb), [[0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)]], atol=1e-12)


def test_attitude_keeps_its_scalar_positive_all_the_way_round():
    round_and_round = RigidMotion(STILL, Line([6.0, 0.0, 0.0], [0.0, 0.0, 0.0]))
    q_nb = imu_attitude(round_and_round, mounted(UPRIGHT, (0.0, 0.0, 0.0)), 3.0 * T_S)
    assert q_nb[:, 0].min() >= 0.0
    np.testing.assert_allclose(np.linalg.norm(q_nb, axis=1), 1.0, atol=1e-12)


def test_an_imu_fixed_awry_leans_as_told():
    place = mounted(UPRIGHT, (0.0, 0.0, 0.0), (0.0, 0.1, 0.0))
    run = ideal_imu(RigidMotion(STILL, Constant(0.0, 0.0, 0.0)), place, T_S)
    expected = GRAVITY_MPS2 * np.array([-np.sin(0.1), 0.0, np.cos(0.1)])
    np.testing.assert_allclose(run.accel_b, np.tile(expected, (100, 1)), atol=1e-12)
