import pytest

from gaitway.estimation import StanceDetector

STILL = ((0.0, 0.0, 9.8), (0.01, 0.0, 0.0))
PUSHED = ((0.0, 0.0, 10.3), (0.01, 0.0, 0.0))
TURNED = ((0.0, 0.0, 9.8), (0.0, 0.3, 0.3))


def detector(period_s=0.01):
    return StanceDetector(period_s, window_s=0.15, accel_max_mps2=0.3, gyro_max_radps=0.4)


@pytest.mark.parametrize("moving", [PUSHED, TURNED])
def test_stance_keeps_half_a_window_from_any_movement(moving):
    stance = detector()
    samples = [STILL] * 20 + [moving] + [STILL] * 20
    answers = [stance.push(*sample) for sample in samples][stance.half :]
    assert stance.half == 7
    assert [k for k, standing in enumerate(answers) if standing] == [*range(7, 13), *range(28, 34)]


def test_neither_attitude_nor_mounting_matters():
    upside_down = ((9.8 * 0.6, 0.0, -9.8 * 0.8), (0.0, -0.01, 0.0))
    stance = detector()
    assert [stance.push(*upside_down) for _ in range(15)][-1]


def test_free_fall_and_double_weight_are_no_stance():
    for force in (0.0, 19.6):
        stance = detector()
        assert not any(stance.push((force, 0.0, 0.0), (0.0, 0.0, 0.0)) for _ in range(30))


@pytest.mark.parametrize("rate_hz", [50, 100, 200, 400])
def test_the_window_lasts_as_long_at_any_rate(rate_hz):
    stance = detector(1.0 / rate_hz)
    moving_s = [0.3, 0.6]
    samples = [STILL] * rate_hz
    for at_s in moving_s:
        samples[round(at_s * rate_hz)] = PUSHED
    standing = [stance.push(*sample) for sample in samples][stance.half :]
    between = [k / rate_hz for k, it in enumerate(standing) if it and 0.3 < k / rate_hz < 0.6]
    assert min(between) == pytest.approx(0.3 + 0.075, abs=1.5 / rate_hz)
    assert max(between) == pytest.approx(0.6 - 0.075, abs=1.5 / rate_hz)
