import numpy as np
import pytest

from gaitway.offline.plausibility import _turned, accel_complaint, gyro_complaint


def test_a_direction_of_the_world_turns_against_the_sensor():
    rows = np.tile([0.0, 0.0, 1.0], (101, 1))
    turned = _turned(np.array([[1.0, 0.0, 0.0]]), rows, np.array([0]), 100, 0.01)
    assert turned[0].tolist() == pytest.approx([np.cos(1.0), -np.sin(1.0), 0.0])


@pytest.mark.parametrize("rate_hz", [25.0, 100.0, 400.0])
def test_degrees_are_told_at_any_sample_rate(walk, rate_hz):
    t_s, accel, gyro = walk(rate_hz=rate_hz, n=round(10 * rate_hz))
    index, period_s = np.arange(len(t_s)), 1 / rate_hz
    assert gyro_complaint(gyro, accel, index, period_s) is None
    assert "degrees" in gyro_complaint(np.degrees(gyro), accel, index, period_s)


def test_a_sensor_at_rest_gives_no_reason_to_complain(walk):
    t_s, accel, gyro = walk(amplitude_rad=0.0)
    assert gyro_complaint(gyro, accel, np.arange(len(t_s)), 0.01) is None
    assert accel_complaint(accel) is None


def test_turns_across_gaps_are_not_judged(walk):
    """Samples of every second row, told to lie far apart: no turn is whole."""
    t_s, accel, gyro = walk()
    slow = np.degrees(gyro) / 4
    assert np.linalg.norm(slow, axis=1).max() < 40
    far = np.arange(len(t_s)) * 100
    assert gyro_complaint(slow, accel, far, 0.01) is None
