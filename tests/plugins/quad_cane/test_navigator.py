import numpy as np
import pytest

from gaitway.estimation import ImuBlock, ImuSample
from gaitway_plugins.quad_cane.navigator import Navigator
from gaitway_plugins.quad_cane.params import QuadCaneParams

STILL = ImuSample(0, (0.3, -0.2, 9.8), (0.01, 0.0, -0.01), clipped=False, bridged=False)


def move(navigator, *samples):
    times, accels, gyros, clipped, bridged = (
        np.array(column) for column in zip(*samples, strict=True)
    )
    block = ImuBlock(times, accels, gyros, clipped, bridged)
    navigator.move(block, np.empty((len(samples), 10)))
    return block


@pytest.fixture
def navigator():
    navigator = Navigator(QuadCaneParams(), 0.01)
    for _ in range(50):
        navigator.seek(STILL)
    assert navigator.aligned
    return navigator


def test_biases_that_can_be_none_are_found_anew(navigator):
    navigator._kf.accel_bias_d[:] = (0.0, 0.6, 0.0)
    navigator.lose()
    for _ in range(25):
        navigator.seek(STILL)
    assert navigator.aligned
    assert navigator._kf.accel_bias_d == pytest.approx(np.zeros(3), abs=0.05)


def test_biases_that_can_be_some_are_kept(navigator):
    navigator._kf.accel_bias_d[:] = (0.02, 0.03, 0.0)
    navigator.lose()
    for _ in range(25):
        navigator.seek(STILL)
    assert navigator._kf.accel_bias_d[:2] == pytest.approx([0.02, 0.03], abs=0.01)


def test_losing_the_way_again_and_again_leaves_the_doubt_about_biases_bounded(navigator):
    for _ in range(100):
        navigator.lose()
    sigma = np.sqrt(navigator._kf.covariance.diagonal()[9:])
    assert sigma[:3] == pytest.approx(np.full(3, 5e-3))
    assert sigma[3:] == pytest.approx(np.full(3, 0.05))


def test_a_landing_that_is_taken_back_leaves_no_trace(navigator):
    reference = Navigator(QuadCaneParams(), 0.01)
    for _ in range(50):
        reference.seek(STILL)
    later = [STILL._replace(accel_d=(0.4, -0.2, 9.7)), STILL]
    for each in (navigator, reference):
        move(each, STILL)
    assert navigator.stand(STILL, landing=True)
    move(reference, *later)
    navigator.unland([move(navigator, *later)])
    assert np.array_equal(navigator._kf.nominal, reference._kf.nominal)
    assert np.array_equal(navigator._kf.covariance, reference._kf.covariance)
    assert navigator.displacement() == reference.displacement()
