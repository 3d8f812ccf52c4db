"""The ankle's estimator: what flows in, what outlives a gap, what flows out."""

from collections.abc import Sequence

import numpy as np

from gaitway.api import EstimatorInput, Event, Floats, SampleBatch, Trace
from gaitway.estimation import Break, GapBridge, ImuSample, Saveable
from gaitway_plugins.ankle.books import Books
from gaitway_plugins.ankle.lever import Lever
from gaitway_plugins.ankle.params import AnkleParams
from gaitway_plugins.ankle.stretch import Loss, Stretch
from gaitway_plugins.ankle.tracing import Tracer


class AnkleEstimator(Saveable):
    """Trajectory, height and walking distance of an ankle: the default method.

    Args:
        params: Of the ankle.
        C_db: Mounting, from IMU to device components; the device's axes are the IMU's where None.
    """

    def __init__(self, params: AnkleParams, C_db: Floats | None = None) -> None:
        self._params = params
        self._lever = Lever.of(params, np.eye(3) if C_db is None else C_db)
        self._bridge = GapBridge(params.max_bridge_s)
        self._books = Books(params, self._lever)
        self._stretch: Stretch | None = None
        self._period_s: float | None = None
        self._tracer: Tracer | None = None

    @property
    def look_ahead_s(self) -> float:
        """From the contact that ends a stride to where its stance has proven quiet.

        A stride of usual walking is told half a second after its end, at the push-off of the
        stance that ends it; the last of a walk when that stance has lasted ``standing_after_s``.
        """
        p = self._params
        return p.standing_after_s + p.chunk_s + p.energy_window_s

    def update(self, item: EstimatorInput) -> Sequence[Event]:
        """Take the next samples, or the news that some are missing; return what is now known."""
        events: list[Event] = []
        if isinstance(item, SampleBatch) and item.period_s != self._period_s:
            events += self._finish_stretch()
            self._period_s = item.period_s
            self._stretch = self._new_stretch(item.period_s)
        for entry in self._bridge.feed(item):
            assert self._stretch is not None
            if isinstance(entry, ImuSample):
                events += self._stretch.push(entry)
            else:
                events += self._after(entry, self._stretch)
        return events

    def finish(self) -> Sequence[Event]:
        """Return what the look-ahead still held back, at the end of the input."""
        return [*self._finish_stretch(), *self._books.finish()]

    def start_trace(self) -> Trace:
        """Keep per-sample estimates from now on; NaN while position is unknown."""
        self._tracer = Tracer()
        if self._stretch is not None:
            self._stretch.tracer = self._tracer
        return self._tracer.trace

    def _finish_stretch(self) -> list[Event]:
        return [] if self._stretch is None else self._stretch.finish()

    def _after(self, gap: Break, broken: Stretch) -> list[Event]:
        """Begin anew after a gap; what was known of the biases stays."""
        events, since_ns = broken.break_off()
        assert self._period_s is not None
        self._stretch = self._new_stretch(self._period_s)
        self._stretch.navigator.know_biases_of(broken.navigator, gap.duration_s)
        if since_ns is not None:
            detail = f"{gap.duration_s:.2f} s of samples missing while walking"
            self._stretch.lost = Loss(since_ns, "gap-in-stride", detail)
        return events

    def _new_stretch(self, period_s: float) -> Stretch:
        return Stretch(self._params, period_s, self._lever, self._books, self._tracer)
