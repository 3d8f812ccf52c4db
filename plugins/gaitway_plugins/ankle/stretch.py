"""Samples with no break between them: quiet parts, anchors, and the ways from one to the next."""

from typing import Final, NamedTuple

import numpy as np

from gaitway.api import Event
from gaitway.estimation import STANDARD_GRAVITY_MPS2, ClipDetector, ImuSample
from gaitway_plugins.ankle.books import Books, Told
from gaitway_plugins.ankle.lever import Lever
from gaitway_plugins.ankle.navigator import Anchor, Navigator
from gaitway_plugins.ankle.params import AnkleParams
from gaitway_plugins.ankle.quiet import QuietDetector
from gaitway_plugins.ankle.tracing import Tracer
from gaitway_plugins.ankle.track import Track
from gaitway_plugins.ankle.watch import Watch
from gaitway_plugins.ankle.way import Way, pendulum_share, swing_of, swung_rad

_SETTLED_S: Final = 2.0
"""Standing so long, small shifts of the foot are no part of a stride."""

_REFUSED: Final = 2
"""After so many long quiet parts in a row that can't be, the filter is begun anew; one may be the
middle of a swing."""
_VAGUE: Final = 0.6
"""A stride is not believed whose standard deviation is a greater share of its length."""


class Loss(NamedTuple):
    """Walking that gives no measure.

    Attributes:
        since_ns: The last moment on the floor that is known.
        anomaly: Name of what happened.
        detail: One line for a person.
    """

    since_ns: int
    anomaly: str
    detail: str


class Stretch:
    """Follows the ankle through samples with no break between them.

    Args:
        params: Of the ankle.
        period_s: Of the samples.
        lever: From pivot to IMU.
        books: Outlive the stretch.
        tracer: Where per-sample estimates go, if anywhere.

    Attributes:
        navigator: The filter.
        lost: Walking under way that is not measured.
        strides: How many there were.
        stood: Whether the last quiet part was that of a foot on a floor.
        tracer: As given.
    """

    def __init__(
        self,
        params: AnkleParams,
        period_s: float,
        lever: Lever,
        books: Books,
        tracer: Tracer | None = None,
    ) -> None:
        self.navigator: Final = Navigator(params, period_s, lever)
        self.lost: Loss | None = None
        self.strides = 0
        self.stood = False
        self.tracer = tracer
        self._params = params
        self._period_s = period_s
        self._lever = lever
        self._books = books
        self._track = Track(period_s)
        self._clip = ClipDetector()
        self._detector = QuietDetector(params, period_s)
        self._watch = Watch(params, period_s)
        self._chunk: Final = max(2, round(params.chunk_s / period_s))
        self._patience: Final = round(params.standing_after_s / period_s)
        self._from: Anchor | None = None
        self._covariance = np.zeros((3, 3))
        self._doubtful = False
        self._contact_ns: int | None = None
        self._rested_to = 0
        self._refused = 0

    def push(self, sample: ImuSample) -> list[Event]:
        """Take the next sample; return what it makes known."""
        self._books.begin(sample.t_ns)
        self._track.push(sample._replace(clipped=self._clip.push(sample)))
        events: list[Event] = self._watch.push(sample)
        quiet = self._detector.push(sample.accel_d, sample.gyro_d)
        if quiet is not None:
            begin = max(quiet.begin, self._rested_to, self._track.first)
            if self._is_footing(begin, quiet.end):
                first, last = quiet.valley
                valley = (max(first, self._rested_to, self._track.first), last)
                events += self._arrive(begin, quiet.end, valley)
            return events
        return events + self._stand()

    def finish(self) -> list[Event]:
        """Return what is known at the end of the input."""
        self._detector.finish()
        begin, end = max(self._detector.quiet_since, self._rested_to), self._track.end - 1
        events: list[Event] = []
        if not self._detector.moving and end - begin >= self._chunk // 2:
            events = self._arrive(begin, end)
        return events + self._break_off()

    def break_off(self) -> tuple[list[Event], int | None]:
        """Take that samples are missing now; return since when a walk is not measured.

        What stands is standing: nothing of a walk is lost then.
        """
        since_ns = None
        if self.lost is not None:
            since_ns = self.lost.since_ns
        elif not self._resting and self._from is not None and self._books.walking:
            since_ns = self._from.t_ns
        return self._break_off(), since_ns

    def _break_off(self) -> list[Event]:
        if self.tracer is not None:
            self.tracer.unknown(self._track, self._track.first, self._track.end)
        return []

    def _lacking_s(self) -> float:
        """Return for how long no anchor was found."""
        if self._from is None:
            return 0.0
        return (self._track.end - 1 - self._from.index) * self._period_s

    def _stand(self) -> list[Event]:
        """Take in standing, a chunk at a time."""
        d = self._detector
        begin = max(d.quiet_since, self._rested_to)
        if d.index + 1 - begin < (self._chunk if self._resting else self._needed):
            return []
        return self._arrive(begin, d.index) + self._books.stand(self._track.t_ns(d.index))

    @property
    def _resting(self) -> bool:
        return self._rested_to > self._detector.quiet_since

    @property
    def _needed(self) -> int:
        return self._patience if self.navigator.started else self._chunk

    def _arrive(self, begin: int, end: int, valley: tuple[int, int] | None = None) -> list[Event]:
        """Take in a quiet part: of a valley between two swings; of standing where there is none."""
        still = valley is None
        if still:
            self._rested_to = end + 1
        if not self.navigator.started:
            return self._start(begin, end, still=still)
        nav = self.navigator
        anchor = nav.visit(self._track, begin, end, valley)
        if anchor is None or nav.leaning_rad() > self._params.max_lean_rad:
            return self._refuse(begin, end, still=still)
        self.stood = True
        self._refused = 0
        return self._reach(anchor)

    def _is_footing(self, begin: int, end: int) -> bool:
        """Return whether a quiet part may be that of a stance: long and unaccelerated."""
        if (end - begin) * self._period_s < self._params.min_quiet_s:
            return False
        force = float(np.linalg.norm(self._track.accel_d(begin, end + 1).mean(axis=0)))
        return abs(force - STANDARD_GRAVITY_MPS2) < self._params.quiet_force_off_mps2

    def _start(self, begin: int, end: int, *, still: bool) -> list[Event]:
        if not still and (end - begin) * self._period_s < self._params.sure_quiet_s:
            return []
        self.stood = True
        self._from = self.navigator.start(self._track, begin, end, still=still)
        self._covariance[:] = 0.0
        self._contact_ns, self._doubtful = None, False
        self._refused = 0
        self._trace(self._from)
        return []

    def _refuse(self, begin: int, end: int, *, still: bool) -> list[Event]:
        """Take that the velocity found is none of a foot on a floor."""
        long = (end - begin) * self._period_s >= self._params.sure_quiet_s
        self._refused += long
        self.stood = False
        lacking = self._lacking_s() >= self._params.max_stride_s
        if not still and self._refused < _REFUSED and not lacking:
            return []
        self._lose("no-footing", "the leg did not move as over a foot on the floor")
        self.navigator.lose(self._track.first - 1)
        return self._start(begin, end, still=still)

    def _lose(self, anomaly: str, detail: str) -> None:
        if self.lost is None and self._from is not None and self._books.walking:
            self.lost = Loss(self._from.t_ns, anomaly, detail)

    def _reach(self, anchor: Anchor) -> list[Event]:
        assert self._from is not None
        before = self._from
        events = self._settle(before.t_ns)
        self._covariance += anchor.covariance
        self._doubtful |= anchor.doubtful
        path = self.navigator.path
        gyro = self._track.gyro_d(anchor.index + 1 - len(path), anchor.index + 1)
        lift, contact, peak = swing_of(path, gyro, self._lever, self._params)
        first = anchor.index + 1 - len(path)
        step_n = anchor.pivot_n - before.pivot_n
        turning = gyro - self.navigator.kf.gyro_bias_d
        arc_rad = swung_rad(path, turning, step_n, self._period_s)
        way = Way(
            before, anchor, step_n, self._covariance.copy(), first + lift, first + contact, peak,
            pendulum_share(path, gyro, step_n), arc_rad, self._doubtful,
        )  # fmt: skip
        if self._is_stride(way):
            events += self._stride(way)
        elif self._settled(anchor) or self._lacking_s() > _SETTLED_S:
            events += self._pause(anchor)
        else:
            self._trace(anchor)
            return events
        self._trace(anchor)
        self._from = anchor
        self._covariance[:] = 0.0
        return events

    def _settle(self, t_ns: int) -> list[Event]:
        """Take that a foot stood on a floor at t_ns, after what was lost."""
        lost, self.lost = self.lost, None
        if lost is None or t_ns <= lost.since_ns:
            return []
        return self._books.unseen(lost.since_ns, t_ns, lost.anomaly, lost.detail)

    def _settled(self, anchor: Anchor) -> bool:
        assert self._from is not None
        return (anchor.index - self._from.index) * self._period_s > _SETTLED_S

    def _pause(self, anchor: Anchor) -> list[Event]:
        self._contact_ns, self._doubtful = None, False
        return self._books.stand(anchor.t_ns)

    def _is_stride(self, way: Way) -> bool:
        p = self._params
        return (
            p.min_stride_m <= way.length_m <= p.max_stride_m
            and way.peak_mps >= p.min_swing_speed_mps
            and (self._books.walking or self._is_leglike(way))
            and (way.contact - way.lift) * self._period_s <= p.max_stride_s
            and way.length_sigma_m < _VAGUE * way.length_m
        )

    def _is_leglike(self, way: Way) -> bool:
        """Return whether what moved turned as a leg that makes such a stride has to."""
        p = self._params
        least_rad = max(p.min_arc_rad, p.min_arc_radpm * way.length_m)
        return way.pendulum >= p.min_pendulum_share and way.arc_rad >= least_rad

    def _stride(self, way: Way) -> list[Event]:
        start_ns = self._contact_ns
        if start_ns is None:
            start_ns = way.before.t_ns
        lift_ns, contact_ns = self._track.t_ns(way.lift), self._track.t_ns(way.contact)
        clipped_s = self._track.clipped(way.lift, way.contact) * self._period_s
        self._contact_ns = contact_ns
        told = Told(way, min(start_ns, lift_ns), lift_ns, contact_ns, clipped_s)
        self._doubtful = False
        self.strides += 1
        events = self._watch.stride(way)
        return [*events, *self._books.stride(told)]

    def _trace(self, anchor: Anchor) -> None:
        path = self.navigator.take_path()
        if self.tracer is not None:
            self.tracer.write(self._track, path, anchor, self._lever)
        self._forget(anchor.index)

    def _forget(self, index: int) -> None:
        self._track.drop_before(min(index, self._track.end - 1))
