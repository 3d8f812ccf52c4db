import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from gaitway.offline.time_grid import GridError, find_grid

RATES_HZ = [10.0, 25.0, 50.0, 59.5, 100.0, 102.4, 128.0, 200.0, 204.8, 512.0, 1000.0, 2000.0]


def index_of(gaps, run_lengths):
    """Grid numbers of runs of samples with gaps of a given number of samples between them."""
    steps = [np.ones(length, dtype=int) for length in run_lengths]
    for step, gap in zip(steps[1:], gaps, strict=False):
        step[0] += gap
    index = np.cumsum(np.concatenate(steps))
    return index - index[0]


@st.composite
def indices(draw, max_gap, first_run=8):
    """At least twice as many samples as runs, so that most differences are one period."""
    runs = draw(st.lists(st.integers(1, 60), min_size=1, max_size=12))
    gaps = draw(st.lists(st.integers(1, max_gap), min_size=len(runs), max_size=len(runs)))
    return index_of(gaps, [4 * len(runs) + first_run, *runs])


@given(indices(max_gap=5000), st.sampled_from(RATES_HZ), st.floats(0, 2e9))
def test_random_gaps_are_counted_exactly(index, rate_hz, start_s):
    grid = find_grid(start_s + index / rate_hz)
    assert grid.index.tolist() == index.tolist()
    assert grid.period_s == pytest.approx(1 / rate_hz, rel=1e-3)


@given(indices(max_gap=20), st.sampled_from(RATES_HZ), st.integers(3, 6))
@example(index_of([3, 20], [60, 60, 60]), 204.8, 4)
@example(index_of([3, 20], [60, 60, 60]), 204.8, 3)
def test_stamps_rounded_to_a_few_decimals_count_the_same(index, rate_hz, decimals):
    assume(10**-decimals <= 0.2 / rate_hz)
    assert find_grid(np.round(index / rate_hz, decimals)).index.tolist() == index.tolist()


@given(indices(max_gap=200, first_run=200), st.integers(0, 2**32 - 1))
def test_jitter_of_a_tenth_of_a_period_changes_no_count(index, seed):
    jitter_s = np.random.default_rng(seed).uniform(-0.1, 0.1, len(index)) / 100.0
    assert find_grid(index / 100.0 + jitter_s).index.tolist() == index.tolist()


def test_the_period_is_refined_far_beyond_the_rounding_of_the_stamps():
    t_s = np.round(np.arange(20_000) / 204.8, 4)
    assert find_grid(t_s).period_s == pytest.approx(1 / 204.8, rel=1e-7)


@pytest.mark.parametrize("drift", [-200e-6, 200e-6])
def test_a_clock_that_drifts_over_an_hour_is_no_fault(drift):
    """Twenty periods of drift at the end, against one straight line."""
    t_s = np.arange(360_000) / 100.0
    drifting_s = t_s + drift * (t_s - t_s.mean()) ** 2 / 3600.0 * 4
    assert find_grid(drifting_s).index.tolist() == list(range(360_000))


def test_two_rows_are_a_grid():
    grid = find_grid(np.array([0.5, 0.51]))
    assert (grid.index.tolist(), grid.period_s) == ([0, 1], pytest.approx(0.01))


def complaint(t_s):
    with pytest.raises(GridError) as caught:
        find_grid(np.asarray(t_s, dtype=np.float64))
    return caught.value.row, str(caught.value)


def test_time_that_stands_still_is_told_with_its_row():
    row, text = complaint([0.0, 0.01, 0.02, 0.02, 0.03])
    assert row == 3
    assert "stands still" in text


def test_time_that_goes_back_is_told_with_its_row():
    row, text = complaint([0.0, 0.01, 0.02, 0.005, 0.03])
    assert row == 3
    assert "goes back by 0.015 s" in text
    assert "sort the rows" in text


@pytest.mark.parametrize("rate_hz", [10.0, 100.0, 204.8, 2000.0])
@pytest.mark.parametrize(
    ("unit", "factor", "remedy"),
    [("milliseconds", 1e3, "0.001"), ("microseconds", 1e6, "1e-06"), ("nanoseconds", 1e9, "1e-09")],
)
def test_time_in_another_unit_is_named(rate_hz, unit, factor, remedy):
    row, text = complaint(np.arange(50) / rate_hz * factor)
    assert row is None
    assert f"t_s looks like {unit}" in text
    assert f"multiply it by {remedy}" in text


@pytest.mark.parametrize("rate_hz", [5.0, 2500.0, 1e-3])
def test_a_rate_that_no_walk_is_recorded_at_is_refused(rate_hz):
    row, text = complaint(np.arange(50) / rate_hz)
    assert row is None
    assert "Hz" in text


@pytest.mark.parametrize("off", [0.3, -0.3, 0.45])
def test_a_row_off_the_grid_is_told_with_its_row(off):
    t_s = np.arange(300) / 100.0
    t_s[123] += off / 100.0
    row, text = complaint(t_s)
    assert row == 123
    assert "off the sample grid" in text


@pytest.mark.parametrize("off", [0.2, -0.2])
def test_a_row_a_fifth_of_a_period_off_is_on_the_grid(off):
    t_s = np.arange(300) / 100.0
    t_s[123] += off / 100.0
    assert find_grid(t_s).index.tolist() == list(range(300))


def test_a_rate_that_changes_within_the_file_is_told():
    t_s = np.concatenate([np.arange(200) / 100.0, 2.0 + np.arange(100) / 125.0])
    row, text = complaint(t_s)
    assert "sample rate changes" in text
    assert row is not None


def test_a_grid_that_shifts_by_half_a_period_in_a_gap_is_told():
    """How many samples are missing, one or two, nobody can tell."""
    t_s = np.concatenate([np.arange(100), np.arange(100) + 101.5]) / 100.0
    row, text = complaint(t_s)
    assert row == 100
    assert "can't be told" in text


@pytest.mark.parametrize(("before", "after"), [(0.2, -0.2), (-0.2, 0.2)])
def test_rows_a_fifth_off_at_both_edges_of_a_gap_change_no_count(before, after):
    index = np.concatenate([np.arange(100), np.arange(100) + 107])
    t_s = index / 100.0
    t_s[99] += before / 100.0
    t_s[100] += after / 100.0
    assert find_grid(t_s).index.tolist() == index.tolist()


def test_random_times_are_no_grid():
    complaint(np.cumsum(np.random.default_rng(0).exponential(0.01, 500)))
