"""CSV files that hold nothing but plain numbers, at the speed of a JSON parser.

Most files are like this, and an hour of samples is 30 MB. Whatever is out of the ordinary (a text,
an empty cell, ``nan``, a row of another length) is left to the reader that can say what is wrong.
"""

from typing import Final

import numpy as np
import orjson

from gaitway.samples import Floats

PLAIN: Final = b"0123456789+-.eE,\n"
"""Of these alone, JSON makes numbers or an error: no text, no null, no nan."""
BLOCK_BYTES: Final = 1 << 20
"""Read at once: what fits the processor's caches is fastest, and takes little memory."""


def read_plain(content: bytes) -> tuple[str, Floats] | None:
    """Return the header line and the numbers, shape (rows, columns); None for any other file.

    The numbers are those that ``float`` makes of each cell, to the last bit.
    """
    header = _header(content)
    if header is None:
        return None
    start, end = content.index(b"\n") + 1, len(content.rstrip())
    blocks: list[Floats] = []
    while start < end:
        stop = content.find(b"\n", start + BLOCK_BYTES, end)
        stop = end if stop < 0 else stop
        block = _block(content[start:stop].replace(b"\r\n", b"\n"), header.count(",") + 1)
        if block is None:
            return None
        blocks.append(block)
        start = stop + 1
    return (header, np.concatenate(blocks)) if sum(map(len, blocks)) >= 2 else None


def _header(content: bytes) -> str | None:
    head, newline, _ = content[:BLOCK_BYTES].partition(b"\n")
    try:
        header = head.decode("utf-8-sig").removesuffix("\r")
    except UnicodeDecodeError:
        return None
    whole = newline and len(header.splitlines()) == 1 and "\0" not in header
    return header if whole else None


def _block(text: bytes, width: int) -> Floats | None:
    """Return the numbers of whole rows, the last without its end of line."""
    text = text.removesuffix(b"\r")
    if text.translate(None, PLAIN):
        return None
    # An integer has no -0, so it is written as the float it is.
    cells = (text + b"\n").replace(b"\n", b",").replace(b"-0,", b"-0.0,")
    try:
        values = orjson.loads(b"[" + cells[:-1] + b"]")
    except orjson.JSONDecodeError:
        return None
    if len(values) % width or not _is_table(text, len(values) // width, width):
        return None
    return np.array(values, dtype=np.float64).reshape(-1, width)


def _is_table(text: bytes, rows: int, width: int) -> bool:
    """Tell whether every row has as many cells as that, where all of them have it on average."""
    codes = np.frombuffer(text, dtype=np.uint8)
    ends = codes == ord("\n")
    separators = np.flatnonzero(ends | (codes == ord(",")))
    every = ends[separators[width - 1 :: width]]
    return bool(every.all()) and len(every) == rows - 1 == np.count_nonzero(ends)
