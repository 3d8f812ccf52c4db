import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.estimation import CentredHold, CentredMean, half_window


@given(st.lists(st.floats(-1e3, 1e3), max_size=40), st.integers(0, 6))
def test_centred_means_are_those_of_the_slices(values, half):
    running = CentredMean(half)
    means = [mean for mean in map(running.push, values) if mean is not None]
    means += running.finish()
    expected = [np.mean(values[max(0, k - half) : k + half + 1]) for k in range(len(values))]
    assert means == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("half", [3, 100])
def test_a_mean_answers_half_a_window_later(half):
    running = CentredMean(half)
    answers = [running.push(1.0) for _ in range(half + 1)]
    assert answers == [None] * half + [1.0]


def test_a_running_mean_forgets_what_left_its_window():
    running = CentredMean(2)
    for _ in range(1000):
        running.push(1e5)  # the greatest reading that a bridge lets pass
    for value in (1.0, 2.0, 3.0, 4.0, 5.0, 1.0, 2.0, 3.0, 4.0, 5.0):
        mean = running.push(value)
    assert mean == pytest.approx(3.0, abs=1e-6)


def test_a_running_mean_is_as_exact_after_a_day():
    running = CentredMean(2)
    running.extend(np.full(8_640_000, 0.1))
    assert [running.push(value) for value in (1.0, 2.0, 3.0, 4.0, 5.0)][-1] == pytest.approx(
        3.0, abs=1e-11
    )


@given(
    st.lists(st.floats(-1e3, 1e3), max_size=60),
    st.integers(0, 6),
    st.lists(st.integers(0, 60), max_size=3),
)
def test_many_at_once_are_the_same_to_the_last_bit(values, half, cuts):
    one, many = CentredMean(half), CentredMean(half)
    expected = [mean for mean in map(one.push, values) if mean is not None]
    parts = np.split(np.array(values, float), sorted(min(cut, len(values)) for cut in cuts))
    assert np.concatenate([many.extend(part) for part in parts]).tolist() == expected
    assert many.finish() == one.finish()


@given(st.lists(st.booleans(), max_size=60), st.integers(0, 5), st.integers(0, 60))
def test_many_conditions_at_once_hold_as_one_by_one(conditions, half, cut):
    one, many = CentredHold(half), CentredHold(half)
    parts = (np.array(conditions[:cut], bool), np.array(conditions[cut:], bool))
    answers = [answer for part in parts for answer in many.extend(part).tolist()]
    assert answers == [one.push(condition) for condition in conditions]


@given(st.lists(st.booleans(), max_size=40), st.integers(0, 5))
def test_a_condition_holds_where_it_holds_all_around(conditions, half):
    hold = CentredHold(half)
    answers = [hold.push(condition) for condition in conditions][half:]
    expected = [
        k >= half and all(conditions[k - half : k + half + 1])
        for k in range(len(conditions) - half)
    ]
    assert answers == expected


@pytest.mark.parametrize(
    ("window_s", "rate_hz", "half"),
    [
        (0.15, 100, 7),
        (0.15, 200, 15),
        (0.15, 50, 3),
        (2.0, 100, 100),
        (2.0, 102.4, 102),
        (0.6, 10, 3),
    ],
)
def test_half_a_window_is_never_longer_than_half_of_it(window_s, rate_hz, half):
    assert half_window(window_s, 1.0 / rate_hz) == half
