"""The fast reader gives what the careful one gives, or nothing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitway.offline import plain_csv
from gaitway.offline.plain_csv import read_plain

CELLS = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.floats(-100, 100).map(lambda value: f"{value:.9g}"),
    st.integers(-(10**25), 10**25).map(str),
    st.sampled_from(["0", "-0", "-0.0", "1E5", "1e-3", "-0e0", "1e-400", "9007199254740993"]),
)
ODD_CELLS = st.sampled_from(
    ["", " 1", "+1", ".5", "5.", "007", "nan", "inf", "1e999", "true", "null", "[1]", "0x1", "1_0",
     "1\n", "1,2", '"1"', "1\r", "\u0661", "\0", "1]", "],["]
)  # fmt: skip


@settings(max_examples=200)
@given(
    st.integers(1, 4).flatmap(
        lambda width: st.lists(st.lists(CELLS, min_size=width, max_size=width), min_size=2)
    ),
    st.sampled_from(["\n", "\r\n"]),
    st.sampled_from(["", "\n", "\r\n \n"]),
    st.sampled_from([1, 7, 1 << 20]),
)
def test_every_number_is_what_float_makes_of_it(rows, end, tail, block_bytes):
    text = end.join([",".join("abcd"[: len(rows[0])]), *map(",".join, rows)]) + tail
    plain_csv.BLOCK_BYTES, before = max(block_bytes, 16), plain_csv.BLOCK_BYTES
    try:
        header, table = read_plain(b"\xef\xbb\xbf" + text.encode())
    finally:
        plain_csv.BLOCK_BYTES = before
    expected = np.array([[float(cell) for cell in row] for row in rows])
    assert header == "abcd"[: len(rows[0])].replace("", ",").strip(",")
    assert table.shape == expected.shape
    assert table.tobytes() == expected.tobytes()  # the sign of zero too


@given(
    st.lists(st.lists(CELLS, min_size=3, max_size=3), min_size=2, max_size=6),
    st.integers(0, 5),
    st.integers(0, 2),
    ODD_CELLS,
)
def test_with_anything_odd_in_it_it_gives_nothing(rows, row, column, odd):
    rows[row % len(rows)][column] = odd
    text = "\n".join(["a,b,c", *map(",".join, rows)])
    # At the very end a line break is no cell, and before another one it is part of that.
    if text.rstrip() == text and "\r\n" not in text:
        assert read_plain(text.encode()) is None


@pytest.mark.parametrize(
    "text",
    [
        "",
        "a,b",
        "a,b\n",
        "a,b\n1,2",
        "a,b\n1,2\n\n3,4",
        "a,b\n1,2,3\n4",  # as many cells as two rows of two
        "a,b\n1\n2,3,4",
        "a,b\n1,2\n3",
        "a,b\n1,2\n3,4,",
        "a\x0bb,c\n1,2\n3,4",
        "a\0,c\n1,2\n3,4",
        "a,b\r1,2\r3,4",
        "a,b\n1,2\n3,\u0664\n",
    ],
)
def test_what_is_no_table_gives_nothing(text):
    assert read_plain(text.encode()) is None


def test_a_header_that_is_no_utf8_gives_nothing():
    assert read_plain(b"a,\xff\n1,2\n3,4") is None


def test_rows_are_checked_in_every_block(monkeypatch):
    monkeypatch.setattr(plain_csv, "BLOCK_BYTES", 16)
    rows = ["1,2"] * 40
    for number in range(40):
        odd = [*rows]
        odd[number] = "1,2,3"
        assert read_plain("\n".join(["a,b", *odd]).encode()) is None
    assert len(read_plain("\n".join(["a,b", *rows]).encode())[1]) == 40
