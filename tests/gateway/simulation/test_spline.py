import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.simulation import Knot, Spline, rest, via

KNOTS = [
    rest(1.0, 0.0, 2.0),
    via(1.4, 0.3, 2.5),
    Knot(1.9, (0.5, 2.0), (0.7, -0.2)),
    Knot(2.1, (0.6, 2.0), (0.0, 0.1), (1.0, -3.0)),
    via(2.6, 0.0, 1.0),
    rest(3.0, 1.0, 1.0),
]


def test_passes_each_knot_with_the_values_rates_and_accelerations_given():
    spline = Spline(KNOTS)
    for knot in KNOTS:
        at = np.array([knot.t_s])
        for order, given_ in enumerate((knot.values, knot.rates, knot.accelerations)):
            if given_ is not None:
                np.testing.assert_allclose(spline(at, order)[0], given_, atol=1e-9)


def test_acceleration_does_not_jump_at_a_knot():
    spline = Spline(KNOTS)
    for knot in KNOTS:
        before, after = spline(np.array([knot.t_s - 1e-9, knot.t_s + 1e-9]), 2)
        np.testing.assert_allclose(before, after, atol=1e-5)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivative_is_that_of_the_order_below(order):
    spline, step_s = Spline(KNOTS), 1e-5
    t_s = np.linspace(1.01, 2.99, 50)
    difference = spline(t_s + step_s, order - 1) - spline(t_s - step_s, order - 1)
    np.testing.assert_allclose(spline(t_s, order), difference / (2 * step_s), rtol=1e-4, atol=1e-3)


def test_rest_to_rest_is_the_minimum_jerk_reach_of_flash_and_hogan():
    u = np.linspace(0.0, 1.0, 11)
    reach = Spline([rest(2.0, 1.0), rest(2.5, 4.0)])(2.0 + 0.5 * u)[:, 0]
    np.testing.assert_allclose(reach, 1.0 + 3.0 * (10 * u**3 - 15 * u**4 + 6 * u**5), atol=1e-12)


def squared_jerk(spline: Spline) -> float:
    middles_s = 1.0 + 2.0 * (np.arange(10000) + 0.5) / 10000
    return float(np.mean(np.sum(spline(middles_s, 3) ** 2, axis=1)) * 2.0)


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 4))
def test_free_rates_and_accelerations_are_those_of_least_jerk(change):
    free = [rest(1.0, 0.0, 0.0), via(1.7, 1.0, -0.5), rest(3.0, 0.5, 0.0)]
    best = Spline(free)
    at = np.array([1.7])
    rates = best(at, 1)[0] + 0.1 * np.array(change[:2])
    accelerations = best(at, 2)[0] + np.array(change[2:])
    other = Spline([free[0], Knot(1.7, (1.0, -0.5), tuple(rates), tuple(accelerations)), free[2]])
    assert squared_jerk(other) >= squared_jerk(best) * (1 - 1e-6)


def test_stays_at_its_ends_outside_the_knots():
    spline = Spline(KNOTS)
    outside = np.array([-5.0, 0.999, 3.001, 9.0])
    np.testing.assert_allclose(spline(outside), [[0, 2], [0, 2], [1, 1], [1, 1]], atol=1e-12)
    np.testing.assert_array_equal(spline(outside, 1), np.zeros((4, 2)))


def test_one_knot_is_a_constant():
    spline = Spline([rest(1.0, 3.0)])
    np.testing.assert_array_equal(spline(np.array([0.0, 2.0])), [[3.0], [3.0]])
    np.testing.assert_array_equal(spline(np.array([0.0, 2.0]), 1), [[0.0], [0.0]])


@pytest.mark.parametrize("last", [via(2.0, 0.0), Knot(2.0, (0.0,), (1.0,), (0.0,))])
def test_refuses_to_end_in_motion(last):
    with pytest.raises(ValueError, match=r"knot at 2\.0 s"):
        Spline([rest(1.0, 0.0), last])


def test_refuses_times_that_do_not_rise():
    with pytest.raises(ValueError, match="rise"):
        Spline([rest(1.0, 0.0), rest(1.0, 1.0)])
