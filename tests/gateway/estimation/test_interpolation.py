import pytest

from gaitway.estimation import StrideInterpolation

S = 1_000_000_000


def learnt(*strides):
    interpolation = StrideInterpolation()
    for cycle_s, length_m in strides:
        interpolation.learn(cycle_s, length_m)
    return interpolation


@pytest.mark.parametrize(("gap_s", "count"), [(2.0, 1), (2.5, 1), (4.2, 2), (6.0, 3)])
def test_a_gap_of_whole_cycles_hid_as_many_strides(gap_s, count):
    lost = learnt((2.0, 0.4), (2.0, 0.5)).between(7 * S, 7 * S + round(gap_s * S))
    assert len(lost.bounds_ns) == count + 1
    assert (lost.bounds_ns[0], lost.bounds_ns[-1]) == (7 * S, 7 * S + round(gap_s * S))
    assert lost.length_m == pytest.approx(0.45)
    assert lost.sigma_m > 0.15 * 0.45


@pytest.mark.parametrize("gap_s", [0.2, 1.2, 3.0, 8.0])
def test_what_is_no_few_cycles_is_not_made_up(gap_s):
    assert learnt((2.0, 0.4), (2.0, 0.5)).between(0, round(gap_s * S)) is None


def test_one_stride_says_nothing_of_others():
    assert learnt((2.0, 0.4)).between(0, 2 * S) is None


def test_what_was_learnt_is_forgotten_with_the_walk():
    interpolation = learnt((2.0, 0.4), (2.0, 0.5))
    interpolation.forget()
    assert interpolation.between(0, 2 * S) is None
