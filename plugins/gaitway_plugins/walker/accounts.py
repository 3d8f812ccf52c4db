"""The walker's books: pieces in; strides, distance, bouts, poses, pushes and anomalies out."""

import math
from typing import Final

from gaitway.api import NS_PER_S, Anomaly, Event, Push, Stride
from gaitway.estimation import WalkLedger
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.path import Path
from gaitway_plugins.walker.pieces import Piece, Style

_BACK_MAX_M: Final = 0.3
"""Going back further is a way of its own, and the same ground counts anew afterwards."""
_PUSH_MIN_M: Final = 0.05
_WORDS: Final = {
    "drag": ("dragging", "moved {0:.2f} m with standing wheels and without a lift; not counted"),
    "lost": (
        "distance-untrusted",
        "a movement in the air that can't be measured (samples missing, or too far: {0:.2f} m)",
    ),
}


class Accounts:
    """Counts new ground, so that rocking to and fro counts once or not at all.

    Progress is the sum of the signed lengths. A piece becomes a stride when it ends at least
    ``min_step_m`` beyond what was counted before; a walk begins when ``begin_m`` were made, and
    until then its first pieces wait.

    Args:
        params: Of the walker.
    """

    def __init__(self, params: WalkerParams) -> None:
        self._params: Final = params
        self._ledger = WalkLedger(
            max_pause_s=params.max_pause_s,
            shared_sigma=params.wheel_shared_sigma,
            stride_time_sigma_s=params.stride_time_sigma_s,
        )
        self._path = Path(params.wheel_shared_sigma)
        self._behind_m = 0.0
        self._behind_var_m2 = 0.0
        self._moving_s = 0.0
        self._waiting: list[tuple[Piece, float, float, float]] = []
        self._end_ns: int | None = None
        self._mistrusted = False
        self._mistrusted_ns = 0

    @property
    def in_bout(self) -> bool:
        """Whether a walk is going on."""
        return self._ledger.in_bout

    def begin(self, t_ns: int) -> None:
        """Take the first sample; later calls change nothing."""
        self._ledger.begin(t_ns)

    def pause(self, t_ns: int) -> list[Event]:
        """Let time pass in which nothing moves."""
        if self._waiting and t_ns - self._waiting[-1][0].t_ns > self._pause_ns:
            self._waiting.clear()
            self._behind_m = 0.0
        return self._ledger.advance(t_ns)

    def add(self, piece: Piece) -> list[Event]:
        """Take the next piece; return what it makes known."""
        if piece.kind == "carried":
            self._path.restart()
            return []
        if piece.kind in _WORDS:
            return self._refuse(piece)
        events = self._push(piece)
        self._path.add(piece)
        # What is behind the furthest point is negative until the ground is new again.
        self._behind_m = max(self._behind_m + piece.length_m, -_BACK_MAX_M)
        self._behind_var_m2 += piece.sigma_m**2
        self._moving_s += (piece.t_ns - piece.start_ns) / NS_PER_S
        if self._behind_m < self._params.min_step_m:
            self._give_way()
            return events
        step = (piece, self._behind_m, math.sqrt(self._behind_var_m2), self._moving_s)
        self._behind_m = self._behind_var_m2 = self._moving_s = 0.0
        self._waiting.append(step)
        progress_m = sum(length_m for _, length_m, _, _ in self._waiting)
        if self._ledger.in_bout or progress_m >= self._params.begin_m:
            for waited in self._waiting:
                events += self._stride(*waited)
            self._waiting.clear()
        return events

    def unseen(self, t_ns: int, duration_s: float, anomaly: str, detail: str) -> list[Event]:
        """Count time of walking that gave no measure."""
        self._path.restart()
        self._ledger.add_unmeasured(duration_s)
        return [
            Anomaly(t_ns=t_ns, anomaly=anomaly, detail=detail),
            self._ledger.distance(t_ns),
        ]

    def mistrust(self, t_ns: int, duration_s: float) -> list[Event]:
        """Count time in which the wheels counted, but wrongly; say so when it begins."""
        begins, self._mistrusted, self._mistrusted_ns = not self._mistrusted, True, t_ns
        self._ledger.add_unmeasured(duration_s, ongoing=True)
        if not begins:
            return []
        detail = "the wheels' counts can't be right; nothing is counted until they are"
        said = Anomaly(t_ns=t_ns, anomaly="distance-untrusted", detail=detail)
        return [said, self._ledger.distance(t_ns)]

    def finish(self) -> list[Event]:
        """Take that no more will come."""
        events = self._ledger.close_bout()
        return [*events, self._ledger.distance(self._mistrusted_ns)] if self._mistrusted else events

    @property
    def _pause_ns(self) -> int:
        return round(self._params.max_pause_s * NS_PER_S)

    def _give_way(self) -> None:
        """Take back steps that wait, when the walker was rolled back over them."""
        while self._waiting and self._behind_m < -0.5 * self._waiting[-1][1]:
            self._behind_m += self._waiting.pop()[1]
        if not self._waiting and not self._ledger.in_bout:
            self._behind_m = max(self._behind_m, -_BACK_MAX_M)

    def _refuse(self, piece: Piece) -> list[Event]:
        anomaly, words = _WORDS[piece.kind]
        duration_s = (piece.t_ns - piece.start_ns) / NS_PER_S
        return self.unseen(piece.t_ns, duration_s, anomaly, words.format(abs(piece.length_m)))

    def _push(self, piece: Piece) -> list[Event]:
        if piece.kind != "roll" or piece.length_m < _PUSH_MIN_M:
            return []
        p = self._params
        return [
            Push(
                t_ns=piece.t_ns,
                start_t_ns=piece.start_ns,
                push_length_m=piece.length_m,
                push_length_sigma_m=math.hypot(
                    piece.sigma_m, p.wheel_shared_sigma * piece.length_m
                ),
                push_duration_s=(piece.t_ns - piece.start_ns) / NS_PER_S,
                push_duration_sigma_s=math.sqrt(2.0) * p.stride_time_sigma_s,
                peak_speed_mps=piece.peak_mps,
                peak_speed_sigma_mps=math.hypot(
                    p.wheel_shared_sigma * piece.peak_mps, p.tick_m / p.block_s / math.sqrt(6.0)
                ),
            )
        ]

    def _stride(
        self, piece: Piece, length_m: float, sigma_m: float, moving_s: float
    ) -> list[Event]:
        """Count a step: from where the one before ended, standing included, to its own end."""
        start_ns = piece.start_ns
        if self._end_ns is not None and 0 <= start_ns - self._end_ns <= self._pause_ns:
            start_ns = self._end_ns
        self._end_ns = piece.t_ns
        cycle_s = (piece.t_ns - start_ns) / NS_PER_S
        moving_s = min(moving_s, cycle_s)
        events = self._ledger.add_stride(
            start_ns, piece.t_ns, length_m, sigma_m,
            stance_duration_s=cycle_s - moving_s, swing_duration_s=moving_s,
            shared_sigma=self._params.lift_shared_sigma if piece.kind == "lift" else None,
        )  # fmt: skip
        told = [_styled(event, piece.style) for event in events]
        told.append(self._path.pose(piece.t_ns, piece.heading_rad, piece.heading_sigma_rad))
        if piece.clipped:
            detail = "readings at the end of their range in this step; its length is less certain"
            told.append(Anomaly(t_ns=piece.t_ns, anomaly="sensor-clipped", detail=detail))
        return told


def _styled(event: Event, style: Style | None) -> Event:
    return event.model_copy(update={"style": style}) if isinstance(event, Stride) else event
