"""The lever arm: from the point that stands still in stance to the IMU."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from gaitway.api import Floats
from gaitway.estimation.rotation import Vector
from gaitway_plugins.ankle.params import AnkleParams


@dataclass(frozen=True, slots=True)
class Lever:
    """What is known of the paper's ``r``.

    Attributes:
        pivot_to_imu_d: Best estimate, metres.
        sigma_m: Standard deviations along the axes of d.
    """

    pivot_to_imu_d: Vector
    sigma_m: Vector

    @classmethod
    def of(cls, params: AnkleParams, C_db: Floats) -> Self:
        """Return the lever arm as configured, or one that suits most people."""
        if params.lever_arm_m is None:
            across_m = 0.5 * params.assumed_lever_sigma_m
            sigmas = (across_m, across_m, params.assumed_lever_sigma_m)
            return cls((0.0, 0.0, params.assumed_lever_m), sigmas)
        x, y, z = (C_db @ np.array(params.lever_arm_m)).tolist()
        sigma_m = params.lever_arm_sigma_m
        return cls((x, y, z), (sigma_m, sigma_m, sigma_m))

    @property
    def imu_to_pivot_d(self) -> Vector:
        """Return the same the other way round, as ``pivot_velocity`` wants it."""
        x, y, z = self.pivot_to_imu_d
        return (-x, -y, -z)

    def velocity_sigma_mps(self, gyro_d: Vector) -> float:
        """Return how wrong the lever arm makes ``w x r``, per axis."""
        return max(self.sigma_m) * math.hypot(*gyro_d) / math.sqrt(2.0)
