from dataclasses import replace

import numpy as np
import pytest

from gaitway.simulation import GRAVITY_MPS2, ImuModel, ImuRun, Triad
from gaitway.simulation.imu_model import sensed

PERFECT = Triad(0.0, 0.0, 0.0, 0.0, 0.0, full_scale=100.0, resolution=1e-9)
PERIOD_S = 1.0 / 400.0


def still(n, accel=(0.0, 0.0, GRAVITY_MPS2), gyro=(0.0, 0.0, 0.0)):
    return ImuRun(PERIOD_S, np.tile(gyro, (n, 1)), np.tile(accel, (n, 1)))


def rng(seed=0):
    return np.random.default_rng(seed)


@pytest.mark.parametrize("count", [2, 4, 8])
def test_white_noise_has_the_density_at_every_sample_rate(count):
    noisy = replace(PERFECT, noise_rthz=0.01)
    run, _ = sensed(still(40000), count, ImuModel(gyro=noisy, accel=noisy), rng())
    expected = 0.01 / np.sqrt(count * PERIOD_S)
    np.testing.assert_allclose(run.accel_b.std(axis=0), expected, rtol=0.05)
    np.testing.assert_allclose(run.gyro_b.std(axis=0), expected, rtol=0.05)


def test_noise_of_one_sample_tells_nothing_of_the_next():
    noisy = replace(PERFECT, noise_rthz=0.01)
    run, _ = sensed(still(20000), 1, ImuModel(gyro=noisy, accel=noisy), rng())
    noise = run.accel_b - run.accel_b.mean(axis=0)
    neighbours = np.mean(noise[1:] * noise[:-1], axis=0) / np.mean(noise**2, axis=0)
    assert np.abs(neighbours).max() < 0.03


def test_turn_on_bias_differs_from_sensor_to_sensor_as_told():
    model = ImuModel(gyro=replace(PERFECT, bias=0.02), accel=replace(PERFECT, bias=0.5))
    runs = [sensed(still(1), 1, model, rng(seed))[0] for seed in range(300)]
    gyro = np.concatenate([run.gyro_b[0] for run in runs])
    accel = np.concatenate([run.accel_b[0] - [0, 0, GRAVITY_MPS2] for run in runs])
    assert gyro.std() == pytest.approx(0.02, rel=0.1)
    assert accel.std() == pytest.approx(0.5, rel=0.1)


def test_bias_walks_with_the_square_root_of_time():
    model = ImuModel(gyro=replace(PERFECT, bias_walk_rts=0.03), accel=PERFECT)
    n = 400
    ends = [sensed(still(n), 1, model, rng(seed))[0].gyro_b[-1] for seed in range(300)]
    assert np.concatenate(ends).std() == pytest.approx(0.03 * np.sqrt(n * PERIOD_S), rel=0.1)


def test_scale_error_grows_with_what_is_measured():
    model = ImuModel(gyro=replace(PERFECT, scale=0.1), accel=PERFECT)
    slow, _ = sensed(still(1, gyro=(1.0, 0.0, 0.0)), 1, model, rng())
    fast, _ = sensed(still(1, gyro=(10.0, 0.0, 0.0)), 1, model, rng())
    error = slow.gyro_b[0, 0] - 1.0
    assert abs(error) > 1e-4
    assert fast.gyro_b[0, 0] - 10.0 == pytest.approx(10.0 * error, rel=1e-6)


def test_misalignment_shows_a_rotation_on_the_other_axes_only():
    model = ImuModel(gyro=replace(PERFECT, misalignment_rad=0.01), accel=PERFECT)
    run, _ = sensed(still(1, gyro=(10.0, 0.0, 0.0)), 1, model, rng())
    assert run.gyro_b[0, 0] == pytest.approx(10.0, abs=1e-6)
    assert np.all(np.abs(run.gyro_b[0, 1:]) > 1e-4)
    assert np.all(np.abs(run.gyro_b[0, 1:]) < 0.4)


@pytest.mark.parametrize(
    ("accel", "gyro", "flags"),
    [
        ((11.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1),
        ((0.0, -11.0, 0.0), (0.0, 0.0, 0.0), 2),
        ((0.0, 0.0, 11.0), (6.0, 0.0, 0.0), 4 + 8),
        ((0.0, 0.0, 0.0), (0.0, 6.0, -6.0), 16 + 32),
        ((9.9, 0.0, 0.0), (4.9, 0.0, 0.0), 0),
    ],
)
def test_what_exceeds_the_full_scale_is_flagged(accel, gyro, flags):
    model = ImuModel(gyro=replace(PERFECT, full_scale=5.0), accel=replace(PERFECT, full_scale=10.0))
    _, clip = sensed(still(3, accel, gyro), 1, model, rng())
    np.testing.assert_array_equal(clip, np.full((3, 1), flags))


def test_what_exceeds_the_full_scale_reads_full_scale():
    model = ImuModel(gyro=PERFECT, accel=replace(PERFECT, full_scale=10.0))
    run, _ = sensed(still(2, accel=(-15.0, 12.0, 3.0)), 1, model, rng())
    np.testing.assert_allclose(run.accel_b, np.tile([-10.0, 10.0, 3.0], (2, 1)), atol=1e-6)


def test_a_peak_shorter_than_a_sample_is_cut_and_flagged():
    model = ImuModel(gyro=PERFECT, accel=replace(PERFECT, full_scale=10.0))
    accel = np.zeros((4, 3))
    accel[1, 0] = 30.0
    run, clip = sensed(ImuRun(PERIOD_S, np.zeros((4, 3)), accel), 4, model, rng())
    assert clip[0, 0] == 1
    assert run.accel_b[0, 0] == pytest.approx(2.5, abs=1e-6)


def test_readings_are_steps_of_the_converter():
    model = ImuModel(gyro=PERFECT, accel=replace(PERFECT, noise_rthz=0.01, resolution=0.25))
    run, _ = sensed(still(100), 1, model, rng())
    steps = run.accel_b / 0.25
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert len(np.unique(np.round(steps))) > 2


def test_default_is_of_the_class_its_data_sheet_says():
    model = ImuModel()
    assert np.degrees(model.gyro.full_scale) == pytest.approx(2000.0)
    assert model.accel.full_scale == pytest.approx(16.0 * GRAVITY_MPS2)
    assert np.degrees(model.gyro.noise_rthz) == pytest.approx(0.007)
    assert model.accel.noise_rthz == pytest.approx(120e-6 * GRAVITY_MPS2)
