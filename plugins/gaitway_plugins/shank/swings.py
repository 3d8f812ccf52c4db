"""Swings of the shank, found in its sagittal rate as the samples come."""

from enum import Enum, auto
from typing import Final, NamedTuple

from gaitway_plugins.shank.params import ShankParams


class Mark(Enum):
    """What a swing detector has found."""

    TOE_OFF = auto()
    """A swing is under way; it began ``at``, where the rate changed sign."""
    CONTACT = auto()
    """The swing is over; stance begins ``at``."""
    TOO_LONG = auto()
    """What looked like a swing lasts too long for one."""


class Found(NamedTuple):
    """Something a swing detector has found.

    Attributes:
        mark: What.
        at: Number of the sample at which it was.
    """

    mark: Mark
    at: int


class SwingDetector:
    """Tells swings by how far and how fast the shank turns backward (top behind the ankle).

    The rate about d's y axis is positive while the shank leans forward over the standing foot and
    strongly negative in swing. A run of rate below ``-swing_edge_radps`` is a swing as soon as it
    has turned the shank far enough and was fast enough; small reversals after a contact are
    neither.

    Args:
        params: Of the shank.
        period_s: Of the samples.
    """

    def __init__(self, params: ShankParams, period_s: float) -> None:
        self._period_s: Final = period_s
        self._edge: Final = -params.swing_edge_radps
        self._angle_min: Final = params.swing_angle_min_rad
        self._rate_min: Final = params.swing_rate_min_radps
        self._longest: Final = round(params.max_swing_s / period_s)
        self._index = -1
        self._begin = 0
        self._angle_rad = 0.0
        self._peak_radps = 0.0
        self._known = False
        self._told_long = False

    @property
    def turning_back(self) -> bool:
        """Whether the shank turns backward, be it in a swing or not."""
        return self._angle_rad > 0.0

    def push(self, rate_radps: float) -> Found | None:
        """Take the next sample's smoothed rate about y; return what it shows."""
        self._index += 1
        if rate_radps >= self._edge:
            return self._end()
        if self._angle_rad == 0.0:
            self._begin = self._index
        self._angle_rad -= rate_radps * self._period_s
        self._peak_radps = max(self._peak_radps, -rate_radps)
        if self._index - self._begin > self._longest and self._known and not self._told_long:
            self._told_long = True
            return Found(Mark.TOO_LONG, self._index)
        enough = self._angle_rad >= self._angle_min and self._peak_radps >= self._rate_min
        if self._known or not enough or self._index - self._begin > self._longest:
            return None
        self._known = True
        return Found(Mark.TOE_OFF, self._begin)

    def _end(self) -> Found | None:
        swing = self._known and not self._told_long
        self._angle_rad = self._peak_radps = 0.0
        self._known = self._told_long = False
        return Found(Mark.CONTACT, self._index) if swing else None
