"""Whether the tip leaves the floor when the crutch is swung forward."""

from typing import Final

from gaitway.api import Floats

SWING_RADPS: Final = 0.3
SWING_RAD: Final = 0.15
SWING_S: Final = 0.15
"""The top goes backward at such a rate, by so much, for so long: a swing."""
DRAG_NEWTON: Final = 8.0
"""A tip in the air reads less, offset and noise of the sensor included."""
SHARE: Final = 0.6
SWINGS: Final = 2
"""Dragged in this many swings in a row, each for this share of it."""


class DragCheck:
    """Looks at the force during forward swings, which the pitch rate alone tells.

    While the tip stands the crutch turns forward over it, pitch rising; pitch falls fast only when
    the tip is brought forward. A force meanwhile means that it rubs along the floor.

    Args:
        force_min_newton: Of a stance; drags are lighter or heavier.
        period_s: Of the samples.

    Attributes:
        level_newton: Mean force of the last swing.
    """

    def __init__(self, force_min_newton: float, period_s: float) -> None:
        self._touching_newton = min(DRAG_NEWTON, 0.5 * force_min_newton)
        self._period_s = period_s
        self._angle_rad = self._sum_newton = 0.0
        self._count = self._touched = self._dragged = 0
        self.level_newton = 0.0

    def extend(self, pitch_rate: Floats, force: Floats) -> bool:
        """Take samples, shape (n,) each; return whether a drag was found in them."""
        found = False
        for rate, newton in zip(pitch_rate.tolist(), force.tolist(), strict=True):
            if rate < -SWING_RADPS:
                self._angle_rad -= rate * self._period_s
                self._sum_newton += newton
                self._count += 1
                self._touched += newton > self._touching_newton
            elif self._count:
                found |= self._swung()
        return found

    def _swung(self) -> bool:
        count, touched, angle = self._count, self._touched, self._angle_rad
        level = self._sum_newton / count
        self._angle_rad = self._sum_newton = 0.0
        self._count = self._touched = 0
        if angle < SWING_RAD or count * self._period_s < SWING_S:
            return False
        self.level_newton = level
        self._dragged = self._dragged + 1 if touched > SHARE * count else 0
        return self._dragged >= SWINGS
