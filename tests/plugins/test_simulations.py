"""What every simulated walk promises, and what is particular to each device."""

import numpy as np
import pytest

from gaitway.api import SimulatedWalk, WalkPlan
from gaitway.simulation import GRAVITY_MPS2, ImuRun
from gaitway_plugins.quad_cane import simulation as quad_cane
from gaitway_plugins.shank import simulation as shank

DEVICES = {"quad-cane": quad_cane, "shank": shank}
MEASURED_TO_IMU_D = {"quad-cane": np.array(quad_cane.BASE_TO_IMU_D), "shank": np.zeros(3)}
LONGEST_STRIDE_M = {"quad-cane": 0.9, "shank": 2.0}
each_device = pytest.mark.parametrize("device", DEVICES)


def walk(device: str, distance_m: float = 8.0, **plan) -> SimulatedWalk:
    return DEVICES[device].simulate(WalkPlan(distance_m, **plan))


def cross(vec):
    x, y, z = vec
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def matrix_of(q):
    w, x, y, z = q
    return (w * w - x * x - y * y - z * z) * np.eye(3) + 2.0 * (
        np.outer([x, y, z], [x, y, z]) + w * cross([x, y, z])
    )


def dead_reckoned(simulated: SimulatedWalk):
    """Return where the IMU goes from the first sample on, and its attitude at the end.

    Attitude by the power series of the rotation, velocity by that of its mean over the interval,
    position by the trapezoid: the plainest strapdown there is, with no correction.
    """
    period_s = 1.0 / simulated.rate_hz
    attitude = matrix_of(simulated.q_nb[0])
    velocity, position = np.zeros(3), np.zeros(3)
    way = [position]
    samples = zip(simulated.channels["gyro"][1:], simulated.channels["accel"][1:], strict=True)
    for gyro, accel in samples:
        turn = cross(gyro * period_s)
        square = turn @ turn
        mean = np.eye(3) + turn / 2 + square / 6 + turn @ square / 24 + square @ square / 120
        change = (attitude @ mean @ accel - [0.0, 0.0, GRAVITY_MPS2]) * period_s
        position = position + (velocity + 0.5 * change) * period_s
        velocity = velocity + change
        attitude = attitude @ (np.eye(3) + turn @ mean)
        way.append(position)
    return np.array(way), attitude


def imu_way(device: str, simulated: SimulatedWalk):
    """Return the true way of the IMU from the true way of the measured point and the attitude."""
    mounting = DEVICES[device].MOUNTING
    assert mounting == {"x": "up", "y": "right", "z": "forward"}
    forward, left, up = MEASURED_TO_IMU_D[device]
    lever_b = np.array([up, -left, forward])
    return simulated.pos_n + [matrix_of(q) @ lever_b for q in simulated.q_nb]


@each_device
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("turn_back", [False, True])
def test_integrating_the_ideal_sensor_returns_the_true_way(device, seed, turn_back, monkeypatch):
    monkeypatch.setattr(quad_cane, "AWRY_SIGMA_RAD", 0.0)
    simulated = walk(device, 20.0, seed=seed, turn_back=turn_back, ideal_sensor=True)
    way, attitude = dead_reckoned(simulated)
    truth = imu_way(device, simulated)
    assert np.abs(way - (truth - truth[0])).max() < 0.01
    np.testing.assert_allclose(attitude, matrix_of(simulated.q_nb[-1]), atol=1e-7)


@each_device
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("distance_m", [4.0, 15.0])
def test_walks_as_far_as_planned_to_half_a_stride(device, seed, distance_m):
    simulated = walk(device, distance_m, seed=seed, ideal_sensor=True)
    assert abs(simulated.distance_m - distance_m) <= 0.55 * LONGEST_STRIDE_M[device]


@each_device
@pytest.mark.parametrize("seed", range(4))
def test_stride_lengths_are_those_of_the_way(device, seed):
    simulated = walk(device, seed=seed, rate_hz=200.0)
    # A cane has settled a quarter of a second after contact; a shank is measured on the spot.
    later_s = 0.25 if device == "quad-cane" else 0.0
    first = np.append(simulated.stride_start_s[:1], simulated.stride_end_s + later_s)
    rows = np.round(first * simulated.rate_hz).astype(int)
    steps = np.diff(simulated.pos_n[rows, :2], axis=0)
    tolerance_m = 1e-6 if device == "quad-cane" else 0.003
    np.testing.assert_allclose(np.hypot(*steps.T), simulated.stride_length_m, atol=tolerance_m)


@each_device
def test_a_straight_walk_ends_as_far_away_as_the_strides_add_up_to(device):
    simulated = walk(device, 15.0, seed=3)
    away_m = np.hypot(*(simulated.pos_n[-1] - simulated.pos_n[0])[:2])
    assert away_m == pytest.approx(simulated.distance_m, rel=0.01)


@each_device
def test_walks_towards_x_at_the_start(device):
    simulated = walk(device, 4.0, seed=3)
    forward, left, _ = simulated.pos_n[-1] - simulated.pos_n[0]
    assert forward > 3.0
    assert abs(left) < 0.5


@each_device
def test_strides_follow_each_other_within_the_recording(device):
    simulated = walk(device, seed=4, rest_s=2.0)
    np.testing.assert_array_equal(simulated.stride_start_s[1:], simulated.stride_end_s[:-1])
    assert np.all(simulated.stride_end_s > simulated.stride_start_s)
    assert simulated.stride_start_s[0] >= 2.0
    assert simulated.stride_end_s[-1] <= len(simulated.pos_n) / simulated.rate_hz - 2.0


@each_device
@pytest.mark.parametrize("seed", [1, 2])
def test_rests_before_and_after(device, seed):
    simulated = walk(device, 3.0, seed=seed, rest_s=1.5, ideal_sensor=True)
    for ends in (slice(0, 150), slice(-149, None)):
        force = np.linalg.norm(simulated.channels["accel"][ends], axis=1)
        np.testing.assert_allclose(force, GRAVITY_MPS2, atol=1e-4)
        np.testing.assert_allclose(simulated.channels["gyro"][ends], 0.0, atol=1e-4)
        assert np.all(simulated.channels["accel"][ends, 0] > 9.5)


@each_device
def test_one_seed_is_one_walk(device):
    one, same, other = (walk(device, 3.0, seed=seed) for seed in (5, 5, 6))
    for name, values in one.channels.items():
        np.testing.assert_array_equal(values, same.channels[name])
    assert one.distance_m == same.distance_m
    assert one.distance_m != other.distance_m


@each_device
def test_the_sensor_changes_nothing_of_the_walk(device):
    real, ideal = (walk(device, 3.0, seed=5, ideal_sensor=perfect) for perfect in (False, True))
    np.testing.assert_array_equal(real.pos_n, ideal.pos_n)
    np.testing.assert_array_equal(real.q_nb, ideal.q_nb)
    assert np.abs(real.channels["accel"] - ideal.channels["accel"]).max() > 1e-3


@each_device
@pytest.mark.parametrize("rate_hz", [50.0, 200.0])
def test_another_sample_rate_is_the_same_walk(device, rate_hz):
    usual = walk(device, 4.0, seed=2)
    other = walk(device, 4.0, seed=2, rate_hz=rate_hz)
    np.testing.assert_array_equal(usual.stride_length_m, other.stride_length_m)
    np.testing.assert_array_equal(usual.stride_end_s, other.stride_end_s)
    common_s = np.arange(0.0, usual.stride_end_s[-1], 0.02)
    rows, other_rows = ((common_s * hz).round().astype(int) for hz in (100.0, rate_hz))
    np.testing.assert_allclose(usual.pos_n[rows], other.pos_n[other_rows], atol=1e-12)


@each_device
@pytest.mark.parametrize("ideal_sensor", [False, True])
def test_samples_at_half_the_rate_are_pairs_of_samples_noise_included(device, ideal_sensor):
    fine = walk(device, 4.0, seed=2, rate_hz=100.0, ideal_sensor=ideal_sensor)
    coarse = walk(device, 4.0, seed=2, rate_hz=50.0, ideal_sensor=ideal_sensor)
    pairs = 2 * (len(coarse.pos_n) - 1)
    merged = ImuRun(
        0.01, fine.channels["gyro"][1 : pairs + 1], fine.channels["accel"][1 : pairs + 1]
    ).merged(2)
    np.testing.assert_allclose(merged.gyro_b, coarse.channels["gyro"][1:], atol=1e-9)
    np.testing.assert_allclose(merged.accel_b, coarse.channels["accel"][1:], atol=1e-8)


@each_device
def test_an_odd_sample_rate_works_too(device):
    simulated = walk(device, 3.0, seed=2, rate_hz=102.4)
    assert simulated.rate_hz == 102.4
    assert np.all(np.isfinite(simulated.channels["accel"]))


@each_device
def test_an_ordinary_walk_does_not_saturate_the_sensor(device):
    assert not walk(device, seed=1).channels["clip"].any()


@each_device
def test_no_rest_is_possible(device):
    simulated = walk(device, 3.0, seed=1, rest_s=0.0)
    assert simulated.stride_start_s[0] < 0.5


@each_device
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_turning_back_turns_half_round_and_comes_back(device, seed):
    simulated = walk(device, 16.0, seed=seed, turn_back=True, ideal_sensor=True)
    attitude = np.array([matrix_of(q) for q in simulated.q_nb])
    first, last = attitude[0, :2, 2], attitude[-1, :2, 2]
    assert first @ last < -0.9 * np.linalg.norm(first) * np.linalg.norm(last)
    farthest_m = np.linalg.norm(simulated.pos_n - simulated.pos_n[0], axis=1).max()
    assert np.linalg.norm(simulated.pos_n[-1] - simulated.pos_n[0]) < 0.65 * farthest_m
    assert simulated.distance_m == pytest.approx(16.0, abs=LONGEST_STRIDE_M[device])


@each_device
def test_a_walk_too_short_to_turn_turns_all_the_same(device):
    simulated = walk(device, 1.0, seed=1, turn_back=True, ideal_sensor=True)
    attitude = np.array([matrix_of(q) for q in simulated.q_nb[[0, -1]]])
    assert attitude[0, 0, 2] > 0.9
    assert attitude[1, 0, 2] < -0.9


@pytest.mark.parametrize(
    ("device", "speed_mps"),
    [("quad-cane", 0.1), ("quad-cane", 0.5), ("shank", 0.8), ("shank", 1.25), ("shank", 1.7)],
)
def test_keeps_the_planned_speed(device, speed_mps):
    simulated = walk(device, 20.0, seed=2, speed_mps=speed_mps, ideal_sensor=True)
    full = slice(1, -1)
    duration_s = (simulated.stride_end_s - simulated.stride_start_s)[full].sum()
    speed = simulated.stride_length_m[full].sum() / duration_s
    assert speed == pytest.approx(speed_mps, rel=0.05)


@pytest.mark.parametrize(("device", "speed_mps"), [("quad-cane", 3.0), ("shank", 0.1)])
def test_refuses_a_speed_nobody_walks_at(device, speed_mps):
    with pytest.raises(ValueError, match=f"speed_mps {speed_mps}"):
        walk(device, speed_mps=speed_mps)


@pytest.mark.parametrize("seed", range(6))
def test_a_planted_cane_is_still_and_one_in_the_air_is_not(seed):
    simulated = walk("quad-cane", seed=seed, rest_s=1.0, ideal_sensor=True)
    gyro = np.linalg.norm(simulated.channels["gyro"], axis=1)
    force = np.linalg.norm(simulated.channels["accel"], axis=1)
    for start_s, end_s in zip(simulated.stride_start_s, simulated.stride_end_s, strict=True):
        planted = slice(int(100 * (end_s + 0.25)), int(100 * (end_s + 0.45)))
        assert gyro[planted].max() < 0.02
        assert np.abs(force[planted] - GRAVITY_MPS2).max() < 0.12
        np.testing.assert_allclose(np.diff(simulated.pos_n[planted], axis=0), 0.0, atol=1e-9)
        cycle = slice(int(100 * start_s), int(100 * end_s))
        assert gyro[cycle].max() > 0.2
        assert 0.02 < simulated.pos_n[cycle, 2].max() < 0.09


@pytest.mark.parametrize("seed", range(6))
def test_a_cane_is_put_down_hard_enough_to_be_felt(seed):
    simulated = walk("quad-cane", seed=seed, ideal_sensor=True)
    force = np.linalg.norm(simulated.channels["accel"], axis=1)
    for end_s in simulated.stride_end_s:
        shock = force[int(100 * end_s) : int(100 * end_s) + 10]
        assert 12.0 < shock.max() < 100.0


@pytest.mark.parametrize("seed", range(6))
def test_placements_are_of_the_length_and_pace_of_cane_users(seed):
    simulated = walk("quad-cane", 15.0, seed=seed, ideal_sensor=True)
    assert 0.28 < simulated.stride_length_m.mean() < 0.62
    cycles_s = np.diff(simulated.stride_end_s)
    assert 1.3 < cycles_s.mean() < 2.7
    assert cycles_s.std() > 0.01


def sagittal(simulated: SimulatedWalk):
    return simulated.channels["gyro"][:, 1]


@pytest.mark.parametrize("seed", range(6))
def test_a_shank_swings_and_rolls_over_like_that_of_a_person(seed):
    simulated = walk("shank", 15.0, seed=seed, ideal_sensor=True)
    rate = sagittal(simulated)
    full = list(zip(simulated.stride_start_s[1:-1], simulated.stride_end_s[1:-1], strict=True))
    for start_s, end_s in full:
        stride = rate[int(100 * start_s) : int(100 * end_s)]
        assert 4.0 < stride.max() < 9.0
        assert -4.8 < stride.min() < -1.8
        assert 0.3 < -stride[:3].mean() < 1.6
        assert 0.85 < end_s - start_s < 1.6


@pytest.mark.parametrize("seed", range(6))
def test_heel_strike_is_felt_at_the_shank_as_in_people(seed):
    simulated = walk("shank", 15.0, seed=seed, ideal_sensor=True)
    force = np.linalg.norm(simulated.channels["accel"], axis=1)
    assert 1.5 * GRAVITY_MPS2 < force.max() < 4.0 * GRAVITY_MPS2


def test_a_faster_walk_has_longer_and_quicker_strides():
    slow, fast = (walk("shank", 15.0, seed=1, speed_mps=speed) for speed in (0.8, 1.6))
    assert fast.stride_length_m[1:-1].mean() > 1.2 * slow.stride_length_m[1:-1].mean()
    assert np.diff(fast.stride_end_s).mean() < 0.85 * np.diff(slow.stride_end_s).mean()
    assert sagittal(fast).max() > 1.3 * sagittal(slow).max()


def test_the_first_and_last_strides_of_a_shank_are_half_ones():
    lengths_m = walk("shank", 15.0, seed=1).stride_length_m
    usual_m = lengths_m[1:-1].mean()
    assert lengths_m[0] == pytest.approx(0.5 * usual_m, rel=0.15)
    assert lengths_m[-1] == pytest.approx(0.5 * usual_m, rel=0.15)


def test_a_shank_on_level_floor_ends_at_the_height_it_began():
    height_m = walk("shank", seed=1).pos_n[:, 2]
    assert height_m[-1] == pytest.approx(height_m[0], abs=1e-9)
    assert height_m.min() > 0.1


def test_people_differ():
    means = [walk("shank", 10.0, seed=seed, ideal_sensor=True) for seed in range(6)]
    assert np.std([simulated.stride_length_m[1:-1].mean() for simulated in means]) > 0.05


@each_device
def test_a_repetition_is_another_walk_of_the_same_person_with_the_same_sensor(device):
    first = walk(device, 3.0, seed=5, rest_s=5.0)
    again = walk(device, 3.0, seed=5, rest_s=5.0, repetition=1)
    assert not np.array_equal(first.stride_length_m, again.stride_length_m)
    rest = slice(0, 450)
    biases = [walk.channels["gyro"][rest].mean(axis=0) for walk in (first, again)]
    other = walk(device, 3.0, seed=6, rest_s=5.0).channels["gyro"][rest].mean(axis=0)
    assert np.abs(biases[0] - biases[1]).max() < 3e-4
    assert np.abs(biases[0] - other).max() > 1e-3
    assert not np.array_equal(first.channels["gyro"][rest], again.channels["gyro"][rest])
