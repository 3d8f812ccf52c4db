"""What the shank says of itself while its foot is on the floor: tilt and velocity.

While the foot is on the floor, the shank turns about the ankle, and the ankle moves on as the foot
rolls over heel, sole and toes: together a rocker. With the IMU a height ``r`` above the ankle its
horizontal velocity is

    v = r (w x z + k mean(w x z)),

``w`` the angular rate, ``z`` up, the mean over the roll-over, ``k`` how fast the rocker carries the
ankle relative to how fast the IMU turns about it; for an ankle that stands still 0. Specific force
less gravity, integrated over the roll-over, is that velocity plus a line ``a + G t``: the intercept
is the velocity not known, the slope the gravity that a wrong tilt lets in. So a straight line
through the difference of the two gives tilt and velocity, without any of the past. In standing
``k`` is zero.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation.rotation import from_gravity, from_rotation_vector, to_matrix
from gaitway_plugins.shank.track import Piece

_ROUNDS: Final = 4
"""Of levelling: each leaves the square of the tilt error before, in radians."""
SKIN_WOBBLE_MPS: Final = 0.02
"""How fast the IMU moves against the bone while the foot is flat, as a standard deviation."""


@dataclass(frozen=True, slots=True, eq=False)
class RollOver:
    """What a window on the floor says; frame n is level, its heading that of frame c.

    Attributes:
        C_nc: Takes components of the track's frame to n, shape (3, 3).
        vel_n: Velocity of the IMU at each sample, vertical 0, shape (k, 3).
        rms_mps: How badly the model fits.
    """

    C_nc: Floats
    vel_n: Floats
    rms_mps: float


def fit_roll_over(
    piece: Piece, *, height_m: float, roll_share: float, gravity_mps2: float
) -> RollOver:
    """Fit the model above.

    Args:
        piece: The samples of the window.
        height_m: Height ``r`` of the IMU above what it turns about.
        roll_share: How fast that moves on itself, ``k``.
        gravity_mps2: What the accelerometer reads at rest.
    """
    time_s = piece.time_s
    C_nc = to_matrix(from_gravity(piece.accel_c.mean(axis=0).tolist()))
    for _ in range(_ROUNDS):
        inertial = velocity_gain(piece.accel_c @ C_nc.T, gravity_mps2, piece.period_s)
        model = height_m * _turning(piece.gyro_c @ C_nc.T, roll_share)
        intercept, slope, rest = _line(time_s, inertial[:, :2] - model)
        turn = (slope[1] / gravity_mps2, -slope[0] / gravity_mps2, 0.0)
        C_nc = to_matrix(from_rotation_vector(turn)) @ C_nc
    vel_n = np.zeros_like(inertial)
    vel_n[:, :2] = inertial[:, :2] - intercept - np.outer(time_s, slope)
    return RollOver(C_nc, vel_n, float(np.sqrt(np.mean(rest**2))))


def pivot_depth(piece: Piece, C_nc: Floats, gravity_mps2: float) -> tuple[float, float]:
    """Return how far below the IMU it turns, and the standard deviation of that, metres.

    The foot-flat form of the model with nothing known beforehand: ``v = h w + a + G t`` along the
    way the shank leans. Over a foot on the floor ``h`` is the height above the ankle; in a leg that
    swings freely it is negative, since the knee is above.

    Args:
        piece: The samples.
        C_nc: Levels them, roughly.
        gravity_mps2: What the accelerometer reads at rest.
    """
    gyro_n = piece.gyro_c @ C_nc.T
    across = np.stack([gyro_n[:, 1], -gyro_n[:, 0]], axis=1)
    mean = across.mean(axis=0)
    way = mean / max(float(np.hypot(*mean)), 1e-9)
    gain = velocity_gain(piece.accel_c @ C_nc.T, gravity_mps2, piece.period_s)
    _, _, rate = _line(piece.time_s, (across @ way)[:, None])
    spread = float((rate**2).sum())
    if spread == 0.0:
        return 0.0, float("inf")
    depth_m = float(rate[:, 0] @ (gain[:, :2] @ way)) / spread
    return depth_m, SKIN_WOBBLE_MPS / float(np.sqrt(spread / len(rate)))


def velocity_gain(accel_n: Floats, gravity_mps2: float, period_s: float) -> Floats:
    """Return the velocity gained since the first sample, shape (k, 3), by the trapezoid rule."""
    free = accel_n - (0.0, 0.0, gravity_mps2)
    gain = np.zeros_like(free)
    np.cumsum(0.5 * period_s * (free[1:] + free[:-1]), axis=0, out=gain[1:])
    return gain


def _turning(gyro_n: Floats, roll_share: float) -> Floats:
    """Return ``w x z`` plus ``k`` times its mean, horizontal, shape (k, 2)."""
    across = np.stack([gyro_n[:, 1], -gyro_n[:, 0]], axis=1)
    return np.asarray(across + roll_share * across.mean(axis=0))


def _line(time_s: Floats, values: Floats) -> tuple[Floats, Floats, Floats]:
    """Return intercept, slope and what is left of a least-squares line, per column."""
    centred = time_s - time_s.mean()
    slope = centred @ values / (centred @ centred)
    intercept = values.mean(axis=0) - slope * time_s.mean()
    return intercept, slope, values - intercept - np.outer(time_s, slope)
