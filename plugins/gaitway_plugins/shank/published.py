"""The published methods: the band-passed forward acceleration integrated, without orientation.

Orlowski & Loose do this to a whole recording afterwards. Here it is done as the samples come: the
filters are causal, and resting is cut off by the swings found so far.
"""

from collections.abc import Sequence
from typing import Final

from gaitway.api import NS_PER_S, Anomaly, EstimatorInput, Event, SampleBatch, Trace
from gaitway.estimation import (
    Break,
    CentredMean,
    GapBridge,
    ImuSample,
    Saveable,
    WalkLedger,
    half_window,
)
from gaitway_plugins.shank.integration import (
    BEFORE_PEAK_S,
    Method,
    Signals,
    Step,
    Stepwise,
    WholeSignal,
)
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.swings import Mark, SwingDetector
from gaitway_plugins.shank.track import samples

_STRIDE_SIGMA: Final = 0.15
"""Relative standard deviation of one stride, from their spread within a walk."""


class PublishedEstimator(Saveable):
    """Walking distance of a shank by one of the paper's methods.

    Args:
        params: Of the shank; ``method`` says which.
    """

    def __init__(self, params: ShankParams) -> None:
        self._params = params
        self._bridge = GapBridge(params.max_bridge_s)
        self._ledger = WalkLedger(
            max_pause_s=params.max_pause_s,
            shared_sigma=params.published_shared_sigma,
            stride_time_sigma_s=params.stride_time_sigma_s,
        )
        self._trace: Trace | None = None
        self._period_s: float | None = None

    @property
    def look_ahead_s(self) -> float:
        """From a stride's end to where standing is certain (wsi), or the swing over (s1 to s3)."""
        p = self._params
        waiting_s = p.max_stance_s if p.method == "wsi" else p.max_swing_s + BEFORE_PEAK_S
        return waiting_s + p.max_swing_s + p.rate_smoothing_s

    def update(self, item: EstimatorInput) -> Sequence[Event]:
        """Take the next samples, or the news that some are missing; return what is now known."""
        events: list[Event] = []
        if isinstance(item, SampleBatch) and item.period_s != self._period_s:
            if self._period_s is not None:
                events += self._count(self._method.stop())
            self._begin(item.period_s)
        for entry in self._bridge.feed(item):
            if isinstance(entry, ImuSample):
                events += self._push(entry)
            else:
                events += self._break(entry)
        return events

    def finish(self) -> Sequence[Event]:
        """Return what the look-ahead still held back, at the end of the input."""
        events: list[Event] = []
        if self._period_s is not None:
            for rate in self._smooth.finish():
                events += self._follow(rate)
            events += self._count(self._method.stop())
        return [*events, *self._ledger.close_bout()]

    def start_trace(self) -> Trace:
        """Keep the filtered signals from now on."""
        self._trace = Trace("forward_accel_mps2", "swing_rate_radps", "stance")
        return self._trace

    def _begin(self, period_s: float) -> None:
        p = self._params
        self._period_s = period_s
        self._signals = Signals(p, period_s)
        self._method: Method = (
            WholeSignal(self._signals)
            if p.method == "wsi"
            else Stepwise(self._signals, p.method, p.v_min_share)
        )
        self._smooth = CentredMean(half_window(p.rate_smoothing_s, period_s))
        self._swings = SwingDetector(p, period_s)
        self._max_stance = samples(p.max_stance_s, period_s)
        self._kept = samples(p.max_swing_s + 2.0 * BEFORE_PEAK_S, period_s)
        self._now = -1
        self._toe_off = 0
        self._contact: int | None = None
        self._swinging = False

    def _push(self, sample: ImuSample) -> list[Event]:
        self._ledger.begin(sample.t_ns)
        row = self._signals.push(sample)
        if self._trace is not None:
            self._trace.append(sample.t_ns, *row, 0.0 if self._swinging else 1.0)
        rate_radps = self._smooth.push(sample.gyro_d[1])
        return [] if rate_radps is None else self._follow(rate_radps)

    def _follow(self, rate_radps: float) -> list[Event]:
        self._now += 1
        found = self._swings.push(rate_radps)
        if found is None:
            return [] if self._swinging else self._wait()
        self._swinging = found.mark is Mark.TOE_OFF
        if found.mark is Mark.TOE_OFF:
            self._toe_off = found.at
            return []
        self._contact = found.at
        if found.mark is Mark.TOO_LONG:
            return self._count(self._method.stop())
        return self._count(self._method.swing(self._toe_off, found.at))

    def _wait(self) -> list[Event]:
        events: list[Event] = []
        if self._contact is not None and self._now - self._contact >= self._max_stance:
            self._contact = None
            events = self._count(self._method.stop())
        if self._contact is None:
            events += self._ledger.advance(self._signals.t_ns(self._now))
        needed = self._method.needs()
        oldest = self._now - self._kept
        self._signals.drop_before(oldest if needed is None else min(oldest, needed))
        return events

    def _break(self, gap: Break) -> list[Event]:
        assert self._period_s is not None
        walking = self._contact is not None or self._swinging
        begun = self._method.needs()
        since_ns = gap.t_ns if begun is None else self._signals.t_ns(begun)
        self._begin(self._period_s)
        if not walking:
            return []
        t_ns = gap.t_ns + round(gap.duration_s * NS_PER_S)
        self._ledger.add_unmeasured((t_ns - since_ns) / NS_PER_S)
        detail = f"{gap.duration_s:.2f} s of samples missing while walking; no stride is made up"
        said = Anomaly(t_ns=t_ns, anomaly="gap-in-stride", detail=detail)
        return [said, self._ledger.distance(t_ns)]

    def _count(self, strides: list[Step]) -> list[Event]:
        events: list[Event] = []
        for begin, end, length_m in strides:
            begin_ns, end_ns = self._signals.t_ns(begin), self._signals.t_ns(end)
            if length_m >= self._params.min_stride_m:
                sigma_m = _STRIDE_SIGMA * length_m
                events += self._ledger.add_stride(begin_ns, end_ns, length_m, sigma_m)
        return events
