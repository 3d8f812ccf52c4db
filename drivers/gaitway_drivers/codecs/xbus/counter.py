"""The packet counter: which messages are missing between two."""

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
        lost = 0
        last = self._last
        for counter in counters or ():
            if last is not None:
                missing = (counter - last - 1) % COUNTS
                lost += missing if missing < COUNTS // 2 else 0
            last = counter
        self._last = last
        return lost
