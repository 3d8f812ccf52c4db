"""A foot that rolls over the floor without slipping: from heel over the flat sole to the ball."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gaitway.samples import Floats

_GRID_RAD = np.linspace(-1.2, 2.0, 6401)


@dataclass(frozen=True)
class Sole:
    """The outline of a shod foot in the sagittal plane, seen from the ankle.

    The foot pitches by ``phi`` (radians, positive with the heel up). Heel and ball are arcs; the
    ankle's height is the greater of what the two ask for, rounded off as a sole rounds it:
    ``h = s log(exp(h_heel / s) + exp(h_ball / s)) - s log 2``. Rolling without slip then moves the
    ankle forward by ``h d phi``. All is smooth, and at ``phi = 0`` the foot is flat.

    Attributes:
        ankle_m: Height of the ankle joint over the floor with the foot flat.
        heel_m: From below the ankle back to where the heel arc meets the flat sole.
        ball_m: From below the ankle forward to where the forefoot arc begins.
        heel_radius_m: Of the heel.
        ball_radius_m: Of the forefoot.
        softness_m: ``s``: the softer, the more the flat foot rocks.
    """

    ankle_m: float
    heel_m: float
    ball_m: float
    heel_radius_m: float
    ball_radius_m: float
    softness_m: float

    @property
    def flat_rad(self) -> float:
        """Pitch to either side within which the foot counts as flat."""
        return 2.0 * self.softness_m / (self.heel_m + self.ball_m)

    def height(self, phi: Floats) -> Floats:
        """Return the ankle's height, shape (n,)."""
        heel, ball = self._arcs(phi)
        soft = self.softness_m
        height: Floats = soft * (np.logaddexp(heel / soft, ball / soft) - np.log(2.0))
        return height

    def advance(self, phi: Floats) -> Floats:
        """Return how far forward the ankle is of where it is with the foot flat, shape (n,)."""
        at = np.clip(np.searchsorted(_GRID_RAD, phi) - 1, 0, len(_GRID_RAD) - 2)
        start = _GRID_RAD[at]
        return self._advances[at] + _gauss(self, start, phi)

    def slope(self, phi: Floats) -> Floats:
        """Return ``dh / d phi``: how far the point of contact is ahead of the ankle, (n,)."""
        heel, ball = self._arcs(phi)
        weight = 1.0 / (1.0 + np.exp((heel - ball) / self.softness_m))
        heel_slope = -self.heel_m * np.cos(phi) - (self.ankle_m - self.heel_radius_m) * np.sin(phi)
        ball_slope = self.ball_m * np.cos(phi) - (self.ankle_m - self.ball_radius_m) * np.sin(phi)
        slope: Floats = (1.0 - weight) * heel_slope + weight * ball_slope
        return slope

    @cached_property
    def _advances(self) -> Floats:
        pieces = _gauss(self, _GRID_RAD[:-1], _GRID_RAD[1:])
        total = np.concatenate([[0.0], np.cumsum(pieces)])
        flat: Floats = total - np.interp(0.0, _GRID_RAD, total)
        return flat

    def _arcs(self, phi: Floats) -> tuple[Floats, Floats]:
        """Return the height of the ankle when standing on the heel arc and on the ball arc."""
        sine, cosine = np.sin(phi), np.cos(phi)
        heel = self.heel_radius_m - self.heel_m * sine
        ball = self.ball_radius_m + self.ball_m * sine
        return (
            heel + (self.ankle_m - self.heel_radius_m) * cosine,
            ball + (self.ankle_m - self.ball_radius_m) * cosine,
        )


def _gauss(sole: Sole, start: Floats, stop: Floats) -> Floats:
    """Return the integral of the height over pitch by Gauss' three-point rule."""
    middle, half = 0.5 * (start + stop), 0.5 * (stop - start)
    offset = np.sqrt(0.6) * half
    ends = sole.height(middle - offset) + sole.height(middle + offset)
    integral: Floats = half * (5.0 * ends + 8.0 * sole.height(middle)) / 9.0
    return integral
