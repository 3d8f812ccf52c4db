"""Time: the clocks, the wall-clock anchor, and a device's clock in terms of the host's.

Nobody else in gaitway reads a clock. ``time.monotonic_ns`` is not touched by NTP, by a person
setting the date, or by a Pi without a battery-backed clock learning the time an hour after boot.
"""

import time
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Protocol

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
        import asyncio  # noqa: PLC0415  heavy, and commands that wait for nothing start without

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


WINDOW_S = 2.0
"""The smallest delay within each window of device time is kept; transport jitter is above it."""
WINDOWS = 60
"""Two minutes of windows: long enough for 10 ppm of drift to show above 1 ms of jitter."""
WINDOWS_FOR_DRIFT = 10
MAX_DRIFT = 500e-6
"""No crystal is worse; a larger slope is queueing, not drift."""
SLEW_TIME_S = 10.0
MAX_SLEW = 0.05
"""The stamp may run at most this much faster or slower than the device: never backwards."""


class DeviceClock:
    """Device time in terms of host time, from when bytes arrived.

    A message can be late, never early, so the smallest ``arrival - device`` of each window lies on
    the true line; a straight line under those minima gives offset and drift (the lower hull of
    Zhang, Liu and Xia 2002, with one point a window). Bursts and stalls only add points above it.
    The line in use is slewed towards the one found, so stamps are continuous and rise strictly.
    """

    def __init__(self) -> None:
        self._windows: deque[tuple[int, int]] = deque(maxlen=WINDOWS)
        self._window_end_ns: int | None = None
        self._best: tuple[int, int] | None = None
        self._base_device_ns = 0
        self._base_offset_ns = 0
        self._slew = 0.0
        self._drift = 0.0

    @property
    def drift_ppm(self) -> float:
        """How much faster host time runs than device time, parts per million; 0 until known."""
        return self._drift * 1e6

    def reset(self) -> None:
        """Forget everything: the device's clock began anew."""
        self.__init__()  # type: ignore[misc]  # the initial state, written once

    def save(self) -> dict[str, Any]:
        """Return what it knows, ready for JSON."""
        return {
            "windows": [list(window) for window in self._windows],
            "window_end_ns": self._window_end_ns,
            "best": None if self._best is None else list(self._best),
            "base_device_ns": self._base_device_ns,
            "base_offset_ns": self._base_offset_ns,
            "slew": self._slew,
            "drift": self._drift,
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Go on from what was saved within the same boot of the host.

        Raises:
            LookupError: Something is missing.
            TypeError: Something is of another type.
            ValueError: Something can't be.
        """
        windows = [(int(at_ns), int(offset_ns)) for at_ns, offset_ns in saved["windows"]]
        best, end_ns = saved["best"], saved["window_end_ns"]
        fresh = DeviceClock()
        fresh._windows.extend(windows)
        fresh._window_end_ns = None if end_ns is None else int(end_ns)
        fresh._best = None if best is None else (int(best[0]), int(best[1]))
        fresh._base_device_ns = int(saved["base_device_ns"])
        fresh._base_offset_ns = int(saved["base_offset_ns"])
        fresh._slew, fresh._drift = float(saved["slew"]), float(saved["drift"])
        self.__dict__.update(fresh.__dict__)

    def observe(self, arrival_ns: int, device_ns: int) -> None:
        """Take the arrival of the sample that the device stamped ``device_ns``."""
        offset_ns = arrival_ns - device_ns
        if self._window_end_ns is None:
            self._base_device_ns, self._base_offset_ns = device_ns, offset_ns
            self._window_end_ns = device_ns + round(WINDOW_S * NS_PER_S)
        if self._best is None or offset_ns < self._best[1]:
            self._best = (device_ns, offset_ns)
        if device_ns >= self._window_end_ns:
            self._windows.append(self._best)
            self._best = None
            self._window_end_ns = device_ns + round(WINDOW_S * NS_PER_S)
            self._aim(device_ns)

    def to_host_ns(self, device_ns: int) -> int:
        """Return the host time of a device time."""
        return self.to_host_all_ns((device_ns,))[0]

    def to_host_all_ns(self, device_ns: Iterable[int]) -> list[int]:
        """Return the host time of each of many device times."""
        base_ns, offset_ns = self._base_device_ns, self._base_offset_ns
        drift, slew, slewing_ns = self._drift, self._slew, SLEW_TIME_S * NS_PER_S
        host_ns: list[int] = []
        for at_ns in device_ns:
            since_ns = at_ns - base_ns
            correction_ns = round(drift * since_ns + slew * min(since_ns, slewing_ns))
            host_ns.append(at_ns + offset_ns + correction_ns)
        return host_ns

    def _aim(self, device_ns: int) -> None:
        """Set the slew that brings the offset in use to the one found within SLEW_TIME_S."""
        present_ns = self.to_host_ns(device_ns) - device_ns
        self._drift = self._find_drift()
        found_ns = min(
            offset_ns + self._drift * (device_ns - at_ns) for at_ns, offset_ns in self._windows
        )
        slew = (found_ns - present_ns) / (SLEW_TIME_S * NS_PER_S)
        self._base_device_ns, self._base_offset_ns = device_ns, present_ns
        self._slew = max(-MAX_SLEW, min(MAX_SLEW, slew))

    def _find_drift(self) -> float:
        """Return the slope of the lower hull's edge below the middle of the windows.

        A point above the hull, however far, changes nothing; a fit of squares would follow it.
        """
        if len(self._windows) < WINDOWS_FOR_DRIFT:
            return 0.0
        hull: list[tuple[int, int]] = []
        for point in self._windows:
            while len(hull) > 1 and not _turns_up(hull[-2], hull[-1], point):
                hull.pop()
            hull.append(point)
        middle_ns = (hull[0][0] + hull[-1][0]) // 2
        right = next(index for index, point in enumerate(hull) if point[0] > middle_ns)
        (left_at, left_offset), (right_at, right_offset) = hull[right - 1], hull[right]
        slope = (right_offset - left_offset) / (right_at - left_at)
        return max(-MAX_DRIFT, min(MAX_DRIFT, slope))


def _turns_up(first: tuple[int, int], second: tuple[int, int], third: tuple[int, int]) -> bool:
    """Tell whether the way over three points bends upwards at the second."""
    return (second[0] - first[0]) * (third[1] - first[1]) > (second[1] - first[1]) * (
        third[0] - first[0]
    )
