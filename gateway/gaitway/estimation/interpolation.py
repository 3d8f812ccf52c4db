"""Strides that missing samples hid in mid-walk: how many and how long, by those beside them."""

from collections import deque
from statistics import fmean, pstdev
from typing import Final, NamedTuple

from gaitway.timebase import NS_PER_S

_NO_CYCLE: Final = 0.35
"""Time that differs by more from that of whole cycles is none of them alone: a pause, a turn."""


class LostStrides(NamedTuple):
    """Strides that nobody saw.

    Attributes:
        bounds_ns: Where each began, and where the last ended.
        length_m: Of each.
        sigma_m: Standard deviation of each.
    """

    bounds_ns: list[int]
    length_m: float
    sigma_m: float


class StrideInterpolation:
    """Learns what the strides of a walk are like, and tells what a gap in it hid.

    That is honest only where the time between two strides that were seen is that of a few cycles;
    else nothing is told, and the time counts as unmeasured.

    Args:
        memory: So many strides before a gap say what the lost ones were like.
        at_least: Fewer say nothing.
        most: More are not made up.
        sigma_share: Standard deviation of a lost stride as a share of its length, besides what the
            strides of the walk show.
    """

    def __init__(
        self, *, memory: int = 6, at_least: int = 2, most: int = 3, sigma_share: float = 0.15
    ) -> None:
        self._usual: deque[tuple[float, float]] = deque(maxlen=memory)
        self._at_least = at_least
        self._most = most
        self._sigma_share = sigma_share

    def learn(self, cycle_s: float, length_m: float) -> None:
        """Take a stride that was seen from contact to contact."""
        self._usual.append((cycle_s, length_m))

    def forget(self) -> None:
        """Take that the walk is over."""
        self._usual.clear()

    def between(self, before_ns: int, after_ns: int) -> LostStrides | None:
        """Return the strides between the last that was seen and the next contact, if that is sure.

        Args:
            before_ns: End of the last.
            after_ns: The contact.
        """
        if len(self._usual) < self._at_least:
            return None
        cycles_s, lengths_m = zip(*self._usual, strict=True)
        cycles = (after_ns - before_ns) / NS_PER_S / fmean(cycles_s)
        count = round(cycles)
        if not 1 <= count <= self._most or abs(cycles - count) > _NO_CYCLE:
            return None
        length_m = fmean(lengths_m)
        whole_ns = after_ns - before_ns
        bounds_ns = [before_ns + whole_ns * part // count for part in range(count + 1)]
        return LostStrides(bounds_ns, length_m, self._sigma_share * length_m + pstdev(lengths_m))
