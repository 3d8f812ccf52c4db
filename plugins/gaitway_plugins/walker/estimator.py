"""The walker's estimator: blocks, stillness, navigation, pieces, books."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gaitway.api import NS_PER_S, Anomaly, EstimatorInput, Event, SampleBatch, Stride, Trace
from gaitway.estimation import Break, Saveable
from gaitway_plugins.walker.accounts import Accounts
from gaitway_plugins.walker.blocks import Block, Blocks
from gaitway_plugins.walker.checks import Checks
from gaitway_plugins.walker.mover import Mover
from gaitway_plugins.walker.navigator import WheelNavigator
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.pieces import Piece
from gaitway_plugins.walker.published import PaperNavigator
from gaitway_plugins.walker.stillness import Stillness
from gaitway_plugins.walker.tracing import Tracer
from gaitway_plugins.walker.turns import Turns
from gaitway_plugins.walker.upset import Upset

if TYPE_CHECKING:
    from gaitway_plugins.walker.fix import Navigator


class WalkerEstimator(Saveable):
    """Path, steps and their style of a front-wheeled walker: Doan & Pham (2019) and better.

    Args:
        params: Of the walker.
    """

    def __init__(self, params: WalkerParams) -> None:
        self._params = params
        self._accounts = Accounts(params)
        self._checks = Checks(params)
        self._turns = Turns(params)
        self._upset = Upset(params)
        paper = params.method == "published"
        self._navigator: Navigator = PaperNavigator(params) if paper else WheelNavigator(params)
        self._mover = Mover(params)
        self._period_s: float | None = None
        self._blocks: Blocks | None = None
        self._stillness = Stillness(params)
        self._held: Block | None = None
        self._tracer: Tracer | None = None

    @property
    def look_ahead_s(self) -> float:
        """Three blocks in which it settles, and of a roll what shows that its wheels have stopped.

        A step that begins a walk waits until ``begin_m`` were made, or for the next.
        """
        return 3.0 * self._params.block_s + max(self._params.stop_s, self._params.min_step_s)

    def update(self, item: EstimatorInput) -> Sequence[Event]:
        """Take the next samples, or the news that some are missing; return what is now known."""
        events: list[Event] = []
        if isinstance(item, SampleBatch) and item.period_s != self._period_s:
            events += self._flush()
            self._period_s = item.period_s
            self._blocks = Blocks(self._params, item.period_s)
        if self._blocks is None:
            return events
        for entry in self._blocks.feed(item):
            events += self._break(entry) if isinstance(entry, Break) else self._push(entry)
        return events

    def finish(self) -> Sequence[Event]:
        """Return what the look-ahead still held back, at the end of the input."""
        return [*self._flush(), *self._turns.finish(), *self._accounts.finish()]

    def start_trace(self) -> Trace:
        """Keep per-sample estimates from now on."""
        self._tracer = Tracer()
        return self._tracer.trace

    def _push(self, block: Block) -> list[Event]:
        calm = self._stillness.push(block, self._navigator.gyro_bias_d)
        held, self._held = self._held, block
        if held is None:
            self._accounts.begin(block.start_ns)
            return []
        return self._navigate(held, calm=calm)

    def _flush(self) -> list[Event]:
        events: list[Event] = []
        for block in [] if self._blocks is None else self._blocks.finish():
            events += self._push(block)
        if self._held is not None:
            events += self._navigate(self._held, calm=self._stillness.last())
        for piece in self._mover.finish():
            events += self._account(piece)
        self._held, self._stillness = None, Stillness(self._params)
        return events

    def _navigate(self, block: Block, *, calm: bool) -> list[Event]:
        fix = self._navigator.step(block, calm=calm)
        rate = block.gyro_d.mean(axis=0) - self._navigator.gyro_bias_d
        events = self._checks.push(block, fix, rate)
        self._upset.push(block, fix)
        pieces = self._mover.push(fix)
        if self._checks.untrusted:
            pieces = [piece for piece in pieces if piece.kind != "roll"]
            if fix.rolling:
                events += self._accounts.mistrust(fix.t_ns, fix.duration_s)
        if self._mover.carried:
            detail = "in the air for longer than a step; the path goes on anew where it is set down"
            events.append(Anomaly(t_ns=fix.t_ns, anomaly="carried", detail=detail))
        if self._tracer is not None:
            self._tracer.write(block, fix, self._mover.phase)
        for piece in pieces:
            events += self._account(piece)
        if self._mover.phase == "stand":
            events += self._accounts.pause(fix.t_ns)
        return [*events, *self._turns.push(fix)]

    def _break(self, gap: Break) -> list[Event]:
        walking = self._accounts.in_bout or self._mover.phase != "stand"
        events = self._flush()
        events += self._turns.finish()
        self._mover, self._turns = Mover(self._params), Turns(self._params)
        self._navigator.lose()
        if not walking:
            return events
        detail = f"{gap.duration_s:.2f} s of samples missing while walking; no step is made up"
        return [
            *events,
            *self._accounts.unseen(gap.t_ns, gap.duration_s, "gap-in-stride", detail),
        ]

    def _account(self, piece: Piece) -> list[Event]:
        if not self._upset.refuses(piece):
            return self._told(self._accounts.add(piece))
        detail = "moved after it fell or was borne off, before it stood or rolled; not counted"
        duration_s = (piece.t_ns - piece.start_ns) / NS_PER_S
        said = self._accounts.unseen(piece.t_ns, duration_s, "distance-untrusted", detail)
        return said if self._upset.tell() else said[1:]

    def _told(self, events: list[Event]) -> list[Event]:
        if self._tracer is not None:
            for event in events:
                if isinstance(event, Stride):
                    self._tracer.style(event)
        return events
