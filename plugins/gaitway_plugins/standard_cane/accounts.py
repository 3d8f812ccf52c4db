"""From placements to strides: which of them count, and what is said of those that don't."""

import math
from collections import deque
from typing import Final, assert_never

import numpy as np

from gaitway.api import NS_PER_S, Anomaly, Event, Stride
from gaitway.estimation import Break, WalkLedger
from gaitway_plugins.standard_cane.navigator import Way
from gaitway_plugins.standard_cane.params import StandardCaneParams
from gaitway_plugins.standard_cane.placements import Clip, Landing, Lift, Lost, Record

_LEVER_SHARE_PER_M: Final = 1.5
"""By how much of the distance, for each metre by which the tip is nearer or farther than told: the
point that is taken for the tip leans forward in stance (0.7 of the error a stride), and its
velocity then is taken for zero (0.4 more); a stride is 0.7 m."""
_FILL_SIGMA: Final = 0.15
"""Relative standard deviation of one placement about those around it, at least."""
_MOVING_MPS: Final = 0.1
_SLIDING_MPS2: Final = 3.0
"""A tip that slides on the floor is accelerated less than one that is swung."""
_SWING_SHARE: Final = 0.43
"""Of a cycle, where the stance before was not seen."""
_NEIGHBOURS: Final = 5
"""Placements before a gap that tell what an unseen one was like."""


class Accounts:
    """Keeps the books of a standard cane: a placement is a stride when the cane walked all the way.

    Takes samples and records in the order of time. Time that may have been walking is counted as
    unmeasured when the way could not be told.

    Args:
        params: Of the cane.
    """

    def __init__(self, params: StandardCaneParams) -> None:
        self._params = params
        self._ledger = WalkLedger(
            max_pause_s=params.max_pause_s,
            shared_sigma=math.hypot(
                params.shared_sigma, _LEVER_SHARE_PER_M * params.imu_to_tip_sigma_m
            ),
            stride_time_sigma_s=params.stride_time_sigma_s,
        )
        self._begun = False
        self._now_ns = 0
        self._walking_since_ns: int | None = None
        self._contact_ns: int | None = None
        self._lift_ns: int | None = None
        self._unseen_s = 0.0
        self._first_lift_ns: int | None = None
        self._told = False
        self._recent: deque[tuple[float, float]] = deque(maxlen=_NEIGHBOURS)

    def sample(self, t_ns: int, walking: bool) -> list[Event]:
        """Let a sample pass, of which the walking test says whether it may be walking."""
        self._now_ns = t_ns
        if not walking:
            self._walking_since_ns = None
        elif self._walking_since_ns is None:
            self._walking_since_ns = t_ns
        # A swing is no pause: it began within the bout if it ends within this.
        events = self._ledger.advance(t_ns - round(self._params.max_swing_s * NS_PER_S))
        return [*events, *self._give_up()] if events else []

    def record(self, record: Record) -> list[Event]:
        """Take what happened at the sample that has just passed."""
        match record:
            case Lift():
                self._lift_ns = self._now_ns
                return []
            case Clip():
                detail = "an axis was at the end of its range; this placement is less certain"
                return [Anomaly(t_ns=self._now_ns, anomaly="sensor-clipped", detail=detail)]
            case Lost():
                return self._lost(record)
            case Landing():
                return self._landed(record)
            case _:
                assert_never(record)

    def broken(self, gap: Break) -> list[Event]:
        """Take that samples are missing after the one that has just passed."""
        lift_ns, begun = self._lift_ns, self._walking_since_ns is not None
        self._lift_ns = self._contact_ns = self._walking_since_ns = None
        if not self._ledger.in_bout and not (begun and lift_ns is not None):
            return []
        self._unseen_s += gap.duration_s
        if lift_ns is not None:
            self._unseen_s += (gap.t_ns - lift_ns) / NS_PER_S
            self._first_lift_ns = None if self._ledger.in_bout else lift_ns
        detail = f"{gap.duration_s:.2f} s of samples missing while walking"
        return [Anomaly(t_ns=gap.t_ns, anomaly="gap-in-stride", detail=detail)]

    def finish(self) -> list[Event]:
        """Take that no more will come."""
        return [*self._give_up(), *self._ledger.close_bout()]

    def _lost(self, lost: Lost) -> list[Event]:
        lift_ns, self._lift_ns, self._contact_ns = self._lift_ns, None, None
        if not self._ledger.in_bout or lift_ns is None:
            return []
        self._unseen_s += (self._now_ns - lift_ns) / NS_PER_S
        if self._told:
            return []
        self._told = True
        dragged = lost.speed_mps > _MOVING_MPS and lost.force_mps2 < _SLIDING_MPS2
        name = "dragging" if dragged else "no-contact"
        detail = (
            "the tip moves and does not come to rest: is the cane dragged or carried? "
            "The distance is not measured until it stands"
        )
        return [Anomaly(t_ns=self._now_ns, anomaly=name, detail=detail)]

    def _landed(self, landing: Landing) -> list[Event]:
        lift_ns, self._lift_ns = self._lift_ns, None
        events: list[Event] = []
        if not self._begun:
            self._begun = True
            self._ledger.begin(self._now_ns)
        elif lift_ns is not None and landing.way is not None:
            if landing.way.length_m < self._params.min_stride_m:
                return []
            events = self._placed(landing.way, lift_ns)
        self._contact_ns = self._now_ns
        return events

    def _placed(self, way: Way, lift_ns: int) -> list[Event]:
        if not self._walked(way, lift_ns):
            if self._ledger.in_bout and self._walking_since_ns is not None:
                self._unseen_s += (self._now_ns - lift_ns) / NS_PER_S
            return []
        events = self._fill(way, lift_ns) if self._unseen_s else []
        now_ns, start_ns, stance_s = self._now_ns, lift_ns, None
        if self._contact_ns is not None:
            rest_s = (lift_ns - self._contact_ns) / NS_PER_S
            if rest_s <= self._params.max_pause_s:
                start_ns, stance_s = self._contact_ns, rest_s
        swing_s = (now_ns - lift_ns) / NS_PER_S
        cycle_s = swing_s / _SWING_SHARE if stance_s is None else stance_s + swing_s
        if stance_s is None or self._ledger.in_bout:
            self._recent.append((way.length_m, cycle_s))
        self._told = False
        stride = self._ledger.add_stride(
            start_ns, now_ns, way.length_m, way.sigma_m,
            stance_duration_s=stance_s, swing_duration_s=swing_s,
        )  # fmt: skip
        return [*events, *(_told(event, lift_ns, way) for event in stride)]

    def _walked(self, way: Way, lift_ns: int) -> bool:
        """Return whether a placement is a stride: what a person does who walks, and no other."""
        p, since_ns = self._params, self._walking_since_ns
        return (
            since_ns is not None
            and since_ns <= lift_ns
            and p.min_stride_m <= way.length_m <= p.max_stride_m
            and way.sigma_m <= p.max_stride_sigma_m
            and abs(way.rise_m) <= p.max_rise_m
            and way.clearance_m >= p.min_clearance_m + way.sigma_m
            and way.swung >= p.min_swung_per_m * way.length_m
        )

    def _fill(self, way: Way, lift_ns: int) -> list[Event]:
        """Fill in the placements that went unseen before this one: since the last, or the first."""
        start_ns, end_ns = self._ledger.bout_end_ns, self._now_ns
        length_m, cycle_s = way.length_m, (end_ns - lift_ns) / NS_PER_S / _SWING_SHARE
        seen = 1
        if not self._ledger.in_bout:
            # The walk began in the gap, with a lift that was seen: from lift to lift.
            if self._first_lift_ns is None:
                return self._give_up()
            start_ns, end_ns, seen = self._first_lift_ns, lift_ns, 0
        elif self._recent:
            length_m, cycle_s = (float(x) for x in np.median(np.array(self._recent), axis=0))
        cycles = (end_ns - start_ns) / NS_PER_S / cycle_s
        unseen = round(cycles) - seen
        if unseen > self._params.max_filled:
            return self._give_up()
        sigma_m = length_m * math.hypot(_FILL_SIGMA, cycles - round(cycles))
        step_ns = (end_ns - start_ns) // max(1, unseen + seen)
        events: list[Event] = []
        for _ in range(unseen):
            events += self._ledger.add_stride(
                start_ns, start_ns + step_ns, length_m, sigma_m, interpolated=True
            )
            start_ns += step_ns
        if unseen > 0:
            self._contact_ns = min(start_ns, lift_ns)
        self._unseen_s = 0.0
        return events

    def _give_up(self) -> list[Event]:
        """Count as unmeasured what went unseen and can't be filled in."""
        if not self._unseen_s:
            return []
        self._ledger.add_unmeasured(self._unseen_s)
        detail = f"{self._unseen_s:.1f} s that may have been walking gave no measure"
        self._unseen_s = 0.0
        self._first_lift_ns = None
        told = Anomaly(t_ns=self._now_ns, anomaly="distance-untrusted", detail=detail)
        return [told, self._ledger.distance(self._now_ns)]


def _told(event: Event, lift_ns: int, way: Way) -> Event:
    """Return a stride with what the ledger does not keep."""
    if not isinstance(event, Stride):
        return event
    return event.model_copy(
        update={
            "lift_t_ns": lift_ns,
            "height_change_m": way.rise_m,
            "height_change_sigma_m": way.rise_sigma_m,
        }
    )
