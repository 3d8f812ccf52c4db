"""A walker driven along a way: its motion, and what its wheels count."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.simulation.curves import Curve

_GRID_S: Final = 0.002
_BACKLASH: Final = 0.5
"""Where in a count a wheel happens to stand at the start."""


class Driven:
    """Position of a point that moves along its own heading, three columns.

    Rates are exact; positions are their integral on a fine grid, cubic between its points.

    Args:
        way: How far it has gone, one column.
        angles: Yaw, pitch and roll; yaw is the heading.
        height: Above the floor, one column.
        end_s: Where it has come to rest.
    """

    def __init__(self, way: Curve, angles: Curve, height: Curve, end_s: float) -> None:
        self._way, self._angles, self._height = way, angles, height
        self._t_s = np.arange(0.0, end_s + _GRID_S, _GRID_S)
        rates, middle = self._rates(self._t_s), self._rates(self._t_s[:-1] + 0.5 * _GRID_S)
        steps = (rates[:-1] + 4.0 * middle + rates[1:]) * (_GRID_S / 6.0)
        self._grid = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return positions or velocities, shape (n, 3)."""
        across = self._rates(t_s) if order else self._across(t_s)
        return np.hstack([across, self._height(t_s, order)])

    def _rates(self, t_s: Floats) -> Floats:
        yaw = self._angles(t_s)[:, :1]
        return np.asarray(self._way(t_s, 1) * np.hstack([np.cos(yaw), np.sin(yaw)]))

    def _across(self, t_s: Floats) -> Floats:
        inside = np.clip(t_s, 0.0, self._t_s[-1])
        low = np.minimum((inside / _GRID_S).astype(int), len(self._t_s) - 2)
        rest_s = (inside - self._t_s[low])[:, None]
        # Between grid points by Simpson's rule once more.
        ends = self._rates(inside), self._rates(self._t_s[low])
        middle = self._rates(self._t_s[low] + 0.5 * rest_s[:, 0])
        return np.asarray(self._grid[low] + (ends[1] + 4.0 * middle + ends[0]) * rest_s / 6.0)


@dataclass(frozen=True, slots=True)
class Wheels:
    """Two wheels with encoders, and what is wrong with them.

    Attributes:
        track_m: Between them.
        radius_m: As the estimator is told.
        pulses: Of one revolution.
        scale: Counts of the left and of the right relative to the right ones; 0 stuck, -1 reversed.
        slip: Relative standard deviation of what each rolls in a tenth of a second.
        first: Of the counters at the start.
        modulus: Where they wrap; never where 0.
    """

    track_m: float
    radius_m: float
    pulses: int
    scale: tuple[float, float] = (1.0, 1.0)
    slip: float = 0.0
    first: tuple[float, float] = (0.0, 0.0)
    modulus: float = 0.0

    def counts(
        self, roll: Curve, angles: Curve, on_floor: Curve, t_s: Floats, rng: np.random.Generator
    ) -> list[Floats]:
        """Return what the left and the right encoder say at times, each of shape (n, 1).

        Args:
            roll: How far the point between the wheels was rolled, one column.
            angles: Yaw, pitch and roll.
            on_floor: 1 while the wheels are on the floor and 0 while they are not, one column.
            t_s: Evenly spaced.
            rng: Draws the slip.
        """
        turning = self.track_m * 0.5 * np.diff(angles(t_s)[:, 0], prepend=angles(t_s)[0, 0])
        rolled_m = np.diff(roll(t_s)[:, 0], prepend=roll(t_s)[0, 0])
        floor = on_floor(t_s)[:, 0]
        tenth = np.floor(t_s / 0.1).astype(int)
        counts = []
        for side, scale, first in zip((-1.0, 1.0), self.scale, self.first, strict=True):
            slip = self.slip * rng.standard_normal(tenth[-1] + 1)[tenth]
            way_m = np.cumsum((rolled_m + side * turning) * floor * (1.0 + slip) * scale)
            count = np.floor(way_m / (2.0 * pi * self.radius_m) * self.pulses + _BACKLASH) + first
            counts.append((np.mod(count, self.modulus) if self.modulus else count)[:, None])
        return counts


class Gate:
    """A curve that is 0 in some intervals and 1 elsewhere; its rate is not asked for.

    Args:
        closed_s: Start and end of each interval.
    """

    def __init__(self, closed_s: Sequence[tuple[float, float]]) -> None:
        self._closed_s = closed_s

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return ones and zeros, shape (n, 1)."""
        open_ = np.ones((len(t_s), 1)) * (order == 0)
        for start, end in self._closed_s:
            open_[(t_s > start) & (t_s <= end)] = 0.0
        return open_
