import numpy as np
import pytest

from gaitway.estimation import ATT, POS, VEL, ErrorStateFilter, ImuNoise

NOISE = ImuNoise(0.02, 3e-3, 1e-3, 1e-4)


@pytest.mark.parametrize("states", [9, 15])
def test_noise_over_a_second_is_the_same_at_any_rate(states):
    """At rest and level, where the transition itself is exact enough to compare to 2 %."""

    def after_a_second(rate_hz):
        kf = ErrorStateFilter(states=states)
        for _ in range(rate_hz):
            kf.predict((0.0, 0.0, 9.80665), (0.0, 0.0, 0.0), 1.0 / rate_hz, NOISE)
        return np.sqrt(kf.covariance.diagonal())

    assert after_a_second(50) == pytest.approx(after_a_second(400), rel=0.03)


def test_a_second_of_white_noise_is_its_density():
    kf = ErrorStateFilter(states=9)
    noise = ImuNoise(0.02, 0.0)
    for _ in range(100):
        kf.predict((0.0, 0.0, 9.80665), (0.0, 0.0, 0.0), 0.01, noise)
    sigma = np.sqrt(kf.covariance.diagonal())
    assert sigma[VEL] == pytest.approx(0.02)
    assert sigma[POS] == pytest.approx(0.02 / np.sqrt(3.0))
    assert not sigma[ATT].any()


def test_scaling_leaves_the_walks_of_the_biases_alone():
    plain, loud = (n.process_covariance(0.01, 15) for n in (NOISE, NOISE.scaled(3.0)))
    assert loud[:9, :9] == pytest.approx(9.0 * plain[:9, :9])
    assert np.array_equal(loud[9:, 9:], plain[9:, 9:])
