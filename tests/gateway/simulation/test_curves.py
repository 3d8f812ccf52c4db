import numpy as np
import pytest

from gaitway.simulation import Constant, Shocks, Spline, Stacked, Sum, Tremor, rest

T_S = np.linspace(0.0, 3.0, 3001)
SHOCKS = Shocks(
    np.array([0.5, 1.5]), np.array([[1e-3, -2e-3], [4e-3, 0.0]]), frequency_hz=30.0, decay_s=0.005
)
ENVELOPE = Spline([rest(0.5, 0.0), rest(1.0, 1.0), rest(2.0, 1.0), rest(2.5, 0.0)])
TREMOR = Tremor(ENVELOPE, np.array([[1.0, 2.0], [0.5, 0.0]]), [6.0, 9.0], np.zeros((2, 2)))
CURVES = {
    "shocks": SHOCKS,
    "tremor": TREMOR,
    "sum": Sum(SHOCKS, TREMOR, Constant(1.0, 2.0)),
    "stacked": Stacked(SHOCKS, Constant(5.0), TREMOR),
}


@pytest.mark.parametrize("name", CURVES)
def test_rate_is_the_derivative_of_the_value(name):
    curve, step_s = CURVES[name], 1e-6
    difference = (curve(T_S + step_s) - curve(T_S - step_s)) / (2 * step_s)
    np.testing.assert_allclose(curve(T_S, 1), difference, rtol=1e-5, atol=1e-5)


def test_a_shock_is_at_rest_before_contact_and_long_after():
    quiet = (T_S < 0.5) | ((T_S > 0.75) & (T_S < 1.5)) | (T_S > 1.75)
    assert np.abs(SHOCKS(T_S)[quiet]).max() == 0.0
    assert np.abs(SHOCKS(T_S, 1)[quiet]).max() == 0.0


def test_a_shock_comes_near_its_peak_and_never_beyond():
    reached = np.abs(SHOCKS(np.linspace(0.4, 0.8, 40001))).max(axis=0)
    assert np.all(reached <= [1e-3, 2e-3])
    assert np.all(reached >= [0.75e-3, 1.5e-3])


def test_what_a_shock_leaves_when_it_is_cut_off_is_nothing():
    last = SHOCKS(np.array([0.5 + 39.9 * 0.005]))
    assert np.abs(last).max() < 1e-15


def test_shocks_that_overlap_add_up():
    both = Shocks(np.array([0.5, 0.51]), np.array([[1.0], [2.0]]), 30.0, 0.005)
    one = Shocks(np.array([0.5]), np.array([[1.0]]), 30.0, 0.005)
    other = Shocks(np.array([0.51]), np.array([[2.0]]), 30.0, 0.005)
    np.testing.assert_allclose(both(T_S), one(T_S) + other(T_S), atol=1e-15)


def test_tremor_keeps_below_its_envelope():
    envelope = ENVELOPE(T_S)
    assert np.all(np.abs(TREMOR(T_S)) <= envelope * [1.5, 2.0] + 1e-12)
    assert np.abs(TREMOR(T_S)).max() > 1.5


def test_stacked_keeps_the_order_of_columns():
    np.testing.assert_array_equal(
        Stacked(Constant(1.0, 2.0), Constant(3.0))(np.zeros(2)), [[1, 2, 3], [1, 2, 3]]
    )
