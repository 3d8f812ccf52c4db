"""Noise of an inertial sensor as densities, so that a filter's settings hold at any rate."""

from dataclasses import dataclass

import numpy as np

from gaitway.samples import Floats


@dataclass(frozen=True, slots=True)
class ImuNoise:
    """White noise and bias walks of an IMU, as the error-state filter assumes them.

    A filter needs more than the data sheet's noise: what its model leaves out (scale, alignment,
    vibration, bandwidth) has to be in here too, as the white noise that does the same harm over
    one swing.

    Attributes:
        accel_mps2_rthz: Density of the specific force's white noise.
        gyro_radps_rthz: Density of the angular rate's white noise.
        accel_bias_walk_mps2_rts: Standard deviation of the change of an accelerometer bias in 1 s.
        gyro_bias_walk_radps_rts: Standard deviation of the change of a gyroscope bias in 1 s.
    """

    accel_mps2_rthz: float
    gyro_radps_rthz: float
    accel_bias_walk_mps2_rts: float = 0.0
    gyro_bias_walk_radps_rts: float = 0.0

    def scaled(self, factor: float) -> "ImuNoise":
        """Return the same sensor with its white noise ``factor`` times as large."""
        return ImuNoise(
            self.accel_mps2_rthz * factor,
            self.gyro_radps_rthz * factor,
            self.accel_bias_walk_mps2_rts,
            self.gyro_bias_walk_radps_rts,
        )

    def process_covariance(self, dt_s: float, states: int) -> Floats:
        """Return what one sample adds to the error's covariance, shape (states, states).

        The integral of the densities over ``dt_s``; white noise is the same in every axis and so
        needs no rotation. The bias' own walk reaches velocity and attitude through the transition
        of the next samples.

        Args:
            dt_s: Length of the sample.
            states: 9 (biases known) or 15, in the order of ``gaitway.estimation.error_state``.
        """
        accel = self.accel_mps2_rthz**2
        gyro = self.gyro_radps_rthz**2
        of_bias = (self.gyro_bias_walk_radps_rts**2, self.accel_bias_walk_mps2_rts**2)
        blocks = (accel * dt_s**3 / 3, accel * dt_s, gyro * dt_s, *(b * dt_s for b in of_bias))
        Q = np.diag(np.repeat(blocks[: states // 3], 3))
        for axis in range(3):
            Q[axis, 3 + axis] = Q[3 + axis, axis] = accel * dt_s**2 / 2
        return Q
