"""From anchor to anchor: how far, how high, when in the air."""

from dataclasses import dataclass

import numpy as np

from gaitway.api import Floats
from gaitway_plugins.ankle.lever import Lever
from gaitway_plugins.ankle.motion import pivot_speed_mps, rotated
from gaitway_plugins.ankle.navigator import Anchor
from gaitway_plugins.ankle.params import AnkleParams

_FLAT_M = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """The pivot's way from one stance to the next.

    Attributes:
        before: Where it began.
        after: Where it ended.
        step_n: From there to there, shape (3,).
        covariance: Of step_n, shape (3, 3).
        lift: Number of the sample at which the foot left the floor.
        contact: Number of the one at which it came down.
        peak_mps: Greatest speed of the pivot.
        pendulum: Share of the turning that is about the axis across the way, 0 to 1.
        arc_rad: How far the leg turned back and forth about that axis.
        doubtful: It closed only with much more noise than the sensor has.
    """

    before: Anchor
    after: Anchor
    step_n: Floats
    covariance: Floats
    lift: int
    contact: int
    peak_mps: float
    pendulum: float
    arc_rad: float
    doubtful: bool

    @property
    def length_m(self) -> float:
        """Horizontal length."""
        return float(np.hypot(*self.step_n[:2]))

    @property
    def height_m(self) -> float:
        """How much higher it ended."""
        return float(self.step_n[2])

    @property
    def length_sigma_m(self) -> float:
        """Standard deviation of the length."""
        x, y = self.step_n[:2] / max(self.length_m, _FLAT_M)
        along = np.array([x, y, 0.0])
        return float(np.sqrt(along @ self.covariance @ along))

    @property
    def across_sigma_m(self) -> float:
        """Standard deviation across the way, horizontally."""
        x, y = self.step_n[:2] / max(self.length_m, _FLAT_M)
        across = np.array([-y, x, 0.0])
        return float(np.sqrt(across @ self.covariance @ across))

    @property
    def height_sigma_m(self) -> float:
        """Standard deviation of the height."""
        return float(np.sqrt(self.covariance[2, 2]))


def swing_of(
    path: Floats, gyro_d: Floats, lever: Lever, params: AnkleParams
) -> tuple[int, int, float]:
    """Return lift, contact (rows of the path) and the greatest speed of the pivot.

    Args:
        path: Position, velocity and ``q_nd`` at each sample, shape (n, 10).
        gyro_d: Angular rate, shape (n, 3).
        lever: From pivot to IMU.
        params: Of the ankle.
    """
    speed = pivot_speed_mps(path, gyro_d, lever)
    peak = int(np.argmax(speed))
    before = np.flatnonzero(speed[:peak] < params.lift_speed_share * speed[peak])
    after = np.flatnonzero(speed[peak:] < params.contact_speed_share * speed[peak])
    lift = int(before[-1]) if len(before) else 0
    contact = peak + int(after[0]) if len(after) else len(speed) - 1
    return lift, contact, float(speed[peak])


def pendulum_share(path: Floats, gyro_d: Floats, step_n: Floats) -> float:
    """Return the share of the squared rate that is about the horizontal axis across a step.

    A leg swings in the direction it goes, whatever the mounting; a hand does not.

    Args:
        path: As for ``swing_of``.
        gyro_d: Angular rate, shape (n, 3).
        step_n: The step, shape (3,).
    """
    turning = _about_across(path, gyro_d, step_n)
    return float((turning**2).sum() / max((gyro_d**2).sum(), _FLAT_M))


def swung_rad(path: Floats, gyro_d: Floats, step_n: Floats, period_s: float) -> float:
    """Return how far the leg turned back and forth about the horizontal axis across a step.

    Args:
        path: As for ``swing_of``.
        gyro_d: Angular rate without its bias, shape (n, 3).
        step_n: The step, shape (3,).
        period_s: Of the samples.
    """
    return float(np.ptp(np.cumsum(_about_across(path, gyro_d, step_n)))) * period_s


def _about_across(path: Floats, gyro_d: Floats, step_n: Floats) -> Floats:
    length = max(float(np.hypot(*step_n[:2])), _FLAT_M)
    across = np.array([-step_n[1], step_n[0], 0.0]) / length
    return np.asarray(rotated(path[:, 6:10], gyro_d) @ across)
