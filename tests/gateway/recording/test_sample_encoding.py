import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from gaitway.recording.sample_encoding import decode_samples, encode_samples
from gaitway.samples import CHANNELS, SampleBatch

WIDTHS = {channel.name: len(channel.columns) for channel in CHANNELS} | {"acme_pressure": 2}


@st.composite
def batches(draw, elements):
    n = draw(st.integers(1, 4))
    names = draw(st.lists(st.sampled_from(sorted(WIDTHS)), unique=True, max_size=4))
    return SampleBatch(
        t_ns=draw(st.integers(0, 2**62)) + np.arange(n) * 10_000_000,
        period_s=draw(st.floats(1e-4, 1.0)),
        sequence=draw(st.integers(0, 2**53)),
        channels={
            name: draw(hnp.arrays(np.float64, (n, WIDTHS[name]), elements=elements))
            for name in names
        },
    )


def bits(values):
    return [None if np.isnan(value) else value.tobytes() for value in np.ravel(values)]


def assert_same(expected, actual):
    assert actual.t_ns.tolist() == expected.t_ns.tolist()
    assert (actual.period_s, actual.sequence) == (expected.period_s, expected.sequence)
    assert actual.channels.keys() == expected.channels.keys()
    for name, values in expected.channels.items():
        assert actual.channels[name].shape == values.shape
        assert bits(actual.channels[name]) == bits(values)


@given(batches(st.floats(width=64)))
def test_any_float64_comes_back_bit_for_bit_not_finite_ones_too(batch):
    assert_same(batch, decode_samples(encode_samples(batch)))


@given(batches(st.floats(width=32)))
def test_any_float32_comes_back_bit_for_bit(batch):
    assert_same(batch, decode_samples(encode_samples(batch)))


@given(batches(st.floats(width=32, allow_nan=False, allow_infinity=False)))
def test_float32_values_are_written_no_longer_than_they_need(batch):
    fields = json.loads(encode_samples(batch), parse_float=str)
    written = [value for name, column in fields.items() for value in column_digits(name, column)]
    assert max((len(digits) for digits in written), default=0) <= 9


def column_digits(name, column):
    if name in ("t_ns", "period_s", "sequence", "float32"):
        return []
    return [text.split("e")[0].strip("-").replace(".", "").strip("0") for text in map(str, column)]


def test_values_of_float64_are_not_rounded_to_float32():
    batch = SampleBatch(np.array([1]), 0.01, 0, {"force": np.array([[0.1]])})
    assert decode_samples(encode_samples(batch)).channels["force"].tolist() == [[0.1]]


def test_decoded_arrays_are_read_only_and_contiguous():
    rows = np.arange(6.0).reshape(2, 3)
    batch = decode_samples(encode_samples(SampleBatch(np.arange(2), 0.01, 0, {"accel": rows})))
    values = batch.channels["accel"]
    assert values.flags["C_CONTIGUOUS"]
    assert not values.flags["WRITEABLE"]
    assert not batch.t_ns.flags["WRITEABLE"]


@pytest.mark.parametrize("column", [[1.0], [1.0, 2.0, 3.0]])
def test_a_column_of_another_length_than_time_is_refused(column):
    text = json.dumps(
        {"t_ns": [1, 2], "period_s": 0.01, "sequence": 0, "float32": [], "force_newton": column}
    )
    with pytest.raises(ValueError, match="t_ns has 2"):
        decode_samples(text.encode())
