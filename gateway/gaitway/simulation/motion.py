"""A rigid device that moves, and what an ideal IMU somewhere on it measures."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from gaitway.samples import Floats
from gaitway.simulation.curves import Curve
from gaitway.simulation.rotation import (
    conjugate,
    from_angles,
    from_matrix,
    from_rotation_vector,
    mean_of_turning,
    multiply,
    positive,
    rate_from_angles,
    rotate,
    to_rotation_vector,
    vector_of_mean,
)

GRAVITY_MPS2: Final = 9.80665
GRAVITY_N: Final = np.array([0.0, 0.0, GRAVITY_MPS2])
"""Specific force of a body at rest, in n."""


@dataclass(frozen=True, slots=True)
class RigidMotion:
    """Where a device is and how it stands, as curves of time.

    Attributes:
        position: Origin of frame d in n, metres, 3 columns.
        angles: Yaw, pitch and roll of d in n, radians, 3 columns (``gaitway.simulation.rotation``).
    """

    position: Curve
    angles: Curve

    def q_nd(self, t_s: Floats) -> Floats:
        """Return the attitude of the device, shape (n, 4)."""
        return from_angles(self.angles(t_s))

    def turning(self, t_s: Floats) -> tuple[Floats, Floats]:
        """Return the attitude, shape (n, 4), and the angular rate in d, rad/s, shape (n, 3)."""
        angles_rad = self.angles(t_s)
        return from_angles(angles_rad), rate_from_angles(angles_rad, self.angles(t_s, 1))

    def point_n(self, t_s: Floats, point_d: Floats) -> Floats:
        """Return where a point of the device is, shape (n, 3)."""
        return self.position(t_s) + rotate(self.q_nd(t_s), point_d)


@dataclass(frozen=True, slots=True)
class ImuPlace:
    """How an IMU sits on a device.

    Attributes:
        device_to_imu_d: From the origin of d to the IMU, metres, shape (3,).
        C_db: Takes components along IMU axes to the device's, shape (3, 3).
    """

    device_to_imu_d: Floats
    C_db: Floats


@dataclass(frozen=True, slots=True, eq=False)
class ImuRun:
    """Angular rate and specific force over consecutive intervals of equal length.

    Both are *interval means* as a sensor with strapdown integration inside reports them: the one
    constant rate and constant specific force which, integrated over the interval, give exactly the
    change of attitude and of velocity that took place (strapdown integration followed by its
    inverse, as the manuals of the Xsens MTi describe their calibrated output). Coning and sculling
    inside an interval are therefore in the numbers and don't depend on the sample rate.

    Attributes:
        period_s: Length of an interval.
        gyro_b: Mean angular rate of each, rad/s, shape (n, 3).
        accel_b: Mean specific force of each, m/s^2, shape (n, 3).
    """

    period_s: float
    gyro_b: Floats
    accel_b: Floats

    def merged(self, count: int) -> "ImuRun":
        """Return the run over intervals ``count`` times as long; ``n`` must be a multiple."""
        gyro = self.gyro_b.reshape(-1, count, 3) * self.period_s
        accel = self.accel_b.reshape(-1, count, 3)
        q = np.tile([1.0, 0.0, 0.0, 0.0], (len(gyro), 1))
        delta_v = np.zeros((len(gyro), 3))
        for part in range(count):
            delta_v += rotate(q, mean_of_turning(gyro[:, part], accel[:, part])) * self.period_s
            q = multiply(q, from_rotation_vector(gyro[:, part]))
        return _from_increments(q, delta_v, self.period_s * count)


def imu_attitude(motion: RigidMotion, place: ImuPlace, t_s: Floats) -> Floats:
    """Return ``q_nb``, the attitude of an IMU, with ``q_w >= 0``, shape (n, 4)."""
    return _imu_turned(motion.q_nd(t_s), place)


def ideal_imu(motion: RigidMotion, place: ImuPlace, t_s: Floats) -> ImuRun:
    """Return what an IMU without error reports between consecutive times.

    Args:
        motion: Of the device.
        place: Of the IMU on it.
        t_s: Ends of the intervals, evenly spaced, shape (n + 1,).
    """
    period_s = float(t_s[-1] - t_s[0]) / (len(t_s) - 1)
    q_nd, rate_d = motion.turning(t_s)
    vel_n = motion.position(t_s, 1) + rotate(q_nd, np.cross(rate_d, place.device_to_imu_d))
    q_nb = _imu_turned(q_nd, place)
    to_start = conjugate(q_nb[:-1])
    delta_v = rotate(to_start, np.diff(vel_n, axis=0) + GRAVITY_N * period_s)
    return _from_increments(multiply(to_start, q_nb[1:]), delta_v, period_s)


def _imu_turned(q_nd: Floats, place: ImuPlace) -> Floats:
    q_db = np.broadcast_to(from_matrix(place.C_db), q_nd.shape)
    return positive(multiply(q_nd, q_db))


def _from_increments(delta_q: Floats, delta_v: Floats, period_s: float) -> ImuRun:
    """Return the constant rate and specific force of increments given in the axes at the start."""
    phi = to_rotation_vector(delta_q)
    return ImuRun(period_s, phi / period_s, vector_of_mean(phi, delta_v) / period_s)
