"""From ways to strides, poses and anomalies: which ways count, and what is said of the rest."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from gaitway.api import NS_PER_S, Anomaly, Event, Floats, Pose, Stride
from gaitway.estimation import WalkLedger
from gaitway_plugins.ankle.lever import Lever
from gaitway_plugins.ankle.params import AnkleParams
from gaitway_plugins.ankle.way import Way

_LOST_BY_CLIPPING_MPS2: Final = 5.0
"""By how much a clipped reading may be short, as a standard deviation."""
_FILLED_SIGMA: Final = 0.12
"""Relative standard deviation of a stride that is only taken to have gone on as before."""
_CYCLE_OFF: Final = 0.3
"""By so many cycles may time unseen differ from whole ones."""
_REMEMBERED: Final = 6
_UNTRUSTED: Final = 2
"""So many strides in a row that do not close make the distance untrustworthy."""
_STEADY: Final = 3
"""After so many strides a pace is known."""
_CLEAN: Final = 2
"""A bout begins with so many strides that close by themselves,"""
_TURN_MAX_RAD: Final = 1.2
"""leading the same way to within this angle,"""
_LEGLIKE: Final = 0.8
"""or with strides whose turning is so much about one axis,"""
_LEGLIKE_ENOUGH: Final = 4
"""so many of them, for a sensor that can't follow,"""
_WAITING: Final = 5
"""among so many in a row."""
_DOUBT_SIGMA: Final = 0.2
"""Relative standard deviation of strides that do not close, common to all in a row."""


class Books:
    """Keeps the books of an ankle.

    The first stride of a bout is told with the second: one that stays alone is a leg that was put
    elsewhere, not walking.

    Args:
        params: Of the ankle.
        lever: From pivot to IMU: its uncertainty is common to all strides.
    """

    def __init__(self, params: AnkleParams, lever: Lever) -> None:
        lever_share = params.lever_share_per_m * max(lever.sigma_m)
        self._params = params
        self._shared: Final = math.hypot(params.shared_sigma, lever_share)
        self.path: Final = PathBook(self._shared)
        self._ledger = WalkLedger(
            max_pause_s=params.max_pause_s,
            shared_sigma=self._shared,
            stride_time_sigma_s=params.stride_time_sigma_s,
        )
        self._doubted = 0
        self._waiting: list[Told] = []
        self._usual: list[tuple[float, float]] = []

    @property
    def walking(self) -> bool:
        """Whether a walk is going on."""
        return self._ledger.in_bout

    def begin(self, t_ns: int) -> None:
        """Take the first sample; later ones change nothing."""
        self._ledger.begin(t_ns)

    def stand(self, t_ns: int) -> list[Event]:
        """Let a moment pass in which nobody walks."""
        return self._ledger.advance(t_ns) if self._ledger.in_bout else []

    def stride(self, told: "Told") -> list[Event]:
        """Count a stride that is believed."""
        if self._ledger.in_bout and told.t_ns - self._ledger.bout_end_ns < self._pause_ns:
            return self._count(told)
        if self._waiting and told.start_ns - self._waiting[-1].t_ns > self._pause_ns:
            self._waiting = []
        self._waiting = [*self._waiting, told][-_WAITING:]
        if not self._is_walking():
            return []
        waiting, self._waiting = self._waiting, []
        return [event for stride in waiting for event in self._count(stride)]

    def unseen(self, since_ns: int, t_ns: int, anomaly: str, detail: str) -> list[Event]:
        """Take that a walk went on unseen: at the pace before, where that explains the time."""
        duration_s = (t_ns - since_ns) / NS_PER_S
        said: Event = Anomaly(t_ns=t_ns, anomaly=anomaly, detail=detail)
        cycles = duration_s / self._cycle_s if len(self._usual) >= _STEADY else 0.0
        count = round(cycles)
        if count == 0 or abs(cycles - count) > _CYCLE_OFF or duration_s > self._params.max_filled_s:
            self._ledger.add_unmeasured(duration_s)
            self.path.lose()
            return [said, self._ledger.distance(t_ns)]
        lengths_m = [length for length, _ in self._usual[-_STEADY:]]
        length_m = float(np.median(lengths_m))
        # Had the pace been changing, all of them are wrong by the same.
        changing_m = math.sqrt(count) * float(np.std(lengths_m))
        sigma_m = math.hypot(_FILLED_SIGMA * length_m, changing_m)
        bounds = np.linspace(since_ns, t_ns, count + 1).astype(np.int64).tolist()
        events: list[Event] = [said]
        for start, end in pairwise(bounds):
            events += self._ledger.add_stride(start, end, length_m, sigma_m)
        self.path.lose()
        return events

    def finish(self) -> list[Event]:
        """Take that no more will come."""
        return self._ledger.close_bout()

    def _is_walking(self) -> bool:
        """Return whether enough strides in a row close by themselves and lead the same way."""
        ways = [stride.way for stride in self._waiting]
        clean = [way for way in ways if not way.doubtful]
        if len(clean) >= _CLEAN:
            return _same_way(clean[-_CLEAN:])
        leglike = [way for way in ways if way.pendulum > _LEGLIKE]
        return len(leglike) >= _LEGLIKE_ENOUGH and _same_way(leglike)

    @property
    def _phase_sigma_s(self) -> float:
        return math.hypot(self._params.stride_time_sigma_s, self._params.lift_time_sigma_s)

    @property
    def _pause_ns(self) -> int:
        return round(self._params.max_pause_s * NS_PER_S)

    @property
    def _cycle_s(self) -> float:
        return float(np.median([cycle for _, cycle in self._usual]))

    def _count(self, told: "Told") -> list[Event]:
        way = told.way
        start_ns = max(told.start_ns, self._ledger.bout_end_ns) if self.walking else told.start_ns
        stance_s = max(0.0, (told.lift_ns - start_ns) / NS_PER_S)
        swing_s = (told.t_ns - told.lift_ns) / NS_PER_S
        cycle_s = (way.after.t_ns - way.before.t_ns) / NS_PER_S
        clipped_m = _LOST_BY_CLIPPING_MPS2 * told.clipped_s * cycle_s / 4.0
        self._doubted = self._doubted + 1 if way.doubtful else 0
        # So that the variance of a run of doubtful strides grows as the square of their number.
        doubt_m = _DOUBT_SIGMA * way.length_m * math.sqrt(max(0, 2 * self._doubted - 1))
        sigma_m = math.hypot(way.length_sigma_m, clipped_m, doubt_m)
        events = self._ledger.add_stride(
            start_ns, told.t_ns, way.length_m, sigma_m, shared_sigma=self._shared_sigma(way),
            stance_duration_s=stance_s, swing_duration_s=swing_s,
        )  # fmt: skip
        self._usual = [*self._usual, (way.length_m, cycle_s)][-_REMEMBERED:]
        events = [self._filled_in(event, told) for event in events]
        events.append(self.path.pose(told.t_ns, start_ns, way))
        if self._doubted == _UNTRUSTED:
            detail = (
                "strides do not close: a range is exceeded, samples are lost or the strap slips"
            )
            events.append(Anomaly(t_ns=told.t_ns, anomaly="distance-untrusted", detail=detail))
        if told.clipped_s:
            detail = f"readings at the end of their range for {told.clipped_s:.2f} s of this stride"
            events.append(Anomaly(t_ns=told.t_ns, anomaly="sensor-clipped", detail=detail))
        return events

    def _shared_sigma(self, way: Way) -> float:
        stairs = self._params.stairs_sigma if self._on_stairs(way) else 0.0
        return math.hypot(self._shared, stairs)

    def _on_stairs(self, way: Way) -> bool:
        return abs(way.height_m) > self._params.stairs_height_m

    def _filled_in(self, event: Event, told: "Told") -> Event:
        if not isinstance(event, Stride):
            return event
        up_m = told.way.height_m
        on_stairs = self._on_stairs(told.way)
        return event.model_copy(
            update={
                "lift_t_ns": told.lift_ns,
                "stance_duration_sigma_s": self._phase_sigma_s,
                "swing_duration_sigma_s": self._phase_sigma_s,
                "height_change_m": up_m,
                "height_change_sigma_m": told.way.height_sigma_m,
                "terrain": ("stairs-up" if up_m > 0 else "stairs-down") if on_stairs else "level",
            }
        )


def _same_way(ways: Sequence[Way]) -> bool:
    """Return whether each way leads on where the one before led."""
    for before, after in pairwise(ways):
        (x, y), (u, v) = before.step_n[:2], after.step_n[:2]
        if abs(math.atan2(x * v - y * u, x * u + y * v)) > _TURN_MAX_RAD:
            return False
    return True


class Told:
    """A stride that is believed, with the times of its cycle.

    Args:
        way: From stance to stance.
        start_ns: The contact before it, or where standing ended.
        lift_ns: When the foot left the floor.
        t_ns: When it came down again.
        clipped_s: For how long a reading was at the end of its range.
    """

    def __init__(self, way: Way, start_ns: int, lift_ns: int, t_ns: int, clipped_s: float) -> None:
        self.way = way
        self.start_ns = start_ns
        self.lift_ns = lift_ns
        self.t_ns = t_ns
        self.clipped_s = clipped_s


class PathBook:
    """Where the strides lead: x where the first one went.

    Args:
        shared_sigma: Relative standard deviation common to all strides.
    """

    def __init__(self, shared_sigma: float) -> None:
        self._shared = shared_sigma
        self.lose()

    def lose(self) -> None:
        """Begin a new path at the next stride."""
        self._since_ns: int | None = None
        self._turn: Floats = np.eye(3)
        self._pos = np.zeros(3)
        self._walked_m = 0.0
        self._variance = np.zeros(3)
        self._heading_sigma0 = self._aside0 = 0.0

    def pose(self, t_ns: int, start_ns: int, way: Way) -> Pose:
        """Return the pose after a stride."""
        course = math.atan2(way.step_n[1], way.step_n[0])
        aside = way.across_sigma_m / max(way.length_m, 1e-3)
        if self._since_ns is None:
            self._since_ns, self._heading_sigma0 = start_ns, way.before.heading_sigma_rad
            self._aside0 = aside
            c, s = math.cos(course), math.sin(course)
            self._turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        step = self._turn @ way.step_n
        drift = math.sqrt(max(0.0, way.after.heading_sigma_rad**2 - self._heading_sigma0**2))
        self._pos = self._pos + step
        self._walked_m += way.length_m
        self._variance += (way.length_sigma_m**2, way.across_sigma_m**2, way.height_sigma_m**2)
        own, away = np.sqrt(self._variance), float(np.hypot(*self._pos[:2]))
        scale_m = self._shared * away
        return Pose(
            t_ns=t_ns,
            since_t_ns=self._since_ns,
            pos_x_m=float(self._pos[0]),
            pos_x_sigma_m=math.hypot(own[0], scale_m, drift * self._pos[1]),
            pos_y_m=float(self._pos[1]),
            pos_y_sigma_m=math.hypot(own[1], scale_m, drift * self._pos[0], self._aside0 * away),
            height_m=float(self._pos[2]),
            height_sigma_m=math.hypot(own[2], 0.5 * self._shared * self._walked_m),
            heading_rad=math.atan2(step[1], step[0]),
            heading_sigma_rad=math.hypot(drift, aside, self._aside0),
        )
