"""The device's clock: SampleTimeFine, which wraps, unwrapped."""

from operator import lt
from typing import Final

TICK_NS: Final = 100_000
"""SampleTimeFine counts at 10 kHz."""

DAY_TICKS: Final = 864_000_000
"""Where the clock of the 10- and 100-series begins anew."""
FULL_TICKS: Final = 2**32
"""Where the clock of the 1- and 600-series begins anew."""
MAX_WRAP_TICKS: Final = 6_000_000
"""A step back is a wrap if it is at most ten minutes forward across one of the two ends.

A clock anywhere else that goes back was set back. So the series need not be known: only a restart
in the ten minutes before an end is mistaken, and the host's own clock shows that one up.
"""


class TickClock:
    """Turns raw ticks into device time that goes on across a wrap."""

    def __init__(self) -> None:
        self._raw: int | None = None
        self._offset = 0
        self._restarted = False

    def restart(self) -> None:
        """Note that the device said its clock begins anew."""
        self._raw = None
        self._offset = 0
        self._restarted = True

    def is_last(self, raw: int) -> bool:
        """Tell whether this is the time of the latest sample."""
        return raw == self._raw

    def is_behind(self, raw: int) -> bool:
        """Tell whether a message is older than the latest sample."""
        return self._raw is not None and (raw - self._raw) % FULL_TICKS > FULL_TICKS // 2

    def advance_all(self, raw: list[int]) -> list[int] | None:
        """Return device time in nanoseconds of samples in plain rising order.

        None, and nothing is done, if there is anything special among them.
        """
        if self._restarted or (self._raw is not None and raw[0] <= self._raw):
            return None
        if not all(map(lt, raw, raw[1:])):
            return None
        self._raw, offset = raw[-1], self._offset
        return [(ticks + offset) * TICK_NS for ticks in raw]

    def advance(self, raw: int) -> tuple[int, bool]:
        """Return device time in nanoseconds of the next sample, and whether it begins anew."""
        restarted, self._restarted = self._restarted, False
        if self._raw is not None and raw <= self._raw:
            wrap_ticks = next(
                (end for end in (DAY_TICKS, FULL_TICKS) if self._wraps_at(end, raw)), None
            )
            restarted = wrap_ticks is None
            self._offset = 0 if wrap_ticks is None else self._offset + wrap_ticks
        self._raw = raw
        return (raw + self._offset) * TICK_NS, restarted

    def would_restart(self, raw: int) -> bool:
        """Tell whether ``advance`` would say that the clock begins anew."""
        if self._raw is None or raw > self._raw:
            return self._restarted
        return not any(self._wraps_at(end, raw) for end in (DAY_TICKS, FULL_TICKS))

    def _wraps_at(self, end: int, raw: int) -> bool:
        assert self._raw is not None
        return self._raw < end and 0 < (raw - self._raw) % end <= MAX_WRAP_TICKS
