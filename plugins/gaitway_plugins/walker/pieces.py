"""Pieces of a way: a roll from stop to stop or from step to step, a lift, and what is neither."""

from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

import numpy as np

from gaitway.api import Floats
from gaitway_plugins.walker.fix import Fix
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.valleys import Valleys

Style = Literal["continuous", "step-by-step", "full-lift", "back-tips"]


class Piece(NamedTuple):
    """A part of the way.

    Attributes:
        kind: ``roll`` and ``lift`` carry the walker on; ``drag`` moved it without wheels and
            without a lift; ``carried`` was too long, too high or not set down; ``lost`` was in the
            air while samples were missing or clipped, or longer than any step.
        start_ns: When it began.
        t_ns: When it ended.
        length_m: Of the body's origin, forward positive.
        sigma_m: Its standard deviation.
        way_n: Where it led, horizontally, shape (2,).
        heading_rad: At its end.
        heading_sigma_rad: Its standard deviation.
        peak_mps: Fastest rolling.
        style: Of the step it makes.
        clipped: A reading was at the end of its range.
    """

    kind: Literal["roll", "lift", "drag", "carried", "lost"]
    start_ns: int
    t_ns: int
    length_m: float
    sigma_m: float
    way_n: Floats
    heading_rad: float
    heading_sigma_rad: float
    peak_mps: float
    style: Style | None
    clipped: bool


class Roll:
    """Wheels that turn, from one stop to the next.

    Args:
        params: Of the walker.
        before: The fix before the first that rolls.
    """

    def __init__(self, params: WalkerParams, before: Fix, rest_pitch_rad: float | None) -> None:
        self._params = params
        self._rest_pitch_rad = before.pitch_rad if rest_pitch_rad is None else rest_pitch_rad
        self._fixes = [before]
        self._valleys = Valleys(params.valley_share, params.valley_min_mps)
        self._cut = False
        self._forward = 0
        self.stopped_s = 0.0

    def push(self, fix: Fix) -> list[Piece]:
        """Take the next fix; return the step that the speed now shows to be over."""
        self._fixes.append(fix)
        self.stopped_s = 0.0 if fix.rolling else self.stopped_s + fix.duration_s
        turned = self._reverse(fix)
        if len(self._fixes) < 3:
            return turned
        speeds = [abs(f.speed_mps) for f in self._fixes[-3:]]
        valley = self._valleys.push(0.25 * speeds[0] + 0.5 * speeds[1] + 0.25 * speeds[2])
        if valley is None or self.stopped_s:
            return turned
        end = len(self._fixes) - 2 - valley
        if end < 1:
            return turned
        whole = self._fixes[end].t_ns - self._fixes[0].t_ns >= 1e9 * self._params.min_step_s
        far = abs(self._fixes[end].travel_m - self._fixes[0].travel_m) >= self._params.min_step_m
        return [*turned, *self._cut_at(end)] if whole and far else turned

    def finish(self) -> Piece:
        """Return the last step, now that the wheels have stopped."""
        while len(self._fixes) > 2 and not self._fixes[-1].rolling:
            self._fixes.pop()
        start, end = self._fixes[0], self._fixes[-1]
        long = abs(end.travel_m - start.travel_m) > self._params.single_roll_m
        return self._piece(self._fixes, "continuous" if self._cut or long else "step-by-step")

    def _reverse(self, fix: Fix) -> list[Piece]:
        """Cut where the wheels begin to turn the other way."""
        sign = (fix.speed_mps > 0.0) - (fix.speed_mps < 0.0)
        turned = fix.rolling and sign * self._forward < 0
        if fix.rolling:
            self._forward = sign or self._forward
        if not turned or len(self._fixes) < 3:
            return []
        piece = self._piece(self._fixes[:-1], "continuous" if self._cut else "step-by-step")
        del self._fixes[:-2]
        self._valleys = Valleys(self._params.valley_share, self._params.valley_min_mps)
        self._cut = False
        return [piece]

    def _cut_at(self, end: int) -> list[Piece]:
        piece = self._piece(self._fixes[: end + 1], "continuous")
        del self._fixes[:end]
        self._cut = True
        return [piece]

    def _piece(self, fixes: Sequence[Fix], style: Style) -> Piece:
        start, end = fixes[0], fixes[-1]
        length_m = end.travel_m - start.travel_m
        p = self._params
        tipped_s = sum(
            f.duration_s
            for f in fixes[1:]
            if f.rolling and abs(f.pitch_rad - self._rest_pitch_rad) > p.back_tips_rad
        )
        rolled_s = sum(f.duration_s for f in fixes[1:] if f.rolling)
        tipped = tipped_s >= max(0.15, 0.25 * rolled_s)
        quantum_m = 0.5 * p.tick_m
        return Piece(
            kind="roll",
            start_ns=fixes[1].start_ns,
            t_ns=end.t_ns,
            length_m=length_m,
            sigma_m=float(np.hypot(p.slip_sigma_m * np.sqrt(abs(length_m)), quantum_m)),
            way_n=(end.path_n - start.path_n)[:2],
            heading_rad=end.heading_rad,
            heading_sigma_rad=end.heading_sigma_rad,
            peak_mps=max(abs(f.speed_mps) for f in fixes[1:]),
            style="back-tips" if tipped else style,
            clipped=False,
        )


_DRAG_M: Final = 0.12
"""Less without wheels and without a lift is leaning and pushing."""
_UNKNOWN_M: Final = 0.25
"""A length with a larger standard deviation is none."""
_SET_DOWN_M: Final = 0.08
"""A walker that ended so much higher or lower was put somewhere else."""


class Flight:
    """Neither standing nor rolling: a lift, a drag, being carried, or hands that shake it.

    Args:
        params: Of the walker.
        before: The fix before the first of it.
    """

    def __init__(self, params: WalkerParams, before: Fix) -> None:
        self._params = params
        self._start = before
        self._last = before
        self._began_ns = before.t_ns
        self._moved_ns = before.t_ns
        self._rise_m = 0.0
        self._clipped = False
        self._bridged = False
        self._still = 0
        self.told = False

    @property
    def duration_s(self) -> float:
        """For how long it has lasted, the still end not."""
        return (self._moved_ns - self._began_ns) / 1e9

    @property
    def settled(self) -> bool:
        """Whether it has stood long enough."""
        return self._still >= 2

    @property
    def paused(self) -> bool:
        """Whether it stands, if only for a block."""
        return self._still > 0

    @property
    def lifted(self) -> bool:
        """Whether it left the floor for certain."""
        return self._rise_m > 3.0 * self._params.min_rise_m

    def push(self, fix: Fix) -> None:
        """Take the next fix."""
        self._last = fix
        if fix.still:
            self._still += 1
            return
        self._still = 0
        self._moved_ns = fix.t_ns
        self._clipped |= fix.clipped
        self._bridged |= fix.bridged
        if self.duration_s <= self._params.max_lift_s:
            self._rise_m = max(self._rise_m, float(fix.path_n[2] - self._start.path_n[2]))

    def finish(self) -> Piece | None:
        """Return what it was, if it moved the walker."""
        start, end, p = self._start, self._last, self._params
        way_n = (end.path_n - start.path_n)[:2]
        length_m = float(np.hypot(*way_n))
        sigma_m = float(np.sqrt(0.5 * (end.path_var[0] + end.path_var[1]) + p.lift_sigma_m**2))
        down_m = abs(float(end.path_n[2] - start.path_n[2]))
        middle = 0.5 * (start.heading_rad + end.heading_rad)
        ahead = float(np.dot(way_n, (np.cos(middle), np.sin(middle))))
        # Across a gap or a clipped reading, and by the paper, who moves without wheels was lifted.
        unseen = self._bridged or self._clipped
        rose = self._rise_m >= p.min_rise_m or unseen or p.method == "published"
        off_floor = down_m > max(_SET_DOWN_M, 3.0 * float(np.sqrt(end.path_var[2])))
        kind: Literal["lift", "drag", "carried", "lost"]
        if self.duration_s > p.max_lift_s or self._rise_m > p.max_rise_m or off_floor:
            if not self.lifted:
                return None
            kind = "carried"
        elif length_m < (p.min_step_m if rose else _DRAG_M) or length_m < 2.0 * sigma_m:
            return None
        elif length_m > p.max_step_m or sigma_m > _UNKNOWN_M:
            kind = "lost"
        else:
            kind = "lift" if rose else "drag"
        return Piece(
            kind=kind,
            start_ns=self._began_ns,
            t_ns=self._moved_ns,
            length_m=float(np.copysign(length_m, ahead)),
            sigma_m=sigma_m * (2.0 if self._clipped else 1.0),
            way_n=way_n,
            heading_rad=end.heading_rad,
            heading_sigma_rad=end.heading_sigma_rad,
            peak_mps=0.0,
            style="full-lift" if kind == "lift" else None,
            clipped=self._clipped,
        )
