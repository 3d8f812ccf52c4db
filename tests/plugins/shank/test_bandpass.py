"""The streaming band-pass against what its formulas promise."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.estimation.bandpass import BandPass, Cascade, butterworth


def gain(sections, frequency_hz, rate_hz):
    omega = 2 * math.pi * frequency_hz / rate_hz
    return abs(math.prod(section.response(omega) for section in sections))


def paper_filter(rate_hz):
    return BandPass(rate_hz, high_stop_hz=0.2, high_pass_hz=0.5, low_pass_hz=10.0, low_stop_hz=20.0)


@given(
    kind=st.sampled_from(["low", "high"]),
    order=st.sampled_from([2, 4, 6]),
    corner_hz=st.floats(0.05, 40.0),
    frequency_hz=st.floats(0.01, 49.0),
)
def test_the_response_is_butterworth_s(kind, order, corner_hz, frequency_hz):
    warped = math.tan(math.pi * frequency_hz / 100.0) / math.tan(math.pi * corner_hz / 100.0)
    ratio = warped if kind == "low" else 1.0 / warped
    expected = 1.0 / math.sqrt(1.0 + ratio ** (2 * order))
    sections = butterworth(kind, order, corner_hz, 100.0)
    assert gain(sections, frequency_hz, 100.0) == pytest.approx(expected, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 200.0])
def test_the_paper_s_edges_hold(rate_hz):
    sections = paper_filter(rate_hz)._sections
    assert gain(sections, 0.5, rate_hz) > 0.95
    assert gain(sections, 10.0, rate_hz) > 0.93
    assert gain(sections, 0.2, rate_hz) < 0.2
    assert gain(sections, 20.0, rate_hz) < 0.25


@pytest.mark.parametrize("frequency_hz", [1.0, 5.0])
def test_a_sine_comes_out_later_by_the_phase_of_the_response(frequency_hz):
    t = np.arange(0.0, 30.0, 0.01)
    out = paper_filter(100.0).filter(np.sin(2 * np.pi * frequency_hz * t))
    omega = 2 * math.pi * frequency_hz / 100.0
    response = math.prod(s.response(omega) for s in paper_filter(100.0)._sections)
    expected = np.imag(response * np.exp(2j * np.pi * frequency_hz * t))
    assert out[2500:] == pytest.approx(expected[2500:].tolist(), abs=1e-6)


def test_the_delay_is_that_of_a_slowly_modulated_tone():
    t = np.arange(0.0, 40.0, 0.01)
    envelope = np.exp(-(((t - 20.0) / 3.0) ** 2))
    out = np.array(paper_filter(100.0).filter(envelope * np.sin(2 * np.pi * 5.0 * t)))
    delay_s = (out**2 @ t) / (out**2).sum() - 20.0
    assert delay_s == pytest.approx(paper_filter(100.0).delay_s(5.0), abs=1e-3)
    assert delay_s > 0.02


def test_a_constant_leaves_no_trace_from_the_first_sample_on():
    assert paper_filter(100.0).filter([9.81] * 50) == pytest.approx([0.0] * 50, abs=1e-9)
    low = Cascade(butterworth("low", 4, 5.0, 100.0))
    assert low.filter([9.81] * 50) == pytest.approx([9.81] * 50)


@given(st.lists(st.integers(1, 299), max_size=5, unique=True))
def test_where_the_stream_is_cut_changes_nothing(cuts):
    values = np.random.default_rng(5).standard_normal(300)
    parts = paper_filter(100.0)
    pieces = [x for part in np.split(values, sorted(cuts)) for x in parts.filter(part)]
    assert pieces == paper_filter(100.0).filter(values)


@pytest.mark.parametrize(("order", "corner_hz"), [(3, 5.0), (0, 5.0), (4, 50.0), (4, 0.0)])
def test_an_impossible_filter_is_refused(order, corner_hz):
    with pytest.raises(ValueError, match=r"order|corner"):
        butterworth("low", order, corner_hz, 100.0)
