"""A clock that stands still until a test moves it."""

import types
from collections.abc import Generator

from gaitway.timebase import NS_PER_S


class ManualClock:
    """A ``Clock`` for tests: time passes by ``advance`` and by sleeping, and then at once.

    Move it from one thread; any thread may read it.

    Args:
        t_ns: Monotonic time at the start.
        wall_ns: Wall-clock time at the start, nanoseconds since 1970.
    """

    def __init__(
        self, t_ns: int = 1_000 * NS_PER_S, wall_ns: int = 1_767_225_600 * NS_PER_S
    ) -> None:
        self._t_ns = t_ns
        self._wall_ns = wall_ns

    def now_ns(self) -> int:
        """Return monotonic time in nanoseconds."""
        return self._t_ns

    def wall_ns(self) -> int:
        """Return wall-clock time in nanoseconds since 1970 (UTC)."""
        return self._wall_ns

    async def sleep(self, delay_s: float) -> None:
        """Let the time pass, and everybody else run once."""
        self.advance(delay_s)
        await _give_way()

    def advance(self, duration_s: float) -> None:
        """Let time pass on both clocks."""
        self._t_ns += round(duration_s * NS_PER_S)
        self._wall_ns += round(duration_s * NS_PER_S)

    def step_wall(self, step_s: float) -> None:
        """Set the wall clock forward or back, as NTP or a person does."""
        self._wall_ns += round(step_s * NS_PER_S)


@types.coroutine
def _give_way() -> Generator[None, None, None]:
    yield
