"""The quad cane's estimator: the stages put together, each as late as its window demands."""

from collections import deque
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gaitway.api import EstimatorInput, Event, Floats, Ints, SampleBatch, Trace
from gaitway.estimation import (
    BlockBridge,
    Break,
    ImuBlock,
    Saveable,
    StanceDetector,
    WalkingTest,
    tilts_from_gravity_rad,
)
from gaitway_plugins.quad_cane.accounts import Accounts
from gaitway_plugins.quad_cane.checks import FallCheck
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
        self._bridge = BlockBridge(params.max_bridge_s)
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
            if isinstance(entry, ImuBlock):
                events += self._stretch.extend(entry)
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
        self._falls = FallCheck(period_s)
        self._test = WalkingTest(
            window_s=params.walking_window_s,
            period_s=period_s,
            sms_max_radps=params.sms_max_radps,
            tilt_max_rad=params.tilt_max_rad,
        )
        tuning = Tuning.of(params, period_s)
        self._tilt_from_gravity = tuning.tilt_from_gravity
        self._placements = Placements(
            navigator,
            half=self._stance.half,
            every=tuning.zero_velocity_every,
            settle=min(round(params.settle_s / period_s), self._test.half - self._stance.half),
            least=round(params.min_stance_s / period_s),
            max_swing=round(params.max_swing_s / period_s),
            stood=stood,
        )
        self._to_navigate: ImuBlock | None = None
        self._to_decide: Ints = np.empty(0, np.int64)
        self._rows: deque[Row] = deque()
        self._decided = 0

    @property
    def standing(self) -> bool:
        """Whether the cane stands, as far as it is known."""
        return self._placements.phase is Phase.STANDING

    def extend(self, block: ImuBlock) -> list[Event]:
        """Take samples; return what is now known of earlier ones."""
        fallen = self._falls.extend(block)
        quiet = self._stance.extend(block.accel_d, block.gyro_d)
        waiting = ImuBlock.joined(self._to_navigate, block) if self._to_navigate else block
        ready = max(0, len(waiting) - self._stance.half)
        self._to_navigate = waiting[ready:]
        if not ready:
            return fallen
        return [*self._navigate(waiting[:ready], quiet[-ready:]), *fallen]

    def finish(self) -> list[Event]:
        """Return what is known of the samples still held back.

        Those whose contact window the end cuts are not navigated: they can't become a contact.
        """
        self._placements.close()
        events = self._decide(np.array(self._test.finish(), np.bool_))
        if self.trace is not None and self._to_navigate is not None:
            for t_ns in self._to_navigate.t_ns.tolist():
                self.trace.append(t_ns, *_UNKNOWN, 0.0)
        return events

    def _navigate(self, block: ImuBlock, quiet: NDArray[np.bool_]) -> list[Event]:
        if self.trace is None:
            tilt_rad = self._placements.extend(block, quiet)
        else:
            tilt_rad = self._traced(block, quiet)
        if self._tilt_from_gravity:
            tilt_rad = tilts_from_gravity_rad(block.accel_d)
        self._to_decide = np.concatenate([self._to_decide, block.t_ns])
        return self._decide(self._test.extend(block.gyro_d, tilt_rad))

    def _traced(self, block: ImuBlock, quiet: NDArray[np.bool_]) -> Floats:
        """Navigate sample by sample, so that a row is known for each."""
        tilts_rad = np.empty(len(block))
        for row in range(len(block)):
            part = slice(row, row + 1)
            tilts_rad[part] = self._placements.extend(block[part], quiet[part])
            self._rows.append(self._row())
        return tilts_rad

    def _decide(self, walking: NDArray[np.bool_]) -> list[Event]:
        """Say what is known of the next samples, as many as there are verdicts."""
        t_ns, self._to_decide = np.split(self._to_decide, [len(walking)])
        if self.trace is not None:
            for t, verdict in zip(t_ns.tolist(), walking.tolist(), strict=True):
                self.trace.append(t, *self._rows.popleft(), float(verdict))
        events: list[Event] = []
        row = 0
        records = self._placements.records
        while records:
            told = records[0]
            # At its own sample, or at the first that is decided when it is known.
            index = max(told.record.index, told.known - self._test.half)
            after = index + 1 - self._decided
            if after > len(walking):
                break
            events += self._accounts.pass_by(t_ns[row:after], walking[row:after])
            events += self._accounts.record(records.popleft().record)
            row = max(row, after)
        events += self._accounts.pass_by(t_ns[row:], walking[row:])
        self._decided += len(walking)
        return events

    def _row(self) -> Row:
        if not self.navigator.aligned:
            return _UNKNOWN
        sigma_m = self.navigator.displacement().sigma_m
        pos_n, vel_n = self.navigator.pos_n.tolist(), self.navigator.vel_n.tolist()
        return (*pos_n, *vel_n, sigma_m, float(self.standing))
