"""What the walker tells its filter, as ``(z, H, R)``: Doan & Pham (2019) with the errata.

The attitude error is a rotation vector in n (``gaitway.estimation.error_state``), so every
``2 C^T K(..) q_e`` of the paper becomes a plain cross product with that vector.
"""

from collections.abc import Iterable

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import ATT, GYRO_BIAS, POS, VEL, ErrorStateFilter, Measurement
from gaitway.estimation.rotation import skew, to_matrix


def rolling_velocity(
    kf: ErrorStateFilter,
    mean_vel_n: Floats,
    rate_d: Floats,
    imu_to_origin_d: Floats,
    speed_mps: float,
    sigma_mps: float,
) -> Measurement:
    """Return that the body's origin moved forward as the wheels say and in no other direction.

    The paper's position update (Eqs. 20-24, 38) takes the position before as known; over a block
    that is a measurement of the mean velocity.

    Args:
        kf: The filter, at the end of the block.
        mean_vel_n: Mean velocity of the IMU over the block as predicted.
        rate_d: Mean angular rate as measured.
        imu_to_origin_d: From the IMU to the floor half-way between the wheels.
        speed_mps: Mean speed of the wheels, forward positive.
        sigma_mps: Per axis.
    """
    C = to_matrix(kf.q_nd)
    turning_d = np.cross(rate_d - kf.gyro_bias_d, imu_to_origin_d)
    excess_n = C @ (turning_d - (speed_mps, 0.0, 0.0))
    H = np.zeros((3, kf.states))
    H[:, VEL] = np.eye(3)
    H[:, ATT] = -skew(excess_n.tolist())
    H[:, GYRO_BIAS] = C @ skew(imu_to_origin_d.tolist())
    return Measurement(-(mean_vel_n + excess_n), H, np.eye(3) * sigma_mps**2)


def yaw_rate(
    kf: ErrorStateFilter, rate_d: Floats, wheels_radps: float, sigma_radps: float
) -> Measurement:
    """Return the yaw rate of the wheels, ``(E_r - E_l) / D`` (Eq. 18, sign corrected).

    Against the gyroscope's it measures that one's bias, which Eq. 31 does through the heading.
    """
    C = to_matrix(kf.q_nd)
    x, y, z = (C @ (rate_d - kf.gyro_bias_d)).tolist()
    H = np.zeros((1, kf.states))
    H[0, ATT] = (-y, x, 0.0)
    H[0, GYRO_BIAS] = C[2]
    return Measurement(np.array([z - wheels_radps]), H, np.array([[sigma_radps**2]]))


def vertical(kf: ErrorStateFilter, rest_up_d: Floats, sigma_rad: float) -> Measurement:
    """Return that the vertical lies in the walker as it did at rest (Eqs. 12-16)."""
    C = to_matrix(kf.q_nd)
    H = np.zeros((2, kf.states))
    up_n = C @ rest_up_d
    H[:, ATT] = skew(up_n.tolist())[:2]
    return Measurement(up_n[:2], H, np.eye(2) * sigma_rad**2)


def heading(kf: ErrorStateFilter, heading_rad: float, sigma_rad: float) -> Measurement:
    """Return the heading that the wheels carried on (Eqs. 25-31), at a sample."""
    H = np.zeros((1, kf.states))
    H[0, ATT.start + 2] = 1.0
    error = (heading_rad - heading_of(kf.q_nd) + np.pi) % (2.0 * np.pi) - np.pi
    return Measurement(np.array([error]), H, np.array([[sigma_rad**2]]))


def position(kf: ErrorStateFilter, pos_n: Floats, sigma_m: float) -> Measurement:
    """Return where the wheels carried the IMU (Eq. 38, with the block of H at the position)."""
    H = np.zeros((3, kf.states))
    H[:, POS] = np.eye(3)
    return Measurement(pos_n - kf.pos_n, H, np.eye(3) * sigma_m**2)


def height(
    kf: ErrorStateFilter, origin_to_imu_d: Floats, height_m: float, sigma_m: float
) -> Measurement:
    """Return that the body's origin is on the floor (Eq. 11: not the IMU's height but the floor's).

    Args:
        kf: The filter.
        origin_to_imu_d: From the floor half-way between the wheels to the IMU.
        height_m: Of the floor in n.
        sigma_m: Of the height.
    """
    arm_n = to_matrix(kf.q_nd) @ origin_to_imu_d
    H = np.zeros((1, kf.states))
    H[0, POS.start + 2] = 1.0
    H[0, ATT] = skew(arm_n.tolist())[2]
    z = height_m - (kf.pos_n[2] - arm_n[2])
    return Measurement(np.array([z]), H, np.array([[sigma_m**2]]))


def up_d(kf: ErrorStateFilter) -> Floats:
    """Return the vertical in the device's axes, shape (3,)."""
    return np.asarray(to_matrix(kf.q_nd)[2])


def heading_of(q_nd: Iterable[float]) -> float:
    """Return the direction of the forward axis on the floor."""
    C = to_matrix(q_nd)
    return float(np.arctan2(C[1, 0], C[0, 0]))
