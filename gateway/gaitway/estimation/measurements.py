"""What an error-state filter can be told: each function returns ``(z, H, R)`` for ``correct``.

Noise is the standard deviation of one measurement. Where one is made at every sample of a stance,
what disturbs it (a hand that leans, a foot that rocks) lasts for many samples: divide a density by
the root of the sample period, so that a faster sensor does not make the filter surer of the same.
"""

from collections.abc import Iterable
from functools import lru_cache
from typing import Final

import numpy as np

from gaitway.estimation.error_state import ErrorStateFilter, Measurement
from gaitway.estimation.rotation import cross, rotate, skew, to_matrix
from gaitway.estimation.states import ACCEL_BIAS, ATT, GYRO_BIAS, VEL
from gaitway.samples import Floats

_IDENTITY: Final = np.eye(3)


def zero_velocity(kf: ErrorStateFilter, sigma_mps: float) -> Measurement:
    """Return that the sensor stands still (Dang & Suh 2018, Eq. 18).

    Args:
        kf: The filter.
        sigma_mps: How fast it may be moving nevertheless, per axis.
    """
    return Measurement(-kf.vel_n, _selector(kf.states, VEL.start), isotropic(sigma_mps))


def pivot_velocity(
    kf: ErrorStateFilter,
    gyro_d: Iterable[float],
    imu_to_pivot_d: Iterable[float],
    sigma_mps: float,
) -> Measurement:
    """Return that a point of the device stands still while the device turns about it.

    Dang & Suh (2018), Eq. 24, with the attitude's share of H that the print omits: the lever arm's
    velocity is known in d and has to be turned into n.

    Args:
        kf: The filter.
        gyro_d: Angular rate as measured, rad/s.
        imu_to_pivot_d: From the sensor to the point that stands still, metres.
        sigma_mps: How fast it may be moving nevertheless, per axis.
    """
    _, _, _, vx, vy, vz, w, x, y, z, *bias = kf.nominal.tolist()
    gx, gy, gz = gyro_d
    lx, ly, lz = imu_to_pivot_d
    tx, ty, tz = rotate(
        (w, x, y, z), cross((gx - bias[0], gy - bias[1], gz - bias[2]), (lx, ly, lz))
    )
    H = _selector(kf.states, VEL.start).copy()
    H[:, ATT] = ((0.0, tz, -ty), (-tz, 0.0, tx), (ty, -tx, 0.0))  # -[turning_n x]
    if kf.states == 15 and (lx or ly or lz):
        H[:, GYRO_BIAS] = to_matrix((w, x, y, z)).dot(skew((lx, ly, lz)))
    return Measurement(np.array((-vx - tx, -vy - ty, -vz - tz)), H, isotropic(sigma_mps))


def zero_rate(kf: ErrorStateFilter, gyro_d: Iterable[float], sigma_radps: float) -> Measurement:
    """Return that the device does not turn: what the gyroscope says is bias. Needs 15 states.

    Args:
        kf: The filter.
        gyro_d: Angular rate as measured, rad/s.
        sigma_radps: How fast it may be turning nevertheless, per axis, and the sensor's noise.
    """
    z = np.subtract(tuple(gyro_d), kf.gyro_bias_d)
    return Measurement(z, _selector(kf.states, GYRO_BIAS.start), isotropic(sigma_radps))


def gravity(kf: ErrorStateFilter, accel_d: Iterable[float], sigma_mps2: float) -> Measurement:
    """Return that the sensor is not accelerated: what it feels is gravity, which shows its tilt.

    With 15 states tilt and accelerometer bias become correlated, as they are: only their sum shows
    at rest.

    Args:
        kf: The filter.
        accel_d: Specific force as measured, m/s^2.
        sigma_mps2: Acceleration there may be nevertheless, per axis, and the sensor's noise; with
            9 states its unknown bias as well.
    """
    C_dn = to_matrix(kf.q_nd).T
    g_n = (0.0, 0.0, kf.gravity_mps2)
    H = np.zeros((3, kf.states))
    H[:, ATT] = C_dn.dot(skew(g_n))
    if kf.states == 15:
        H[:, ACCEL_BIAS] = np.eye(3)
    z = np.subtract(tuple(accel_d), kf.accel_bias_d) - C_dn.dot(g_n)
    return Measurement(z, H, isotropic(sigma_mps2))


@lru_cache(maxsize=16)
def _selector(states: int, first: int) -> Floats:
    H = np.zeros((3, states))
    H[:, first : first + 3] = np.eye(3)
    H.setflags(write=False)
    return H


def isotropic(sigma: float) -> Floats:
    """Return the covariance of three independent axes of one standard deviation, shape (3, 3)."""
    return _IDENTITY * sigma**2
