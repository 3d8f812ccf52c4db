"""Changes of direction: turns of several steps as one."""

import math
from collections.abc import Sequence

from gaitway.api import NS_PER_S, Event, Turn
from gaitway_plugins.walker.fix import Fix
from gaitway_plugins.walker.params import WalkerParams


class Turns:
    """Finds turns in the heading.

    Args:
        params: Of the walker.
    """

    def __init__(self, params: WalkerParams) -> None:
        self._params = params
        self._before: Fix | None = None
        self._start: Fix | None = None
        self._last: Fix | None = None
        self._sense = 0.0

    def push(self, fix: Fix) -> Sequence[Event]:
        """Take the next fix; return the turn that it shows to be over."""
        before, self._before = self._before, fix
        if before is None:
            return ()
        rate_radps = (fix.heading_rad - before.heading_rad) / fix.duration_s
        turning = abs(rate_radps) > self._params.turn_rate_radps
        if turning and self._start is not None and rate_radps * self._sense > 0.0:
            self._last = fix
            return ()
        if turning and (self._start is None or not self._far()):
            self._start, self._last, self._sense = before, fix, rate_radps
            return ()
        pause_s = 0.0 if self._last is None else (fix.t_ns - self._last.t_ns) / NS_PER_S
        if self._start is None or pause_s < self._params.turn_pause_s:
            return ()
        return self.finish()

    def finish(self) -> Sequence[Event]:
        """Return the turn that was going on."""
        start, last = self._start, self._last
        far = self._far()
        self._start = self._last = None
        if start is None or last is None or not far:
            return ()
        angle_rad = last.heading_rad - start.heading_rad
        sigma_rad = math.hypot(0.01 * angle_rad, 0.01, 0.5 * last.heading_sigma_rad)
        return (
            Turn(
                t_ns=last.t_ns,
                start_t_ns=start.t_ns,
                turn_duration_s=(last.t_ns - start.t_ns) / NS_PER_S,
                turn_duration_sigma_s=math.sqrt(2.0) * self._params.stride_time_sigma_s,
                turn_angle_rad=angle_rad,
                turn_angle_sigma_rad=sigma_rad,
            ),
        )

    def _far(self) -> bool:
        if self._start is None or self._last is None:
            return False
        angle_rad = self._last.heading_rad - self._start.heading_rad
        return abs(angle_rad) >= self._params.turn_min_rad
