"""Which sample of a regular grid each row of a file is, from its time stamp alone."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from gaitway.samples import Floats, Ints

MAX_OFF_GRID: Final = 0.25
"""A stamp further than this from the grid, in periods, is no sample of it."""
NEIGHBOURS: Final = 25
"""The grid at a sample is where this many rows before and after it put it."""
RATE_ROWS: Final = 20
MAX_RATE_CHANGE: Final = 0.05
"""Of the sample rate within RATE_ROWS rows."""
CLOCK_TOLERANCE: Final = 500e-6
"""What the device's clock may drift during a gap, relative to its length."""
MAX_REFINEMENTS: Final = 3
"""Of the period; one does unless it changes what is a hole."""
MIN_RATE_HZ: Final = 10.0
MAX_RATE_HZ: Final = 2000.0
TIME_UNITS: Final = {"milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}


class GridError(ValueError):
    """The time stamps lie on no grid.

    Attributes:
        row: Number of the row that shows it, from 0; None when all do.
    """

    def __init__(self, row: int | None, reason: str) -> None:
        super().__init__(reason)
        self.row = row


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """A regular grid and the place of each row on it.

    Attributes:
        period_s: The sample period.
        index: Number of the grid's sample that each row is, from 0, shape (n,).
    """

    period_s: float
    index: Ints


def find_grid(t_s: Floats) -> Grid:
    """Return the grid on which time stamps lie, holes in it allowed.

    The period begins as the median difference and is refined by a straight line through each
    stretch without holes, so that stamps rounded to a few decimals count even long holes exactly.
    Where the grid lies is judged locally: a clock that drifts is no fault.

    Args:
        t_s: Time stamps, shape (n,), n at least 2.

    Raises:
        GridError: They do not rise, are not in seconds, or are no grid.
    """
    t_s = t_s - t_s[0]
    steps_s = np.diff(t_s)
    _check_rising(steps_s)
    period_s = float(np.median(steps_s))
    _check_seconds(period_s)
    starts = _starts(steps_s, period_s)
    for _ in range(MAX_REFINEMENTS):
        period_s = _refined(t_s, starts, period_s)
        before, starts = starts, _starts(steps_s, period_s)
        if np.array_equal(before, starts):
            break
    _check_rate(t_s, starts, period_s)
    residual_s = _local_residual(t_s, starts, period_s)
    _check_on_grid(residual_s, period_s)
    return Grid(period_s, _index(t_s - residual_s, starts, period_s))


def _check_rising(steps_s: Floats) -> None:
    rows = np.flatnonzero(steps_s <= 0)
    if len(rows):
        row = int(rows[0])
        what = "stands still" if steps_s[row] == 0 else f"goes back by {-steps_s[row]:g} s"
        raise GridError(row + 1, f"time {what} (sort the rows by t_s and remove duplicates)")


def _check_seconds(period_s: float) -> None:
    if MIN_RATE_HZ * 0.99 <= 1 / period_s <= MAX_RATE_HZ * 1.01:
        return
    told = f"rows are {period_s:g} s apart, {1 / period_s:.4g} Hz"
    for unit, scale in TIME_UNITS.items():
        if MIN_RATE_HZ <= 1 / (period_s * scale) <= MAX_RATE_HZ:
            raise GridError(None, f"t_s looks like {unit}: {told} (multiply it by {scale:g})")
    raise GridError(
        None, f"{told}; rates from {MIN_RATE_HZ:g} to {MAX_RATE_HZ:g} Hz can be used (check t_s)"
    )


def _starts(steps_s: Floats, period_s: float) -> Ints:
    """Return the first row of each stretch without holes."""
    holes = np.flatnonzero(steps_s > 1.5 * period_s) + 1
    return np.concatenate([[0], holes]).astype(np.int64)


def _places(n: int, starts: Ints) -> tuple[Ints, Ints, Ints]:
    """Return, for each row, the first row of its stretch, the one after it, and its own number."""
    lengths = np.diff(np.append(starts, n))
    first = np.repeat(starts, lengths)
    return first, first + np.repeat(lengths, lengths), np.arange(n) - first


def _refined(t_s: Floats, starts: Ints, period_s: float) -> float:
    """Return the common slope of straight lines through every stretch, by least squares."""
    first, end, number = _places(len(t_s), starts)
    centred = number - (end - first - 1) / 2
    spread = float(centred @ centred)
    return float(centred @ (t_s - t_s[first])) / spread if spread else period_s


def _local_residual(t_s: Floats, starts: Ints, period_s: float) -> Floats:
    """Return how far each row is from where its neighbours put it, shape (n,)."""
    first, end, number = _places(len(t_s), starts)
    offset_s = t_s - t_s[first] - number * period_s
    low = np.maximum(np.arange(len(t_s)) - NEIGHBOURS, first)
    high = np.minimum(np.arange(len(t_s)) + NEIGHBOURS + 1, end)
    sums = np.concatenate([[0.0], np.cumsum(offset_s)])
    return np.asarray(offset_s - (sums[high] - sums[low]) / (high - low))


def _check_on_grid(residual_s: Floats, period_s: float) -> None:
    row = int(np.argmax(np.abs(residual_s)))
    off = abs(float(residual_s[row])) / period_s
    if off > MAX_OFF_GRID:
        raise GridError(
            row,
            f"time is {off:.0%} of a period of {period_s:g} s off the sample grid (stamps may be "
            f"{MAX_OFF_GRID:.0%} off; resample the walk, or stamp it with the sensor's clock)",
        )


def _check_rate(t_s: Floats, starts: Ints, period_s: float) -> None:
    first, _, _ = _places(len(t_s), starts)
    rows = np.flatnonzero(first[RATE_ROWS:] == first[:-RATE_ROWS])
    ratio = (t_s[rows + RATE_ROWS] - t_s[rows]) / (RATE_ROWS * period_s)
    wrong = np.flatnonzero(np.abs(ratio - 1) > MAX_RATE_CHANGE)
    if len(wrong):
        rate_hz = 1 / (period_s * float(ratio[wrong[0]]))
        raise GridError(
            int(rows[wrong[0]]),
            f"the sample rate changes: about {rate_hz:.4g} Hz from here, {1 / period_s:.4g} Hz "
            "over the whole file (split the file, or resample it)",
        )


def _index(grid_s: Floats, starts: Ints, period_s: float) -> Ints:
    """Return the grid number of each row, counting the holes between stretches."""
    steps = np.ones(len(grid_s), dtype=np.int64)
    steps[0] = 0
    holes = starts[1:]
    lengths = (grid_s[holes] - grid_s[holes - 1]) / period_s
    counted = np.rint(lengths)
    wrong = np.abs(lengths - counted) > MAX_OFF_GRID + CLOCK_TOLERANCE * lengths
    wrong |= counted < 1
    if wrong.any():
        which = int(np.flatnonzero(wrong)[0])
        raise GridError(
            int(holes[which]),
            f"after a hole of {lengths[which]:.2f} periods the sample grid is another one: how "
            "many samples are missing can't be told (split the file there)",
        )
    steps[holes] = counted.astype(np.int64)
    return np.cumsum(steps)
