"""From placements to strides: which of them count, and what is said of those that don't."""

import math
from itertools import pairwise
from typing import NamedTuple, assert_never

import numpy as np
from numpy.typing import NDArray

from gaitway.api import NS_PER_S, Anomaly, Event, Ints, Stride
from gaitway.estimation import Break, StrideInterpolation, WalkLedger
from gaitway_plugins.quad_cane.checks import MountingCheck
from gaitway_plugins.quad_cane.navigator import Displacement
from gaitway_plugins.quad_cane.params import QuadCaneParams
from gaitway_plugins.quad_cane.placements import Clip, Landing, Lift, Record


class _Placement(NamedTuple):
    """A placement that counts as a stride."""

    start_ns: int
    end_ns: int
    way: Displacement
    stance_s: float | None
    swing_s: float


class Accounts:
    """Keeps the books of a quad cane: a placement is a stride when the cane walked all the way.

    Takes samples and records in the order of time. Time that may have been walking is counted as
    unmeasured when the way could not be told.

    Args:
        params: Of the cane.
    """

    def __init__(self, params: QuadCaneParams) -> None:
        self._params = params
        self._checks = MountingCheck()
        self._ledger = WalkLedger(
            max_pause_s=params.max_pause_s,
            shared_sigma=params.shared_sigma,
            stride_time_sigma_s=params.stride_time_sigma_s,
        )
        self._interpolation = StrideInterpolation()
        self._first: _Placement | None = None
        self._begun = False
        self._found_ns: int | None = None
        self._doubtful = False
        self._now_ns = 0
        self._walking_since_ns: int | None = None
        self._contact_ns: int | None = None
        self._lift_ns: int | None = None
        self._told = False
        self._unmeasured_ns = 0
        self._gap_s = 0.0
        self._gap_in_bout = False
        self._gap_hid = False

    def pass_by(self, t_ns: Ints, walking: NDArray[np.bool_]) -> list[Event]:
        """Let samples pass by.

        Args:
            t_ns: Their times, shape (n,).
            walking: Which may be walking, as the walking test says, shape (n,).
        """
        events: list[Event] = []
        edges = [0, *(np.flatnonzero(np.diff(walking)) + 1).tolist(), len(t_ns)]
        for start, stop in pairwise(edges):
            if stop > start:
                events += self._pass_alike(t_ns[start:stop], bool(walking[start]))
        return events

    def _pass_alike(self, t_ns: Ints, walking: bool) -> list[Event]:
        """Let samples pass by of which the walking test says the same."""
        before_ns, self._now_ns = self._now_ns, int(t_ns[-1])
        if not walking:
            self._walking_since_ns = None
        elif self._walking_since_ns is None:
            self._walking_since_ns = int(t_ns[0])
        if walking and (self._lift_ns is not None or self._gap_s):
            self._unmeasured_ns += self._now_ns - before_ns
        if self._lift_ns is None:
            return self._ledger.advance(self._now_ns)
        return self._without_contact(t_ns, self._lift_ns)

    def record(self, record: Record) -> list[Event]:
        """Take what happened at the sample that has just passed."""
        match record:
            case Lift():
                self._lift_ns = self._now_ns
                least_ns = round(self._params.min_found_stance_s * NS_PER_S)
                found_ns, self._found_ns = self._found_ns, None
                self._doubtful = found_ns is not None and self._now_ns - found_ns < least_ns
                return []
            case Clip():
                detail = "an axis was at the end of its range; this placement is less certain"
                return [Anomaly(t_ns=self._now_ns, anomaly="sensor-clipped", detail=detail)]
            case Landing():
                return self._landed(record)
            case _:
                assert_never(record)

    def broken(self, gap: Break) -> list[Event]:
        """Take that samples are missing after the one that has just passed."""
        if not self._begun:
            return []
        self._now_ns += round(gap.duration_s * NS_PER_S)
        walking, self._walking_since_ns = self._walking_since_ns is not None, None
        if self._lift_ns is None:
            self._gap_s += gap.duration_s
            self._gap_in_bout |= self._ledger.in_bout
        if walking:
            self._unmeasured_ns += round(gap.duration_s * NS_PER_S)
        if not walking or self._lift_ns is None or self._told:
            return []
        self._told = self._gap_hid = True
        return [_gap_in_stride(gap.t_ns, gap.duration_s)]

    def finish(self) -> list[Event]:
        """Take that no more will come."""
        events = self._count_unmeasured() if self._told else []
        self._told = False
        if self._first is not None:
            self._ledger.add_unmeasured(self._first.swing_s)
            self._first = None
        return [*events, *self._ledger.close_bout()]

    def _without_contact(self, t_ns: Ints, lift_ns: int) -> list[Event]:
        """Return what a swing that does not end means: no pause within it, but no bout for ever."""
        max_swing_ns = round(self._params.max_swing_s * NS_PER_S)
        if self._now_ns - lift_ns <= max_swing_ns:
            return []
        since_ns = self._walking_since_ns
        told_after_ns = None if since_ns is None else max(since_ns, lift_ns) + max_swing_ns
        if self._told or told_after_ns is None or self._now_ns <= told_after_ns:
            return self._ledger.advance(self._now_ns)
        self._told = True
        told_ns = int(t_ns[np.searchsorted(t_ns, told_after_ns, side="right")])
        events = self._ledger.advance(told_ns)
        detail = (
            f"no contact for {self._params.max_swing_s:g} s: is the cane dragged or carried? "
            "The distance is not measured until it stands"
        )
        events.append(Anomaly(t_ns=told_ns, anomaly="no-contact", detail=detail))
        return [*events, *self._ledger.advance(self._now_ns)]

    def _landed(self, landing: Landing) -> list[Event]:
        lift_ns, self._lift_ns = self._lift_ns, None
        events: list[Event] = []
        if not landing.seen and not landing.as_before:
            self._found_ns = self._now_ns
        if not self._begun:
            self._begun = True
            self._ledger.begin(self._now_ns)
        elif lift_ns is None:
            events = self._stood_through_gap(landing)
        elif landing.way is not None:
            swing_s = (self._now_ns - lift_ns) / NS_PER_S
            events = [
                *self._checks.placement(
                    self._now_ns, landing.tilt_rad, landing.way.length_m, swing_s
                ),
                *self._placed(landing.way, lift_ns),
            ]
        elif self._told:
            events = self._unmeasured()
        put_right = landing.way is not None and landing.way.length_m < self._params.min_stride_m
        if not put_right:
            self._contact_ns = self._now_ns if landing.seen else None
        self._told = self._gap_in_bout = self._gap_hid = False
        self._unmeasured_ns = 0
        self._gap_s = 0.0
        return events

    def _stood_through_gap(self, landing: Landing) -> list[Event]:
        short = self._gap_s <= self._params.max_standing_gap_s
        if landing.as_before and (short or not self._gap_in_bout):
            return []
        if not self._unmeasured_ns:
            return []
        self._gap_hid = True
        return [_gap_in_stride(self._now_ns, self._gap_s), *self._unmeasured()]

    def _placed(self, way: Displacement, lift_ns: int) -> list[Event]:
        p, now_ns, since_ns = self._params, self._now_ns, self._walking_since_ns
        swing_s = (now_ns - lift_ns) / NS_PER_S
        if since_ns is None or since_ns > lift_ns or way.length_m < p.min_stride_m:
            return []
        if now_ns - since_ns < p.min_walking_s * NS_PER_S:
            return []
        if way.length_m > p.max_stride_m or way.sigma_m > p.max_stride_sigma_m:
            self._unmeasured_ns = now_ns - lift_ns
            detail = f"{way.length_m:.2f} m +- {way.sigma_m:.2f} m is not believed and not counted"
            told = Anomaly(t_ns=now_ns, anomaly="implausible-stride", detail=detail)
            return [told, *self._count_unmeasured()]
        start_ns, stance_s = lift_ns, None
        if self._contact_ns is not None:
            rest_s = (lift_ns - self._contact_ns) / NS_PER_S
            if rest_s <= p.max_pause_s:
                start_ns, stance_s = self._contact_ns, rest_s
                self._interpolation.learn(rest_s + swing_s, way.length_m)
        if not self._ledger.in_bout:
            self._interpolation.forget()
        return self._count(_Placement(start_ns, now_ns, way, stance_s, swing_s))

    def _count(self, placement: "_Placement") -> list[Event]:
        """Count a placement; one from a stance that was hardly any waits for a second.

        A cane that is waved about is still for a moment now and then, in the air.
        """
        first, self._first = self._first, None
        if self._doubtful and not self._ledger.in_bout:
            self._first = placement
        if first is None:
            return [] if self._first else self._counted(placement)
        if placement.start_ns - first.end_ns > self._params.max_pause_s * NS_PER_S:
            self._ledger.add_unmeasured(first.swing_s)
            return [] if self._first else self._counted(placement)
        self._first = None
        return [*self._counted(first), *self._counted(placement)]

    def _counted(self, placement: "_Placement") -> list[Event]:
        way = placement.way
        events = self._ledger.add_stride(
            placement.start_ns, placement.end_ns, way.length_m, way.sigma_m,
            stance_duration_s=placement.stance_s, swing_duration_s=placement.swing_s,
        )  # fmt: skip
        return [_with_lean(event, way.lean_sigma_m) for event in events]

    def _unmeasured(self) -> list[Event]:
        """Return what is told of a time in which samples were missing or no contact was seen."""
        lost = None
        if self._gap_hid and self._ledger.in_bout:
            # Where the cane was found to stand it had stood for the window that showed it.
            contact_ns = self._now_ns - round(self._params.resume_window_s * NS_PER_S)
            lost = self._interpolation.between(self._ledger.bout_end_ns, contact_ns)
        if lost is None:
            return self._count_unmeasured()
        self._ledger.add_unmeasured(self._unmeasured_ns / NS_PER_S, speed_sigma_mps=0.0)
        events: list[Event] = []
        for start_ns, end_ns in pairwise(lost.bounds_ns):
            events += self._ledger.add_stride(
                start_ns, end_ns, lost.length_m, lost.sigma_m, interpolated=True
            )
        return events

    def _count_unmeasured(self) -> list[Event]:
        self._ledger.add_unmeasured(self._unmeasured_ns / NS_PER_S)
        return [self._ledger.distance(self._now_ns)]


def _gap_in_stride(t_ns: int, gap_s: float) -> Anomaly:
    detail = f"{gap_s:.2f} s of samples missing while walking; what they hid is not measured"
    return Anomaly(t_ns=t_ns, anomaly="gap-in-stride", detail=detail)


def _with_lean(event: Event, lean_sigma_m: float) -> Event:
    """Return a stride with what only its own length suffers from, and not the distance."""
    if not isinstance(event, Stride):
        return event
    speed_sigma_mps = math.hypot(
        event.walking_speed_sigma_mps, lean_sigma_m / event.stride_duration_s
    )
    return event.model_copy(
        update={
            "stride_length_sigma_m": math.hypot(event.stride_length_sigma_m, lean_sigma_m),
            "walking_speed_sigma_mps": speed_sigma_mps,
        }
    )
