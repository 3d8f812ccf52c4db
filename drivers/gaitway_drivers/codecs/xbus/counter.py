"""The packet counter: which messages are missing between two."""

from itertools import pairwise
from typing import Final

COUNTS: Final = 2**16


class PacketCounter:
    """Counts messages that were sent and never came.

    The counter numbers all measurements together, whatever they hold, so it must see them all.
    """

    def __init__(self) -> None:
        self._last: int | None = None

    def restart(self) -> None:
        """Expect any number next: the device began anew."""
        self._last = None

    def advance(self, counters: list[int] | None) -> int:
        """Return how many messages are missing before and between these.

        Half a round or more is no loss but a counter that began anew.

        Args:
            counters: Numbers of messages in the order they came; None if they carry none.
        """
        if not counters:
            return 0
        last, self._last = self._last, counters[-1]
        if last is not None and counters == list(range(last + 1, last + 1 + len(counters))):
            return 0  # as nearly always: one comparison instead of one a message
        numbers = counters if last is None else [last, *counters]
        missing = [(number - before - 1) % COUNTS for before, number in pairwise(numbers)]
        return sum(count for count in missing if count < COUNTS // 2)
