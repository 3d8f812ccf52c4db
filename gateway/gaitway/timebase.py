"""Time: the clocks, the wall-clock anchor, and a device's clock in terms of the host's.

Nobody else in gaitway reads a clock. ``time.monotonic_ns`` is not touched by NTP, by a person
setting the date, or by a Pi without a battery-backed clock learning the time an hour after boot.
"""

import asyncio
import time
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Protocol

NS_PER_S = 1_000_000_000


class Clock(Protocol):
    """The host's clocks, injectable."""

    def now_ns(self) -> int:
        """Return monotonic time in nanoseconds."""
        ...

    def wall_ns(self) -> int:
        """Return wall-clock time in nanoseconds since 1970 (UTC)."""
        ...

    async def sleep(self, delay_s: float) -> None:
        """Wait on the monotonic clock."""
        ...


class HostClock:
    """The real clocks of this machine."""

    def now_ns(self) -> int:
        """Return monotonic time in nanoseconds."""
        return time.monotonic_ns()

    def wall_ns(self) -> int:
        """Return wall-clock time in nanoseconds since 1970 (UTC)."""
        return time.time_ns()

    async def sleep(self, delay_s: float) -> None:
        """Wait on the monotonic clock."""
        await asyncio.sleep(delay_s)


@dataclass(frozen=True, slots=True)
class WallAnchor:
    """One moment on both clocks: the only bridge from monotonic to wall-clock time.

    Attributes:
        t_ns: The moment on the monotonic clock.
        wall_ns: The same moment in nanoseconds since 1970 (UTC).
    """

    t_ns: int
    wall_ns: int

    @classmethod
    def take(cls, clock: Clock) -> "WallAnchor":
        """Return the present moment on both clocks."""
        return cls(clock.now_ns(), clock.wall_ns())

    def to_wall_ns(self, t_ns: int) -> int:
        """Return nanoseconds since 1970 of a monotonic time; intervals are kept exactly."""
        return self.wall_ns + (t_ns - self.t_ns)

    def to_utc(self, t_ns: int) -> str:
        """Return a monotonic time as ISO 8601 in UTC, with microseconds."""
        wall_ns = self.to_wall_ns(t_ns)
        whole_s, rest_ns = divmod(wall_ns, NS_PER_S)
        moment = datetime.fromtimestamp(whole_s, UTC)
        return f"{moment:%Y-%m-%dT%H:%M:%S}.{rest_ns // 1000:06d}Z"

    def stepped_by_s(self, clock: Clock) -> float:
        """Return how far the wall clock has moved against the monotonic one since the anchor."""
        return (clock.wall_ns() - self.to_wall_ns(clock.now_ns())) / NS_PER_S
