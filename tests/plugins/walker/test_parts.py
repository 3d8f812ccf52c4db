"""The parts of the walker's estimator, each by itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.estimation import ErrorStateFilter
from gaitway.estimation.rotation import from_rotation_vector, multiply
from gaitway_plugins.walker import updates
from gaitway_plugins.walker.ticks import increments
from gaitway_plugins.walker.valleys import Valleys

ARM = np.array([-0.1, 0.05, 0.8])


@given(
    steps=st.lists(st.integers(-20, 40), min_size=1, max_size=50),
    first=st.integers(0, 2**16 - 1),
    bits=st.sampled_from([8, 12, 16, 32]),
)
def test_counters_that_wrap_lose_nothing(steps, first, bits):
    counts = np.mod(first + np.cumsum([0, *steps]), 2**bits).astype(float)
    told, restarts = increments(counts, np.full(len(steps), 100.0))
    assert told.tolist() == [float(step) for step in steps]
    assert restarts == 0


def test_a_counter_that_begins_anew_adds_nothing():
    told, restarts = increments(np.array([70000.0, 70010.0, 0.0, 5.0]), np.full(3, 100.0))
    assert told.tolist() == [10.0, 0.0, 5.0]
    assert restarts == 1


def test_valleys_are_found_where_the_signal_is_lowest():
    t = np.arange(60) / 10.0
    valleys = Valleys(0.08, 0.02)
    found = [valleys.push(v) for v in 0.6 * (1 - 0.2 * np.cos(2 * np.pi * t))]
    assert [at - v for at, v in enumerate(found) if v is not None] == [10, 20, 30, 40, 50]


def test_a_ripple_is_no_valley():
    valleys = Valleys(0.08, 0.02)
    assert not any(valleys.push(0.6 + 0.02 * (-1) ** k) for k in range(50))


def filter_at(rng):
    kf = ErrorStateFilter()
    kf.q_nd = from_rotation_vector(rng.normal(0, 0.3, 3).tolist())
    kf.pos_n[:], kf.vel_n[:] = rng.normal(0, 1, 3), rng.normal(0, 1, 3)
    kf.gyro_bias_d[:] = rng.normal(0, 0.01, 3)
    return kf


RATE = np.array([0.2, -0.4, 0.7])
MEASUREMENTS = {
    "rolling": lambda kf: updates.rolling_velocity(kf, kf.vel_n, RATE, -ARM, 0.5, 0.03),
    "yaw": lambda kf: updates.yaw_rate(kf, RATE, 0.3, 0.05),
    "vertical": lambda kf: updates.vertical(kf, np.array([0.05, -0.02, 0.998]), 0.02),
    "heading": lambda kf: updates.heading(kf, 0.4, 0.01),
    "position": lambda kf: updates.position(kf, np.array([1.0, 2.0, 3.0]), 0.01),
    "height": lambda kf: updates.height(kf, ARM, 0.0, 0.02),
}


@pytest.mark.parametrize("name", MEASUREMENTS)
@pytest.mark.parametrize("seed", range(3))
def test_what_the_filter_is_told_has_the_jacobian_of_its_differences(name, seed):
    """Moving an error into the nominal state takes H times it out of z."""
    kf = filter_at(np.random.default_rng(seed))
    if name == "heading":
        kf.q_nd = from_rotation_vector((0.0, 0.0, 0.3))
    z, H, _ = MEASUREMENTS[name](kf)
    nominal = kf.nominal.copy()
    for state in range(12):
        error = np.zeros(15)
        error[state] = 1e-5
        kf.nominal[:] = nominal
        kf.nominal[:6] += error[:6]
        kf.q_nd = multiply(from_rotation_vector(error[6:9].tolist()), kf.q_nd)
        kf.nominal[10:] += error[9:]
        moved = MEASUREMENTS[name](kf).z
        np.testing.assert_allclose((z - moved) / 1e-5, H[:, state], atol=2e-4)
