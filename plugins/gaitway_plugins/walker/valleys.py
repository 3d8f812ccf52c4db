"""Steps within a roll: where its speed is lowest between two humps."""

from typing import Final


class Valleys:
    """Finds the valleys of a signal as it comes, by how far it fell before and rises after.

    Args:
        share: A valley is deeper than this share of the hump before.
        least: And deeper than this.
    """

    def __init__(self, share: float, least: float) -> None:
        self._share: Final = share
        self._least: Final = least
        self._peak = 0.0
        self._lowest = 0.0
        self._since_lowest = 0
        self._falling = False

    def push(self, value: float) -> int | None:
        """Take the next value; return how many values ago the valley was that it confirms."""
        if not self._falling:
            self._peak = max(self._peak, value)
            self._falling = self._peak - value > self._depth
            self._lowest, self._since_lowest = value, 0
            return None
        self._since_lowest += 1
        if value < self._lowest:
            self._lowest, self._since_lowest = value, 0
        if value - self._lowest <= self._depth:
            return None
        self._falling, self._peak = False, value
        return self._since_lowest

    @property
    def _depth(self) -> float:
        return max(self._least, self._share * self._peak)
