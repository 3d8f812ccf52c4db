"""From ways to strides: which of them count, and what is said of those that don't."""

import math
from collections import deque
from itertools import pairwise
from typing import Final, NamedTuple

from gaitway.api import NS_PER_S, Anomaly, Event
from gaitway.estimation import WalkLedger
from gaitway_plugins.shank.footing import Footing
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.stride import Way

_LOST_BY_CLIPPING_MPS2: Final = 5.0
"""By how much a clipped reading may be short, as a standard deviation."""
_NEIGHBOURS: Final = 3
"""So many strides before a gap say what the lost ones were like."""
_FIRST: Final = 0.65
"""A stride from or to standing is no longer than this share of the longest: the leg that follows
takes most of a whole one."""
_SHORT_M: Final = 0.45
"""A step from or to standing that is shorter may wander about its place."""
_NO_CYCLE: Final = 0.25
"""Time that differs by more from that of whole strides is none of them alone."""


class Unmeasured(NamedTuple):
    """A time of walking that was not measured.

    Attributes:
        since_ns: The footing before.
        anomaly: Name of what happened.
        detail: One line for a person.
        t_ns: When it was over.
    """

    since_ns: int
    anomaly: str
    detail: str
    t_ns: int

    @property
    def duration_s(self) -> float:
        """How long it was."""
        return (self.t_ns - self.since_ns) / NS_PER_S

    def bounds_ns(self, count: int) -> list[int]:
        """Return where so many equal parts of it begin and end."""
        whole_ns = self.t_ns - self.since_ns
        return [self.since_ns + whole_ns * part // count for part in range(count + 1)]


class Accounts:
    """Keeps the books of a shank: a stride is one way from floor to floor that is believed.

    Args:
        params: Of the shank.
    """

    def __init__(self, params: ShankParams) -> None:
        self._params = params
        self._usual: deque[tuple[float, float]] = deque(maxlen=_NEIGHBOURS)
        self._waiting: Unmeasured | None = None
        self._ledger = WalkLedger(
            max_pause_s=params.max_pause_s,
            shared_sigma=params.shared_sigma,
            stride_time_sigma_s=params.stride_time_sigma_s,
        )

    @property
    def in_bout(self) -> bool:
        """Whether a walk is going on."""
        return self._ledger.in_bout

    def begin(self, t_ns: int) -> None:
        """Take the first sample; later ones change nothing."""
        self._ledger.begin(t_ns)

    def stand(self, t_ns: int) -> list[Event]:
        """Let a sample pass in which nobody walks."""
        if not self._ledger.in_bout:
            return []
        events = self._ledger.advance(t_ns)
        return [*self._flush(), *events] if events else []

    def believes(self, way: Way, swing_share: float, *, half: bool) -> bool:
        """Return whether a way is none that only an error, or no walk, can make.

        Args:
            way: From footing to footing.
            swing_share: Of its duration that the leg was in the air.
            half: It began or ended in standing.
        """
        p = self._params
        return (
            way.length_m <= p.max_stride_m * (_FIRST if half else 1.0)
            and swing_share <= p.max_swing_share
            and way.speed_ratio >= p.min_speed_ratio
            and (way.detour <= p.max_detour or (half and way.length_m < _SHORT_M))
            and way.height_range_m <= p.max_height_m + p.max_steepness * way.length_m
            and way.tilt_step_rad <= p.max_tilt_step_rad
            and abs(way.closing_mps2) <= p.max_closing_mps2
        )

    def stride(
        self, before: Footing, after: Footing, way: Way, swing_s: float, clipped_s: float
    ) -> list[Event]:
        """Count a way that is believed, unless it is stepping on the spot.

        Args:
            before: Where it began.
            after: Where it ended.
            way: Between them.
            swing_s: Time in the air.
            clipped_s: Time in which a reading was at the end of its range.
        """
        if way.length_m < self._params.min_stride_m:
            return []
        cycle_s = (after.t_ns - before.t_ns) / NS_PER_S
        events = self._get_used_to(before, after, cycle_s, way.length_m)
        events += self._ledger.add_stride(
            before.t_ns, after.t_ns, way.length_m,
            self._sigma_m(way, cycle_s, clipped_s),
            stance_duration_s=cycle_s - swing_s, swing_duration_s=swing_s,
        )  # fmt: skip
        if not clipped_s:
            return events
        detail = f"readings at the end of their range for {clipped_s:.2f} s of this stride"
        return [*events, Anomaly(t_ns=after.t_ns, anomaly="sensor-clipped", detail=detail)]

    def _get_used_to(
        self, before: Footing, after: Footing, cycle_s: float, length_m: float
    ) -> list[Event]:
        """Learn from a whole stride what strides are like; return those that waited for it."""
        if before.flat is None:
            self._usual.clear()
            return self._flush()
        if after.flat is None:
            return self._flush()
        self._usual.append((cycle_s, length_m))
        return self._waited()

    def bridge(self, lost: Unmeasured) -> list[Event]:
        """Interpolate the strides between two footings of one walk, where that is honest.

        It is where the time between is that of one to a few strides like those just before, or,
        early in a walk, like the one after, which is waited for.
        """
        if self._usual:
            return self._interpolated(lost)
        events = self._flush()
        self._waiting = lost
        return events

    def unseen(self, lost: Unmeasured) -> list[Event]:
        """Count time of walking that gave no measure."""
        events = self._flush()
        self._ledger.add_unmeasured(lost.duration_s)
        said = Anomaly(t_ns=lost.t_ns, anomaly=lost.anomaly, detail=lost.detail)
        return [*events, said, self._ledger.distance(lost.t_ns)]

    def finish(self) -> list[Event]:
        """Take that no more will come."""
        return [*self._flush(), *self._ledger.close_bout()]

    def _flush(self) -> list[Event]:
        """Give up waiting for a stride like those that were lost."""
        lost, self._waiting = self._waiting, None
        return [] if lost is None else self.unseen(lost)

    def _waited(self) -> list[Event]:
        lost, self._waiting = self._waiting, None
        return [] if lost is None else self._interpolated(lost)

    def _interpolated(self, lost: Unmeasured) -> list[Event]:
        """Count lost strides with the usual speed, a wide sigma of their own, and as unmeasured."""
        p = self._params
        walked_s, walked_m = (sum(column) for column in zip(*self._usual, strict=True))
        cycles = lost.duration_s * len(self._usual) / walked_s
        count = round(cycles)
        if not 1 <= count <= p.max_lost_strides or abs(cycles / count - 1.0) > _NO_CYCLE:
            return self.unseen(lost)
        self._ledger.add_unmeasured(lost.duration_s, speed_sigma_mps=0.0)
        length_m = walked_m / walked_s * lost.duration_s / count
        told = f"{lost.detail}; {count} of {length_m:.2f} m interpolated from strides beside"
        events: list[Event] = [Anomaly(t_ns=lost.t_ns, anomaly=lost.anomaly, detail=told)]
        for start_ns, end_ns in pairwise(lost.bounds_ns(count)):
            sigma_m = p.lost_stride_sigma * length_m
            events += self._ledger.add_stride(
                start_ns, end_ns, length_m, sigma_m, interpolated=True
            )
        return events

    def _sigma_m(self, way: Way, cycle_s: float, clipped_s: float) -> float:
        """Return the standard deviation of a length from what is uncertain in the stride alone.

        The velocities at both ends, mean of two independent ones; a tilt step whose moment is not
        known, at worst ``g a T^2 / 24`` when it was spread over the stride; clipped readings.
        """
        velocity_m = self._params.velocity_sigma_mps * cycle_s / math.sqrt(2.0)
        tilt_m = 9.8 * way.tilt_step_rad * cycle_s**2 / 24.0
        clipped_m = _LOST_BY_CLIPPING_MPS2 * clipped_s * cycle_s / 4.0
        return math.hypot(velocity_m, tilt_m, clipped_m)
