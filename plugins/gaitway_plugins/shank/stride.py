"""From one moment on the floor to the next: the way between by strapdown integration.

Tilt and velocity are known at both ends. What gyroscope and gravity disagree on at the end is
spread over the stride in proportion to how much the shank turned, because scale errors and lost
samples do harm there; what velocity disagrees on is spread evenly, as a constant force would.
"""

from dataclasses import dataclass

import numpy as np

from gaitway.api import Floats
from gaitway_plugins.shank.footing import Footing
from gaitway_plugins.shank.rollover import velocity_gain
from gaitway_plugins.shank.track import Piece


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """The IMU's way through one stride; frame n is level, its heading that of the track.

    Attributes:
        pos_n: Since the first sample, shape (k, 3), back at the same height at the end.
        vel_n: Shape (k, 3).
        C_nc: Levelling at the start, shape (3, 3).
        tilt_step_rad: How far gyroscope and gravity disagreed.
        closing_mps2: Force per mass along the way that had to be added to meet the velocity at
            the end.
    """

    pos_n: Floats
    vel_n: Floats
    C_nc: Floats
    tilt_step_rad: float
    closing_mps2: float

    @property
    def length_m(self) -> float:
        """Horizontal distance from the first sample to the last."""
        return float(np.hypot(*self.pos_n[-1, :2]))

    @property
    def height_range_m(self) -> float:
        """From the lowest to the highest it came."""
        return float(np.ptp(self.pos_n[:, 2]))

    @property
    def detour(self) -> float:
        """How much longer the way was than the distance."""
        steps_m = np.hypot(*np.diff(self.pos_n[:, :2], axis=0).T)
        return float(steps_m.sum() / max(self.length_m, 1e-6))

    @property
    def speed_ratio(self) -> float:
        """How much faster its fastest moment was than both ends."""
        speed_mps = np.hypot(*self.vel_n[:, :2].T)
        return float(speed_mps.max() / max(speed_mps[0], speed_mps[-1], 1e-6))

    @property
    def direction(self) -> Floats:
        """Horizontal direction of the way, a unit vector, shape (2,)."""
        return _direction(self.pos_n)


def find_way(piece: Piece, before: Footing, after: Footing, gravity_mps2: float) -> Way:
    """Return the way through a stride.

    Args:
        piece: Its samples, from that of ``before`` to that of ``after``.
        before: Where it begins.
        after: Where it ends.
        gravity_mps2: What the accelerometer reads at rest.
    """
    C_nc = before.fit.C_nc
    turn_n = _tilt_between(C_nc, after.fit.C_nc)
    accel_n = _turned(piece.accel_c @ C_nc.T, turn_n, _share_of_turning(piece))
    gain = velocity_gain(accel_n, gravity_mps2, piece.period_s)
    # Frame n of the footing after, as the one before sees it, differs by this stride's drift.
    end_n = _turned((C_nc @ after.fit.C_nc.T @ after.vel_n)[None], turn_n, np.ones(1))[0]
    missing = end_n - before.vel_n - gain[-1]
    part = piece.time_s / piece.duration_s
    vel_n = before.vel_n + gain + np.outer(part, missing)
    pos_n = np.zeros_like(vel_n)
    np.cumsum(0.5 * piece.period_s * (vel_n[1:] + vel_n[:-1]), axis=0, out=pos_n[1:])
    pos_n[:, 2] -= pos_n[-1, 2] * part
    closing = float(missing[:2] @ _direction(pos_n)) / piece.duration_s
    return Way(pos_n, vel_n, C_nc, float(np.linalg.norm(turn_n)), closing)


def _direction(pos_n: Floats) -> Floats:
    end = pos_n[-1, :2]
    return np.asarray(end / max(float(np.hypot(*end)), 1e-9))


def _tilt_between(before_nc: Floats, after_nc: Floats) -> Floats:
    """Return the rotation that takes what ``before_nc`` calls the other's up to up, shape (3,)."""
    x, y, z = before_nc @ after_nc[2]
    sine = float(np.hypot(x, y))
    angle_rad = float(np.arctan2(sine, z))
    return np.array([y, -x, 0.0]) * (angle_rad / sine if sine > 0.0 else 0.0)


def _share_of_turning(piece: Piece) -> Floats:
    """Return how much of a stride's turning was done up to each sample, shape (k,), 0 to 1."""
    rate = piece.rate_radps
    turned = np.zeros(len(rate))
    np.cumsum(rate[1:] + rate[:-1], out=turned[1:])
    return turned / turned[-1] if turned[-1] > 0.0 else np.linspace(0.0, 1.0, len(rate))


def _turned(vectors: Floats, turn: Floats, share: Floats) -> Floats:
    """Return vectors, shape (k, 3), each turned by its share of a rotation vector (Rodrigues)."""
    angle_rad = float(np.linalg.norm(turn))
    if angle_rad == 0.0:
        return vectors
    axis = turn / angle_rad
    along = np.outer(vectors @ axis, axis)
    cosine, sine = np.cos(angle_rad * share)[:, None], np.sin(angle_rad * share)[:, None]
    return np.asarray(along + cosine * (vectors - along) + sine * np.cross(axis, vectors))
