"""How long to wait before a lost link is tried again."""

from typing import Final

FIRST_S: Final = 0.25
FACTOR: Final = 2.0
LONGEST_S: Final = 2.0
"""Short enough that a cable put back works within five seconds; a failed open costs little."""


class Backoff:
    """Doubles from a quarter of a second to two; a success starts it again."""

    def __init__(self) -> None:
        self._next_s = FIRST_S

    def next_delay_s(self) -> float:
        """Return how long to wait now, and wait longer the next time."""
        delay_s, self._next_s = self._next_s, min(self._next_s * FACTOR, LONGEST_S)
        return delay_s

    def succeeded(self) -> None:
        """Start again from the shortest wait."""
        self._next_s = FIRST_S
