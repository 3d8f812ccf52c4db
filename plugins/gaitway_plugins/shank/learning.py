"""What the shank's estimator learns as it goes: gyroscope bias, gravity, height above the ankle."""

import math
from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import STANDARD_GRAVITY_MPS2
from gaitway.estimation.rotation import Quaternion, Vector, conjugate, rotate
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.rollover import SKIN_WOBBLE_MPS, velocity_gain
from gaitway_plugins.shank.track import Piece, samples

_GRAVITY_READ_SIGMA_MPS2: Final = 0.03
"""Of the mean size of the specific force over a second of swaying."""
_VERTICAL_RATE_SIGMA_RADPS: Final = 0.05
"""How fast a standing person may be turning about the vertical."""
_BIAS_WALK_RADPS_RTS: Final = 2e-4
"""How a consumer gyroscope's bias walks as it warms up: 0.1 deg/s in a minute."""
_OUTLIER_M: Final = 0.25
"""A stance that says so much more or less than what is known is not a usual one."""


class RestLearner:
    """Learns gyroscope bias and gravity while a person stands.

    Nobody stands still: the mean rate is not the bias. But gravity comes back to the same place in
    a frame that the gyroscope carries without error, so what it wanders is the bias.

    Args:
        params: Of the shank.

    Attributes:
        gravity_mps2: What the accelerometer reads at rest.
        gyro_bias_d: Rad/s.
    """

    def __init__(self, params: ShankParams) -> None:
        self.gravity_mps2 = STANDARD_GRAVITY_MPS2
        self.gyro_bias_d: Vector = (0.0, 0.0, 0.0)
        self._params = params
        self._gravity_variance = params.gravity_sigma_mps2**2
        self._bias_variance = np.full(3, params.gyro_bias_sigma_radps**2)

    def learn(self, piece: Piece, q_cd: Quaternion) -> None:
        """Take a second or so of standing.

        Args:
            piece: Its samples.
            q_cd: Attitude in the middle of it.
        """
        p = self._params
        end = samples(0.3 * p.rest_window_s, piece.period_s)
        up_c, down_c = piece.accel_c[:end].mean(axis=0), piece.accel_c[-end:].mean(axis=0)
        size_mps2 = float(np.linalg.norm(piece.accel_c.mean(axis=0)))
        self._learn_gravity(size_mps2)
        apart_s = piece.duration_s - end * piece.period_s
        rate_c = np.cross(up_c, down_c) / (size_mps2**2 * apart_s)
        vertical_c = up_c / size_mps2
        rate_c = rate_c + vertical_c * float(vertical_c @ piece.gyro_c.mean(axis=0))
        tilt_radps = math.sqrt(2.0) * p.rest_tilt_sigma_rad / apart_s
        sigmas = np.array([tilt_radps, tilt_radps, _VERTICAL_RATE_SIGMA_RADPS])
        self._learn_bias(np.array(rotate(conjugate(q_cd), rate_c.tolist())), sigmas, piece)

    def _learn_gravity(self, size_mps2: float) -> None:
        gain = self._gravity_variance / (self._gravity_variance + _GRAVITY_READ_SIGMA_MPS2**2)
        self.gravity_mps2 += gain * (size_mps2 - self.gravity_mps2)
        self._gravity_variance *= 1.0 - gain

    def _learn_bias(self, left_d: Floats, sigmas: Floats, piece: Piece) -> None:
        self._bias_variance += _BIAS_WALK_RADPS_RTS**2 * piece.duration_s
        gain = self._bias_variance / (self._bias_variance + sigmas**2)
        x, y, z = (np.array(self.gyro_bias_d) + gain * left_d).tolist()
        self.gyro_bias_d = (x, y, z)
        self._bias_variance *= 1.0 - gain


class AnkleHeight:
    """Learns how high above the ankle the IMU sits, a stance at a time.

    While the foot is flat the forward velocity changes by the height times the change of the
    rate, whatever the velocity itself is.

    Args:
        params: Of the shank.

    Attributes:
        height_m: Best estimate.
    """

    def __init__(self, params: ShankParams) -> None:
        self.height_m = params.ankle_to_imu_m
        self._stance_sigma_m = params.ankle_to_imu_stride_sigma_m
        self._variance = params.ankle_to_imu_sigma_m**2

    def learn(self, forward_mps: Floats, rate_radps: Floats) -> None:
        """Take the foot-flat part of a stance.

        Args:
            forward_mps: Velocity along the way, up to a constant, shape (k,).
            rate_radps: Rate at which the shank leans forward, shape (k,).
        """
        varied = rate_radps - rate_radps.mean()
        spread = float(varied @ varied)
        if spread == 0.0:
            return
        off_m = float(varied @ forward_mps) / spread - self.height_m
        noise_m = SKIN_WOBBLE_MPS / math.sqrt(spread / len(varied))
        if abs(off_m) > _OUTLIER_M:
            return
        gain = self._variance / (self._variance + self._stance_sigma_m**2 + noise_m**2)
        self.height_m += gain * off_m
        self._variance *= 1.0 - gain


def forward_motion(
    piece: Piece, C_nc: Floats, direction: Floats, closing_mps2: float, gravity_mps2: float
) -> tuple[Floats, Floats]:
    """Return velocity gained along a direction and the rate of leaning that way, shape (k,) each.

    Args:
        piece: The samples.
        C_nc: Levels them.
        direction: Horizontal unit vector, shape (2,).
        closing_mps2: Force per mass along it that the strides to either side found missing: the
            tilt of one roll-over is less certain than that of a whole stride.
        gravity_mps2: What the accelerometer reads at rest.
    """
    gain = velocity_gain(piece.accel_c @ C_nc.T, gravity_mps2, piece.period_s)[:, :2]
    gyro_n = piece.gyro_c @ C_nc.T
    leaning = gyro_n[:, 1] * direction[0] - gyro_n[:, 0] * direction[1]
    return gain @ direction + closing_mps2 * piece.time_s, leaning
