"""How the pivot moves along a path of the IMU."""

import numpy as np

from gaitway.api import Floats
from gaitway_plugins.ankle.lever import Lever


def pivot_speed_mps(path: Floats, gyro_d: Floats, lever: Lever) -> Floats:
    """Return how fast the pivot moves, ``|v - w x r|``, shape (n,)."""
    return np.asarray(np.linalg.norm(pivot_velocity_n(path, gyro_d, lever), axis=1))


def pivot_velocity_n(path: Floats, gyro_d: Floats, lever: Lever) -> Floats:
    """Return the velocity of the pivot, ``v - w x r``, shape (n, 3)."""
    arm_n = rotated(path[:, 6:10], np.cross(gyro_d, lever.pivot_to_imu_d))
    return np.asarray(path[:, 3:6] - arm_n)


def rotated(q_nd: Floats, vec_d: Floats) -> Floats:
    """Return vectors in frame n, shape (n, 3)."""
    w, axis = q_nd[:, :1], q_nd[:, 1:]
    twice = 2.0 * np.cross(axis, vec_d)
    return np.asarray(vec_d + w * twice + np.cross(axis, twice))
