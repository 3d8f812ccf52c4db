"""How the pivot moves along a path of the IMU."""

import numpy as np

from gaitway.api import Floats
from gaitway_plugins.ankle.lever import Lever


def pivot_speed_mps(path: Floats, gyro_d: Floats, lever: Lever) -> Floats:
    """Return how fast the pivot moves, ``|v - w x r|``, shape (n,)."""
    arm_n = rotated(path[:, 6:10], np.cross(gyro_d, lever.pivot_to_imu_d))
    return np.asarray(np.linalg.norm(path[:, 3:6] - arm_n, axis=1))


def rotated(q_nd: Floats, vec_d: Floats) -> Floats:
    """Return vectors in frame n, shape (n, 3)."""
    w, axis = q_nd[:, :1], q_nd[:, 1:]
    twice = 2.0 * np.cross(axis, vec_d)
    return np.asarray(vec_d + w * twice + np.cross(axis, twice))
