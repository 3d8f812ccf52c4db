"""The crutch tip's estimator: the stages put together."""

from collections import deque
from collections.abc import Sequence
from typing import Final

import numpy as np

from gaitway.api import EstimatorInput, Event, Floats, SampleBatch, Trace
from gaitway.estimation import Break, Saveable
from gaitway_plugins.crutch_tip.books import Books, Pitches
from gaitway_plugins.crutch_tip.checks import Checks, change
from gaitway_plugins.crutch_tip.force import ContactDetector, Edge
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.stances import ForceMeter, Stance, kept_samples, smoothing_samples
from gaitway_plugins.crutch_tip.stream import FORCE, GYRO_D, UP_D, Rows, Stream
from gaitway_plugins.crutch_tip.trackers import make_tracker

CHUNK_S: Final = 0.1
"""Samples are worked on in chunks of this, counted from the beginning of a stretch, so that it does
not matter in which batches they come."""


class CrutchTipEstimator(Saveable):
    """Pitch and load of a crutch: Sesar et al. (2019), with the errata of the plugin's README.

    Args:
        params: Of the crutch.
    """

    def __init__(self, params: CrutchTipParams) -> None:
        self._params = params
        self._stream = Stream(params)
        self._books = Books(params)
        self._period_s: float | None = None
        self._stretch: Stretch | None = None
        self._trace: Trace | None = None

    @property
    def look_ahead_s(self) -> float:
        """A stance is told when its end is certain and its chunk is full."""
        return self._params.force_hold_s + CHUNK_S

    def update(self, item: EstimatorInput) -> Sequence[Event]:
        """Take the next samples, or the news that some are missing; return what is now known."""
        events: list[Event] = []
        if isinstance(item, SampleBatch) and item.period_s != self._period_s:
            events += self._stretch.finish() if self._stretch else []
            self._period_s = item.period_s
            self._stretch = Stretch(self._params, item.period_s, self._books)
            self._stretch.trace = self._trace
        for entry in self._stream.feed(item):
            assert self._stretch is not None
            if isinstance(entry, Break):
                events += self._stretch.broken(entry)
            else:
                events += self._stretch.extend(entry)
        return events

    def finish(self) -> Sequence[Event]:
        """Return what the look-ahead still held back, at the end of the input."""
        events = self._stretch.finish() if self._stretch else []
        return [*events, *self._books.close()]

    def start_trace(self) -> Trace:
        """Keep per-sample estimates from now on."""
        self._trace = Trace("pitch_rad", "pitch_sigma_rad", "force_newton", "stance")
        if self._stretch is not None:
            self._stretch.trace = self._trace
        return self._trace


class Stretch:
    """Samples of one period, worked on chunk by chunk.

    Args:
        params: Of the crutch.
        period_s: Of the samples.
        books: Go on from stretch to stretch.

    Attributes:
        trace: Where per-sample estimates go, if anywhere.
    """

    def __init__(self, params: CrutchTipParams, period_s: float, books: Books) -> None:
        self.trace: Trace | None = None
        self._params = params
        self._period_s = period_s
        self._books = books
        self._chunk: Final = max(1, round(CHUNK_S / period_s))
        self._keep: Final = kept_samples(params, period_s)
        self._tracker = make_tracker(params, period_s)
        self._checks = Checks(params, period_s)
        self._meter = ForceMeter(period_s, smoothing_samples(params, period_s))
        self._untold: deque[tuple[int, float, float]] = deque()
        self._waiting: Rows | None = None
        self._begin()

    def extend(self, rows: Rows) -> list[Event]:
        """Take samples; return what is now known."""
        waiting = rows if self._waiting is None else self._waiting.joined(rows)
        events: list[Event] = []
        full = len(waiting) - len(waiting) % self._chunk
        for start in range(0, full, self._chunk):
            events += self._work(waiting[start : start + self._chunk])
        self._waiting = waiting[full:]
        return events

    def broken(self, gap: Break) -> list[Event]:
        """Take that samples are missing: a stance that was going on is not measured."""
        events = self._flush()
        self._tracker.broken(gap.duration_s)
        self._begin()
        return events

    def finish(self) -> list[Event]:
        """Return what is known of the samples still held back."""
        return self._flush()

    def _begin(self) -> None:
        self._contact = ContactDetector(
            self._params.force_min_newton, round(self._params.force_hold_s / self._period_s)
        )
        self._stance: Stance | None = None
        self._measured = 0
        self._recent: Rows | None = None

    def _flush(self) -> list[Event]:
        events = []
        if self._waiting is not None and len(self._waiting):
            events = self._work(self._waiting)
        self._waiting = None
        if self._stance is not None:
            self._tracker.relieved(self._contact.index)
        self._tell_trace(all_of_them=True)
        return events

    def _work(self, rows: Rows) -> list[Event]:
        recent = rows if self._recent is None else self._recent.joined(rows)
        self._recent = recent[-self._keep :]
        self._tracker.extend(rows)
        events = self._checks.samples(rows)
        for edge in self._contact.extend(rows.values[:, FORCE]):
            events += self._on_contact(edge) if edge.loaded else self._on_lift(edge)
        if self._stance is not None:
            self._measure_until(self._stance, self._contact.index)
        events += self._stand(int(rows.t_ns[-1]))
        if self.trace is not None:
            self._untold.extend(
                (t, f, float(self._stance is not None))
                for t, f in zip(rows.t_ns.tolist(), rows.values[:, FORCE].tolist(), strict=True)
            )
        self._tell_trace()
        return events

    def _stand(self, t_ns: int) -> list[Event]:
        """Let time pass: a stance or a pause may grow too long for walking."""
        stance = self._stance
        if stance is None:
            return self._books.advance(t_ns)
        if stance.pitch is not None or stance.contact == 0:
            return []
        if (self._contact.index - stance.contact) * self._period_s <= self._params.max_stance_s:
            return []
        stance.pitch = self._tracker.pitch(stance.contact)
        return self._books.standing(stance, self._pitches(stance, self._contact.index))

    def _pitches(self, stance: Stance, end: int) -> Pitches | None:
        if self._checks.misplaced:
            return None
        contact = stance.pitch or self._tracker.pitch(stance.contact)
        return Pitches(*contact, *self._tracker.pitch(end))

    def _on_contact(self, edge: Edge) -> list[Event]:
        rows = self._rows(edge.sample, edge.sample + 1)
        self._stance = Stance(edge.sample, int(rows.t_ns[0]))
        self._meter.begin()
        self._measured = edge.sample
        self._tracker.loaded(edge.sample)
        return []

    def _on_lift(self, edge: Edge) -> list[Event]:
        stance, self._stance = self._stance, None
        if stance is None:
            return []
        self._measure_until(stance, edge.sample)
        stance.lift, stance.lift_ns = (
            edge.sample,
            int(self._rows(edge.sample, edge.sample + 1).t_ns[0]),
        )
        events = self._compare(stance)
        self._tracker.relieved(edge.sample)
        if (edge.sample - stance.contact) * self._period_s < self._params.min_stance_s:
            return events
        pitches = self._pitches(stance, stance.lift)
        if stance.contact == 0:
            self._books.half_seen(stance, pitches)
            return events
        return [*events, *self._books.stance(stance, pitches)]

    def _compare(self, stance: Stance) -> list[Event]:
        """Compare how inclinometer and gyroscope saw the stance turn."""
        edge = round(self._params.settle_s / self._period_s)
        middle = self._rows(stance.contact + edge, stance.lift - edge)
        if len(middle) < edge:
            return []
        rate: Floats = middle.values[:, GYRO_D][:, 1]
        inclination = -np.arcsin(np.clip(middle.values[:, UP_D][:, 0], -1.0, 1.0))
        by_gyro = change(np.cumsum(rate) * self._period_s)
        return self._checks.stance(stance.lift_ns, by_gyro, change(inclination))

    def _measure_until(self, stance: Stance, stop: int) -> None:
        if stop > self._measured:
            force = self._rows(self._measured, stop).values[:, FORCE]
            self._meter.measure(stance, force)
            self._measured = stop

    def _rows(self, start: int, stop: int) -> Rows:
        """Return samples of late by their numbers, as far as they are kept."""
        assert self._recent is not None
        first = self._contact.index - len(self._recent)
        return self._recent[max(0, start - first) : max(0, stop - first)]

    def _tell_trace(self, *, all_of_them: bool = False) -> None:
        settled = self._tracker.settle(all_of_them=all_of_them)
        if self.trace is None:
            return
        for pitch, sigma in zip(
            settled.pitch_rad.tolist(), settled.sigma_rad.tolist(), strict=True
        ):
            t_ns, force, stance = self._untold.popleft()
            self.trace.append(t_ns, pitch, sigma, force, stance)
