"""The shank's estimator: what flows in, what outlives a gap, what flows out."""

from collections.abc import Sequence

from gaitway.api import EstimatorInput, Event, SampleBatch, Trace
from gaitway.estimation import Break, GapBridge, ImuSample, Saveable
from gaitway_plugins.shank.accounts import Accounts
from gaitway_plugins.shank.learning import AnkleHeight, RestLearner
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.stretch import Loss, Stretch
from gaitway_plugins.shank.tracing import Tracer
from gaitway_plugins.shank.wearing import Wearing


class ShankEstimator(Saveable):
    """Walking distance of a shank, stride by stride: the default method.

    A stride is the IMU's horizontal way from the middle of one stance to that of the next, by
    strapdown integration between tilts and velocities that each stance gives by itself
    (``rollover``). The first begins and the last ends in standing, so half strides count.

    Args:
        params: Of the shank.
    """

    def __init__(self, params: ShankParams) -> None:
        self._params = params
        self._bridge = GapBridge(params.max_bridge_s)
        self._accounts = Accounts(params)
        self._rest = RestLearner(params)
        self._ankle = AnkleHeight(params)
        self._wearing = Wearing()
        self._period_s: float | None = None
        self._stretch: Stretch | None = None
        self._tracer: Tracer | None = None

    @property
    def look_ahead_s(self) -> float:
        """From the middle of the longest stance to where the swing that ends it is certain.

        A stride of usual walking is told 0.5 to 0.8 s after its end; the last one of a walk
        ``max_stance_s`` after its contact, when standing is certain.
        """
        p = self._params
        middle = 0.5 * (p.flat_begin + p.flat_end)
        return (1.0 - middle) * p.max_stance_s + p.max_swing_s + p.rate_smoothing_s

    def update(self, item: EstimatorInput) -> Sequence[Event]:
        """Take the next samples, or the news that some are missing; return what is now known."""
        events: list[Event] = []
        if isinstance(item, SampleBatch) and item.period_s != self._period_s:
            events += self._finish_stretch()
            self._stretch = self._new_stretch(item.period_s, None)
        for entry in self._bridge.feed(item):
            assert self._stretch is not None
            if isinstance(entry, ImuSample):
                events += self._stretch.push(entry)
            else:
                self._stretch = self._after(entry, self._stretch)
        return events

    def finish(self) -> Sequence[Event]:
        """Return what the look-ahead still held back, at the end of the input."""
        return [*self._finish_stretch(), *self._accounts.finish()]

    def start_trace(self) -> Trace:
        """Keep per-sample estimates from now on; the pitch is NaN until the first footing."""
        self._tracer = Tracer()
        return self._tracer.trace

    def _finish_stretch(self) -> list[Event]:
        return [] if self._stretch is None else self._stretch.finish()

    def _after(self, gap: Break, broken: Stretch) -> Stretch:
        """Return the stretch that begins after a gap; what it breaks off is not finished."""
        assert self._period_s is not None
        since_ns = broken.walking_since_ns()
        long = gap.duration_s > self._params.max_stance_s
        if since_ns is None and long and self._accounts.in_bout:
            since_ns = gap.t_ns
        broken.abandon()
        if since_ns is None:
            return self._new_stretch(self._period_s, None)
        detail = f"{gap.duration_s:.2f} s of samples missing while walking"
        mid_walk = broken.mid_walk and gap.duration_s <= self._params.max_lost_s
        loss = Loss(since_ns, "gap-in-stride", detail, mid_walk)
        return self._new_stretch(self._period_s, loss)

    def _new_stretch(self, period_s: float, lost: Loss | None) -> Stretch:
        self._period_s = period_s
        return Stretch(
            self._params, period_s, self._accounts, self._rest, self._ankle, self._wearing, lost,
            self._tracer,
        )  # fmt: skip
