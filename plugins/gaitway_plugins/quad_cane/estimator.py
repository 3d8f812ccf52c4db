"""The quad cane's estimator: the stages put together, each as late as its window demands."""

from collections import deque
from collections.abc import Sequence
from typing import Final

from gaitway.api import EstimatorInput, Event, SampleBatch, Trace
from gaitway.estimation import Break, GapBridge, ImuSample, Saveable, StanceDetector
from gaitway_plugins.quad_cane.accounts import Accounts
from gaitway_plugins.quad_cane.activity import WalkingTest, tilt_from_gravity_rad
from gaitway_plugins.quad_cane.navigator import Navigator
from gaitway_plugins.quad_cane.params import QuadCaneParams
from gaitway_plugins.quad_cane.placements import Phase, Placements
from gaitway_plugins.quad_cane.tuning import Tuning

Row = tuple[float, ...]

_UNKNOWN: Final[Row] = (float("nan"),) * 7 + (0.0,)


class QuadCaneEstimator(Saveable):
    """Walking distance of a quad cane: Dang & Suh (2018), with the errata of the plugin's README.

    Args:
        params: Of the cane.
    """

    def __init__(self, params: QuadCaneParams) -> None:
        self._params = params
        self._bridge = GapBridge(params.max_bridge_s)
        self._accounts = Accounts(params)
        self._period_s: float | None = None
        self._stretch: Stretch | None = None
        self._trace: Trace | None = None

    @property
    def look_ahead_s(self) -> float:
        """Half of the contact window and half of the walking window."""
        return 0.5 * (self._params.stance_window_s + self._params.walking_window_s)

    def update(self, item: EstimatorInput) -> Sequence[Event]:
        """Take the next samples, or the news that some are missing; return what is now known."""
        events: list[Event] = []
        if isinstance(item, SampleBatch) and item.period_s != self._period_s:
            self._period_s = item.period_s
            events += self._go_on(Navigator(self._params, item.period_s))
        for entry in self._bridge.feed(item):
            assert self._stretch is not None
            if isinstance(entry, ImuSample):
                events += self._stretch.push(entry)
            else:
                events += self._break(entry, self._stretch)
        return events

    def finish(self) -> Sequence[Event]:
        """Return what the look-ahead still held back, at the end of the input."""
        events = [] if self._stretch is None else self._stretch.finish()
        return [*events, *self._accounts.finish()]

    def start_trace(self) -> Trace:
        """Keep per-sample estimates from now on; NaN while the attitude is unknown."""
        self._trace = Trace(
            "pos_x_m", "pos_y_m", "pos_z_m", "vel_x_mps", "vel_y_mps", "vel_z_mps",
            "swing_sigma_m", "contact", "walking",
        )  # fmt: skip
        if self._stretch is not None:
            self._stretch.trace = self._trace
        return self._trace

    def _break(self, gap: Break, stretch: "Stretch") -> list[Event]:
        stood = stretch.standing
        if not stood:
            stretch.navigator.lose()
        events = self._go_on(stretch.navigator, stood=stood)
        return [*events, *self._accounts.broken(gap)]

    def _go_on(self, navigator: Navigator, *, stood: bool = False) -> list[Event]:
        assert self._period_s is not None
        events = [] if self._stretch is None else self._stretch.finish()
        self._stretch = Stretch(self._params, self._period_s, navigator, self._accounts, stood)
        self._stretch.trace = self._trace
        return events


class Stretch:
    """Samples with no break between them, and the windows over them.

    A sample is navigated when the contact window is centred on it, and spoken of when the walking
    window is: half of the one and half of the other after it came.

    Args:
        params: Of the cane.
        period_s: Of the samples.
        navigator: Goes on from stretch to stretch.
        accounts: The same.
        stood: The cane stood when the stretch before ended.

    Attributes:
        navigator: As given.
        trace: Where per-sample estimates go, if anywhere.
    """

    def __init__(
        self,
        params: QuadCaneParams,
        period_s: float,
        navigator: Navigator,
        accounts: Accounts,
        stood: bool,
    ) -> None:
        self.navigator = navigator
        self.trace: Trace | None = None
        self._accounts = accounts
        self._stance = StanceDetector(
            period_s,
            window_s=params.stance_window_s,
            accel_max_mps2=params.stance_accel_max_mps2,
            gyro_max_radps=params.stance_gyro_max_radps,
        )
        self._test = WalkingTest(params, period_s)
        tuning = Tuning.of(params, period_s)
        self._tilt_from_gravity = tuning.tilt_from_gravity
        self._placements = Placements(
            navigator,
            half=self._stance.half,
            every=tuning.zero_velocity_every,
            settle=min(round(params.settle_s / period_s), self._test.half - self._stance.half),
            max_swing=round(params.max_swing_s / period_s),
            stood=stood,
        )
        self._to_navigate: deque[ImuSample] = deque()
        self._to_decide: deque[tuple[int, Row]] = deque()
        self._decided = -1

    @property
    def standing(self) -> bool:
        """Whether the cane stands, as far as it is known."""
        return self._placements.phase is Phase.STANDING

    def push(self, sample: ImuSample) -> list[Event]:
        """Take the next sample; return what is now known of an earlier one."""
        quiet = self._stance.push(sample.accel_d, sample.gyro_d)
        self._to_navigate.append(sample)
        if len(self._to_navigate) <= self._stance.half:
            return []
        return self._navigate(self._to_navigate.popleft(), quiet)

    def finish(self) -> list[Event]:
        """Return what is known of the samples still held back.

        Those whose contact window the end cuts are not navigated: they can't become a contact.
        """
        self._placements.close()
        events = [event for walking in self._test.finish() for event in self._decide(walking)]
        if self.trace is not None:
            for sample in self._to_navigate:
                self.trace.append(sample.t_ns, *_UNKNOWN, 0.0)
        return events

    def _navigate(self, sample: ImuSample, quiet: bool) -> list[Event]:
        self._placements.push(sample, quiet)
        aligned = self.navigator.aligned and not self._tilt_from_gravity
        tilt_rad = self.navigator.tilt_rad() if aligned else tilt_from_gravity_rad(sample)
        self._to_decide.append((sample.t_ns, self._row() if self.trace is not None else _UNKNOWN))
        walking = self._test.push(sample, tilt_rad)
        return [] if walking is None else self._decide(walking)

    def _decide(self, walking: bool) -> list[Event]:
        self._decided += 1
        t_ns, row = self._to_decide.popleft()
        if self.trace is not None:
            self.trace.append(t_ns, *row, float(walking))
        events = self._accounts.sample(t_ns, walking)
        records = self._placements.records
        while records and records[0].index <= self._decided:
            events += self._accounts.record(records.popleft())
        return events

    def _row(self) -> Row:
        if not self.navigator.aligned:
            return _UNKNOWN
        sigma_m = self.navigator.displacement().sigma_m
        pos_n, vel_n = self.navigator.pos_n.tolist(), self.navigator.vel_n.tolist()
        return (*pos_n, *vel_n, sigma_m, float(self.standing))
