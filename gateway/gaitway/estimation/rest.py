"""Standing still long enough to learn from it: tilt and gyroscope bias."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from gaitway.estimation.error_state import ErrorStateFilter
from gaitway.estimation.measurements import gravity
from gaitway.estimation.rotation import Vector, from_gravity
from gaitway.estimation.states import ACCEL_BIAS, ATT, GYRO_BIAS, POS, VEL

_REST_ACCEL_MPS2: Final = 0.01
"""Noise of a mean specific force at rest, and the acceleration a hand may still give."""


@dataclass(frozen=True, slots=True)
class Rest:
    """What a sensor read while it stood still.

    Attributes:
        accel_d: Mean specific force, m/s^2.
        gyro_d: Mean angular rate, rad/s: the gyroscope's bias.
        duration_s: For how long.
    """

    accel_d: Vector
    gyro_d: Vector
    duration_s: float


class RestDetector:
    """Finds windows in which nothing moved, by the spread of each axis.

    Spread, not size, because a bias or a tilt is no movement; but a mean rate beyond
    ``gyro_max_radps`` is taken for a slow turn. Costs the same for any window.

    Args:
        period_s: Of the samples.
        window_s: How long it has to be still.
        accel_std_max_mps2: Greatest standard deviation of an accelerometer axis.
        gyro_std_max_radps: Greatest standard deviation of a gyroscope axis.
        gyro_max_radps: Greatest mean of a gyroscope axis.
    """

    def __init__(
        self,
        period_s: float,
        *,
        window_s: float,
        accel_std_max_mps2: float,
        gyro_std_max_radps: float,
        gyro_max_radps: float,
    ) -> None:
        self._size: Final = max(2, round(window_s / period_s))
        self._period_s = period_s
        self._var_max = np.repeat([accel_std_max_mps2**2, gyro_std_max_radps**2], 3)
        self._gyro_max = gyro_max_radps
        self._ring = np.zeros((self._size, 6))
        self._offset = np.zeros(6)
        self._pushed = 0
        self._sums = np.zeros((2, 6))

    def push(self, accel_d: Vector, gyro_d: Vector) -> Rest | None:
        """Take the next sample; return the rest if the window that ends here is one."""
        row = np.array(accel_d + gyro_d)
        if self._pushed == 0:
            self._offset = row
        # Relative to a recent mean: a variance is the small difference of two squares.
        row = row - self._offset
        slot = self._pushed % self._size
        old = self._ring[slot]
        self._sums += (row - old, row * row - old * old)
        old[:] = row
        self._pushed += 1
        if slot == self._size - 1:
            shift = self._ring.mean(axis=0)
            self._offset = self._offset + shift
            self._ring -= shift
            self._sums[:] = self._ring.sum(axis=0), (self._ring**2).sum(axis=0)
        return self._verdict() if self._pushed >= self._size else None

    def _verdict(self) -> Rest | None:
        mean, square = self._sums / self._size
        if (square - mean * mean > self._var_max).any():
            return None
        ax, ay, az, gx, gy, gz = (mean + self._offset).tolist()
        if max(abs(gx), abs(gy), abs(gz)) > self._gyro_max:
            return None
        return Rest((ax, ay, az), (gx, gy, gz), self._size * self._period_s)


def align_at_rest(
    kf: ErrorStateFilter,
    rest: Rest,
    *,
    accel_bias_sigma_mps2: float,
    gyro_bias_sigma_radps: float,
    velocity_sigma_mps: float,
) -> None:
    """Start a filter from a rest: tilt from gravity, the gyroscope's bias from what it reads.

    The accelerometer's bias starts at 0, correlated with the tilt that it spoils.

    Args:
        kf: The filter; whatever it held is overwritten.
        rest: What the sensor read.
        accel_bias_sigma_mps2: Standard deviation of an accelerometer bias at turn-on.
        gyro_bias_sigma_radps: How far the mean rate may be from the bias.
        velocity_sigma_mps: How fast the sensor may be moving nevertheless.
    """
    kf.accel_bias_d[:] = 0.0
    kf.gyro_bias_d[:] = rest.gyro_d
    if kf.states == 15:
        kf.set_block(GYRO_BIAS, gyro_bias_sigma_radps**2)
        kf.set_block(ACCEL_BIAS, accel_bias_sigma_mps2**2)
    level_at_rest(
        kf,
        rest,
        velocity_sigma_mps=velocity_sigma_mps,
        accel_bias_sigma_mps2=0.0 if kf.states == 15 else accel_bias_sigma_mps2,
    )


def level_at_rest(
    kf: ErrorStateFilter,
    rest: Rest,
    *,
    velocity_sigma_mps: float,
    accel_bias_sigma_mps2: float = 0.0,
) -> None:
    """Start position, velocity and attitude anew; what is known of the biases stays.

    Position and heading are 0 by definition, as a new frame n begins here.

    Args:
        kf: The filter.
        rest: What the sensor read.
        velocity_sigma_mps: How fast the sensor may be moving nevertheless.
        accel_bias_sigma_mps2: Accelerometer bias that the filter does not know about.
    """
    kf.pos_n[:] = 0.0
    kf.vel_n[:] = 0.0
    kf.q_nd = from_gravity(np.subtract(rest.accel_d, kf.accel_bias_d).tolist())
    kf.set_block(POS, 0.0)
    kf.set_block(VEL, velocity_sigma_mps**2)
    kf.set_block(ATT, np.diag([1.0, 1.0, 0.0]))
    kf.correct(gravity(kf, rest.accel_d, math.hypot(_REST_ACCEL_MPS2, accel_bias_sigma_mps2)))
