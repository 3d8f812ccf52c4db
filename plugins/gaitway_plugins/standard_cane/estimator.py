"""The standard cane's estimator: the stages put together, each as late as its window demands."""

from collections import deque
from collections.abc import Sequence
from typing import Final

import numpy as np

from gaitway.api import EstimatorInput, Event, Floats, SampleBatch, Trace
from gaitway.estimation import (
    STANDARD_GRAVITY_MPS2,
    CentredHold,
    GapBridge,
    ImuSample,
    Saveable,
    WalkingTest,
    half_window,
    tilt_from_gravity_rad,
)
from gaitway_plugins.standard_cane.accounts import Accounts
from gaitway_plugins.standard_cane.mishaps import Mishaps
from gaitway_plugins.standard_cane.navigator import Navigator
from gaitway_plugins.standard_cane.params import StandardCaneParams
from gaitway_plugins.standard_cane.placements import Phase, Placements, Timing
from gaitway_plugins.standard_cane.tip import TipRow, TipTransport
from gaitway_plugins.standard_cane.tuning import Tuning

Row = tuple[float, ...]

_UNKNOWN: Final[Row] = (float("nan"),) * 7 + (0.0,)


class StandardCaneEstimator(Saveable):
    """Walking distance of a standard cane: Dang & Suh (2018), with the errata of the README.

    Args:
        params: Of the cane.
        C_db: The mounting, from IMU to device components, shape (3, 3).
    """

    def __init__(self, params: StandardCaneParams, C_db: Floats) -> None:
        self._params = params
        self._lever_d = np.asarray(C_db) @ np.array(params.imu_to_tip_m)
        self._bridge = GapBridge(params.max_bridge_s)
        self._accounts = Accounts(params)
        self._mishaps: Mishaps | None = None
        self._period_s: float | None = None
        self._stretch: Stretch | None = None
        self._trace: Trace | None = None

    @property
    def look_ahead_s(self) -> float:
        """Half of the walking window, of the contact window and of the window of w'."""
        p = self._params
        contact_s = Tuning.of(p, 0.01).contact_window_s
        return 0.5 * (p.walking_window_s + contact_s + p.rate_window_s)

    def update(self, item: EstimatorInput) -> Sequence[Event]:
        """Take the next samples, or the news that some are missing; return what is now known."""
        events: list[Event] = []
        if isinstance(item, SampleBatch) and item.period_s != self._period_s:
            self._period_s = item.period_s
            self._mishaps = Mishaps(item.period_s)
            events += self._go_on(Navigator(self._params, self._lever_d, item.period_s))
        samples: list[ImuSample] = []
        for entry in self._bridge.feed(item):
            assert self._stretch is not None
            assert self._mishaps is not None
            if isinstance(entry, ImuSample):
                samples.append(entry)
                mishap = self._mishaps.push(entry)
                if mishap is not None:
                    events.append(mishap)
                continue
            events += self._stretch.extend(samples)
            samples = []
            self._stretch.navigator.lose()
            events += self._go_on(self._stretch.navigator)
            events += self._accounts.broken(entry)
        if samples:
            assert self._stretch is not None
            events += self._stretch.extend(samples)
        return events

    def finish(self) -> Sequence[Event]:
        """Return what the look-ahead still held back, at the end of the input."""
        events = [] if self._stretch is None else self._stretch.finish()
        return [*events, *self._accounts.finish()]

    def start_trace(self) -> Trace:
        """Keep per-sample estimates from now on; NaN while the attitude is unknown."""
        self._trace = Trace(
            "tip_x_m", "tip_y_m", "tip_z_m", "tip_vel_x_mps", "tip_vel_y_mps", "tip_vel_z_mps",
            "swing_sigma_m", "contact", "walking",
        )  # fmt: skip
        if self._stretch is not None:
            self._stretch.trace = self._trace
        return self._trace

    def _go_on(self, navigator: Navigator) -> list[Event]:
        assert self._period_s is not None
        events = [] if self._stretch is None else self._stretch.finish()
        self._stretch = Stretch(
            self._params, self._lever_d, self._period_s, navigator, self._accounts
        )
        self._stretch.trace = self._trace
        return events


class Stretch:
    """Samples with no break between them, and the windows over them.

    A sample is carried to the tip when the window of w' is centred on it, navigated when the
    contact window is, and spoken of when the walking window is.

    Args:
        params: Of the cane.
        imu_to_tip_d: The paper's p1, metres, in d.
        period_s: Of the samples.
        navigator: Goes on from stretch to stretch.
        accounts: The same.

    Attributes:
        navigator: As given.
        trace: Where per-sample estimates go, if anywhere.
    """

    def __init__(
        self,
        params: StandardCaneParams,
        imu_to_tip_d: Floats,
        period_s: float,
        navigator: Navigator,
        accounts: Accounts,
    ) -> None:
        self.navigator = navigator
        self.trace: Trace | None = None
        self._accounts = accounts
        self._tuning = tuning = Tuning.of(params, period_s)
        self._transport = TipTransport(imu_to_tip_d, params.rate_window_s, period_s)
        self._half = half_window(tuning.contact_window_s, period_s)
        self._hold = CentredHold(self._half)
        self._rate_max = params.contact_rate_max_radps
        self._test = WalkingTest(
            window_s=params.walking_window_s,
            period_s=period_s,
            sms_max_radps=params.sms_max_radps,
            tilt_max_rad=params.tilt_max_rad,
        )
        self._placements = Placements(navigator, _timing(params, tuning, period_s, self._half))
        self._to_navigate: deque[TipRow] = deque()
        self._to_decide: deque[tuple[int, Row]] = deque()
        self._decided = -1

    def extend(self, samples: list[ImuSample]) -> list[Event]:
        """Take the next samples; return what is now known of earlier ones."""
        events: list[Event] = []
        for row in self._transport.extend(samples):
            force_off = abs(row.force_mps2 - STANDARD_GRAVITY_MPS2)
            quiet = self._hold.push(
                force_off <= self._tuning.contact_force_max_mps2
                and row.rate_radps <= self._rate_max
            )
            self._to_navigate.append(row)
            if len(self._to_navigate) > self._half:
                events += self._navigate(self._to_navigate.popleft(), quiet)
        return events

    def finish(self) -> list[Event]:
        """Return what is known of the samples still held back."""
        self._placements.close()
        return [event for walking in self._test.finish() for event in self._decide(walking)]

    def _navigate(self, row: TipRow, quiet: bool) -> list[Event]:
        self._placements.push(row, quiet)
        sample = row.sample
        # Eq. 13 takes a swing's acceleration for a lean, which the navigated attitude does not.
        known = self.navigator.aligned
        tilt = self.navigator.tilt_rad() if known else tilt_from_gravity_rad(sample.accel_d)
        self._to_decide.append((sample.t_ns, self._row(row)))
        walking = self._test.push(sample.gyro_d, tilt)
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

    def _row(self, row: TipRow) -> Row:
        if self.trace is None or not self.navigator.aligned:
            return _UNKNOWN
        navigator = self.navigator
        standing = self._placements.phase is Phase.STANDING
        tip_n, vel_n = navigator.tip_n.tolist(), navigator.tip_velocity_n(row).tolist()
        return (*tip_n, *vel_n, navigator.way().sigma_m, float(standing))


def _timing(params: StandardCaneParams, tuning: Tuning, period_s: float, half: int) -> Timing:
    return Timing(
        half=half,
        every=tuning.pivot_every,
        settle=round(params.settle_s / period_s),
        max_swing=round(params.max_swing_s / period_s),
        stance=round(params.min_stance_s / period_s),
        insist=round(params.insist_s / period_s),
        start=round(params.start_window_s / period_s),
        resume=round(params.resume_window_s / period_s),
    )
