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
        self._lowest_index = 0
        self._falling = False
        self._index = 0

    def push(self, value: float) -> int | None:
        """Take the next value; return the index of the valley it confirms, counted from 0."""
        index = self._index
        self._index += 1
        depth = max(self._least, self._share * self._peak)
        if not self._falling:
            self._peak = max(self._peak, value)
            if self._peak - value > max(self._least, self._share * self._peak):
                self._falling, self._lowest, self._lowest_index = True, value, index
            return None
        if value < self._lowest:
            self._lowest, self._lowest_index = value, index
        if value - self._lowest <= depth:
            return None
        self._falling, self._peak = False, value
        return self._lowest_index
