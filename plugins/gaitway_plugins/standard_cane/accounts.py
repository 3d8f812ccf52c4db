"""From placements to strides: which of them count, and what is said of those that don't."""

import math
from collections import deque
from typing import Final, assert_never

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
        self._gap_s = 0.0
        self._recent: deque[tuple[float, float]] = deque(maxlen=_NEIGHBOURS)

    def sample(self, t_ns: int, walking: bool) -> list[Event]:
        """Let a sample pass, of which the walking test says whether it may be walking."""
        self._now_ns = t_ns
        if not walking:
            self._walking_since_ns = None
        elif self._walking_since_ns is None:
            self._walking_since_ns = t_ns
        return self._ledger.advance(t_ns - round(self._params.max_swing_s * NS_PER_S))

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
                return self._lost()
            case Landing():
                return self._landed(record)
            case _:
                assert_never(record)

    def broken(self, gap: Break) -> list[Event]:
        """Take that samples are missing after the one that has just passed."""
        return []

    def finish(self) -> list[Event]:
        """Take that no more will come."""
        return self._ledger.close_bout()

    def _lost(self) -> list[Event]:
        self._lift_ns = self._contact_ns = None
        return []

    def _landed(self, landing: Landing) -> list[Event]:
        lift_ns, self._lift_ns = self._lift_ns, None
        events: list[Event] = []
        if not self._begun:
            self._begun = True
            self._ledger.begin(self._now_ns)
        elif lift_ns is not None and landing.way is not None:
            events = self._placed(landing.way, lift_ns)
            if landing.way.length_m < self._params.min_stride_m:
                return events
        self._contact_ns = self._now_ns
        return events

    def _placed(self, way: Way, lift_ns: int) -> list[Event]:
        p, now_ns, since_ns = self._params, self._now_ns, self._walking_since_ns
        swing_s = (now_ns - lift_ns) / NS_PER_S
        if since_ns is None or since_ns > lift_ns or way.length_m < p.min_stride_m:
            return []
        if way.length_m > p.max_stride_m or way.sigma_m > p.max_stride_sigma_m:
            return []
        if abs(way.rise_m) > p.max_rise_m:
            return []
        start_ns, stance_s = lift_ns, None
        if self._contact_ns is not None:
            rest_s = (lift_ns - self._contact_ns) / NS_PER_S
            if rest_s <= p.max_pause_s:
                start_ns, stance_s = self._contact_ns, rest_s
        events = self._ledger.add_stride(
            start_ns, now_ns, way.length_m, way.sigma_m,
            stance_duration_s=stance_s, swing_duration_s=swing_s,
        )  # fmt: skip
        return [_told(event, lift_ns, way) for event in events]


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
